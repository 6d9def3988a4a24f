//! Circles between the modules of a crate.
//!
//! A module's edge goes to the module that defines what a path names: re-exports are followed. Modules with the same parent form a
//! graph, in which an edge between two modules counts for the children that hold them; where some reach each other, they are a circle.
//! What a parent and its descendants have of each other is not counted.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use proc_macro2::{Delimiter, TokenTree};

use super::paths::{self, Import};
use super::source::{Source, inside, is_mark, word};

/// Names from the crate's root to a module.
pub type Name = Vec<String>;

/// The modules of a library or a program.
pub struct Modules {
    files: Vec<(PathBuf, Source)>,
    modules: BTreeMap<Name, Module>,
}

struct Module {
    file: usize,
    imports: Vec<Import>,
    paths: Vec<(usize, Name)>,
    items: BTreeSet<String>,
}

/// One module that uses another.
struct Edge {
    from: Name,
    to: Name,
    place: String,
}

/// Modules that reach each other.
pub struct Circle {
    /// Their names, sorted, with that of their parent before a colon, as in `identify: edges, joined`.
    pub name: String,
    /// One place for each pair of them.
    pub places: Vec<String>,
}

impl Modules {
    /// Reads the tree of modules that begins in `root`, the file of a library or a program.
    pub fn read(root: &Path) -> Result<Self, String> {
        let mut found = Self {
            files: Vec::new(),
            modules: BTreeMap::new(),
        };
        let folder = root.parent().unwrap_or(root);
        found.read_file(root, folder, Vec::new())?;
        Ok(found)
    }

    /// The files that belong to the tree.
    pub fn files(&self) -> impl Iterator<Item = &(PathBuf, Source)> {
        self.files.iter()
    }

    fn read_file(&mut self, path: &Path, folder: &Path, name: Name) -> Result<(), String> {
        let text = std::fs::read_to_string(path)
            .map_err(|error| format!("{}: {error}", path.display()))?;
        let source = Source::new(text).map_err(|error| format!("{}: {error}", path.display()))?;
        let code = source.production.clone();
        self.files.push((path.to_owned(), source));
        self.add(self.files.len() - 1, &code, folder, name)
    }

    /// Adds a module with its submodules, whose code is no part of its own. `folder` is where the files of submodules are.
    fn add(
        &mut self,
        file: usize,
        code: &[TokenTree],
        folder: &Path,
        name: Name,
    ) -> Result<(), String> {
        let mut own = Vec::new();
        let mut at = 0;
        while at < code.len() {
            let Some((child, content)) = declaration(&code[at..]) else {
                own.push(code[at].clone());
                at += 1;
                continue;
            };
            let inner = folder.join(&child);
            let child_name = [&name[..], std::slice::from_ref(&child)].concat();
            match content {
                Some(content) => self.add(file, &content, &inner, child_name)?,
                None => {
                    let path = match path_attribute(&own) {
                        Some(given) => self.files[file].0.with_file_name(given),
                        None => file_of(folder, &child),
                    };
                    self.read_file(&path, &inner, child_name)?;
                }
            }
            at += DECLARATION;
        }
        let (imports, paths) = paths::imports_and_paths(&own);
        let module = Module {
            file,
            imports,
            paths,
            items: paths::items(&own),
        };
        self.modules.insert(name, module);
        Ok(())
    }

    /// Names of the modules at the top of the tree that have a file of their own.
    pub fn rooms(&self) -> impl Iterator<Item = &String> {
        let with_file = self.modules.iter().filter(|(_, module)| module.file > 0);
        with_file.filter_map(|(name, _)| match &name[..] {
            [room] => Some(room),
            _ => None,
        })
    }

    /// Every circle of the tree.
    pub fn circles(&self) -> Vec<Circle> {
        let edges = self.edges();
        let parents: BTreeSet<Name> = self
            .modules
            .keys()
            .filter(|name| !name.is_empty())
            .map(|name| name[..name.len() - 1].to_vec())
            .collect();
        parents
            .iter()
            .flat_map(|parent| circles_below(parent, &edges))
            .collect()
    }

    fn edges(&self) -> Vec<Edge> {
        let mut edges = Vec::new();
        for (from, module) in &self.modules {
            let imported = module.imports.iter().map(|i| (i.line, &i.path));
            let written = module.paths.iter().map(|(line, path)| (*line, path));
            for (line, path) in imported.chain(written) {
                let Some(to) = self.resolve(from, path, 0) else {
                    continue;
                };
                let place = format!("{}:{line}", self.files[module.file].0.display());
                edges.push(Edge {
                    from: from.clone(),
                    to,
                    place,
                });
            }
        }
        edges
    }

    /// The module that defines what `path`, written in `from`, names.
    fn resolve(&self, from: &Name, path: &[String], depth: usize) -> Option<Name> {
        let (first, rest) = path.split_first()?;
        let child = [&from[..], std::slice::from_ref(first)].concat();
        match first.as_str() {
            "crate" => Some(self.descend(Vec::new(), rest, depth)),
            "self" => Some(self.descend(from.clone(), rest, depth)),
            "super" => {
                let mut up = from.clone();
                up.pop()?;
                let above = rest.iter().take_while(|name| *name == "super").count();
                up.truncate(up.len().checked_sub(above)?);
                Some(self.descend(up, &rest[above..], depth))
            }
            _ if self.modules.contains_key(&child) => Some(self.descend(child, rest, depth)),
            _ => {
                let module = &self.modules[from];
                let import = module.imports.iter().find(|import| import.name == *first)?;
                let is_itself = import.path == path;
                let path = [&import.path[..], rest].concat();
                (depth < 16 && !is_itself)
                    .then(|| self.resolve(from, &path, depth + 1))
                    .flatten()
            }
        }
    }

    fn descend(&self, mut at: Name, path: &[String], depth: usize) -> Name {
        for (index, segment) in path.iter().enumerate() {
            let child = [&at[..], std::slice::from_ref(segment)].concat();
            if self.modules.contains_key(&child) {
                at = child;
                continue;
            }
            let module = &self.modules[&at];
            if module.items.contains(segment) || depth > 16 {
                break;
            }
            let named = module.imports.iter().find(|i| i.name == *segment);
            let rest = &path[index..];
            let found = match named {
                Some(import) => {
                    let path = [&import.path[..], &rest[1..]].concat();
                    self.resolve(&at, &path, depth + 1)
                }
                None => self.through_globs(&at, rest, depth),
            };
            return found.unwrap_or(at);
        }
        at
    }

    /// Where a module's `use x::*` bring a name from.
    fn through_globs(&self, at: &Name, path: &[String], depth: usize) -> Option<Name> {
        let globs = self.modules[at].imports.iter().filter(|i| i.name == "*");
        globs
            .filter_map(|import| self.resolve(at, &import.path, depth + 1))
            .find(|target| {
                let target = &self.modules[target];
                let is_named = |import: &Import| import.name == path[0];
                target.items.contains(&path[0]) || target.imports.iter().any(is_named)
            })
            .map(|target| self.descend(target, path, depth + 1))
    }
}

/// Tokens of `mod name;` and of `mod name { ... }`.
const DECLARATION: usize = 3;

/// The name of the module that the tokens begin with, and its content where it has no file of its own.
fn declaration(code: &[TokenTree]) -> Option<(String, Option<Vec<TokenTree>>)> {
    let [keyword, name, end, ..] = code else {
        return None;
    };
    let content = inside(end, Delimiter::Brace);
    let is_module = word(keyword)? == "mod" && (content.is_some() || is_mark(end, ';'));
    is_module.then_some((word(name)?, content))
}

fn file_of(folder: &Path, module: &str) -> PathBuf {
    let flat = folder.join(format!("{module}.rs"));
    match flat.exists() {
        true => flat,
        false => folder.join(module).join("mod.rs"),
    }
}

/// The file that a `#[path = "..."]` names right before a module.
fn path_attribute(before: &[TokenTree]) -> Option<String> {
    let visible = before.iter().rev().skip_while(|token| {
        word(token).is_some_and(|word| word == "pub")
            || inside(token, Delimiter::Parenthesis).is_some()
    });
    let attribute = inside(visible.into_iter().next()?, Delimiter::Bracket)?;
    let path = attribute
        .get(2)
        .filter(|_| word(&attribute[0]).is_some_and(|w| w == "path"))?;
    Some(path.to_string().trim_matches('"').to_owned())
}

/// Circles among the children of a module.
fn circles_below(parent: &Name, edges: &[Edge]) -> Vec<Circle> {
    let child = |name: &Name| {
        let is_below = name.len() > parent.len() && name.starts_with(parent);
        is_below.then(|| name[parent.len()].clone())
    };
    let mut arrows: BTreeMap<String, BTreeMap<String, &str>> = BTreeMap::new();
    for edge in edges {
        if let (Some(from), Some(to)) = (child(&edge.from), child(&edge.to))
            && from != to
        {
            let targets = arrows.entry(from).or_default();
            targets.entry(to).or_insert(&edge.place);
        }
    }
    let reached: BTreeMap<&String, BTreeSet<&String>> = arrows
        .keys()
        .map(|from| (from, reachable(from, &arrows)))
        .collect();
    let mut circles: BTreeSet<Vec<&String>> = BTreeSet::new();
    for (from, targets) in &reached {
        if targets.contains(from) {
            let is_mutual = |to: &&&String| reached.get(**to).is_some_and(|r| r.contains(from));
            circles.insert(targets.iter().filter(is_mutual).copied().collect());
        }
    }
    circles
        .into_iter()
        .map(|members| circle(parent, &members, &arrows))
        .collect()
}

fn reachable<'a>(
    from: &str,
    arrows: &'a BTreeMap<String, BTreeMap<String, &str>>,
) -> BTreeSet<&'a String> {
    let mut reached = BTreeSet::new();
    let mut open = vec![from];
    while let Some(at) = open.pop() {
        for target in arrows.get(at).into_iter().flat_map(BTreeMap::keys) {
            if reached.insert(target) {
                open.push(target);
            }
        }
    }
    reached
}

fn circle(
    parent: &Name,
    members: &[&String],
    arrows: &BTreeMap<String, BTreeMap<String, &str>>,
) -> Circle {
    let mut places = Vec::new();
    for from in members {
        for (to, place) in &arrows[*from] {
            if members.contains(&to) {
                places.push(format!("{from} -> {to} at {place}"));
            }
        }
    }
    let names: Vec<&str> = members.iter().map(|name| name.as_str()).collect();
    let prefix = match parent.is_empty() {
        true => String::new(),
        false => format!("{}: ", parent.join("::")),
    };
    Circle {
        name: format!("{prefix}{}", names.join(", ")),
        places,
    }
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
            (
                "a/mod.rs",
                "mod b; mod c; pub use b::Two; pub fn g() { c::h() }",
            ),
            (
                "a/b.rs",
                "pub struct Two; fn f() { super::c::h(); super::g() }",
            ),
            ("a/c.rs", "use super::*; pub fn h() -> super::Two {}"),
        ]);
        assert_eq!(found, ["a: b, c"]);
    }
}
