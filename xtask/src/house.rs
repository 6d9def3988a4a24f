//! Whether the code keeps the plan of the house: arrows between crates and modules, and how long things are.

mod allowed;
mod floors;
mod modules;
mod paths;
mod source;

use std::cmp::Ordering;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::cargo;
use modules::Modules;
use source::Source;

const FILE_LINES: usize = 500;
const FUNCTION_LINES: usize = 100;
const LONG_FUNCTION_LINES: usize = 60;
const LONG_FUNCTIONS: usize = 30;

/// What breaks the plan.
struct Finding {
    /// What stands in the table of what is still allowed.
    key: String,
    /// Where it is and by how much.
    detail: String,
}

/// What the code is found to be.
#[derive(Default)]
struct Survey {
    findings: Vec<Finding>,
    lines: Vec<(String, usize)>,
    string_errors: BTreeMap<String, Vec<String>>,
    long_functions: Vec<String>,
}

/// Fails on what the table does not allow, and on what it allows without need. `list` prints everything that is still to be mended.
pub fn check(list: bool) -> Result<(), String> {
    let survey = Survey::of_workspace()?;
    survey.print_lines();
    if list {
        survey.print_remaining();
    }
    let faults = survey.faults();
    match faults.is_empty() {
        true => Ok(()),
        false => Err(faults.join("\n")),
    }
}

impl Survey {
    fn of_workspace() -> Result<Self, String> {
        let output = cargo(&["metadata", "--format-version", "1", "--no-deps"])
            .output()
            .map_err(|error| format!("cargo metadata: {error}"))?;
        let metadata: Value = serde_json::from_slice(&output.stdout)
            .map_err(|error| format!("cargo metadata: {error}"))?;
        let root = PathBuf::from(metadata["workspace_root"].as_str().unwrap_or_default());
        let mut survey = Self::default();
        for arrow in floors::violations(&metadata) {
            survey.add("floor", &arrow, String::new());
        }
        for page in ["ARCHITECTURE.md", "CONTRIBUTING.md"] {
            let text = std::fs::read_to_string(root.join(page))
                .map_err(|error| format!("{page}: {error}"))?;
            for path in missing_paths(&root, &text) {
                survey.add("path", &format!("{page} {path}"), "does not exist".into());
            }
        }
        for package in metadata["packages"].as_array().into_iter().flatten() {
            survey.add_package(&root, package)?;
        }
        Ok(survey)
    }

    fn add(&mut self, rule: &str, what: &str, detail: String) {
        let key = format!("{rule} {what}");
        self.findings.push(Finding { key, detail });
    }

    fn add_package(&mut self, root: &Path, package: &Value) -> Result<(), String> {
        let name = package["name"].as_str().unwrap_or_default();
        let mut seen = BTreeSet::new();
        let mut lines = 0;
        for target in package["targets"].as_array().into_iter().flatten() {
            if ["test", "example", "bench", "custom-build"].contains(&kind(target)) {
                continue;
            }
            let path = PathBuf::from(target["src_path"].as_str().unwrap_or_default());
            let path = path.strip_prefix(root).unwrap_or(&path);
            let modules = Modules::read(path)?;
            for circle in modules.circles() {
                let what = format!("{name}/{}", circle.name);
                self.add("circle", &what, circle.places.join("; "));
            }
            for (path, source) in modules.files() {
                if seen.insert(path.clone()) {
                    lines += source.production_lines;
                    self.add_file(name, path, source);
                }
            }
        }
        self.lines.push((name.to_owned(), lines));
        Ok(())
    }

    fn add_file(&mut self, package: &str, path: &Path, source: &Source) {
        let path = path.display();
        if source.production_lines > FILE_LINES {
            let detail = format!("{} lines", source.production_lines);
            self.add("file", &path.to_string(), detail);
        }
        for function in source.functions() {
            let place = format!("{path}:{}: {} lines", function.line, function.lines);
            if function.lines > FUNCTION_LINES {
                let what = format!("{package} {}", function.name);
                self.add("function", &what, place.clone());
            }
            if function.lines > LONG_FUNCTION_LINES {
                self.long_functions
                    .push(format!("{} at {place}", function.name));
            }
        }
        if !floors::is_edge(package) {
            let lines = source.string_errors().into_iter();
            let places = lines.map(|line| format!("{path}:{line}"));
            let all = self.string_errors.entry(package.to_owned()).or_default();
            all.extend(places);
        }
    }

    fn print_lines(&self) {
        let total: usize = self.lines.iter().map(|(_, lines)| lines).sum();
        for (name, lines) in &self.lines {
            println!("{lines:>7}  {name}");
        }
        println!(
            "{total:>7}  lines of production code; {} functions over {LONG_FUNCTION_LINES} lines",
            self.long_functions.len()
        );
    }

    fn print_remaining(&self) {
        for finding in &self.findings {
            println!("{}  ({})", finding.key, finding.detail);
        }
        for function in &self.long_functions {
            println!("long-function {function}");
        }
        for place in self.string_errors.values().flatten() {
            println!("string-error {place}");
        }
    }

    fn faults(&self) -> Vec<String> {
        let found: BTreeSet<&str> = self.findings.iter().map(|f| f.key.as_str()).collect();
        let mut faults: Vec<String> = self
            .findings
            .iter()
            .filter(|finding| !allowed::ALLOWED.contains(&finding.key.as_str()))
            .map(|finding| format!("{}  ({})", finding.key, finding.detail))
            .collect();
        for key in allowed::ALLOWED {
            if !found.contains(key) {
                faults.push(format!("mended: take \"{key}\" out of ALLOWED"));
            }
        }
        let limit = LONG_FUNCTIONS.max(allowed::LONG_FUNCTIONS);
        let long = &self.long_functions;
        faults.extend(over("LONG_FUNCTIONS", long, limit, LONG_FUNCTIONS));
        for (package, errors) in &self.string_errors {
            let entry = allowed::STRING_ERRORS.iter().find(|(p, _)| p == package);
            let limit = entry.map_or(0, |(_, limit)| *limit);
            faults.extend(over(
                &format!("STRING_ERRORS of {package}"),
                errors,
                limit,
                0,
            ));
        }
        let unknown = allowed::STRING_ERRORS
            .iter()
            .filter(|(package, _)| !self.string_errors.contains_key(*package));
        faults.extend(unknown.map(|(package, _)| format!("STRING_ERRORS: {package} is no crate")));
        faults
    }
}

/// What to say of places that are more than `allowed`, or fewer although the plan's `limit` is lower still.
fn over(name: &str, places: &[String], allowed: usize, limit: usize) -> Option<String> {
    let count = places.len();
    match count.cmp(&allowed) {
        Ordering::Greater => Some(format!(
            "{name}: {count}, allowed are {allowed}:\n  {}",
            places.join("\n  ")
        )),
        Ordering::Less if allowed > limit => {
            Some(format!("mended: lower {name} to {}", count.max(limit)))
        }
        _ => None,
    }
}

/// What a page names between backticks as a path of the project, and is not there.
fn missing_paths<'a>(root: &'a Path, page: &'a str) -> impl Iterator<Item = &'a str> {
    const FOLDERS: [&str; 7] = [
        "crates/",
        "xtask/",
        "docs/",
        "fuzz/",
        "bench/",
        "scenarios/",
        "validation/",
    ];
    page.split('`')
        .skip(1)
        .step_by(2)
        .filter(|quoted| !quoted.contains([' ', '{', '*', '\n']))
        .filter(|quoted| FOLDERS.iter().any(|folder| quoted.starts_with(folder)))
        .filter(|path| !root.join(path).exists())
}

fn kind(target: &Value) -> &str {
    target["kind"][0].as_str().unwrap_or_default()
}
