//! The docs as a site: built, its links followed, its index for machines written.

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::steps::{run, skipped};
use crate::target::{binary, in_target, target};
use crate::{alone, page, python};

const DOCS: &str = "docs";
/// The docs with the pages that are made of the program, which are no part of the repository.
const SOURCE: &str = "book-source";
const VERBS: &str = "reference/verbs.md";
const BOOK: &str = "book";
/// What stands in its place where it has not been built.
const NOT_BUILT: &str = "<!DOCTYPE html>\n<html lang=\"en\"><meta charset=\"utf-8\"><title>seatrial</title>\n\
    <p>This site was built without the page. <code>cargo xtask page</code> builds it into <code>target/alone/seatrial.html</code>, \
    and <code>cargo xtask docs</code> then puts it here. <a href=\"howto/page.html\">More about the page</a></html>\n";
/// Where a page leads that is no part of the site.
const REPOSITORY: &str = "https://github.com/seatrial/seatrial/blob/main/";

/// Builds the site and fails where a link leads nowhere.
pub fn check() -> Result<(), String> {
    let Some(program) = mdbook() else {
        return skipped(
            "the docs as a site",
            "mdbook is missing, which Python brings (docs/requirements.txt)",
        );
    };
    let source = in_target(SOURCE);
    let _ = std::fs::remove_dir_all(&source);
    copy(Path::new(DOCS), &source)?;
    write(&source.join(VERBS), &verbs()?)?;
    run(
        Command::new(program).arg("build").arg(&source),
        format!("mdbook build {}", source.display()),
    )?;
    let pages = of_suffix(&in_target(BOOK), "html")?;
    for page in &pages {
        lead_out(page)?;
    }
    put_alone()?;
    let mut broken = unlisted()?;
    broken.extend(pages.iter().flat_map(|page| broken_links(page)));
    if !broken.is_empty() {
        return Err(broken.join("\n"));
    }
    let index = index_for_machines()?;
    write(&in_target(BOOK).join("llms.txt"), &index)?;
    live_figures()
}

/// Moves the sliders of the figures that are computed where they are read, and holds their numbers against the terminal.
fn live_figures() -> Result<(), String> {
    if !alone::place().exists() || !page::prepared() || !Path::new(page::BROWSER).exists() {
        return skipped(
            "the live figures of the docs",
            "the page without a server (cargo xtask page), npm or chromium is missing",
        );
    }
    let mut tests = page::node();
    tests
        .args(["--test", "--test-reporter=spec", "tests/figures.check.ts"])
        .env("SEATRIAL_BOOK", in_target(BOOK))
        .env("SEATRIAL", binary());
    run(&mut tests, "tests of the live figures")
}

/// Puts the page without a server where the docs link to it, once it has been built; where it has not been built, a page that says how.
fn put_alone() -> Result<(), String> {
    let place = in_target(BOOK).join("seatrial.html");
    let built = alone::place();
    match built.exists() {
        true => std::fs::copy(&built, &place)
            .map(|_| ())
            .map_err(|error| format!("{}: {error}", built.display())),
        false => write(&place, NOT_BUILT),
    }
}

fn write(path: &Path, text: &str) -> Result<(), String> {
    std::fs::write(path, text).map_err(|error| format!("{}: {error}", path.display()))
}

/// Copies a folder with all that is in it.
fn copy(from: &Path, to: &Path) -> Result<(), String> {
    let failed = |error: std::io::Error| format!("{}: {error}", from.display());
    std::fs::create_dir_all(to).map_err(failed)?;
    for entry in std::fs::read_dir(from).map_err(failed)? {
        let path = entry.map_err(failed)?.path();
        let place = to.join(path.file_name().unwrap_or_default());
        match path.is_dir() {
            true => copy(&path, &place)?,
            false => std::fs::copy(&path, &place).map(|_| ()).map_err(failed)?,
        }
    }
    Ok(())
}

/// The page of the verbs: what the program says of each with `--help-all`, and of the verbs below it.
fn verbs() -> Result<String, String> {
    let program = binary();
    let help = |words: &[&str]| {
        let said = Command::new(&program)
            .args(words)
            .arg("--help-all")
            .output();
        said.map(|said| String::from_utf8_lossy(&said.stdout).into_owned())
            .map_err(|error| format!("{}: {error}", program.display()))
    };
    let mut text = "# Verbs\n\nWhat each verb says with `--help-all`. Exit codes: 0 done, 1 internal fault, 2 usage, 3 input cannot be read or understood, 4 done but the\nresult is not to be used or was not validated, 5 trial aborted and vehicle handed back, 6 something could not be saved.\n"
        .to_owned();
    let mut count = [0, 0];
    let listed = help(&[])?;
    for verb in listed_verbs(&listed) {
        let said = help(&[verb])?;
        let _ = write!(text, "\n## {verb}\n\n```text\n{}\n```\n", said.trim_end());
        count[0] += 1;
        for below in listed_verbs(&said) {
            let said = help(&[verb, below])?;
            let said = said.trim_end();
            let _ = write!(text, "\n### {verb} {below}\n\n```text\n{said}\n```\n");
            count[1] += 1;
        }
    }
    if count[0] < 15 || count[1] < 10 {
        let [verbs, below] = count;
        let program = program.display();
        return Err(format!(
            "{program} lists {verbs} verbs and {below} below them"
        ));
    }
    Ok(text)
}

/// The verbs that a help lists under `Commands:` and under the groups that follow.
fn listed_verbs(help: &str) -> impl Iterator<Item = &str> {
    help.lines()
        .skip_while(|line| *line != "Commands:")
        .skip(1)
        .take_while(|line| *line != "Options:")
        .filter(|line| line.starts_with("  ") && !line.starts_with("   "))
        .filter_map(|line| line.split_whitespace().next())
        .filter(|verb| *verb != "help")
}

/// The one that docs/requirements.txt pins, else the machine's own.
fn mdbook() -> Option<PathBuf> {
    let own = python::of_tests("mdbook");
    if own.exists() {
        return Some(own);
    }
    let is_there = Command::new("mdbook").arg("--version").output().is_ok();
    is_there.then(|| "mdbook".into())
}

fn read(path: &Path) -> Result<String, String> {
    std::fs::read_to_string(path).map_err(|error| format!("{}: {error}", path.display()))
}

/// The titles and files of the table of contents.
fn contents() -> Result<Vec<(String, String)>, String> {
    let summary = read(&in_target(SOURCE).join("SUMMARY.md"))?;
    let entry = |line: &str| {
        let (_, rest) = line.split_once('[')?;
        let (title, rest) = rest.split_once("](")?;
        let (file, _) = rest.split_once(')')?;
        Some((title.to_owned(), file.to_owned()))
    };
    Ok(summary.lines().filter_map(entry).collect())
}

/// Pages that nobody has put into the table of contents, which the site would lack.
fn unlisted() -> Result<Vec<String>, String> {
    let source = in_target(SOURCE);
    let listed = contents()?.into_iter().map(|(_, file)| source.join(file));
    let listed: BTreeSet<PathBuf> = listed.chain([source.join("SUMMARY.md")]).collect();
    let pages = of_suffix(&source, "md")?.into_iter();
    let others = pages.filter(|page| !listed.contains(page));
    Ok(others
        .map(|page| format!("{}: is not in SUMMARY.md", page.display()))
        .collect())
}

fn of_suffix(folder: &Path, suffix: &str) -> Result<Vec<PathBuf>, String> {
    let failed = |error: std::io::Error| format!("{}: {error}", folder.display());
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(failed)? {
        let path = entry.map_err(failed)?.path();
        if path.is_dir() {
            found.extend(of_suffix(&path, suffix)?);
        } else if path.extension().is_some_and(|own| own == suffix) {
            found.push(path);
        }
    }
    found.sort();
    Ok(found)
}

/// Where the links of a page lead, as they are written.
fn links(page: &str) -> impl Iterator<Item = &str> {
    let behind = ["href=\"", "src=\""]
        .into_iter()
        .flat_map(|name| page.split(name).skip(1));
    behind.filter_map(|rest| rest.split('"').next())
}

fn is_own(link: &str) -> bool {
    !link.is_empty() && !link.contains(':') && !link.starts_with(['#', '/'])
}

/// The file that a link of a page leads to, without `..`.
fn file_behind(page: &Path, link: &str) -> PathBuf {
    let file = link.split(['#', '?']).next().unwrap_or_default();
    let mut path = page.parent().unwrap_or(Path::new("")).to_path_buf();
    for part in file.split('/') {
        match part {
            ".." => {
                path.pop();
            }
            "." | "" => {}
            part => path.push(part),
        }
    }
    path
}

/// Links to files of the repository that are no part of the site lead to the repository.
fn lead_out(page: &Path) -> Result<(), String> {
    let text = read(page)?;
    let mut led = text.clone();
    for link in links(&text).filter(|link| is_own(link)) {
        let path = file_behind(page, link);
        if let Some(outside) = path
            .strip_prefix(target())
            .ok()
            .filter(|_| !path.starts_with(in_target(BOOK)))
        {
            let outside = outside.display().to_string();
            let source = match outside.strip_suffix(".html") {
                Some(stem) => format!("{stem}.md"),
                None => outside,
            };
            if !Path::new(&source).exists() {
                return Err(format!("{}: {link} leads nowhere", page.display()));
            }
            led = led.replace(
                &format!("=\"{link}\""),
                &format!("=\"{REPOSITORY}{source}\""),
            );
        }
    }
    std::fs::write(page, led).map_err(|error| format!("{}: {error}", page.display()))
}

fn broken_links(page: &Path) -> Vec<String> {
    let text = read(page).unwrap_or_default();
    let own = links(&text).filter(|link| is_own(link));
    own.filter(|link| !file_behind(page, link).exists())
        .map(|link| format!("{}: {link} leads nowhere", page.display()))
        .collect()
}

/// The first sentence of a page's text.
fn first_sentence(page: &str) -> String {
    let mut is_in_block = false;
    let text = page.lines().filter(|line| {
        let is_fence = line.starts_with("```");
        is_in_block ^= is_fence;
        !is_in_block && !is_fence && !line.starts_with(['#', '<', '!'])
    });
    let text: Vec<&str> = text
        .skip_while(|line| line.is_empty())
        .take_while(|line| !line.is_empty())
        .collect();
    let text = text.join(" ");
    match text.split_once(". ") {
        Some((sentence, _)) => format!("{sentence}."),
        None => text,
    }
}

/// What there is to read, for programs that assist people: a line a page.
fn index_for_machines() -> Result<String, String> {
    let mut index = "# seatrial\n\n> Finds out how a marine vehicle steers, from a short sea trial or a log: a model with 95 % bounds, gains, turning limits, and a verdict.\n\n"
        .to_owned();
    for (title, file) in contents()? {
        let text = read(&in_target(SOURCE).join(&file))?;
        let page = Path::new(&file).with_extension("html");
        let _ = writeln!(
            index,
            "- [{title}]({}): {}",
            page.display(),
            first_sentence(&text)
        );
    }
    Ok(index)
}
