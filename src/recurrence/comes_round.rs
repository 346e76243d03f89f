//! Terms that come round: where each follows from those before it alone and these come again, so does all that is behind
//! them.

use super::Reach;
use super::numeric::Numeric;
use super::reach::Wanted;
use crate::closed_form::Recurrence;
use crate::value::Value;

/// Terms that are looked at.
const MOST_TERMS: u64 = 3_000;
/// The bits of the longest of them.
const LONGEST: u64 = 256;

/// The first index at which a comparison holds, or that none has it, if the terms come round soon.
pub(super) fn comes_round(recurrence: &Recurrence, wanted: Wanted<'_>, stop: &dyn Fn() -> bool) -> Option<Reach> {
    let (index, (_, left, right)) = (&recurrence.index, wanted);
    let nexts = recurrence.sequences.iter().map(|sequence| &sequence.next);
    if nexts.chain([left, right]).any(|value| value.mentions(index)) {
        return None;
    }
    let mut numbers = Numeric::of(recurrence, wanted)?;
    // The terms are compared with those at 0, 1, 2, 4, 8, …, so that any round is met in a few times its length.
    let (mut earlier, mut since) = (numbers.terms(), 0);
    for count in 0..MOST_TERMS {
        if numbers.holds()? {
            let at = recurrence.from.checked_add(i64::try_from(count).ok()?)?;
            return Some(Reach::At(Value::integer(at), Vec::new()));
        }
        numbers.advance()?;
        if stop() || numbers.bits().1 > LONGEST {
            return None;
        }
        if numbers.terms() == earlier {
            let round = count + 1 - since;
            let first = recurrence.from.checked_add(i64::try_from(since).ok()?)?;
            let from = if since == 0 { String::new() } else { format!(", from {index} = {first} on at the latest") };
            let text =
                if round == 1 { "stay as they are".to_string() } else { format!("come round every {round} indices") };
            return Some(Reach::Never(format!("the terms {text}{from}, and none of them is")));
        }
        if (count + 1).is_power_of_two() {
            (earlier, since) = (numbers.terms(), count + 1);
        }
    }
    None
}

/// The same of exact values of any kind that are computed one by one: that none of them is, where the state is as it was
/// earlier.
pub(super) fn comes_again(
    recurrence: &Recurrence,
    sides: [&Value; 2],
    (at, count, state): (i64, u64, &[Value]),
    earlier: &mut Option<(i64, Vec<Value>)>,
) -> Option<Reach> {
    let index = &recurrence.index;
    if let Some((from, _)) = earlier.as_ref().filter(|(_, earlier)| earlier == state) {
        let text = match at - *from {
            1 => "stay as they are".to_string(),
            round => format!("come round every {round} indices"),
        };
        let text = format!("the terms {text}, from {index} = {from} on at the latest, and none of them is");
        return Some(Reach::Never(text));
    }
    let reads = |value: &Value| value.mentions(index);
    let nexts = || recurrence.sequences.iter().map(|sequence| &sequence.next);
    if count.is_power_of_two() && !sides.into_iter().chain(nexts()).any(reads) {
        *earlier = Some((at, state.to_vec()));
    }
    None
}
