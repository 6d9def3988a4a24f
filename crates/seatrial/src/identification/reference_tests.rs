//! The page of the verdicts is made of the code.

use std::fmt::Write;
use std::path::Path;

use super::code::{Reader, ReasonCode, WORDS};

/// Every code with what its documentation says, in the order of the code.
fn documented() -> Vec<(ReasonCode, String)> {
    let source = include_str!("code.rs");
    let body = source.split("pub enum ReasonCode {").nth(1).unwrap();
    let body = body.split("/// A code that this version").next().unwrap();
    let mut lines = body.lines().map(str::trim).filter(|line| !line.is_empty());
    let mut found = Vec::new();
    while let Some(says) = lines.next() {
        let says = says.strip_prefix("/// ").unwrap();
        let variant = lines.next().unwrap().trim_end_matches(',');
        let mut name = String::new();
        for letter in variant.chars() {
            if letter.is_uppercase() && !name.is_empty() {
                name.push('_');
            }
            name.extend(letter.to_lowercase());
        }
        let code: ReasonCode = serde_json::from_value(name.clone().into()).unwrap();
        assert!(!matches!(code, ReasonCode::Other(_)), "{name}");
        found.push((code, says.to_owned()));
    }
    found
}

fn page() -> String {
    let mut page = "# Verdicts\n\nEvery code of a verdict, and of what, with its cause and its cure. The most important reason decides the outcome; the others are remarks. Where\nno cure stands here, the reason itself names one. [The file of channels](channels.md) says how a column is scaled or turned.\n"
        .to_owned();
    for (code, says) in documented() {
        let mut worded = WORDS.iter().filter(|words| words.kind.code == code).peekable();
        if worded.peek().is_none() {
            let _ = writeln!(page, "\n## {code}\n\n{says}");
        }
        for words in worded {
            let cure = words.action(Reader::Terminal);
            let _ = writeln!(page, "\n## {}\n\n{}\n\n**Cure:** {cure}", words.kind, words.cause);
        }
    }
    page
}

/// `UPDATE_DOCS=1` writes the page anew.
#[test]
fn io_the_page_of_verdicts_is_what_the_code_says() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/reference/verdicts.md");
    let page = page();
    if std::env::var_os("UPDATE_DOCS").is_some() {
        std::fs::write(&path, &page).unwrap();
    }
    let kept = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(
        kept == page,
        "docs/reference/verdicts.md is not what the code says; write it anew with UPDATE_DOCS=1"
    );
}
