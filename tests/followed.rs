//! Missions that the kernel follows: nothing of them is on trust, and their proof files check.

mod common;

/// Runs the program; what it prints.
fn pars(arguments: &[&str]) -> String {
    let ran = std::process::Command::new(env!("CARGO_BIN_EXE_pars"))
        .args(arguments)
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .expect("pars runs");
    String::from_utf8_lossy(&ran.stdout).into_owned()
}

/// What the program prints of a script, and the script behind it.
fn run(text: &str) -> String {
    let folder = tempfile::tempdir().expect("a folder");
    let script = folder.path().join("script.pars");
    std::fs::write(&script, text).expect("written");
    pars(&["run", script.to_str().expect("a path")])
}

const CLAMPED: &str = "proc World_r = (Delay_t # Odo_r # At_r) ; In_c<u> ; World_{r+u*t}\nproc Odo_r = Out_{p,r} ; Odo_r\n\
    proc Move_g = In_p<r> ; Neq_{r,g} ; Out_{c,s(g-r)} ; Move_g\nfn s(e) = clamp(e/t,-v,v)\n";

/// The way there and back from 0 or a symbol at a limited speed.
#[test]
fn a_limited_speed_is_followed_from_any_start() {
    for (known, first, start, asked) in [
        ("param a > 0, v = 1, t = 1", "a", "0", "a"),
        ("param a > 0, v > 0, t > 0", "a", "0", "a"),
        // Of the start it is known in two steps, and in one besides, that it lies before the goal.
        ("param o, b > 0, a > b, o < b, v > 0, t > 0", "a", "o", "a"),
        ("param o, b > 0, a > b, o < b, o < a, v > 0, t > 0", "a", "o", "a"),
    ] {
        let back = if start == "0" { "0" } else { "b" };
        let text = run(&format!(
            "{known}\n{CLAMPED}proc M = Move_{first} ; Move_{back} ; M\nsystem Sys = World_{start} | M\n\
             property G = Delay_{{?t1}} ; (Delay_{{?t2}} # At_{asked}) ; Delay_{{?t3}} ; G\nprove Sys satisfies G\n"
        ));
        assert!(text.contains("proved: ") && !text.contains("on trust"), "{known}: {text}");
    }
}

const PLANE: &str = "observer Pos(r)\nproc World_r = (Delay_1 # Odo_r # Pos_r) ; In_w<u> ; World_{r+u}\n\
    proc Odo_r = Out_{p,r} ; Odo_r\nproc Move_g = In_p<r> ; Neq_{r,g} ; Out_{w,st(g-r)} ; Move_g\n";

/// A number as goal at any speed, a wait that is any number of rounds long, and straight lines in the plane at any speed: how
/// each round begins, the closed forms tell.
#[test]
fn symbols_in_the_speed_the_wait_and_the_plane_are_followed() {
    let plane = format!("fn st(d) = if norm(d) > v then v*unit(d) else d\n{PLANE}");
    let there = |goal: &str| {
        format!(
            "proc M = Move_{{{goal}}} ; Move_{{(0,0)}} ; M\nsystem Sys = World_{{(0,0)}} | M\n\
             property G = Delay_{{?t1}} ; (Delay_{{?t2}} # Pos_{{{goal}}}) ; Delay_{{?t3}} ; G\n"
        )
    };
    let line = "system Sys = World_0 | M\nproperty G = Delay_{?t1} ; (Delay_{?t2} # At_a) ; Delay_{?t3} ; G\n";
    let goal = format!("param a = 10, v > 0, t > 0\n{CLAMPED}proc M = Move_a ; Move_0 ; M\n{line}");
    let wait = format!(
        "param a = 3, v = 1, t = 1\nparam d : natural, d > 0\n{CLAMPED}proc Wait = Out_{{c,0}}\n\
         proc M = Move_a ; Wait^d ; Move_0 ; M\n{line}"
    );
    let speed = format!("param v > 0\n{plane}{}", there("(3,4)"));
    for (text, time) in [(goal, "t*ceil(10/(t*v))"), (wait, "3"), (speed, "ceil(5/v)")] {
        let text = run(&format!("{text}prove Sys satisfies G\nexpect proved\nexpect t1 = {time}\n"));
        assert!(text.contains("proved: ") && !text.contains("on trust") && !text.contains("but expected"), "{text}");
    }
}

/// Of each of these the kernel has checked all ways, so many.
fn all_checked<const COUNT: usize>(systems: [(String, usize); COUNT]) {
    for (text, ways) in systems {
        let found = run(&text);
        let all = format!("by the kernel: all {ways} ways");
        assert!(found.contains(&all), "{}", &found[found.len().saturating_sub(900)..]);
    }
}

/// What a call binds is read behind it, whatever was bound so before: how the system stands in the middle of a round says so.
#[test]
fn what_a_call_binds_is_read_behind_it() {
    let tour = |between: &str| {
        format!(
            "observer At(s)\nproc Step_s<s2> = (Delay_1 # At_s) ; Set_{{s+1}}<s2>\n\
             proc Rec = In_o<y> ; (Delay_1 # At_y) ; Rec\n\
             proc Tour_s = Step_s<s2> ; Set_s2<a> ; {between} ; Out_{{o,s2}} ; Delay_{{1/2}} ; Tour_{{mod(s2,5)}}\n\
             system Sys = Tour_0 | Rec\nperiod Sys\n"
        )
    };
    all_checked([(tour("Step_a<s2>"), 3), (tour("Step_a<s2> ; Set_s2<b> ; Step_b<s2>"), 3)]);
}

/// Along an axis a direction is the sign of a number: what the system does then depends on conditions, and is followed case
/// by case.
#[test]
fn ways_along_an_axis_are_checked_case_by_case() {
    let plane = format!(
        "fn st(d) = if norm(d) > 1 then unit(d) else d\n{PLANE}proc M = Move_{{(3,4)}} ; Move_{{(-2,4)}} ; M\n\
         system Sys = World_{{(3,4)}} | M\nperiod Sys\n"
    );
    let dock = format!(
        "param v = 1, t = 1\nfn d(e) = if abs(e) > 4 then 2*e/abs(e) else clamp(e, -1/2, 1/2)\n{}\
         proc M = Move_10 ; Move_0 ; M\nsystem Sys = World_0 | M\nperiod Sys\n",
        CLAMPED.replace("s(g-r)", "d(g-r)")
    );
    all_checked([(plane, 5), (dock, 5)]);
}

/// In the plane until the goal is near: where a step ends, the next direction must have a value, and what is under the root is
/// the square of a length in another form.
#[test]
fn ways_in_the_plane_until_the_goal_is_near_are_checked() {
    for (command, goals, ways) in [
        ("unit(g-r)/5", "Go_{(7,2)} ; Go_{(1,-1)}", 5),
        ("unit(g-r)", "Go_{(6,8)} ; Go_{(0,0)}", 5),
        ("min(1/2,norm(g-r))*unit(g-r)", "Go_{(7,2)} ; Go_{(1,-1)}", 5),
        ("if norm(g-r) > 1/2 then unit(g-r)/2 else g-r", "Go_{(6,8)} ; Go_{(0,0)}", 5),
        ("unit(g-r)/2", "Go_{(6,1)} ; Go_{(2,3)} ; Go_{(0,0)}", 10),
    ] {
        let mission = format!(
            "proc World_r = (Delay_1 # Odo_r # At_r) ; In_c<u> ; World_{{r+u}}\nproc Odo_r = Out_{{p,r}} ; Odo_r\n\
             proc Go_g = In_p<r> ; Gtr_{{norm(g-r),1/4}} ; Out_{{c,{command}}} ; Go_g\nproc M = {goals} ; M\n\
             system Sys = World_{{(0,0)}} | M\nperiod Sys\n"
        );
        all_checked([(mission, ways)]);
    }
}

/// All ways of a period are theorems: whose goal is the limit of the command, where parts branch on what they read so that
/// one branch goes on, of many goals, and of robots that all read and write at once.
#[test]
fn every_way_of_a_period_is_checked() {
    let goals: String = (0..70).map(|number| format!("Move_{} ; ", number * 7 % 23 + 1)).collect();
    let tour = format!("param v = 1, t = 1\n{CLAMPED}proc M = {goals}M\nsystem Sys = World_{{1/2}} | M\nperiod Sys\n");
    let limit = format!(
        "param v = 1, t = 1\n{CLAMPED}proc M = Move_1 ; Move_8 ; M\nsystem Sys = World_{{1/2}} | M\nperiod Sys\n"
    );
    let branches = "observer X(x)\n\
        proc Room_x = (Delay_1 # X_x # Sense_x) ; In_c<k> ; \
        ((Eq_{k,1} ; Set_{x+1}<y>) | (Neq_{k,1} ; Set_{x-1}<y>)) ; Room_y\nproc Sense_x = Out_{s,x} ; Sense_x\n\
        proc Ctl = In_s<m> ; ((Lte_{m,19} ; Set_1<g>) | (Gtr_{m,19} ; Set_0<g>)) ; Out_{c,g} ; Ctl\n\
        system Sys = Room_18 | Ctl\nperiod Sys\n";
    let count = 420;
    let robots: Vec<String> = (0..count)
        .map(|own| {
            let before = (own + count - 1) % count;
            format!(
                "proc Robot{own}_r = (Delay_1 # At_{{{own},r}}) ; (Out_{{c{own},r}} | In_c{before}<q>) ; \
                 Robot{own}_{{r+(q-r)/2}}\n"
            )
        })
        .collect();
    let all: Vec<String> = (0..count).map(|own| format!("Robot{own}_{own}")).collect();
    let ring = format!("observer At(i, r)\n{}system Sys = {}\nperiod Sys\n", robots.concat(), all.join(" | "));
    all_checked([(tour, 140), (limit, 5), (branches.to_string(), 5), (ring, 2)]);
}

#[test]
fn missions_are_proved_with_nothing_on_trust_and_their_files_check() {
    let examples = ["back_and_forth", "granularities", "six_states", "constant_speed", "plane", "tolerance"];
    for example in examples {
        let folder = tempfile::tempdir().expect("a folder");
        let into = folder.path().to_str().expect("a path");
        let text = pars(&["run", "--proofs", into, &format!("examples/{example}.pars")]);
        assert!(text.contains("proved: ") && !text.contains("on trust"), "{example}: {text}");
        let mut files = 0;
        for file in std::fs::read_dir(folder.path()).expect("a folder").flatten() {
            let path = file.path();
            let checked = pars(&["check", path.to_str().expect("a path")]);
            assert!(checked.contains(" <~ ") && !checked.contains("on trust"), "{example}: {checked}");
            files += 1;
        }
        assert!(files > 0, "{example} has no proof file");
    }
    // In either order of two places, each with a proof of its own; in the plane, to within a distance, and at a symbolic speed.
    for mission in ["either_order", "plane_tolerance", "oblique_tour"] {
        let text = pars(&["run", &format!("tests/cases/missions/{mission}.pars")]);
        assert!(text.contains("proved: ") && !text.contains("on trust"), "{mission}: {text}");
    }
    // Where the kernel cannot follow, the trust stays and is said, with the reason.
    let text = pars(&["run", "tests/cases/missions/on_trust.pars"]);
    assert!(text.contains("the kernel could not follow the run: "), "{text}");
    assert!(text.contains("on trust: that the system runs as printed"), "{text}");
}

/// Straight to a goal at a distance that is irrational, in steps and at a speed that are symbols.
#[test]
fn a_line_of_irrational_length_is_followed() {
    for goal in ["(1,1)", "(3,5)", "(-2,3)"] {
        let text = run(&format!(
            "observer At(x)\nparam t > 0, v > 0\nproc World_r = (Delay_t # At_r # Odo_r) ; In_c<u> ; World_{{r+u*t}}\n\
             proc Odo_r = Out_{{p,r}} ; Odo_r\n\
             proc Go_g = In_p<r> ; Neq_{{r,g}} ; Out_{{c, min(v, norm(g-r)/t)*unit(g-r)}} ; Go_g\n\
             system Sys = World_{{(0,0)}} | Go_{{{goal}}}\nproperty G = Delay_{{?a}} ; (Delay_{{?b}} # At_{{{goal}}})\n\
             prove Sys satisfies G\n"
        ));
        assert!(text.contains("proved: ") && !text.contains("on trust"), "{goal}: {text}");
    }
}

const COUNTED: &str = "param N : natural, N >= 2\nproc World_r = (Delay_1 # At_r) ; In_v<u> ; World_{r+u}\n\
    proc Up_n = Gtr_{n,0} ; Out_{v,1} ; Up_{n-1}\nproc Down_n = Gtr_{n,0} ; Out_{v,-1} ; Down_{n-1}\n\
    proc Prog = Out_{v,1} ; Up_N ; Out_{v,-1} ; Down_N ; Prog\nsystem Sys = World_0 | Prog\nperiod Sys\n\
    property Top = Delay_{?t1} ; (Delay_{?t2} # At_{N+1}) ; Delay_{?t3} ; Top\nprove Sys satisfies Top\n";

#[test]
fn a_symbolic_number_of_rounds_is_proved_by_a_lemma_about_one() {
    let folder = tempfile::tempdir().expect("a folder");
    let script = folder.path().join("counted.pars");
    std::fs::write(&script, COUNTED).expect("written");
    let proofs = folder.path().join("proofs");
    let text = pars(&["run", "--proofs", proofs.to_str().expect("a path"), script.to_str().expect("a path")]);
    assert!(text.contains("by the kernel: all 7 ways from start and phases"), "{text}");
    assert!(text.contains("proved: Sys satisfies Top") && !text.contains("on trust"), "{text}");
    let file = std::fs::read_dir(proofs).expect("a folder").flatten().next().expect("a proof").path();
    let written = std::fs::read_to_string(&file).expect("a proof");
    assert!(written.contains("\"step\":\"rounds\""), "{written}");
    assert!(!pars(&["check", file.to_str().expect("a path")]).contains("on trust"));
}

#[test]
fn a_number_of_rounds_that_may_be_none_is_proved_in_two_cases() {
    let folder = tempfile::tempdir().expect("a folder");
    let proofs = folder.path().join("proofs");
    let text = pars(&["run", "--proofs", proofs.to_str().expect("a path"), "examples/symbolic_speed.pars"]);
    assert!(text.contains("proved: Sys satisfies Goal") && !text.contains("on trust"), "{text}");
    let file = std::fs::read_dir(proofs).expect("a folder").flatten().next().expect("a proof").path();
    let written = std::fs::read_to_string(&file).expect("a proof");
    assert!(written.contains("\"step\":\"cases\""), "{written}");
    assert!(!pars(&["check", file.to_str().expect("a path")]).contains("on trust"));
}

/// A chain has more ports of its own than a small stack takes, and ever two of its parts meet at a time.
#[test]
fn a_long_chain_is_followed() {
    let parts = 1_500;
    let (relays, names) = common::relays(parts);
    let text = run(&format!(
        "observer Got(x)\nproc First_k = Delay_1 ; Out_{{c0,k}} ; First_{{k+1}}\n{relays}\
         proc Last = In_c{parts}<x> ; (Delay_{{1/2}} # Got_x) ; Last\nsystem Sys = First_3{names} | Last\nperiod Sys\n"
    ));
    assert!(text.contains("by the kernel: all 3 ways"), "{}", text.lines().last().unwrap_or_default());
}

/// Each pair of legs is a way, and ways that leave from one place have what they draw in common.
#[test]
fn many_noisy_legs_are_followed() {
    let legs: String = (0..24).map(|leg| format!("Go_{{{}}} ; ", [3, -1, 5, 2][leg % 4])).collect();
    let text = run(&format!(
        "observer Done\nproc World_r = (Delay_1 # Odo_r) ; In_v<u> ; Ran_{{Normal(0, sd: 0.4)}}<e> ; World_{{r+(u+e)/4}}\n\
         proc Odo_r = Ran_{{Normal(0, sd: 0.2)}}<n> ; Out_{{p,r+n}} ; Odo_r\n\
         proc Go_g = In_p<m> ; Gtr_{{abs(m-g),1/5}} ; Out_{{v,g-m}} ; Go_g\nsystem Sys = World_0 | {legs}Done\nperiod Sys\n"
    ));
    assert!(text.contains("by the kernel: all 350 ways"), "{}", text.lines().last().unwrap_or_default());
}

/// Two robots of other steps that hand over: how far one clamped step after another leads is decided.
#[test]
fn clamped_steps_within_one_step_of_another_are_followed() {
    let text = run("observer At1(r), At2(r)\n\
        proc World1_r = (Delay_2 # Odo1_r # At1_r) ; In_v1<u> ; World1_{r+u}\nproc Odo1_r = Out_{p1,r} ; Odo1_r\n\
        proc Move1_g = In_p1<r> ; Neq_{r,g} ; Out_{v1,clamp(g-r,-1,1)} ; Move1_g\n\
        proc World2_r = (Delay_{1/2} # Odo2_r # At2_r) ; (In_v2<u> # Odo2_r # At2_r) ; World2_{r+u}\n\
        proc Odo2_r = Out_{p2,r} ; Odo2_r\nproc Move2_g = In_p2<r> ; Neq_{r,g} ; Out_{v2,clamp(g-r,-1,1)} ; Move2_g\n\
        proc Prog1 = Move1_4 ; Out_{give,2} ; Move1_0 ; Prog1\nproc Prog2 = In_give<x> ; Move2_0 ; Move2_x ; Prog2\n\
        system Sys = World1_1 | Prog1 | World2_7 | Prog2\nperiod Sys\n");
    assert!(text.contains("by the kernel: all 84 ways") && text.contains("lasting: 16 in all"), "{text}");
    // The run is known, and never comes to where some run might wait.
    assert!(!text.contains("warning"), "{text}");
}

/// Beside a value that never comes again, one that comes round in turn.
#[test]
fn a_counter_beside_what_never_repeats_is_followed() {
    for (beside, counter) in [("y/2+1", "mod(m+1,3)"), ("y+m", "mod(m+1,3)"), ("y+1", "if m < 2 then m+1 else 0")] {
        let text = run(&format!(
            "observer M(m), B(y)\nproc P_{{m,y}} = (Delay_1 # M_m # B_y) ; P_{{{counter},{beside}}}\nsystem S = P_{{0,0}}\n\
             property K = Delay_{{?t1}} ; (Delay_{{?t2}} # M_2)\nprove S satisfies K\n"
        ));
        assert!(text.contains("proved: ") && !text.contains("on trust"), "{counter} beside {beside}: {text}");
        assert!(text.contains("with ?t1 = 2, ?t2 = 1"), "{text}");
    }
}

/// A goal in halves: what stands in the distance is no sum of squares, but a multiple of it is.
#[test]
fn a_goal_in_halves_is_followed() {
    let text = run(&format!(
        "fn st(d) = min(1,norm(d))*unit(d)\n{PLANE}proc M = Move_{{(5/2,7/2)}} ; Move_{{(0,0)}} ; M\n\
         system Sys = World_{{(0,0)}} | M\nperiod Sys\n\
         property G = Delay_{{?t1}} ; (Delay_{{?t2}} # Pos_{{(5/2,7/2)}}) ; Delay_{{?t3}} ; G\nprove Sys satisfies G\n"
    ));
    assert!(text.contains("all 5 ways") && text.contains("proved: ") && !text.contains("on trust"), "{text}");
}

/// Of two tries of which the first is known to fail, the second binds what is read later.
#[test]
fn a_second_try_that_binds_a_result_is_followed() {
    let text = run("param t > 0\nobserver Slow(n)\n\
         proc Try_n = (Delay_t ; Gtr_{n,2} ; Set_0<k>) else ((Delay_{2*t} # Slow_n) ; Set_{n+1}<k>)\n\
         proc L_n = Try_n ; Out_{c,k} ; L_k\nproc R = In_c<x> ; R\nsystem Sys = L_0 | R\nperiod Sys\n");
    assert!(text.contains("lasting: 10*t in all") && text.contains("all 3 ways"), "{text}");
}
