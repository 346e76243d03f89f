//! Chances: distributions against an independent computation, the closed forms of the paper's systems, the noisy
//! waypoint, and each method against the others.

use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::{Signed, ToPrimitive, Zero};

use pars::distribution::Distribution;
use pars::interval::Interval;
use pars::probability::chain::Chain;
use pars::probability::estimated::{estimated, interval};
use pars::probability::{Question, enclosed, exact, normal};
use pars::value::Value;

#[path = "probability/load.rs"]
mod load;
#[path = "probability/shared.rs"]
mod shared;

use load::load;

/// `-3/4`, `0.25`, `1.5e-12`
fn rational(text: &str) -> BigRational {
    if let Some((top, bottom)) = text.split_once('/') {
        return BigRational::new(top.parse().expect("a number"), bottom.parse().expect("a number"));
    }
    let (digits, exponent) = text.split_once('e').unwrap_or((text, "0"));
    let (whole, part) = digits.split_once('.').unwrap_or((digits, ""));
    let number: BigInt = format!("{whole}{part}").parse().expect("digits");
    let power = exponent.parse::<i64>().expect("an exponent") - part.len() as i64;
    // Nothing that a machine number could hold.
    if power < -1_000 {
        return BigRational::zero();
    }
    let power = i32::try_from(power).expect("a small exponent");
    let ten = BigRational::from_integer(10.into());
    BigRational::from_integer(number) * num_traits::Pow::pow(ten, power)
}

fn distribution(words: &mut std::str::SplitWhitespace<'_>) -> Distribution {
    let kind = words.next().expect("a kind");
    if kind == "Mix" {
        let count: usize = words.next().expect("a count").parse().expect("a count");
        let part = |words: &mut std::str::SplitWhitespace<'_>| {
            let weight = rational(words.next().expect("a weight"));
            (weight, distribution(words))
        };
        return Distribution::Mixture((0..count).map(|_| part(words)).collect());
    }
    let mut number = || rational(words.next().expect("a parameter"));
    match kind {
        "Point" => Distribution::Point(number()),
        "Normal" => Distribution::Normal { mean: number(), variance: number() },
        "Uniform" => Distribution::Uniform { low: number(), high: number() },
        "Exp" => Distribution::Exponential { rate: number(), start: BigRational::zero(), rising: true },
        "Poisson" => Distribution::Poisson { mean: number() },
        other => panic!("{other}"),
    }
}

/// The intervals hold the values, which are rounded to 30 digits, and are narrow.
fn holds(found: Interval, wanted: &BigRational, line: &str) {
    let slack = wanted.abs() * rational("1e-29") + rational("1e-340");
    let (low, high) =
        (BigRational::from_float(found.low).expect("finite"), BigRational::from_float(found.high).expect("finite"));
    assert!(low <= wanted + &slack && wanted - &slack <= high, "{found:?} for {line}");
    let wide = found.high - found.low;
    let near = wanted.to_f64().expect("a number");
    assert!(wide <= 2e-11 * near || wide <= 1e-300, "{found:?} is wide for {line}");
}

#[test]
fn chances_agree_with_an_independent_computation() {
    let text = include_str!("data/distribution.txt");
    let mut count = 0;
    for line in text.lines().filter(|line| !line.starts_with('#')) {
        let parts: Vec<&str> = line.split(" | ").collect();
        let [what, bound, below, above] = parts.as_slice() else { panic!("{line}") };
        let (one, bound) = (distribution(&mut what.split_whitespace()), rational(bound));
        let (below, above) = (rational(below), rational(above));
        if below > rational("1e-300") || below.is_zero() {
            holds(one.at_most(&bound), &below, line);
        }
        if above > rational("1e-300") || above.is_zero() {
            holds(one.more_than(&bound), &above, line);
        }
        // Through the mirrored and stretched distribution, and through an interval on one side.
        if let Some(image) = one.affine(&rational("-3/2"), &rational("1/7")) {
            let mirrored = &bound * rational("-3/2") + rational("1/7");
            let chance = image.more_than(&mirrored);
            let near = BigRational::from_float(chance.high).expect("finite") + rational("1e-12");
            let point = one.between(&bound, &bound).high;
            assert!(BigRational::from_float(point).expect("finite") + near >= below, "{line}: {chance:?}");
        }
        count += 1;
    }
    assert!(count > 200);
}

#[test]
fn sums_and_images_have_the_right_moments() {
    let normal = Distribution::Normal { mean: rational("2"), variance: rational("1/4") };
    let mixed = Distribution::Mixture(vec![
        (rational("1/3"), Distribution::Normal { mean: rational("-1"), variance: rational("2") }),
        (rational("2/3"), Distribution::Point(rational("4"))),
    ]);
    let sum = normal.plus(&mixed).expect("closed");
    assert_eq!(sum.mean(), normal.mean() + mixed.mean());
    assert_eq!(sum.variance(), normal.variance() + mixed.variance());
    for one in [&normal, &mixed, &Distribution::Uniform { low: rational("0"), high: rational("3") }] {
        let image = one.affine(&rational("-2"), &rational("5")).expect("closed");
        assert_eq!(image.mean(), one.mean() * rational("-2") + rational("5"));
        assert_eq!(image.variance(), one.variance() * rational("4"));
    }
    let poisson = |mean: &str| Distribution::Poisson { mean: rational(mean) };
    assert_eq!(poisson("2").plus(&poisson("3")), Some(poisson("5")));
    let uniform = Distribution::Uniform { low: rational("0"), high: rational("1") };
    assert_eq!(uniform.plus(&uniform), None);
    assert!(Distribution::of(&Value::integer(3)).is_err());
}

#[test]
fn fast_chances_keep_their_bounds() {
    for number in -1300..=1300 {
        let place = f64::from(number) / 137.0;
        let chance = Interval::exactly(place).normal();
        let error = (normal::distribution(place) - f64::midpoint(chance.low, chance.high)).abs();
        assert!(error <= normal::DISTRIBUTION_ERROR, "{place}: {error}");
        let density = Interval::exactly(place).normal_density();
        let error = (normal::density(place) - f64::midpoint(density.low, density.high)).abs();
        assert!(error <= normal::DENSITY_ERROR * density.high, "{place}: {error}");
    }
    // Φ(1), to all digits of a machine number.
    assert!(Interval::exactly(1.0).normal().holds(0.841_344_746_068_542_9));
}

fn exactly((chain, question): &(Chain, Question)) -> exact::Exact {
    exact::exact(chain, question).expect("exact")
}

fn enclose((chain, question): &(Chain, Question)) -> Interval {
    *enclosed::enclosed(chain, question, 1e-9).expect("enclosed")
}

/// A unit command for each step of one, with noise on the velocity.
fn unit_steps(question: &str) -> (Chain, Question) {
    load(&format!(
        "proc Env_r = (Delay_1 # At_r) ; (Ran_{{Normal(0, sd: 0.02)}}<e> | In_v<u>) ; Env_{{r+u+e}}
proc Go = Out_{{v,1}} ; Go
system Sys = Env_0 | Go
prove probability of Sys {question}"
    ))
}

#[test]
fn ten_unit_steps() {
    let found = exactly(&unit_steps("showing At_p where |p-10| <= 0.1 at 10"));
    assert!(found.chance.low > 0.886_153 && found.chance.high < 0.886_154 && found.chance.width() < 1e-13);
    assert_eq!(found.shown[0].1.mean(), rational("10"));
    assert_eq!(found.shown[0].1.variance(), rational("0.004"));
    // The same by quadrature, which knows nothing of the closed form.
    let other = enclose(&unit_steps("showing At_p where |p-10| <= 0.1 at 10"));
    assert!(other.low <= found.chance.low && found.chance.high <= other.high && other.width() < 1e-6, "{other:?}");
    // What is shown at a time is not what is reached by then.
    let first = enclose(&unit_steps("reaching At_p where |p-10| <= 0.1 within 10"));
    assert!(first.low <= other.high && first.high >= other.low);
}

#[test]
fn noisy_position_and_noisy_odometry() {
    let both = load(
        "proc NEnv_{r,q} = (Delay_1 # NOdo_q # At_r) ; (Ran_{Normal(0, sd: 0.02)}<e> | In_v<u>) ; NEnv_{r+u+e,q+u}
proc NOdo_q = Ran_{Normal(0, sd: 0.05)}<w> ; Out_{p,q+w} ; NOdo_q
proc Go = In_p<m> ; Out_{v,(10-m)/2} ; Go
system Sys = NEnv_{0,0} | Go
prove probability of Sys showing At_p where |p-10| <= 0.1 at 10",
    );
    let found = exactly(&both);
    assert_eq!(found.shown[0].1.mean(), rational("10230/1024"));
    let variance = found.shown[0].1.variance().to_f64().expect("a number");
    assert!((variance - 0.004_833_33).abs() < 5e-9, "{variance}");
    assert!((found.chance.low - 0.845_659).abs() < 5e-7 && found.chance.width() < 1e-12);
}

/// The waypoint of the issue: 50 looks at a noisy position, a fifth of a second apart.
fn waypoint() -> (Chain, Question) {
    load(
        "proc Env_r = (Delay_{1/5} # Odo_r # At_r) ; (Ran_{Normal(0, sd: 1/2)}<e> | In_v<u>) ; Env_{r+(u+e)/5}
proc Odo_r = Ran_{Normal(0, sd: 1/10)}<w> ; Out_{p,r+w} ; Odo_r
proc Go_g  = In_p<m> ; Gtr_{|m-g|,1/10} ; Out_{v,(g-m)/2} ; Go_g
system Sys = Env_0 | (Go_10 ; Done)
prove probability of Sys reaching Done within 49/5",
    )
}

#[test]
fn the_noisy_waypoint_is_enclosed() {
    let (chain, question) = waypoint();
    assert!(exact::exact(&chain, &question).is_err(), "a guard cuts the distribution");
    let found = enclose(&(chain.clone(), question.clone()));
    // By a dense quadrature elsewhere, with 2,000 and 3,000 points: 0.9155277343350(8), 0.9155277343352(2).
    assert!(found.holds(0.915_527_734_335) && found.width() < 1e-6, "{found:?}");
    let estimate = estimated(&chain, &question, 20_000, 7).expect("runs");
    assert!(estimate.low < 0.9155 && estimate.high > 0.9155 && estimate.high - estimate.low < 0.02, "{estimate:?}");
}

/// The waypoint in the plane, with independent axes; `first` where one of them is enough.
#[test]
fn the_noisy_waypoint_in_the_plane() {
    let axis = |name: &str, start: &str| {
        format!(
            "proc Env{name}_r = (Delay_{{1/5}} # Odo{name}_r) ; (Ran_{{Normal(0, sd: 1/2)}}<e> | In_v{name}<u>) ; Env{name}_{{r+(u+e)/5}}
proc Odo{name}_r = Ran_{{Normal(0, sd: 1/10)}}<w> ; Out_{{p{name},r+w}} ; Odo{name}_r
proc Start{name} = Env{name}_{start}
"
        )
    };
    let plane = load(&format!(
        "{}{}proc Go_{{g,h}} = (In_px<m> | In_py<n>) ; (Gtr_{{|m-g|,1/10}} | Gtr_{{|n-h|,1/10}}) ;
 (Out_{{vx,(g-m)/2}} | Out_{{vy,(h-n)/2}}) ; Go_{{g,h}}
system Sys = Startx | Starty | (Go_{{10,10}} ; Done)
prove probability of Sys reaching Done within 74/5",
        axis("x", "0"),
        axis("y", "0")
    ));
    let found = *enclosed::enclosed(&plane.0, &plane.1, 1e-8).expect("enclosed");
    assert!(found.width() < 1e-6, "{found:?}");
    // By a dense quadrature elsewhere, with 250 to 500 points an axis: 0.92024601954(1).
    assert!(found.holds(0.920_246_019_54), "{found:?}");
    let estimate = estimated(&plane.0, &plane.1, 1_000, 7).expect("runs");
    assert!(estimate.low < found.low && estimate.high > found.high, "{estimate:?} {found:?}");
}

#[test]
fn two_legs_in_sequence() {
    let legs = load(
        "proc Env_r = (Delay_{1/5} # Odo_r # At_r) ; (Ran_{Normal(0, sd: 1/2)}<e> | In_v<u>) ; Env_{r+(u+e)/5}
proc Odo_r = Ran_{Normal(0, sd: 1/10)}<w> ; Out_{p,r+w} ; Odo_r
proc Go_g  = In_p<m> ; Gtr_{|m-g|,1/10} ; Out_{v,(g-m)/2} ; Go_g
system Sys = Env_0 | (Go_10 ; Go_2 ; Done)
prove probability of Sys reaching Done within 15",
    );
    let found = enclose(&legs);
    assert!(found.width() < 1e-6, "{found:?}");
    let estimate = estimated(&legs.0, &legs.1, 20_000, 7).expect("runs");
    assert!(estimate.low < found.low && estimate.high > found.high, "{estimate:?} {found:?}");
}

/// Legs to these goals in turn, each of which may end with any look: several may at one moment, each with a look of its own.
#[test]
fn many_legs_in_sequence() {
    let legs = |goals: &[&str], time: &str| {
        let legs: Vec<String> = goals.iter().map(|goal| format!("Go_{{{goal}}}")).collect();
        let asked = load(&format!(
            "proc Env_r = (Delay_{{1/5}} # Odo_r # At_r) ; (Ran_{{Normal(0, sd: 1/2)}}<e> | In_v<u>) ; Env_{{r+(u+e)/5}}
proc Odo_r = Ran_{{Normal(0, sd: 1/10)}}<w> ; Out_{{p,r+w}} ; Odo_r
proc Go_g  = In_p<m> ; Gtr_{{|m-g|,1/10}} ; Out_{{v,(g-m)/2}} ; Go_g
system Sys = Env_0 | ({} ; Done)
prove probability of Sys reaching Done within {time}",
            legs.join(" ; ")
        ));
        *enclosed::enclosed(&asked.0, &asked.1, 1e-8).expect("enclosed")
    };
    // By a dense quadrature elsewhere, with steps of 1/50 and of 1/100, which agree to 12 digits.
    let holds =
        |found: Interval, wanted: f64| assert!(found.holds(wanted) && found.width() < 1e-5, "{found:?} {wanted}");
    holds(legs(&["10", "2", "10", "2"], "30"), 0.668_829_465_837_28);
    holds(legs(&["3/10", "0"].repeat(3), "3"), 0.209_243_674_919_950);
    holds(legs(&["3/10", "0"].repeat(4), "4"), 0.173_409_579_253_860);
}

#[test]
fn a_guard_on_the_position_itself_cuts_the_density() {
    // The first passage of a random walk with drift: P(some of 20 sums of N(1/10, 1) is at least 3).
    let walk = load(
        "proc Env_r = (Delay_1 # At_r) ; (Ran_{Normal(1/10, sd: 1)}<e> | In_v<u>) ; Env_{r+u+e}
proc Go = Out_{v,0} ; Go
system Sys = Env_0 | Go
prove probability of Sys reaching At_p where p >= 3 within 20",
    );
    let found = enclose(&walk);
    // By a quadrature elsewhere, on 59 panels of 24 points down to -30.
    assert!(found.holds(0.582_233_456_588_69) && found.width() < 1e-6, "{found:?}");
}

#[test]
fn finite_draws_are_followed_exactly() {
    let steps = "Mix(1/2: Point(1), 1/2: Point(-1))";
    let walk = load(&format!(
        "proc Env_r = (Delay_1 # At_r) ; (Ran_{{{steps}}}<e> | In_v<u>) ; Env_{{r+u+e}}
proc Go = Out_{{v,0}} ; Go
system Sys = Env_0 | Go
prove probability of Sys reaching At_3 within 9"
    ));
    // By counting all 2^9 walks.
    let mut reached = 0;
    for walk in 0..512u32 {
        let mut at = 0i32;
        reached += u32::from((0..9).any(|step| {
            at += if walk >> step & 1 == 1 { 1 } else { -1 };
            at == 3
        }));
    }
    let found = exactly(&walk).chance;
    assert_eq!(found.number(), Some(&rational(&format!("{reached}/512"))));
}

#[test]
fn a_spread_of_nothing_is_certain() {
    let still = |question: &str| {
        load(&format!(
            "proc Env_r = (Delay_1 # At_r) ; (Ran_{{Normal(0, sd: 0)}}<e> | In_v<u>) ; Env_{{r+u+e}}
proc Go = Out_{{v,1}} ; Go
system Sys = Env_0 | Go
prove probability of Sys {question}"
        ))
    };
    let chance = |question: &str| *exactly(&still(question)).chance;
    assert_eq!(chance("showing At_p where |p-10| <= 1/1000 at 10"), Interval::exactly(1.0));
    assert_eq!(chance("showing At_p where |p-10| <= 1/1000 at 9"), Interval::exactly(0.0));
    assert_eq!(chance("reaching At_7 within 7"), Interval::exactly(1.0));
    assert_eq!(chance("reaching At_7 within 6"), Interval::exactly(0.0));
    assert_eq!(chance("showing At_0 at 1/2"), Interval::exactly(1.0));
}

#[test]
fn at_least_95_of_100_seeds_hold_the_value() {
    let asked = unit_steps("showing At_p where |p-10| <= 0.1 at 10");
    let held = (0..100)
        .filter(|seed| {
            let found = estimated(&asked.0, &asked.1, 500, *seed).expect("runs");
            found.low <= 0.886_153_70 && 0.886_153_71 <= found.high
        })
        .count();
    assert!(held >= 95, "{held}");
    let again = |seed| estimated(&asked.0, &asked.1, 500, seed).expect("runs");
    assert_eq!(again(3), again(3));
    assert_ne!(again(3).share, again(4).share);
    assert_eq!(interval(0, 10).low, 0.0);
    assert_eq!(interval(10, 10).high, 1.0);
    assert!(interval(0, 10).high < 0.5);
}

#[test]
fn rationals_are_enclosed_by_neighbours() {
    for text in ["1/3", "-1/3", "1/10", "0", "1e-320", "-1e300", "7", "1e-12", "123456789012345678901234567890"] {
        let number = rational(text);
        let found = Interval::of(&number);
        let end = |end: f64| BigRational::from_float(end).expect("finite");
        assert!(end(found.low) <= number && number <= end(found.high), "{text}");
        assert!(found.high <= found.low.next_up(), "{text}");
    }
    assert!(Interval::of(&rational("1e400")).high.is_infinite());
}
