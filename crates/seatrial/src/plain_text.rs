//! Text of others on its way to a terminal or a page.

use std::borrow::Cow;

/// The text without what would command a terminal or turn lines of a page around: control characters other than the end of a
/// line and a tab, and marks of writing direction, are shown by their numbers, as in `\u{1b}`.
///
/// Names, notes, columns, keys and paths come from files and over the network: whatever is printed for people passes here.
pub fn plain(text: &str) -> Cow<'_, str> {
    if !text.contains(is_command) {
        return Cow::Borrowed(text);
    }
    let lines = text.replace("\r\n", "\n");
    let mut shown = String::with_capacity(lines.len());
    for c in lines.chars() {
        match is_command(c) {
            true => shown.extend(c.escape_unicode()),
            false => shown.push(c),
        }
    }
    Cow::Owned(shown)
}

/// Would it command a terminal or turn the direction of writing?
fn is_command(c: char) -> bool {
    let turns = matches!(c, '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    turns || (c.is_control() && c != '\n' && c != '\t')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_no_command_reaches_a_terminal() {
        assert_eq!(
            plain("\u{1b}[2J\u{9b}31m\u{7}"),
            "\\u{1b}[2J\\u{9b}31m\\u{7}"
        );
        assert_eq!(plain("a\r\nb\rc\td\n"), "a\nb\\u{d}c\td\n");
        assert_eq!(plain("\u{202e}evil"), "\\u{202e}evil");
        assert!(matches!(plain("20 °, −1 µs, 船"), Cow::Borrowed(_)));
    }
}
