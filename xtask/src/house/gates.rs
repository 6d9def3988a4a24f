//! Counts that may not rise unless somebody says why: `house.toml` holds the most that each may be.

use std::collections::BTreeMap;
use std::path::Path;

use proc_macro2::{Delimiter, TokenTree};

use super::source::{Source, for_each_level, inside, is_mark, word};

/// Where the limits are.
pub const LIMITS: &str = "house.toml";
/// The crate whose constants, codes of reasons and public modules are counted.
const ESTIMATOR: &str = "seatrial";
/// The crate whose verbs and options are counted.
const TERMINAL: &str = "seatrial-cli";
/// Lines that a count of lines may lie below its limit without a word: every change moves it.
const LINES_OF_SLACK: usize = 200;

/// What is counted, by the names of house.toml.
#[derive(Default)]
pub struct Counts(BTreeMap<String, usize>);

impl Counts {
    /// Adds the concepts of a file, and its lines to those of its crate.
    pub fn add(&mut self, package: &str, path: &Path, source: &Source) {
        self.raise(&format!("lines.{package}"), source.production_lines);
        let code = &source.production;
        if package == ESTIMATOR {
            self.raise("constants", constants(code));
            self.raise("reason_codes", variants(code, is_reason_code));
            if path.ends_with("lib.rs") {
                let is_public = |w: &&[TokenTree]| is_word(&w[0], "pub") && is_word(&w[1], "mod");
                self.raise("public_modules", code.windows(2).filter(is_public).count());
            }
        }
        if package == TERMINAL {
            self.raise(
                "verbs",
                variants(code, |before| derives(before, "Subcommand")),
            );
            self.raise("options", options(code));
        }
    }

    /// Raises a count.
    pub fn raise(&mut self, name: &str, by: usize) {
        *self.0.entry(name.to_owned()).or_default() += by;
    }

    /// What is above its limit in house.toml, and, printed, what could be lowered there.
    pub fn faults(&self, root: &Path) -> Result<Vec<String>, String> {
        let failed = |error: &dyn std::fmt::Display| format!("{LIMITS}: {error}");
        let text = std::fs::read_to_string(root.join(LIMITS)).map_err(|error| failed(&error))?;
        let limits: BTreeMap<String, toml::Value> =
            toml::from_str(&text).map_err(|error| failed(&error))?;
        Ok(self.beside(|name| {
            let (table, name) = name.split_once('.').unwrap_or(("concepts", name));
            usize::try_from(limits.get(table)?.get(name)?.as_integer()?).ok()
        }))
    }

    fn beside(&self, limit: impl Fn(&str) -> Option<usize>) -> Vec<String> {
        let mut faults = Vec::new();
        for (name, &count) in &self.0 {
            let slack = if name.starts_with("lines.") {
                LINES_OF_SLACK
            } else {
                0
            };
            match limit(name) {
                None => faults.push(format!("{name}: {count}, and no limit of it")),
                Some(most) if count > most => faults.push(format!(
                    "{name}: {count}, at most {most} may be: delete, or raise the limit with a line above it that says why"
                )),
                Some(most) if count + slack < most => {
                    println!("{LIMITS}: {name} can be lowered from {most} to {count}");
                }
                Some(_) => {}
            }
        }
        faults
    }
}

fn is_word(token: &TokenTree, text: &str) -> bool {
    word(token).is_some_and(|word| word == text)
}

/// Constants that are numbers or lists of numbers.
fn constants(code: &[TokenTree]) -> usize {
    const NUMBERS: [&str; 10] = [
        "f64", "f32", "usize", "u64", "u32", "u16", "u8", "i64", "i32", "i16",
    ];
    let is_number = |token: &TokenTree| {
        let text = token.to_string();
        let element = text.trim_start_matches('[').split(';').next();
        NUMBERS.contains(&element.unwrap_or_default().trim())
    };
    let mut count = 0;
    for_each_level(code, &mut |level| {
        let is_generic =
            |at: usize| at > 0 && (is_mark(&level[at - 1], '<') || is_mark(&level[at - 1], ','));
        let is_constant = |(at, w): &(usize, &[TokenTree])| {
            is_word(&w[0], "const") && is_mark(&w[2], ':') && is_number(&w[3]) && !is_generic(*at)
        };
        count += level.windows(4).enumerate().filter(is_constant).count();
    });
    count
}

/// Variants of the enums before whose braces the tokens are as asked for.
fn variants(code: &[TokenTree], is_counted: impl Fn(&[TokenTree]) -> bool) -> usize {
    let mut count = 0;
    for_each_level(code, &mut |level| {
        for (at, w) in level.windows(3).enumerate() {
            let body = inside(&w[2], Delimiter::Brace).filter(|_| is_word(&w[0], "enum"));
            if let Some(body) = body.filter(|_| is_counted(&level[..at + 2])) {
                let parts = body.split(|token| is_mark(token, ','));
                count += parts
                    .filter(|variant| !variant.is_empty() && !is_hidden(variant))
                    .count();
            }
        }
    });
    count
}

fn is_reason_code(before: &[TokenTree]) -> bool {
    before
        .last()
        .is_some_and(|name| is_word(name, "ReasonCode"))
}

/// Does the item whose name is last derive the trait?
fn derives(before: &[TokenTree], derived: &str) -> bool {
    let item = before.iter().rev().skip(2);
    item.take_while(|token| !is_mark(token, ';') && inside(token, Delimiter::Brace).is_none())
        .filter_map(|token| inside(token, Delimiter::Bracket))
        .any(|attribute| {
            is_word(&attribute[0], "derive") && attribute[1].to_string().contains(derived)
        })
}

/// Is the variant an old spelling, which help does not show?
fn is_hidden(variant: &[TokenTree]) -> bool {
    let attributes = variant
        .iter()
        .filter_map(|token| inside(token, Delimiter::Bracket));
    attributes
        .flatten()
        .any(|token| token.to_string().contains("hide = true"))
}

/// Options with a long name.
fn options(code: &[TokenTree]) -> usize {
    let mut count = 0;
    for_each_level(code, &mut |level| {
        let is_option = |w: &&[TokenTree]| {
            let given = inside(&w[1], Delimiter::Parenthesis).unwrap_or_default();
            is_word(&w[0], "arg") && given.iter().any(|token| is_word(token, "long"))
        };
        count += level.windows(2).filter(is_option).count();
    });
    count
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_concepts_are_counted_and_held_against_their_limits() {
        let text = "const A: f64 = 1.0; const B: [u8; 2] = [1, 2]; const C: &str = \"\"; fn f<const N: usize>() {}
            #[derive(Clone, Subcommand)] pub enum Verb { Go(u8), #[doc = \"a, b\"] Stop { at: u8 }, #[command(hide = true)] Halt }
            enum ReasonCode { Ok, }
            struct Args { #[arg(long, value_name = \"N\")] a: u8, #[arg(short)] b: u8 }";
        let source = Source::new(text.to_owned()).unwrap();
        let mut counts = Counts::default();
        for package in [ESTIMATOR, TERMINAL] {
            counts.add(package, Path::new("a.rs"), &source);
        }
        let of = |name: &str| counts.0[name];
        let found = ["constants", "reason_codes", "verbs", "options"].map(of);
        assert_eq!(found, [2, 1, 2, 1]);
        let limit = |name: &str| (name != "verbs").then(|| if name == "options" { 0 } else { 9 });
        let faults = counts.beside(limit);
        assert_eq!(faults.len(), 2, "{faults:?}");
        assert!(faults[0].starts_with("options: 1, at most 0"));
        assert!(faults[1].starts_with("verbs: 2, and no limit"));
    }
}
