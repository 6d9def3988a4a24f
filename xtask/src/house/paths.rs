//! Paths that a module writes.

use std::collections::BTreeSet;

use syn::spanned::Spanned;
use syn::visit::{self, Visit};
use syn::{Item, UseTree};

use super::source::{attributes, is_test, line};

/// Names between `::`.
pub type Name = Vec<String>;

/// A name that `use` brings into a module.
pub struct Import {
    /// The name, `*` for all that is there.
    pub name: String,
    /// What it stands for.
    pub path: Name,
}

/// What the items of a module define and name.
#[derive(Default)]
pub struct Module {
    /// Names of its own items, and, which does no harm, of those in them.
    pub items: BTreeSet<String>,
    /// Every name of its `use`.
    pub imports: Vec<Import>,
    /// Every path, those of `use` as well, with its line.
    pub paths: Vec<(usize, Name)>,
}

impl Module {
    /// Adds the names of a `use` tree behind a path.
    fn import(&mut self, line: usize, before: &[String], tree: &UseTree) {
        let with = |name: &syn::Ident| [before, &[name.to_string()]].concat();
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
        let is_itself = path.len() > 1 && path.last().is_some_and(|name| name == "self");
        if is_itself {
            path.pop();
        }
        let name = match path.last() {
            Some(last) if name == "self" => last.clone(),
            _ => name,
        };
        self.paths.push((line, path.clone()));
        self.imports.push(Import { name, path });
    }

    /// Adds paths in what is not parsed.
    fn add_tokens(&mut self, tokens: &proc_macro2::TokenStream) {
        let text = tokens.to_string().replace(" :: ", "::");
        let is_of_path = |c: char| c.is_alphanumeric() || c == '_' || c == ':';
        for path in text
            .split(|c| !is_of_path(c))
            .filter(|path| path.contains("::"))
        {
            let names = path.trim_matches(':').split("::").map(String::from);
            self.paths.push((line(tokens.span()), names.collect()));
        }
    }
}

impl Visit<'_> for Module {
    fn visit_item(&mut self, item: &Item) {
        if is_test(attributes(item)) {
            return;
        }
        let name = match item {
            Item::Const(item) => Some(&item.ident),
            Item::Enum(item) => Some(&item.ident),
            Item::Fn(item) => Some(&item.sig.ident),
            Item::Static(item) => Some(&item.ident),
            Item::Struct(item) => Some(&item.ident),
            Item::Trait(item) => Some(&item.ident),
            Item::Type(item) => Some(&item.ident),
            Item::Union(item) => Some(&item.ident),
            _ => None,
        };
        self.items.extend(name.map(ToString::to_string));
        visit::visit_item(self, item);
    }

    fn visit_item_use(&mut self, item: &syn::ItemUse) {
        self.import(line(item.span()), &[], &item.tree);
    }

    fn visit_path(&mut self, path: &syn::Path) {
        if path.leading_colon.is_none() && path.segments.len() > 1 {
            let names = path
                .segments
                .iter()
                .map(|segment| segment.ident.to_string());
            self.paths.push((line(path.span()), names.collect()));
        }
        visit::visit_path(self, path);
    }

    fn visit_macro(&mut self, called: &syn::Macro) {
        self.add_tokens(&called.tokens);
    }

    fn visit_meta_list(&mut self, list: &syn::MetaList) {
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
        syn::parse_file(code)
            .unwrap()
            .items
            .iter()
            .for_each(|item| module.visit_item(item));
        let found: Vec<_> = module
            .imports
            .iter()
            .map(|i| (i.name.as_str(), i.path.join("::")))
            .collect();
        let expected = [("a", "crate::a"), ("C", "crate::a::B"), ("*", "crate::d")];
        assert_eq!(found, expected.map(|(name, path)| (name, path.to_owned())));
        let paths: Vec<_> = module.paths.iter().map(|p| p.1.join("::")).collect();
        assert_eq!(
            paths,
            ["crate::a", "crate::a::B", "crate::d", "x::y", "h::i"]
        );
        assert_eq!(module.items.iter().collect::<Vec<_>>(), ["f"]);
    }
}
