//! Circles between the modules of a crate.
//!
//! A module's edge goes to the module that defines what a path names: re-exports are followed. Modules with the same parent form a
//! graph, in which an edge between two modules counts for the children that hold them; where some reach each other, they are a circle.
//! What a parent and its descendants have of each other is not counted.

use std::collections::{BTreeMap, BTreeSet};
use std::hash::RandomState;
use std::path::{Path, PathBuf};
use std::rc::Rc;

use anyhow::Result;
use petgraph::algo::tarjan_scc;
use petgraph::graphmap::DiGraphMap;
use syn::spanned::Spanned;
use syn::visit::Visit;
use syn::{Item, ItemMod};

use super::paths::{Module, Name};
use super::source::{Source, is_test};

/// The modules of a library or a program.
#[derive(Default)]
pub struct Modules {
    /// The files that belong to the tree.
    pub files: Vec<(PathBuf, Rc<Source>)>,
    /// Each with the number of its file, by the names from the crate's root to it.
    modules: BTreeMap<Name, (usize, Module)>,
}

/// One module, another that it uses, and where.
type Edge = (Name, Name, String);
/// More names than any path has, with those that its imports stand for.
const DEEPEST: usize = 32;

/// Modules that reach each other.
pub struct Circle {
    /// Their names, sorted, with that of their parent before a colon, as in `identify: edges, joined`.
    pub name: String,
    /// One place for each pair of them.
    pub places: Vec<String>,
}

impl Modules {
    /// Reads the tree of modules that begins in `root`, the file of a library or a program.
    pub fn read(root: &Path) -> Result<Self> {
        let mut found = Self::default();
        let folder = root.parent().unwrap_or(root);
        found.read_file(root, folder, Vec::new())?;
        Ok(found)
    }

    fn read_file(&mut self, path: &Path, folder: &Path, name: Name) -> Result<()> {
        let source = Rc::new(Source::read(path)?);
        self.files.push((path.to_owned(), Rc::clone(&source)));
        self.add(self.files.len() - 1, &source.items, folder, name)
    }

    /// Adds a module with its submodules, whose code is no part of its own. `folder` is where the files of submodules are.
    fn add(&mut self, file: usize, items: &[Item], folder: &Path, name: Name) -> Result<()> {
        let mut module = Module::default();
        for item in items {
            let Item::Mod(child) = item else {
                module.visit_item(item);
                continue;
            };
            if is_test(&child.attrs) {
                continue;
            }
            let ident = child.ident.to_string();
            let inner = folder.join(&ident);
            let child_name = below(&name, &ident);
            match &child.content {
                Some((_, items)) => self.add(file, items, &inner, child_name)?,
                None => {
                    let given =
                        path_attribute(child).map(|given| self.files[file].0.with_file_name(given));
                    let flat = given.unwrap_or_else(|| inner.with_extension("rs"));
                    let path = Some(flat).filter(|flat| flat.exists());
                    let path = path.unwrap_or_else(|| inner.join("mod.rs"));
                    self.read_file(&path, &inner, child_name)?;
                }
            }
        }
        self.modules.insert(name, (file, module));
        Ok(())
    }

    /// Names of the modules at the top of the tree that have a file of their own.
    pub fn rooms(&self) -> impl Iterator<Item = &String> {
        let with_file = self.modules.iter().filter(|(_, (file, _))| *file > 0);
        with_file.filter_map(|(name, _)| match &name[..] {
            [room] => Some(room),
            _ => None,
        })
    }

    /// Every circle of the tree.
    pub fn circles(&self) -> Vec<Circle> {
        let edges = self.edges();
        let parents = self.modules.keys().filter_map(|name| name.split_last());
        let parents: BTreeSet<&[String]> = parents.map(|(_, parent)| parent).collect();
        let circles = parents.iter().flat_map(|parent| circles_below(parent, &edges));
        circles.collect()
    }

    fn edges(&self) -> Vec<Edge> {
        let of_module = |(from, (file, module)): (&Name, &(usize, Module))| {
            let file = self.files[*file].0.display();
            let edges = module.paths.iter().filter_map(|(line, path)| {
                let place = format!("{file}:{line}");
                Some((from.clone(), self.resolve(from, path, 0)?, place))
            });
            edges.collect::<Vec<_>>()
        };
        self.modules.iter().flat_map(of_module).collect()
    }

    /// The module that defines what `path`, written in `from`, names; `None` where that is another crate.
    fn resolve(&self, from: &Name, path: &[String], depth: usize) -> Option<Name> {
        let (first, rest) = path.split_first()?;
        let child = below(from, first);
        let next = match first.as_str() {
            "crate" => Vec::new(),
            "self" => from.clone(),
            "super" => from.split_last()?.1.to_vec(),
            _ if self.modules.contains_key(&child) => child,
            _ => {
                let import = self.modules[from].1.imports.get(first)?;
                let through = [import, rest].concat();
                let leads_on = through != path && depth < DEEPEST;
                return leads_on.then(|| self.resolve(from, &through, depth + 1)).flatten();
            }
        };
        // What is neither a module nor imported there is defined there.
        Some(self.resolve(&next, rest, depth + 1).unwrap_or(next))
    }
}

fn below(parent: &[String], child: &str) -> Name {
    [parent, &[child.to_owned()]].concat()
}

/// The file that a `#[path = "..."]` names.
fn path_attribute(module: &ItemMod) -> Option<String> {
    let named =
        module.attrs.iter().filter_map(|attribute| attribute.meta.require_name_value().ok());
    let value =
        named.filter(|named| named.path.is_ident("path")).map(|named| named.value.span()).next();
    Some(value?.source_text()?.trim_matches('"').to_owned())
}

/// Circles among the children of a module.
fn circles_below(parent: &[String], edges: &[Edge]) -> Vec<Circle> {
    let child = |name: &Name| name.strip_prefix(parent)?.first().cloned();
    let arrows = edges
        .iter()
        .rev()
        .filter_map(|(from, to, place)| Some(((child(from)?, child(to)?), place)));
    let arrows: BTreeMap<_, _> = arrows.filter(|((from, to), _)| from != to).collect();
    let graph = DiGraphMap::<&str, (), RandomState>::from_edges(
        arrows.keys().map(|(from, to)| (from.as_str(), to.as_str())),
    );
    let circles = tarjan_scc(&graph).into_iter().filter(|members| members.len() > 1);
    let circles = circles.map(|mut members| {
        members.sort_unstable();
        let is_in = |name: &String| members.contains(&name.as_str());
        let among = arrows.iter().filter(|((from, to), _)| is_in(from) && is_in(to));
        let places =
            among.map(|((from, to), place)| format!("{from} uses {to} at {place}")).collect();
        let names = [parent.join("::"), members.join(", ")];
        let name = names.join(": ").trim_start_matches(": ").to_owned();
        Circle { name, places }
    });
    circles.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn circles(files: &[(&str, &str)]) -> Vec<String> {
        let folder = std::env::temp_dir().join(format!(
            "seatrial-house-{}-{:?}",
            std::process::id(),
            std::thread::current().id()
        ));
        for (name, text) in files {
            let path = folder.join(name);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, text).unwrap();
        }
        let modules = Modules::read(&folder.join("lib.rs")).unwrap();
        let found = modules.circles().into_iter().map(|c| c.name).collect();
        std::fs::remove_dir_all(folder).unwrap();
        found
    }

    #[test]
    fn exact_modules_that_use_each_other_are_a_circle() {
        let found = circles(&[
            ("lib.rs", "mod a; mod b; mod c; pub use a::One;"),
            ("a.rs", "use crate::b::Two; pub struct One;"),
            // Through the root, which re-exports it.
            ("b.rs", "use crate::{c, One}; pub struct Two;"),
            ("c.rs", "pub struct Three; #[cfg(test)] use crate::b::Two;"),
        ]);
        assert_eq!(found, ["a, b"]);
    }

    #[test]
    fn exact_a_parent_and_its_children_are_none_but_siblings_below_are() {
        let found = circles(&[
            ("lib.rs", "mod a; mod d { pub fn f() { crate::a::g() } }"),
            ("a/mod.rs", "mod b; mod c; pub use b::Two; pub fn g() { c::h() }"),
            ("a/b.rs", "pub struct Two; fn f() { super::c::h(); super::g() }"),
            ("a/c.rs", "use super::*; pub fn h() -> super::Two {}"),
        ]);
        assert_eq!(found, ["a: b, c"]);
    }
}
