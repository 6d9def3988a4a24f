//! Paths that a module writes.

use std::collections::BTreeMap;

use proc_macro2::TokenStream;
use syn::spanned::Spanned;
use syn::visit::{self, Visit};
use syn::{Item, ItemUse, Macro, MetaList, Path, UseTree};

use super::source::{attributes, is_test, line};

/// Names between `::`.
pub type Name = Vec<String>;

/// What the items of a module name.
#[derive(Default)]
pub struct Module {
    /// Every name that `use` brings into it, and what that stands for.
    pub imports: BTreeMap<String, Name>,
    /// Every path, those of `use` as well, with its line.
    pub paths: Vec<(usize, Name)>,
}

impl Module {
    /// Adds the names of a `use` tree behind a path.
    fn import(&mut self, line: usize, before: &[String], tree: &UseTree) {
        let with = |name: &proc_macro2::Ident| [before, &[name.to_string()]].concat();
        let (name, mut path) = match tree {
            UseTree::Path(tree) => return self.import(line, &with(&tree.ident), &tree.tree),
            UseTree::Group(group) => {
                return (group.items.iter()).for_each(|tree| self.import(line, before, tree));
            }
            UseTree::Glob(_) => ("*".to_owned(), before.to_vec()),
            UseTree::Name(tree) => (tree.ident.to_string(), with(&tree.ident)),
            UseTree::Rename(tree) => (tree.rename.to_string(), with(&tree.ident)),
        };
        // `use a::{self as b}`: the name of `self` is that of the module.
        path.pop_if(|name| name == "self");
        let name = path.last().filter(|_| name == "self").cloned().unwrap_or(name);
        self.paths.push((line, path.clone()));
        self.imports.insert(name, path);
    }

    /// Adds paths in what is not parsed.
    fn add_tokens(&mut self, tokens: &TokenStream) {
        let text = tokens.to_string().replace(" :: ", "::");
        let is_of_path = |c: char| c.is_alphanumeric() || c == '_' || c == ':';
        for path in text.split(|c| !is_of_path(c)).filter(|path| path.contains("::")) {
            let names = path.trim_matches(':').split("::").map(String::from);
            self.paths.push((line(tokens.span()), names.collect()));
        }
    }
}

impl Visit<'_> for Module {
    fn visit_item(&mut self, item: &Item) {
        if !is_test(attributes(item)) {
            visit::visit_item(self, item);
        }
    }

    fn visit_item_use(&mut self, item: &ItemUse) {
        self.import(line(item.span()), &[], &item.tree);
    }

    fn visit_path(&mut self, path: &Path) {
        if path.leading_colon.is_none() && path.segments.len() > 1 {
            let names = path.segments.iter().map(|segment| segment.ident.to_string());
            self.paths.push((line(path.span()), names.collect()));
        }
        visit::visit_path(self, path);
    }

    fn visit_macro(&mut self, called: &Macro) {
        self.add_tokens(&called.tokens);
    }

    fn visit_meta_list(&mut self, list: &MetaList) {
        self.add_tokens(&list.tokens);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_every_name_of_a_use_tree() {
        let code = "pub use crate::{a::{self, B as C}, d::*}; fn f() { x::y::<Z>(e); g!(h::i(j)) }";
        let mut module = Module::default();
        syn::parse_file(code).unwrap().items.iter().for_each(|item| module.visit_item(item));
        let found: Vec<_> =
            module.imports.iter().map(|(name, path)| (name.as_str(), path.join("::"))).collect();
        let expected = [("*", "crate::d"), ("C", "crate::a::B"), ("a", "crate::a")];
        assert_eq!(found, expected.map(|(name, path)| (name, path.to_owned())));
        let paths: Vec<_> = module.paths.iter().map(|p| p.1.join("::")).collect();
        assert_eq!(paths, ["crate::a", "crate::a::B", "crate::d", "x::y", "h::i"]);
    }
}
