//! Paths that a module writes.

use std::collections::BTreeSet;

use proc_macro2::{Delimiter, TokenTree};

use super::source::{for_each_level, inside, is_mark, line, word};

/// A name that `use` brings into a module.
pub struct Import {
    /// The line of its `use`.
    pub line: usize,
    /// The name, `*` for all that is there.
    pub name: String,
    /// What it stands for.
    pub path: Vec<String>,
}

/// Names of what a module defines itself, and, which does no harm, of what its items hold.
pub fn items(code: &[TokenTree]) -> BTreeSet<String> {
    const KEYWORDS: [&str; 8] = [
        "fn", "struct", "enum", "trait", "type", "const", "static", "union",
    ];
    let mut names = BTreeSet::new();
    for_each_level(code, &mut |level| {
        for pair in level.windows(2) {
            if let (Some(keyword), Some(name)) = (word(&pair[0]), word(&pair[1]))
                && KEYWORDS.contains(&keyword.as_str())
            {
                names.insert(name);
            }
        }
    });
    names
}

/// Every `use` of a module's code, and every path of at least two segments in the rest with its line.
pub fn imports_and_paths(code: &[TokenTree]) -> (Vec<Import>, Vec<(usize, Vec<String>)>) {
    let (mut imports, mut paths) = (Vec::new(), Vec::new());
    for_each_level(code, &mut |level| {
        let mut at = 0;
        while at < level.len() {
            let rest = &level[at..];
            let is_use = word(&rest[0]).is_some_and(|word| word == "use");
            let end = rest.iter().position(|token| is_mark(token, ';'));
            // `impl Trait + use<'a>` is no import.
            let is_import = is_use && rest.get(1).is_some_and(|next| !is_mark(next, '<'));
            if let Some(end) = end.filter(|_| is_import) {
                imports.extend(branches(line(&rest[0]), &[], &rest[1..end]));
                at += end;
                continue;
            }
            let (path, length) = path(rest);
            let is_absolute = at > 0 && is_mark(&level[at - 1], ':') && length > 0;
            if path.len() > 1 && !is_absolute {
                paths.push((line(&rest[0]), path));
            }
            at += length.max(1);
        }
    });
    (imports, paths)
}

/// The names between `::` at the beginning, and how many tokens they take.
fn path(tokens: &[TokenTree]) -> (Vec<String>, usize) {
    let mut names = Vec::new();
    let mut length = 0;
    while let Some(name) = tokens.get(length).and_then(word) {
        names.push(name);
        length += 1;
        match &tokens[length..] {
            [a, b, ..] if is_mark(a, ':') && is_mark(b, ':') => length += 2,
            _ => break,
        }
    }
    (names, length)
}

/// The names of a `use` tree behind a path.
fn branches(line: usize, before: &[String], tree: &[TokenTree]) -> Vec<Import> {
    let start = tree.iter().position(|token| !is_mark(token, ':'));
    let tree = &tree[start.unwrap_or(tree.len())..];
    let (own, length) = path(tree);
    let mut path = [before, &own].concat();
    let last = tree.get(length);
    if let Some(group) = last.and_then(|token| inside(token, Delimiter::Brace)) {
        return group
            .split(|token| is_mark(token, ','))
            .filter(|branch| !branch.is_empty())
            .flat_map(|branch| branches(line, &path, branch))
            .collect();
    }
    // `use a::{self as b}`: the name of `self` is that of the module.
    if path.len() > 1 && path.last().is_some_and(|name| name == "self") {
        path.pop();
    }
    let alias = tree
        .iter()
        .skip_while(|t| word(t).is_none_or(|word| word != "as"));
    let name = match last {
        Some(star) if is_mark(star, '*') => Some("*".to_owned()),
        Some(_) => alias.skip(1).find_map(word),
        None => path.last().cloned(),
    };
    name.map(|name| Import { line, name, path })
        .into_iter()
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_every_name_of_a_use_tree() {
        let code = "pub use crate::{a::{self, B as C}, d::*}; fn f() { x::y::<Z>(e) }";
        let code: Vec<TokenTree> = code
            .parse::<proc_macro2::TokenStream>()
            .unwrap()
            .into_iter()
            .collect();
        let (imports, paths) = imports_and_paths(&code);
        let found: Vec<_> = imports
            .iter()
            .map(|i| (i.name.as_str(), i.path.join("::")))
            .collect();
        let expected = [("a", "crate::a"), ("C", "crate::a::B"), ("*", "crate::d")];
        assert_eq!(found, expected.map(|(name, path)| (name, path.to_owned())));
        let paths: Vec<_> = paths.into_iter().map(|p| p.1.join("::")).collect();
        assert_eq!(paths, ["x::y"]);
    }
}
