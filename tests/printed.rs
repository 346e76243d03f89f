//! Closed forms as they are printed, read by a reader of its own that knows nothing of the values they were made from.

use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::{One, ToPrimitive, Zero};
use pars::lower::{Environment, Lowered};
use pars::name::Name;
use pars::parser::parse;
use pars::recurrence::solve_all;

/// Reads a formula in names whose numbers are known; nothing where there is more than numbers, sums, products and powers.
struct Reader<'t> {
    text: &'t str,
    known: Vec<(&'t str, BigRational)>,
}

fn whole(number: i64) -> BigRational {
    BigRational::from_integer(BigInt::from(number))
}

impl<'t> Reader<'t> {
    fn of(text: &'t str, name: &'t str, number: i64) -> Option<BigRational> {
        let mut reader = Reader { text, known: vec![(name, whole(number))] };
        let value = reader.sum()?;
        reader.text.is_empty().then_some(value)
    }

    fn takes(&mut self, sign: &str) -> bool {
        let rest = self.text.trim_start().strip_prefix(sign);
        self.text = rest.unwrap_or(self.text).trim_start();
        rest.is_some()
    }

    fn sum(&mut self) -> Option<BigRational> {
        let mut all = if self.takes("-") { -self.product()? } else { self.product()? };
        loop {
            if self.takes("+") {
                all += self.product()?;
            } else if self.takes("-") {
                all -= self.product()?;
            } else {
                return Some(all);
            }
        }
    }

    fn product(&mut self) -> Option<BigRational> {
        let mut all = self.power()?;
        loop {
            if self.takes("*") {
                all *= self.power()?;
            } else if self.takes("/") {
                let below = self.power()?;
                all = (!below.is_zero()).then(|| all / below)?;
            } else {
                return Some(all);
            }
        }
    }

    fn power(&mut self) -> Option<BigRational> {
        let mut base = self.one()?;
        while self.takes("!") {
            base = (1..=base.to_i64().filter(|_| base.is_integer())?).fold(whole(1), |all, next| all * whole(next));
        }
        if !self.takes("^") {
            return Some(base);
        }
        let exponent = if self.takes("-") { -self.power()? } else { self.power()? };
        let exponent = exponent.is_integer().then(|| exponent.to_i32())??;
        (exponent >= 0 || !base.is_zero()).then(|| num_traits::Pow::pow(base, exponent))
    }

    fn one(&mut self) -> Option<BigRational> {
        if self.takes("(") {
            let value = self.sum()?;
            return self.takes(")").then_some(value);
        }
        let end = self.text.find(|letter: char| !letter.is_alphanumeric()).unwrap_or(self.text.len());
        let word = &self.text[..end];
        self.text = &self.text[end..];
        match word {
            "sum" | "prod" if self.takes("(") => self.series(word == "sum"),
            _ if word.starts_with(|letter: char| letter.is_ascii_digit()) => word.parse().ok().map(whole),
            _ => self.known.iter().find(|(name, _)| *name == word).map(|(_, number)| number.clone()),
        }
    }

    /// `k=0..n-1, …)`
    fn series(&mut self, adds: bool) -> Option<BigRational> {
        let (name, rest) = self.text.split_once('=')?;
        let (from, rest) = rest.split_once("..")?;
        self.text = rest;
        let (from, to) = (from.parse::<i64>().ok()?, self.sum()?.to_i64()?);
        let mut all = if adds { BigRational::zero() } else { BigRational::one() };
        let inner = self.takes(",").then_some(self.text)?;
        for step in from..=to {
            self.text = inner;
            self.known.push((name, whole(step)));
            let value = self.sum()?;
            self.known.pop();
            if adds {
                all += value
            } else {
                all *= value
            }
            self.takes(")").then_some(())?;
        }
        if from > to {
            // What is not summed is skipped.
            let mut depth = 1;
            let end = inner.find(|letter: char| {
                depth += i32::from(letter == '(') - i32::from(letter == ')');
                depth == 0
            })?;
            self.text = &inner[end + 1..];
        }
        Some(all)
    }
}

/// How many formulas the forms of a recurrence have that can be read; each gives what iteration gives.
fn read(source: &str) -> usize {
    let mut environment = Environment::new();
    let lowered = environment.declare(&parse(source).items, source);
    let question = lowered.into_iter().flatten().find_map(|one| match one {
        Lowered::Solve(solve) => Some(*solve),
        _ => None,
    });
    let question = question.unwrap_or_else(|| panic!("{source}"));
    let Ok(solved) = solve_all(question.recurrence, &environment.assumptions) else { return 0 };
    let recurrence = solved.recurrence();
    let index = recurrence.index.to_string();
    let mut count = 0;
    for line in solved.lines() {
        let Some((left, text)) = line.split_once(" = ") else { continue };
        let Some(name) = left.strip_suffix(&format!("({index})")) else { continue };
        let (text, since) = match text.split_once(" for ") {
            None => (text, recurrence.from),
            Some((text, range)) => match range.strip_suffix(&format!(" <= {index}")).and_then(|from| from.parse().ok())
            {
                Some(from) => (text, from),
                None => continue,
            },
        };
        let place = recurrence.sequences.iter().position(|one| one.name == Name::new(name)).expect("a sequence");
        let terms = recurrence.iterate(16).expect("terms").swap_remove(place);
        let mut all = true;
        for (at, term) in (recurrence.from..).zip(&terms).filter(|(at, _)| *at >= since) {
            match (Reader::of(text, &index, at), term.as_rational()) {
                (Some(found), Some(wanted)) => assert_eq!(found, wanted, "{source}\n{line}\nat {at}"),
                _ => all = false,
            }
        }
        count += usize::from(all);
    }
    count
}

#[test]
fn what_is_printed_is_what_was_found() {
    let mut count = 0;
    for text in [include_str!("recurrences/sixty.txt"), include_str!("recurrences/more.txt")] {
        for stanza in text.split("\n\n").filter(|stanza| stanza.contains("solve ")) {
            let lines = stanza.lines().filter(|line| line.starts_with("param ") || line.starts_with("solve "));
            count += read(&lines.collect::<Vec<_>>().join("\n"));
        }
    }
    assert!(count > 40, "only {count} were read");
}

#[test]
fn sums_over_factorials_with_factors() {
    let mut count = 0;
    for factor in ["n+1", "n+3", "(n+3)/3", "(n+2)/(n+4)", "(2*n+4)/5", "1/(n+3)", "(n+1)*(n+2)", "n^2+1"] {
        for input in ["1", "n^2", "2^n", "1/(n+2)", "(-1)^n"] {
            count += read(&format!("solve u(n+1) = ({factor})*u(n) + {input}, u(0) = 2"));
        }
    }
    for (one, other, below) in
        [("n+1", "n+1", "1"), ("2*n+3", "-(n+1)", "n+2"), ("n+2", "-1", "n+3"), ("2", "n+1", "n+1"), ("1", "2", "n+2")]
    {
        count += read(&format!("solve u(n+2) = (({one})*u(n+1) + ({other})*u(n))/({below}) + 1, u(0) = -1, u(1) = 2"));
    }
    assert!(count > 35, "only {count} were read");
}
