//! Derivations for print: `align*` with the name of a law on each line, and only what changed underlined.

mod flow;

use std::fmt::Write as _;
use std::ops::Range;

use crate::explain::{Chain, Why};
use crate::law::{Connective, Laws};
use crate::lexer::{Keyword, Kind, Token};
use crate::mark::marked;
use crate::parser::{Role, parse};
use crate::term::Term;

pub use flow::phases;

/// Letters with a command of their own.
const GREEK: [(&str, &str); 28] = [
    ("α", "\\alpha"),
    ("β", "\\beta"),
    ("γ", "\\gamma"),
    ("δ", "\\delta"),
    ("ε", "\\varepsilon"),
    ("ζ", "\\zeta"),
    ("η", "\\eta"),
    ("θ", "\\theta"),
    ("κ", "\\kappa"),
    ("λ", "\\lambda"),
    ("μ", "\\mu"),
    ("ν", "\\nu"),
    ("ξ", "\\xi"),
    ("π", "\\pi"),
    ("ρ", "\\rho"),
    ("σ", "\\sigma"),
    ("τ", "\\tau"),
    ("φ", "\\varphi"),
    ("χ", "\\chi"),
    ("ψ", "\\psi"),
    ("ω", "\\omega"),
    ("Γ", "\\Gamma"),
    ("Δ", "\\Delta"),
    ("Θ", "\\Theta"),
    ("Λ", "\\Lambda"),
    ("Σ", "\\Sigma"),
    ("Φ", "\\Phi"),
    ("Ω", "\\Omega"),
];

/// A whole document that shows one derivation.
pub fn document(claim: &str, chain: &Chain, laws: &Laws) -> String {
    let claim = claim.split_whitespace().collect::<Vec<_>>().join(" ");
    format!(
        "\\documentclass{{article}}\n\\usepackage[T1]{{fontenc}}\n\\usepackage{{amsmath,amssymb}}\n\
         \\usepackage[landscape,margin=15mm]{{geometry}}\n\\allowdisplaybreaks\n\\begin{{document}}\n\
         \\noindent\\texttt{{{}}}\n{}\\end{{document}}\n",
        escaped(&claim),
        derivation(chain, laws)
    )
}

/// The derivation alone, for use inside a document with `amsmath`.
pub fn derivation(chain: &Chain, laws: &Laws) -> String {
    let mut out = format!("\\begin{{align*}}\n  & {}", process(&chain.start));
    let mut before = &chain.start;
    for line in &chain.lines {
        let sign = if line.connective == Connective::Equal { "=" } else { "\\le" };
        let title = match &line.why {
            Why::Law(name) => laws.get(name).map(|law| format!(": {}", law.title)).unwrap_or_default(),
            _ => String::new(),
        };
        let title = title.trim_end_matches('.');
        let way = if line.backwards { ", from right to left" } else { "" };
        let why = escaped(&format!("{}{way}{title}", line.why));
        let after = marked(before, &line.term);
        let _ = write!(out, " \\\\\n  {sign}{{}} & {} && \\text{{\\small {why}}}", math(&after.text, &after.places));
        before = &line.term;
    }
    if chain.cut {
        out.push_str(" \\\\\n  & \\cdots");
    }
    out + "\n\\end{align*}\n"
}

/// A process in mathematics.
pub fn process(term: &Term) -> String {
    math(&term.to_string(), &[])
}

/// A text for use outside of mathematics.
pub fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for letter in text.chars() {
        match letter {
            '\\' => out.push_str("\\textbackslash{}"),
            '~' => out.push_str("\\textasciitilde{}"),
            '^' => out.push_str("\\textasciicircum{}"),
            '<' => out.push_str("\\textless{}"),
            '>' => out.push_str("\\textgreater{}"),
            '|' => out.push_str("\\textbar{}"),
            '#' | '$' | '%' | '&' | '_' | '{' | '}' => {
                out.push('\\');
                out.push(letter);
            }
            _ => match GREEK.iter().find(|(greek, _)| greek.starts_with(letter)) {
                Some((_, command)) => {
                    let _ = write!(out, "${command}$");
                }
                None => out.push(letter),
            },
        }
    }
    out
}

/// Before a process, so that the text is an item.
const LEAD: &str = "simplify ";

/// The text of a process in mathematics, with these places of it underlined.
fn math(text: &str, places: &[Range<usize>]) -> String {
    let item = format!("{LEAD}{text}");
    let parsed = parse(&item);
    if !parsed.diagnostics.is_empty() {
        return format!("\\text{{\\texttt{{{}}}}}", escaped(text));
    }
    let tokens: Vec<(Token, Role)> = parsed
        .tokens
        .into_iter()
        .zip(parsed.roles)
        .skip(1)
        .filter(|(token, _)| token.kind != Kind::End)
        .map(|(token, role)| {
            let shift = |at: usize| at.saturating_sub(LEAD.len());
            let span = crate::diagnostic::Span::new(shift(token.span.start), shift(token.span.end));
            (Token { span, ..token }, role)
        })
        .collect();
    let mut setter = Setter { text, tokens: &tokens, places, out: String::new(), place: 0 };
    setter.until(tokens.len());
    setter.out
}

struct Setter<'a> {
    text: &'a str,
    tokens: &'a [(Token, Role)],
    places: &'a [Range<usize>],
    out: String,
    place: usize,
}

impl Setter<'_> {
    fn until(&mut self, end: usize) {
        while self.place < end {
            let Some((token, role)) = self.tokens.get(self.place).copied() else { return };
            for place in self.places.iter().filter(|place| place.start == token.span.start) {
                if place.end > place.start {
                    self.out.push_str("\\underline{");
                }
            }
            self.place += 1;
            match (token.kind, self.brackets(token)) {
                (Kind::Underscore | Kind::Caret, _) => self.script(token.kind),
                (_, Some((open, close))) => {
                    let end = self.closing(self.place, Kind::OpenRound, Kind::CloseRound);
                    self.out.push_str(open);
                    self.place += 1;
                    self.until(end);
                    self.out.push_str(close);
                    self.place += 1;
                }
                _ => self.token(token, role),
            }
            let close = self.places.iter().filter(|place| place.end == self.end() && place.end > place.start).count();
            self.out.push_str(&"}".repeat(close));
        }
    }

    /// The brackets of a function that is written as such, when its name stands before one.
    fn brackets(&self, token: Token) -> Option<(&'static str, &'static str)> {
        let called = self.tokens.get(self.place).is_some_and(|(next, _)| next.kind == Kind::OpenRound);
        match token.span.of(self.text) {
            "sqrt" if called => Some(("\\sqrt{", "}")),
            "floor" if called => Some(("\\lfloor ", "\\rfloor ")),
            "ceil" if called => Some(("\\lceil ", "\\rceil ")),
            "abs" if called => Some(("\\lvert ", "\\rvert ")),
            _ => None,
        }
    }

    /// Where the token before ends.
    fn end(&self) -> usize {
        self.place.checked_sub(1).and_then(|place| self.tokens.get(place)).map_or(0, |(token, _)| token.span.end)
    }

    /// What stands below or above: a bracketed group, or one token with its sign.
    fn script(&mut self, kind: Kind) {
        // A marked place is a whole part: it ends behind its script, not in it.
        let places = std::mem::take(&mut self.places);
        self.out.push(if kind == Kind::Caret { '^' } else { '_' });
        self.out.push('{');
        let first = self.tokens.get(self.place).map(|(token, _)| token.kind);
        let sign = usize::from(first == Some(Kind::Minus));
        let group = |open: Kind, close: Kind| self.closing(self.place + sign, open, close);
        match self.tokens.get(self.place + sign).map(|(token, _)| token.kind) {
            Some(Kind::OpenCurly) => {
                let end = group(Kind::OpenCurly, Kind::CloseCurly);
                self.place += sign + 1;
                self.until(end);
                self.place += 1;
            }
            Some(Kind::OpenRound) => {
                let end = group(Kind::OpenRound, Kind::CloseRound);
                self.until(end + 1);
            }
            _ => self.until(self.place + sign + 1),
        }
        self.out.push('}');
        self.places = places;
    }

    /// The place of the bracket that closes the one at this place.
    fn closing(&self, start: usize, open: Kind, close: Kind) -> usize {
        let mut depth = 0usize;
        for (place, (token, _)) in self.tokens.iter().enumerate().skip(start) {
            if token.kind == open {
                depth += 1;
            } else if token.kind == close {
                depth = depth.saturating_sub(1);
                if depth == 0 {
                    return place;
                }
            }
        }
        self.tokens.len()
    }

    fn token(&mut self, token: Token, role: Role) {
        let written = token.span.of(self.text);
        let piece = match token.kind {
            Kind::Upper => format!("\\mathsf{{{}}}", name(written)),
            Kind::Lower if self.tokens.get(self.place).is_some_and(|(next, _)| next.kind == Kind::OpenRound) => {
                format!("\\operatorname{{{}}}", name(written))
            }
            Kind::Lower => letter(written),
            Kind::Meta => letter(written.trim_start_matches('?')),
            Kind::Word(Keyword::New) => "\\mathsf{new}\\,".to_string(),
            Kind::Word(Keyword::Try | Keyword::Loop) => format!("\\mathsf{{{written}}}"),
            Kind::Word(word) => format!("\\mathbin{{\\mathsf{{{}}}}}", word.spelling()),
            Kind::Semicolon => "\\mathbin{;}".to_string(),
            Kind::Bar if role == Role::Opening => "\\lvert ".to_string(),
            Kind::Bar if role == Role::Closing => "\\rvert ".to_string(),
            Kind::Bar => "\\parallel ".to_string(),
            Kind::Hash => "\\mathbin{\\#}".to_string(),
            Kind::Less if role != Role::Plain => "\\langle ".to_string(),
            Kind::Greater if role != Role::Plain => "\\rangle ".to_string(),
            Kind::LessEqual => "\\le ".to_string(),
            Kind::GreaterEqual => "\\ge ".to_string(),
            Kind::NotEqual => "\\ne ".to_string(),
            Kind::Assign => "\\mathrel{:=}".to_string(),
            Kind::Star => "\\cdot ".to_string(),
            Kind::Colon => "{:}\\,".to_string(),
            Kind::Dot => ".\\,".to_string(),
            Kind::OpenCurly => "\\{".to_string(),
            Kind::CloseCurly => "\\}".to_string(),
            Kind::Less => "<".to_string(),
            Kind::Greater => ">".to_string(),
            Kind::Minus => "-".to_string(),
            _ => escaped(written),
        };
        self.out.push_str(&piece);
    }
}

/// A name of one letter, or of several set as one word.
fn letter(text: &str) -> String {
    if let Some((_, command)) = GREEK.iter().find(|(greek, _)| *greek == text) {
        return format!("{command} ");
    }
    if text.chars().count() == 1 { name(text) } else { format!("\\mathit{{{}}}", name(text)) }
}

/// The letters of a name inside mathematics.
fn name(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for letter in text.chars() {
        match GREEK.iter().find(|(greek, _)| greek.starts_with(letter)) {
            Some((_, command)) => {
                let _ = write!(out, "{command} ");
            }
            None if letter == '_' => out.push_str("\\_"),
            None => out.push(letter),
        }
    }
    out
}
