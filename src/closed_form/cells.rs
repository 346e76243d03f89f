//! Several forms by pieces, side by side: between all indices at which one of them changes, each has one form.

use super::Piece;
use crate::assumption::Assumptions;
use crate::value::{Relation, Value};

/// The indices from one piece of some form to the next of any.
pub(crate) struct Cell<'a> {
    pub(crate) from: Value,
    pub(crate) until: Option<Value>,
    /// One for each that is cut into pieces, in their order.
    pub(crate) forms: Vec<&'a Value>,
}

/// The cells of all pieces together, which begin at one index.
///
/// # Errors
/// Where it is not known which of two pieces ends first, or one form ends before the others.
pub(crate) fn cells<'p>(all: &'p [Vec<Piece>], first: Value, known: &Assumptions) -> Result<Vec<Cell<'p>>, String> {
    let sooner = |end: &Value, other: &Value| known.decide(Relation::Lss, end, other);
    by_ends(all, first, &sooner, &|end, other| end == other).map_err(NotKnown::told)
}

/// The same where it is enough to know that one piece does not end later than another: a cell may then be of no index.
///
/// # Errors
/// Where it is not known which of two pieces ends first, or one form ends before the others.
pub(crate) fn cells_or_none<'p>(
    all: &'p [Vec<Piece>],
    first: Value,
    known: &Assumptions,
) -> Result<Vec<Cell<'p>>, NotKnown> {
    let sooner = |end: &Value, other: &Value| {
        let is = |relation| known.decide(relation, end, other) == Some(true);
        if is(Relation::Lte) { Some(true) } else { is(Relation::Gte).then_some(false) }
    };
    let same = |end: &Value, other: &Value| end == other || known.decide(Relation::Eq, end, other) == Some(true);
    by_ends(all, first, &sooner, &same)
}

/// Why there are no cells: two ends of which it is not known which is sooner; none where the pieces have gaps.
pub(crate) struct NotKnown(pub(crate) Option<(Value, Value)>);

impl NotKnown {
    fn told(self) -> String {
        match self.0 {
            Some((end, other)) => format!("it must be known whether {end} < {other}"),
            None => "the pieces have gaps".to_string(),
        }
    }
}

fn by_ends<'p>(
    all: &'p [Vec<Piece>],
    first: Value,
    sooner: &dyn Fn(&Value, &Value) -> Option<bool>,
    same: &dyn Fn(&Value, &Value) -> bool,
) -> Result<Vec<Cell<'p>>, NotKnown> {
    let mut rest: Vec<&'p [Piece]> = all.iter().map(Vec::as_slice).collect();
    let (mut from, mut cells) = (first, Vec::new());
    loop {
        let mut until: Option<&Value> = None;
        for end in rest.iter().filter_map(|pieces| pieces.first()?.until.as_ref()) {
            let first = match until {
                None => true,
                Some(other) if other == end => false,
                Some(other) => sooner(end, other).ok_or_else(|| NotKnown(Some((end.clone(), other.clone()))))?,
            };
            until = if first { Some(end) } else { until };
        }
        let forms = rest.iter().map(|pieces| Some(&pieces.first()?.form)).collect::<Option<Vec<_>>>();
        let forms = forms.ok_or(NotKnown(None))?;
        cells.push(Cell { from, until: until.cloned(), forms });
        let Some(until) = until else { return Ok(cells) };
        for pieces in &mut rest {
            let ends = |piece: &Piece| piece.until.as_ref().is_some_and(|end| same(end, until));
            if pieces.first().is_some_and(ends) {
                *pieces = &pieces[1..];
            }
        }
        from = until.clone();
    }
}
