//! What the checks need to know of a Rust file: its code, without that of tests. What macros hold is not looked at.

use std::path::Path;

use anyhow::{Context, Result};
use proc_macro2::Span;
use syn::spanned::Spanned;
use syn::visit::{self, Visit};
use syn::{Attribute, Block, Field, File, GenericArgument, ImplItemFn, Item, ItemEnum, Meta};
use syn::{PathArguments, PathSegment, Signature, TraitItemFn, Type, Variant};

use crate::shell::shell;

/// A file and what is in it.
#[derive(Default)]
pub struct Source {
    /// The text as it is in the file.
    pub text: String,
    /// Its items that are no test.
    pub items: Vec<Item>,
    /// Lines that belong to no test.
    pub production_lines: usize,
    /// Of these, lines of examples in docs, which run as tests.
    pub example_lines: usize,
    /// Every function that has a body.
    pub functions: Vec<Function>,
    /// The lines that write a `Result` whose error is a `String`.
    pub string_errors: Vec<usize>,
    /// Constants that are numbers or lists of numbers.
    pub constants: usize,
    /// Variants of `ReasonCode`.
    pub reason_codes: usize,
    /// Variants of enums that derive `Subcommand` but for old spellings, which help does not show.
    pub verbs: usize,
    /// Options with a long name.
    pub options: usize,
}

/// Lines of blocks of Rust in the docs of a file.
fn example_lines(text: &str) -> usize {
    let mut is_rust = None;
    let in_docs = text.lines().map(str::trim_start).filter(|line| line.starts_with("//"));
    let in_examples = in_docs.filter(|line| {
        let fence = line.trim_start_matches(['/', '!', ' ']).strip_prefix("```");
        match (fence, is_rust) {
            (Some(_), Some(was_rust)) => {
                is_rust = None;
                was_rust
            }
            (Some(language), None) => *is_rust.insert(["", "rust"].contains(&language)),
            (None, _) => is_rust == Some(true),
        }
    });
    in_examples.count()
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

    /// Looks through a file's text.
    pub fn new(text: String) -> Result<Self> {
        let File { mut items, .. } = syn::parse_file(&text)?;
        let mut source = Self {
            production_lines: text.lines().count(),
            example_lines: example_lines(&text),
            text,
            ..Self::default()
        };
        items.iter().for_each(|item| source.visit_item(item));
        items.retain(|item| !is_test(attributes(item)));
        Ok(Self { items, ..source })
    }

    fn leave_out(&mut self, test: &impl Spanned) {
        let span = test.span();
        self.production_lines -= span.end().line + 1 - line(span);
    }

    fn add_function(&mut self, signature: &Signature, body: &Block) {
        let line = line(signature.fn_token.span);
        self.functions.push(Function {
            name: signature.ident.to_string(),
            line,
            lines: body.span().end().line + 1 - line,
        });
    }
}

impl Visit<'_> for Source {
    fn visit_item(&mut self, item: &Item) {
        match item {
            item if is_test(attributes(item)) => return self.leave_out(item),
            Item::Fn(function) => self.add_function(&function.sig, &function.block),
            Item::Const(constant) if is_number(&constant.ty) => self.constants += 1,
            _ => {}
        }
        visit::visit_item(self, item);
    }

    fn visit_impl_item_fn(&mut self, function: &ImplItemFn) {
        if is_test(&function.attrs) {
            return self.leave_out(function);
        }
        self.add_function(&function.sig, &function.block);
        visit::visit_impl_item_fn(self, function);
    }

    fn visit_trait_item_fn(&mut self, function: &TraitItemFn) {
        if let Some(body) = &function.default {
            self.add_function(&function.sig, body);
        }
        visit::visit_trait_item_fn(self, function);
    }

    fn visit_impl_item_const(&mut self, constant: &syn::ImplItemConst) {
        self.constants += usize::from(is_number(&constant.ty));
    }

    fn visit_path_segment(&mut self, segment: &PathSegment) {
        if segment.ident == "Result"
            && let PathArguments::AngleBracketed(arguments) = &segment.arguments
            && let Some(GenericArgument::Type(Type::Path(error))) = arguments.args.get(1)
            && error.path.is_ident("String")
        {
            self.string_errors.push(line(segment.ident.span()));
        }
        visit::visit_path_segment(self, segment);
    }

    fn visit_item_enum(&mut self, item: &ItemEnum) {
        let is_shown = |variant: &&Variant| !holds(&variant.attrs, "command", "hide");
        let shown = item.variants.iter().filter(is_shown).count();
        if item.ident == "ReasonCode" {
            self.reason_codes += shown;
        }
        if holds(&item.attrs, "derive", "Subcommand") {
            self.verbs += shown;
        }
        visit::visit_item_enum(self, item);
    }

    fn visit_field(&mut self, field: &Field) {
        self.options += usize::from(holds(&field.attrs, "arg", "long"));
        visit::visit_field(self, field);
    }
}

/// The line on which something begins, counted from 1.
pub fn line(span: Span) -> usize {
    span.start().line
}

/// `#[test]`, `#[cfg(test)]`, `#[cfg(all(test, ...))]`.
pub fn is_test(attributes: &[Attribute]) -> bool {
    let is_all_of_test = |list: &syn::MetaList| {
        let tokens = list.tokens.to_string().replace(' ', "");
        list.path.is_ident("cfg") && tokens.starts_with("all(test,")
    };
    holds(attributes, "cfg", "test")
        || attributes.iter().any(|attribute| match &attribute.meta {
            Meta::Path(path) => path.is_ident("test"),
            Meta::List(list) => is_all_of_test(list),
            Meta::NameValue(_) => false,
        })
}

/// Is one of the attributes `name(...)` with this word in it?
fn holds(attributes: &[Attribute], name: &str, word: &str) -> bool {
    let lists = attributes.iter().filter_map(|attribute| attribute.meta.require_list().ok());
    let mut words =
        lists.filter(|list| list.path.is_ident(name)).flat_map(|list| list.tokens.clone());
    words.any(|token| token.to_string() == word)
}

/// A number, or a list of numbers.
fn is_number(kind: &Type) -> bool {
    const NUMBERS: &str = "f64 f32 usize u64 u32 u16 u8 i64 i32 i16";
    match kind {
        Type::Array(array) => is_number(&array.elem),
        Type::Path(path) => NUMBERS.split(' ').any(|number| path.path.is_ident(number)),
        _ => false,
    }
}

/// The attributes of an item.
pub fn attributes(item: &Item) -> &[Attribute] {
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
        let functions = source.functions;
        let found: Vec<_> = functions.iter().map(|f| (f.name.as_str(), f.line, f.lines)).collect();
        assert_eq!(found, [("first", 3, 4), ("last", 10, 1)]);
        assert_eq!(source.string_errors, [3]);
        assert_eq!(source.production_lines, TEXT.lines().count() - 8);
    }
}
