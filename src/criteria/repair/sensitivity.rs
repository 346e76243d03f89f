//! How margins move when one parameter is a little larger or smaller.

use num_rational::BigRational;
use num_traits::{One, Signed, Zero};

use super::{Workshop, difference};
use crate::criteria::{Finding, Measure, Standing};
use crate::name::Name;
use crate::value::Value;

/// How the margin of a criterion moves with a parameter.
#[derive(Clone, Debug)]
pub struct Sensitivity {
    /// The criterion.
    pub name: Name,
    /// The parameter.
    pub parameter: Name,
    /// By how much the parameter was changed, where that is no hundredth of it.
    pub step: Option<BigRational>,
    /// By how much the margin changes when the parameter is a hundredth larger, or so much.
    pub up: Option<Measure>,
    /// The same, when it is that much smaller.
    pub down: Option<Measure>,
    /// The slope of the margin from here upward and downward, as long as the run takes the same ways; none where the
    /// margin jumps.
    pub slopes: [Option<BigRational>; 2],
    /// What becomes of the criterion upward and downward where its margin, which is known here, is not known there: the goal
    /// of a leg is reached no more.
    pub lost: [Option<Standing>; 2],
}

impl Sensitivity {
    /// Whether anything is known of it.
    pub fn is_known(&self) -> bool {
        let changes = self.up.is_some() || self.down.is_some() || self.lost != [None, None];
        changes || self.slopes.iter().any(Option::is_some)
    }
}

impl Workshop<'_> {
    /// How each margin moves with each parameter, or that nothing is known of it.
    pub fn sensitivities(&self) -> Vec<Sensitivity> {
        let mut all = Vec::new();
        for (parameter, value) in self.parameters {
            if (self.judge.interrupted)() {
                break;
            }
            let hundredth = value / BigRational::from_integer(100.into());
            let own = hundredth.is_zero().then(|| self.small());
            let step = own.clone().unwrap_or_else(|| hundredth.abs());
            let around = [value + &step, value - &step].map(|value| {
                let (criteria, environment) = self.elsewhere(&[(parameter.clone(), value)])?;
                Some(self.judge.judge(&criteria, &environment).findings)
            });
            for finding in &self.judged.findings {
                let [up, down] = around.each_ref().map(|findings| {
                    let there = findings.as_ref()?.iter().find(|other| other.name == finding.name)?;
                    difference(there.margin.as_ref()?, finding.margin.as_ref()?)
                });
                let slopes = self.slopes(finding, parameter, value);
                let lost = around.each_ref().map(|findings| {
                    let there = findings.as_ref()?.iter().find(|other| other.name == finding.name)?;
                    let known = finding.exact_margin().is_some() && there.exact_margin().is_none();
                    (known && there.standing != finding.standing).then_some(there.standing)
                });
                let (name, parameter) = (finding.name.clone(), parameter.clone());
                all.push(Sensitivity { name, parameter, step: own.clone(), up, down, slopes, lost });
            }
        }
        all
    }

    /// A change of a parameter that is 0: a hundredth of the smallest margin that there is.
    fn small(&self) -> BigRational {
        let margins = self.judged.findings.iter().filter_map(Finding::exact_margin);
        let numbers = margins.filter_map(Value::as_rational);
        let least = numbers.map(|number| number.abs()).filter(|number| !number.is_zero()).min();
        least.unwrap_or_else(BigRational::one) / BigRational::from_integer(100.into())
    }

    fn slopes(&self, finding: &Finding, parameter: &Name, value: &BigRational) -> [Option<BigRational>; 2] {
        let here = finding.exact_margin().and_then(Value::as_rational);
        let (Some(sides), Some(here)) = (self.formulas.get(parameter), here) else { return [None, None] };
        sides.each_ref().map(|side| {
            let formula = side.get(&finding.name)?;
            if formula.at(value)? == here { formula.slope(value) } else { None }
        })
    }
}
