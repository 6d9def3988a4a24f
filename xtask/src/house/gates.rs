//! Counts that may not rise unless somebody says why: `house.toml` holds the most that each may be.

use std::collections::BTreeMap;
use std::path::Path;

use anyhow::Result;
use syn::{Item, Visibility};

use super::source::Source;
use crate::shell::shell;

/// Where the limits are.
pub const LIMITS: &str = "house.toml";
/// The crate whose constants, codes of reasons and public modules are counted.
const ESTIMATOR: &str = "seatrial";
/// The crates whose verbs and options are counted, and what their counts are called: what people install, and the project's own studies.
const TERMINALS: [(&str, [&str; 2]); 2] =
    [("seatrial-cli", ["verbs", "options"]), ("seatrial-lab", ["lab_verbs", "lab_options"])];
/// Lines that a crate may lie above or below its figure: a small addition leaves house.toml alone. Every other count is exact.
const LINES_OF_SLACK: usize = 150;

/// What is counted, by the names of house.toml.
#[derive(Default)]
pub struct Counts(BTreeMap<String, usize>);

impl Counts {
    /// Adds the concepts of a file, and its lines to those of its crate.
    pub fn add(&mut self, package: &str, path: &Path, source: &Source) {
        self.raise(&format!("lines.{package}"), source.production_lines);
        if package == ESTIMATOR {
            self.raise("constants", source.constants);
            self.raise("reason_codes", source.reason_codes);
            if path.ends_with("lib.rs") {
                let is_public = |item: &&Item| {
                    let public =
                        |module: &syn::ItemMod| matches!(module.vis, Visibility::Public(_));
                    matches!(item, Item::Mod(module) if public(module))
                };
                self.raise("public_modules", source.items.iter().filter(is_public).count());
            }
        }
        if let Some((_, [verbs, options])) = TERMINALS.iter().find(|(name, _)| *name == package) {
            self.raise(verbs, source.verbs);
            self.raise(options, source.options);
        }
    }

    /// Raises a count.
    pub fn raise(&mut self, name: &str, by: usize) {
        *self.0.entry(name.to_owned()).or_default() += by;
    }

    /// Lines of production code by crate.
    pub fn lines(&self) -> impl Iterator<Item = (&str, usize)> {
        let counts = self.0.iter();
        counts.filter_map(|(name, lines)| Some((name.strip_prefix("lines.")?, *lines)))
    }

    /// Verbs and options of each program.
    pub fn of_terminals(&self) -> String {
        let of = |name: &str| self.0.get(name).copied().unwrap_or_default();
        let programs = TERMINALS.map(|(package, [verbs, options])| {
            format!("{package} has {} verbs and {} options", of(verbs), of(options))
        });
        programs.join("; ")
    }

    /// What is above its limit in house.toml, and, printed, what could be lowered there.
    pub fn faults(&self) -> Result<Vec<String>> {
        let limits: BTreeMap<String, BTreeMap<String, usize>> =
            toml::from_str(&shell().read_file(LIMITS)?)?;
        Ok(self.beside(|name| {
            let (table, name) = name.split_once('.').unwrap_or(("concepts", name));
            limits.get(table)?.get(name).copied()
        }))
    }

    fn beside(&self, limit: impl Fn(&str) -> Option<usize>) -> Vec<String> {
        let mut faults = Vec::new();
        for (name, &count) in &self.0 {
            let slack = LINES_OF_SLACK * usize::from(name.starts_with("lines."));
            match limit(name) {
                None => faults.push(format!("{name}: {count}, and no limit of it")),
                Some(most) if count > most + slack => faults.push(format!(
                    "{name}: {count}, at most {} may be: delete, or raise the limit with a line above it that says why",
                    most + slack
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
        for package in [ESTIMATOR, "seatrial-cli", "seatrial-lab"] {
            counts.add(package, Path::new("a.rs"), &source);
        }
        let of = |name: &str| counts.0[name];
        let found = ["constants", "reason_codes", "verbs", "options", "lab_verbs"].map(of);
        assert_eq!(found, [2, 1, 2, 1, 2]);
        let limit = |name: &str| (name != "verbs").then(|| if name == "options" { 0 } else { 9 });
        let faults = counts.beside(limit);
        assert_eq!(faults.len(), 2, "{faults:?}");
        assert!(faults[0].starts_with("options: 1, at most 0"));
        assert!(faults[1].starts_with("verbs: 2, and no limit"));
        counts.raise("lines.seatrial", 9 + LINES_OF_SLACK);
        let of_lines = |counts: &Counts| {
            let faults = counts.beside(|_| Some(9));
            faults.iter().filter(|fault| fault.starts_with("lines.")).count()
        };
        assert_eq!(of_lines(&counts), 1, "the lines of the text come on top");
    }
}
