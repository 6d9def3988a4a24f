//! What is published on crates.io: whether every crate can be packed with what its page there needs.

use std::path::PathBuf;

use anyhow::{Result, ensure};
use serde_json::{Value, json};

use crate::shell::{Run, command, shell};
use crate::workspace::{in_target, metadata, packages, text};

/// What a packed crate holds besides its code.
const FILES: [&str; 4] = ["Cargo.toml", "README.md", "LICENSE-APACHE", "LICENSE-MIT"];

/// Packs every published crate. `builds` also builds each from what would be uploaded, in the order of their dependencies, as publishing does.
pub fn check(builds: bool) -> Result<()> {
    let crates = packages(metadata()?).iter();
    let (published, others): (Vec<_>, Vec<_>) = crates.partition(|package| is_published(package));
    for name in published.iter().map(|package| text(package, "name")) {
        let listed = command!("cargo package --list --allow-dirty -p {name}").read()?;
        for file in FILES {
            ensure!(listed.lines().any(|line| line == file), "{name}: the package lacks {file}");
        }
    }
    let others = others.iter().flat_map(|package| ["--exclude", text(package, "name")]);
    let what = if builds {
        forget_unpacked()?;
        ["publish", "--dry-run"]
    } else {
        ["package", "--no-verify"]
    };
    let mut cargo = command!("cargo {what...} --workspace --quiet --allow-dirty {others...}");
    let built = in_target("publish");
    cargo.env("CARGO_TARGET_DIR", &built).run()?;
    shell().remove_path(built)?;
    eprintln!("== {} crates can be published", published.len());
    Ok(())
}

/// Removes the crates that an earlier check unpacked and built: cargo keeps them by their version, and their version is the same.
fn forget_unpacked() -> Result<()> {
    shell().remove_path(in_target("publish"))?;
    let of_user = || std::env::home_dir().map(|home| home.join(".cargo"));
    let cargo = std::env::var_os("CARGO_HOME").map(PathBuf::from);
    let Some(cargo) = cargo.or_else(of_user) else {
        return Ok(());
    };
    // On a machine that has fetched nothing yet there is no such folder.
    let registries = shell().read_dir(cargo.join("registry/src"));
    let is_of_check = |registry: &PathBuf| {
        let name = registry.file_name().unwrap_or_default();
        name.to_string_lossy().starts_with('-')
    };
    for registry in registries.unwrap_or_default().iter().filter(|r| is_of_check(r)) {
        for package in packages(metadata()?) {
            let [name, version] = ["name", "version"].map(|field| text(package, field));
            shell().remove_path(registry.join(format!("{name}-{version}")))?;
        }
    }
    Ok(())
}

/// `publish = false` is an empty list of registries.
pub fn is_published(package: &Value) -> bool {
    package["publish"] != json!([])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Most keywords of a crate on crates.io, and most characters of one.
    const KEYWORDS: (usize, usize) = (5, 20);

    #[test]
    fn exact_the_changes_begin_with_those_of_the_version() {
        let changes = include_str!("../../CHANGELOG.md");
        let heading = changes.lines().find_map(|line| line.strip_prefix("## "));
        let version = heading.unwrap().split([' ', ',']).next();
        assert_eq!(version, Some(env!("CARGO_PKG_VERSION")), "{heading:?}");
    }

    fn faults_of(package: &Value) -> Vec<String> {
        const TEXTS: [&str; 5] = ["description", "license", "readme", "repository", "rust_version"];
        let name = text(package, "name");
        let list = |field: &str| package[field].as_array().cloned().unwrap_or_default();
        let without = TEXTS.into_iter().filter(|field| text(package, field).is_empty());
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
        faults
    }

    /// Somebody who upgrades reads it whole.
    #[test]
    fn exact_a_release_takes_sixty_lines_of_the_changelog() {
        let releases = include_str!("../../CHANGELOG.md").split("\n## ").skip(1);
        for release in releases {
            let (lines, title) = (release.lines().count(), release.lines().next());
            assert!(lines <= 60, "{title:?}: {lines} lines");
        }
    }

    #[test]
    fn exact_every_published_crate_has_what_its_page_needs() {
        let published =
            packages(metadata().unwrap()).iter().filter(|package| is_published(package));
        let faults: Vec<String> = published.flat_map(faults_of).collect();
        assert_eq!(faults, Vec::<String>::new());
    }

    #[test]
    fn exact_a_crate_whose_page_would_lack_something_is_named() {
        let whole = r#"{"name": "boat", "description": "d", "license": "MIT", "readme": "README.md", "repository": "r",
            "rust_version": "1.95", "keywords": ["marine"], "categories": ["simulation"]}"#;
        assert_eq!(faults_of(&serde_json::from_str(whole).unwrap()), Vec::<String>::new());
        for (part, by, fault) in [
            ("\"d\"", "null", "boat: no description"),
            ("[\"marine\"]", "[\"a-keyword-that-is-too-long\"]", "keywords"),
            ("[\"simulation\"]", "[]", "boat: no categories"),
        ] {
            let faults = faults_of(&serde_json::from_str(&whole.replace(part, by)).unwrap());
            assert!(faults.len() == 1 && faults[0].contains(fault), "{faults:?}");
        }
        assert!(is_published(&json!({"publish": null})));
        assert!(!is_published(&json!({"publish": []})));
    }
}
