//! Where a sweep is feasible: a picture, and the same at a terminal.

use std::fmt::Write;

use super::{Cell, Head, Row};

/// The side of a cell, in pixels.
const CELL: usize = 22;
/// Cells along one side of a panel, at most; more are left to the table.
const MOST_CELLS: usize = 120;
/// Panels, at most.
const MOST_PANELS: usize = 16;

/// What a point is called, with its colour (also told apart by people who see fewer colours) and its sign.
const KINDS: [(&str, &str, &str, char); 4] = [
    ("yes", "feasible", "#2166ac", '█'),
    ("no", "not feasible", "#f4a582", '·'),
    ("open", "open", "#d9d9d9", '?'),
    ("invalid", "excluded by the declarations", "#ffffff", ' '),
];

/// One panel: two axes, the others fixed.
struct Panel {
    title: String,
    columns: Vec<String>,
    rows: Vec<String>,
    across: String,
    down: String,
    /// Row by row from below; nothing where a point is not known.
    cells: Vec<Vec<Option<usize>>>,
}

fn panels(head: &Head, rows: &[Row]) -> Vec<Panel> {
    let Some(place) = head.feasible() else { return Vec::new() };
    let kind = |row: &Row| match row.cells.get(place) {
        Some(Cell::Text(text)) => KINDS.iter().position(|(word, ..)| word == text),
        _ => None,
    };
    let sizes: Vec<usize> = head.axes.iter().map(|(_, values)| values.len()).collect();
    let (fixed, shown) = head.axes.split_at(head.axes.len().saturating_sub(2));
    let one = ("".to_string(), vec!["".to_string()]);
    let (down, across) = match shown {
        [down, across] => (down.clone(), across.clone()),
        [across] => (one, across.clone()),
        _ => return Vec::new(),
    };
    let size = down.1.len() * across.1.len();
    let count: usize = sizes.iter().take(fixed.len()).product();
    let mut all = Vec::new();
    for panel in 0..count.min(MOST_PANELS) {
        let mut rest = panel;
        let mut titles = Vec::new();
        for (name, values) in fixed.iter().rev() {
            titles.push(format!("{name} = {}", values[rest % values.len()]));
            rest /= values.len();
        }
        titles.reverse();
        let mut cells = vec![vec![None; across.1.len()]; down.1.len()];
        for row in rows.iter().filter(|row| row.point / size == panel) {
            let inside = row.point % size;
            cells[inside / across.1.len()][inside % across.1.len()] = kind(row);
        }
        all.push(Panel {
            title: titles.join(", "),
            columns: across.1.clone(),
            rows: down.1.clone(),
            across: across.0.clone(),
            down: down.0.clone(),
            cells,
        });
    }
    all
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

/// The region as a picture.
pub fn svg(head: &Head, rows: &[Row]) -> String {
    let panels = panels(head, rows);
    let wide = panels.iter().map(|panel| panel.columns.len().min(MOST_CELLS)).max().unwrap_or(1) * CELL + 140;
    let wide = wide.max(420);
    let mut body = String::new();
    let mut top = 30;
    for (place, (_, label, colour, _)) in KINDS.iter().take(3).enumerate() {
        let left = 20 + place * 130;
        let _ = writeln!(
            body,
            r##"<rect x="{left}" y="12" width="14" height="14" fill="{colour}" stroke="#555"/><text x="{}" y="24">{label}</text>"##,
            left + 20
        );
    }
    top += 20;
    for panel in &panels {
        top = drawn(panel, top, &mut body);
    }
    let summary = super::summary(head, rows);
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{wide}\" height=\"{top}\" viewBox=\"0 0 {wide} {top}\" \
         font-family=\"sans-serif\" font-size=\"12\" role=\"img\"><title>Feasible region</title>\
         <desc>{summary}</desc>\
         <rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n{body}</svg>\n"
    )
}

fn drawn(panel: &Panel, top: usize, body: &mut String) -> usize {
    let left = 100;
    let mut y = top;
    if !panel.title.is_empty() {
        let _ =
            writeln!(body, r#"<text x="{left}" y="{}" font-weight="bold">{}</text>"#, y + 12, escaped(&panel.title));
        y += 22;
    }
    let height = panel.rows.len().min(MOST_CELLS);
    let _ = writeln!(body, r#"<text x="10" y="{}" font-style="italic">{}</text>"#, y + 14, escaped(&panel.down));
    for (line, label) in panel.rows.iter().enumerate().take(MOST_CELLS) {
        let from = y + (height - 1 - line) * CELL;
        let _ =
            writeln!(body, r#"<text x="{}" y="{}" text-anchor="end">{}</text>"#, left - 6, from + 15, escaped(label));
        for (column, cell) in panel.cells[line].iter().enumerate().take(MOST_CELLS) {
            let Some((_, name, colour, _)) = cell.and_then(|kind| KINDS.get(kind)) else { continue };
            let _ = writeln!(
                body,
                r##"<rect x="{}" y="{from}" width="{CELL}" height="{CELL}" fill="{colour}" stroke="#fff"><title>{} = {}, {} = {}: {name}</title></rect>"##,
                left + column * CELL,
                escaped(&panel.across),
                escaped(&panel.columns[column]),
                escaped(&panel.down),
                escaped(label)
            );
        }
    }
    y += height * CELL;
    let longest = panel.columns.iter().map(|label| label.chars().count()).max().unwrap_or(1);
    let every = (longest * 8).div_ceil(CELL).max(1);
    for (column, label) in panel.columns.iter().enumerate().take(MOST_CELLS).step_by(every) {
        let _ = writeln!(
            body,
            r#"<text x="{}" y="{}" text-anchor="middle">{}</text>"#,
            left + column * CELL + CELL / 2,
            y + 15,
            escaped(label)
        );
    }
    let _ = writeln!(body, r#"<text x="{left}" y="{}" font-style="italic">{}</text>"#, y + 32, escaped(&panel.across));
    y + 50
}

/// The region in signs, a line a value of the second but last parameter.
pub fn lines(head: &Head, rows: &[Row]) -> Vec<String> {
    let mut all = Vec::new();
    if !head.judges() {
        return all;
    }
    for panel in panels(head, rows) {
        if !panel.title.is_empty() {
            all.push(panel.title.clone());
        }
        let wide = panel.rows.iter().map(|label| label.chars().count()).max().unwrap_or(0);
        for (line, label) in panel.rows.iter().enumerate().rev() {
            let signs: String = panel.cells[line]
                .iter()
                .take(MOST_CELLS)
                .map(|cell| cell.and_then(|kind| KINDS.get(kind)).map_or(' ', |(.., sign)| *sign))
                .collect();
            all.push(format!("{label:>wide$} {signs}"));
        }
        if let (Some(first), Some(last)) = (panel.columns.first(), panel.columns.last()) {
            let beside = if panel.down.is_empty() { String::new() } else { format!("; {} up", panel.down) };
            all.push(format!("{:wide$} {} from {first} to {last}{beside}", "", panel.across));
        }
    }
    all.push("█ feasible, · not, ? open".to_string());
    all
}
