//! What is published on crates.io: whether every crate has what its page there needs, and whether all of them can be packed.

use std::path::Path;
use std::process::Command;

use serde_json::Value;

use crate::cargo;
use crate::steps::run;

/// Most keywords of a crate, and most characters of one.
const KEYWORDS: (usize, usize) = (5, 20);

/// What a packed crate holds besides its code.
const FILES: [&str; 4] = ["Cargo.toml", "README.md", "LICENSE-APACHE", "LICENSE-MIT"];

/// Fails on a published crate whose page would lack something. `builds` also builds each from what would be uploaded,
/// in the order of their dependencies, as publishing does.
pub fn check(builds: bool) -> Result<(), String> {
    let metadata = metadata()?;
    let packages = metadata["packages"].as_array().cloned();
    let packages = packages.unwrap_or_default();
    let (published, others): (Vec<&Value>, Vec<&Value>) =
        packages.iter().partition(|package| is_published(package));
    let mut faults: Vec<String> = published.iter().flat_map(|p| faults_of(p)).collect();
    for package in &published {
        faults.extend(missing_files(text(package, "name"))?);
    }
    faults.extend(unlike_changes(&changes()?));
    if !faults.is_empty() {
        return Err(faults.join("\n"));
    }
    let names: Vec<&str> = others.iter().map(|p| text(p, "name")).collect();
    run(
        &mut packing(builds, &names),
        "cargo could not pack the crates",
    )?;
    eprintln!("== {} crates can be published", published.len());
    Ok(())
}

/// What cargo knows of the workspace's crates.
pub fn metadata() -> Result<Value, String> {
    let output = cargo(&["metadata", "--format-version", "1", "--no-deps"])
        .output()
        .map_err(|error| format!("cargo metadata: {error}"))?;
    serde_json::from_slice(&output.stdout).map_err(|error| format!("cargo metadata: {error}"))
}

fn changes() -> Result<String, String> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../CHANGELOG.md");
    std::fs::read_to_string(&path).map_err(|error| format!("{}: {error}", path.display()))
}

/// The changes begin with those of the workspace's version, released or not.
fn unlike_changes(changes: &str) -> Option<String> {
    let heading = changes.lines().find_map(|line| line.strip_prefix("## "));
    let heading = heading.unwrap_or_default();
    let version = heading.split([' ', ',']).next().unwrap_or_default();
    (version != env!("CARGO_PKG_VERSION")).then(|| {
        format!(
            "CHANGELOG.md: begins with {heading:?}; expected {}, the version in Cargo.toml",
            env!("CARGO_PKG_VERSION")
        )
    })
}

/// Packs all crates that are published, or does what publishing does but for the upload.
fn packing(builds: bool, others: &[&str]) -> Command {
    let mut command = match builds {
        true => cargo(&["publish", "--workspace", "--dry-run", "--quiet"]),
        false => cargo(&["package", "--workspace", "--no-verify", "--quiet"]),
    };
    command.arg("--allow-dirty");
    for name in others {
        command.args(["--exclude", name]);
    }
    command
}

/// `publish = false` is an empty list of registries.
pub fn is_published(package: &Value) -> bool {
    package["publish"]
        .as_array()
        .is_none_or(|registries| !registries.is_empty())
}

fn text<'a>(package: &'a Value, field: &str) -> &'a str {
    package[field].as_str().unwrap_or_default()
}

fn faults_of(package: &Value) -> Vec<String> {
    let name = text(package, "name");
    let mut faults: Vec<String> = [
        "description",
        "license",
        "readme",
        "repository",
        "rust_version",
    ]
    .into_iter()
    .filter(|field| text(package, field).is_empty())
    .map(|field| format!("{name}: no {field}"))
    .collect();
    let words = |field: &str| package[field].as_array().cloned().unwrap_or_default();
    let keywords = words("keywords");
    let is_short = |word: &Value| word.as_str().is_some_and(|word| word.len() <= KEYWORDS.1);
    if keywords.is_empty() || keywords.len() > KEYWORDS.0 || !keywords.iter().all(is_short) {
        faults.push(format!(
            "{name}: expected 1 to {} keywords of at most {} characters",
            KEYWORDS.0, KEYWORDS.1
        ));
    }
    if words("categories").is_empty() {
        faults.push(format!("{name}: no categories"));
    }
    for dependency in words("dependencies") {
        let is_local = dependency["path"].is_string() && dependency["kind"].is_null();
        if is_local && text(&dependency, "req") == "*" {
            faults.push(format!(
                "{name}: no version of {}",
                text(&dependency, "name")
            ));
        }
    }
    faults
}

/// What the packed crate should hold and does not.
fn missing_files(name: &str) -> Result<Vec<String>, String> {
    let output = cargo(&["package", "--list", "--allow-dirty", "-p", name])
        .output()
        .map_err(|error| format!("cargo package: {error}"))?;
    let listed = String::from_utf8_lossy(&output.stdout).into_owned();
    let holds = |file: &str| {
        listed
            .lines()
            .any(|line| Path::new(line) == Path::new(file))
    };
    let missing = FILES.into_iter().filter(|file| !holds(file));
    Ok(missing
        .map(|file| format!("{name}: the package lacks {file}"))
        .collect())
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
