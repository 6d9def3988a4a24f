//! Hashes of documents, one line each.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use anyhow::{Result, bail};
use sha2::{Digest, Sha256};

use crate::shell::shell;

use super::document::{Document, first_difference, split_sentences};

const HEADER: &str =
    "# SHA-256 of the values, the first 16 digits of that of the sentences, exit code, document";

/// What the documents of a binary hash to.
pub struct Manifest {
    /// Where the documents themselves are, if they are known.
    folder: Option<PathBuf>,
    entries: BTreeMap<String, Entry>,
}

/// The hash of the values, that of the sentences, the exit code.
type Entry = [String; 3];

impl Manifest {
    /// The hashes of documents at hand.
    pub fn of(documents: &[Document]) -> Self {
        let entry = |document: &Document| {
            let (values, sentences) = split_sentences(&document.value);
            let sentences = &sha256(&sentences.join(
                "
",
            ))[..16];
            let entry =
                [sha256(&values.to_string()), sentences.to_owned(), document.exit.to_string()];
            (document.name.clone(), entry)
        };
        Self { folder: None, entries: documents.iter().map(entry).collect() }
    }

    /// Reads a manifest, or the one in a folder of documents.
    pub fn read(path: &Path) -> Result<Self> {
        let folder = path.is_dir().then(|| path.to_owned());
        let file = folder.as_deref().map(|folder| folder.join("manifest.txt"));
        let text = shell().read_file(file.as_deref().unwrap_or(path))?;
        let mut entries = BTreeMap::new();
        for line in text.lines().filter(|line| !line.starts_with('#')) {
            let words: Vec<String> = line.splitn(4, ' ').map(str::to_owned).collect();
            let Ok([values, sentences, exit, name]) = <[String; 4]>::try_from(words) else {
                bail!("{}: no line of a manifest: {line}", path.display());
            };
            entries.insert(name, [values, sentences, exit]);
        }
        Ok(Self { folder, entries })
    }

    /// Writes it as text.
    pub fn write(&self, path: &Path) -> Result<()> {
        let lines =
            self.entries.iter().map(|(name, entry)| format!("{} {name}\n", entry.join(" ")));
        let lines: String = lines.collect();
        Ok(shell().write_file(path, format!("{HEADER}\n{lines}"))?)
    }
}

fn sha256(text: &str) -> String {
    let digest = Sha256::digest(text.as_bytes());
    digest.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// Prints what differs. `true`: every document has the same values and exit code.
///
/// A document that only `before` has counts where `all` were made.
pub fn compare(before: &Manifest, now: &Manifest, documents: &[Document], all: bool) -> bool {
    let mut differing = Vec::new();
    let mut reworded = 0;
    for document in documents {
        let name = &document.name;
        let [values, sentences, exit] = &now.entries[name];
        match before.entries.get(name) {
            None => differing.push(format!("{name}: was not made before")),
            Some([.., old]) if old != exit => {
                differing.push(format!("{name}: exit {old} -> {exit}"))
            }
            Some([old, ..]) if old != values => {
                differing.push(format!("{name}{}", detail(before, document)));
            }
            Some([_, old, _]) => reworded += usize::from(old != sentences),
        }
    }
    let gone = before.entries.keys().filter(|name| all && !now.entries.contains_key(*name));
    differing.extend(gone.map(|name| format!("{name}: is not made any more")));
    differing.iter().for_each(|difference| println!("DIFFERS {difference}"));
    println!(
        "{} documents differ; {reworded} others differ only in sentences for people",
        differing.len()
    );
    differing.is_empty()
}

/// The first field that differs, where the other document is at hand.
fn detail(before: &Manifest, document: &Document) -> String {
    let Some(folder) = &before.folder else {
        return String::new();
    };
    let path = folder.join(format!("{}.json", document.name));
    let old = shell().read_file(&path).ok();
    match old.and_then(|text| serde_json::from_str(&text).ok()) {
        Some(old) => {
            first_difference(&split_sentences(&old).0, &split_sentences(&document.value).0)
                .unwrap_or_default()
        }
        None => format!(": {} cannot be read", path.display()),
    }
}
