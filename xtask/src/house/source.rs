//! What the checks need to know of a Rust file: its tokens, without those of tests.

use std::ops::RangeInclusive;

use proc_macro2::{Delimiter, Group, TokenStream, TokenTree};

/// A file's text, and its code without comments and tests.
pub struct Source {
    /// The text as it is in the file.
    pub text: String,
    /// Tokens of no test.
    pub production: Vec<TokenTree>,
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
    /// Splits a file's text; an error where it is no Rust.
    pub fn new(text: String) -> Result<Self, String> {
        let tokens: TokenStream = text.parse().map_err(|error| format!("{error}"))?;
        let mut tests = Vec::new();
        let production = without_tests(tokens, &mut tests);
        let test_lines: usize = tests.into_iter().map(Iterator::count).sum();
        let production_lines = text.lines().count().saturating_sub(test_lines);
        Ok(Self {
            text,
            production,
            production_lines,
        })
    }

    /// Every function of production code that has a body.
    pub fn functions(&self) -> Vec<Function> {
        let mut functions = Vec::new();
        for_each_level(&self.production, &mut |level| {
            for (at, pair) in level.windows(2).enumerate() {
                let [first, TokenTree::Ident(name)] = pair else {
                    continue;
                };
                if word(first).is_none_or(|word| word != "fn") {
                    continue;
                }
                if let Some(body) = body(&level[at..]) {
                    let line = line(first);
                    functions.push(Function {
                        name: name.to_string(),
                        line,
                        lines: body.span_close().end().line + 1 - line,
                    });
                }
            }
        });
        functions
    }

    /// The lines of production code that write a `Result` whose error is a `String`.
    pub fn string_errors(&self) -> Vec<usize> {
        let mut lines = Vec::new();
        for_each_level(&self.production, &mut |level| {
            for (at, token) in level.iter().enumerate() {
                let is_result = word(token).is_some_and(|word| word == "Result");
                let arguments = || generic_arguments(&level[at + 1..]);
                if is_result && arguments().get(1).is_some_and(|error| error == "String") {
                    lines.push(line(token));
                }
            }
        });
        lines
    }
}

/// The line on which a token begins, counted from 1.
pub fn line(token: &TokenTree) -> usize {
    token.span().start().line
}

/// A keyword or a name.
pub fn word(token: &TokenTree) -> Option<String> {
    match token {
        TokenTree::Ident(name) => Some(name.to_string()),
        _ => None,
    }
}

/// Is this the mark?
pub fn is_mark(token: &TokenTree, mark: char) -> bool {
    matches!(token, TokenTree::Punct(punct) if punct.as_char() == mark)
}

/// What stands between these braces, brackets or parentheses.
pub fn inside(token: &TokenTree, delimiter: Delimiter) -> Option<Vec<TokenTree>> {
    match token {
        TokenTree::Group(group) if group.delimiter() == delimiter => {
            Some(group.stream().into_iter().collect())
        }
        _ => None,
    }
}

/// Calls with the tokens, then with those between each of their braces, brackets and parentheses, and so on.
pub fn for_each_level(level: &[TokenTree], visit: &mut impl FnMut(&[TokenTree])) {
    visit(level);
    for token in level {
        if let TokenTree::Group(group) = token {
            let inner: Vec<TokenTree> = group.stream().into_iter().collect();
            for_each_level(&inner, visit);
        }
    }
}

/// The body of the item at the beginning; none for an item that ends in a semicolon.
fn body(item: &[TokenTree]) -> Option<&Group> {
    let end = item.iter().find_map(|token| match token {
        TokenTree::Group(group) if group.delimiter() == Delimiter::Brace => Some(Some(group)),
        token => is_mark(token, ';').then_some(None),
    });
    end.flatten()
}

/// The arguments between the angle brackets at the beginning.
fn generic_arguments(tokens: &[TokenTree]) -> Vec<String> {
    let mut arguments = vec![String::new()];
    let mut depth = 0;
    let mut before = ' ';
    for token in tokens {
        let mark = match token {
            TokenTree::Punct(punct) => punct.as_char(),
            _ => ' ',
        };
        match mark {
            '<' => depth += 1,
            '>' if before != '-' => depth -= 1,
            ',' if depth == 1 => arguments.push(String::new()),
            _ => {}
        }
        before = mark;
        if depth == 0 {
            break;
        }
        if let Some(argument) = arguments.last_mut().filter(|_| !['<', ','].contains(&mark)) {
            argument.push_str(&token.to_string());
        }
    }
    arguments
}

/// Tokens without items under `#[cfg(test)]` and functions under `#[test]`, whose lines are put into `tests`.
fn without_tests(tokens: TokenStream, tests: &mut Vec<RangeInclusive<usize>>) -> Vec<TokenTree> {
    let tokens: Vec<TokenTree> = tokens.into_iter().collect();
    let mut kept = Vec::new();
    let mut at = 0;
    while at < tokens.len() {
        if is_test(&tokens[at..]) {
            let end = at + item_length(&tokens[at..]);
            tests.push(line(&tokens[at])..=tokens[end - 1].span().end().line);
            at = end;
            continue;
        }
        kept.push(match &tokens[at] {
            TokenTree::Group(group) => {
                let inner = without_tests(group.stream(), tests).into_iter().collect();
                let mut shorter = Group::new(group.delimiter(), inner);
                shorter.set_span(group.span());
                shorter.into()
            }
            token => token.clone(),
        });
        at += 1;
    }
    kept
}

/// Do the tokens begin with the attribute of a test?
fn is_test(tokens: &[TokenTree]) -> bool {
    let [mark, attribute, ..] = tokens else {
        return false;
    };
    let text = attribute.to_string().replace([' ', '\n'], "");
    is_mark(mark, '#')
        && (["[test]", "[cfg(test)]"].contains(&text.as_str())
            || text.starts_with("[cfg(all(test,"))
}

/// Tokens of the item that begins with attributes.
fn item_length(tokens: &[TokenTree]) -> usize {
    let mut at = 0;
    while tokens.get(at).is_some_and(|token| is_mark(token, '#')) {
        at += 2;
    }
    let is_use = |token: &TokenTree| word(token).is_some_and(|word| word == "use");
    let is_import = tokens[at..].iter().take(3).any(is_use);
    let ends = |token: &TokenTree| {
        is_mark(token, ';') || !is_import && inside(token, Delimiter::Brace).is_some()
    };
    let end = tokens[at..].iter().position(ends);
    end.map_or(tokens.len(), |end| at + end + 1)
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
        let source = Source::new(TEXT.to_owned()).unwrap();
        let functions = source.functions();
        let found: Vec<_> = functions
            .iter()
            .map(|f| (f.name.as_str(), f.line, f.lines))
            .collect();
        assert_eq!(found, [("first", 3, 4), ("last", 10, 1)]);
        assert_eq!(source.string_errors(), [3]);
        assert_eq!(source.production_lines, TEXT.lines().count() - 8);
    }
}
