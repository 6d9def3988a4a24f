//! Paths that a module writes.

use std::collections::BTreeSet;

use super::source::{following_name, words};

/// A name that `use` brings into a module.
pub struct Import {
    /// Where its `use` is.
    pub at: usize,
    /// The name, `*` for all that is there.
    pub name: String,
    /// What it stands for.
    pub path: Vec<String>,
}

/// Names of what a module defines itself, and, which does no harm, of what its items hold.
pub fn items(code: &str) -> BTreeSet<String> {
    const KEYWORDS: [&str; 9] = [
        "fn",
        "struct",
        "enum",
        "trait",
        "type",
        "const",
        "static",
        "union",
        "macro_rules",
    ];
    words(code)
        .filter(|(_, word)| KEYWORDS.contains(word))
        .filter_map(|(at, word)| following_name(code, at + word.len()))
        .map(str::to_owned)
        .collect()
}

/// Takes every `use` out of a module's code, which keeps its length.
pub fn take_imports(code: &mut String) -> Vec<Import> {
    let starts: Vec<usize> = words(code)
        .filter(|(_, word)| *word == "use")
        .map(|(at, _)| at)
        .collect();
    let mut imports = Vec::new();
    for at in starts {
        let Some(length) = code[at..].find(';') else {
            continue;
        };
        let tree = code[at + "use".len()..at + length].to_owned();
        // `impl Trait + use<'a>` is no import.
        if tree.trim_start().starts_with('<') {
            continue;
        }
        imports.extend(branches(at, &[], tree.trim()));
        code.replace_range(at..at + length, &" ".repeat(length));
    }
    imports
}

/// The names of a `use` tree behind a path.
fn branches(at: usize, before: &[String], tree: &str) -> Vec<Import> {
    if let Some((head, group)) = tree.split_once('{') {
        let group = group.trim_end().strip_suffix('}').unwrap_or(group);
        let path = [before, &segments(head)].concat();
        return split_group(group)
            .into_iter()
            .flat_map(|branch| branches(at, &path, branch))
            .collect();
    }
    let (tree, alias) = match tree.split_once(" as ") {
        Some((tree, alias)) => (tree, Some(alias.trim())),
        None => (tree, None),
    };
    let mut path = [before, &segments(tree)].concat();
    let last = path.last().cloned().unwrap_or_default();
    if (last == "*" || last == "self") && path.len() > 1 {
        path.pop();
    }
    let own = match last.as_str() {
        "self" => path.last().cloned().unwrap_or_default(),
        _ => last,
    };
    let name = alias.map_or(own, str::to_owned);
    match path.is_empty() {
        true => Vec::new(),
        false => vec![Import { at, name, path }],
    }
}

fn segments(path: &str) -> Vec<String> {
    path.split("::")
        .map(str::trim)
        .filter(|segment| !segment.is_empty())
        .map(str::to_owned)
        .collect()
}

/// Parts of a group between commas of its own level.
fn split_group(group: &str) -> Vec<&str> {
    let mut parts = Vec::new();
    let (mut depth, mut start) = (0, 0);
    for (at, character) in group.char_indices() {
        match character {
            '{' => depth += 1,
            '}' => depth -= 1,
            ',' if depth == 0 => {
                parts.push(group[start..at].trim());
                start = at + 1;
            }
            _ => {}
        }
    }
    parts.push(group[start..].trim());
    parts.retain(|part| !part.is_empty());
    parts
}

/// Paths of at least two segments in code without its `use` items, with where they begin.
pub fn in_code(code: &str) -> Vec<(usize, Vec<String>)> {
    let mut found: Vec<(usize, Vec<String>)> = Vec::new();
    let mut end = None;
    for (at, word) in words(code) {
        let continues = end.is_some_and(|end: usize| code[end..at].trim() == "::");
        match found.last_mut() {
            Some((_, path)) if continues => path.push(word.to_owned()),
            _ => found.push((at, vec![word.to_owned()])),
        }
        end = Some(at + word.len());
    }
    found.retain(|(at, path)| path.len() > 1 && !code[..*at].ends_with("::"));
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_every_name_of_a_use_tree() {
        let mut code =
            "pub use crate::{a::{self, B as C}, d::*}; fn f() { x::y::<Z>(e) }".to_owned();
        let imports = take_imports(&mut code);
        let found: Vec<_> = imports
            .iter()
            .map(|i| (i.name.as_str(), i.path.join("::")))
            .collect();
        let expected = [("a", "crate::a"), ("C", "crate::a::B"), ("*", "crate::d")];
        assert_eq!(found, expected.map(|(name, path)| (name, path.to_owned())));
        let paths: Vec<_> = in_code(&code).into_iter().map(|p| p.1.join("::")).collect();
        assert_eq!(paths, ["x::y"]);
    }
}
