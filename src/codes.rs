//! What each error code means: `docs/errors.md`, a section a code.

/// The page with all codes.
const PAGE: &str = include_str!("../docs/errors.md");

/// The sections: code, title, and the whole section.
fn sections() -> impl Iterator<Item = (&'static str, &'static str, &'static str)> {
    PAGE.split("\n## ").skip(1).filter_map(|section| {
        let (head, _) = section.split_once('\n')?;
        let (code, title) = head.split_once(' ')?;
        Some((code, title, section))
    })
}

/// All codes with their titles, in order.
pub fn all() -> impl Iterator<Item = (&'static str, &'static str)> {
    sections().map(|(code, title, _)| (code, title))
}

/// The section about a code, in whatever letters it is written.
pub fn explain(code: &str) -> Option<&'static str> {
    sections().find(|(known, _, _)| known.eq_ignore_ascii_case(code)).map(|(_, _, section)| section)
}
