//! Text into tokens, in one pass and linear time.

mod signs;

use crate::diagnostic::{Diagnostic, Span};
use signs::single;

/// The words that the language keeps for itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Keyword {
    /// `param`
    Param,
    /// `fn`
    Fn,
    /// `proc`
    Proc,
    /// `observer`
    Observer,
    /// `system`
    System,
    /// `property`
    Property,
    /// `prove`
    Prove,
    /// `simplify`
    Simplify,
    /// `period`
    Period,
    /// `flow`
    Flow,
    /// `solve`
    Solve,
    /// `project`
    Project,
    /// `lts`
    Lts,
    /// `minimise`
    Minimise,
    /// `compare`
    Compare,
    /// `expect`
    Expect,
    /// `import`
    Import,
    /// `law`
    Law,
    /// `exercise`
    Exercise,
    /// `probability`
    Probability,
    /// `criteria`
    Criteria,
    /// `sweep`
    Sweep,
    /// `by`
    By,
    /// `when`
    When,
    /// `satisfies`
    Satisfies,
    /// `always`
    Always,
    /// `to`, `↓`
    To,
    /// `try`
    Try,
    /// `loop`
    Loop,
    /// `new`
    New,
    /// `if`
    If,
    /// `then`
    Then,
    /// `else`
    Else,
}

impl Keyword {
    /// All of them with their spelling; the first twenty-two begin an item.
    pub const ALL: [(Keyword, &'static str); 33] = [
        (Keyword::Exercise, "exercise"),
        (Keyword::Param, "param"),
        (Keyword::Fn, "fn"),
        (Keyword::Proc, "proc"),
        (Keyword::Observer, "observer"),
        (Keyword::System, "system"),
        (Keyword::Property, "property"),
        (Keyword::Prove, "prove"),
        (Keyword::Simplify, "simplify"),
        (Keyword::Period, "period"),
        (Keyword::Flow, "flow"),
        (Keyword::Solve, "solve"),
        (Keyword::Project, "project"),
        (Keyword::Lts, "lts"),
        (Keyword::Minimise, "minimise"),
        (Keyword::Compare, "compare"),
        (Keyword::Expect, "expect"),
        (Keyword::Import, "import"),
        (Keyword::Law, "law"),
        (Keyword::Probability, "probability"),
        (Keyword::Criteria, "criteria"),
        (Keyword::Sweep, "sweep"),
        (Keyword::By, "by"),
        (Keyword::When, "when"),
        (Keyword::Satisfies, "satisfies"),
        (Keyword::Always, "always"),
        (Keyword::To, "to"),
        (Keyword::Try, "try"),
        (Keyword::Loop, "loop"),
        (Keyword::New, "new"),
        (Keyword::If, "if"),
        (Keyword::Then, "then"),
        (Keyword::Else, "else"),
    ];

    /// The keyword of this spelling.
    pub fn of(text: &str) -> Option<Keyword> {
        Keyword::ALL.iter().find(|(_, spelling)| *spelling == text).map(|(keyword, _)| *keyword)
    }

    /// Its spelling.
    pub fn spelling(self) -> &'static str {
        Keyword::ALL.iter().find(|(keyword, _)| *keyword == self).map_or("", |(_, spelling)| spelling)
    }

    /// Whether it begins an item.
    pub fn begins_item(self) -> bool {
        Keyword::ALL.iter().take(22).any(|(keyword, _)| *keyword == self)
    }
}

/// What a token is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Kind {
    /// A name that begins with a capital: a process, an observer, a distribution.
    Upper,
    /// A name that begins small: a value, a port, a result, a law.
    Lower,
    /// `?P`, `?x`
    Meta,
    /// `12`, `0.1`
    Number,
    /// `"…"`
    Text,
    /// `paper …` or `ours …`, to the end of the line
    Origin,
    /// A word of the language.
    Word(Keyword),
    /// `_`
    Underscore,
    /// `,`
    Comma,
    /// `;`
    Semicolon,
    /// `|`, `∥`
    Bar,
    /// `#`
    Hash,
    /// `^`
    Caret,
    /// `(`
    OpenRound,
    /// `)`
    CloseRound,
    /// `{`
    OpenCurly,
    /// `}`
    CloseCurly,
    /// `[`
    OpenSquare,
    /// `]`
    CloseSquare,
    /// `<`, `⟨`
    Less,
    /// `>`, `⟩`
    Greater,
    /// `<=`, `≤`
    LessEqual,
    /// `~~`, `≈`
    Weak,
    /// `<~`, `≲`
    LessWeak,
    /// `>=`, `≥`
    GreaterEqual,
    /// `=`
    Equal,
    /// `!=`, `≠`
    NotEqual,
    /// `=>`
    Arrow,
    /// `:=`
    Assign,
    /// `:`
    Colon,
    /// `.`
    Dot,
    /// `..`
    Dots,
    /// `%`
    Percent,
    /// `!` behind a value
    Factorial,
    /// `+`
    Plus,
    /// `-`, `−`
    Minus,
    /// `*`, `·`
    Star,
    /// `/`
    Slash,
    /// `~`, between two processes that are compared
    Tilde,
    /// A character that the language does not use; reported already.
    Unknown,
    /// The end of the text.
    End,
}

/// A token where it stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Token {
    /// What it is.
    pub kind: Kind,
    /// Its place.
    pub span: Span,
}

/// The tokens of a text, the last of them [`Kind::End`], with its comments and what is wrong in it.
#[derive(Clone, Debug, Default)]
pub struct Lexed {
    /// The tokens, in order.
    pub tokens: Vec<Token>,
    /// The places of the comments, from `//` to the end of the line.
    pub comments: Vec<Span>,
    /// What is wrong.
    pub diagnostics: Vec<Diagnostic>,
}

/// Numbers with more digits than this are refused.
pub const MOST_DIGITS: usize = 10_000;

/// More errors than this in one text are not reported.
pub const MOST_ERRORS: usize = 100;

/// The tokens of `text`.
pub fn lex(text: &str) -> Lexed {
    lex_until(text, &|| false)
}

/// The same, or the tokens as far as it came before it was interrupted.
pub fn lex_until(text: &str, interrupted: &dyn Fn() -> bool) -> Lexed {
    let mut lexer = Lexer { text, position: 0, in_law: false, line_start: true, lexed: Lexed::default() };
    while lexer.step() && !(lexer.lexed.tokens.len().is_multiple_of(1 << 14) && interrupted()) {}
    lexer.lexed
}

struct Lexer<'t> {
    text: &'t str,
    position: usize,
    in_law: bool,
    line_start: bool,
    lexed: Lexed,
}

impl Lexer<'_> {
    fn rest(&self) -> &str {
        self.text.get(self.position..).unwrap_or("")
    }

    /// Reads one token or blank; false at the end.
    fn step(&mut self) -> bool {
        let start = self.position;
        let Some(letter) = self.rest().chars().next() else {
            self.push(Kind::End, start);
            return false;
        };
        if letter == '\n' {
            self.line_start = true;
        }
        if letter.is_whitespace() || letter == '\u{feff}' {
            self.position += letter.len_utf8();
            return true;
        }
        if self.rest().starts_with("//") {
            self.position += self.rest().find('\n').unwrap_or(self.rest().len());
            self.lexed.comments.push(Span::new(start, self.position));
            return true;
        }
        let first = std::mem::replace(&mut self.line_start, false);
        match letter {
            '"' => self.quoted(),
            '?' => self.meta(),
            _ if letter.is_ascii_digit() => self.number(),
            _ if letter.is_alphabetic() => self.word(first),
            _ => self.symbol(letter),
        }
        true
    }

    fn push(&mut self, kind: Kind, start: usize) {
        self.lexed.tokens.push(Token { kind, span: Span::new(start, self.position) });
    }

    fn report(&mut self, diagnostic: Diagnostic) {
        if self.lexed.diagnostics.len() < MOST_ERRORS {
            self.lexed.diagnostics.push(diagnostic);
        }
    }

    /// Moves behind the letters and digits of a name; `_` joins only in names that begin small.
    fn name(&mut self, joined: bool) {
        let mut letters = self.rest().char_indices().peekable();
        let mut length = self.rest().len();
        while let Some((offset, letter)) = letters.next() {
            let next = letters.peek().map(|(_, letter)| *letter);
            let joins = joined && letter == '_' && next.is_some_and(char::is_alphanumeric);
            if !(letter.is_alphanumeric() || letter == '\'' || joins) {
                length = offset;
                break;
            }
        }
        self.position += length;
    }

    /// Whether the title of a law was read last.
    fn titled(&self) -> bool {
        self.lexed.tokens.last().is_some_and(|token| token.kind == Kind::Text)
    }

    fn word(&mut self, first: bool) {
        let start = self.position;
        let capital = self.rest().chars().next().is_some_and(char::is_uppercase);
        self.name(!capital);
        let text = self.text.get(start..self.position).unwrap_or("");
        if capital {
            self.push(Kind::Upper, start);
        } else if self.in_law && (first || self.titled()) && matches!(text, "paper" | "ours") {
            self.position += self.rest().find('\n').unwrap_or(self.rest().len());
            self.push(Kind::Origin, start);
        } else if let Some(keyword) = Keyword::of(text) {
            let dashed = self.text.get(..start).unwrap_or("").ends_with('-');
            let item = keyword.begins_item() && !dashed && !self.rest().starts_with(['-', '(']);
            self.in_law = if item { keyword == Keyword::Law } else { self.in_law };
            self.push(Kind::Word(keyword), start);
        } else {
            self.push(Kind::Lower, start);
        }
    }

    fn meta(&mut self) {
        let start = self.position;
        self.position += 1;
        let next = self.rest().chars().next();
        if next.is_some_and(char::is_alphabetic) {
            self.name(!next.is_some_and(char::is_uppercase));
            self.push(Kind::Meta, start);
        } else {
            self.push(Kind::Unknown, start);
            self.report(
                Diagnostic::error("P0102", "`?` must be followed by a name")
                    .label(Span::new(start, start + 1), "no name follows")
                    .help("write `?t` for a value to be found, or `?P` for any process"),
            );
        }
    }

    fn digits(&mut self) -> usize {
        let count = self.rest().bytes().take_while(u8::is_ascii_digit).count();
        self.position += count;
        count
    }

    fn number(&mut self) {
        let start = self.position;
        let mut count = self.digits();
        if self.rest().starts_with('.') && self.rest().as_bytes().get(1).is_some_and(u8::is_ascii_digit) {
            self.position += 1;
            count += self.digits();
        }
        // A number that is not read stands for no value, so that nothing is ever said of the item it stands in.
        self.push(if count > MOST_DIGITS { Kind::Unknown } else { Kind::Number }, start);
        if count > MOST_DIGITS {
            self.report(
                Diagnostic::error("P0103", format!("this number has {count} digits; at most {MOST_DIGITS} are read"))
                    .label(Span::new(start, start + 20), "the number begins here"),
            );
        }
    }

    fn quoted(&mut self) {
        let start = self.position;
        let body = self.rest().get(1..).unwrap_or("");
        match body.find(['"', '\n']) {
            Some(length) if body.as_bytes().get(length) == Some(&b'"') => {
                self.position += length + 2;
                self.push(Kind::Text, start);
            }
            end => {
                self.position += 1 + end.unwrap_or(body.len());
                self.push(Kind::Text, start);
                self.report(
                    Diagnostic::error("P0104", "this text in quotes does not end on its line")
                        .label(Span::new(start, start + 1), "it begins here")
                        .help("close it with `\"`"),
                );
            }
        }
    }

    /// Whether `>` would close the results of a process here, so that in `Foo_a<x>= P` it stands for itself.
    fn closes_results(&self) -> bool {
        let mut before = self.lexed.tokens.iter().rev().map(|token| token.kind);
        let mut commas = 0;
        loop {
            if !matches!(before.next(), Some(Kind::Lower | Kind::Meta)) {
                return false;
            }
            match before.next() {
                Some(Kind::Comma) => commas += 1,
                Some(Kind::Less) => break,
                _ => return false,
            }
        }
        match before.next() {
            Some(Kind::Upper | Kind::CloseCurly) => true,
            Some(Kind::CloseRound) => commas == 0,
            _ => before.next() == Some(Kind::Underscore),
        }
    }

    fn symbol(&mut self, letter: char) {
        let start = self.position;
        let rest = self.rest();
        let pairs = [("<=", Kind::LessEqual), (">=", Kind::GreaterEqual), ("!=", Kind::NotEqual), ("=>", Kind::Arrow)];
        let more = [(":=", Kind::Assign), ("~~", Kind::Weak), ("<~", Kind::LessWeak), ("..", Kind::Dots)];
        let pair = pairs.into_iter().chain(more).find(|(text, _)| rest.starts_with(text));
        if let Some((_, kind)) = pair {
            if kind == Kind::GreaterEqual && self.closes_results() {
                self.position += 1;
                self.push(Kind::Greater, start);
                return;
            }
            self.position += 2;
            self.push(kind, start);
            return;
        }
        let value = self
            .text
            .get(..start)
            .is_some_and(|before| before.ends_with(|last: char| last.is_alphanumeric() || matches!(last, ')' | '}')));
        let kind = if letter == '!' && value { Kind::Factorial } else { single(letter) };
        self.position += letter.len_utf8();
        self.push(kind, start);
        if kind == Kind::Unknown {
            let advice = match letter {
                '~' => "equality of processes is written `=`, weak equality `~~`",
                '→' | '⇒' => "a law that simplifies is written `=>`",
                '!' => "\"not equal\" is written `!=`, and behind `if` and `find n with` \"not\" is a word",
                '&' | '∧' => "behind `if` and `find n with` write `and`, elsewhere a comma",
                _ => "the signs of the language are ; | # ^ _ < > ( ) { } + - * / and = != <= >=",
            };
            self.report(
                Diagnostic::error("P0105", format!("the language does not use the sign `{letter}`"))
                    .label(Span::new(start, self.position), "this sign")
                    .help(advice),
            );
        }
    }
}
