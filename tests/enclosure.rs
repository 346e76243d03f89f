//! Every enclosed interval holds the truth: closed forms, other methods, and inputs made to break it.

use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::{One, Signed};

use pars::interval::Interval;
use pars::probability::chain::Chain;
use pars::probability::estimated::estimated;
use pars::probability::grid::gauss;
use pars::probability::{Question, enclosed, exact};

#[path = "probability/load.rs"]
mod load;

use load::load;

fn try_enclose((chain, question): &(Chain, Question)) -> Result<Interval, String> {
    enclosed::enclosed(chain, question, 1e-9).map(|found| found.interval())
}

fn enclose(asked: &(Chain, Question)) -> Interval {
    try_enclose(asked).expect("enclosed")
}

/// The waypoint with other numbers: noise of the motion, of the look, the gain, the start, the goal, the time.
fn waypoint(motion: &str, look: &str, gain: &str, start: &str, tolerance: &str, time: &str) -> (Chain, Question) {
    load(&format!(
        "proc Env_r = (Delay_{{1/5}} # Odo_r # At_r) ; (Ran_{{Normal(0, sd: {motion})}}<e> | In_v<u>) ; Env_{{r+(u+e)/5}}
proc Odo_r = Ran_{{Normal(0, sd: {look})}}<w> ; Out_{{p,r+w}} ; Odo_r
proc Go_g  = In_p<m> ; Gtr_{{|m-g|,{tolerance}}} ; Out_{{v,({gain})*(g-m)}} ; Go_g
system Sys = Env_{{{start}}} | (Go_10 ; Done)
prove probability of Sys reaching Done within {time}"
    ))
}

/// Holds what a simulation says, which errs in one of a hundred.
fn agrees(asked: &(Chain, Question), found: Interval, runs: u64) {
    let estimate = estimated(&asked.0, &asked.1, runs, 11).expect("runs");
    let slack = (estimate.high - estimate.low) / 2.0;
    assert!(found.low <= estimate.high + slack && found.high >= estimate.low - slack, "{estimate:?} {found:?}");
    assert!(found.width() < 1e-5, "{found:?}");
}

#[test]
fn gains_of_every_size_and_sign() {
    // 1/2 is the waypoint; 5 gives 0 at once, from 10 on the position swings ever further, below 0 it runs away.
    for gain in ["1/10", "1/2", "5", "9", "10", "21/2", "12", "-1/10", "-1"] {
        let asked = waypoint("1/2", "1/10", gain, "9", "1/10", "4");
        match try_enclose(&asked) {
            Ok(found) => agrees(&asked, found, 4_000),
            Err(reason) => assert!(reason.contains("reach too far") || reason.contains("too much"), "{gain}: {reason}"),
        }
    }
}

#[test]
fn at_the_goal_and_with_no_round() {
    // P(|w| <= 1/10) for a standard deviation of 1/10.
    let inside = 0.682_689_492_137_085_9;
    let now = enclose(&waypoint("1/2", "1/10", "1/2", "10", "1/10", "0"));
    assert!(now.holds(inside) && now.width() < 1e-13, "{now:?}");
    // Spreads far below and above everything else.
    for (spread, width) in [("1/10^160", "1/10^160"), ("1/10^9", "1/10^9"), ("10^9", "10^9"), ("10^150", "10^150")] {
        let now = enclose(&waypoint("1/2", spread, "1/2", "10", width, "0"));
        assert!(now.holds(inside) && now.width() < 1e-13, "{spread}: {now:?}");
    }
    // A look without noise, and motion without noise: certain.
    let still = enclose(&waypoint("0", "0", "1/2", "10", "1/10", "5"));
    assert_eq!(still, Interval::exactly(1.0));
    // Nothing in the look: the guard cuts the position itself.
    let clear = waypoint("1/2", "0", "1/2", "9", "1/10", "3");
    agrees(&clear, enclose(&clear), 4_000);
    // Nothing in the motion but what the looks make of it: position and next position fix the look.
    let given = waypoint("0", "1/10", "1/2", "9", "1/10", "3");
    agrees(&given, enclose(&given), 4_000);
}

#[test]
fn spreads_of_every_size() {
    for (motion, look) in
        [("1/100", "1/10"), ("1/2", "1/100"), ("5", "1/10"), ("1/2", "2"), ("1/10^6", "1/10"), ("1/2", "1/10^7")]
    {
        let asked = waypoint(motion, look, "1/2", "9", "1/10", "3");
        match try_enclose(&asked) {
            Ok(found) => agrees(&asked, found, 4_000),
            Err(reason) => {
                assert!(reason.contains("reach too far") || reason.contains("too much"), "{motion} {look}: {reason}")
            }
        }
    }
}

/// One draw each round, added; success where a sum exceeds a level. Reached at the end of the first round alone, the
/// chance is that of one draw.
fn sums(draw: &str, level: &str, time: &str) -> (Chain, Question) {
    load(&format!(
        "proc Env_r = (Delay_1 # At_r) ; (Ran_{{{draw}}}<e> | In_v<u>) ; Env_{{r+u+e}}
proc Go = Out_{{v,0}} ; Go
system Sys = Env_0 | Go
prove probability of Sys reaching At_p where p > {level} within {time}"
    ))
}

#[test]
fn chances_near_nothing_and_near_certainty() {
    // 1 - Φ(7.034483825307) = 1e-12: one sum, by the normal distribution in 40 digits elsewhere.
    let rare = enclose(&sums("Normal(0, sd: 1)", "7.034483825307", "1"));
    assert!(rare.low < 1.000_001e-12 && rare.high > 0.999_999e-12 && rare.width() < 1e-15, "{rare:?}");
    let sure = enclose(&load(
        "proc Env_r = (Delay_1 # At_r) ; (Ran_{Normal(0, sd: 1)}<e> | In_v<u>) ; Env_{r+u+e}
proc Go = Out_{v,0} ; Go
system Sys = Env_0 | Go
prove probability of Sys showing At_p where p > -7.034483825307 at 1",
    ));
    assert!(sure.holds(1.0 - 1e-12) && sure.width() < 1e-13, "{sure:?}");
    // Two draws, the first alone or the sum: P = 1 - P(x <= a, x + y <= a), here at a = 0: 1 - 3/8.
    let two = enclose(&sums("Normal(0, sd: 1)", "1/1000000000000", "2"));
    assert!(two.low < 0.625 + 1e-9 && two.high > 0.625 - 1e-9 && two.width() < 1e-7, "{two:?}");
}

#[test]
fn equal_and_unequal_parts_of_a_mixture() {
    let one = enclose(&sums("Normal(0, sd: 1)", "2", "6"));
    let parts = enclose(&sums("Mix(1/3: Normal(0, sd: 1), 2/3: Normal(0, sd: 1))", "2", "6"));
    assert!(one.low <= parts.high && parts.low <= one.high, "{one:?} {parts:?}");
    let asked = sums("Mix(9/10: Normal(0, sd: 1), 1/10: Normal(-3, sd: 1/10))", "2", "6");
    agrees(&asked, enclose(&asked), 4_000);
}

#[test]
fn what_is_no_normal_number_is_enclosed_where_it_has_a_density() {
    for draw in ["Uniform(0, 1)", "Exp(rate: 2)", "Mix(1/4: Uniform(0, 1), 3/4: Exp(rate: 2))"] {
        let asked = sums(draw, "2", "6");
        let found = enclose(&asked);
        let estimate = estimated(&asked.0, &asked.1, 40_000, 11).expect("runs");
        assert!(found.low <= estimate.high && found.high >= estimate.low, "{draw}: {estimate:?} {found:?}");
        assert!(found.width() < 1e-2, "{draw}: {found:?}");
    }
    for draw in ["Mix(1/2: Point(1), 1/2: Uniform(0, 1))", "Mix(1/2: Normal(0, sd: 1), 1/2: Poisson(rate: 1))"] {
        assert!(try_enclose(&sums(draw, "2", "6")).is_err(), "{draw}");
    }
}

#[test]
fn what_is_shown_on_one_way_alone() {
    let asked = load(
        "proc Env_r = (Ran_{Normal(0, sd: 1)}<e> | In_v<u>) ; (Gtr_{e,1} ; (Delay_1 # At_r) | Lte_{e,1} ; Delay_1) ; Env_{r+e}
proc Go = Out_{v,0} ; Go
system Sys = Env_0 | Go
prove probability of Sys reaching At_p where p >= 0 within 3",
    );
    if let Ok(found) = try_enclose(&asked) {
        agrees(&asked, found, 4_000);
    }
}

#[test]
fn what_happens_before_the_first_round_takes_its_time() {
    let asked = load(
        "proc Start = Ran_{Normal(0, sd: 1)}<x> ; (Gtr_{x,0} ; Delay_100 ; Done | Lte_{x,0} ; Env_0)
proc Env_r = (Delay_1 # At_r) ; (Ran_{Normal(0, sd: 1)}<e> | In_v<u>) ; Env_{r+u+e}
proc Go = Out_{v,0} ; Go
system Sys = Start | Go
prove probability of Sys reaching Done within 10",
    );
    if let Ok(found) = try_enclose(&asked) {
        agrees(&asked, found, 4_000);
    }
}

#[test]
fn both_methods_agree_at_a_time() {
    // At a time nothing is cut: the exact method knows the chance too.
    for (mean, sd, time) in [("1", "1/50", "10"), ("0", "1", "30"), ("-1/7", "3", "5")] {
        let asked = load(&format!(
            "proc Env_r = (Delay_1 # At_r) ; (Ran_{{Normal({mean}, sd: {sd})}}<e> | In_v<u>) ; Env_{{r+u+e}}
proc Go = Out_{{v,0}} ; Go
system Sys = Env_0 | Go
prove probability of Sys showing At_p where |p-10| <= 3/10 at {time}"
        ));
        let (other, found) = (exact::exact(&asked.0, &asked.1).expect("exact").chance, enclose(&asked));
        assert!(found.low <= other.low && other.high <= found.high && found.width() < 1e-8, "{found:?} {other:?}");
    }
}

/// The value of Legendre's polynomial at a rational, and of the one below it.
fn legendre(degree: i64, place: &BigRational) -> (BigRational, BigRational) {
    let (mut before, mut now) = (BigRational::one(), place.clone());
    let whole = |number: i64| BigRational::from_integer(BigInt::from(number));
    for degree in 2..=degree {
        let next = (whole(2 * degree - 1) * place * &now - whole(degree - 1) * &before) / whole(degree);
        (before, now) = (now, next);
    }
    (now, before)
}

#[test]
fn the_points_of_the_rule_are_roots_and_the_weights_fit() {
    let rule = gauss();
    let exact = |number: f64| BigRational::from_float(number).expect("finite");
    let count = i64::try_from(rule.len()).expect("few");
    for (place, weight) in rule {
        let (low, high) = (exact(place - 4e-16), exact(place + 4e-16));
        let (left, right) = (legendre(count, &low).0, legendre(count, &high).0);
        assert!((left * right).is_negative(), "no root near {place}");
        // One step of Newton's method from there, without rounding; then w = 2 (1 - x²) / (n P_(n-1)(x))².
        let (here, before) = legendre(count, &exact(place));
        let one = BigRational::one();
        let degree = BigRational::from_integer(count.into());
        let slope = &degree * (exact(place) * &here - before) / (exact(place) * exact(place) - &one);
        let root = exact(place) - here / slope;
        let factor = degree * legendre(count, &root).1;
        let wanted = BigRational::from_integer(2.into()) * (&one - &root * &root) / (&factor * &factor);
        let off = (exact(weight) - &wanted) / wanted;
        // Within what the bound on the kernel allows.
        assert!(off.abs() < exact(3.9e-13), "{place}");
    }
    let total: BigRational = rule.iter().map(|(_, weight)| exact(*weight)).sum();
    assert!((total - BigRational::from_integer(2.into())).abs() < exact(1e-14));
}

/// Position and odometry as they move in a round: the noise that is added to each beside the command, how the odometry is
/// looked at, how the position is shown while it waits for the next command and before, where both begin.
fn drifting(position: &str, odometry: &str, look: &str, before: &str, start: &str, asked: &str) -> (Chain, Question) {
    load(&format!(
        "proc Env_{{r,q}} = (Delay_1 # Odo_q {before}) ; (Ran_{{Normal(0, sd: 1/5)}}<e> | Ran_{{Normal(0, sd: 1/5)}}<f> | \
(In_v<u> # At_r)) ; Env_{{r+u+{position},q+u+{odometry}}}
proc Odo_q = {look} ; Odo_q
proc Go_g = In_p<m> ; Gtr_{{|m-g|,1/10}} ; Out_{{v,(g-m)/2}} ; Go_g
system Sys = Env_{{{start}}} | (Go_2 ; Done)
prove probability of Sys {asked}"
    ))
}

const NOISY: &str = "Ran_{Normal(0, sd: 1/10)}<w> ; Out_{p,q+w}";
const EXACT: &str = "Out_{p,q}";

#[test]
fn position_and_drifting_odometry_are_followed_together() {
    // By 4,000,000 runs elsewhere and more, within three standard deviations.
    let near = "showing At_r where |r-2| <= 1/10 at";
    let missions = [
        (drifting("e", "e+f", EXACT, "# At_r", "1,1", "reaching Done within 4"), 0.527_659, 8e-4),
        (drifting("e", "e+f", EXACT, "", "1,1", &format!("{near} 4")), 0.103_334, 4e-4),
        (drifting("e", "e+f", EXACT, "", "1,1", "showing At_r where r <= 2 at 6"), 0.393_716, 6e-4),
        (drifting("e", "e", NOISY, "", "1,11/10", &format!("{near} 5")), 0.210_732, 5e-4),
        (drifting("e", "0*f", NOISY, "", "1,1", &format!("{near} 5")), 0.161_355, 5e-4),
    ];
    for (number, (asked, wanted, off)) in missions.iter().enumerate() {
        let found = enclose(asked);
        assert!(found.low - off <= *wanted && *wanted <= found.high + off, "{number}: {found:?}");
        assert!(found.width() < 1e-6, "{number}: {found:?}");
    }
    // What is not followed is refused, with the reason.
    for asked in [
        drifting("e", "e+f", NOISY, "# At_r", "1,1", &format!("{near} 4")),
        drifting("0*e", "f", NOISY, "# At_r", "1,1", &format!("{near} 4")),
    ] {
        let reason = try_enclose(&asked).expect_err("refused");
        assert!(reason.contains("share their noise with both dimensions"), "{reason}");
    }
}

#[test]
fn a_constant_command_has_noise_of_both() {
    // By 4,000,000 runs elsewhere, within three standard deviations.
    let asked = [
        ("reaching Done within 5", 0.856_561, 6e-4),
        ("showing At_r where |r-1| <= 1/10 at 5", 0.266_286, 7e-4),
        ("reaching At_r where r >= 1 within 4", 0.454_871, 8e-4),
    ];
    for (asked, wanted, off) in asked {
        let found = enclose(&load(&format!(
            "proc Odo_q = Ran_{{Normal(0, sd: 1/10)}}<w> ; Out_{{p,q+w}} ; Odo_q
proc Env_{{r,q}} = (Delay_1 # Odo_q # At_r) ; (Ran_{{Normal(0, sd: 1/10)}}<e> | Ran_{{Normal(0, sd: 1/10)}}<f> | \
(In_v<u> # At_r)) ; Env_{{r+u+e,q+u+f}}
proc Go_g  = In_p<m> ; Lss_{{m,g}} ; Out_{{v,1/4}} ; Go_g
system Sys = Env_{{0,0}} | (Go_1 ; Done)
prove probability of Sys {asked}"
        )));
        assert!(found.low - off <= wanted && wanted <= found.high + off && found.width() < 1e-6, "{asked}: {found:?}");
    }
}

/// The noisy environment of the paper: the goal, the tolerance of a look, the gain, the noise of the motion and of the look,
/// where position and odometry begin.
fn paper(
    goal: u32,
    tolerance: &str,
    gain: &str,
    motion: &str,
    look: &str,
    start: &str,
    asked: &str,
) -> (Chain, Question) {
    load(&format!(
        "proc NEnv_{{r,q}} = (Delay_1 # NOdo_q # At_r) ; (Ran_{{Normal(0, sd: {motion})}}<e> | (In_v<u> # At_r)) ; NEnv_{{r+u+e,q+u}}
proc NOdo_q = Ran_{{Normal(0, sd: {look})}}<w> ; Out_{{p,q+w}} ; NOdo_q
proc Go_g = In_p<m> ; Gtr_{{|m-g|,{tolerance}}} ; Out_{{v,{gain}*(g-m)}} ; Go_g
system Sys = NEnv_{{{start}}} | (Go_{goal} ; Done)
prove probability of Sys {asked}"
    ))
}

#[test]
fn the_noisy_environment_of_the_paper_ends_at_a_noisy_look() {
    // Elsewhere: the odometry alone by Chebyshev's points, with the drift, a sum of normal numbers, in closed form.
    let missions = [
        (paper(2, "1/10", "1/2", "1/50", "1/20", "0,0", "reaching Done within 8"), 0.999_878_264_08),
        (paper(2, "1/10", "1/2", "1/50", "1/20", "0,0", "showing At_r where |r-2| <= 1/10 at 5"), 0.675_957_451_85),
        (paper(1, "1/20", "1/4", "1/100", "1/25", "0,0", "showing At_r where |r-1| <= 3/50 at 12"), 0.556_541_921_56),
        (paper(1, "1/20", "1/4", "1/100", "1/25", "0,0", "reaching Done within 12"), 0.962_694_625_48),
        (
            paper(1, "1/50", "4/5", "3/100", "1/50", "1/20,0", "showing At_r where |r-1| <= 1/10 at 20"),
            0.833_550_373_37,
        ),
    ];
    for (number, (asked, wanted)) in missions.iter().enumerate() {
        let found = enclose(asked);
        assert!(found.low - 1e-9 <= *wanted && *wanted <= found.high + 1e-9, "{number}: {found:?}");
        assert!(found.width() < 1e-7, "{number}: {found:?}");
    }
    // By 4,000,000 runs elsewhere.
    let first = enclose(&paper(2, "1/10", "1/2", "1/50", "1/20", "0,0", "reaching At_r where |r-2| <= 1/20 within 8"));
    assert!((first.low - 0.404_234).abs() < 8e-4 && first.width() < 1e-7, "{first:?}");
}
