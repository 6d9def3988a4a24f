//! Text of others on its way to a terminal or a page.

use std::borrow::Cow;

/// The text without what would command a terminal or turn lines of a page around: control characters other than the end of a
/// line and a tab, and marks of writing direction, are shown by their numbers, as in `\u{1b}`.
///
/// Names, notes, columns, keys and paths come from files and over the network: whatever is printed for people passes here.
///
/// ```
/// use seatrial::words::plain;
///
/// // A vehicle whose name would clear the screen.
/// assert_eq!(plain("boat\u{1b}[2J"), "boat\\u{1b}[2J");
/// assert_eq!(plain("20 °, 船"), "20 °, 船");
/// ```
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

/// A text with a capital letter at its start.
///
/// ```
/// use seatrial::words::capitalised;
///
/// assert_eq!(capitalised("élan 40"), "Élan 40");
/// ```
pub fn capitalised(text: &str) -> String {
    let mut letters = text.chars();
    let first = letters.next().map(|first| first.to_uppercase().to_string());
    first.unwrap_or_default() + letters.as_str()
}

/// A text with a capital letter at its start and a full stop at its end.
///
/// ```
/// use seatrial::words::sentence;
///
/// assert_eq!(sentence("the rudder did not move"), "The rudder did not move.");
/// ```
pub fn sentence(text: &str) -> String {
    capitalised(text.trim_end_matches('.')) + "."
}

/// The longest line of a message, characters, and the most lines.
const LONGEST_LINE: usize = 2000;
const MOST_LINES: usize = 200;

/// A message with the middle of its long lines left out, and the lines after the first two hundred: a message says what was found in a file
/// or an option, and does not repeat all of it.
///
/// ```
/// use seatrial::words::shortened;
///
/// let shown = shortened(&"7,".repeat(5000)).into_owned();
/// assert!(shown.contains("(8000 more characters)") && shown.len() < 2100);
/// ```
pub fn shortened(text: &str) -> Cow<'_, str> {
    let is_short = text.len() <= LONGEST_LINE
        || (text.lines().nth(MOST_LINES).is_none()
            && text.lines().all(|line| line.len() <= LONGEST_LINE));
    if is_short {
        return Cow::Borrowed(text);
    }
    let mut shown: Vec<Cow<str>> = text.lines().take(MOST_LINES).map(short_line).collect();
    let left = text.lines().count() - shown.len();
    if left > 0 {
        shown.push(format!("({left} more lines)").into());
    }
    Cow::Owned(shown.join("\n"))
}

/// The beginning and the end of a long line.
fn short_line(line: &str) -> Cow<'_, str> {
    let characters = line.chars().count();
    if characters <= LONGEST_LINE {
        return Cow::Borrowed(line);
    }
    let half = LONGEST_LINE / 2;
    let at = |n: usize| line.char_indices().nth(n).map_or(line.len(), |(at, _)| at);
    let (first, last) = (&line[..at(half)], &line[at(characters - half)..]);
    let left = characters - 2 * half;
    format!("{first} ({left} more characters) {last}").into()
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
    fn exact_a_sentence_begins_and_ends_as_one() {
        let said = sentence("the rudder did not move");
        assert_eq!(said, "The rudder did not move.");
        assert_eq!(sentence("Done."), "Done.");
    }

    #[test]
    fn exact_a_message_has_an_end() {
        let said = "seatrial: no plan\nfound: 20 °";
        assert!(matches!(shortened(said), Cow::Borrowed(_)));
        let long = format!("thrusts {}: expected one", "船,".repeat(1_000_000));
        let shown = shortened(&long);
        assert!(shown.chars().count() < LONGEST_LINE + 50);
        assert!(shown.starts_with("thrusts 船,") && shown.ends_with("船,: expected one"));
        let shown = shortened(&"0.5\n".repeat(1_000_000)).into_owned();
        assert!(shown.len() < 1000 && shown.ends_with("(999800 more lines)"));
    }

    #[test]
    fn exact_no_command_reaches_a_terminal() {
        assert_eq!(plain("\u{1b}[2J\u{9b}31m\u{7}"), "\\u{1b}[2J\\u{9b}31m\\u{7}");
        assert_eq!(plain("a\r\nb\rc\td\n"), "a\nb\\u{d}c\td\n");
        assert_eq!(plain("\u{202e}evil"), "\\u{202e}evil");
        assert!(matches!(plain("20 °, −1 µs, 船"), Cow::Borrowed(_)));
    }
}
