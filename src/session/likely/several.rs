//! What independent parts of a system show at one time: the chances of the parts, multiplied.

use std::borrow::Cow;

use num_rational::BigRational;
use num_traits::One;

use super::super::beside::{BESIDE, apart};
use super::{Answer, event, name, sought, surely};
use crate::lower::{Environment, Event, Likelihood, Method};
use crate::probability::Enclosed;

/// The chance, where what is asked for is shown at one time by parts without a common port, and that of each is known.
pub(super) fn several(likelihood: &Likelihood, environment: &Environment) -> Option<Answer> {
    let Event::Shown { first: false, pattern, time } = &likelihood.event else { return None };
    if matches!(likelihood.method, Some(Method::Estimated)) {
        return None;
    }
    let parts = apart(environment.system(&likelihood.system)?, pattern, environment)?;
    let mut whole = Enclosed::known(BigRational::one());
    let (mut method, mut lines, mut trusted) = (Method::Exact, Vec::new(), Vec::new());
    for pattern in parts {
        let shown: Vec<String> = pattern.terms.iter().map(ToString::to_string).collect();
        let event_of_part = Event::Shown { first: false, pattern, time: time.clone() };
        let asked = |method| Likelihood { event: event_of_part.clone(), method: Some(method), ..likelihood.clone() };
        // Of the other parts it must be known that they do not matter.
        let (Cow::Owned(_), ..) = event(&asked(Method::Exact), environment).ok()? else { return None };
        let methods = likelihood.method.map_or_else(|| vec![Method::Exact, Method::Enclosed], |method| vec![method]);
        let found = methods.into_iter().find_map(|method| sought(&asked(method), None, environment).ok())?;
        whole = whole.and(found.enclosed.as_ref()?);
        if found.chance.method != name(Method::Exact) {
            method = Method::Enclosed;
        }
        lines.extend(found.lines.first().map(|line| format!("{}: {line}", shown.join(", "))));
        trusted.extend(found.trusted);
    }
    trusted.push(BESIDE.to_string());
    trusted.sort();
    trusted.dedup();
    lines.insert(0, "parts without a common port do not matter to each other, so their chances are multiplied".into());
    Some(Answer { trusted, ..surely(whole, method, lines, BESIDE) })
}
