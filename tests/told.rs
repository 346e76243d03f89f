//! What is said beside a verdict is true: of rounds that pass in several ways, of values that come by turns, of what moves
//! what, and under which conditions.

mod common;

use common::ran;

/// What the program says to a script.
fn told(script: &str) -> String {
    String::from_utf8_lossy(&ran(script).stdout).into_owned()
}

#[track_caller]
fn says(script: &str, lines: &[&str]) {
    let told = told(script);
    for line in lines {
        assert!(told.lines().any(|other| other.trim() == *line), "not said: {line}\n{told}");
    }
}

#[track_caller]
fn never_says(script: &str, words: &str) {
    let told = told(script);
    assert!(!told.contains(words), "said: {words}\n{told}");
}

#[test]
fn a_flow_table_tells_of_each_way_what_passes() {
    let script = "proc W_r = (Delay_1 # At_r) ; ((Gtr_{r,3} ; (Delay_2 # At_{0-r}) ; Out_{c,r} ; Set_0<z>) | (Lte_{r,3} ; Set_{r+1}<z>)) ; W_z\n\
        proc R = In_c<x> ; R\nsystem Sys = W_0 | R\nflow Sys\nperiod Sys\n";
    says(
        script,
        &[
            "period    (Delay_1 # At_r) ; (Delay_2 # At_{-r}), lasting 3 if r > 3",
            "period    Delay_1 # At_r, lasting 1 if r <= 3",
            "port c    r if r > 3",
            "phase 1: (Delay_1 # At_r) ; (Delay_2 # At_{-r}) if r > 3",
            "phase 1: Delay_1 # At_r if r <= 3",
        ],
    );
    // On the way out nothing passes.
    let script = "proc V_r = (Delay_1 # At_r) ; ((Lss_{r,3} ; Out_{c,r} ; V_{r+1}) | (Gte_{r,3} ; Y_r))\n\
        proc Y_r = (Delay_1 # At_r) ; Y_{r/2}\nproc R = In_c<x> ; R\nsystem S = V_0 | R\nflow S\n";
    says(script, &["port c    r if r < 3"]);
    // Another phase is entered with values of its own, after another time.
    let script = "proc W_r = (Delay_1 # At_r) ; ((Gtr_{r,3} ; (Delay_2 # At_{0-r}) ; V_{r*2}) | (Lte_{r,3} ; W_{r+1}))\n\
        proc V_s = (Delay_5 # At_s) ; ((Gtr_{s,0} ; V_{s-1}) | (Lte_{s,0} ; W_{s+1}))\nsystem Sys = W_0\nflow Sys\n";
    let leaves = "then      to phase 2 after (Delay_1 # At_r) ; (Delay_2 # At_{-r}), lasting 3 with s = 2*r if r > 3";
    let back = "then      to phase 1 with r = s+1 if s <= 0";
    says(script, &["period    Delay_1 # At_r, lasting 1", "flow      f(r) = r+1 if r <= 3", leaves, back]);
}

#[test]
fn a_closed_form_in_a_flow_table_says_what_it_needs() {
    let script = "param t > 0\nproc W_r = (Delay_t # At_r) ; W_{t*r+1}\nsystem S = W_0\nflow S\n";
    says(script, &["closed    r = (t^n*(r0*t-r0+1)-1)/(t-1) from n = 0 if t != 1"]);
}

#[test]
fn values_that_are_not_the_same_in_all_later_rounds_are_said_by_turns() {
    let world = "observer One(x)\nproc Sub_n = Gtr_{n,0} ; (Delay_1 # One_1) ; Sub_{n-1}\n\
        proc W_x = (Delay_1 # One_0) ; Sub_x ; (Delay_1 # One_0) ; W_{if x >= 2 then 1 else x+1}\nsystem Sys = W_1\n";
    let free = "property G = Delay_{?t1} ; (Delay_{?t2} # One_1) ; Delay_{?t3} ; G\nprove Sys satisfies G\n";
    let lines =
        ["with ?t1 = 1, ?t2 = 1, ?t3 = 1", "in later rounds ?t1 = 1, ?t3 = 1", "from round 2 on ?t2 = 2, 1 by turns"];
    says(&format!("{world}{free}"), &lines);
    let fixed = "property L = Delay_1 ; (Delay_{?t2} # One_1) ; Delay_1 ; L\nprove Sys satisfies L\n";
    says(&format!("{world}{fixed}"), &["with ?t2 = 1", "from round 1 on ?t2 = 1, 2 by turns"]);
}

#[test]
fn what_is_shown_for_ever_could_be_shown_for_longer() {
    let script = "proc W = (Delay_1 # At_0) ; W\nsystem Sys = W\nproperty G = Delay_{?t1} ; (Delay_{?t2} # At_0)\nprove Sys satisfies G\n";
    says(script, &["it is shown for ever: ?t2 could be any longer"]);
    let ends = "proc W = (Delay_1 # At_0) ; (Delay_1 # At_1) ; W\nsystem Sys = W\nproperty G = Delay_{?t1} ; (Delay_{?t2} # At_0)\nprove Sys satisfies G\n";
    says(ends, &["with ?t1 = 0, ?t2 = 1"]);
    never_says(ends, "any longer");
}

#[test]
fn what_moves_by_itself_is_moved_by_no_port() {
    let world = |next: &str| {
        format!(
            "observer Rock(o)\nproc Odo_r = Out_{{p,r}} ; Odo_r\nproc Env_{{r,o}} = (Delay_1 # Odo_r # At_r # Rock_o) ; In_v<u> ; {next}\n\
            proc Go = In_p<r> ; Out_{{v,-2}} ; Go\nsystem A = Env_{{0,5}} | Go\nprove A always p < o when At_p, Rock_o\n"
        )
    };
    let itself = world("Env_{r+u,o-1}");
    says(&itself, &["not connected: no port carries what Rock shows, so nothing can sense it"]);
    never_says(&itself, "moves Rock");
    // What a test decides moves, too.
    let tested = world("((Gtr_{u,0} ; Env_{r+1,o-1}) | (Lte_{u,0} ; Env_{r-2,o-1}))");
    never_says(&tested, "there is no actuator");
}

#[test]
fn the_weakest_condition_asks_for_nothing_that_is_not_needed() {
    let script = "param k, v > 0, w > 0\nproc Odo_r = Out_{p,r} ; Odo_r\nproc Env_r = (Delay_{1/2} # Odo_r # At_r) ; In_v<u> ; Env_{r+u*1/2}\n\
        proc Go = In_p<r> ; ((Gte_{r-k,1} ; Out_{v,k}) | (Lss_{r-k,1} ; Out_{v,0})) ; Go\nsystem A = Env_0 | Go\n\
        prove A always p <= k+3, p >= -v when At_p\n";
    says(script, &["try: it is proved if k > -1, the weakest condition found"]);
    let assumed = script.replace("param k,", "param k > -1,");
    assert!(told(&assumed).contains("proved: A always"), "{}", told(&assumed));
}

/// Whoever works out the distance that is looked at, the writer as it writes or the one who calls it.
#[test]
fn the_weakest_condition_is_found_whoever_works_out_the_distance() {
    for (sonar, sees) in
        [("Sonar_r = Out_{d,w-r} ; Sonar_r", "Sonar_r"), ("Sonar_x = Out_{d,x} ; Sonar_x", "Sonar_{w-r}")]
    {
        let script = format!(
            "observer Rock(q)\nparam hh, w > 2, t > 0, k > 0\nproc {sonar}\n\
            proc Env_r = (Delay_t # {sees} # At_r # Rock_w) ; In_v<u> ; Env_{{r+u*t}}\n\
            proc Go = In_d<x> ; (Gtr_{{x,hh}} ; Out_{{v,k}} ; Go | Lte_{{x,hh}} ; Out_{{v,0}} ; Go)\n\
            system Sys = Env_0 | Go\nprove Sys always |p-o| > 1 when At_p, Rock_o\n"
        );
        says(&script, &["try: it is proved if hh >= k*t+1, the weakest condition found"]);
        let assumed = script.replace("k > 0", "k > 0, hh >= k*t+1");
        assert!(told(&assumed).contains("proved: Sys always"), "{}", told(&assumed));
    }
}

#[test]
fn who_came_to_a_port_before_is_not_said_never_to_come() {
    let again = "proc W_r = Lss_{r,3} ; Out_{c,r} ; W_{r+1}\nproc V = In_c<x> ; (Delay_1 # At_x) ; V\n\
        system S = (W_0 ; Idle) | V\nperiod S\n";
    let after = "V reads port c and waits for ever: component 1, who writes it, never comes to it again";
    assert!(told(again).contains(after), "{}", told(again));
    let never = "proc A = (Delay_1 # At_0) ; Gtr_{0,1} ; Out_{c,1}\nproc B = In_c<x> ; B\nsystem S = (A ; Idle) | B\nperiod S\n";
    let told = told(never);
    assert!(told.contains("who writes it, never comes to it") && !told.contains("again"), "{told}");
    // On one way of two.
    let script = "param a\nproc A = (Delay_1 # At_0) ; ((Gtr_{a,0} ; Out_{c,1}) | (Lte_{a,0} ; Delay_1)) ; L_3\n\
        proc L_k = Gtr_{k,0} ; (Delay_1 # At_k) ; L_{k-1}\nproc B = In_c<x> ; B\nsystem S = (A ; Idle) | B\nperiod S\n";
    never_says(script, "never comes");
}

#[test]
fn tests_between_numbers_are_no_conditions() {
    // Where z is 3 the second choice is made with the first.
    let script = "proc C_{x,y} = (Delay_1 # At_y) ; ((Gtr_{y,1} ; Set_3<z>) | (Lte_{y,1} ; Set_x<z>)) ; (Delay_1 # At_z) ; \
        ((Gtr_{z,2} ; Delay_1) | (Lte_{z,2} ; Delay_2)) ; C_{x+1,y-1}\nsystem S = C_{0,4}\nflow S\nperiod S\n";
    let told = told(script);
    for line in told.lines() {
        let condition = line.rsplit_once(" if ").map_or("", |(_, condition)| condition);
        let numbers = condition.chars().all(|letter| letter.is_ascii_digit() || "<>=/- ".contains(letter));
        assert!(condition.is_empty() || !numbers, "{line}\n{told}");
    }
    assert!(told.contains("lasting 3 if y > 1") && !told.contains("lasting 4 if y > 1"), "{told}");
}

#[test]
fn of_the_variables_of_a_phase_those_are_told_that_depend_on_none_without_a_form() {
    let script = "proc W_{x,y} = (Delay_1 # At_x) ; (Delay_1 # At_y) ; W_{x*x+y, 2*y+1}\nsystem S = W_{1,1}\nflow S\n";
    let reason = "no closed form of x: it is not linear in x(n) and depends on n";
    says(script, &["closed    y = 2^n*(y0+1)-1 from n = 0", reason]);
}

#[test]
fn what_is_assumed_of_no_value_is_said() {
    let script = "param n : natural, n*n = 7\nproc W_r = (Delay_1 # At_r) ; W_{r+n}\nsystem S = W_0\n\
        property G = (Delay_{?t1} # At_1) ; G\nprove S satisfies G\n";
    says(script, &["no run was looked at: no values found for n that meet what is assumed"]);
}

#[test]
fn a_parameter_that_is_0_is_changed_by_what_is_said() {
    let script = "param p0 = 0, v = 1/1000\nproc Env_r = (Delay_1 # At_r) ; Env_{r+v}\nsystem S = Env_{p0}\n\
        criteria C for S {\n  goals At_{1/100}\n  leg within 12\n}\n";
    // From -1/50 it takes 30 in place of 10.
    says(script, &["margin of leg1 by p0: with +1/50 it is not met, -1/50 changes it by -20"]);
}

#[test]
fn a_law_that_fits_nothing_is_said_to() {
    let law = |left: &str| {
        format!(
            "law user \"A law.\"\n  ours a test\n  when ?a >= 0, ?b >= 0, observer(?O)\n  {left}\nprove Delay_1 = Delay_1\n"
        )
    };
    let warned = |left: &str| String::from_utf8_lossy(&ran(&law(left)).stderr).into_owned();
    let free = warned("(Delay_{?a+?b} # ?O) ; ?O => ?O");
    assert!(free.contains("P0924") && free.contains("of ?a or ?b alone"), "{free}");
    // Where another place tells one of them, the sum tells the other; and the right side may do.
    for fine in ["Delay_?a | Delay_{?a+?b} => Delay_{?a+?b}", "Delay_{?a+?b} = Delay_?a ; Delay_?b"] {
        let told = warned(fine);
        assert!(!told.contains("fits nothing"), "{told}");
    }
}

#[test]
fn what_nobody_reads_is_told_of_as_what_it_is() {
    let script = "observer At(r)\nproc World_r = (Delay_1 # Odo_r # At_r) ; In_v<u> ; World_{r+u}\nproc Odo_r = Out_{p,r} ; Odo_r\n";
    let unread = format!("{script}proc Push = Out_{{v,1}} ; Push\nsystem Sys = World_0 | Push\nperiod Sys\n");
    says(&unread, &["warning: World writes port p, which nobody reads; nothing waits for that", "lasting: 1"]);
    let spins = format!("{script}proc Spin = In_p<r> ; Spin\nsystem Sys = World_0 | Spin\nperiod Sys\n");
    says(&spins, &["no period: Odo and Spin go round in no time"]);
    never_says(&spins, "waits for ever");
}

#[test]
fn durations_below_0_are_told_of_where_one_may_be_drawn() {
    let below = "a duration that is drawn below 0 counts as 0";
    let fixed = "observer At(r)\nproc W = Ran_{Uniform(0, 1)}<a> ; Ran_{Uniform(0, 1)}<b> ; (Delay_1 # At_{a*b})\nsystem Sys = W\n\
        probability of Sys showing At_p where p > 1/2 at 1/2\n";
    never_says(fixed, below);
    let drawn = "observer Done\nproc W = Ran_{Normal(3, sd: 1)}<a> ; Delay_a ; Done\nsystem Sys = W\n\
        probability of Sys reaching Done within 4\n";
    says(drawn, &[below]);
    let surely =
        |start: i64| format!("proc V_d = (Delay_d # At_d) ; V_{{d-2}}\nsystem Sys = V_{{{start}}}\nperiod Sys\n");
    says(&surely(3), &["no period found: in V: the duration -1 is negative"]);
    let refused = String::from_utf8_lossy(&ran(&surely(-2)).stderr).into_owned();
    assert!(refused.contains("error[P0423]: in V: a delay cannot last -2"), "{refused}");
}

#[test]
fn what_swings_away_is_not_said_to_close_in() {
    let swing = |factor: &str| {
        format!(
            "observer At(r), Done\nproc Swing_{{r,i}} = (Delay_1 # Odo_r # At_r) ; In_v<u> ; Swing_{{r+i,({factor})*i}}\n\
             proc Odo_r = Out_{{p,r}} ; Odo_r\nproc Near = In_p<q> ; Gtr_{{abs(q-7),3/2}} ; Out_{{v,1}} ; Near\n\
             system Sys = Swing_{{0,1}} | (Near ; Done)\nproperty Reach = Delay_{{?t}} ; Done\nprove Sys satisfies Reach\n"
        )
    };
    let reason = "never meets the goal on its way";
    says(
        &swing("-2"),
        &[&format!("leg 1: phase 1, for ever: it moves away from 1/3, to either side in turn, and {reason}")],
    );
    says(&swing("-1/2"), &[&format!("leg 1: phase 1, for ever: it closes in on 2/3 and {reason}")]);
}

#[test]
fn where_hardly_any_change_is_needed_a_simple_one_is_named() {
    let script = "param speed = 2, wait = 1, far = 6\nobserver Rough\nfn s(d) = clamp(d, -speed, speed)\n\
        proc Go_g = In_p<r> ; Neq_{r,g} ; Out_{v,s(g-r)} ; Go_g\n\
        proc Trip = Go_far ; (Delay_wait # Rough) ; Go_{-far} ; (Delay_wait # Rough) ; Go_0 ; Trip\n\
        proc Base_r = (Delay_1 # Odo_r # At_r) ; In_v<u> ; Base_{r+u}\nproc Odo_r = Out_{p,r} ; Odo_r\n\
        system Sys = Base_0 | Trip\n\
        criteria C for Sys { goals At_far, At_{-far}, At_0 battery 11 rate 1, rate 1 while Rough keep 4 leg within 36 }\n";
    says(script, &["try: leg2: wait = 99/100 in place of 1 gives leg2 = 6, margin 30; 1 itself is not enough"]);
}

#[test]
fn a_power_that_comes_to_a_symbol_is_told_by_a_logarithm() {
    let falls = "param D > 0, e > 0\nsolve r(n+1) = r(n)/2, r(0) = D find n with r(n) < e\n";
    says(
        falls,
        &[
            "n = if D < e then 0 else floor(log(e/D)/log(1/2))+1 is the first with r(n) < e",
            "it is the least n with D*(1/2)^n < e; this is told in words and not checked, as logarithms are no values here",
        ],
    );
    let grows = "param D > 0\nsolve r(n+1) = 2*r(n), r(0) = 1 find n with r(n) >= D\n";
    says(grows, &["n = if 1 >= D then 0 else ceil(log(D)/log(2)) is the first with r(n) >= D"]);
    // From below it never comes to what is below it.
    let never = "param D > 0\nsolve r(n+1) = r(n)/2, r(0) = -1 find n with r(n) >= D\n";
    assert!(told(never).contains("never r(n) >= D"), "{}", told(never));
}

#[test]
fn what_is_measured_from_a_number_is_sensed() {
    let road = "observer Wall(q)\nproc Road_x = (Delay_1 # Ping_{9-x} # At_x # Wall_9) ; In_mot<c> ; Road_{x+c}\n\
        proc Ping_z = Out_{rng,z} ; Ping_z\n\
        proc Drive = In_rng<z> ; ((Gtr_{z,3} ; Out_{mot,1}) | (Lte_{z,3} ; Out_{mot,0})) ; Drive\n\
        system Car = Road_0 | Drive\nprove Car always |p-o| > 2 when At_p, Wall_o\n";
    says(road, &["connected: Wall (Road) -rng-> Drive -mot-> At (Road)"]);
}

#[test]
fn a_tour_of_many_legs_is_followed_to_where_it_repeats() {
    let legs: Vec<String> = (0..70).map(|leg| format!("Go_{}", 1 + 5 * (leg % 2) + leg % 3)).collect();
    let script = format!(
        "proc World_r = (Delay_1 # Odo_r # At_r) ; In_v<u> ; World_{{r+u}}\nproc Odo_r = Out_{{p,r}} ; Odo_r\n\
         proc Go_g = In_p<r> ; Neq_{{r,g}} ; Out_{{v,clamp(g-r,-1,1)}} ; Go_g\nproc Tour = {} ; Go_20 ; Tour\n\
         system Sys = World_0 | Tour\nproperty Far = Delay_{{?a}} ; (Delay_{{?b}} # At_20) ; Delay_{{?c}} ; Far\n\
         prove Sys satisfies Far\n",
        legs.join(" ; ")
    );
    assert!(told(&script).contains("proved: Sys satisfies Far"), "{}", told(&script));
}

/// A robot that walks to (3,4) in the plane, at a speed of at most v.
fn walk(end: &str) -> String {
    "param v > 0\nproc World_r = (Delay_1 # Odo_r # At_r) ; In_c<u> ; World_{r+u}\nproc Odo_r = Out_{p,r} ; Odo_r\n\
     proc Go_g = In_p<z> ; Neq_{z,g} ; Out_{c,if norm(g-z) > v then v*unit(g-z) else g-z} ; Go_g\n\
     system Sys = World_{(0,0)} | Go_{(3,4)}\n"
        .to_string()
        + end
}

#[test]
fn motion_in_the_plane_is_told_in_vectors() {
    says(
        &walk("flow Sys\nperiod Sys\n"),
        &[
            "World'_r = (Delay_1 # At_r # Odo_r) ; In_c<u>",
            "f_World(r) = r+u",
            "Go'_g = In_p<z> ; Neq_{z,g} ; Out_{c,if norm(z-g) > v then (g*v-v*z)/norm(z-g) else g-z}",
            "flow      f(rx,ry) = if norm((rx-3,ry-4)) > v then (rx-(rx*v-3*v)/norm((rx-3,ry-4)),ry-(ry*v-4*v)/norm((rx-3,ry-4))) else (3,4)",
            "again     while (rx,ry) != (3,4) after the round",
            "then      to phase 2 with rx = 3, ry = 4 if (rx,ry) = (3,4) after the round",
            "port p    (rx,ry) after the round",
            "-> phase 1, lasting 1 if (rx,ry) != (3,4) after the round",
        ],
    );
    // The components of a vector that differ stay what they are.
    let turned = "proc W_r = (Delay_1 # At_r) ; In_c<u> ; W_{(part(r,2),part(r,1)+part(u,1))}\n\
        proc C = Out_{c,(1,0)} ; C\nsystem S = W_{(0,0)} | C\nperiod S\n";
    says(turned, &["W'_r = (Delay_1 # At_r) ; In_c<u>", "f_W(r) = (part(r,2),part(u,1)+part(r,1))"]);
}

#[test]
fn motion_along_a_line_of_the_plane_has_a_closed_form_from_any_start() {
    let until = "n = ceil(norm((rx0-3,ry0-4))/v)";
    says(
        &walk("flow Sys\n"),
        &[
            &format!(
                "closed    rx = rx0-(n*rx0*v-3*n*v)/norm((rx0-3,ry0-4)) from n = 0 until {until} if norm((rx0-3,ry0-4)) > 0"
            ),
            &format!("closed    ry = 4 from {until} if norm((rx0-3,ry0-4)) > 0"),
        ],
    );
    says(
        &walk("property Goal = Delay_{?a} ; (Delay_1 # At_{(3,4)})\nprove Sys satisfies Goal\n"),
        &["with ?a = ceil(5/v)", "closed    rx = 3/5*i*v from i = 0 until i = ceil(5/v)"],
    );
    // A distance that is no rational number.
    let other = walk(
        "system Other = World_{(3,-8)} | Go_{(1,0)}\nproperty Goal = Delay_{?a} ; (Delay_1 # At_{(1,0)})\nprove Other satisfies Goal\n",
    );
    says(&other, &["with ?a = ceil(2*sqrt(17)/v)", "closed    ry = 0 from i = ceil(2*sqrt(17)/v)"]);
    // Along an axis, where one component stays what it is.
    let down = walk(
        "system Down = World_{(0,0)} | Go_{(0,-4)}\nproperty Goal = Delay_{?a} ; (Delay_1 # At_{(0,-4)})\nprove Down satisfies Goal\n",
    );
    says(&down, &["with ?a = ceil(4/v)", "closed    ry = -4 from i = ceil(4/v)"]);
}

#[test]
fn every_component_is_counted_in_one_period() {
    let parts = "proc A = Delay_1 ; Out_{c,0} ; A\nproc B = In_c<x> ; In_c<y> ; B\nproc D = Delay_3 ; D\n";
    says(&format!("{parts}system S = A | B | D\nperiod S\n"), &["rounds: A 6, B 3, D 2", "lasting: 6"]);
    says(&format!("{parts}system T = A | B\nperiod T\n"), &["rounds: A 2, B 1", "lasting: 2"]);
}

#[test]
fn a_port_may_carry_numbers_in_one_system_and_vectors_in_another() {
    let text = "proc K_r = Out_{p,(r,r)} ; Delay_1 ; K_{r+1}\nproc L = In_p<x> ; L\nsystem C = K_0 | L\n\
        proc X_r = (Delay_1 # Y_r # At_r) ; In_w<u> ; X_{r+u}\nproc Y_r = Out_{p,r} ; Y_r\n\
        proc Z = In_p<r> ; Out_{w,1-r/2} ; Z\nsystem A = X_0 | Z\nperiod A\nperiod C\n";
    says(text, &["phase 1: Delay_1 # At_r", "phase 1: Delay_1"]);
}

#[test]
fn what_would_have_to_be_known_is_said_of_what_is_open() {
    let gain = "param k > 0, k < 2\nsolve r(n+1) = r(n)+k*(5-r(n)), r(0) = 0 find n with r(n) = 5\n";
    says(gain, &["if k = 1:", "if k != 1:", "r(n) = 5-5*(1-k)^n", "never r(n) = 5: -5*(1-k)^n = 0 for no n"]);
    let shorter = "proc H_x = Delay_x ; H_{x/2}\nproc L = Delay_1 ; L\nsystem S = H_1 | L\nperiod S\n";
    let longer = "no period found: after 300 phases the delays that remain (H of about 10^(-90), L of about 10^(-90)) have not \
        repeated; with variables for the durations: in H: the duration 1/2*x may be negative";
    says(shorter, &[longer]);
    let quotient = "solve x(n+1) = (2*x(n)+1)/(x(n)+1), x(0) = 1\n";
    says(
        quotient,
        &[
            "no closed form is known: no form of x(n) without roots was found; it is u(n)/v(n), where u(n+1) = 2*u(n)+v(n), u(0) = 1, v(n+1) = u(n)+v(n), v(0) = 1",
        ],
    );
    let asked = "observer Done\nproc M = Ran_{Exp(rate: 1)}<y> ; Delay_y ; Done\nsystem T = M\n\
        property P = Delay_{?t} ; Done\nprove T satisfies P with probability >= 9/10\n";
    never_says(asked, "not exact: the time");
    // What was shown once is not said never to have been shown.
    let once = "proc A = (Delay_1 # At_21) ; B\nproc B = (Delay_1 # At_3) ; B\nsystem S = A\n\
        property G = Delay_{?a} ; (Delay_{?b} # At_21) ; Delay_{?c} ; G\nprove S satisfies G\n";
    let why = "it does not: At_21 is not shown again: phase 2 never ends, its values repeat for ever";
    says(once, &[why]);
}

#[test]
fn a_clearance_on_a_run_that_only_goes_on_is_repaired() {
    let text = "observer Rock(q)\nparam apart = 1\n\
        proc Away_{r,o} = (Delay_1 # Near_r # Far_o # At_r # Rock_o) ; In_v<u> ; Away_{r+u,o+1/4}\n\
        proc Near_r = Out_{p,r} ; Near_r\nproc Far_o = Out_{b,o} ; Far_o\n\
        proc Follow = (In_p<r> | In_b<o>) ; ((Gtr_{o-r,apart} ; Out_{v,1}) | (Lte_{o-r,apart} ; Out_{v,0})) ; Follow\n\
        system Trail = Away_{0,4} | Follow\ncriteria Behind for Trail { clearance 1 between At, Rock }\n";
    // Gaps go 4, 13/4, …, 1 and come back by quarters: any smaller margin lets the gap of 3/2 shrink to 3/4.
    let repair = "try: clearance: apart = 3/2 in place of 1 gives clearance = 1, margin 0; with a change that is smaller by less than 1/1000000 it is not met";
    says(text, &[repair]);
}

#[test]
fn a_simulation_takes_what_is_equal_for_equal_and_has_as_many_runs_as_are_asked_for() {
    // The difference is 0 in every run: no rounding may make it less.
    let two = "observer Pair(x)\nproc Start = Ran_{Normal(0, sd: 1)}<s> ; Twin_{s,s/3}\n\
        proc Twin_{a,b} = (Delay_1 # Pair_{a-3*b}) ; In_v<u> ; Twin_{a+u,b+u/3}\nproc Push = Out_{v,1/10} ; Push\n\
        system Two = Start | Push\n\
        probability of Two showing Pair_x where x >= 0 at 5 by estimated with 2000 runs seed 3\n";
    let chance = "probability 0.999, between 0.9973543472409907 and 1 (estimated)";
    says(two, &[chance, "2000 runs, seed 3, confidence 0.99"]);
    // What no run does is no share, and how many more runs it would take follows from how many there were.
    let rare = "observer Done\nproc Rare = Ran_{Exp(rate: 1/1000)}<x> ; (Delay_x | Delay_{x/2}) ; Done\nsystem Late = Rare\n\
        prove probability of Late reaching Done within 1/100 <= 1/1000 by estimated\n";
    let work = "1/1000 lies between 0 and 0.0013237024736240137: it would take some 5296 runs to tell them apart, if all end \
        as these did";
    says(rare, &["probability at most 0.0013237024736240137, between 0 and 0.0013237024736240137 (estimated)", work]);
}

#[test]
fn a_limited_speed_in_the_plane_is_simulated_and_a_likelier_deadline_is_found() {
    let sea = "observer Done\nproc Sea_r = (Delay_1 # Odo_r # At_r) ; In_v<u> ; Ran_{Normal(0, sd: 1/10)}<x> ; \
        Ran_{Normal(0, sd: 1/10)}<y> ; Sea_{r+u+(x,y)}\nproc Odo_r = Out_{p,r} ; Odo_r\n\
        fn lim(d) = if norm(d) > 1 then unit(d) else d\n\
        proc Go_g = In_p<z> ; Gtr_{norm(z-g),1/5} ; Out_{v,lim(g-z)} ; Go_g\nsystem S = Sea_{(0,0)} | (Go_{(3,0)} ; Done)\n\
        probability of S reaching Done within 5 by estimated with 150 runs seed 1\n";
    says(sea, &["150 runs of the executable meaning, seed 1, confidence 0.99"]);
    // Of 1,000,000 runs 0.4769 have gone beyond 2 by 14, and 0.5063 by 15.
    let walk = "proc World_r = (Delay_1 # At_r) ; Ran_{Normal(1/10, sd: 1/2)}<e> ; World_{r+e}\nsystem S = World_0\n\
        criteria C for S { probability of reaching At_p where p > 2 within 10 >= 1/2 }\n";
    says(walk, &["try: probability: or ask for a deadline of 15"]);
    let open = walk.replace("sd: 1/2", "sd: s").replace("proc World", "param s > 0\nproc World");
    says(&open, &["`s` has no value, and a chance is computed where every parameter that matters is a number:"]);
}

#[test]
fn what_machine_numbers_cannot_tell_apart_is_followed_exactly_or_said() {
    let thirds = "proc Start = Ran_{Uniform(0,1/2)}<e> ; World_e\nproc World_r = (Delay_1 # At_r) ; World_{r+(1-r)/3}\n\
        system S = Start\n";
    let asked = |time: u64| {
        format!("{thirds}probability of S reaching At_x where x >= 1 within {time} by estimated with 200 runs\n")
    };
    let never = "probability at most 0.026143762983521265, between 0 and 0.026143762983521265 (estimated)";
    says(&asked(200), &[never]);
    let why =
        "not estimated: numbers next to each other could not be told apart: the exact numbers of a run grow too long";
    says(&asked(3_000), &[why]);
    // A robot that goes half of what is left in each step never stands there.
    let halves = "observer Done\nproc World_r = (Delay_1 # Odo_r # At_r) ; In_v<u> ; World_{r+u}\n\
        proc Odo_r = Out_{p,r} ; Odo_r\nproc Go = In_p<z> ; Neq_{z,10} ; Out_{v,(10-z)/2} ; Go\n\
        proc Start = Ran_{Uniform(0,1)}<e> ; World_e\nsystem Halving = Start | (Go ; (Idle # Done))\n\
        probability of Halving reaching Done within 45 by estimated with 200 runs\n\
        probability of Halving reaching Done within 60 by estimated with 200 runs\n";
    let never = "probability at most 0.026143762983521265, between 0 and 0.026143762983521265 (estimated)";
    says(halves, &[never, never]);
}

#[test]
fn a_spread_that_runs_below_0_is_none() {
    let script = "proc N_{r,k} = (Delay_1 # At_r) ; Ran_{Normal(0, sd: 1-k)}<e> ; N_{r+e,k+1}\nsystem T = N_{0,0}\n\
        probability of T showing At_p where p > 1 at 5\n";
    says(script, &["not estimated: Normal needs a spread that is not negative"]);
    // One that is squared runs as before.
    let script = "proc N_{r,k} = (Delay_1 # At_r) ; Ran_{Normal(0, sd: abs(1-k))}<e> ; N_{r+e,k+1}\nsystem T = N_{0,0}\n\
        probability of T showing At_p where p > 100 at 5 by estimated with 100 runs\n";
    says(script, &["100 runs of the executable meaning, seed 1, confidence 0.99"]);
}

#[test]
fn the_imaginary_unit_is_called_as_nothing_else_is() {
    says(
        "param i\nsolve x(n+2) = x(n+1)-x(n)+i, x(0) = i, x(1) = 0\n",
        &["x(n) = i + 2*Re(1/3*i*sqrt(3)*j*(1/2+1/2*sqrt(3)*j)^n)"],
    );
    says(
        "solve x(i+2) = x(i+1)-x(i), x(0) = 1, x(1) = 0\n",
        &["x(i) = 2*Re((1/2+1/6*sqrt(3)*j)*(1/2+1/2*sqrt(3)*j)^i)"],
    );
}

/// Where a condition excludes a division, the test that reads it says nothing of the divisor: it holds at k = 0 too.
#[test]
fn a_test_of_what_may_be_divided_leaves_no_way_out() {
    let script = "param k >= 0\nobserver Z(v)\nfn far(y) = if y > 0 then 1/y else 5\n\
        proc A_q = (Delay_1 # Z_q) ; In_c<y> ; ((Gtr_{far(y),3} ; ((Neq_{y,0} ; Delay_1) | (Eq_{y,0} ; Delay_7))) | \
        (Lte_{far(y),3} ; Delay_2)) ; A_y\nproc B = Out_{c,k} ; B\nsystem Sys = A_0 | B\nperiod Sys\n";
    says(script, &["-> phase 1, lasting 8 if (if k > 0 then 1/k else 5) > 3 and k = 0: (Delay_1 # Z_q) ; Delay_7"]);
}

#[test]
fn why_drawn_times_are_not_told_apart_is_said_in_the_names_of_the_text() {
    let script = "observer Done\nproc A = Ran_{Exp(rate: 1)}<x> ; Delay_x\nproc B = Ran_{Uniform(1,3)}<y> ; Delay_{1/(y-2)}\n\
        system S = (A | B) ; Done\nprobability of S reaching Done within 1\n";
    says(script, &["note: neither exact nor enclosed: it must be known whether max(0,1/(y-2)) > 0"]);
}

/// Factorials below a fraction inside of a sum are written as such.
#[test]
fn factorials_stand_below_fractions_in_sums() {
    let script = "solve x(n+1) = (n+2)*x(n)+1/n!, x(0) = 1\n";
    says(script, &["x(n) = (n+1)! + (n+1)!*sum(k=0..n-1, (3*k+k^2+2)/(k+2)!^2)"]);
}
