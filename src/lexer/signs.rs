//! The signs that are one letter.

use super::{Keyword, Kind};

pub(super) fn single(letter: char) -> Kind {
    match letter {
        '_' => Kind::Underscore,
        ',' => Kind::Comma,
        ';' => Kind::Semicolon,
        '|' | '∥' | '‖' | '∣' => Kind::Bar,
        '#' => Kind::Hash,
        '^' => Kind::Caret,
        '(' => Kind::OpenRound,
        ')' => Kind::CloseRound,
        '{' => Kind::OpenCurly,
        '}' => Kind::CloseCurly,
        '[' => Kind::OpenSquare,
        ']' => Kind::CloseSquare,
        '<' | '⟨' | '〈' => Kind::Less,
        '>' | '⟩' | '〉' => Kind::Greater,
        '≤' => Kind::LessEqual,
        '≈' => Kind::Weak,
        '≲' => Kind::LessWeak,
        '≥' => Kind::GreaterEqual,
        '=' => Kind::Equal,
        '≠' => Kind::NotEqual,
        ':' => Kind::Colon,
        '.' => Kind::Dot,
        '+' => Kind::Plus,
        '-' | '−' => Kind::Minus,
        '*' | '·' | '×' | '⋅' => Kind::Star,
        '∘' => Kind::Lower,
        '/' => Kind::Slash,
        '~' => Kind::Tilde,
        '%' => Kind::Percent,
        '↓' => Kind::Word(Keyword::To),
        _ => Kind::Unknown,
    }
}
