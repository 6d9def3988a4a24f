//! Rules that one place owns: a second place that does the same is a second filter.
//!
//! A filter's gains go on by P <- P - K S K'. Whoever writes it subtracts a product from an element of a matrix (`p[i][j] - k[i] * s[j]`), from a number
//! that is itself a factor (`p - k * p`), or from a matrix, with a transpose in the product. Elimination and conditional covariances are written like
//! that, too: the page of the house names every file that may, and why.

use std::path::Path;

use quote::ToTokens;
use syn::spanned::Spanned;
use syn::visit::{self, Visit};
use syn::{BinOp, Expr, ExprBinary, File};

use super::source::{attributes, is_test, line};

/// How the row of the page begins that names the owners.
const RULE: &str = "| a product corrects a matrix |";
/// The crates whose code estimates.
const ESTIMATORS: [&str; 2] = ["seatrial-core", "seatrial"];

/// What a file of a crate does that only the owners on the page of the house may.
pub fn faults(package: &str, path: &Path, text: &str, plan: &str) -> Vec<String> {
    let owners = plan.lines().filter(|row| row.starts_with(RULE));
    let mut named = owners.flat_map(|row| row.split('`').skip(1).step_by(2));
    if !ESTIMATORS.contains(&package) || named.any(|owner| path.ends_with(owner)) {
        return Vec::new();
    }
    corrections(text)
        .into_iter()
        .map(|line| format!("owner {package}: corrects a matrix by a product, which a filter of measurements does ({}:{line})", path.display()))
        .collect()
}

/// Lines that correct a matrix or a number by a product, in order.
fn corrections(text: &str) -> Vec<usize> {
    let mut found = Corrections::default();
    if let Ok(File { items, .. }) = syn::parse_file(text) {
        items.iter().for_each(|item| found.visit_item(item));
    }
    found.0
}

#[derive(Default)]
struct Corrections(Vec<usize>);

impl Visit<'_> for Corrections {
    fn visit_item(&mut self, item: &syn::Item) {
        if !is_test(attributes(item)) {
            visit::visit_item(self, item);
        }
    }

    fn visit_expr_binary(&mut self, difference: &ExprBinary) {
        if matches!(difference.op, BinOp::Sub(_) | BinOp::SubAssign(_)) {
            let factors = factors(&difference.right);
            let of = |expression: &Expr| bare(expression).to_token_stream().to_string();
            let minuend = of(&difference.left);
            let is_number = matches!(bare(&difference.left), Expr::Lit(_));
            let is_factor = !is_number && factors.iter().any(|factor| of(factor) == minuend);
            let has_transpose = factors.iter().any(|factor| of(factor).contains("transpose"));
            let is_corrected = is_of_matrix(&difference.left) || is_factor || has_transpose;
            if factors.len() > 1 && is_corrected {
                self.0.push(line(difference.op.span()));
            }
        }
        visit::visit_expr_binary(self, difference);
    }
}

/// `a[i][j]` or `a[(i, j)]`.
fn is_of_matrix(expression: &Expr) -> bool {
    match bare(expression) {
        Expr::Index(outer) => {
            matches!(*outer.index, Expr::Tuple(_)) || matches!(bare(&outer.expr), Expr::Index(_))
        }
        _ => false,
    }
}

/// Without parentheses, references and copies.
fn bare(expression: &Expr) -> &Expr {
    match expression {
        Expr::Paren(inner) => bare(&inner.expr),
        Expr::Reference(inner) => bare(&inner.expr),
        Expr::Unary(inner) => bare(&inner.expr),
        other => other,
    }
}

/// What is multiplied, and divided by what.
fn factors(expression: &Expr) -> Vec<&Expr> {
    match bare(expression) {
        Expr::Binary(product) if matches!(product.op, BinOp::Mul(_)) => {
            [factors(&product.left), factors(&product.right)].concat()
        }
        Expr::Binary(quotient) if matches!(quotient.op, BinOp::Div(_)) => factors(&quotient.left),
        other => vec![other],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PLAN: &str =
        "| a product corrects a matrix | `crates/seatrial-core/src/whitening.rs` (filters) |";

    fn faults_in(text: &str) -> usize {
        faults("seatrial", Path::new("crates/seatrial/src/a.rs"), text, PLAN).len()
    }

    /// The three filters that once stood in the workspace, and one by matrices.
    #[test]
    fn regress_a_second_filter_is_found() {
        for second in [
            "fn f() { let p: Square = from_fn(|a| from_fn(|b| p[a][b] - gain[a] * p[0][b])); }",
            "fn f() { for a in 0..6 { for b in 0..6 { p[a][b] -= gain[a] * row[b]; } } }",
            "fn given(&self) -> Self { let psi = [psi_psi - k_psi * psi_psi, psi_r - k_psi * psi_r]; }",
            "fn f() { p = &p - &gain * s * gain.transpose(); }",
            "fn f() { self.p[(i, j)] -= self.p[(i, 0)] * self.p[(0, j)] / s; }",
        ] {
            assert!(faults_in(second) > 0, "{second}");
        }
    }

    #[test]
    fn exact_owners_tests_and_other_differences_are_none() {
        let filter = "fn f() { p[a][b] -= gain[a] * row[b]; }";
        let of = |package, path: &str| faults(package, Path::new(path), filter, PLAN).len();
        assert_eq!(of("seatrial-core", "crates/seatrial-core/src/whitening.rs"), 0);
        assert_eq!(of("seatrial-core", "crates/seatrial-core/src/refine/whitening.rs"), 1);
        assert_eq!(of("seatrial-sim", "crates/seatrial-sim/src/plant.rs"), 0);
        for other in [
            "fn f() { let e = y - (a * u + b); let away = psi[k] - gain * r; x[i] -= x[j]; }",
            "fn f() { 2.0 - 2.0 * share; self.rate[i] -= k * h; }",
            "#[cfg(test)] mod tests { fn f() { p[a][b] -= gain[a] * row[b]; } }",
        ] {
            assert_eq!(faults_in(other), 0, "{other}");
        }
    }
}
