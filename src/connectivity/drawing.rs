//! The links between components as a picture: boxes in a row, arrows above them to the right and below them to the left.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use super::Connectivity;

/// Sizes, in pixels.
const WIDTH: usize = 130;
const HEIGHT: usize = 34;
const APART: usize = 90;
/// How much higher an arrow goes for each component that it passes.
const STEP: usize = 34;
/// Components that are drawn.
const MOST_DRAWN: usize = 12;
/// Characters of a name that are drawn.
const LONGEST: usize = 15;

impl Connectivity {
    /// As SVG, which can stand within a page; none where nothing is linked, or too much to be seen.
    pub fn svg(&self) -> Option<String> {
        let mut names: Vec<&str> = Vec::new();
        let mut arrows: BTreeMap<(usize, usize), Vec<&str>> = BTreeMap::new();
        for (from, port, to) in &self.links {
            let mut place = |name| match names.iter().position(|other| *other == name) {
                Some(place) => place,
                None => {
                    names.push(name);
                    names.len() - 1
                }
            };
            arrows.entry((place(from.as_str()), place(to.as_str()))).or_default().push(port.as_str());
        }
        if names.is_empty() || names.len() > MOST_DRAWN {
            return None;
        }
        let reach = |upward: bool| {
            let these = arrows.keys().filter(|(from, to)| (from < to) == upward);
            these.map(|(from, to)| from.abs_diff(*to).max(1) * STEP + 24).max().unwrap_or(10)
        };
        let (top, below) = (reach(true), reach(false));
        let (width, height) = (names.len() * (WIDTH + APART) - APART + 20, top + HEIGHT + below);
        let mut text = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" width=\"{width}\" \
             font-family=\"sans-serif\" font-size=\"13\" text-anchor=\"middle\">\n<defs><marker id=\"link\" \
             viewBox=\"0 0 8 8\" refX=\"7\" refY=\"4\" markerWidth=\"8\" markerHeight=\"8\" orient=\"auto\">\
             <path d=\"M0,0 L8,4 L0,8 z\"/></marker></defs>\n"
        );
        for (place, name) in names.iter().enumerate() {
            let left = 10 + place * (WIDTH + APART);
            let (x, y) = (left + WIDTH / 2, top + HEIGHT / 2 + 5);
            let _ = writeln!(
                text,
                "<rect x=\"{left}\" y=\"{top}\" width=\"{WIDTH}\" height=\"{HEIGHT}\" rx=\"6\" fill=\"#eef3f8\" \
                 stroke=\"#345\"/><text x=\"{x}\" y=\"{y}\">{}</text>",
                shortened(name)
            );
        }
        for (ends, ports) in &arrows {
            arrow(&mut text, *ends, &ports.join(", "), top);
        }
        text.push_str("</svg>\n");
        Some(text)
    }
}

/// A curve from one box to another, with the ports beside it.
fn arrow(text: &mut String, (from, to): (usize, usize), ports: &str, top: usize) {
    let upward = from < to;
    let middle = |place: usize| 10 + place * (WIDTH + APART) + WIDTH / 2;
    // Arrows there and back leave and reach a box at different places.
    let (start, end) = if upward { (middle(from) + 30, middle(to) - 30) } else { (middle(from) - 30, middle(to) + 30) };
    let height = from.abs_diff(to).max(1) * STEP;
    let rise = (height * 4).div_ceil(3);
    let half = usize::midpoint(start, end);
    // A curve bends three quarters of the way to what it is drawn towards.
    let (edge, bend, label) = if upward {
        (top, top.saturating_sub(rise), top.saturating_sub(height + 5))
    } else {
        (top + HEIGHT, top + HEIGHT + rise, top + HEIGHT + height + 16)
    };
    let _ = writeln!(
        text,
        "<path d=\"M{start},{edge} C{start},{bend} {end},{bend} {end},{edge}\" fill=\"none\" stroke=\"#345\" \
         stroke-width=\"1.5\" marker-end=\"url(#link)\"/><text x=\"{half}\" y=\"{label}\">{ports}</text>"
    );
}

/// A name that fits into a box, in which no sign has a meaning of its own.
fn shortened(name: &str) -> String {
    let long = name.chars().count() > LONGEST;
    let kept: String = name.chars().take(if long { LONGEST - 1 } else { LONGEST }).collect();
    let kept = kept.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;");
    if long { kept + "…" } else { kept }
}
