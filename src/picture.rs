//! Pictures of runs and distributions: as SVG for a page, in signs for a terminal. What they show is rounded.

mod run;

use plotters::prelude::{
    AreaSeries, BLACK, ChartBuilder, Color, IntoDrawingArea, IntoTextStyle, LineSeries, PathElement, RGBColor,
    Rectangle, SVGBackend, SeriesLabelPosition, Text, WHITE,
};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use textplots::{Chart, Plot, Shape};

pub use run::{of_run, of_runs};

/// A curve.
#[derive(Clone, Debug, Default)]
pub struct Line {
    /// What it shows.
    pub name: String,
    /// Its points, from left to right.
    pub points: Vec<(f64, f64)>,
}

/// A picture with axes.
#[derive(Clone, Debug, Default)]
pub struct Picture {
    /// What it shows.
    pub title: String,
    /// The axis to the right.
    pub across: String,
    /// The axis up.
    pub up: String,
    /// The curves.
    pub lines: Vec<Line>,
    /// Whether the curves are of one kind: one colour for all, and no names.
    pub alike: bool,
    /// Stretches of the axis up that matter, with what they are: a goal to within its radius.
    pub bands: Vec<(f64, f64, String)>,
    /// Places on the axis to the right that matter: a deadline.
    pub marks: Vec<(f64, String)>,
    /// A stretch of the axis to the right under which the first curve is filled.
    pub filled: Option<(f64, f64)>,
}

impl Line {
    /// Its stretches that hang together: a point that is no number parts them.
    fn pieces(&self) -> impl Iterator<Item = &[(f64, f64)]> {
        self.points.split(|(x, y)| !(x.is_finite() && y.is_finite())).filter(|piece| !piece.is_empty())
    }
}

/// Colours that people who see fewer of them can tell apart.
const COLOURS: [RGBColor; 6] = [
    RGBColor(33, 102, 172),
    RGBColor(178, 24, 43),
    RGBColor(77, 146, 33),
    RGBColor(118, 42, 131),
    RGBColor(224, 130, 20),
    RGBColor(90, 90, 90),
];

type Failure = Box<dyn std::error::Error>;

impl Picture {
    /// The least and the greatest of what is drawn, with some room; none where nothing is drawn.
    fn frame(&self) -> Option<[f64; 4]> {
        let points = || self.lines.iter().flat_map(|line| &line.points).filter(|(x, y)| x.is_finite() && y.is_finite());
        points().next()?;
        let least = |numbers: &mut dyn Iterator<Item = f64>| numbers.fold(f64::INFINITY, f64::min);
        let most = |numbers: &mut dyn Iterator<Item = f64>| numbers.fold(f64::NEG_INFINITY, f64::max);
        let right = || points().map(|(x, _)| *x).chain(self.marks.iter().map(|(x, _)| *x));
        let up = || points().map(|(_, y)| *y).chain(self.bands.iter().flat_map(|(low, high, _)| [*low, *high]));
        let (left, right) = (least(&mut right()), most(&mut right()));
        let (low, high) = (least(&mut up()), most(&mut up()));
        let room = |low: f64, high: f64, part: f64| if high > low { (high - low) * part } else { 0.5 };
        let (aside, above) = (room(left, right, 0.02), room(low, high, 0.08));
        // The names of the curves stand above them all.
        let names = if self.named() { 0.12 * self.lines.len() as f64 } else { 0.0 };
        Some([left - aside, right + aside, low - above, high + above + room(low, high, names)])
    }

    /// Whether its curves have names beside them.
    fn named(&self) -> bool {
        self.lines.len() > 1 && !self.alike
    }

    /// As SVG, which can stand within a page; empty where nothing is drawn.
    pub fn svg(&self) -> String {
        let mut text = String::new();
        let Some(frame) = self.frame() else { return text };
        match self.draw(frame, &mut text) {
            Ok(()) => text,
            Err(_) => String::new(),
        }
    }

    fn draw(&self, [left, right, low, high]: [f64; 4], text: &mut String) -> Result<(), Failure> {
        let root = SVGBackend::with_string(text, (760, 340)).into_drawing_area();
        root.fill(&WHITE)?;
        let mut chart = ChartBuilder::on(&root)
            .caption(&self.title, ("sans-serif", 16))
            .margin(12)
            .x_label_area_size(42)
            .y_label_area_size(64)
            .build_cartesian_2d(left..right, low..high)?;
        let marks = |low: f64, high: f64| move |at: &f64| mark(*at, high - low);
        let (across, up) = (marks(left, right), marks(low, high));
        let mut mesh = chart.configure_mesh();
        mesh.x_desc(&self.across).y_desc(&self.up).light_line_style(WHITE);
        mesh.x_label_formatter(&across).y_label_formatter(&up).draw()?;
        for (from, to, name) in &self.bands {
            let style = COLOURS[2].mix(0.18).filled();
            chart.draw_series([Rectangle::new([(left, *from), (right, *to)], style)])?;
            let edge = COLOURS[2].mix(0.6);
            chart.draw_series([PathElement::new(vec![(left, *from), (right, *from)], edge)])?;
            let style = ("sans-serif", 12).into_text_style(&root).pos(Pos::new(HPos::Right, VPos::Bottom));
            chart.draw_series([Text::new(name.clone(), (right, *to), style)])?;
        }
        if let (Some((from, to)), Some(line)) = (self.filled, self.lines.first()) {
            let inside = line.points.iter().filter(|(x, _)| *x >= from && *x <= to).copied();
            chart.draw_series(AreaSeries::new(inside, 0.0, COLOURS[0].mix(0.3)))?;
        }
        for (place, name) in &self.marks {
            let style = COLOURS[1].stroke_width(1);
            chart.draw_series([PathElement::new(vec![(*place, low), (*place, high)], style)])?;
            chart.draw_series([Text::new(name.clone(), (*place, high), ("sans-serif", 12))])?;
        }
        for (number, line) in self.lines.iter().enumerate() {
            let colour = if self.alike { COLOURS[0] } else { COLOURS[number % COLOURS.len()] };
            let style = if self.alike { colour.mix(0.6).stroke_width(1) } else { colour.stroke_width(2) };
            for (place, piece) in line.pieces().enumerate() {
                let series = chart.draw_series(LineSeries::new(piece.iter().copied(), style))?;
                if place == 0 {
                    let legend = move |(x, y)| PathElement::new(vec![(x, y), (x + 16, y)], colour);
                    series.label(line.name.clone()).legend(legend);
                }
            }
        }
        if self.named() {
            let place = SeriesLabelPosition::UpperRight;
            let mut labels = chart.configure_series_labels();
            labels.position(place).background_style(WHITE.mix(0.8)).border_style(BLACK.mix(0.3)).draw()?;
        }
        root.present()?;
        Ok(())
    }

    /// In signs, each line of it apart; nothing where nothing is drawn.
    pub fn signs(&self) -> Vec<String> {
        let Some([left, right, low, high]) = self.frame() else { return Vec::new() };
        let mut all = vec![self.title.clone()];
        let narrow = |number: f64| number as f32;
        let points = |piece: &[(f64, f64)]| piece.iter().map(|(x, y)| (narrow(*x), narrow(*y))).collect();
        let drawn: Vec<Vec<(f32, f32)>> = self.lines.iter().flat_map(Line::pieces).map(points).collect();
        let shapes: Vec<Shape<'_>> = drawn.iter().map(|points| Shape::Lines(points)).collect();
        let frame = [left, right, low, high].map(narrow);
        let mut chart = Chart::new_with_y_range(120, 40, frame[0], frame[1], frame[2], frame[3]);
        let mut whole = &mut chart;
        for shape in &shapes {
            whole = whole.lineplot(shape);
        }
        whole.axis();
        whole.figures();
        all.extend(whole.to_string().lines().map(|line| line.trim_end().to_string()));
        all.push(format!("{} to the right, {} up (rounded)", self.across, self.up));
        all
    }
}

/// The text of a mark on an axis of this length, with as many digits as tell one mark from the next.
fn mark(at: f64, length: f64) -> String {
    // A tenth of the length, about the distance of two marks.
    let step = (length / 10.0).log10().floor();
    let whole = if at.abs() < length * 1e-9 { 0.0 } else { at };
    if !step.is_finite() {
        return format!("{whole}");
    }
    let large = whole.abs().max(length).log10().floor();
    if step < -4.0 && large < -2.0 || large > 6.0 {
        let digits = (large - step).clamp(0.0, 12.0) as usize;
        return if whole == 0.0 { "0".to_string() } else { format!("{whole:.digits$e}") };
    }
    let digits = (-step).clamp(0.0, 12.0) as usize;
    format!("{whole:.digits$}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn marks_that_differ_are_written_differently() {
        for length in [1e-12, 3e-7, 2e-4, 0.05, 1.0, 7.0, 40.0, 1e5, 3e9] {
            for start in [0.0, length, -length / 2.0] {
                let all: Vec<String> =
                    (0..=10).map(|part| mark(start + length * f64::from(part) / 10.0, length)).collect();
                assert!(all.windows(2).all(|pair| pair[0] != pair[1]), "{all:?}");
            }
        }
        assert_eq!(mark(0.30000000000000004, 1.0), "0.3");
        assert_eq!(mark(20.0, 40.0), "20");
    }

    #[test]
    fn what_was_not_shown_for_a_while_is_not_joined() {
        let gap = Line { name: "At".to_string(), points: vec![(0.0, 1.0), (1.0, 1.0), (3.0, f64::NAN), (3.0, 2.0)] };
        let pieces: Vec<&[(f64, f64)]> = gap.pieces().collect();
        assert_eq!(pieces, [&[(0.0, 1.0), (1.0, 1.0)][..], &[(3.0, 2.0)][..]]);
        let drawn = Picture { lines: vec![gap], ..Picture::default() }.svg();
        assert_eq!(drawn.matches("stroke-width=\"2\"").count(), 2, "{drawn}");
    }
}
