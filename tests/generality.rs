//! The paper's mission at a limited speed with nothing assumed of where it begins and goes: each case that is told is what the
//! system with numbers does.

mod common;

use common::ran;

const MISSION: &str = "fn s(d) = clamp(d/t,-v,v)
proc BF_{a,b}  = MoveTo_a ; MoveTo_b ; BF_{a,b}
proc MoveTo_g  = In_p<r> ; Neq_{r,g} ; Out_{v,s(g-r)} ; MoveTo_g
proc DEnv_r    = (Delay_t # Odo_r # At_r) ; In_v<u> ; DEnv_{r+u*t}
proc Odo_r     = Out_{p,r} ; Odo_r
system Sys     = DEnv_{p0} | BF_{a,b}
period Sys
";

fn told(parameters: &str) -> String {
    String::from_utf8_lossy(&ran(&format!("param {parameters}\n{MISSION}")).stdout).into_owned()
}

/// What takes so many rounds of a time t, if each of them moves by v*t at most.
fn rounds(from: i64, to: i64, step: i64) -> i64 {
    let distance = (from - to).abs();
    (distance + step - 1) / step
}

#[test]
fn equal_places_are_cases_and_the_sides_are_told_as_one() {
    let general = told("t > 0, v > 0, p0, a, b");
    for line in [
        "if a = b and p0 = a: after 0 in all: goes round in no time (Odo, MoveTo, BF)",
        "if a = b and p0 != a: after t*ceil(abs(a-p0)/(t*v)) in all: goes round in no time (Odo, BF, MoveTo)",
        "if a != b and p0 = a: lasting: 2*t*ceil(abs(a-b)/(t*v)) in all, as the system runs from t*ceil(abs(a-b)/(t*v)) on",
        "if a != b and p0 != a: lasting: 2*t*ceil(abs(a-b)/(t*v)) in all, as the system runs from t*ceil(abs(a-p0)/(t*v)) on",
    ] {
        assert!(general.lines().any(|other| other.trim() == line), "not said: {line}\n{general}");
    }
    for (t, v, p0, a, b) in [(1, 2, 7, 0, 5), (2, 3, -4, 9, -8), (3, 1, 0, 0, 10), (1, 1, 4, -3, 4), (2, 2, 5, 3, 3)] {
        let told = told(&format!("t = {t}, v = {v}, p0 = {p0}, a = {a}, b = {b}"));
        let lasting = 2 * t * rounds(a, b, t * v);
        let from = t * if p0 == a { rounds(a, b, t * v) } else { rounds(p0, a, t * v) };
        let wanted = match a == b {
            true => "no period: Odo, BF and MoveTo go round in no time".to_string(),
            false => format!("lasting: {lasting} in all"),
        };
        assert!(told.contains(&wanted), "{wanted}\n{told}");
        // With numbers it is told from when on it is as it was, which may be sooner.
        if let Some((_, since)) = told.split_once("in all, as the system runs from ").filter(|_| a != b) {
            let since: i64 = since.split(' ').next().and_then(|time| time.parse().ok()).expect("a time");
            assert!(since <= from, "{since} and {from}\n{told}");
        }
    }
}
