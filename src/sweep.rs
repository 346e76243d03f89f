//! Sweeps: what came of each point, kept so that work can stop and go on, be spread and be put together again.

pub mod region;
pub mod store;
pub mod table;

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

/// What a column holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Kind {
    /// A parameter, exactly.
    Axis,
    /// A verdict.
    Verdict,
    /// Text: exact values.
    Text,
    /// A number of the machine: rounded.
    Number,
}

/// A column of a table.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Column {
    /// Its heading.
    pub name: String,
    /// What it holds.
    pub kind: Kind,
}

/// One cell.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Cell {
    /// A number of the machine.
    Number(f64),
    /// A text.
    Text(String),
    /// Nothing is known.
    Nothing(()),
}

impl Cell {
    /// As it stands in a table of text.
    pub fn text(&self) -> String {
        match self {
            // A number next to 0 with its power of ten, not with hundreds of zeros.
            Cell::Number(number) if *number != 0.0 && number.abs() < 1e-6 => format!("{number:e}"),
            Cell::Number(number) => number.to_string(),
            Cell::Text(text) => text.clone(),
            Cell::Nothing(()) => String::new(),
        }
    }
}

/// What came of one point.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// The number of the point.
    pub point: usize,
    /// The cells, in the order of the columns.
    pub cells: Vec<Cell>,
}

/// What a sweep is, so that its parts can be told from those of others.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Head {
    /// What wrote it.
    pub format: String,
    /// A hash of all that the answers depend on.
    pub input: String,
    /// How many points there are in all.
    pub points: usize,
    /// Which part this is, from 1, and of how many.
    pub shard: (usize, usize),
    /// The values of each parameter, as text, in order.
    pub axes: Vec<(String, Vec<String>)>,
    /// The columns.
    pub columns: Vec<Column>,
}

/// The name and version of the format.
pub const FORMAT: &str = concat!("pars sweep 2, pars ", env!("CARGO_PKG_VERSION"));

impl Head {
    /// Whether a point belongs to this part.
    pub fn holds(&self, point: usize) -> bool {
        let (part, parts) = self.shard;
        point < self.points && point % parts.max(1) + 1 == part
    }

    /// The column of what is feasible.
    pub fn feasible(&self) -> Option<usize> {
        self.columns.iter().position(|column| column.name == FEASIBLE)
    }

    /// Whether anything is asked that can hold or fail, so that points are feasible or not.
    pub fn judges(&self) -> bool {
        self.columns.iter().any(|column| column.kind == Kind::Verdict && column.name != FEASIBLE)
    }
}

/// The heading of the column that says whether all that is asked holds at a point.
pub const FEASIBLE: &str = "feasible";

/// A hash of texts, in hexadecimal digits.
pub fn hash<'t>(texts: impl IntoIterator<Item = &'t str>) -> String {
    let mut hasher = Sha256::new();
    for text in texts {
        hasher.update((text.len() as u64).to_le_bytes());
        hasher.update(text.as_bytes());
    }
    hasher.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
}

/// The points as a table to read, headings first: exact values, no rounded ones.
pub fn readable(head: &Head, rows: &[Row]) -> Vec<Vec<String>> {
    let kept = |place: &usize| head.columns.get(*place).is_some_and(|column| column.kind != Kind::Number);
    let line = |cells: Vec<String>| (0..cells.len()).filter(kept).map(|place| cells[place].clone()).collect();
    let heading = head.columns.iter().map(|column| column.name.clone()).collect();
    let points = rows.iter().map(|row| row.cells.iter().map(Cell::text).collect());
    std::iter::once(heading).chain(points).map(line).collect()
}

/// How many points are feasible, are not, and were left open.
pub fn counts(head: &Head, rows: &[Row]) -> (usize, usize, usize) {
    let Some(place) = head.feasible() else { return (0, 0, 0) };
    let count =
        |word: &str| rows.iter().filter(|row| row.cells.get(place) == Some(&Cell::Text(word.to_string()))).count();
    (count("yes"), count("no") + count("invalid"), count("open"))
}

/// The counts in words, and where the declarations do not hold.
pub fn summary(head: &Head, rows: &[Row]) -> String {
    let told = if head.judges() {
        let (yes, no, open) = counts(head, rows);
        format!("{} points: {yes} feasible, {no} not, {open} open", rows.len())
    } else {
        let points = rows.len();
        format!("{points} points; neither criteria nor claims are asked, so none is feasible or infeasible")
    };
    match invalid(head, rows) {
        Some(invalid) => format!("{told}; {invalid}"),
        None => told,
    }
}

/// At how many points the declarations are wrong with the values there, and the first of these.
fn invalid(head: &Head, rows: &[Row]) -> Option<String> {
    let place = head.feasible()?;
    let wrong = |row: &&Row| row.cells.get(place) == Some(&Cell::Text("invalid".to_string()));
    let (first, count) = (rows.iter().find(wrong)?, rows.iter().filter(wrong).count());
    let values = head.columns.iter().zip(&first.cells).filter_map(|(column, cell)| match cell {
        Cell::Text(value) if column.kind == Kind::Axis => Some(format!("{} = {value}", column.name)),
        _ => None,
    });
    let at = values.collect::<Vec<_>>().join(", ");
    Some(match count {
        1 => format!("at one of them, {at}, what is declared or asked has no meaning"),
        _ => format!("at {count} of them, the first at {at}, what is declared or asked has no meaning"),
    })
}
