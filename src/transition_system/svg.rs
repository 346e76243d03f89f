//! A picture of a small system: states in rows by their distance from the beginning, ordered to cross little.
//!
//! A step leads at most one row down, so an edge downwards passes no other row. Edges that lead up, or along a row,
//! bend out to the side.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use super::display::{caption, edges};
use super::{Ending, TransitionSystem};

/// Systems with more states than this are not drawn.
pub const MOST_DRAWN: usize = 300;

const RADIUS: f64 = 18.0;
const ROW: f64 = 110.0;
/// How far a step from a state to itself reaches out.
const LOOP: f64 = 34.0;
const LINE: f64 = 14.0;
/// The width of a letter, about.
const LETTER: f64 = 6.5;
/// Where along an edge its label may stand, the best first.
const PARTS: [f64; 7] = [0.45, 0.35, 0.55, 0.65, 0.25, 0.75, 0.18];
/// How far beside the edge, in lines.
const BESIDE: [f64; 5] = [0.0, 1.2, -1.2, 2.4, -2.4];
/// Rows up to which a picture has one column.
const TALL: usize = 12;
/// The most by which an edge bends out.
const BEND: f64 = 130.0;
/// How often the rows are put in order, down and up.
const SWEEPS: usize = 8;

/// A picture with its width and height.
struct Drawing {
    text: String,
    size: (f64, f64),
}

/// The height of a title, and the room around it.
const TITLE: f64 = 26.0;

/// The picture; none when the system has more than [`MOST_DRAWN`] states.
pub fn svg(system: &TransitionSystem) -> Option<String> {
    drawing(system).map(|drawing| drawing.text)
}

/// The pictures of several systems one below the other, each under its title; none when one of them has too many states.
pub fn svg_of_each(systems: &[(String, TransitionSystem)]) -> Option<String> {
    let (mut body, mut width, mut below) = (String::new(), 0.0_f64, 0.0);
    for (title, system) in systems {
        let Drawing { text, size } = drawing(system)?;
        let wide = title.chars().count() as f64 * LETTER + 20.0;
        width = width.max(size.0).max(wide);
        let _ = write!(
            body,
            "<text x=\"10\" y=\"{:.0}\" font-weight=\"bold\">{}</text>\n<g transform=\"translate(0,{:.0})\">{text}</g>\n",
            below + TITLE - 8.0,
            escaped(title),
            below + TITLE
        );
        below += size.1 + TITLE;
    }
    Some(format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width:.0} {below:.0}\" width=\"{width:.0}\" \
         height=\"{below:.0}\" font-family=\"sans-serif\" font-size=\"12\">\n\
         <rect width=\"{width:.0}\" height=\"{below:.0}\" fill=\"#fff\"/>\n{body}</svg>\n"
    ))
}

fn drawing(system: &TransitionSystem) -> Option<Drawing> {
    if system.states() > MOST_DRAWN {
        return None;
    }
    let edges = edges(system);
    let rows = rows(system, &edges);
    let gap = gap(system, &edges);
    let widest = rows.iter().map(Vec::len).max().unwrap_or(1) as f64;
    let fold = fold(rows.len(), widest * gap);
    let mut place = vec![(0.0, 0.0); system.states()];
    for (depth, row) in rows.iter().enumerate() {
        let left = (depth / fold) as f64 * widest * gap + (widest - row.len() as f64) * gap / 2.0;
        for (index, state) in row.iter().enumerate() {
            place[*state as usize] = (left + (index as f64 + 0.5) * gap, 60.0 + (depth % fold) as f64 * ROW);
        }
    }
    let mut picture = Picture {
        body: String::new(),
        place,
        least: (widest * gap / 2.0, 30.0),
        most: (0.0, 0.0),
        taken: Vec::new(),
        wanted: Vec::new(),
    };
    picture.most.1 = 60.0 + (rows.len().min(fold) as f64 - 1.0) * ROW + RADIUS + 10.0;
    for ((from, to), labels) in &edges {
        picture.edge(*from, *to, labels, edges.contains_key(&(*to, *from)));
    }
    for state in 0..system.states() as u32 {
        picture.state(system, state);
    }
    picture.write_labels();
    if let Some(cut) = system.cut {
        picture.text(8.0, 16.0, "start", "", &format!("not the whole system: {cut}"));
    }
    Some(picture.finish())
}

/// The width that one state with what is written on either side of it needs.
fn gap(system: &TransitionSystem, edges: &BTreeMap<(u32, u32), Vec<String>>) -> f64 {
    let letters = |lines: &[String]| lines.iter().map(|line| line.chars().count()).max().unwrap_or(0) as f64 * LETTER;
    let captions = (0..system.states() as u32).map(|state| letters(&caption(system, state))).fold(0.0, f64::max);
    let (own, others): (Vec<_>, Vec<_>) = edges.iter().partition(|((from, to), _)| from == to);
    let rounds = own.into_iter().map(|(_, labels)| LOOP + letters(labels)).fold(0.0, f64::max);
    let between = others.into_iter().map(|(_, labels)| letters(labels)).fold(0.0, f64::max);
    (captions + rounds + 3.0 * RADIUS).max(between + RADIUS).clamp(90.0, 640.0)
}

/// How many rows one column of a picture has: one column if it is not much taller than wide.
fn fold(rows: usize, width: f64) -> usize {
    if rows <= TALL {
        return rows.max(1);
    }
    let high = (rows as f64 * width / (1.5 * ROW)).sqrt().ceil().max(TALL as f64);
    rows.min(high as usize).max(1)
}

/// The states in rows by distance, those that cannot be reached last, each row ordered by where its neighbours stand.
fn rows(system: &TransitionSystem, edges: &BTreeMap<(u32, u32), Vec<String>>) -> Vec<Vec<u32>> {
    let distances = system.distances();
    let deepest = distances.iter().flatten().max().map_or(0, |most| *most as usize);
    let mut rows = vec![Vec::new(); deepest + 2];
    for (state, distance) in distances.iter().enumerate() {
        rows[distance.map_or(deepest + 1, |distance| distance as usize)].push(state as u32);
    }
    rows.retain(|row| !row.is_empty());
    let mut order = vec![0.0; system.states()];
    let number = |rows: &[Vec<u32>], order: &mut Vec<f64>| {
        for row in rows {
            for (index, state) in row.iter().enumerate() {
                order[*state as usize] = index as f64 - row.len() as f64 / 2.0;
            }
        }
    };
    number(&rows, &mut order);
    let mut beside: Vec<Vec<u32>> = vec![Vec::new(); system.states()];
    for (from, to) in edges.keys().filter(|(from, to)| from != to) {
        beside[*from as usize].push(*to);
        beside[*to as usize].push(*from);
    }
    for sweep in 0..SWEEPS {
        let count = rows.len();
        for turn in 0..count {
            let row = if sweep % 2 == 0 { turn } else { count - 1 - turn };
            let mut wanted: Vec<(f64, u32)> = rows[row]
                .iter()
                .map(|state| {
                    let near = &beside[*state as usize];
                    let sum: f64 = near.iter().map(|other| order[*other as usize]).sum();
                    (if near.is_empty() { order[*state as usize] } else { sum / near.len() as f64 }, *state)
                })
                .collect();
            wanted.sort_by(|one, two| one.0.total_cmp(&two.0));
            rows[row] = wanted.into_iter().map(|(_, state)| state).collect();
            number(&rows[row..=row], &mut order);
        }
    }
    rows
}

/// Where labels may stand, and the labels.
type Wanted = (Vec<(f64, f64)>, Vec<String>);

struct Picture {
    body: String,
    place: Vec<(f64, f64)>,
    least: (f64, f64),
    most: (f64, f64),
    /// What is covered already: left, top, right, bottom.
    taken: Vec<[f64; 4]>,
    /// Labels with the places where they may stand, the best first.
    wanted: Vec<Wanted>,
}

impl Picture {
    fn reach(&mut self, x: f64, y: f64) {
        self.least = (self.least.0.min(x), self.least.1.min(y));
        self.most = (self.most.0.max(x), self.most.1.max(y));
    }

    fn text(&mut self, x: f64, y: f64, anchor: &str, class: &str, text: &str) {
        let width = text.chars().count() as f64 * LETTER;
        let left = match anchor {
            "middle" => x - width / 2.0,
            "end" => x - width,
            _ => x,
        };
        self.reach(left, y - LINE);
        self.reach(left + width, y + 4.0);
        let class = if class.is_empty() { String::new() } else { format!(" class=\"{class}\"") };
        let text = escaped(text);
        let _ = writeln!(self.body, "<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\"{class}>{text}</text>");
    }

    fn path(&mut self, path: &str) {
        let _ = writeln!(self.body, "<path d=\"{path}\" class=\"edge\" marker-end=\"url(#arrow)\"/>");
    }

    fn labels(&mut self, x: f64, y: f64, anchor: &str, labels: &[String]) {
        let top = y - (labels.len() as f64 - 1.0) * LINE / 2.0;
        for (line, label) in labels.iter().enumerate() {
            self.text(x, top + line as f64 * LINE, anchor, "label", label);
        }
    }

    fn edge(&mut self, from: u32, to: u32, labels: &[String], both_ways: bool) {
        let (start, end) = (self.place[from as usize], self.place[to as usize]);
        if from == to {
            let (x, y) = start;
            let right = x + RADIUS + LOOP;
            self.path(&format!(
                "M {:.1} {:.1} C {right:.1} {:.1}, {right:.1} {:.1}, {:.1} {:.1}",
                x + RADIUS * 0.8,
                y - RADIUS * 0.6,
                y - 30.0,
                y + 30.0,
                x + RADIUS * 0.8 + 2.0,
                y + RADIUS * 0.6 + 2.0
            ));
            let width = labels.iter().map(|label| label.chars().count()).max().unwrap_or(0) as f64 * LETTER;
            self.wanted.push((vec![(right - 4.0 + width / 2.0, y)], labels.to_vec()));
            return;
        }
        let (dx, dy) = (end.0 - start.0, end.1 - start.1);
        let length = dx.hypot(dy).max(1.0);
        // To the right of the way, so that two edges between the same states part.
        let (nx, ny) = (-dy / length, dx / length);
        let bend = if dy > 1.0 {
            if both_ways { 16.0 } else { 0.0 }
        } else if dy.abs() <= 1.0 {
            20.0 + (length * 0.12).min(BEND)
        } else {
            24.0 + (length * 0.18).min(BEND)
        };
        let control = ((start.0 + end.0) / 2.0 + 2.0 * nx * bend, (start.1 + end.1) / 2.0 + 2.0 * ny * bend);
        let towards = |from: (f64, f64), to: (f64, f64), far: f64| {
            let length = (to.0 - from.0).hypot(to.1 - from.1).max(1.0);
            (from.0 + (to.0 - from.0) / length * far, from.1 + (to.1 - from.1) / length * far)
        };
        let (tail, head) = (towards(start, control, RADIUS), towards(end, control, RADIUS + 3.0));
        self.reach(control.0, control.1);
        self.path(&format!(
            "M {:.1} {:.1} Q {:.1} {:.1} {:.1} {:.1}",
            tail.0, tail.1, control.0, control.1, head.0, head.1
        ));
        let along = |part: f64| {
            let (one, two, three) = ((1.0 - part) * (1.0 - part), 2.0 * part * (1.0 - part), part * part);
            (one * tail.0 + two * control.0 + three * head.0, one * tail.1 + two * control.1 + three * head.1)
        };
        let beside = |far: f64| {
            let place = |part: f64| {
                let (x, y) = along(part);
                (x + nx * far * LINE, y + ny * far * LINE)
            };
            PARTS.map(place)
        };
        self.wanted.push((BESIDE.map(beside).concat(), labels.to_vec()));
    }

    /// Writes each label on its edge, where it covers no state and no other label if there is such a place.
    fn write_labels(&mut self) {
        // Those with the least choice come first.
        let mut wanted = std::mem::take(&mut self.wanted);
        wanted.sort_by_key(|(places, _)| places.len());
        for (places, labels) in wanted {
            let width = labels.iter().map(|label| label.chars().count()).max().unwrap_or(0) as f64 * LETTER;
            let height = labels.len() as f64 * LINE;
            let covers = |(x, y): (f64, f64)| [x - width / 2.0, y - height / 2.0, x + width / 2.0, y + height / 2.0];
            let free = |place: &&(f64, f64)| {
                let [left, top, right, bottom] = covers(**place);
                !self
                    .taken
                    .iter()
                    .any(|other| left < other[2] && other[0] < right && top < other[3] && other[1] < bottom)
            };
            let Some(place) = places.iter().find(free).or(places.first()).copied() else { continue };
            self.taken.push(covers(place));
            self.labels(place.0, place.1 + 4.0, "middle", &labels);
        }
    }

    fn state(&mut self, system: &TransitionSystem, state: u32) {
        let (x, y) = self.place[state as usize];
        self.taken.push([x - RADIUS, y - RADIUS, x + RADIUS, y + RADIUS]);
        self.reach(x - RADIUS, y);
        self.reach(x + RADIUS, y);
        if state == system.initial() {
            self.reach(x, y - RADIUS - 26.0);
            self.path(&format!("M {:.1} {:.1} L {:.1} {:.1}", x, y - RADIUS - 24.0, x, y - RADIUS - 3.0));
        }
        let ending = &system.mark(state).ending;
        if *ending == Ending::Aborted {
            let (left, top, side) = (x - RADIUS, y - RADIUS, 2.0 * RADIUS);
            let _ = writeln!(
                self.body,
                "<rect x=\"{left:.1}\" y=\"{top:.1}\" width=\"{side}\" height=\"{side}\" class=\"state\"/>"
            );
        } else {
            let _ = writeln!(self.body, "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{RADIUS}\" class=\"state\"/>");
        }
        if matches!(ending, Ending::Stopped(_)) {
            let inner = RADIUS - 4.0;
            let _ = writeln!(self.body, "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{inner}\" class=\"state\"/>");
        }
        self.text(x, y + 4.0, "middle", "", &state.to_string());
        let caption = caption(system, state);
        let top = y + 4.0 - (caption.len() as f64 - 1.0) * LINE / 2.0;
        for (line, text) in caption.iter().enumerate() {
            let at = top + line as f64 * LINE;
            let width = text.chars().count() as f64 * LETTER;
            self.taken.push([x - RADIUS - 5.0 - width, at - LINE, x - RADIUS, at]);
            self.text(x - RADIUS - 5.0, at, "end", "caption", text);
        }
    }

    fn finish(self) -> Drawing {
        let (left, top) = (self.least.0 - 10.0, self.least.1 - 10.0);
        let (width, height) = (self.most.0 - left + 10.0, self.most.1 - top + 10.0);
        let text = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"{left:.0} {top:.0} {width:.0} {height:.0}\" \
             width=\"{width:.0}\" height=\"{height:.0}\" font-family=\"sans-serif\" font-size=\"12\">\n\
             <defs><marker id=\"arrow\" markerWidth=\"8\" markerHeight=\"8\" refX=\"7\" refY=\"4\" orient=\"auto\">\
             <path d=\"M 0 0.5 L 8 4 L 0 7.5 z\" fill=\"#444\"/></marker></defs>\n\
             <style>.edge {{ fill: none; stroke: #444; stroke-width: 1.2; }} .state {{ fill: #fff; stroke: #222; \
             stroke-width: 1.4; }} .label {{ fill: #234a8f; paint-order: stroke; stroke: #fff; stroke-width: 4px; }} \
             .caption {{ fill: #8a3b12; paint-order: stroke; stroke: #fff; stroke-width: 4px; }}</style>\n\
             <rect x=\"{left:.0}\" y=\"{top:.0}\" width=\"{width:.0}\" height=\"{height:.0}\" fill=\"#fff\"/>\n{}</svg>\n",
            self.body
        );
        Drawing { text, size: (width, height) }
    }
}

/// Text that can stand in XML: its signs escaped, control characters gone.
fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for letter in text.chars() {
        match letter {
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '&' => out.push_str("&amp;"),
            '"' => out.push_str("&quot;"),
            letter if letter.is_control() => out.push(' '),
            letter => out.push(letter),
        }
    }
    out
}
