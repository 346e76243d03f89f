//! A report as a page of its own, in HTML or Markdown: verdict, threshold and margin first, then what limits it, then
//! pictures, the model, the assumptions, the laws used and what was taken on trust.

use std::fmt::Write;

use crate::criteria::repair::is_short;
use crate::criteria::{Measure, Standing};
use crate::law::Laws;
use crate::picture::Picture;
use crate::report::{Assessment, Output, Report, Verdict};

/// What a page is made of.
pub struct Page<'a> {
    /// Its title.
    pub title: String,
    /// The texts of the model, each with its name.
    pub texts: Vec<(String, String)>,
    /// What the session answered, in order.
    pub outputs: Vec<Output>,
    /// The laws in force.
    pub laws: &'a Laws,
}

const STYLE: &str = "
body{font:16px/1.5 system-ui,sans-serif;max-width:60rem;margin:2rem auto;padding:0 1rem;color:#1b1b1b;background:#fff}
h1{font-size:1.6rem}h2{font-size:1.2rem;margin-top:2.5rem;border-top:1px solid #ccc;padding-top:1rem}h3{font-size:1rem}
pre{background:#f4f4f4;padding:.8rem;font-size:.85rem;white-space:pre-wrap;overflow-wrap:anywhere}
figure{margin:1rem 0}li,h1,h2{overflow-wrap:anywhere}table{border-collapse:collapse;width:100%}
th,td{text-align:left;padding:.3rem .6rem;border-bottom:1px solid #ddd;vertical-align:top}
.verdict{display:inline-block;padding:.1rem .6rem;border-radius:.3rem;font-weight:700;color:#fff}
.good{background:#1b6e3c}.bad{background:#a31515}.open{background:#6b5900}
svg{max-width:100%;height:auto}.table{overflow-x:auto}
";

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// A verdict in words.
fn word(report: &Report) -> &'static str {
    report.verdict.spelling()
}

fn class(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Proved | Verdict::Met => "good",
        Verdict::Refuted | Verdict::NotMet => "bad",
        Verdict::Open => "open",
    }
}

fn standing_class(standing: Standing) -> &'static str {
    match standing {
        Standing::Met => "good",
        Standing::NotMet => "bad",
        Standing::Open => "open",
    }
}

/// A row a criterion: verdict, what was asked, what was measured, the margin.
fn rows(assessment: &Assessment) -> Vec<[String; 4]> {
    let text = |measure: &Option<Measure>| measure.as_ref().map(Measure::readable).unwrap_or_default();
    let row = |finding: &crate::criteria::Finding| {
        let short = finding.margin.as_ref().is_some_and(is_short);
        let margin = text(&finding.margin);
        let margin = if short { format!("{margin} (short)") } else { margin };
        [finding.standing.spelling().to_string(), finding.text.clone(), text(&finding.value), margin]
    };
    assessment.findings.iter().map(row).collect()
}

/// What limits criteria: each that stands in the way, and what decides it.
fn limiting(assessment: &Assessment) -> Vec<String> {
    let mut lines = Vec::new();
    for finding in assessment.limiting() {
        lines.push(finding.text.clone());
        lines.extend(finding.notes.iter().cloned());
        let feedback = assessment.advice.feedback.iter().find(|feedback| feedback.name == finding.name);
        lines.extend(feedback.into_iter().flat_map(|feedback| feedback.blame.clone()));
    }
    lines
}

/// The laws that a claim rests on: name, title, equation.
fn laws(report: &Report, laws: &Laws) -> Vec<String> {
    let known = report.laws.iter().map(|name| match laws.get(name) {
        Some(law) => format!("{name}: {}, {} {} {}", law.title, law.left, law.connective, law.right),
        None => name.to_string(),
    });
    known.collect()
}

/// The values found and the probability, as lines.
fn measured(report: &Report) -> Vec<String> {
    let mut lines = Vec::new();
    lines.extend(report.asked.clone());
    lines.extend(report.trace.iter().filter(|line| decides(line)).cloned());
    if let Some(chance) = &report.chance {
        let (low, high) = (chance.low, chance.high);
        let sure = chance.confidence.map_or(String::new(), |sure| format!(", with confidence {sure}"));
        lines.push(format!("probability between {low} and {high} (rounded outward; {}{sure})", chance.method));
    }
    if report.assessment.is_none() {
        let named = |(name, value): &(crate::name::Name, crate::value::Value)| format!("{name} = {value}");
        lines.extend(report.values.iter().map(named));
        lines.extend(report.steady.iter().map(|pair| format!("in later rounds {}", named(pair))));
    }
    lines
}

/// Whether a line says by how much a claim about all times holds, or where it fails.
fn decides(line: &str) -> bool {
    ["there ", "the least ", "the greatest ", "note: it holds for want", "from round "]
        .iter()
        .any(|start| line.starts_with(start))
}

impl Page<'_> {
    fn reports(&self) -> impl Iterator<Item = &Report> {
        self.outputs.iter().filter_map(|output| if let Output::Claim(report) = output { Some(&**report) } else { None })
    }

    /// The chances that were only asked for: the question, and what was found.
    fn chances(&self) -> impl Iterator<Item = (&str, &str)> {
        self.outputs.iter().filter_map(|output| match output {
            Output::Answer(answer) if answer.kind == "probability" => {
                Some((answer.question.as_str(), answer.lines.first()?.as_str()))
            }
            _ => None,
        })
    }

    /// The page as HTML that needs nothing beside it.
    pub fn html(&self) -> String {
        let mut out = String::new();
        let title = escaped(&self.title);
        let _ = write!(
            out,
            "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
             <title>{title}</title>\n<style>{STYLE}</style>\n</head>\n<body>\n<h1>{title}</h1>\n"
        );
        out.push_str("<div class=\"table\"><table><thead><tr><th>Verdict</th><th>Claim</th></tr></thead><tbody>\n");
        for (number, report) in self.reports().enumerate() {
            let (class, word) = (class(report.verdict), word(report));
            let claim = escaped(&report.claim);
            let _ = writeln!(
                out,
                "<tr><td><span class=\"verdict {class}\">{word}</span></td><td><a href=\"#claim{number}\">{claim}</a></td></tr>"
            );
        }
        for (question, found) in self.chances() {
            let _ = writeln!(out, "<tr><td>{}</td><td>{}</td></tr>", escaped(found), escaped(question));
        }
        out.push_str("</tbody></table></div>\n");
        let mut number = 0;
        for output in &self.outputs {
            match output {
                Output::Claim(report) => {
                    self.claim_html(report, number, &mut out);
                    number += 1;
                }
                Output::Answer(answer) => {
                    let _ = writeln!(out, "<h2>{}</h2>", escaped(&answer.question));
                    html_lines(&mut out, "", &answer.lines);
                    html_table(&mut out, &answer.table);
                    html_pictures(&mut out, &answer.pictures);
                }
                Output::Trouble(source, diagnostics) => {
                    let text = crate::diagnostic::render_all(diagnostics, source, false);
                    let _ = writeln!(out, "<h2>Trouble</h2><pre>{}</pre>", escaped(&text));
                }
                Output::Declared(_) | Output::Note(_) => {}
            }
        }
        for (name, text) in &self.texts {
            let _ = writeln!(out, "<h2>The model: {}</h2>\n<pre>{}</pre>", escaped(name), escaped(text));
        }
        out.push_str("</body>\n</html>\n");
        out
    }

    fn claim_html(&self, report: &Report, number: usize, out: &mut String) {
        let (class, word) = (class(report.verdict), word(report));
        let claim = escaped(&report.claim);
        let _ = writeln!(out, "<h2 id=\"claim{number}\"><span class=\"verdict {class}\">{word}</span> {claim}</h2>");
        if let Some(assessment) = &report.assessment {
            out.push_str(
                "<div class=\"table\"><table><thead><tr><th>Verdict</th><th>Criterion</th><th>Measured</th>\
                 <th>Margin</th></tr></thead><tbody>\n",
            );
            for (row, finding) in rows(assessment).iter().zip(&assessment.findings) {
                let [word, text, value, margin] = row.each_ref().map(|cell| escaped(cell));
                let class = standing_class(finding.standing);
                let _ = writeln!(
                    out,
                    "<tr><td><span class=\"verdict {class}\">{word}</span></td><td>{text}</td><td>{value}</td><td>{margin}</td></tr>"
                );
            }
            out.push_str("</tbody></table></div>\n");
            html_lines(out, "What limits it", &limiting(assessment));
        }
        html_lines(out, "", &measured(report));
        html_lines(out, "What could be changed", &report.feedback);
        if let Some(links) = &report.links {
            let _ = writeln!(out, "<figure>{links}<figcaption>Who reads what from whom</figcaption></figure>");
        }
        html_pictures(out, &report.pictures);
        let detail: Vec<String> = report.trace.iter().chain(&report.remains).cloned().collect();
        if !detail.is_empty() {
            let _ = writeln!(out, "<h3>In detail</h3>\n<pre>{}</pre>", escaped(&detail.join("\n")));
        }
        html_lines(out, "Assumptions", &report.assumed);
        html_lines(out, "Laws used", &laws(report, self.laws));
        html_lines(out, "Taken on trust", &report.trusted);
    }

    /// The page as Markdown, its pictures in signs.
    pub fn markdown(&self) -> String {
        let mut out = format!("# {}\n\n| verdict | claim |\n|---|---|\n", self.title);
        for report in self.reports() {
            let _ = writeln!(out, "| **{}** | {} |", word(report), cell(&report.claim));
        }
        for (question, found) in self.chances() {
            let _ = writeln!(out, "| {} | {} |", cell(found), cell(question));
        }
        for output in &self.outputs {
            match output {
                Output::Claim(report) => self.claim_markdown(report, &mut out),
                Output::Answer(answer) => {
                    let _ = writeln!(out, "\n## `{}`\n", one_line(&answer.question));
                    fence(&mut out, &answer.lines.join("\n"));
                    markdown_table(&mut out, &answer.table);
                    markdown_pictures(&mut out, &answer.pictures);
                }
                Output::Trouble(source, diagnostics) => {
                    out.push_str("\n## Trouble\n\n");
                    fence(&mut out, &crate::diagnostic::render_all(diagnostics, source, false));
                }
                Output::Declared(_) | Output::Note(_) => {}
            }
        }
        for (name, text) in &self.texts {
            let _ = writeln!(out, "\n## The model: {name}\n");
            fence(&mut out, text);
        }
        out
    }

    fn claim_markdown(&self, report: &Report, out: &mut String) {
        let _ = writeln!(out, "\n## {}: `{}`\n", word(report), one_line(&report.claim));
        if let Some(assessment) = &report.assessment {
            out.push_str("| verdict | criterion | measured | margin |\n|---|---|---|---|\n");
            for row in rows(assessment) {
                let _ = writeln!(out, "| {} |", row.each_ref().map(|text| cell(text)).join(" | "));
            }
            markdown_lines(out, "What limits it", &limiting(assessment));
        }
        markdown_lines(out, "Measured", &measured(report));
        markdown_lines(out, "What could be changed", &report.feedback);
        markdown_pictures(out, &report.pictures);
        let detail: Vec<String> = report.trace.iter().chain(&report.remains).cloned().collect();
        if !detail.is_empty() {
            out.push_str("\n### In detail\n\n");
            fence(out, &detail.join("\n"));
        }
        markdown_lines(out, "Assumptions", &report.assumed);
        markdown_lines(out, "Laws used", &laws(report, self.laws));
        markdown_lines(out, "Taken on trust", &report.trusted);
    }

    /// The answers as they stand at a terminal, with pictures in signs.
    pub fn terminal(&self, colour: bool) -> String {
        let mut out = String::new();
        for output in &self.outputs {
            if !matches!(output, Output::Declared(_)) {
                out.push_str(&output.text(colour));
            }
            let pictures = match output {
                Output::Claim(report) => &report.pictures,
                Output::Answer(answer) => &answer.pictures,
                _ => continue,
            };
            for line in pictures.iter().flat_map(Picture::signs) {
                let _ = writeln!(out, "    {line}");
            }
        }
        out
    }
}

/// The most rows of a table on a page.
const MOST_ROWS: usize = 500;

fn html_table(out: &mut String, table: &[Vec<String>]) {
    let Some((heading, rows)) = table.split_first() else { return };
    let line = |cells: &Vec<String>, kind: &str| {
        let cells = cells.iter().map(|cell| format!("<{kind}>{}</{kind}>", escaped(cell)));
        format!("<tr>{}</tr>\n", cells.collect::<String>())
    };
    let body: String = rows.iter().take(MOST_ROWS).map(|row| line(row, "td")).collect();
    let heading = line(heading, "th");
    out.push_str("<div class=\"table\"><table><thead>");
    let _ = writeln!(out, "{heading}</thead><tbody>\n{body}</tbody></table></div>");
    if let Some(more) = left_out(rows) {
        let _ = writeln!(out, "<p>{more}</p>");
    }
}

fn markdown_table(out: &mut String, table: &[Vec<String>]) {
    let Some((heading, rows)) = table.split_first() else { return };
    let line =
        |cells: &Vec<String>| format!("| {} |", cells.iter().map(|text| cell(text)).collect::<Vec<_>>().join(" | "));
    let _ = writeln!(out, "\n{}\n|{}", line(heading), "---|".repeat(heading.len()));
    for row in rows.iter().take(MOST_ROWS) {
        let _ = writeln!(out, "{}", line(row));
    }
    if let Some(more) = left_out(rows) {
        let _ = writeln!(out, "\n{more}");
    }
}

/// What is said of points for which a page has no room.
fn left_out(rows: &[Vec<String>]) -> Option<String> {
    let more = rows.len().checked_sub(MOST_ROWS).filter(|more| *more > 0)?;
    Some(format!("Points that are left out here: {more}. The command pars sweep writes all of them."))
}

fn html_pictures(out: &mut String, pictures: &[Picture]) {
    for picture in pictures {
        let title = escaped(&picture.title);
        let _ = writeln!(out, "<figure>{}<figcaption>{title} (rounded)</figcaption></figure>", picture.svg());
    }
}

fn markdown_pictures(out: &mut String, pictures: &[Picture]) {
    for picture in pictures {
        out.push('\n');
        fence(out, &picture.signs().join("\n"));
    }
}

fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// A text within a table of Markdown.
fn cell(text: &str) -> String {
    one_line(text).replace('|', "\\|").replace('<', "&lt;")
}

/// A block of text as it stands; longer fences where the text has fences of its own.
fn fence(out: &mut String, text: &str) {
    let mut ticks = "```".to_string();
    while text.contains(&ticks) {
        ticks.push('`');
    }
    let _ = writeln!(out, "{ticks}\n{}\n{ticks}", text.trim_end());
}

fn markdown_lines(out: &mut String, title: &str, lines: &[String]) {
    if lines.is_empty() {
        return;
    }
    let _ = writeln!(out, "\n### {title}\n");
    for line in lines {
        let _ = writeln!(out, "- `{}`", line.trim().replace('`', "'"));
    }
}

fn html_lines(out: &mut String, title: &str, lines: &[String]) {
    if lines.is_empty() {
        return;
    }
    if !title.is_empty() {
        let _ = writeln!(out, "<h3>{title}</h3>");
    }
    out.push_str("<ul>\n");
    for line in lines {
        let _ = writeln!(out, "<li>{}</li>", escaped(line.trim()));
    }
    out.push_str("</ul>\n");
}
