//! What the checks need to know of a Rust file, without a parser of the whole language.

use std::ops::Range;

/// A file's text with comments, the contents of literals and, in `production`, tests replaced by blanks. Every byte stays where it was.
pub struct Source {
    /// The text as it is in the file.
    pub text: String,
    /// Code alone, without tests.
    pub production: String,
    /// Lines that belong to no test.
    pub production_lines: usize,
}

/// A function with the lines from its `fn` to its closing brace.
pub struct Function {
    /// Its name.
    pub name: String,
    /// The line of its `fn`, counted from 1.
    pub line: usize,
    /// How many lines it takes.
    pub lines: usize,
}

impl Source {
    /// Splits a file's text.
    pub fn new(text: String) -> Self {
        let mut production = without_comments_and_literals(&text);
        let mut test_lines = 0;
        for range in tests(&production) {
            test_lines += text[range.clone()].lines().count();
            blank(&mut production, range);
        }
        let production = String::from_utf8(production).expect("only ASCII was put in");
        let production_lines = text.lines().count().saturating_sub(test_lines);
        Self {
            text,
            production,
            production_lines,
        }
    }

    /// The line of a byte, counted from 1.
    pub fn line(&self, at: usize) -> usize {
        self.text.as_bytes()[..at]
            .iter()
            .filter(|byte| **byte == b'\n')
            .count()
            + 1
    }

    /// Every function of production code that has a body.
    pub fn functions(&self) -> Vec<Function> {
        let code = self.production.as_bytes();
        let mut functions = Vec::new();
        for (at, word) in words(&self.production) {
            let Some(name) = following_name(&self.production, at + word.len()) else {
                continue;
            };
            if word != "fn" {
                continue;
            }
            let Some(open) = body(code, at) else { continue };
            let line = self.line(at);
            let lines = self.line(closing(code, open)) - line + 1;
            functions.push(Function {
                name: name.to_owned(),
                line,
                lines,
            });
        }
        functions
    }

    /// The lines of production code that write a `Result` whose error is a `String`.
    pub fn string_errors(&self) -> Vec<usize> {
        let code = self.production.as_bytes();
        let is_result = |(at, word): &(usize, &str)| {
            *word == "Result" && code.get(at + word.len()) == Some(&b'<')
        };
        words(&self.production)
            .filter(is_result)
            .filter(|(at, _)| {
                let arguments = generic_arguments(&self.production, at + "Result".len());
                arguments.get(1) == Some(&"String")
            })
            .map(|(at, _)| self.line(at))
            .collect()
    }
}

/// Identifiers and keywords with the byte at which each begins.
pub fn words(code: &str) -> impl Iterator<Item = (usize, &str)> {
    let is_word = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let mut at = 0;
    std::iter::from_fn(move || {
        let start = at + code[at..].find(is_word)?;
        let rest = &code[start..];
        let length = rest.find(|c: char| !is_word(c)).unwrap_or(rest.len());
        at = start + length;
        Some((start, &code[start..at]))
    })
}

/// The name after a keyword such as `fn` or `mod`; none where a parenthesis follows, as in `fn(f64)`.
pub fn following_name(code: &str, after: usize) -> Option<&str> {
    let rest = &code[after..];
    let blanks = rest.len() - rest.trim_start().len();
    let (at, word) = words(&rest[blanks..]).next()?;
    (blanks > 0 && at == 0).then_some(word)
}

/// The brace that closes the one at `open`, or the end of the code.
pub fn closing(code: &[u8], open: usize) -> usize {
    let mut depth = 0;
    for (at, byte) in code.iter().enumerate().skip(open) {
        match byte {
            b'{' => depth += 1,
            b'}' => depth -= 1,
            _ => continue,
        }
        if depth == 0 {
            return at;
        }
    }
    code.len()
}

/// The brace that opens the body of the item at `from`; none for an item that ends in a semicolon.
fn body(code: &[u8], from: usize) -> Option<usize> {
    let mut depth = 0;
    for (at, byte) in code.iter().enumerate().skip(from) {
        match byte {
            b'(' | b'[' => depth += 1,
            b')' | b']' => depth -= 1,
            b';' if depth == 0 => return None,
            b'{' if depth == 0 => return Some(at),
            _ => {}
        }
    }
    None
}

/// The arguments between the angle brackets that open at `open`.
fn generic_arguments(code: &str, open: usize) -> Vec<&str> {
    let mut arguments = Vec::new();
    let (mut depth, mut start) = (0, open + 1);
    for (at, byte) in code.bytes().enumerate().skip(open) {
        let is_arrow = byte == b'>' && code.as_bytes()[at - 1] == b'-';
        match byte {
            b'<' | b'(' | b'[' => depth += 1,
            b'>' | b')' | b']' if !is_arrow => depth -= 1,
            b',' if depth == 1 => {
                arguments.push(code[start..at].trim());
                start = at + 1;
            }
            b';' | b'{' if depth <= 1 => break,
            _ => {}
        }
        if depth == 0 {
            arguments.push(code[start..at].trim());
            break;
        }
    }
    arguments
}

/// Items under `#[cfg(test)]` and functions under `#[test]`, with their attributes.
fn tests(code: &[u8]) -> Vec<Range<usize>> {
    let mut found: Vec<Range<usize>> = Vec::new();
    for attribute in ["#[cfg(test)]", "#[test]"] {
        let mut from = 0;
        while let Some(at) = find(code, attribute.as_bytes(), from) {
            from = item_end(code, at);
            if !found.iter().any(|other| other.contains(&at)) {
                found.push(at..from);
            }
        }
    }
    found
}

fn find(code: &[u8], what: &[u8], from: usize) -> Option<usize> {
    let at = code[from..]
        .windows(what.len())
        .position(|window| window == what)?;
    Some(from + at)
}

/// The end of the item that begins with attributes at `from`.
fn item_end(code: &[u8], from: usize) -> usize {
    let mut at = from;
    loop {
        let blanks = code[at..].iter().take_while(|b| b.is_ascii_whitespace());
        at += blanks.count();
        if code.get(at) != Some(&b'#') {
            break;
        }
        at += find(&code[at..], b"]", 0).unwrap_or(code.len() - at - 1) + 1;
    }
    let semicolon = || find(code, b";", at).unwrap_or(code.len() - 1);
    let is_use = code[at..].starts_with(b"use ") || code[at..].starts_with(b"pub use ");
    let last = match body(code, at).filter(|_| !is_use) {
        Some(open) => closing(code, open),
        None => semicolon(),
    };
    (last + 1).min(code.len())
}

fn blank(code: &mut [u8], range: Range<usize>) {
    for byte in &mut code[range] {
        if *byte != b'\n' {
            *byte = b' ';
        }
    }
}

fn without_comments_and_literals(text: &str) -> Vec<u8> {
    let mut code = text.as_bytes().to_vec();
    let mut at = 0;
    while at < code.len() {
        let end = match text.as_bytes()[at] {
            b'/' if text[at..].starts_with("//") => {
                at + text[at..].find('\n').unwrap_or(text.len() - at)
            }
            b'/' if text[at..].starts_with("/*") => at + block_comment(&text[at..]),
            b'"' => at + string(&text[at..]),
            b'r' if is_raw_string(text, at) => at + raw_string(&text[at..]),
            b'\'' => at + character(&text[at..]),
            _ => at + 1,
        };
        if end > at + 1 || !text.as_bytes()[at].is_ascii() {
            blank(&mut code, at..end);
        }
        at = end;
    }
    code
}

fn block_comment(text: &str) -> usize {
    let (mut depth, mut at) = (0, 0);
    while at < text.len() {
        let bytes = &text.as_bytes()[at..];
        at += match bytes {
            [b'/', b'*', ..] => {
                depth += 1;
                2
            }
            [b'*', b'/', ..] => {
                depth -= 1;
                2
            }
            _ => 1,
        };
        if depth == 0 {
            break;
        }
    }
    at
}

fn string(text: &str) -> usize {
    let bytes = text.as_bytes();
    let mut at = 1;
    while at < bytes.len() && bytes[at] != b'"' {
        at += if bytes[at] == b'\\' { 2 } else { 1 };
    }
    (at + 1).min(bytes.len())
}

fn is_raw_string(text: &str, at: usize) -> bool {
    let before = text.as_bytes()[..at].last();
    let is_word = |byte: &u8| byte.is_ascii_alphanumeric() || *byte == b'_';
    let in_word = before.is_some_and(is_word) && before != Some(&b'b');
    let rest = text[at + 1..].trim_start_matches('#');
    !in_word && rest.starts_with('"')
}

fn raw_string(text: &str) -> usize {
    let hashes = text[1..].len() - text[1..].trim_start_matches('#').len();
    let start = hashes + 2;
    let end = format!("\"{}", "#".repeat(hashes));
    text[start..]
        .find(&end)
        .map_or(text.len(), |found| start + found + end.len())
}

/// The length of a character literal, or 1 for the quote of a lifetime.
fn character(text: &str) -> usize {
    let mut characters = text.char_indices().skip(1);
    match characters.next() {
        Some((_, '\\')) => {
            characters.next();
            let rest = characters.find(|(_, character)| *character == '\'');
            rest.map_or(1, |(at, _)| at + 1)
        }
        Some(_) => match characters.next() {
            Some((at, '\'')) => at + 1,
            _ => 1,
        },
        None => 1,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = r##"
/// A `fn comment() {`
pub fn first<'a>(text: &'a str) -> Result<Vec<(u8, String)>, String> {
    let brace = '{'; let quote = '"'; let text = "} fn no() {"; let raw = r#"fn "raw" {"#;
    inner(|x| { x })
}
fn declared(x: fn(f64)) -> Result<String, Error>;
#[cfg(test)]
use a::{b, c};
fn last() {}
#[cfg(test)]
mod tests {
    #[test]
    fn in_a_test() -> Result<(), String> {
    }
}
"##;

    #[test]
    fn exact_functions_of_production_code_and_their_lines() {
        let source = Source::new(TEXT.to_owned());
        let functions = source.functions();
        let found: Vec<_> = functions
            .iter()
            .map(|f| (f.name.as_str(), f.line, f.lines))
            .collect();
        assert_eq!(found, [("first", 3, 4), ("last", 10, 1)]);
        assert_eq!(source.string_errors(), [3]);
        assert_eq!(source.production_lines, TEXT.lines().count() - 8);
        assert_eq!(source.production.len(), TEXT.len());
        assert!(!source.production.contains("use a"));
    }
}
