//! Controllers with a gain and a limit: at the limit first, then closer by a ratio in each step.

mod common;

use common::ran;

/// The lines that are told.
fn told(asked: &str) -> String {
    String::from_utf8_lossy(&ran(asked).stdout).into_owned()
}

#[test]
fn when_a_limited_gain_comes_near_its_goal_is_told_in_each_case() {
    let told =
        told("param v > 0, g > 0, e > 0\nsolve x(n+1) = x(n)+min(v,(g-x(n))/2), x(0) = 0 find n with g-x(n) <= e\n");
    for line in [
        "x(n) = g+(1/2)^(n-floor(g/v)+1)*(v*floor(g/v)-g-v) for floor(g/v)-1 <= n",
        "n = max(ceil((g-e)/v),0) is the first with g-x(n) <= e",
        "n = floor(g/v)-1 is the first with g-x(n) <= e",
        "n = ceil(log(e/(mod(g,v)+v))/log(1/2))+floor(g/v)-1 is the first with g-x(n) <= e",
        "n = if g <= e then 0 else ceil(log(e/g)/log(1/2)) is the first with g-x(n) <= e",
    ] {
        assert!(told.contains(line), "{line}: {told}");
    }
    assert!(!told.contains("not known"), "{told}");
    these_are_what_a_run_shows();
    these_are_what_numbers_give();
}

/// The index that these cases tell, as a program would compute it from the four lines above.
fn index(v: f64, g: f64, e: f64) -> f64 {
    let fallen = |far: f64| (e / far).log(0.5).ceil().max(0.0);
    if g < 2.0 * v {
        return if g <= e { 0.0 } else { fallen(g) };
    }
    let begins = (g / v).floor() - 1.0;
    let away = g - begins * v;
    if (g / v).floor() + ((e - g) / v).floor() > 1.0 {
        ((g - e) / v).ceil().max(0.0)
    } else if away <= e {
        begins
    } else {
        begins + fallen(away)
    }
}

fn these_are_what_a_run_shows() {
    for place in 0..400 {
        let [v, g, e] = [(17, 41), (23, 107), (29, 61)].map(|(by, most)| f64::from(1 + place * by % most) / 8.0);
        // A bound that is met just where it is a power is a matter of rounding here.
        let e = e / 3.0;
        let (mut x, mut n) = (0.0, 0.0);
        while g - x > e {
            x += f64::min(v, (g - x) / 2.0);
            n += 1.0;
        }
        assert_eq!(index(v, g, e), n, "v = {v}, g = {g}, e = {e}");
    }
}

/// The same index as is found where all are numbers.
fn these_are_what_numbers_give() {
    let choices: Vec<[i64; 3]> =
        (0..12).map(|place| [1 + place * 5 % 9, 3 + place * 13 % 47, 1 + place * 7 % 19]).collect();
    let asked: Vec<String> = choices
        .iter()
        .map(|[v, g, e]| format!("solve x(n+1) = x(n)+min({v},({g}-x(n))/2), x(0) = 0 find n with {g}-x(n) <= {e}/3\n"))
        .collect();
    let told = told(&asked.concat());
    let found: Vec<f64> =
        told.lines().filter_map(|line| line.trim().strip_prefix("n = ")?.split(' ').next()?.parse().ok()).collect();
    let wanted: Vec<f64> =
        choices.iter().map(|one| one.map(|number| number as f64)).map(|[v, g, e]| index(v, g, e / 3.0)).collect();
    assert_eq!(found, wanted, "{told}");
}

#[test]
fn a_gain_that_is_a_parameter_is_told_without_written_out_powers() {
    let told =
        told("param k > 0, k < 1\nsolve x(n+1) = x(n)+clamp(k*(10-x(n)),-1,1), x(0) = 0 find n with x(n) >= 9\n");
    for line in [
        "x(n) = (1-k)^(n+ceil(1/k)-11)*(floor(-1/k)+1)+10 for floor(-1/k)+11 <= n",
        "n = ceil(log(1/10)/log(1-k)) is the first with x(n) >= 9",
        "n = ceil(log(1/(ceil(1/k)-1))/log(1-k))+floor(-1/k)+11 is the first with x(n) >= 9",
    ] {
        assert!(told.contains(line), "{line}: {told}");
    }
    assert!(!told.contains("k^2") && !told.contains("not known"), "{told}");
}
