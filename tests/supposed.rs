//! Where it is not known whether the phases of a run end, as with a speed that is any function: what remains to be shown,
//! and what follows if it is. That this is so is tried with functions whose run is counted here.

mod common;

use common::ran;

const MISSION: &str = "proc BF_{a,b} = MoveTo_a ; MoveTo_b ; BF_{a,b}\n\
    proc MoveTo_g = In_p<r> ; Neq_{r,g} ; Out_{v,s(g-r)} ; MoveTo_g\n\
    proc DEnv_r = (Delay_t # Odo_r # At_r) ; In_v<u> ; DEnv_{r+u*t}\n\
    proc Odo_r = Out_{p,r} ; Odo_r\n\
    system Sys = DEnv_{p0} | BF_{a,b}\n\
    property Goal = Delay_{?t1} ; (Delay_{?t2} # At_a) ; Delay_{?t3} ; Goal\n";

const SYMBOLS: &str = "param t > 0, p0, a, b, a != b, p0 != a\n";

fn told(script: &str) -> (String, bool) {
    let output = ran(script);
    (String::from_utf8_lossy(&output.stdout).into_owned(), output.status.success())
}

#[track_caller]
fn says(told: &str, line: &str) {
    assert!(told.lines().any(|other| other.trim() == line), "not said: {line}\n{told}");
}

#[test]
fn any_speed_goes_n_rounds_and_then_m() {
    let (told, _) = told(&format!("{SYMBOLS}fn s(d)\n{MISSION}period Sys\nprove Sys satisfies Goal\n"));
    for line in [
        "n1 is the least i >= 1 with r1(i) = a, where r1(0) = p0, r1(i+1) = r1(i)+t*s(a-r1(i))",
        "n2 is the least i >= 1 with r2(i) = b, where r2(0) = a, r2(i+1) = r2(i)+t*s(b-r2(i))",
        "n3 is the least i >= 1 with r3(i) = a, where r3(0) = b, r3(i+1) = r3(i)+t*s(a-r3(i))",
        "phase 1 n1 times, then again and again phase 2 n2 times, phase 1 n3 times",
        "lasting: n2*t+n3*t in all, as the system runs from n1*t on",
        "if they do: ?t1 = n1*t, ?t2 = t, ?t3 = n2*t-t",
        "in later rounds ?t1 = n3*t, ?t2 = t, ?t3 = n2*t-t",
    ] {
        says(&told, line);
    }
    assert!(told.contains("could not prove: Sys satisfies Goal") && !told.contains("p0+t*s(a-p0) != a`"), "{told}");
}

/// Rounds until the goal is reached from a start, of a speed of at most so much.
fn rounds(start: i64, goal: i64, most: i64) -> i64 {
    let (mut place, mut rounds) = (start, 0);
    loop {
        place += (goal - place).clamp(-most, most);
        rounds += 1;
        if place == goal {
            return rounds;
        }
    }
}

#[test]
fn what_is_said_is_so_of_speeds_that_are_counted() {
    for (p0, a, b, most) in [(0, 3, -1, 1), (0, 7, 2, 3), (5, -6, 6, 4), (2, 3, 9, 2), (-1, 8, 0, 9)] {
        for t in ["1", "1/2", "3"] {
            let (first, there, back) = (rounds(p0, a, most), rounds(a, b, most), rounds(b, a, most));
            let numbers = format!("param t = {t}, p0 = {p0}, a = {a}, b = {b}\nfn s(d) = clamp(d,-{most},{most})/t\n");
            let expected = format!(
                "expect proved\nexpect t1 = {first}*({t}), t2 = {t}, t3 = {there}*({t})-{t}\n\
                 period Sys\nexpect lasting = ({there}+{back})*({t})\n"
            );
            let (told, met) = told(&format!("{numbers}{MISSION}prove Sys satisfies Goal\n{expected}"));
            assert!(met, "p0 = {p0}, a = {a}, b = {b}, at most {most}, t = {t}\n{told}");
        }
    }
}

#[test]
fn what_would_not_follow_is_not_said() {
    // The robot may pass any place on its way, so when it is first at c is not known even if it arrives.
    let other =
        "param c, c != a, c != b, c != p0\nproperty Other = Delay_{?t1} ; (Delay_{?t2} # At_c) ; Delay_{?t3} ; Other\n";
    let (at_another, _) = told(&format!("{SYMBOLS}fn s(d)\n{MISSION}{other}prove Sys satisfies Other\n"));
    assert!(at_another.contains("could not prove") && !at_another.contains("if they do"), "{at_another}");
    // Where the start may be the goal there is another run.
    let anywhere = "param t > 0, p0, a, b, a != b\n";
    let (from_anywhere, _) = told(&format!("{anywhere}fn s(d)\n{MISSION}prove Sys satisfies Goal\n"));
    assert!(from_anywhere.contains("could not prove") && !from_anywhere.contains("if they do"), "{from_anywhere}");
    // Two places that may be shown in either order are not told in one.
    let never = "property Never = Delay_{?t1} ; (Delay_{2*t} # At_a) ; Delay_{?t3} ; Never\n";
    let (too_long, _) = told(&format!("{SYMBOLS}fn s(d)\n{MISSION}{never}prove Sys satisfies Never\n"));
    assert!(!too_long.contains("if they do"), "{too_long}");
}

#[test]
fn a_mission_that_ends_is_told_with_its_end() {
    let script = "param t > 0, p0, a, p0 != a\nfn s(d)\n\
        proc MoveTo_g = In_p<r> ; Neq_{r,g} ; Out_{v,s(g-r)} ; MoveTo_g\n\
        proc DEnv_r = (Delay_t # Odo_r # At_r) ; (In_v<u> # At_r) ; DEnv_{r+u*t}\n\
        proc Odo_r = Out_{p,r} ; Odo_r\nsystem Sys = DEnv_{p0} | MoveTo_a\n\
        property Goal = Delay_{?t1} ; At_a\nperiod Sys\nprove Sys satisfies Goal\n";
    let (told, _) = told(script);
    says(&told, "phase 1 n1 times, phase 2 once");
    says(&told, "if they do: ?t1 = n1*t");
}

/// A robot that counts its rounds in a first phase at a speed of which nothing is known, in a second where it stands.
const COUNTED: &str = "proc M = M1 ; M2 ; M3\n\
    proc M1 = In_p<r> ; In_q<x> ; Lss_{x,c} ; Out_{v,s(r)} ; Out_{a,w} ; Out_{b,0} ; Out_{e,0} ; M1\n\
    proc M2 = In_p<r> ; In_o<y> ; Lss_{y,c} ; Out_{v,0} ; Out_{a,0} ; Out_{b,w} ; Out_{e,0} ; M2\n\
    proc M3 = In_p<r> ; In_m<z> ; Lss_{z,abs(r)+5} ; Out_{v,0} ; Out_{a,0} ; Out_{b,0} ; Out_{e,1} ; M3\n\
    proc Env_{r,x,y,z} = (Delay_t # Odo_r # Cnt_x # Cny_y # Cnz_z # At_r) ; \
    In_v<u> ; In_a<k> ; In_b<l> ; In_e<h> ; Env_{r+u*t,x+k,y+l,z+h}\n\
    proc Odo_r = Out_{p,r} ; Odo_r\nproc Cnt_x = Out_{q,x} ; Cnt_x\nproc Cny_y = Out_{o,y} ; Cny_y\n\
    proc Cnz_z = Out_{m,z} ; Cnz_z\nsystem Sys = Env_{p0,0,0,0} | M\nperiod Sys\n";

#[test]
fn what_is_so_of_the_rounds_of_one_phase_is_not_known_of_another() {
    let (told_of, _) = told(&format!("param t > 0, w > 0, c > 0, p0\nfn s(d)\n{COUNTED}"));
    says(&told_of, "n1 is the least i >= 1 with i*w >= c, where r1(0) = p0, r1(i+1) = r1(i)+t*s(r1(i))");
    says(&told_of, "phase 1 n1 times, phase 2 ceil(c/w) times, phase 3 ceil(abs(r1(n1)))+5 times, phase 4 once");
    assert!(told_of.contains("after 6*t+n1*t+t*ceil(abs(r1(n1)))+t*ceil(c/w) in all"), "{told_of}");
    // With n1 = 3 and r1(3) = 3.
    let numbers = "param t = 1, w = 1, c = 3, p0 = 0\nfn s(d) = 1\n";
    let (told_of, _) = told(&format!("{numbers}{COUNTED}"));
    assert!(told_of.contains("after 15 in all"), "{told_of}");
}
