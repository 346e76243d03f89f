//! Tokens into items: missions, properties, laws, scripts and the prompt share one grammar (`docs/language.md`).
//!
//! Recovers at the next item, so that a file gets all its errors at once; nests at most [`DEEPEST`] deep.

mod choice;
mod claim;
mod criteria;
mod exercise;
mod item;
mod system;
mod solve;
mod term;
mod value;
mod verdict;

use crate::ast::{Condition, Ident, Item, Term, Value};
use crate::diagnostic::{Diagnostic, Span};
use crate::digest::Quick;
use crate::lexer::{Keyword, Kind, MOST_ERRORS, Token, lex_until};
use crate::name::Name;

pub use exercise::parse_step;

/// Brackets and other nesting deeper than this are refused.
pub const DEEPEST: usize = 200;

/// The code of the error that something else was expected.
const UNEXPECTED: &str = "P0201";

/// After so many tokens it is asked whether to go on.
const POLL: usize = 1 << 14;

/// What a text says, and what is wrong with it.
#[derive(Clone, Debug, Default)]
pub struct Parsed {
    /// The items that could be read, in order.
    pub items: Vec<Item>,
    /// What is wrong, in order.
    pub diagnostics: Vec<Diagnostic>,
    /// Where the items begin that could not be read.
    pub broken: Vec<usize>,
    /// Whether the only thing wrong is that the text ends too early: more lines may mend it.
    pub incomplete: bool,
    /// Whether it was interrupted: then what stands further on was not read.
    pub interrupted: bool,
    /// The tokens, for the layout of files.
    pub tokens: Vec<Token>,
    /// For each token, how it was read.
    pub roles: Vec<Role>,
    /// The places of the comments.
    pub comments: Vec<Span>,
}

/// How a token was read, where its kind alone does not tell.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Role {
    /// As usual.
    #[default]
    Plain,
    /// Begins an item.
    Item,
    /// Belongs close to the token after it: `|` and `<` that open, a sign, `_`.
    Opening,
    /// Belongs close to the token before it: `|` and `>` that close, the colon of a label.
    Closing,
    /// Belongs close to the tokens before and after it: `_`, the dash in a law's name, the bracket of parameters.
    Joining,
    /// Stands off from what is around it: the brackets of a calculation.
    Spaced,
    /// Begins a line within an item: `when` and `try` of a law.
    Line,
}

/// Reads a file: items only.
pub fn parse(text: &str) -> Parsed {
    Parser::new(text, false).items()
}

/// The same, until it is interrupted: then nothing.
pub fn parse_until(text: &str, interrupted: &dyn Fn() -> bool) -> Option<Parsed> {
    let parsed = Parser::until(text, false, interrupted).items();
    (!parsed.interrupted).then_some(parsed)
}

/// Reads an input at the prompt: items, or one term alone, which asks to simplify it.
pub fn parse_input(text: &str) -> Parsed {
    Parser::new(text, true).items()
}

/// Reads one term and nothing else.
///
/// # Errors
/// What is wrong with it.
pub fn parse_term(text: &str) -> Result<Term, Vec<Diagnostic>> {
    Parser::new(text, false).alone_in_text(Parser::term)
}

/// Reads one value and nothing else.
///
/// # Errors
/// What is wrong with it.
pub fn parse_value(text: &str) -> Result<Value, Vec<Diagnostic>> {
    Parser::new(text, false).alone_in_text(Parser::value)
}

/// Reads one condition and nothing else.
///
/// # Errors
/// What is wrong with it.
pub fn parse_condition(text: &str) -> Result<Condition, Vec<Diagnostic>> {
    Parser::new(text, false).alone_in_text(Parser::condition)
}

/// The error has been reported.
struct Failed;

type Parse<T> = Result<T, Failed>;

struct Parser<'t> {
    text: &'t str,
    tokens: Vec<Token>,
    roles: Vec<Role>,
    comments: Vec<Span>,
    /// The names met so far: what is spelt alike is one piece of memory.
    names: Quick<&'t str, Name>,
    position: usize,
    depth: usize,
    prompt: bool,
    incomplete: bool,
    diagnostics: Vec<Diagnostic>,
    interrupted: &'t dyn Fn() -> bool,
    stopped: bool,
}

impl<'t> Parser<'t> {
    fn new(text: &'t str, prompt: bool) -> Parser<'t> {
        Parser::until(text, prompt, &|| false)
    }

    fn until(text: &'t str, prompt: bool, interrupted: &'t dyn Fn() -> bool) -> Parser<'t> {
        let lexed = lex_until(text, interrupted);
        Parser {
            text,
            roles: vec![Role::Plain; lexed.tokens.len()],
            tokens: lexed.tokens,
            comments: lexed.comments,
            names: Quick::default(),
            position: 0,
            depth: 0,
            prompt,
            incomplete: false,
            diagnostics: lexed.diagnostics,
            interrupted,
            stopped: interrupted(),
        }
    }

    /// Reads with `read` what must be the whole text.
    fn alone_in_text<T>(mut self, read: fn(&mut Self) -> Parse<T>) -> Result<T, Vec<Diagnostic>> {
        let result = read(&mut self);
        if result.is_ok() && !self.at(Kind::End) {
            let _: Parse<()> = self.unexpected("the end");
        }
        match result {
            Ok(result) if self.diagnostics.is_empty() => Ok(result),
            _ => Err(self.diagnostics),
        }
    }

    /// Reads items to the end.
    fn items(mut self) -> Parsed {
        let (mut items, mut broken) = (Vec::new(), Vec::new());
        while !self.at(Kind::End) {
            let start = self.position;
            let place = self.token().span.start;
            match self.item() {
                Ok(item) => items.push(item),
                Err(Failed) => {
                    broken.push(place);
                    self.recover(start);
                }
            }
        }
        self.diagnostics.sort_by_key(|diagnostic| diagnostic.span());
        Parsed {
            items,
            broken,
            incomplete: self.incomplete && self.diagnostics.len() == 1,
            interrupted: self.stopped,
            diagnostics: self.diagnostics,
            tokens: self.tokens,
            roles: self.roles,
            comments: self.comments,
        }
    }

    /// Goes on to the next token that begins an item, at least one token further than `start`.
    fn recover(&mut self, start: usize) {
        self.depth = 0;
        if self.position == start {
            self.advance();
        }
        while !self.at(Kind::End) && !self.at_item() {
            self.advance();
        }
    }

    /// Whether the next token begins an item: an item's keyword that is no part of a law's name and no condition.
    fn at_item(&self) -> bool {
        let Kind::Word(keyword) = self.kind() else { return false };
        let close = |left: Token, right: Token, kind: Kind| left.span.end == right.span.start && right.kind == kind;
        let before = self.position.checked_sub(1).and_then(|index| self.tokens.get(index));
        let dashed = before.is_some_and(|token| token.kind == Kind::Minus && token.span.end == self.token().span.start);
        let after = self.ahead(1);
        let in_name = dashed || close(self.token(), after, Kind::Minus);
        let condition = keyword == Keyword::Observer && after.kind == Kind::OpenRound;
        // `prove probability of …`, `with probability >= q`
        let within = keyword == Keyword::Probability && before.is_some_and(|token| self.leads_to_probability(*token));
        keyword.begins_item() && !in_name && !condition && !within
    }

    fn ahead(&self, count: usize) -> Token {
        let end = Token { kind: Kind::End, span: Span::new(self.text.len(), self.text.len()) };
        self.tokens.get(self.position + count).copied().unwrap_or(end)
    }

    fn token(&self) -> Token {
        self.ahead(0)
    }

    fn kind(&self) -> Kind {
        self.token().kind
    }

    fn at(&self, kind: Kind) -> bool {
        self.kind() == kind
    }

    fn at_word(&self, keyword: Keyword) -> bool {
        self.at(Kind::Word(keyword))
    }

    /// The text of the next token.
    fn spelling(&self) -> &'t str {
        self.token().span.of(self.text)
    }

    /// Takes the next token.
    fn advance(&mut self) -> Token {
        let token = self.token();
        if token.kind != Kind::End {
            self.position += 1;
        }
        if self.position.is_multiple_of(POLL) && (self.stopped || (self.interrupted)()) {
            self.stopped = true;
            self.position = self.tokens.len();
        }
        token
    }

    /// Takes the next token and notes how it is read.
    fn take(&mut self, role: Role) -> Token {
        if let Some(slot) = self.roles.get_mut(self.position) {
            *slot = role;
        }
        self.advance()
    }

    /// Takes the next token if it is of this kind.
    fn accept(&mut self, kind: Kind) -> bool {
        let found = self.at(kind);
        if found {
            self.advance();
        }
        found
    }

    /// Takes a token of this kind, or reports that `what` was expected.
    fn require(&mut self, kind: Kind, what: &str) -> Parse<Token> {
        if self.at(kind) { Ok(self.advance()) } else { self.unexpected(what) }
    }

    /// The name that is the next token.
    fn ident(&mut self) -> Ident {
        let spelling = self.spelling();
        let name = self.names.entry(spelling).or_insert_with(|| Name::new(spelling)).clone();
        Ident { name, span: self.advance().span }
    }

    /// The end of the token before.
    fn end(&self) -> usize {
        self.position.checked_sub(1).and_then(|index| self.tokens.get(index)).map_or(0, |token| token.span.end)
    }

    fn since(&self, start: usize) -> Span {
        Span::new(start, self.end())
    }

    fn report(&mut self, diagnostic: Diagnostic) {
        if self.diagnostics.len() < MOST_ERRORS {
            self.diagnostics.push(diagnostic);
        }
    }

    fn fail<T>(&mut self, diagnostic: Diagnostic) -> Parse<T> {
        // What cannot be read at all has been reported.
        if diagnostic.code != UNEXPECTED || self.kind() != Kind::Unknown {
            self.report(diagnostic);
        }
        Err(Failed)
    }

    /// Reports that `what` was expected where the next token stands.
    fn unexpected<T>(&mut self, what: &str) -> Parse<T> {
        let diagnostic = self.wrong(what);
        self.fail(diagnostic)
    }

    /// The error that `what` was expected where the next token stands, for the caller to complete.
    fn wrong(&mut self, what: &str) -> Diagnostic {
        let token = self.token();
        if token.kind == Kind::End {
            self.incomplete = true;
            let end = self.end();
            return Diagnostic::error("P0202", format!("the text ends where {what} should follow"))
                .label(Span::new(end, end), format!("expected {what}"));
        }
        let found = excerpt(token.span.of(self.text));
        let wrong = Diagnostic::error(UNEXPECTED, format!("expected {what}, found `{found}`"))
            .label(token.span, format!("expected {what}"));
        let before = self.position.checked_sub(1).and_then(|index| self.tokens.get(index));
        let twice = before.is_some_and(|before| before.kind == Kind::Equal && before.span.end == token.span.start);
        if twice && token.kind == Kind::Equal { wrong.help("equality is written with one `=`") } else { wrong }
    }

    /// Runs `read` one level deeper; refuses to go deeper than [`DEEPEST`].
    fn nested<T>(&mut self, read: impl FnOnce(&mut Self) -> Parse<T>) -> Parse<T> {
        self.deeper(1)?;
        let result = read(self);
        self.depth = self.depth.saturating_sub(1);
        result
    }

    /// Goes `levels` deeper, or reports that it is too deep.
    fn deeper(&mut self, levels: usize) -> Parse<()> {
        if self.depth + levels > DEEPEST {
            return self.too_deep(self.token().span);
        }
        self.depth += levels;
        Ok(())
    }

    fn too_deep<T>(&mut self, span: Span) -> Parse<T> {
        self.fail(
            Diagnostic::error("P0205", format!("nested deeper than {DEEPEST}"))
                .label(span, format!("level {} begins here", DEEPEST + 1))
                .help("give an inner part a name with `proc Part = …` and use the name"),
        )
    }

    /// `a, b, c` up to a closing token, which is taken; may be empty. Each is read by `read`.
    fn list<T>(&mut self, close: Kind, what: &str, mut read: impl FnMut(&mut Self) -> Parse<T>) -> Parse<Vec<T>> {
        let mut all = Vec::new();
        if self.accept(close) {
            return Ok(all);
        }
        loop {
            all.push(read(self)?);
            if self.accept(close) {
                all.shrink_to_fit();
                return Ok(all);
            }
            self.require(Kind::Comma, what)?;
        }
    }
}

/// The beginning of a text, for use within a sentence.
fn excerpt(text: &str) -> String {
    let short: String = text.chars().take(30).collect();
    if short.len() < text.len() { format!("{short}…") } else { short }
}
