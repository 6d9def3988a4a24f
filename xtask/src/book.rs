//! The docs as a site: built, its links followed, its index for machines written.

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use anyhow::{Result, ensure};

use crate::shell::{Run, command, files, has, put, shell};
use crate::steps::missing;
use crate::workspace::{binary, in_target, root};
use crate::{alone, page, python};

/// The docs with the pages that are made of the program, which are no part of the repository.
const SOURCE: &str = "book-source";
const BOOK: &str = "book";
/// Fewer verbs than the program has: what lists fewer is not read rightly.
const FEWEST_VERBS: usize = 25;
/// What stands in its place where it has not been built.
const NOT_BUILT: &str = "<!DOCTYPE html>\n<html lang=\"en\"><meta charset=\"utf-8\"><title>seatrial</title>\n\
    <p>This site was built without the page. <code>cargo xtask page</code> builds it into <code>target/alone/seatrial.html</code>, \
    and <code>cargo xtask docs</code> then puts it here. <a href=\"howto/page.html\">More about the page</a></html>\n";
/// Where a page leads that is no part of the site.
const REPOSITORY: &str = "https://github.com/seatrial/seatrial/blob/main/";
const VERBS: &str = "# Verbs\n\nWhat each verb says with `--help-all`. Exit codes: 0 done, 1 internal fault, 2 usage, 3 input cannot be read or understood, 4 done but the\nresult is not to be used or was not validated, 5 trial aborted and vehicle handed back, 6 something could not be saved.\n";
const INDEX: &str = "# seatrial\n\n> Finds out how a marine vehicle steers, from a short sea trial or a log: a model with 95 % bounds, gains, turning limits, and a verdict.\n\n";

/// Builds the site and fails where a link leads nowhere.
pub fn check() -> Result<()> {
    let mdbook = mdbook()?;
    let (source, book) = (in_target(SOURCE), in_target(BOOK));
    shell().remove_path(&source)?;
    for file in files(Path::new("docs"), "")? {
        put(&file, source.join(file.strip_prefix("docs")?))?;
    }
    for page in files(Path::new("docs"), "md")? {
        shell().write_file(source.join(page.strip_prefix("docs")?), led_out(&page)?)?;
    }
    shell().write_file(source.join("reference/verbs.md"), verbs()?)?;
    command!("{mdbook} build {source}").run()?;
    // The page without a server, or where it has not been built a page that says how.
    match alone::place() {
        built if built.exists() => put(built, book.join("seatrial.html"))?,
        _ => shell().write_file(book.join("seatrial.html"), NOT_BUILT)?,
    }
    let contents = contents()?;
    let mut faults = unlisted(&contents)?;
    for page in files(&book, "html")? {
        faults.extend(broken_links(&page)?);
    }
    ensure!(faults.is_empty(), "{}", faults.join("\n"));
    let mut index = INDEX.to_owned();
    for (title, file) in contents {
        let sentence = first_sentence(&shell().read_file(source.join(&file))?);
        let page = Path::new(&file).with_extension("html");
        writeln!(index, "- [{title}]({}): {sentence}", page.display())?;
    }
    shell().write_file(book.join("llms.txt"), index)?;
    live_figures()
}

/// Moves the sliders of the figures that are computed where they are read, and holds their numbers against the terminal.
fn live_figures() -> Result<()> {
    if !alone::place().exists() {
        return missing("the page of the live figures is missing: cargo xtask page");
    }
    page::prepare()?;
    page::needs_browser()?;
    page::tests("tests/figures.check.ts").env("SEATRIAL_BOOK", in_target(BOOK)).run()
}

/// The page of the verbs: what the program says of each with `--help-all`, and of the verbs below it.
fn verbs() -> Result<String> {
    let mut page = VERBS.to_owned();
    add_verbs(&[], &mut page)?;
    let verbs = page.matches("\n```text\n").count();
    ensure!(verbs >= FEWEST_VERBS, "the command lists {verbs} verbs");
    Ok(page)
}

fn add_verbs(verb: &[&str], page: &mut String) -> Result<()> {
    let program = binary();
    let said = command!("{program} {verb...} --help-all").read()?;
    if !verb.is_empty() {
        let (marks, name) = ("#".repeat(verb.len() + 1), verb.join(" "));
        write!(page, "\n{marks} {name}\n\n```text\n{}\n```\n", said.trim_end())?;
    }
    listed_verbs(&said).try_for_each(|below| add_verbs(&[verb, &[below]].concat(), page))
}

/// The verbs that a help lists under `Commands:` and under the groups that follow.
fn listed_verbs(help: &str) -> impl Iterator<Item = &str> {
    let listed = help.lines().skip_while(|line| *line != "Commands:").skip(1);
    let listed = listed.take_while(|line| !["Arguments:", "Options:"].contains(line));
    let verbs = listed.filter(|line| line.starts_with("  ") && !line.starts_with("   "));
    verbs.filter_map(|line| line.split_whitespace().next()).filter(|verb| *verb != "help")
}

/// The one that docs/requirements.txt pins, else the machine's own.
fn mdbook() -> Result<PathBuf> {
    let own = python::OF_TESTS.path("mdbook");
    match own.exists() {
        true => Ok(own),
        false if has("mdbook") => Ok("mdbook".into()),
        false => missing("mdbook is missing, which Python brings (docs/requirements.txt)"),
    }
}

/// The titles and files of the table of contents.
fn contents() -> Result<Vec<(String, String)>> {
    let summary = shell().read_file(in_target(SOURCE).join("SUMMARY.md"))?;
    let entry = |line: &str| {
        let (title, rest) = line.split_once('[')?.1.split_once("](")?;
        let (file, _) = rest.split_once(')')?;
        Some((title.to_owned(), file.to_owned()))
    };
    Ok(summary.lines().filter_map(entry).collect())
}

/// Pages that nobody has put into the table of contents, which the site would lack.
fn unlisted(contents: &[(String, String)]) -> Result<Vec<String>> {
    let source = in_target(SOURCE);
    let is_listed = |page: &PathBuf| contents.iter().any(|(_, file)| *page == source.join(file));
    let others = files(&source, "md")?.into_iter();
    let others = others.filter(|page| !is_listed(page) && !page.ends_with("SUMMARY.md"));
    Ok(others.map(|page| format!("{}: is not in SUMMARY.md", page.display())).collect())
}

/// The text of a page, in which links to files of the repository that are no part of the site lead to the repository.
fn led_out(page: &Path) -> Result<String> {
    let text = shell().read_file(page)?;
    let links = text.split("](").skip(1).filter_map(|rest| rest.split([')', '#']).next());
    let links: BTreeSet<&str> = links.filter(|link| !link.is_empty()).collect();
    let mut led = text.clone();
    for link in links {
        if let Ok(path) = page.with_file_name(link).canonicalize()
            && let Ok(file) = path.strip_prefix(root().canonicalize()?)
            && !file.starts_with("docs")
        {
            let there = format!("]({REPOSITORY}{}", file.display());
            for end in [')', '#'] {
                led = led.replace(&format!("]({link}{end}"), &format!("{there}{end}"));
            }
        }
    }
    Ok(led)
}

/// Links of a page of the site to files that are not there.
fn broken_links(page: &Path) -> Result<Vec<String>> {
    let text = shell().read_file(page)?;
    let links = ["href=\"", "src=\""].into_iter().flat_map(|name| text.split(name).skip(1));
    let files = links.filter_map(|rest| rest.split(['"', '#', '?']).next());
    let own =
        files.filter(|file| !file.is_empty() && !file.contains(':') && !file.starts_with('/'));
    let broken = own.filter(|file| !page.with_file_name(file).exists());
    Ok(broken.map(|file| format!("{}: {file} leads nowhere", page.display())).collect())
}

/// The first sentence of a page's text.
fn first_sentence(page: &str) -> String {
    let mut is_in_block = false;
    let text = page.lines().filter(|line| {
        let is_fence = line.starts_with("```");
        is_in_block ^= is_fence;
        !is_in_block && !is_fence && !line.starts_with(['#', '<', '!'])
    });
    let text = text.skip_while(|line| line.is_empty()).take_while(|line| !line.is_empty());
    let text = text.collect::<Vec<_>>().join(" ");
    match text.split_once(". ") {
        Some((sentence, _)) => format!("{sentence}."),
        None => text,
    }
}
