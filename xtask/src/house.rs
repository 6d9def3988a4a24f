//! Whether the code keeps the plan of the house: arrows between crates and modules, how long things are, and how many.

mod floors;
mod gates;
mod modules;
mod owners;
mod paths;
mod source;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use anyhow::{Result, ensure};
use serde_json::Value;

use crate::shell::shell;
use crate::workspace::{metadata, packages, root, text};
use gates::Counts;
use modules::Modules;
use source::Source;

const FILE_LINES: usize = 500;
const FUNCTION_LINES: usize = 100;
const LONG_FUNCTION_LINES: usize = 60;
const PLAN: &str = "ARCHITECTURE.md";

/// The crate with a file for each verb of its own, which no list needs to name.
const HAS_A_FILE_A_VERB: &str = "seatrial-cli";
/// What is no production code.
const OTHER_TARGETS: [&str; 4] = ["test", "example", "bench", "custom-build"];
/// The program of a crate's tests/, which names each file there as a module.
const TEST_PROGRAM: &str = "suite.rs";
/// How a documentation comment begins that is understood beside another one only.
const LEANING: [&str; 3] = ["The same ", "Likewise", "Of it"];

/// What the code is found to be.
#[derive(Default)]
struct Survey {
    /// What breaks the plan: the rule, what breaks it, and where or by how much.
    faults: Vec<String>,
    counts: Counts,
    function_lengths: Vec<usize>,
    example_lines: usize,
    long_functions: Vec<String>,
}

/// Fails on what breaks the plan. `list` prints the long functions that it still allows.
pub fn check(list: bool) -> Result<()> {
    let mut survey = Survey::default();
    survey
        .faults
        .extend(floors::violations(metadata()?).into_iter().map(|arrow| format!("floor {arrow}")));
    for page in [PLAN, "CONTRIBUTING.md"] {
        let text = shell().read_file(page)?;
        survey.faults.extend(
            missing_paths(&text).map(|path| format!("path {page} {path}  (does not exist)")),
        );
    }
    let plan = shell().read_file(PLAN)?;
    for package in packages(metadata()?) {
        survey.add_package(package, &plan)?;
        survey.add_forgotten_tests(text(package, "name"));
    }
    let above = survey.counts.faults()?.into_iter();
    survey.faults.extend(above.map(|fault| format!("count {fault}  ({})", gates::LIMITS)));
    survey.print_lines();
    if list {
        survey.long_functions.iter().for_each(|function| println!("long-function {function}"));
    }
    ensure!(survey.faults.is_empty(), "{}", survey.faults.join("\n"));
    Ok(())
}

impl Survey {
    fn add_package(&mut self, package: &Value, plan: &str) -> Result<()> {
        let name = text(package, "name");
        let mut seen = BTreeSet::new();
        for target in package["targets"].as_array().into_iter().flatten() {
            if OTHER_TARGETS.contains(&target["kind"][0].as_str().unwrap_or_default()) {
                continue;
            }
            let path = Path::new(text(target, "src_path"));
            let modules = Modules::read(path.strip_prefix(root()).unwrap_or(path))?;
            for circle in modules.circles() {
                self.faults.push(format!(
                    "circle {name}/{}  ({})",
                    circle.name,
                    circle.places.join("; ")
                ));
            }
            if let Some(rooms) = rooms_of(plan, name)
                .filter(|_| path.ends_with("lib.rs") && name != HAS_A_FILE_A_VERB)
            {
                let unnamed = modules.rooms().filter(|module| !rooms.contains(&module.as_str()));
                self.faults.extend(
                    unnamed.map(|module| format!("room {name}/{module}  (is not in {PLAN})")),
                );
            }
            for (path, source) in &modules.files {
                if seen.insert(path.clone()) {
                    self.counts.add(name, path, source);
                    self.add_file(name, path, source);
                    self.faults.extend(owners::faults(name, path, &source.text, plan));
                }
            }
        }
        Ok(())
    }

    /// Files of tests that the crate's test program does not name, which would never run.
    fn add_forgotten_tests(&mut self, name: &str) {
        let folder = PathBuf::from(format!("crates/{name}/tests"));
        let Ok(suite) = shell().read_file(folder.join(TEST_PROGRAM)) else {
            return;
        };
        for path in shell().read_dir(&folder).unwrap_or_default() {
            let is_module =
                path.extension().is_some_and(|kind| kind == "rs") || path.join("mod.rs").exists();
            let module = path.file_stem().unwrap_or_default().to_string_lossy();
            let is_named = path.ends_with(TEST_PROGRAM)
                || suite.lines().any(|line| line == format!("mod {module};"));
            if is_module && !is_named {
                self.faults.push(format!("test {name}/tests/{module}  (is not in {TEST_PROGRAM})"));
            }
        }
    }

    fn add_file(&mut self, package: &str, path: &Path, source: &Source) {
        let path = path.display();
        if source.production_lines > FILE_LINES {
            self.faults.push(format!("file {path}  ({} lines)", source.production_lines));
        }
        self.example_lines += source.example_lines;
        for function in &source.functions {
            self.function_lengths.push(function.lines);
            let place =
                format!("{} at {path}:{}: {} lines", function.name, function.line, function.lines);
            if function.lines > FUNCTION_LINES {
                self.faults.push(format!("function {package} {place}"));
            }
            if function.lines > LONG_FUNCTION_LINES {
                self.counts.raise("long_functions", 1);
                self.long_functions.push(place);
            }
        }
        for (number, line) in (1..).zip(source.text.lines().map(str::trim_start)) {
            let comment = line.strip_prefix("///").or_else(|| line.strip_prefix("//!"));
            let comment = comment.unwrap_or_default().trim_start();
            if LEANING.iter().any(|opening| comment.starts_with(opening)) {
                self.faults.push(format!("comment that does not stand alone  ({path}:{number})"));
            }
        }
        if !floors::is_edge(package) {
            let places = source.string_errors.iter();
            self.faults
                .extend(places.map(|line| format!("string-error {package}  ({path}:{line})")));
        }
    }

    fn print_lines(&mut self) {
        let mut total = 0;
        for (name, lines) in self.counts.lines() {
            println!("{lines:>7}  {name}");
            total += lines;
        }
        println!("{}", self.counts.of_terminals());
        self.function_lengths.sort_unstable();
        println!(
            "{total:>7}  lines of production code, {} of them examples in docs, which run as tests; {} functions, half of them of at most {} lines, {} over {LONG_FUNCTION_LINES}",
            self.example_lines,
            self.function_lengths.len(),
            self.function_lengths[self.function_lengths.len() / 2],
            self.long_functions.len()
        );
    }
}

/// The words of a crate in the list of rooms; `None` where it is not in the list.
fn rooms_of<'a>(plan: &'a str, package: &str) -> Option<Vec<&'a str>> {
    let is_of_package =
        |section: &&str| section.strip_prefix(package).is_some_and(|rest| rest.starts_with('/'));
    let sections = plan.split("\ncrates/").skip(1).filter(is_of_package);
    let lists = sections.filter_map(|section| section.split("\n```").next());
    let is_word = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let words: Vec<&str> = lists.flat_map(|list| list.split(move |c| !is_word(c))).collect();
    (!words.is_empty()).then_some(words)
}

/// What a page names between backticks as a path of the project, and is not there.
fn missing_paths(page: &str) -> impl Iterator<Item = &str> {
    const FOLDERS: &str = "crates/ xtask/ docs/ examples/ fuzz/ bench/ validation/";
    let quoted = page.split('`').skip(1).step_by(2);
    let paths = quoted.filter(|quoted| FOLDERS.split(' ').any(|folder| quoted.starts_with(folder)));
    paths.filter(|path| !path.contains([' ', '{', '*', '\n']) && !root().join(path).exists())
}
