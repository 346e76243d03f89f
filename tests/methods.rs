//! The closed forms of the paper's systems by all three methods, from a table; rare events by splitting; numbers that are
//! not normal. What is compared with was computed elsewhere.

use num_traits::ToPrimitive;

use pars::probability::chain::Chain;
use pars::probability::direct::direct;
use pars::probability::estimated::{Rare, estimated};
use pars::probability::schedule::schedule;
use pars::probability::{Question, enclosed, exact};

#[path = "probability/load.rs"]
mod load;

use load::{load, read};

/// A value as printed, and half a unit of its last digit.
fn printed(text: &str) -> (f64, f64) {
    let digits = text.split_once('.').map_or(0, |(_, digits)| digits.len());
    let exact = digits == 0 || text.parse::<f64>().is_ok_and(|number| number == 9.990_234_375);
    (text.parse().expect("a number"), if exact { 1e-12 } else { 0.5 * 10f64.powi(-(digits as i32)) })
}

fn check((chain, question): &(Chain, Question), title: &str, method: &str, value: &str) {
    if let Some(reason) = value.strip_prefix("- ") {
        let found = match method {
            "exact" => exact::exact(chain, question).err(),
            "enclosed" => enclosed::enclosed(chain, question, 1e-8).err(),
            _ => estimated(chain, question, 500, 1).err(),
        };
        assert_eq!(found.as_deref(), Some(reason), "{title}");
        return;
    }
    let (wanted, half) = printed(value);
    match method {
        "exact" => {
            let chance = exact::exact(chain, question).expect(title).chance;
            assert!(chance.width() < 1e-12 && (chance.low - wanted).abs() <= half, "{title}: {chance:?}");
        }
        "enclosed" => {
            let chance = *enclosed::enclosed(chain, question, 1e-8).expect(title);
            let known = exact::exact(chain, question).map(|exact| exact.chance.interval());
            let (low, high) = known.map_or((wanted, wanted), |known| (known.low, known.high));
            assert!(chance.low <= low && high <= chance.high && chance.width() < 2e-8, "{title}: {chance:?}");
        }
        "estimated" => {
            let holds = |seed: &u64| {
                let found = estimated(chain, question, 500, *seed).expect(title);
                found.low <= wanted + half && wanted - half <= found.high && found.high - found.low < 0.2
            };
            let held = (0..100).filter(holds).count();
            assert!(held >= 95, "{title}: {held} of 100 seeds");
        }
        "mean" | "variance" => {
            let exact = exact::exact(chain, question).expect(title);
            let shown = &exact.shown[0].1;
            let found = if method == "mean" { shown.mean() } else { shown.variance() };
            assert!((found.to_f64().expect("a number") - wanted).abs() <= half, "{title}: {found}");
        }
        other => panic!("{title}: {other}"),
    }
}

#[test]
fn every_closed_form_by_every_method() {
    let text = include_str!("data/methods.txt");
    let mut count = 0;
    for block in text.split("== ").skip(1) {
        let (title, rest) = block.split_once('\n').expect("a title");
        let methods = ["exact ", "enclosed ", "estimated ", "mean ", "variance "];
        let (said, mission): (Vec<&str>, Vec<&str>) = rest
            .lines()
            .filter(|line| !line.is_empty())
            .partition(|line| methods.iter().any(|one| line.starts_with(one)));
        assert!(said.len() >= 3, "{title}");
        let asked = load(&mission.join("\n"));
        for line in said {
            let (method, value) = line.split_once(' ').expect("a value");
            check(&asked, title, method, value);
            count += 1;
        }
    }
    assert!(count >= 52, "{count}");
}

/// One draw each round, added to the position.
fn sums(draw: &str, asked: &str) -> (Chain, Question) {
    load(&format!(
        "proc Env_r = (Delay_1 # At_r) ; (Ran_{{{draw}}}<e> | In_v<u>) ; Env_{{r+u+e}}
proc Go = Out_{{v,0}} ; Go
system Sys = Env_0 | Go
prove probability of Sys {asked}"
    ))
}

#[test]
fn exact_numbers_are_not_compared_by_rounding() {
    // Walks of tenths: 176 of 512 come to 3/10 in nine steps. Three tenths added up by a machine are more than 3/10.
    let asked = sums("Mix(1/2: Point(1/10), 1/2: Point(-1/10))", "reaching At_{3/10} within 9");
    let found = estimated(&asked.0, &asked.1, 20_000, 1).expect("runs");
    assert!(found.low < 0.34375 && 0.34375 < found.high && found.high - found.low < 0.02, "{found:?}");
}

#[test]
fn rare_events_are_split() {
    let holds = |asked: &(Chain, Question), wanted: f64| {
        let found: Vec<_> = (0..20u64).map(|seed| estimated(&asked.0, &asked.1, 500, seed).expect("runs")).collect();
        for found in found.iter().filter(|found| found.rare == Rare::Split) {
            assert!(found.high < 3.0 * wanted && found.low > wanted / 4.0, "{wanted}: {found:?}");
        }
        let held = found.iter().filter(|found| found.low <= wanted && wanted <= found.high).count();
        // Estimates that happen to differ too much leave the plain runs.
        let split = found.iter().filter(|found| found.rare == Rare::Split).count();
        assert!(held >= 19 && split >= 17, "{wanted}: {held} {split}");
    };
    // A walk of thirty steps that all go up.
    holds(&sums("Mix(1/2: Point(1), 1/2: Point(-1))", "reaching At_30 within 30"), 2f64.powi(-30));
    // A sum of twenty normal numbers: 1 - Φ(6).
    holds(&sums("Normal(0, sd: 1)", "showing At_p where p > 26.83281572999748 at 20"), 9.865_876_450_377e-10);
}

/// Where a run soon forgets where it was, copies that go on from a place have no better chance than others.
#[test]
fn runs_that_are_drawn_back_are_changed_as_a_whole() {
    let asked = load(
        "proc Env_r = (Delay_1 # At_r) ; (Ran_{N(0, sd: 1)}<e> | In_v<u>) ; Env_{7/10*r+u+e}\nproc Go = Out_{v,0} ; Go\n\
         system Sys = Env_0 | Go\nprove probability of Sys reaching At_p where p >= 6 within 8",
    );
    let exactly = enclosed::enclosed(&asked.0, &asked.1, 1e-9).expect("enclosed");
    let found: Vec<_> = (0..6).map(|seed| estimated(&asked.0, &asked.1, 500, seed).expect("runs")).collect();
    let held = found.iter().filter(|one| one.low <= exactly.high && exactly.low <= one.high).count();
    let changed = found.iter().filter(|one| one.rare == Rare::Changed && one.high < 2.0 * one.low).count();
    assert!(held >= 5 && changed >= 4, "{exactly:?}: {found:?}");
}

#[test]
fn a_rare_first_passage_agrees_with_its_enclosure() {
    let asked = sums("Normal(0, sd: 1)", "reaching At_p where p > 26 within 20");
    let found = enclosed::enclosed(&asked.0, &asked.1, 1e-14).expect("enclosed");
    let estimate = estimated(&asked.0, &asked.1, 1_000, 3).expect("runs");
    assert!(
        estimate.rare == Rare::Split && estimate.low <= found.high && found.low <= estimate.high,
        "{estimate:?} {found:?}"
    );
}

#[test]
fn arrivals_and_other_numbers() {
    let chance = |draw: &str, asked: &str| {
        let asked = sums(draw, asked);
        let found = exact::exact(&asked.0, &asked.1).expect("exact").chance;
        let estimate = estimated(&asked.0, &asked.1, 4_000, 5).expect("runs");
        assert!(estimate.low <= found.high && found.low <= estimate.high, "{draw}: {estimate:?} {found:?}");
        *found
    };
    let holds = |draw: &str, asked: &str, wanted: f64| {
        let found = chance(draw, asked);
        assert!(
            found.low <= wanted * (1.0 + 1e-13) && wanted * (1.0 - 1e-13) <= found.high,
            "{draw} {asked}: {found:?}"
        );
        assert!(found.width() < 1e-12, "{found:?}");
    };
    // Sums of Poisson numbers, by scipy.stats.poisson(6): 3 is an end of two alternatives, and counts once.
    holds("Poisson(rate: 3/2)", "showing At_p where p <= 3 at 4", 0.151_203_882_776_648_3);
    holds("Poisson(rate: 3/2)", "showing At_p where p < 3 at 4", 0.061_968_804_416_658_96);
    holds("Poisson(rate: 3/2)", "showing At_p where |p-3| <= 1 at 4", 0.267_705_235_079_966_7);
    holds("Poisson(rate: 3/2)", "showing At_p where p > 11/2 at 4", 0.554_320_358_635_389_1);
    holds("Poisson(rate: 3/2)", "showing At_6 at 4", 0.160_623_141_047_980_27);
    // 1 - e^-2, 3/4, and a mixture of both kinds.
    holds("Exp(rate: 2)", "showing At_p where p <= 1 at 1", 0.864_664_716_763_387_3);
    holds("Uniform(-1, 3)", "showing At_p where p >= 0 at 1", 0.75);
    holds("Mix(1/2: Exp(rate: 2), 1/2: Normal(0, sd: 1))", "showing At_p where p <= 1 at 1", 0.853_004_731_415_965_1);
    // A rate at an extreme, and a spread of nothing.
    holds("Exp(rate: 10^12)", "showing At_p where p <= 1/10^12 at 1", 0.632_120_558_828_557_7);
    holds("Exp(rate: 1/10^12)", "showing At_p where p > 10^12 at 1", 0.367_879_441_171_442_3);
    holds("Uniform(2, 2)", "showing At_2 at 1", 1.0);
    // Two exponential numbers: 1 - 3 e^-2.
    holds("Exp(rate: 2)", "showing At_p where p <= 1 at 2", 0.593_994_150_290_161_9);
}

#[test]
fn a_large_count_is_drawn_as_a_sum() {
    let asked = sums("Poisson(rate: 2000)", "showing At_p where p > 2000 at 1");
    // 0.494053299548…, by mpmath.gammainc(2001, 0, 2000, regularized=True)
    let exact = exact::exact(&asked.0, &asked.1).expect("a chance").chance;
    assert!(exact.low < 0.494_053_299_55 && 0.494_053_299_54 < exact.high && exact.width() < 1e-9, "{exact:?}");
    let found = estimated(&asked.0, &asked.1, 4_000, 5).expect("runs");
    assert!(found.low < 0.494_054 && 0.494_053 < found.high, "{found:?}");
}

#[test]
fn what_is_enclosed_is_about_as_narrow_as_asked() {
    let asked = load(
        "proc Env_r = (Delay_{1/5} # Odo_r # At_r) ; (Ran_{Normal(0, sd: 1/2)}<e> | In_v<u>) ; Env_{r+(u+e)/5}
proc Odo_r = Ran_{Normal(0, sd: 1/10)}<w> ; Out_{p,r+w} ; Odo_r
proc Go_g  = In_p<m> ; Gtr_{|m-g|,1/10} ; Out_{v,(g-m)/2} ; Go_g
system Sys = Env_0 | (Go_10 ; Done)
prove probability of Sys reaching Done within 49/5",
    );
    for wanted in [1e-6, 1e-7, 1e-8] {
        let found = enclosed::enclosed(&asked.0, &asked.1, wanted).expect("enclosed");
        assert!(found.holds(0.915_527_734_335) && found.width() < 1.5 * wanted, "{wanted}: {found:?}");
    }
}

#[test]
fn guards_on_odometry_and_rounds_of_unequal_length() {
    let near = |mission: &str, wanted: f64| {
        let asked = load(mission);
        if let Ok(found) = enclosed::enclosed(&asked.0, &asked.1, 1e-6) {
            assert!(found.low < wanted + 0.001 && wanted - 0.001 < found.high && found.width() < 1e-5, "{found:?}");
        }
        let found = estimated(&asked.0, &asked.1, 20_000, 2).expect("runs");
        assert!(found.low < wanted + 0.001 && wanted - 0.001 < found.high, "{found:?}");
    };
    // The position drifts away from the odometry, by which the robot stops: four million runs in numpy, ±0.0003.
    near(
        "proc NEnv_{r,q} = (Delay_1 # NOdo_q # At_r) ; (Ran_{Normal(0, sd: 0.02)}<e> | In_v<u>) ; NEnv_{r+u+e,q+u}
proc NOdo_q = Ran_{Normal(0, sd: 0.05)}<w> ; Out_{p,q+w} ; NOdo_q
proc Go_g = In_p<m> ; Gtr_{|m-g|,1/10} ; Out_{v,(g-m)/2} ; Go_g
system Sys = NEnv_{0,0} | (Go_10 ; Done)
prove probability of Sys reaching At_p where |p-10| <= 1/10 within 10",
        0.693_22,
    );
    // Rounds of 1 and of 1/2 in turn: the deadline is a time. Four million runs, ±0.0004.
    near(
        "proc Alt_r = (Delay_1 # At_r) ; (Ran_{Normal(0, sd: 1)}<e> | In_v<u>) ; (Delay_{1/2} # At_{r+u+e}) ;
 (Ran_{Normal(1/2, sd: 1)}<f> | In_v<z>) ; Alt_{r+u+e+f+z}
proc Go = Out_{v,0} ; Go
system Sys = Alt_0 | Go
prove probability of Sys reaching At_p where p > 3 within 6",
        0.433_96,
    );
}

#[test]
fn runs_of_the_meaning_agree_with_closed_forms() {
    let holds = |mission: &str, wanted: f64| {
        let (environment, system, event, question) = read(mission);
        let term = system.term(&environment.definitions);
        let found = direct(&term, &environment.definitions, &event, &question, (None, 1)).expect(mission);
        assert!(found.low <= wanted && wanted <= found.high && found.high - found.low < 0.05, "{wanted}: {found:?}");
    };
    let terrain = "proc Ter = (Ran_{Exp(rate: 1/3)}<x> | Ran_{Normal(2, sd: 1/2)}<d>) ; Delay_x ; (Delay_d # Done)
system Sys = Ter | Delay_100\n";
    // By scipy: the integral of the density of x over P(x <= 4 < x + d); and 1 - e^(-4/3).
    holds(&format!("{terrain}prove probability of Sys showing Done at 4"), 0.256_999_591_330_9);
    holds(&format!("{terrain}prove probability of Sys reaching Done within 4"), 0.736_402_861_8);
    // A normal duration that is mostly negative: nothing is shown then. 1 - Φ(1).
    let short = "proc Ter = Ran_{Normal(-1, sd: 1)}<d> ; (Delay_d # Done)\nsystem Sys = Ter | Delay_100\n";
    holds(&format!("{short}prove probability of Sys reaching Done within 4"), 0.158_655_253_9);
    // 1 - 3*ln(4/3): the product of two uniform numbers.
    let product = "proc Growth_n = (Delay_1 # At_n) ; Ran_{Uniform(1,2)}<k> ; Growth_{n*k}\nsystem Sys = Growth_1\n";
    holds(&format!("{product}prove probability of Sys showing At_n where n >= 3 at 2"), 0.136_953_782_6);
    // Three throws of a coin, of which two or more are heads.
    let coin = "proc Throw_n = (Delay_1 # At_n) ; Ran_{Mix(1/2: Point(0), 1/2: Point(1))}<k> ; Throw_{n+k}
system Sys = Throw_0\n";
    holds(&format!("{coin}prove probability of Sys showing At_n where n >= 2 at 3"), 0.5);
}

#[test]
fn what_is_shown_for_no_time_in_one_round_may_be_shown_in_a_later_one() {
    // 0.2149: the sixth round shows it, and the second for no time.
    let (environment, system, event, question) = read(
        "proc Turn_n = Ran_{Exp(rate: 1)}<x> ; Delay_x ; (Delay_{if n < 3 then 0 else 1} # At_n) ; Turn_{n+1}
system Sys = Turn_0\nprove probability of Sys reaching At_n where (n-1)*(n-5) = 0 within 6",
    );
    let found = schedule(&system.components, &environment.definitions, &event, &question);
    assert_eq!(found.err().as_deref(), Some("what is asked for is shown several times, and may last no time"));
}

#[test]
fn what_depends_on_an_order_is_not_estimated() {
    let (environment, system, event, question) = read(
        "proc One = Out_{c,1} ; Idle\nproc Two = Out_{c,2} ; Idle\nproc Read = In_c<y> ; At_y
system Sys = One | Two | Read\nprove probability of Sys reaching At_1 within 1",
    );
    let term = system.term(&environment.definitions);
    let found = direct(&term, &environment.definitions, &event, &question, (None, 1));
    assert!(found.is_err_and(|why| why.contains("which of several communications comes first")));
}

#[test]
fn noise_much_finer_than_the_next_is_put_together_with_it() {
    // What the first odometry adds to the position counts for 2^-100 of what is shown a hundred rounds later.
    let asked = load(
        "proc NEnv_{r,q} = (Delay_1 # NOdo_q # At_r) ; (Ran_{Normal(0, sd: 0.02)}<e> | In_v<u>) ; NEnv_{r+u+e,q+u}
proc NOdo_q = Ran_{Normal(0, sd: 0.05)}<w> ; Out_{p,q+w} ; NOdo_q
proc Go = In_p<m> ; Out_{v,(10-m)/2} ; Go
system Sys = NEnv_{0,0} | Go
prove probability of Sys showing At_p where |p-10| <= 0.1 at 100",
    );
    let found = enclosed::enclosed(&asked.0, &asked.1, 1e-8).expect("enclosed");
    let known = exact::exact(&asked.0, &asked.1).expect("exact").chance;
    assert!(found.low <= known.low && known.high <= found.high && found.width() < 2e-8, "{found:?} {known:?}");
}

#[test]
fn measured_and_actual_positions_are_enclosed_together() {
    // The robot stops by what it measures; asked is where it is. Four million runs in numpy, ±0.0005.
    let mission =
        "proc Field_r = (Delay_{1/2} # Look_r # At_r) ; (Ran_{Normal(0, sd: 0.3)}<e> | In_v<u>) ; Field_{r+(u+e)/2}
proc Look_r = Ran_{Normal(0, sd: 0.2)}<w> ; Out_{p,r+w} ; Look_r
proc Go_g = In_p<m> ; Gtr_{|m-g|,0.2} ; Out_{v,(g-m)*4/5} ; Go_g
system Sys = Field_2 | (Go_7 ; Done)\n";
    for (asked, wanted) in
        [("reaching At_p where |p-7| <= 1/10 within 5", 0.397_86), ("showing At_p where |p-7| <= 1/10 at 5", 0.023_53)]
    {
        let (chain, question) = load(&format!("{mission}prove probability of Sys {asked}"));
        let found = enclosed::enclosed(&chain, &question, 1e-8).expect("enclosed");
        assert!(found.width() < 2e-8 && (found.low - wanted).abs() < 0.000_5, "{asked}: {found:?}");
    }
}

#[test]
fn uneven_estimates_are_not_relied_on() {
    // 239 of 10^7 runs of another program: 2.4e-5, with a standard deviation of 1.5e-6.
    let text = include_str!("cases/probability/uneven.pars");
    let asked = "prove probability of Sys showing Pos_{a,b} where b <= -45/8 at 4";
    let mission: Vec<&str> = text.lines().take_while(|line| !line.starts_with("prob")).chain([asked]).collect();
    let asked = load(&mission.join("\n").replace("observer Done, Pos", "observer Pos"));
    let held = (0..20u64).filter(|seed| {
        let found = estimated(&asked.0, &asked.1, 2_000, *seed).expect("runs");
        found.low <= 2.4e-5 && 2.4e-5 <= found.high
    });
    assert!(held.count() >= 19);
}
