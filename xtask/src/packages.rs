//! What is published on crates.io: whether every crate has what its page there needs, and whether all of them can be packed.

use anyhow::{Result, ensure};
use serde_json::Value;

use crate::container;
use crate::shell::{Run, command, shell};
use crate::workspace::{metadata, packages, root, text};

/// Most keywords of a crate, and most characters of one.
const KEYWORDS: (usize, usize) = (5, 20);
const VERSION: &str = env!("CARGO_PKG_VERSION");

/// What a packed crate holds besides its code.
const FILES: [&str; 4] = ["Cargo.toml", "README.md", "LICENSE-APACHE", "LICENSE-MIT"];

/// Fails on a published crate whose page would lack something, and on a container file that contradicts itself. `builds` also builds
/// each crate from what would be uploaded, in the order of their dependencies, as publishing does.
pub fn check(builds: bool) -> Result<()> {
    container::check()?;
    let crates = packages(metadata()?).iter();
    let (published, others): (Vec<_>, Vec<_>) = crates.partition(|package| is_published(package));
    let mut faults: Vec<String> = published
        .iter()
        .flat_map(|package| faults_of(package))
        .collect();
    for name in published.iter().map(|package| text(package, "name")) {
        let listed = command!("cargo package --list --allow-dirty -p {name}").read()?;
        let absent = FILES
            .iter()
            .filter(|file| !listed.lines().any(|line| line == **file));
        faults.extend(absent.map(|file| format!("{name}: the package lacks {file}")));
    }
    faults.extend(unlike_changes(&changes()?));
    ensure!(faults.is_empty(), "{}", faults.join("\n"));
    let others = others
        .iter()
        .flat_map(|package| ["--exclude", text(package, "name")]);
    let what = if builds {
        "publish --dry-run"
    } else {
        "package --no-verify"
    }
    .split(' ');
    command!("cargo {what...} --workspace --quiet --allow-dirty {others...}").run()?;
    eprintln!("== {} crates can be published", published.len());
    Ok(())
}

fn changes() -> Result<String> {
    Ok(shell().read_file(root().join("CHANGELOG.md"))?)
}

/// The changes begin with those of the workspace's version, released or not.
fn unlike_changes(changes: &str) -> Option<String> {
    let heading = changes
        .lines()
        .find_map(|line| line.strip_prefix("## "))
        .unwrap_or_default();
    let is_of_version = heading.split([' ', ',']).next() == Some(VERSION);
    (!is_of_version).then(|| {
        format!(
            "CHANGELOG.md: begins with {heading:?}; expected {VERSION}, the version in Cargo.toml"
        )
    })
}

/// `publish = false` is an empty list of registries.
pub fn is_published(package: &Value) -> bool {
    package["publish"] != serde_json::json!([])
}

fn faults_of(package: &Value) -> Vec<String> {
    const TEXTS: [&str; 5] = [
        "description",
        "license",
        "readme",
        "repository",
        "rust_version",
    ];
    let name = text(package, "name");
    let list = |field: &str| package[field].as_array().cloned().unwrap_or_default();
    let without = TEXTS
        .into_iter()
        .filter(|field| text(package, field).is_empty());
    let mut faults: Vec<String> = without.map(|field| format!("{name}: no {field}")).collect();
    let (most, longest) = KEYWORDS;
    let keywords = list("keywords");
    let is_short = |word: &Value| word.as_str().is_some_and(|word| word.len() <= longest);
    if !(1..=most).contains(&keywords.len()) || !keywords.iter().all(is_short) {
        faults.push(format!(
            "{name}: expected 1 to {most} keywords of at most {longest} characters"
        ));
    }
    if list("categories").is_empty() {
        faults.push(format!("{name}: no categories"));
    }
    let dependencies = list("dependencies").into_iter();
    let without_version = dependencies
        .filter(|on| on["path"].is_string() && on["kind"].is_null() && on["req"] == "*");
    faults.extend(without_version.map(|on| format!("{name}: no version of {}", text(&on, "name"))));
    faults
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_the_changes_begin_with_those_of_the_version() {
        assert_eq!(unlike_changes(&changes().unwrap()), None);
        let fault = unlike_changes("# Changes\n\n## 0.0.9, 2026-01-01\n").unwrap();
        assert!(fault.contains("0.0.9, 2026-01-01"), "{fault}");
        let released = format!("## {}, 2026-01-01", env!("CARGO_PKG_VERSION"));
        assert_eq!(unlike_changes(&released), None);
    }

    fn package(json: &str) -> Value {
        serde_json::from_str(json).unwrap()
    }

    #[test]
    fn exact_a_crate_whose_page_would_lack_something_is_named() {
        let whole = r#"{"name": "boat", "description": "d", "license": "MIT", "readme": "README.md", "repository": "r",
            "rust_version": "1.95", "keywords": ["marine"], "categories": ["simulation"],
            "dependencies": [{"name": "hull", "path": "hull", "req": "^0.1", "kind": null}]}"#;
        assert_eq!(faults_of(&package(whole)), Vec::<String>::new());
        for (part, by, fault) in [
            ("\"d\"", "null", "boat: no description"),
            (
                "[\"marine\"]",
                "[\"a-keyword-that-is-too-long\"]",
                "keywords",
            ),
            ("[\"simulation\"]", "[]", "boat: no categories"),
            ("^0.1", "*", "boat: no version of hull"),
        ] {
            let faults = faults_of(&package(&whole.replace(part, by)));
            assert!(faults.len() == 1 && faults[0].contains(fault), "{faults:?}");
        }
        assert!(is_published(&package("{\"publish\": null}")));
        assert!(!is_published(&package("{\"publish\": []}")));
    }
}
