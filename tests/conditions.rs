//! What parameters must be: conditions that are learned from instances, checked, and said under a claim that some break.

mod common;

/// What the program advises about a script.
fn advice(script: &str) -> Vec<String> {
    let told = String::from_utf8_lossy(&common::ran(script).stdout).into_owned();
    told.lines().filter_map(|line| line.trim().strip_prefix("try: ")).map(str::to_string).collect()
}

/// The paper's robot that keeps clear of a rock, with its sensor, whose sample is one period old; some of it in symbols.
fn robot(parameters: &str, sensor: &str, speed: &str) -> String {
    format!(
        "observer Rock(q)
param {parameters}
fn s(e) = if e > 0 then {speed} else -{speed}
proc Env_r        = (Delay_t # Odo_r # Obs_d # At_r # Rock_d) ; In_v<u> ; Env_{{r+u*t}}
proc Odo_r        = Out_{{p,r}} ; Odo_r
proc Obs_q        = Out_{{b,q}} ; Obs_q
proc Sensor_c     = (In_b<q> | In_p<r>)
                  ; ((Lte_{{|r-q|,c}} ; Out_{{near,q}}) | (Gtr_{{|r-q|,c}} ; Out_{{near,r+2*c}})) ; Sensor_c
proc MoveTo_{{g,h}} = (In_p<r> | In_near<q>) ; Neq_{{r,g}}
                  ; ((Gtr_{{|r-q|,h}} ; Out_{{v,s(g-r)}}) | (Lte_{{|r-q|,h}} ; Out_{{v,s(r-q)}})) ; MoveTo_{{g,h}}
system Sys = Env_0 | Sensor_{sensor} | MoveTo_{{10,h}}
prove Sys always |p-o| > 1 when At_p, Rock_o
"
    )
}

fn proved_if(condition: &str) -> Vec<String> {
    vec![format!("it is proved if {condition}, the weakest condition found")]
}

#[test]
fn the_papers_robot_with_a_margin_in_symbols() {
    // The sensor sees 3 far, a step of 1/2 before it counts.
    assert_eq!(advice(&robot("h > 0, d = 5, t = 1/2", "3", "1")), proved_if("h >= 3/2 and h <= 5/2"));
}

#[test]
fn the_papers_robot_with_margin_period_and_sensor_in_symbols() {
    assert_eq!(advice(&robot("h > 0, t > 0, d = 5, c > 0", "c", "1")), proved_if("h >= t+1 and c >= h+t"));
}

#[test]
fn the_papers_robot_with_the_place_of_the_rock_in_symbols() {
    let script = robot("h > 0, t = 1/2, d > 0, c > 0", "c", "1");
    assert_eq!(advice(&script), proved_if("d > 1 and h >= 3/2 and c >= h+1/2"));
}

#[test]
fn what_is_advised_is_proved_when_it_is_declared() {
    let with = robot("t > 0, d = 5, h >= t + 1, c >= h + t", "c", "1") + "expect proved\n";
    assert!(advice(&with).is_empty());
    // A step more than the margin allows is refuted.
    let without = robot("t > 0, d = 5, h > 1, h < t + 1, c >= h + t", "c", "1") + "expect refuted\n";
    assert!(!advice(&without).iter().any(|line| line.starts_with("it is proved if h < ")));
}

#[test]
fn a_factor_that_is_positive_is_left_out_and_the_larger_side_comes_first() {
    let script = "observer Gap(g)
param a > 0, w > 0, h > 0
proc World_g = (Delay_1 # Odo_g # Gap_g) ; In_c<u> ; World_{g-u}
proc Odo_g = Out_{p,g} ; Odo_g
proc Go = In_p<g> ; ((Gtr_{g,h} ; Out_{c,w}) | (Lte_{g,h} ; Out_{c,0})) ; Go
param g0 >= h
system Sys = World_g0 | Go
prove Sys always g >= a when Gap_g
";
    assert_eq!(advice(script), proved_if("h >= a+w"));
}
