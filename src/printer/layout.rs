//! The canonical layout of a file: one space around operators, none inside parameters, an item a line.
//!
//! Line breaks inside an item and comments stay where they were put. Laying out a laid-out file changes nothing.

use crate::diagnostic::{Diagnostic, Span};
use crate::lexer::{Kind, lex};
use crate::parser::{Role, parse};

/// The file in canonical layout.
///
/// # Errors
/// What is wrong with the file, when it does not parse.
pub fn format(text: &str) -> Result<String, Vec<Diagnostic>> {
    let parsed = parse(text);
    if !parsed.diagnostics.is_empty() {
        return Err(parsed.diagnostics);
    }
    let mut pieces: Vec<Piece> = parsed
        .tokens
        .iter()
        .zip(&parsed.roles)
        .map(|(token, role)| Piece::new(token.kind, *role, token.span))
        .collect();
    pieces.extend(
        parsed.comments.iter().map(|span| Piece { comment: true, ..Piece::new(Kind::Unknown, Role::Plain, *span) }),
    );
    pieces.sort_by_key(|piece| (piece.span.start, piece.span.end));
    let mut layout = Layout { source: text, text: String::new(), open: Vec::new() };
    for (index, piece) in pieces.iter().enumerate() {
        if piece.kind == Kind::End {
            break;
        }
        let before = index.checked_sub(1).and_then(|index| pieces.get(index));
        let next = pieces.iter().skip(index).find(|piece| !piece.comment);
        layout.put(before, piece, next);
    }
    if !layout.text.is_empty() {
        layout.text.push('\n');
    }
    // A layout that changed what the file says would be worse than none.
    Ok(if same(text, &layout.text) { layout.text } else { text.to_string() })
}

/// Whether two texts have the same tokens.
fn same(left: &str, right: &str) -> bool {
    let (one, other) = (lex(left), lex(right));
    one.tokens.len() == other.tokens.len()
        && one.comments.len() == other.comments.len()
        && one.tokens.iter().zip(&other.tokens).all(|(a, b)| {
            a.kind == b.kind && (spelling(a.kind).is_some() || a.span.of(left).trim() == b.span.of(right).trim())
        })
}

#[derive(Clone, Copy)]
struct Piece {
    kind: Kind,
    role: Role,
    span: Span,
    comment: bool,
}

impl Piece {
    fn new(kind: Kind, role: Role, span: Span) -> Piece {
        Piece { kind, role, span, comment: false }
    }
}

/// What an open bracket holds.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Inside {
    /// Parameters in braces: no spaces at all.
    Parameters,
    /// Arguments in round brackets: spaces behind commas.
    Arguments,
    /// Anything else.
    Open,
}

struct Layout<'t> {
    source: &'t str,
    text: String,
    open: Vec<(Inside, bool)>,
}

impl Layout<'_> {
    /// Writes the next piece with what belongs between it and the one before.
    fn put(&mut self, before: Option<&Piece>, piece: &Piece, next: Option<&Piece>) {
        if let Some(before) = before {
            let lines = self.source.get(before.span.end..piece.span.start).unwrap_or("").matches('\n').count();
            let item = if piece.comment {
                next.is_none_or(|next| matches!(next.role, Role::Item) || next.kind == Kind::End)
            } else {
                piece.role == Role::Item
            };
            let breaks =
                lines > 0 || before.comment || (!piece.comment && matches!(piece.role, Role::Item | Role::Line));
            if breaks {
                self.text.push_str(if item && lines > 1 { "\n\n" } else { "\n" });
                self.text.push_str(if item {
                    ""
                } else if piece.role == Role::Line {
                    "  "
                } else {
                    "    "
                });
            } else if piece.comment {
                self.text.push_str("  ");
            } else if self.spaced(before, piece) {
                self.text.push(' ');
            }
        }
        if piece.comment {
            self.text.push_str(piece.span.of(self.source).trim_end());
            return;
        }
        self.brackets(before, piece);
        let written = piece.span.of(self.source).trim();
        self.text.push_str(spelling(piece.kind).unwrap_or(written));
    }

    fn compact(&self) -> bool {
        self.open.last().is_some_and(|(_, compact)| *compact)
    }

    fn brackets(&mut self, before: Option<&Piece>, piece: &Piece) {
        match piece.kind {
            Kind::OpenRound | Kind::OpenCurly | Kind::OpenSquare => {
                let names = before.is_some_and(|before| matches!(before.kind, Kind::Upper | Kind::Lower | Kind::Meta));
                let inside = match piece.kind {
                    Kind::OpenCurly
                        if before.is_some_and(|before| matches!(before.kind, Kind::Underscore | Kind::Caret)) =>
                    {
                        Inside::Parameters
                    }
                    Kind::OpenRound if piece.role == Role::Joining && names => Inside::Arguments,
                    _ => Inside::Open,
                };
                let compact = inside == Inside::Parameters || self.compact();
                self.open.push((inside, compact));
            }
            Kind::CloseRound | Kind::CloseCurly | Kind::CloseSquare => {
                self.open.pop();
            }
            _ => {}
        }
    }

    fn spaced(&self, before: &Piece, piece: &Piece) -> bool {
        if before.role == Role::Spaced || piece.role == Role::Spaced {
            return true;
        }
        let opens = matches!(before.kind, Kind::OpenRound | Kind::OpenCurly | Kind::OpenSquare);
        let closes = matches!(piece.kind, Kind::CloseRound | Kind::CloseCurly | Kind::CloseSquare | Kind::Comma);
        if opens
            || closes
            || matches!(before.role, Role::Opening | Role::Joining)
            || matches!(piece.role, Role::Joining | Role::Closing)
        {
            return false;
        }
        if before.kind == Kind::Comma {
            return !matches!(self.open.last(), Some((Inside::Parameters, _)));
        }
        let sign = |kind: Kind| matches!(kind, Kind::Plus | Kind::Minus | Kind::Star | Kind::Slash) || relation(kind);
        !(self.compact() && (sign(before.kind) || sign(piece.kind)))
    }
}

fn relation(kind: Kind) -> bool {
    matches!(kind, Kind::Less | Kind::LessEqual | Kind::Greater | Kind::GreaterEqual | Kind::Equal | Kind::NotEqual)
}

/// The one spelling of a sign that has several.
fn spelling(kind: Kind) -> Option<&'static str> {
    Some(match kind {
        Kind::Bar => "|",
        Kind::Less => "<",
        Kind::Greater => ">",
        Kind::LessEqual => "<=",
        Kind::Weak => "~~",
        Kind::LessWeak => "<~",
        Kind::GreaterEqual => ">=",
        Kind::NotEqual => "!=",
        Kind::Minus => "-",
        Kind::Star => "*",
        Kind::Word(word) => word.spelling(),
        _ => return None,
    })
}
