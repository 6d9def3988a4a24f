//! Which output of this program a file is, by what its beginning says.

use std::fs::{self, File};
use std::io::Read;
use std::path::Path;

use super::OutputKind;

/// Bytes at the beginning of a file that say what it is.
const HEAD: u64 = 4096;

/// A vehicle in the language of another program.
const EXPORT: &str = "export";

/// A page, by its head.
const PAGE: &str = "page";

/// A first line that is shorter does not tell a table of ours from another.
const SHORTEST_HEADING: usize = 20;

/// The beginning of a file; empty where there is none, and of a device or a pipe, which would be read without end.
pub fn head_of(path: &Path) -> Vec<u8> {
    let mut head = Vec::new();
    if fs::metadata(path).is_ok_and(|about| about.is_file())
        && let Ok(file) = File::open(path)
    {
        // What cannot be read is judged by what could be.
        let _ = file.take(HEAD).read_to_end(&mut head);
    }
    head
}

/// Is there an output of this program, of whatever kind?
pub(super) fn is_output(path: &Path) -> bool {
    marked(&head_of(path)).is_some() || is_results(path)
}

/// May the new file take the place of the one that is there: is nothing there, or an output of the same kind?
pub(super) fn is_replaced(there: &Path, new: &Path) -> bool {
    let [there_head, new_head] = [there, new].map(head_of);
    if there_head.is_empty() {
        return fs::metadata(there).map_or(true, |about| about.len() == 0);
    }
    match (marked(&there_head), marked(&new_head)) {
        (None, None) => {
            let heading = heading(&there_head);
            (heading.is_some() && heading == self::heading(&new_head))
                || (is_results(there) && is_results(new))
        }
        (one, other) => one == other,
    }
}

/// Is nothing there, or an output of this kind?
pub(super) fn is_planned(there: &Path, planned: OutputKind) -> bool {
    let head = head_of(there);
    head.is_empty()
        || match planned {
            OutputKind::Page => marked(&head).as_deref() == Some(PAGE),
            OutputKind::Results => is_results(there),
        }
}

/// A table of the results of many logs.
fn is_results(path: &Path) -> bool {
    let has_verdict = |columns: Vec<String>| columns.iter().any(|name| name == "verdict");
    head_of(path).starts_with(b"PAR1") && seatrial_logs::columns(path).is_ok_and(has_verdict)
}

/// The kind of an output that says that it is one.
fn marked(head: &[u8]) -> Option<String> {
    let text = String::from_utf8_lossy(head);
    if text.starts_with("PK") {
        let is_fmu = text.contains("<fmiModelDescription") && text.contains("seatrial");
        return is_fmu.then(|| "FMU".into());
    }
    if text.contains("<meta name=\"generator\" content=\"seatrial\">") {
        return Some(PAGE.into());
    }
    let mut lines = text.lines();
    let kind = lines.by_ref().take(5).find_map(kind_of_line).or_else(|| {
        let manual = lines.find(|line| line.starts_with(".TH seatrial"));
        manual.map(|_| "manual".into())
    })?;
    // Languages begin differently.
    match kind == EXPORT {
        true => Some(format!("{EXPORT} {}", text.get(..2).unwrap_or_default())),
        false => Some(kind),
    }
}

/// As in `"schema": "seatrial.truth.v1"`, in `# PX4 rover parameters by seatrial` and in `// name, by seatrial`.
fn kind_of_line(line: &str) -> Option<String> {
    let schema =
        line.split_once("schema").map(|(_, rest)| rest.trim_start_matches(['"', ':', '=', ' ']));
    if let Some(schema) = schema.filter(|schema| schema.starts_with("seatrial.")) {
        return schema.split('"').next().map(str::to_owned);
    }
    if line.starts_with(".TH seatrial") {
        return Some("manual".into());
    }
    let (title, _) = line.split_once(" by seatrial")?;
    match title.strip_suffix(',') {
        Some(_) => Some(EXPORT.into()),
        None => Some(title.to_owned()),
    }
}

/// The first line of a table or a text.
fn heading(head: &[u8]) -> Option<&str> {
    let line = head.split(|byte| *byte == b'\n').next()?;
    let line = std::str::from_utf8(line).ok()?.trim();
    (line.len() >= SHORTEST_HEADING && !line.starts_with(['<', '{', '['])).then_some(line)
}
