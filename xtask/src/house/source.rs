//! What the checks need to know of a Rust file: its code, without that of tests.

use std::path::Path;

use anyhow::{Context, Result};
use proc_macro2::Span;
use syn::spanned::Spanned;
use syn::visit::{self, Visit};
use syn::visit_mut::{self, VisitMut};
use syn::{Attribute, Block, GenericArgument, Item, Meta, PathArguments, Signature};

use crate::shell::shell;

/// A file's text, and its code without comments and tests.
pub struct Source {
    /// The text as it is in the file.
    pub text: String,
    /// What is no test.
    pub code: syn::File,
    /// Lines that belong to no test.
    pub production_lines: usize,
}

/// A function with the lines from its `fn` to its closing brace.
pub struct Function {
    /// Its name.
    pub name: String,
    /// The line of its `fn`, counted from 1.
    pub line: usize,
    /// How many lines it takes.
    pub lines: usize,
}

impl Source {
    /// Reads a file; an error where it is no Rust.
    pub fn read(path: &Path) -> Result<Self> {
        Self::new(shell().read_file(path)?).with_context(|| path.display().to_string())
    }

    /// Splits a file's text.
    pub fn new(text: String) -> Result<Self> {
        let mut code = syn::parse_file(&text)?;
        let mut tests = TestLines(0);
        tests.visit_file_mut(&mut code);
        let production_lines = text.lines().count().saturating_sub(tests.0);
        Ok(Self {
            text,
            code,
            production_lines,
        })
    }

    /// Every function of production code that has a body.
    pub fn functions(&self) -> Vec<Function> {
        let mut functions = Functions(Vec::new());
        functions.visit_file(&self.code);
        functions.0
    }

    /// The lines of production code that write a `Result` whose error is a `String`.
    pub fn string_errors(&self) -> Vec<usize> {
        let mut lines = StringErrors(Vec::new());
        lines.visit_file(&self.code);
        lines.0
    }
}

/// The line on which something begins, counted from 1.
pub fn line(span: Span) -> usize {
    span.start().line
}

/// Removes what is a test, and counts its lines.
struct TestLines(usize);

impl TestLines {
    fn is_none(&mut self, attributes: &[Attribute], item: &impl Spanned) -> bool {
        let is_test = attributes.iter().any(is_of_test);
        if is_test {
            let span = item.span();
            self.0 += span.end().line + 1 - line(span);
        }
        !is_test
    }
}

impl VisitMut for TestLines {
    fn visit_file_mut(&mut self, file: &mut syn::File) {
        file.items
            .retain(|item| self.is_none(attributes(item), item));
        visit_mut::visit_file_mut(self, file);
    }

    fn visit_item_mod_mut(&mut self, module: &mut syn::ItemMod) {
        if let Some((_, items)) = &mut module.content {
            items.retain(|item| self.is_none(attributes(item), item));
        }
        visit_mut::visit_item_mod_mut(self, module);
    }

    fn visit_item_impl_mut(&mut self, item: &mut syn::ItemImpl) {
        item.items.retain(|item| match item {
            syn::ImplItem::Fn(function) => self.is_none(&function.attrs, function),
            _ => true,
        });
    }
}

/// `#[test]`, `#[cfg(test)]`, `#[cfg(all(test, ...))]`.
fn is_of_test(attribute: &Attribute) -> bool {
    match &attribute.meta {
        Meta::Path(path) => path.is_ident("test"),
        Meta::List(list) if list.path.is_ident("cfg") => {
            let tokens = list.tokens.to_string().replace(' ', "");
            tokens == "test" || tokens.starts_with("all(test,")
        }
        _ => false,
    }
}

fn attributes(item: &Item) -> &[Attribute] {
    match item {
        Item::Const(item) => &item.attrs,
        Item::Enum(item) => &item.attrs,
        Item::Fn(item) => &item.attrs,
        Item::Impl(item) => &item.attrs,
        Item::Macro(item) => &item.attrs,
        Item::Mod(item) => &item.attrs,
        Item::Static(item) => &item.attrs,
        Item::Struct(item) => &item.attrs,
        Item::Trait(item) => &item.attrs,
        Item::Type(item) => &item.attrs,
        Item::Use(item) => &item.attrs,
        _ => &[],
    }
}

struct Functions(Vec<Function>);

impl Functions {
    fn add(&mut self, signature: &Signature, body: &Block) {
        let line = line(signature.fn_token.span);
        self.0.push(Function {
            name: signature.ident.to_string(),
            line,
            lines: body.span().end().line + 1 - line,
        });
    }
}

impl Visit<'_> for Functions {
    fn visit_item_fn(&mut self, function: &syn::ItemFn) {
        self.add(&function.sig, &function.block);
        visit::visit_item_fn(self, function);
    }

    fn visit_impl_item_fn(&mut self, function: &syn::ImplItemFn) {
        self.add(&function.sig, &function.block);
        visit::visit_impl_item_fn(self, function);
    }

    fn visit_trait_item_fn(&mut self, function: &syn::TraitItemFn) {
        if let Some(body) = &function.default {
            self.add(&function.sig, body);
        }
        visit::visit_trait_item_fn(self, function);
    }
}

struct StringErrors(Vec<usize>);

impl Visit<'_> for StringErrors {
    fn visit_path_segment(&mut self, segment: &syn::PathSegment) {
        if segment.ident == "Result"
            && let PathArguments::AngleBracketed(arguments) = &segment.arguments
            && let Some(GenericArgument::Type(syn::Type::Path(error))) = arguments.args.get(1)
            && error.path.is_ident("String")
        {
            self.0.push(line(segment.ident.span()));
        }
        visit::visit_path_segment(self, segment);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = r##"
/// A `fn comment() {`
pub fn first<'a>(text: &'a str) -> Result<Vec<(u8, String)>, String> {
    let brace = '{'; let quote = '"'; let text = "} fn no() {"; let raw = r#"fn "raw" {"#;
    inner(|x| { x })
}
fn declared(x: fn(f64)) -> Result<String, Error>;
#[cfg(test)]
use a::{b, c};
fn last() {}
#[cfg(test)]
mod tests {
    #[test]
    fn in_a_test() -> Result<(), String> {
    }
}
"##;

    #[test]
    fn exact_functions_of_production_code_and_their_lines() {
        let source = Source::new(TEXT.to_owned()).unwrap();
        let functions = source.functions();
        let found: Vec<_> = functions
            .iter()
            .map(|f| (f.name.as_str(), f.line, f.lines))
            .collect();
        assert_eq!(found, [("first", 3, 4), ("last", 10, 1)]);
        assert_eq!(source.string_errors(), [3]);
        assert_eq!(source.production_lines, TEXT.lines().count() - 8);
    }
}
