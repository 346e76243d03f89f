//! What the kernel has checked of a period: all ways for all values, or those that the run takes with the values it has.

mod common;

fn told(asked: &str) -> String {
    String::from_utf8_lossy(&common::ran(asked).stdout).into_owned()
}

fn case(name: &str) -> String {
    told(&std::fs::read_to_string(format!("tests/cases/{name}.pars")).expect("a case"))
}

#[test]
fn counters_that_go_round_are_checked_in_all_ways() {
    let text = case("periods/rest_of_divisions");
    let checked = text.lines().filter(|line| line.contains("by the kernel: all")).count();
    assert_eq!((checked, text.matches("not checked").count()), (3, 0), "{text}");
    // Each order of what is not known, where a delay may be none.
    let text = told(
        "param a > 0, d >= 0\nproc W = Delay_a ; Out_{c,1} ; W\nproc Z = In_c<x> ; Delay_d ; Z\nsystem S = W | Z\nperiod S\n",
    );
    assert_eq!(text.matches("by the kernel: all").count(), 3, "{text}");
    assert!(!text.contains("if d <= 0") || !text.contains("phase 2 -> phase 1"), "{text}");
}

#[test]
fn time_outs_and_rounds_that_may_be_none_are_checked_in_all_ways() {
    for (name, periods) in [("periods/time_outs", 3), ("periods/at_least_one", 8), ("periods/names_again", 3)] {
        let text = case(name);
        let counts = (text.matches("by the kernel: all").count(), text.matches("on trust").count());
        assert_eq!(counts, (periods, 0), "{text}");
    }
    let text = case("missions/off_the_line");
    assert_eq!((text.matches("proved:").count(), text.matches("on trust").count()), (2, 0), "{text}");
}

#[test]
fn rounds_of_the_run_on_other_ways_are_checked_one_by_one() {
    let counter = "proc W_r = (Delay_1 # Odo_r) ; In_v<u> ; W_{if r > 19 then 0 else r+u}\nproc Odo_r = Out_{p,r} ; Odo_r\n\
        proc Go = In_p<x> ; ((Gtr_{x^4-x^3+1,0} ; Out_{v,1}) | (Lte_{x^4-x^3+1,0} ; Out_{v,1/(x^4+x^3+2)} ; Delay_1)) ; Go\n\
        system Sys = W_0 | Go\nperiod Sys\n";
    let text = told(counter);
    assert!(
        text.contains("2 of 3 ways from start and phases, with their flow functions; the run takes no other"),
        "{text}"
    );
    assert!(text.contains("not checked by the kernel for all values: phase 1 -> waits for ever"), "{text}");
    // A battery that runs down: one variable, all ways, with what is written with as few corners as it has.
    let text = case("missions/battery");
    assert_eq!(
        (text.matches("by the kernel: all 8 ways").count(), text.matches("not checked").count()),
        (2, 0),
        "{text}"
    );
    // Along an axis the length divides, and the guard tells that what is left after a step is not 0.
    let text = told(
        "proc Go_g = In_p<r> ; Gtr_{norm(g-r),1/2} ; Out_{w,unit(g-r)/2} ; Go_g\n\
         proc World_r = (Delay_1 # Odo_r) ; In_w<u> ; World_{r+u}\nproc Odo_r = Out_{p,r} ; Odo_r\n\
         system Sys = World_{(0,3)} | Go_{(0,0)}\nperiod Sys\n",
    );
    assert!(text.contains("by the kernel: all 4 ways"), "{text}");
}

/// What varies from round to round is nothing that an assumption could tell of.
#[test]
fn no_assumption_is_advised_of_what_varies() {
    let text = told(
        "proc Src_k = Out_{c,k} ; Delay_{1+k} ; Src_{1/(2+k)}\nproc Snk = In_c<x> ; Delay_{3/2} ; Out_{d,x} ; Snk\n\
         proc End = In_d<y> ; Delay_{2-y} ; End\nsystem Sys = Src_1 | Snk | End\nperiod Sys\n",
    );
    assert!(!text.contains("`param") || !text.contains("rest"), "{text}");
}

#[test]
fn ways_with_symbols_are_checked_by_where_they_lead() {
    // A rectangle of any size at any speed, and a stay of any length at any place of a line.
    let goes = "proc World_r = (Delay_1 # Odo_r # At_r) ; (In_v<u> # Odo_r # At_r) ; World_{r+u}\n\
        proc Odo_r = Out_{p,r} ; Odo_r\nproc Go_g = In_p<r> ; Neq_{r,g} ; Out_{v,s(g-r)} ; Go_g\n";
    let plane = told(&format!(
        "param a > 0, b > 0, v > 0\nfn s(d) = min(v, norm(d))*unit(d)\n{goes}\
         proc M = Go_{{(a,0)}} ; Go_{{(a,b)}} ; Go_{{(0,b)}} ; Go_{{(0,0)}} ; M\nsystem Sys = World_{{(0,0)}} | M\nperiod Sys\n"
    ));
    assert!(plane.contains("by the kernel: all 9 ways") && !plane.contains("not checked"), "{plane}");
    assert!(plane.contains("lasting: 2*ceil(b/v)+2*ceil(a/v) in all"), "{plane}");
    let line = told(&format!(
        "param g > 0, v > 0, w > 0, w = 1\nfn s(d) = clamp(d,-v,v)\n{goes}\
         proc M = Go_g ; Delay_w ; Go_0 ; M\nsystem Sys = World_0 | M\nperiod Sys\n"
    ));
    assert!(line.contains("by the kernel: all 9 ways") && !line.contains("not checked"), "{line}");
}
