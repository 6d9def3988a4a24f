//! Text as wide as the screen.

use std::io::IsTerminal;

use terminal_size::{Width, terminal_size_of};

/// Columns of a terminal that does not tell, and of output that is none.
pub const PLAIN_WIDTH: usize = 80;

/// Columns in which standard output is read.
pub fn width() -> usize {
    columns(terminal_size_of(std::io::stdout())).unwrap_or(PLAIN_WIDTH)
}

/// Columns of the terminal that standard error is; `None` where it is none.
pub fn width_of_stderr() -> Option<usize> {
    columns(terminal_size_of(std::io::stderr()))
}

/// Does a person see colours on standard output, and want them? (<https://no-color.org>)
pub fn has_colour() -> bool {
    let is_set = |name: &str| std::env::var_os(name).is_some_and(|value| !value.is_empty());
    let is_plain = std::env::var_os("TERM").is_some_and(|term| term == "dumb");
    std::io::stdout().is_terminal() && !is_set("NO_COLOR") && !is_plain && shows_colours()
}

/// Windows shows colours where it is asked to.
#[cfg(windows)]
fn shows_colours() -> bool {
    anstyle_query::windows::enable_ansi_colors() == Some(true)
}

#[cfg(not(windows))]
fn shows_colours() -> bool {
    true
}

const GREEN: &str = "32";
const YELLOW: &str = "33";
const RED: &str = "31";

/// Verdicts in capitals and their colours. Of those that begin alike the longest comes first.
const VERDICTS: [(&str, &str); 19] = [
    ("USE WITH CARE", YELLOW),
    ("USE", GREEN),
    ("NOT VALIDATED", YELLOW),
    ("DO NOT USE", RED),
    ("THE METHODS AGREE", GREEN),
    ("THE METHODS DIFFER", YELLOW),
    ("NO METHOD FOUND A MODEL", RED),
    ("NO CHANGE FOUND", GREEN),
    ("CHANGED", RED),
    ("RE-TRIAL DUE", RED),
    ("CANNOT TELL", YELLOW),
    ("KEPT", GREEN),
    ("PUT BACK", YELLOW),
    ("REFUSED", RED),
    ("ABORTED", RED),
    ("READY", GREEN),
    ("NOT READY", RED),
    ("SAME", GREEN),
    ("DIFFERENT", RED),
];

/// A text with its verdicts in green, yellow or red: those with which the first line begins, and those that are a line.
pub fn coloured(text: &str) -> String {
    let lines = text.split('\n').enumerate().map(|(number, line)| {
        let verdict = VERDICTS.into_iter().find(|(verdict, _)| {
            let begins = line.strip_prefix(verdict);
            begins.is_some_and(|rest| {
                rest.is_empty() || number == 0 && rest.starts_with([':', ',', ' '])
            })
        });
        verdict.map_or(line.to_owned(), |(verdict, colour)| {
            format!("\x1b[1;{colour}m{verdict}\x1b[0m{}", &line[verdict.len()..])
        })
    });
    lines.collect::<Vec<String>>().join("\n")
}

fn columns<Height>(size: Option<(Width, Height)>) -> Option<usize> {
    let (Width(columns), _) = size?;
    (columns > 0).then(|| usize::from(columns).max(PLAIN_WIDTH / 2))
}

/// Lines that begin with a label, or with as many spaces, and hold no more columns than the screen has.
pub fn labelled(label: &str, text: &str, width: usize) -> String {
    broken(label, text, width, "")
}

/// A text whose lines that hold more columns than the screen has go on in the next line, below what stands behind their label.
pub fn wrapped(text: &str, width: usize) -> String {
    let is_long = |line: &str| line.chars().count() > width;
    text.lines()
        .map(|line| match is_long(line) {
            true => {
                let (label, rest) = line.split_at(label_end(line));
                labelled(label, rest, width)
            }
            false => format!("{line}\n"),
        })
        .collect()
}

/// Columns of the widest label.
const WIDEST_LABEL: usize = 16;

/// Where the text of a line begins: behind the spaces before it, and behind a label that two spaces end.
fn label_end(line: &str) -> usize {
    let begins = line.len() - line.trim_start().len();
    let gap = line[begins..].find("  ").map(|at| begins + at);
    let behind = |at: usize| line.len() - line[at..].trim_start().len();
    gap.map(behind).filter(|end| *end <= WIDEST_LABEL).unwrap_or(begins)
}

/// A command under a label. The shell goes on over the ends of its lines.
pub fn command(label: &str, text: &str, width: usize) -> String {
    broken(label, text, width, " \\")
}

fn broken(label: &str, text: &str, width: usize, end: &str) -> String {
    let room = width.saturating_sub(label.chars().count());
    let mut lines: Vec<String> = vec![String::new()];
    for word in text.split_whitespace() {
        let line = lines.last_mut().expect("there is a first line");
        let length = |text: &str| text.chars().count();
        if line.is_empty() {
            line.push_str(word);
        } else if length(line) + 1 + length(word) + length(end) <= room {
            line.push(' ');
            line.push_str(word);
        } else {
            line.push_str(end);
            lines.push(word.to_owned());
        }
    }
    let indent = " ".repeat(label.chars().count());
    let starts = std::iter::once(label).chain(std::iter::repeat(indent.as_str()));
    starts.zip(&lines).map(|(start, line)| format!("{start}{line}\n")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_a_verdict_at_the_beginning_is_coloured() {
        for (text, shown) in [
            ("USE\nspeed", "\x1b[1;32mUSE\x1b[0m\nspeed"),
            ("USE WITH CARE\n", "\x1b[1;33mUSE WITH CARE\x1b[0m\n"),
            ("DO NOT USE: the runs part\n", "\x1b[1;31mDO NOT USE\x1b[0m: the runs part\n"),
            ("KEPT the new gains: proven", "\x1b[1;32mKEPT\x1b[0m the new gains: proven"),
        ] {
            assert_eq!(coloured(text), shown);
        }
        let own_line = coloured("speed\n\nDO NOT USE\nCause");
        assert_eq!(own_line, "speed\n\n\x1b[1;31mDO NOT USE\x1b[0m\nCause");
        for plain in ["USEFUL\n", "speed\nUSE this one\n", ""] {
            assert_eq!(coloured(plain), plain);
        }
        // Every outcome has a colour.
        use seatrial::identification::Outcome;
        for outcome in
            [Outcome::Use, Outcome::UseWithCare, Outcome::NotValidated, Outcome::DoNotUse]
        {
            let text = outcome.name().to_uppercase();
            assert_ne!(coloured(&text), text);
        }
    }

    #[test]
    fn exact_lines_end_where_the_screen_does() {
        assert_eq!(labelled("Do  ", "one two three", 11), "Do  one two\n    three\n");
        assert_eq!(command("Next  ", "a bb ccc", 12), "Next  a bb \\\n      ccc\n");
        assert_eq!(
            wrapped("Log  one two three\n  four five six", 12),
            "Log  one two\n     three\n  four five\n  six\n"
        );
    }
}
