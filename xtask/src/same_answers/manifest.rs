//! Hashes of documents, one line each.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256};

use super::document::{Document, first_difference, split_sentences};

const HEADER: &str =
    "# SHA-256 of the values, the first 16 digits of that of the sentences, exit code, document";

/// What the documents of a binary hash to.
pub struct Manifest {
    /// Where the documents themselves are, if they are known.
    folder: Option<PathBuf>,
    entries: BTreeMap<String, Entry>,
}

#[derive(PartialEq, Eq)]
struct Entry {
    values: String,
    sentences: String,
    exit: String,
}

impl Manifest {
    /// The hashes of documents at hand.
    pub fn of(documents: &[Document]) -> Self {
        let entry = |document: &Document| {
            let (values, sentences) = split_sentences(&document.value);
            let entry = Entry {
                values: sha256(&values.to_string()),
                sentences: sha256(&sentences.join("\n"))[..16].to_owned(),
                exit: document.exit.to_string(),
            };
            (document.name.clone(), entry)
        };
        Self {
            folder: None,
            entries: documents.iter().map(entry).collect(),
        }
    }

    /// Reads a manifest, or the one in a folder of documents.
    pub fn read(path: &Path) -> Result<Self, String> {
        let folder = path.is_dir().then(|| path.to_owned());
        let path = match &folder {
            Some(folder) => folder.join("manifest.txt"),
            None => path.to_owned(),
        };
        let text = std::fs::read_to_string(&path)
            .map_err(|error| format!("{}: {error}", path.display()))?;
        let mut entries = BTreeMap::new();
        for line in text.lines().filter(|line| !line.starts_with('#')) {
            let mut words = line.splitn(4, ' ').map(str::to_owned);
            let (Some(values), Some(sentences), Some(exit), Some(name)) =
                (words.next(), words.next(), words.next(), words.next())
            else {
                return Err(format!("{}: no line of a manifest: {line}", path.display()));
            };
            let entry = Entry {
                values,
                sentences,
                exit,
            };
            entries.insert(name, entry);
        }
        Ok(Self { folder, entries })
    }

    /// Writes it as text.
    pub fn write(&self, path: &Path) -> Result<(), String> {
        let mut text = format!("{HEADER}\n");
        for (name, entry) in &self.entries {
            let Entry {
                values,
                sentences,
                exit,
            } = entry;
            text += &format!("{values} {sentences} {exit} {name}\n");
        }
        std::fs::write(path, text).map_err(|error| format!("{}: {error}", path.display()))
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
    let mut differing = 0;
    let mut reworded = 0;
    for document in documents {
        let name = &document.name;
        let entry = &now.entries[name];
        let Some(old) = before.entries.get(name) else {
            println!("DIFFERS {name}: was not made before");
            differing += 1;
            continue;
        };
        if old.exit != entry.exit {
            println!("DIFFERS {name}: exit {} -> {}", old.exit, entry.exit);
            differing += 1;
        } else if old.values != entry.values {
            println!("DIFFERS {name}{}", detail(before, document));
            differing += 1;
        } else if old.sentences != entry.sentences {
            reworded += 1;
        }
    }
    if all {
        let gone = |name: &&String| !now.entries.contains_key(*name);
        for name in before.entries.keys().filter(gone) {
            println!("DIFFERS {name}: is not made any more");
            differing += 1;
        }
    }
    println!("{differing} documents differ; {reworded} others differ only in sentences for people");
    differing == 0
}

/// The first field that differs, where the other document is at hand.
fn detail(before: &Manifest, document: &Document) -> String {
    let Some(folder) = &before.folder else {
        return String::new();
    };
    let path = folder.join(format!("{}.json", document.name));
    let old = std::fs::read(&path).ok();
    let Some(old) = old.and_then(|text| serde_json::from_slice(&text).ok()) else {
        return format!(": {} cannot be read", path.display());
    };
    let (old, _) = split_sentences(&old);
    let (new, _) = split_sentences(&document.value);
    first_difference(&old, &new).unwrap_or_default()
}
