//! Whether the code keeps the plan of the house: arrows between crates and modules, how long things are, and how many.

mod floors;
mod gates;
mod modules;
mod paths;
mod source;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::cargo;
use gates::Counts;
use modules::Modules;
use source::Source;

const FILE_LINES: usize = 500;
const FUNCTION_LINES: usize = 100;
const LONG_FUNCTION_LINES: usize = 60;

/// Crates with a file for each verb of theirs, which no list needs to name.
const HAS_A_FILE_A_VERB: [&str; 1] = ["seatrial-cli"];

/// The program of a crate's tests/, which names each file there as a module.
const TEST_PROGRAM: &str = "suite.rs";

/// What breaks the plan.
struct Finding {
    /// The rule and what breaks it.
    what: String,
    /// Where it is and by how much.
    detail: String,
}

/// What the code is found to be.
#[derive(Default)]
struct Survey {
    findings: Vec<Finding>,
    counts: Counts,
    lines: Vec<(String, usize)>,
    function_lengths: Vec<usize>,
    long_functions: Vec<String>,
}

/// Fails on what breaks the plan. `list` prints the long functions that it still allows.
pub fn check(list: bool) -> Result<(), String> {
    let survey = Survey::of_workspace()?;
    survey.print_lines();
    if list {
        for function in &survey.long_functions {
            println!("long-function {function}");
        }
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
        let plan = std::fs::read_to_string(root.join("ARCHITECTURE.md"))
            .map_err(|error| format!("ARCHITECTURE.md: {error}"))?;
        for package in metadata["packages"].as_array().into_iter().flatten() {
            survey.add_package(&root, package)?;
            survey.add_unnamed_rooms(&root, package, &plan)?;
            survey.add_forgotten_tests(&root, package)?;
        }
        for fault in survey.counts.faults(&root)? {
            survey.add("count", &fault, gates::LIMITS.into());
        }
        Ok(survey)
    }

    fn add(&mut self, rule: &str, what: &str, detail: String) {
        let what = format!("{rule} {what}");
        self.findings.push(Finding { what, detail });
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
                    self.counts.add(name, path, source);
                    self.add_file(name, path, source);
                }
            }
        }
        self.lines.push((name.to_owned(), lines));
        Ok(())
    }

    /// Modules of a crate that the plan does not name.
    fn add_unnamed_rooms(
        &mut self,
        root: &Path,
        package: &Value,
        plan: &str,
    ) -> Result<(), String> {
        let name = package["name"].as_str().unwrap_or_default();
        let Some(rooms) = rooms_of(plan, name).filter(|_| !HAS_A_FILE_A_VERB.contains(&name))
        else {
            return Ok(());
        };
        let library = root.join("crates").join(name).join("src/lib.rs");
        for module in Modules::read(library.strip_prefix(root).unwrap_or(&library))?.rooms() {
            if !rooms.contains(&module.as_str()) {
                self.add(
                    "room",
                    &format!("{name}/{module}"),
                    "is not in ARCHITECTURE.md".into(),
                );
            }
        }
        Ok(())
    }

    /// Files of tests that the crate's test program does not name, which would never run.
    fn add_forgotten_tests(&mut self, root: &Path, package: &Value) -> Result<(), String> {
        let name = package["name"].as_str().unwrap_or_default();
        let folder = root.join("crates").join(name).join("tests");
        let Ok(suite) = std::fs::read_to_string(folder.join(TEST_PROGRAM)) else {
            return Ok(());
        };
        let entries = std::fs::read_dir(&folder).map_err(|error| format!("{name}: {error}"))?;
        for path in entries.flatten().map(|entry| entry.path()) {
            let is_module =
                path.extension().is_some_and(|kind| kind == "rs") || path.join("mod.rs").exists();
            let module = path.file_stem().unwrap_or_default().to_string_lossy();
            if is_module
                && !path.ends_with(TEST_PROGRAM)
                && !suite.lines().any(|line| line == format!("mod {module};"))
            {
                let what = format!("{name}/tests/{module}");
                self.add("test", &what, format!("is not in {TEST_PROGRAM}"));
            }
        }
        Ok(())
    }

    fn add_file(&mut self, package: &str, path: &Path, source: &Source) {
        let path = path.display();
        if source.production_lines > FILE_LINES {
            let detail = format!("{} lines", source.production_lines);
            self.add("file", &path.to_string(), detail);
        }
        for function in source.functions() {
            self.function_lengths.push(function.lines);
            let place = format!("{path}:{}: {} lines", function.line, function.lines);
            if function.lines > FUNCTION_LINES {
                let what = format!("{package} {}", function.name);
                self.add("function", &what, place.clone());
            }
            if function.lines > LONG_FUNCTION_LINES {
                self.counts.raise("long_functions", 1);
                self.long_functions
                    .push(format!("{} at {place}", function.name));
            }
        }
        for (number, line) in source.text.lines().enumerate() {
            if leans_on_another(line) {
                let detail = format!("{path}:{}", number + 1);
                self.add("comment", "that does not stand alone", detail);
            }
        }
        if !floors::is_edge(package) {
            for line in source.string_errors() {
                let detail = format!("{path}:{line}");
                self.add("string-error", package, detail);
            }
        }
    }

    fn print_lines(&self) {
        let total: usize = self.lines.iter().map(|(_, lines)| lines).sum();
        for (name, lines) in &self.lines {
            println!("{lines:>7}  {name}");
        }
        let mut lengths = self.function_lengths.clone();
        lengths.sort_unstable();
        println!(
            "{total:>7}  lines of production code; {} functions, half of them of at most {} lines, {} over {LONG_FUNCTION_LINES}",
            lengths.len(),
            lengths.get(lengths.len() / 2).unwrap_or(&0),
            self.long_functions.len()
        );
    }

    fn faults(&self) -> Vec<String> {
        self.findings
            .iter()
            .map(|finding| format!("{}  ({})", finding.what, finding.detail))
            .collect()
    }
}

/// Does a documentation comment begin so that it is understood beside another one only?
fn leans_on_another(line: &str) -> bool {
    let line = line.trim_start();
    let text = line
        .strip_prefix("///")
        .or_else(|| line.strip_prefix("//!"));
    let text = text.unwrap_or_default().trim_start();
    ["The same ", "Likewise", "Of it"]
        .iter()
        .any(|opening| text.starts_with(opening))
}

/// The words of a crate in the list of rooms; `None` where it is not in the list.
fn rooms_of<'a>(plan: &'a str, package: &str) -> Option<Vec<&'a str>> {
    let starts: Vec<usize> = plan.match_indices("\ncrates/").map(|(at, _)| at).collect();
    let of_package = starts.iter().filter(|at| {
        let rest = plan[**at..].strip_prefix("\ncrates/");
        rest.and_then(|rest| rest.strip_prefix(package))
            .is_some_and(|rest| rest.starts_with('/'))
    });
    let sections = of_package.map(|at| {
        let end = plan[at + 1..]
            .find("\ncrates/")
            .map(|length| at + 1 + length);
        let end = end.or_else(|| plan[*at..].find("\n```").map(|length| at + length));
        &plan[*at..end.unwrap_or(plan.len())]
    });
    let is_word = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let words: Vec<&str> = sections
        .flat_map(|section| section.split(move |c| !is_word(c)))
        .filter(|word| !word.is_empty())
        .collect();
    (!words.is_empty()).then_some(words)
}

/// What a page names between backticks as a path of the project, and is not there.
fn missing_paths<'a>(root: &'a Path, page: &'a str) -> impl Iterator<Item = &'a str> {
    const FOLDERS: [&str; 7] = [
        "crates/",
        "xtask/",
        "docs/",
        "examples/",
        "fuzz/",
        "bench/",
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
