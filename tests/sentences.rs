//! What is said where something is not known, ends, or is too long to read.

use std::process::{Command, Output};

fn pars(command: &str, script: &str) -> Output {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("mission.pars"), script).expect("written");
    let program = env!("CARGO_BIN_EXE_pars");
    Command::new(program).args([command, "mission.pars"]).current_dir(folder.path()).output().expect("it runs")
}

fn told(script: &str) -> String {
    String::from_utf8_lossy(&pars("run", script).stdout).into_owned()
}

const WORLD: &str = "observer At(r), Done\nproc World_r = (Delay_1 # Look_r # At_r) ; In_w<u> ; World_{r+u}\n\
    proc Look_r = Out_{l,r} ; Look_r\nproc Go_g = In_l<r> ; Neq_{r,g} ; Out_{w,g-r} ; Go_g\n";

#[test]
fn an_assumption_that_is_named_tells() {
    let mission = "system Sys = World_0 | (((Gtr_{k,0} ; Go_2 ; Go_0) | (Lte_{k,0} ; Go_2)) ; Done)\n\
        property P = Delay_{?s} ; Done\nprove Sys satisfies P\n";
    // Without one it is told by what is not known.
    let proved = told(&format!("{WORLD}param k > -5\n{mission}"));
    assert!(proved.contains("proved: Sys satisfies P") && proved.contains("?s = if k > 0 then 2 else 1"), "{proved}");
    assert!(!proved.contains("on trust"), "{proved}");
    let proved = told(&format!("{WORLD}param k > 0\n{mission}"));
    assert!(proved.contains("proved: Sys satisfies P") && proved.contains("with ?s = 2"), "{proved}");
    assert!(!proved.contains("on trust"), "{proved}");
    // Where what is found is the same in both cases no assumption is needed.
    let mission = "system Sys = World_0 | ((Go_2 ; Go_0)^k ; Done)\nproperty P = Delay_{?s} ; Done\n\
        prove Sys satisfies P\n";
    let proved = told(&format!("{WORLD}param k : natural\n{mission}"));
    assert!(proved.contains("proved: Sys satisfies P") && proved.contains("with ?s = 2*k"), "{proved}");
    assert!(!proved.contains("on trust"), "{proved}");
}

#[test]
fn a_run_that_ends_has_no_period_at_the_shell_either() {
    let script = |goals: &str| format!("{WORLD}proc Mission = {goals}\nsystem Sys = World_0 | Mission\n");
    let count = "proc Count_n = Gtr_{n,0} ; Delay_1 ; Count_{n-1}\nsystem Sys = Count_3\n";
    let ended = pars("period", count);
    let text = String::from_utf8_lossy(&ended.stdout).into_owned();
    assert_eq!((ended.status.code(), text.contains("no period: the run ends")), (Some(1), true), "{text}");
    assert_eq!(pars("period", &script("Go_2 ; Go_0 ; Mission")).status.code(), Some(0));
    assert_eq!(pars("period", &script("Go_2 ; Go_0")).status.code(), Some(1));
}

#[test]
fn nothing_stands_between_commas_or_at_an_end() {
    let script = "observer T(x)\nproc Src = Out_{a,0} ; In_b<z> ; (Delay_1 # T_z) ; Src\n\
        proc N = In_a<x> ; (Delay_1 # T_x) ; Out_{b,x+7} ; N\nsystem S = Src | N\nprove S always x <= 7 when T_x\n";
    let told = told(script);
    assert!(told.contains("T is sensed, and nothing else that is shown moves by what is read"), "{told}");
    assert!(told.lines().all(|line| !line.ends_with("moves ")), "{told}");
}

#[test]
fn long_vectors_are_rounded_where_they_are_read() {
    let script = "observer At(r)\nproc World_r = (Delay_1 # Look_r # At_r) ; In_w<u> ; World_{r+u}\n\
        proc Look_r = Out_{l,r} ; Look_r\nproc Go_g = In_l<r> ; Gtr_{norm(g-r),1/10} ; Out_{w,(g-r)/20} ; Go_g\n\
        proc Tour = Go_{(10,2)} ; Go_{(0,0)} ; Tour\nsystem Sys = World_{(0,0)} | Tour\n\
        criteria C for Sys { goals At_{(10,2)}, At_{(0,0)} radius 1/5 round within 16 }\n";
    let told = told(script);
    let line = told.lines().find(|line| line.contains("commanded by Tour on port w")).expect("who commanded");
    assert!(line.contains("(rounded)") && line.len() < 120, "{line}");
}

#[test]
fn a_speed_that_hits_the_goal_is_the_nearest_one() {
    let mission =
        "param v = 1\nproc On_g = In_l<r> ; Neq_{r,g} ; Out_{w,v} ; On_g\nsystem Sys = World_0 | (On_6 ; Done)\n";
    let late = told(&format!("{WORLD}{mission}criteria C for Sys {{ goals At_6 leg within 5 }}\n"));
    assert!(late.contains("try: leg1: v = 6/5 in place of 1 gives leg1 = 5"), "{late}");
}

#[test]
fn what_comes_then_is_said_of_a_direction_that_there_is_none_of() {
    let script = "observer At(r)\nproc World_r = (Delay_1 # Look_r # At_r) ; In_w<u> ; World_{r+u}\n\
        proc Look_r = Out_{l,r} ; Look_r\nproc Go_g = In_l<r> ; Out_{w,unit(g-r)} ; Go_g\n\
        system Sys = World_{(0,0)} | Go_{(3,4)}\ncriteria C for Sys { goals At_{(3,4)} leg within 5 }\n";
    let told = told(script);
    assert!(told.contains("divides by zero (as `unit` of a vector of length 0 does)"), "{told}");
}

#[test]
fn a_duration_that_cannot_be_less_than_0_is_not_said_to_count_as_0() {
    let asked = |drawn: &str| {
        let script = format!("observer Done\nproc P = Ran_{{{drawn}}}<x> ; Delay_x ; Done\nsystem S = P\n");
        told(&format!("{script}probability of S reaching Done within 2\n"))
    };
    assert!(!asked("Exp(rate: 1)").contains("counts as 0"));
    assert!(asked("Normal(1, sd: 1)").contains("counts as 0"));
}

#[test]
fn many_parts_without_a_port_are_not_all_named() {
    let parts: Vec<String> = (0..20).map(|n| format!("proc Part{n} = Delay_1 ; Part{n}\n")).collect();
    let names: Vec<String> = (0..20).map(|n| format!("Part{n}")).collect();
    let told = told(&format!("{}system S = {}\nperiod S\n", parts.concat(), names.join(" | ")));
    assert!(told.contains("Part5 and 14 more share no port"), "{told}");
}

#[test]
fn values_of_a_long_chain_change_one_after_the_other() {
    // Sixty that follow one another: more than are looked at one by one.
    let mut script = "observer Last(x)\nproc Lead_x = (Delay_1 # Tell0_x) ; Lead_{x+1}\n\
        proc Tell0_x = Out_{p0,x} ; Tell0_x\nproc End_x = In_p60<y> ; (Delay_1 # Last_x) ; End_y\n"
        .to_string();
    let mut parts = vec!["Lead_0".to_string(), "End_0".to_string()];
    for n in 1..=60 {
        let before = n - 1;
        script.push_str(&format!(
            "proc Link{n}_x = In_p{before}<y> ; (Delay_1 # Tell{n}_x) ; Link{n}_y\nproc Tell{n}_x = Out_{{p{n},x}} ; Tell{n}_x\n"
        ));
        parts.push(format!("Link{n}_0"));
    }
    script.push_str(&format!("system Chain = {}\nperiod Chain\nexpect yes\nexpect lasting = 1\n", parts.join(" | ")));
    let found = pars("run", &script);
    let text = String::from_utf8_lossy(&found.stdout).into_owned();
    assert_eq!(found.status.code(), Some(0), "{text}");
}

/// The paper's mission, its `s` and its places left open.
const PAPER: &str = "param t > 0, a, b, p0, a != b, p0 != a\nfn s(d)\nobserver At(r)\n\
    proc BF_{a,b} = MoveTo_a ; MoveTo_b ; BF_{a,b}\nproc MoveTo_g = In_p<r> ; Neq_{r,g} ; Out_{v,s(g-r)} ; MoveTo_g\n\
    proc DEnv_r = (Delay_t # Odo_r # At_r) ; In_v<u> ; DEnv_{r+u*t}\nproc Odo_r = Out_{p,r} ; Odo_r\n\
    system Sys = DEnv_{p0} | BF_{a,b}\nperiod Sys\n";

#[test]
fn the_phases_of_the_paper_are_checked_with_its_function_open() {
    let told = told(PAPER);
    assert!(told.contains("by the kernel: all 5 ways from start and phases"), "{told}");
}

#[test]
fn a_name_elsewhere_in_the_file_takes_nothing_from_a_proof() {
    let mission = "observer At(r)\nproc BF_{a,b} = MoveTo_a ; MoveTo_b ; BF_{a,b}\n\
        proc MoveTo_g = In_p<r> ; Gtr_{abs(r-g),1/10} ; Out_{v,(g-r)/2} ; MoveTo_g\n\
        proc DEnv_r = (Delay_1 # Odo_r # At_r) ; In_v<u> ; DEnv_{r+u}\nproc Odo_r = Out_{p,r} ; Odo_r\n\
        proc Gauge = In_level<x> ; Delay_1 ; Gauge\nsystem Sys = DEnv_0 | BF_{10,0}\n\
        property Goal = Delay_{?t1} ; (Delay_{?t2} # At_{?y}) ; Lte_{abs(?y-10),1/10} ; Delay_{?t3} ; Goal\n\
        prove Sys satisfies Goal\n";
    let told = told(mission);
    assert!(told.contains("proved: Sys satisfies Goal") && !told.contains("on trust"), "{told}");
}

#[test]
fn one_component_that_competes_with_itself_is_named_once() {
    let told = told(
        "observer Lit(z)\nproc Either = (Out_{h,1} | Out_{h,2}) ; Delay_1 ; Either\n\
        proc Keeps = In_h<x> ; In_h<y> ; (Delay_1 # Lit_x) ; Keeps\nsystem Race = Either | Keeps\nperiod Race\n",
    );
    assert!(told.contains("two parts of Either compete for one communication on port h"), "{told}");
}

#[test]
fn a_robot_that_stays_at_its_goal_is_said_to_stay() {
    let mission = "system Sys = World_1 | Stays\nproc Stays = In_l<r> ; Out_{w,0} ; Stays\n";
    let told = told(&format!("{WORLD}{mission}criteria C for Sys {{ goals At_1 every leg within 3 }}\n"));
    assert!(told.contains("it stays at At_1"), "{told}");
}

#[test]
fn a_goal_of_another_sort_is_told_from_what_is_shown() {
    let mission = "system Sys = World_0 | Go_2\n";
    let told = told(&format!("{WORLD}{mission}criteria C for Sys {{ goals At_{{(2,0)}} leg within 3 }}\n"));
    assert!(told.contains("At shows a number, and (2,0) in the goal At_{(2,0)} is a vector of 2"), "{told}");
}

/// Robots in a row: each looks at its own place and at that of the one before it, and comes nearer by a third.
fn followers(count: usize) -> String {
    let mut text = String::from("observer At(i, r)\n");
    let mut all = Vec::new();
    for number in 0..count {
        let other = if number == 0 { "Set_100<q>".to_string() } else { format!("In_p{}<q>", number - 1) };
        text.push_str(&format!(
            "proc World{number}_r = (Delay_1 # Odo{number}_r # At_{{{number},r}}) ; In_v{number}<u> ; World{number}_{{r+u}}\n\
             proc Odo{number}_r = Out_{{p{number},r}} ; Odo{number}_r\n\
             proc Base{number} = In_p{number}<r> ; {other} ; Out_{{v{number},(q-r)/3}} ; Base{number}\n"
        ));
        all.push(format!("World{number}_{{-{number}}} | Base{number}"));
    }
    format!("{text}system Sys = {}\nperiod Sys\n", all.join(" | "))
}

#[test]
fn looks_at_one_place_by_many_are_not_put_in_order() {
    for count in [3, 9, 20] {
        let told = told(&followers(count));
        assert!(told.contains("by the kernel: all 2 ways"), "{count}: {told}");
    }
}

#[test]
fn what_is_sensed_is_told_from_what_is_not() {
    let robot = |beam: &str, rock: &str| {
        told(&format!(
            "observer Rock(x)\nproc Env_r = (Delay_1 # Beam_{{{beam}}} # At_r # Rock_{{{rock}}}) ; In_v<u> ; Env_{{r+u}}\n\
             proc Beam_d = Out_{{f,d}} ; Beam_d\n\
             proc C = In_f<d> ; ((Gtr_{{d,2}} ; Out_{{v,1}}) | (Lte_{{d,2}} ; Out_{{v,0}})) ; C\n\
             system S = Env_0 | C\nprove S always abs(o-p) > 1 when At_p, Rock_o\n"
        ))
    };
    let sensed = "connected: Rock (Env) -f-> C -v-> At (Env)";
    for beam in ["30-r", "(30-r)/2", "abs(30-r)", "if 30-r < 3 then 0 else 9"] {
        let told = robot(beam, "30");
        assert!(told.contains(sensed), "{beam}: {told}");
    }
    // A rock behind the robot is not seen by a beam that looks ahead, wherever it is.
    for rock in ["-7", "-30"] {
        let told = robot("30-r", rock);
        assert!(told.contains("no port carries what Rock shows") && !told.contains(sensed), "{rock}: {told}");
    }
}

#[test]
fn moments_are_told_in_the_names_of_the_program() {
    let told = told(
        "proc E_{r,q} = (Delay_1 # O_q # At_r) ; (Ran_{Normal(0, sd: 1/10)}<e> | In_v<u>) ; E_{r+u+e,q+u}\n\
         proc O_q = Out_{p,q} ; O_q\nproc K = In_p<m> ; Out_{v,(5-m)/2} ; K\nsystem F = E_{0,0} | K\n\
         probability of F showing At_r where r >= 5 at 6\n",
    );
    assert!(told.contains("mean_q(n) = 5-5*(1/2)^n") && told.contains("covariance_r_q(n) = 0"), "{told}");
}

#[test]
fn a_logarithm_is_told_as_it_is_meant() {
    let start =
        "param g, p0, h, k, 0 < k, k < 1, e > 0, p0 < h, h < g\nsolve r(n+1) = r(n)+k*(g-r(n)), r(0) = p0 find n with";
    // With g = 10, p0 = 2, k = 1/2, e = 1 the first is 3: log((1)/8)/log(1/2).
    let near = told(&format!("{start} abs(r(n)-g) <= e\n"));
    assert!(near.contains("(g-p0)*(1-k)^n <= e") && near.contains("ceil(log(e/(g-p0))/log(1-k))"), "{near}");
    // With D = 10, c = 3, d = 1 it is 0: the other side counts as well, in a case of its own.
    let far = told("param D > 0, c, d > 0, c > d\nsolve r(n+1) = r(n)/2, r(0) = D find n with abs(r(n)-c) >= d\n");
    let (above, below) = far.split_once("if D < c+d:").unwrap_or_default();
    assert!(above.contains("if D >= c+d:\n      n = 0 is the first") && !above.contains("log("), "{far}");
    assert!(below.contains("ceil(log((c-d)/D)/log(1/2))"), "{far}");
    let past = told(&format!("{start} r(n) >= h\n"));
    assert!(past.contains("ceil(log((g-h)/(g-p0))/log(1-k))") && !past.contains("not known whether ever"), "{past}");
}

#[test]
fn what_an_operator_is_told_of_chances_and_of_what_does_not_matter() {
    let told = told(
        "observer Done\nparam sigma = 1/2, speed = 1, bat = 20\nproc Env_x = (Delay_1 # Od_x # At_x) ; (In_m<u> | Ran_{Normal(0, sd: sigma)}<e>) ; Env_{x+u+e}\n\
         proc Od_x = Out_{p,x} ; Od_x\nproc Go_g = In_p<x> ; Lss_{x,g} ; Out_{m,speed} ; Go_g\nsystem S = Env_0 | (Go_6 ; Done)\n\
         criteria Arrival for S { probability of reaching Done within 6 >= 9/10 battery bat rate 1 for 5 keep 5 }\n",
    );
    assert!(told.contains("in phase 1 of 2 (Env, component 2: Go) are 100 % of the runs that miss it"), "{told}");
    assert!(told.contains("margins that such a change does not move: ") && told.contains("battery by speed"), "{told}");
}

#[test]
fn how_closely_a_circle_is_enclosed_is_said() {
    let told = told(
        "proc W_r = (Delay_1 # O_r # At_r) ; In_v<u> ; W_{r+u}\nproc O_r = Out_{p,r} ; O_r\n\
         proc Hover = In_p<m> ; Ran_{Uniform(-1/10,1/10)}<a> ; Ran_{Uniform(-1/10,1/10)}<b> ; Out_{v,(a,b)-m/2} ; Hover\n\
         system S = W_{(0,0)} | Hover\nprove S always norm(x) < 3/10 when At_x\n",
    );
    assert!(told.contains("circles are enclosed by 20 half planes, which tell a length to within 1.4 %"), "{told}");
}

const SLOW: &str = "param a = 4, b = 1/4\n\
    proc World_r = (Delay_1 # At_r # Look_r) ; In_v<u> ; World_{r+u}\nproc Look_r = Out_{p,r} ; Look_r\n\
    proc Go = In_p<r> ; ((Lss_{r,8} ; Out_{v,a}) | (Gte_{r,8} ; Lss_{r,12} ; Out_{v,b}) | (Gte_{r,12} ; Lss_{r,20} ; \
    Out_{v,4})) ; Go\nsystem Sys = World_0 | Go\n\
    criteria Job for Sys { goals At_20 leg within 15 }\ncriteria Both for Sys { goals At_12, At_20 round within 15 }\n";

#[test]
fn a_late_leg_is_blamed_on_the_phase_that_takes_most_of_it() {
    let told = told(SLOW);
    assert!(told.contains("in phase 2 of 3, for 16 of 20: Go at Out_{v,1/4} ; Go"), "{told}");
    assert!(told.contains("commanded by Go on port v: 1/4 at 18"), "{told}");
    // Of a round, the longest leg.
    assert!(told.contains("in phase 2 of 3, for 16 of 18"), "{told}");
    // The goal is met exactly or not at all: of the changes with which it is, the nearest in time.
    assert!(told.contains("try: leg1: a = 37/8 in place of 4 gives leg1 = 15"), "{told}");
}

#[test]
fn why_no_time_in_all_is_known_is_said() {
    let rare = "proc Pause_{x,y} = (Eq_{x,y} ; Delay_2 ; Pause_{x+1,2*y} | Neq_{x,y} ; Delay_1 ; Pause_{x+1,y})\n\
        system Sys = Pause_{0,1}\nperiod Sys\n";
    let told_of = told(rare);
    assert!(told_of.contains("whether it all repeats is not known: it was followed through"), "{told_of}");
    let counted = "param n : natural, n >= 1\nproc Beat = (Delay_2 ; Out_{h,1})^n ; Delay_3 ; Beat\n\
        proc Hear = In_h<x> ; Hear\nsystem Sys = Beat | Hear\nperiod Sys\n";
    let told_of = told(counted);
    assert!(told_of.contains("lasting: 2*n+3 in all"), "{told_of}");
    let less = "param n : natural, n >= 1\nproc P = (Delay_{n-1} | Delay_{1/2}) ; P\nsystem Sys = P\nperiod Sys\n";
    let told_of = told(less);
    assert!(told_of.contains("if n > 1: lasting: n-1 in all"), "{told_of}");
    assert!(told_of.contains("if n = 1: lasting: 1/2 = 0.5 in all"), "{told_of}");
}

#[test]
fn too_many_terms_are_not_said_to_have_symbols() {
    let next = |place: usize| format!("x{place}(n+1) = x{place}(n)/2+x{}(n)/4", (place + 1) % 65);
    let equations: Vec<String> =
        (0..65).map(next).chain((0..65).map(|place| format!("x{place}(0) = {place}"))).collect();
    let told = told(&format!("solve {}\n", equations.join(", ")));
    assert!(told.contains("65 terms depend on each other: too many"), "{told}");
}

#[test]
fn the_flow_of_a_clamped_robot_has_a_form_for_each_order() {
    let robot = "proc World_r = (Delay_1 # Look_r) ; In_v<u> ; World_{r+u}\nproc Look_r = Out_{p,r} ; Look_r\n\
        proc Go_g = In_p<r> ; Neq_{r,g} ; Out_{v,clamp(g-r,-1/2,1/2)} ; Go_g\nproc Tour = Go_3 ; Go_0 ; Tour\n\
        system Sys = World_0 | Tour\nflow Sys\n";
    let told = told(robot);
    assert!(told.contains("flow      f(r) = clamp(3-r,-1/2,1/2)+r"), "{told}");
    assert!(told.contains("closed    if r0 < 3:\n"), "{told}");
    assert!(told.contains("r(n) = 1/2*n+r0 for n < 6-floor(2*r0)\n"), "{told}");
}

#[test]
fn a_closed_form_calls_nothing_as_something_else_is_called() {
    let flow = |text: &str| {
        let told = told(&format!("observer At(r)\n{text}flow Sys\n"));
        let line = |word: &str| told.lines().find(|line| line.trim_start().starts_with(word)).map(str::trim);
        (line("closed").unwrap_or_default().to_string(), line("mean").unwrap_or_default().to_string())
    };
    let world = |next: &str, start: &str| {
        format!("proc World_r = (Delay_1 # At_r) ; World_{{{next}}}\nsystem Sys = World_{start}\n")
    };
    // A step is no start, and no number of rounds.
    assert_eq!(flow(&format!("param r0\n{}", world("r+r0", "3"))).0, "closed    r = rstart+n*r0 from n = 0");
    assert_eq!(flow(&format!("param r0\n{}", world("r+r0", "r0"))).0, "closed    r = r0+n*r0 from n = 0");
    assert_eq!(flow(&format!("param n, v\n{}", world("r+n+v", "3"))).0, "closed    r = r0+k*n+k*v from k = 0");
    // What is assumed of a parameter is not assumed of a start that is called so.
    let clamped = flow(&format!("param r0 > 0\n{}", world("r+clamp(-r,-1,1)", "{-3}")));
    assert!(clamped.0.starts_with("closed    if rstart <"), "{clamped:?}");
    let drawn = "param m, r0\nproc World_r = (Delay_1 # At_r) ; Ran_{Normal(r0/2+m, sd: 1)}<e> ; World_{r/2+e}\nsystem Sys = World_3\n";
    assert_eq!(flow(drawn).1, "mean      r = 2*m+r0+(1/2)^n*(rstart-2*m-r0) from n = 0");
    // The place from which a robot comes back is no start of the leg that leads there.
    let back = "param r0, g\nfn s(d) = d/2\nproc World_r = (Delay_1 # At_r # Look_r) ; In_w<u> ; World_{r+u}\nproc Look_r = Out_{p,r} ; Look_r\n\
        proc Go_a = In_p<r> ; Gtr_{|a-r|,1/10} ; Out_{w,s(a-r)} ; Go_a\nproc Patrol = Go_g ; Go_r0 ; Patrol\nsystem Sys = World_r0 | Patrol\n";
    let told = told(&format!("observer At(r)\n{back}flow Sys\n"));
    assert!(told.contains("closed    r = r0+(1/2)^n*(rstart-r0) from n = 0"), "{told}");
}

#[test]
fn a_gain_of_one_and_a_value_of_nothing_are_tried() {
    let mission = |parameters: &str, go: &str, goals: &str, asked: &str| {
        told(&format!(
            "{WORLD}{parameters}proc Go2_a = In_l<r> ; {go} ; Go2_a\nsystem Sys = World_0 | ({goals} ; Done)\ncriteria C for Sys {{ {asked} }}\n"
        ))
    };
    let gain =
        mission("param k = 4/5, d = 12\n", "Gtr_{|r-a|,1/5} ; Out_{w,(a-r)*k}", "Go2_d", "goals Done leg within 1");
    assert!(gain.contains("k = 59/60 in place of 4/5"), "{gain}");
    let back =
        mission("param b = 1\n", "Neq_{r,a} ; Out_{w,clamp(a-r,-1,1)}", "Go2_9 ; Go2_{-b}", "goals Done leg within 18");
    assert!(back.contains("b = 0 in place of 1"), "{back}");
}

#[test]
fn what_is_divided_by_may_be_nothing_in_one_case() {
    let start = "x(0) = (if c < 3 then 0 else 2), y(0) = 0\n";
    for next in ["(n+1)*x(n)", "2*x(n)", "x(n)"] {
        let told = told(&format!("param c\nsolve x(n+1) = {next}, y(n+1) = y(n)+1/x(n), {start}"));
        assert!(told.contains("if (if c < 3 then 0 else 2) != 0"), "{told}");
    }
    // Neither is it a value where a process is given it, or reads it.
    let shown = "proc World_r = (Delay_1 # At_{1/r}) ; World_r\nsystem Sys = World_{if c < 3 then 0 else 2}\n";
    let told_of = told(&format!("param c\nobserver At(x)\n{shown}prove Sys always x = 1/2 when At_x\n"));
    assert!(told_of.contains("could not prove") && told_of.contains("division by 0 where 3-c > 0"), "{told_of}");
    for next in ["f(if c < 3 then 0 else 2)", "(if c < 3 then 0 else 2)^(-1)", "mod(5,if c < 3 then 0 else 2)"] {
        let text = format!("param c\nfn f(d) = 1/d\nsolve y(n+1) = y(n)+{next}, y(0) = 0\n");
        let said = String::from_utf8_lossy(&pars("run", &text).stderr).into_owned();
        assert!(said.contains("P0402") && said.contains("division by 0 where 3-c > 0"), "{next}: {said}");
    }
    // A product is never 0, so there is nothing to suppose.
    let product =
        "solve x(n+1) = (n+1)*x(n), a(n+1) = a(n)+1, y(n+1) = y(n)+1/(a(n)*x(n)), x(0) = 1, y(0) = 0, a(0) = 1\n";
    assert!(!told(product).contains("!= 0"));
}

#[test]
fn an_index_is_said_with_what_its_form_needs() {
    // Where no round adds anything it is never met: the case that the form leaves out has an answer of its own.
    let text = "param a : natural\nsolve r(n+1) = if n < a then r(n)+2 else r(n)-1, r(0) = 0 find n with r(n) > 0\n";
    let told = told(text);
    assert!(told.contains("n = 1 is the first with r(n) > 0\n    if a > 0"), "{told}");
    let own = told.split("where a = 0:").nth(1).unwrap_or_default();
    assert!(own.contains("never r(n) > 0: it moves away"), "{told}");
}

#[test]
fn a_repair_that_breaks_nothing_is_looked_for_beyond_one_that_does() {
    let told = told(&std::fs::read_to_string("tests/cases/operator/beyond_a_harmful_repair.pars").expect("a file"));
    let repairs: Vec<&str> = told.lines().filter(|line| line.contains("try: leg1: v = ")).collect();
    assert!(repairs.first().is_some_and(|line| line.contains("v = 10/3") && !line.contains("not met")), "{told}");
    assert_eq!(repairs.iter().collect::<std::collections::BTreeSet<_>>().len(), repairs.len(), "{told}");
    assert!(told.contains("a run comes so near at 9: At_9, Rock_9"), "{told}");
}

#[test]
fn a_goal_that_is_missed_beside_a_value_is_said_to_be() {
    let text = "param h = 1\nproc World_r = (Delay_1 # Odo_r # At_r) ; In_m<u> ; World_{r+u}\n\
                proc Odo_r = Out_{g,r} ; Odo_r\nproc Go_q = In_g<r> ; Neq_{r,q} ; Out_{m,h} ; Go_q\n\
                proc Stay = Out_{m,0} ; Stay\nsystem Sys = World_0 | (Go_6 ; Stay)\n\
                criteria Trip for Sys { goals At_6 leg within 8 }\n";
    let told = told(text);
    assert!(told.contains("margin of leg1 by h: with +1 % it is not met, with -1 % it is not met"), "{told}");
}

#[test]
fn a_delay_that_may_be_nothing_is_asked_once_in_a_round_and_runs_where_it_is_entered() {
    let twice =
        "param w >= 0\nproc Twice = Delay_1 ; Delay_w ; Delay_2 ; Delay_w ; Twice\nsystem Sys = Twice\nperiod Sys\n";
    let twice = told(twice);
    assert!(twice.contains("lasting 2*w+3 if w > 0:") && !twice.contains("w > 0 and w > 0"), "{twice}");
    // The phase in which it runs is entered only where there is something left of it, and the kernel is told so.
    let first = told("param w >= 0\nproc First = Delay_w ; Delay_1 ; First\nsystem Sys = First\nperiod Sys\n");
    assert!(first.contains("start -> phase 1 if w > 0") && first.contains("by the kernel: all 5 ways"), "{first}");
}

#[test]
fn drift_is_told_of_the_parts_that_never_agree_and_of_natural_ratios() {
    let parts = "observer X, Y, Z\nparam t > 0, s > 0, m : natural, m >= 1\nproc A = (Delay_t # X) ; A\n\
        proc B = (Delay_s # Y) ; B\nproc C = (Delay_{sqrt(3)*t} # Z) ; C\nproc D = (Delay_{m*t} # Y) ; D\n";
    let never = told(&format!("{parts}system S = A | B | C\nperiod S\n"));
    assert!(never.contains("no period: A goes round in t and C in t*sqrt(3)") && !never.contains("2/3"), "{never}");
    let natural = told(&format!("{parts}system S = A | D\nperiod S\n"));
    assert!(natural.contains("lasting: m*t in all"), "{natural}");
    let found = told(&format!("{parts}param m = 2\nsystem S = A | D\nperiod S\n").replace(", m : natural, m >= 1", ""));
    assert!(found.contains("lasting: 2*t"), "{found}");
}

#[test]
fn terms_that_are_very_large_or_small_have_leading_digits() {
    let listed = |map: &str, start: &str| told(&format!("solve r(n+1) = {map}, r(0) = {start}\n"));
    // 2^-(2^19) and 2^-(3^19) by their logarithms.
    let squares = listed("r(n)^2", "1/2");
    assert!(squares.contains("≈3.851530334e-157827, …") && !squares.contains('?'), "{squares}");
    let cubes = listed("r(n)^3", "1/2");
    let row = cubes.lines().find(|line| line.contains("from 0 on")).unwrap_or_default();
    assert_eq!((row.split(", ").count(), row.contains('?')), (21, false), "{row}");
    let last = row.split(", ").nth(19).unwrap_or_default();
    let exponent = last.rsplit_once("e-").map(|(_, digits)| digits.parse::<f64>().unwrap());
    assert_eq!(exponent, Some((3f64.powi(19) * 2f64.log10()).ceil()), "{last}");
    // Up to exponents of twelve digits; what grows faster ends the list.
    let fast = listed("r(n)^4+1", "2");
    let row = fast.lines().find(|line| line.contains("from 0 on")).unwrap_or_default();
    assert_eq!((row.split(", ").count(), row.contains('?')), (21, false), "{row}");
    let faster = listed("r(n)^10+1", "2");
    assert!(faster.contains("e301072386, ") && !faster.contains('?'), "{faster}");
    let both = told("solve x(n+1) = x(n)+x(n)*y(n)/10, y(n+1) = y(n)-x(n)*y(n)/10, x(0) = 1, y(0) = 9\n");
    assert!(!both.contains('?') && both.contains("e-"), "{both}");
}

#[test]
fn a_jump_over_an_obstacle_between_two_looks_is_said_and_is_no_repair() {
    let told = String::from_utf8_lossy(
        &Command::new(env!("CARGO_BIN_EXE_pars"))
            .args(["run", "tests/cases/operator/jumps.pars"])
            .current_dir(env!("CARGO_MANIFEST_DIR"))
            .output()
            .expect("it runs")
            .stdout,
    )
    .into_owned();
    assert!(told.contains("try: clearance: no change of v was found") && !told.contains("v = "), "{told}");
    assert!(
        told.contains("going straight from what is shown before 2 to what is shown then comes as near as 0"),
        "{told}"
    );
    // A margin of which only a bound is known has no sensitivity, which is said.
    assert!(told.contains("as of them only bounds are known here: clearance by step"), "{told}");
}

#[test]
fn a_value_with_a_capital_is_advised_a_name_that_stands_for_a_value() {
    let errors = String::from_utf8_lossy(&pars("run", "prove (Delay_1)^L = Delay_L\n").stderr).into_owned();
    assert!(errors.contains("declare it with `param L`, or write `?l` for any value"), "{errors}");
}

#[test]
fn what_is_checked_is_what_was_solved() {
    let script = "param v > 0, p, q\nsolve x(n+1) = x(n)+clamp(p-x(n),-v,v), y(n+1) = y(n)+clamp(q-y(n),-v,v), \
        x(0) = 0, y(0) = 0 find n with x(n) = p\n";
    let told = told(script);
    let proofs: Vec<&str> = told.lines().filter(|line| line.contains("checked by induction")).collect();
    assert!(told.contains("n = ceil(abs(p)/v) is the first") && proofs.len() == 1, "{told}");
    assert!(proofs.iter().all(|line| line.contains("x(0) = 0") && !line.contains("y(")), "{told}");
}

#[test]
fn a_change_that_hides_what_is_kept_apart_is_no_repair() {
    let text = told(include_str!("cases/missions/clearance_repairs.pars"));
    assert!(text.contains("clearance: no change of wait was found with which it is met"), "{text}");
}

#[test]
fn a_run_whose_values_become_roundings_of_roundings_says_so() {
    let text = told(include_str!("cases/periods/free_rates.pars"));
    assert!(text.contains("forms of its values grow") && text.contains("followed through 25 legs"), "{text}");
}
