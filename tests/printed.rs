//! Closed forms as they are printed, read by a reader of its own that knows nothing of the values they were made from.

mod common;

use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::{One, ToPrimitive, Zero};
use pars::lower::{Environment, Lowered};
use pars::name::Name;
use pars::parser::parse;
use pars::recurrence::solve_all;
use pars::value::Value;

/// Reads a formula in names whose numbers are known; nothing where there is more than numbers, sums, products and powers.
struct Reader<'t> {
    text: &'t str,
    known: Vec<(&'t str, BigRational)>,
}

fn whole(number: i64) -> BigRational {
    BigRational::from_integer(BigInt::from(number))
}

impl<'t> Reader<'t> {
    fn of(text: &'t str, known: &[(&'t str, i64)]) -> Option<BigRational> {
        let mut reader = Reader { text, known: known.iter().map(|(name, number)| (*name, whole(*number))).collect() };
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
            "floor" if self.takes("(") => {
                let value = self.sum()?.floor();
                self.takes(")").then_some(value)
            }
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

/// The first index of `3 <= n < 5`, and the one after the last; nothing if they are no numbers.
fn ends(range: &str, index: &str, from: i64, known: &[(&str, i64)]) -> Option<(i64, i64)> {
    let number = |text: &str| Reader::of(text, known)?.to_i64();
    let (before, after) = match range.split_once(&format!(" <= {index}")) {
        Some((before, after)) => (Some(before), after),
        None => (None, range.strip_prefix(index)?),
    };
    let until = if after.is_empty() { i64::MAX } else { number(after.strip_prefix(" < ")?)? };
    Some((before.map_or(Some(from), number)?, until))
}

/// How many formulas the forms of a recurrence have that can be read; each gives what iteration gives, where the parameters
/// are these numbers and what was said to be needed holds.
fn read_at(source: &str, parameters: &[(&str, i64)]) -> usize {
    let mut environment = Environment::new();
    let lowered = environment.declare(&parse(source).items, source);
    let question = lowered.into_iter().flatten().find_map(|one| match one {
        Lowered::Solve(solve) => Some(*solve),
        _ => None,
    });
    let question = question.unwrap_or_else(|| panic!("{source}"));
    let Ok(solved) = solve_all(question.recurrence, &environment.assumptions) else { return 0 };
    let images = parameters.iter().map(|(name, number)| (Name::new(name), Value::integer(*number))).collect();
    let put = |value: &Value| value.substitute(&images).expect("a value").as_rational();
    if !solved.conditions().iter().all(|(relation, left, right)| {
        let sides = put(left).zip(put(right));
        sides.is_some_and(|(left, right)| relation.holds(left.cmp(&right)))
    }) {
        return 0;
    }
    let recurrence = solved.recurrence();
    let index = recurrence.index.to_string();
    let mut plain = recurrence.clone();
    for sequence in &mut plain.sequences {
        for value in sequence.start.iter_mut().chain([&mut sequence.next]) {
            *value = value.substitute(&images).expect("a value");
        }
    }
    let mut count = 0;
    for line in solved.lines() {
        let Some((left, text)) = line.split_once(" = ") else { continue };
        let Some((name, place)) = left.strip_suffix(')').and_then(|left| left.split_once('(')) else { continue };
        let (text, range) = text.split_once(" for ").unwrap_or((text, &index));
        // What is said of every second index, say, counts rounds.
        let from = if place == index { recurrence.from } else { 0 };
        // A term alone, `u(3)`, is a range of one index.
        let alone = || Some((0, 1)).filter(|_| range == index);
        let ends = if place.contains(&index) { ends(range, &index, from, parameters) } else { alone() };
        let Some((since, until)) = ends else { continue };
        let sequence = recurrence.sequences.iter().position(|one| one.name == Name::new(name)).expect("a sequence");
        let terms = plain.iterate(16).expect("terms").swap_remove(sequence);
        let mut all = true;
        for at in since..until {
            let known = [&[(index.as_str(), at)], parameters].concat();
            let own = Reader::of(place, &known).and_then(|at| usize::try_from(at.to_i64()? - recurrence.from).ok());
            let Some(wanted) = own.and_then(|own| terms.get(own)) else { break };
            match (Reader::of(text, &known), wanted.as_rational()) {
                (Some(found), Some(wanted)) => {
                    assert_eq!(found, wanted, "{source}\n{line}\nat {at} with {parameters:?}");
                }
                _ => all = false,
            }
        }
        count += usize::from(all);
    }
    count
}

fn read(source: &str) -> usize {
    read_at(source, &[])
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

#[test]
fn conditions_on_the_index() {
    let mut count = 0;
    for condition in ["n < 4", "n >= 2", "n = 3", "n^2 > 20", "n < 0", "2*n <= 9"] {
        for (one, other) in [
            ("u(n) + 1", "2*u(n)"),
            ("max(u(n) - 2, 0)", "u(n) + n"),
            ("-u(n)", "if n < 7 then u(n)/2 else 1"),
            ("(n+1)*u(n)", "3 - u(n)"),
            ("u(n) + max(n, 3)", "(-1)^n*u(n)"),
        ] {
            let formulas = read(&format!("solve u(n+1) = if {condition} then {one} else {other}, u(0) = 3"))
                + read(&format!("solve u(n+1) = if {condition} then {other} else {one}, u(-3) = -2"));
            assert!(formulas >= 2, "{condition}: {one}, {other}");
            count += formulas;
        }
        count += read(&format!("solve u(n+2) = if {condition} then u(n+1) + u(n) else 2*u(n), u(0) = 1, u(1) = 3"));
    }
    assert!(count > 110, "only {count} were read");
}

#[test]
fn changes_at_a_symbolic_index() {
    let mut count = 0;
    for (map, first) in [
        ("if n <= m then u(n) + 3 else u(n)/2", 1),
        ("u(n) + min(n, 2*m)", -1),
        ("if n < m then 2*u(n) else if n < 2*m + 3 then u(n) - 1 else -u(n)", 4),
        ("if n = m + 2 then 7 else u(n) + n", 0),
        ("max(n - m, 3 - n)", 2),
    ] {
        for m in 0..6 {
            let source = format!("param m : natural\nsolve u(n+1) = {map}, u(0) = {first}");
            count += read_at(&source, &[("m", m)]);
        }
    }
    assert!(count > 50, "only {count} were read");
}

#[test]
fn symbolic_factors_that_are_never_0() {
    let mut count = 0;
    for factor in ["n+a", "(n+a)/(n+a+1)", "n*a+1", "(n^2+a)/(n+1)", "a^n", "2^n+a"] {
        for input in ["1", "n", "a*2^n", "1/(n+a)"] {
            for a in 1..4 {
                let source = format!("param a > 0\nsolve u(n+1) = ({factor})*u(n) + {input}, u(0) = a-2");
                count += read_at(&source, &[("a", a)]);
            }
        }
    }
    assert!(count > 60, "only {count} were read");
}

/// Also of maps with maxima, sizes and conditions the terms are told that are too long to be exact.
#[test]
fn twenty_terms_are_told_of_maps_by_pieces() {
    let terms = |map: &str, first: &str| -> Vec<String> {
        let told = common::ran(&format!("solve u(n+1) = {map}, u(0) = {first}\n"));
        let told = String::from_utf8_lossy(&told.stdout).into_owned();
        let line = told.lines().find_map(|line| line.trim().strip_prefix("u from 0 on: ")).unwrap_or_default();
        line.split(", ").map(str::to_string).filter(|term| term != "…").collect()
    };
    let plain = terms("u(n)^2-3", "5/2");
    assert_eq!(plain.len(), 20);
    assert_eq!(terms("max(u(n)^2-3,0)", "5/2"), plain);
    assert_eq!(terms("if u(n) > 2 then u(n)^2-3 else 0", "5/2"), plain);
    let near = terms("u(n)+(4-u(n))*abs(4-u(n))/10", "1");
    assert_eq!(near.len(), 20);
    let mut wanted = 1.0f64;
    for term in near {
        let number = match term.trim_start_matches('≈').split_once('/') {
            Some((top, below)) => top.parse::<f64>().expect("a number") / below.parse::<f64>().expect("a number"),
            None => term.trim_start_matches('≈').parse().expect("a number"),
        };
        assert!((number - wanted).abs() < 1e-8, "{term}: {wanted}");
        wanted += (4.0 - wanted) * (4.0 - wanted).abs() / 10.0;
    }
}
