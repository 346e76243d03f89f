//! What is said of runs and loops that go on with other values, of legs between numbers, and of conditions with a common factor.

mod common;

use common::ran;

#[track_caller]
fn says(script: &str, lines: &[&str]) {
    let told = String::from_utf8_lossy(&ran(script).stdout).into_owned();
    for line in lines {
        assert!(told.lines().any(|other| other.trim() == *line), "not said: {line}\n{told}");
    }
}

#[test]
fn a_run_that_takes_the_same_ways_for_ever_repeats_though_values_go_on() {
    let script = "observer V(x)\nproc S_k = Out_{c,k} ; Delay_1 ; S_{k+1}\n\
        proc U = In_c<z> ; ((Gtr_{z,3} ; Set_0<w>) | (Lte_{z,3} ; Set_z<w>)) ; (Delay_1 # V_w) ; U\n\
        system Sys = S_0 | U\nperiod Sys\n";
    // At 3 the third value is shown still.
    says(script, &["lasting: 1 in all, as the system runs from 4 on, while k may go on"]);
}

#[test]
fn what_is_left_of_a_value_may_come_again_while_the_value_goes_on() {
    // 2, 6, 18, … leave 0 by 2, and 3, -6, 12, … leave 0 by 3: they are others each time all the same.
    let rest = "proc Q_k = (Eq_{mod(k,2),0} ; (Delay_1 # A_k) ; Q_{3*k})\nsystem Sys = Q_2\nperiod Sys\n";
    says(&format!("observer A(x)\n{rest}"), &["lasting: 1 in all, as the system runs, while k may go on"]);
    let turned = "proc P_k = (Delay_{1+mod(k,3)} # A_k) ; P_{-2*k}\nsystem Sys = P_3\nperiod Sys\n";
    says(&format!("observer A(x)\n{turned}"), &["lasting: 1 in all, as the system runs from 1 on, while k may go on"]);
    let two = "proc P_{k,j} = (Delay_{1+mod(j,2)} # A_j) ; P_{2*k,j+k}\nsystem Sys = P_{5,0}\nperiod Sys\n";
    says(&format!("observer A(x)\n{two}"), &["lasting: 2 in all, as the system runs from 3 on, while j, k may go on"]);
    let least = "proc P_k = (Neq_{mod(k,3),0} ; (Delay_1 # A_k) ; P_{2*k-1}) | (Eq_{mod(k,3),0} ; (Delay_2 # A_k) ; P_{2*k})\n\
        system Sys = P_4\nperiod Sys\n";
    says(&format!("observer A(x)\n{least}"), &["lasting: 1 in all, as the system runs, while k may go on"]);
}

#[test]
fn a_leg_between_numbers_is_said_to_lead_from_one_to_the_other() {
    let script = "proc W_x = (Delay_1 # Odo_x # At_x) ; In_v<u> ; W_{x+u}\nproc Odo_x = Out_{p,x} ; Odo_x\n\
        proc Go_g = In_p<r> ; Neq_{r,g} ; Out_{v,g-r} ; Go_g\nproc M = Go_7 ; Go_0 ; M\n\
        system Sys = W_0 | M\nflow Sys\n";
    says(script, &["flow      x from 0 to 7", "flow      x from 7 to 0"]);
}

#[test]
fn a_condition_with_a_common_factor_is_two() {
    let script = "param K, r\nsolve x(n+1) = K*r*x(n) + K^n, x(0) = 1\nsolve x(n+1) = K*x(n) + (K*r)^n, x(0) = 1\n";
    says(script, &["if K != 0", "if r != 1", "where r = 1:"]);
    let told = String::from_utf8_lossy(&ran(script).stdout).into_owned();
    assert!(!told.contains("!= K") && !told.contains("1 != r"), "{told}");
}

#[test]
fn a_loop_in_no_time_is_told_of_with_what_changes_each_time() {
    let echo = "proc Q = In_a<x> ; Out_{b,x} ; Q\n";
    let of = |program: &str, start: &str| format!("{echo}proc {program}\nsystem Sys = {start} | Q\nperiod Sys\n");
    let plain = of("P_{k,s} = Out_{a,k} ; In_b<y> ; P_{k+1,s+2*y}", "P_{0,1}");
    says(&plain, &["no period: P and Q go round in no time, each time with k+1 for k and 2*k+s for s"]);
    let late = of("P_k = Out_{a,k} ; In_b<y> ; ((Lss_{k,3} ; Delay_1) | Gte_{k,3}) ; P_{k+1}", "P_0");
    says(&late, &["warning: P and Q go round in no time if k+1 >= 3, each time with k+1 for k"]);
    // What ends it is told of; what divides by 0 on the way does not go on.
    let ends = of("P_k = Out_{a,k} ; In_b<y> ; Lss_{k,1000000} ; P_{k+1}", "P_0");
    says(&ends, &["no period found: P and Q go round in no time until k >= 1000000, for longer than is followed"]);
    let divides = of("P_k = Out_{a,1/(k-40)} ; In_b<y> ; P_{k+1}", "P_0");
    let told = String::from_utf8_lossy(&ran(&divides).stdout).into_owned();
    assert!(!told.contains("in no time"), "{told}");
}

/// The values with which a phase begins that goes round are said where it is entered.
#[test]
fn a_phase_that_is_entered_tells_its_values() {
    let script = "proc A = (In_c<x> | In_d<y>) ; Out_{e,x+y} ; A\nproc C_k = Delay_1 ; Out_{c,k} ; C_{1-k}\n\
        proc D_k = Delay_2 ; Out_{d,k} ; D_{2*k}\nproc E = In_e<s> ; Delay_1 ; E\n\
        system Sys = A | C_0 | D_1 | E\nflow Sys\n";
    says(script, &["then      to phase 2 with k = 0, k2 = 2, x = 1", "flow      f(k,k2,x) = (1-k, 2*k2, k)"]);
}

/// What holds in every order may be several rounds in one of them, which is said.
#[test]
fn fewer_rounds_in_some_order_are_said() {
    let script = "param w > 0, ch > 0\nproc R1 = Delay_ch ; Out_{b,1} ; Delay_w ; In_a<x> ; R1\n\
        proc R2 = Delay_w ; In_b<x> ; Delay_ch ; Out_{c,x} ; R2\nproc R3 = Delay_w ; In_c<x> ; Delay_ch ; Out_{a,x} ; R3\n\
        system Sys = R1 | R2 | R3\nperiod Sys\n";
    says(script, &["lasting: 3*ch", "in some order fewer rounds come again, as is told there"]);
}
