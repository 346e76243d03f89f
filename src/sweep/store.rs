//! The file to which each point is added as soon as it is known: a line for the head, then a line a point, with a hash by
//! which a point of another sweep, or one that was changed by hand, is told.

use std::collections::BTreeMap;
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{Read, Seek, SeekFrom, Write};
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::{Head, Row, hash};

/// A point as it stands in its line.
#[derive(Serialize, Deserialize)]
struct Line {
    #[serde(flatten)]
    row: Row,
    /// The hash of the point and of its sweep's input.
    hash: String,
}

impl Line {
    fn new(row: Row, head: &Head) -> Result<Line, String> {
        let text = serde_json::to_string(&row).map_err(|error| error.to_string())?;
        let mut hash = hash([head.input.as_str(), text.as_str()]);
        hash.truncate(16);
        Ok(Line { row, hash })
    }
}

/// A file that grows point by point. While it is open no other program adds to it.
pub struct Store {
    file: File,
    head: Head,
    rows: BTreeMap<usize, Row>,
}

impl Store {
    /// Opens the file of a sweep, or makes it. A line that was cut off by an interruption is dropped.
    ///
    /// # Errors
    /// When it cannot be read or written, is in use, or belongs to another sweep.
    pub fn open(path: &Path, head: &Head) -> Result<Store, String> {
        let shown = path.display();
        let options = OpenOptions::new().read(true).write(true).create(true).truncate(false).open(path);
        let mut file = options.map_err(|error| format!("`{shown}` cannot be written: {error}"))?;
        match file.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => return Err(format!("`{shown}` is in use by another sweep")),
            Err(TryLockError::Error(error)) => return Err(format!("`{shown}` cannot be locked: {error}")),
        }
        let mut text = String::new();
        file.read_to_string(&mut text).map_err(|error| format!("`{shown}` cannot be read: {error}"))?;
        let whole = text.rfind('\n').map_or(0, |end| end + 1);
        let kept = text.get(..whole).unwrap_or("");
        let mut rows = BTreeMap::new();
        if kept.is_empty() {
            file.set_len(0).map_err(|error| error.to_string())?;
            file.seek(SeekFrom::Start(0)).map_err(|error| error.to_string())?;
            let line = serde_json::to_string(head).map_err(|error| error.to_string())?;
            file.write_all(format!("{line}\n").as_bytes()).map_err(|error| error.to_string())?;
        } else {
            let (found, done) = parsed(kept, path)?;
            if found != *head {
                return Err(other(path, &found, head));
            }
            rows = done;
            file.set_len(whole as u64).map_err(|error| error.to_string())?;
            file.seek(SeekFrom::End(0)).map_err(|error| error.to_string())?;
        }
        Ok(Store { file, head: head.clone(), rows })
    }

    /// Whether this point is known.
    pub fn knows(&self, point: usize) -> bool {
        self.rows.contains_key(&point)
    }

    /// Adds a point, and writes it at once.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn add(&mut self, row: Row) -> Result<(), String> {
        let line = Line::new(row, &self.head)?;
        let text = serde_json::to_string(&line).map_err(|error| error.to_string())?;
        self.file.write_all(format!("{text}\n").as_bytes()).map_err(|error| error.to_string())?;
        self.rows.insert(line.row.point, line.row);
        Ok(())
    }

    /// The points known so far, in order.
    pub fn rows(&self) -> Vec<Row> {
        self.rows.values().cloned().collect()
    }
}

fn other(path: &Path, found: &Head, wanted: &Head) -> String {
    let shown = path.display();
    if found.input != wanted.input {
        return format!(
            "`{shown}` holds a sweep of another input (its hash begins {}, this one's {}): remove it, or name another file",
            found.input.get(..12).unwrap_or(""),
            wanted.input.get(..12).unwrap_or("")
        );
    }
    if found.shard != wanted.shard {
        let (part, parts) = found.shard;
        return format!("`{shown}` holds part {part} of {parts} of this sweep: name another file");
    }
    format!("`{shown}` was written by another version ({})", found.format)
}

/// Reads a finished or unfinished file.
///
/// # Errors
/// What is wrong with it.
pub fn read(path: &Path) -> Result<(Head, Vec<Row>), String> {
    let text =
        std::fs::read_to_string(path).map_err(|error| format!("`{}` cannot be read: {error}", path.display()))?;
    let whole = text.rfind('\n').map_or(0, |end| end + 1);
    let (head, rows) = parsed(text.get(..whole).unwrap_or(""), path)?;
    Ok((head, rows.into_values().collect()))
}

fn parsed(text: &str, path: &Path) -> Result<(Head, BTreeMap<usize, Row>), String> {
    let wrong = |line: usize, why: String| format!("`{}`, line {line}: {why}", path.display());
    let mut lines = text.lines();
    let first = lines.next().ok_or_else(|| wrong(1, "there is nothing in it".to_string()))?;
    let head: Head = serde_json::from_str(first).map_err(|error| wrong(1, format!("no sweep begins so: {error}")))?;
    let mut rows = BTreeMap::new();
    for (place, line) in lines.enumerate() {
        let Line { row, hash } = serde_json::from_str(line).map_err(|error| wrong(place + 2, error.to_string()))?;
        if row.cells.len() != head.columns.len() || !head.holds(row.point) {
            return Err(wrong(place + 2, format!("point {} does not belong here", row.point)));
        }
        let line = Line::new(row, &head)?;
        if line.hash != hash {
            let text = "is of another sweep, or was changed by hand: without this line it is asked again";
            return Err(wrong(place + 2, format!("point {} {text}", line.row.point)));
        }
        let row = line.row;
        if rows.insert(row.point, row).is_some() {
            return Err(wrong(place + 2, "a point stands here twice".to_string()));
        }
    }
    Ok((head, rows))
}

/// Puts the parts of one sweep together.
///
/// # Errors
/// When they are of different inputs, a part is missing or stands twice, or a point is not known.
pub fn merge(parts: &[(String, Head, Vec<Row>)]) -> Result<(Head, Vec<Row>), String> {
    let Some((first, head, _)) = parts.first() else { return Err("there is nothing to merge".to_string()) };
    let mut rows = BTreeMap::new();
    let mut seen: BTreeMap<usize, &str> = BTreeMap::new();
    for (name, other, more) in parts {
        if other.input != head.input || other.format != head.format {
            return Err(format!("`{name}` is part of a sweep of another input than `{first}`: they cannot be merged"));
        }
        if other.shard.1 != head.shard.1 {
            let text = "they were cut differently";
            return Err(format!("`{name}` is one of {} parts, `{first}` of {}: {text}", other.shard.1, head.shard.1));
        }
        if let Some(before) = seen.insert(other.shard.0, name) {
            return Err(format!("`{before}` and `{name}` are both part {} of {}", other.shard.0, other.shard.1));
        }
        rows.extend(more.iter().map(|row| (row.point, row.clone())));
    }
    let missing: Vec<usize> = (1..=head.shard.1).filter(|part| !seen.contains_key(part)).collect();
    if let Some(part) = missing.first() {
        return Err(format!("part {part} of {} is missing", head.shard.1));
    }
    if let Some(point) = (0..head.points).find(|point| !rows.contains_key(point)) {
        let part = point % head.shard.1 + 1;
        let unknown = head.points - rows.len();
        return Err(format!(
            "{unknown} points are not known yet, the first in part {part}: let that part run to its end"
        ));
    }
    let head = Head { shard: (1, 1), ..head.clone() };
    Ok((head, rows.into_values().collect()))
}

#[cfg(test)]
mod tests {
    use crate::sweep::{Cell, Row};

    #[test]
    fn numbers_of_the_machine_come_back_to_the_last_bit() {
        let mut bits: u64 = 0x9e37_79b9_7f4a_7c15;
        for point in 0..2_000 {
            bits = bits.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            let number = f64::from_bits(bits);
            if !number.is_finite() {
                continue;
            }
            let row = Row { point, cells: vec![Cell::Number(number)] };
            let text = serde_json::to_string(&row).expect("a row");
            let read: Row = serde_json::from_str(&text).expect("the row");
            let Some(Cell::Number(back)) = read.cells.first() else { panic!("{text}") };
            assert_eq!(back.to_bits(), number.to_bits(), "{text}");
        }
    }
}
