//! Random systems whose guards share noise: what is enclosed must hold the chance that a simulation written here finds.

use super::{enclosed, load};

/// A generator of its own, so that the systems are the same everywhere.
struct Source(u64);

impl Source {
    fn word(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut word = self.0;
        word = (word ^ (word >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        word = (word ^ (word >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        word ^ (word >> 31)
    }

    fn one<T: Copy>(&mut self, of: &[T]) -> T {
        of[(self.word() % of.len() as u64) as usize]
    }

    /// A standard normal number, by Box and Muller.
    fn normal(&mut self) -> f64 {
        let mut unit = || ((self.word() >> 11) as f64 + 0.5) / (1u64 << 53) as f64;
        let (radius, angle) = ((-2.0 * unit().ln()).sqrt(), std::f64::consts::TAU * unit());
        radius * angle.cos()
    }
}

/// A number that is measured and compared: factors of the position and of each draw, and the guard.
struct Look {
    position: f64,
    draws: Vec<f64>,
    greater: bool,
    bound: f64,
}

struct System {
    spreads: Vec<f64>,
    looks: Vec<Look>,
    /// The position of the next round: this much of the last, of the first look, and of noise.
    next: [f64; 3],
    rounds: usize,
}

fn system(source: &mut Source) -> System {
    let draws = source.one(&[2, 3]);
    let spreads = (0..draws).map(|_| source.one(&[1.0, 0.5, 2.0])).collect();
    let position = source.one(&[0.0, 1.0]);
    let look = |source: &mut Source| Look {
        position: position * source.one(&[0.0, 1.0]),
        draws: (0..draws).map(|_| source.one(&[0.0, 0.0, 1.0, -1.0, 0.5])).collect(),
        greater: source.one(&[true, false]),
        bound: source.one(&[-1.0, 0.0, 0.5, 1.0]),
    };
    let looks = (0..source.one(&[1, 2, 2, 3])).map(|_| look(source)).collect();
    let next = [source.one(&[1.0, 0.5, -0.5]), source.one(&[0.0, 0.0, 0.25]), source.one(&[0.5, 1.0])];
    System { spreads, looks, next, rounds: source.one(&[0, 1, 2]) }
}

impl System {
    fn text(&self) -> String {
        let names = ["a", "b", "c"];
        let rans: Vec<String> =
            self.spreads.iter().zip(names).map(|(sd, name)| format!("Ran_{{Normal(0, sd: {sd})}}<{name}>")).collect();
        let (mut outs, mut ins, mut guards) = (Vec::new(), Vec::new(), Vec::new());
        for (number, look) in self.looks.iter().enumerate() {
            let mut sum = format!("({})*r", look.position);
            for (factor, name) in look.draws.iter().zip(names) {
                sum += &format!("+({factor})*{name}");
            }
            outs.push(format!("Out_{{p{number},{sum}}}"));
            ins.push(format!("In_p{number}<m{number}>"));
            let guard = if look.greater { "Gtr" } else { "Lte" };
            guards.push(format!("{guard}_{{m{number},{}}}", look.bound));
        }
        let [slope, command, sd] = self.next;
        format!(
            "proc E_r = (Delay_1 # L_r # At_r) ; (Ran_{{Normal(0, sd: {sd})}}<e> | In_v<u>) ; E_{{({slope})*r+u+e}}
proc L_r = {} ; {} ; L_r
proc Go = {} ; (({} ; Done) else Out_{{v,{command}*m0}}) ; Go
system Sys = E_0 | Go
prove probability of Sys reaching Done within {}",
            rans.join(" ; "),
            outs.join(" ; "),
            ins.join(" ; "),
            guards.join(" ; "),
            self.rounds
        )
    }

    /// Whether all guards of a round hold by the last one.
    fn happens(&self, source: &mut Source) -> bool {
        let mut at = 0.0;
        for _ in 0..=self.rounds {
            let drawn: Vec<f64> = self.spreads.iter().map(|sd| sd * source.normal()).collect();
            let seen = |look: &Look| {
                let noise: f64 = look.draws.iter().zip(&drawn).map(|(factor, draw)| factor * draw).sum();
                look.position * at + noise
            };
            if self.looks.iter().all(|look| (seen(look) > look.bound) == look.greater) {
                return true;
            }
            let [slope, command, sd] = self.next;
            at = slope * at + command * self.looks.first().map_or(0.0, seen) + sd * source.normal();
        }
        false
    }
}

#[test]
fn what_is_enclosed_holds_the_chance_of_guards_that_share_noise() {
    let runs = 100_000;
    let mut source = Source(1);
    let (mut held, mut refused) = (0, 0);
    for _ in 0..150 {
        let system = system(&mut source);
        let (chain, question) = load(&system.text());
        let Ok(found) = enclosed::enclosed(&chain, &question, 1e-6) else {
            refused += 1;
            continue;
        };
        let happened = (0..runs).filter(|_| system.happens(&mut source)).count();
        let share = happened as f64 / f64::from(runs);
        let middle = f64::midpoint(found.low, found.high);
        let slack = 6.0 * (middle * (1.0 - middle) / f64::from(runs)).sqrt() + 1e-4;
        assert!(found.low - slack <= share && share <= found.high + slack, "{found:?} {share}\n{}", system.text());
        held += 1;
    }
    assert!(held >= 20 && refused >= 20, "{held} enclosed, {refused} refused");
}
