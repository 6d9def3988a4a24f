//! `seatrial paper`: the paper's printed numbers beside recomputed ones.

use std::fmt::Write as _;
use std::path::Path;

use seatrial_app::trials::paper::recreation;
use seatrial_app::trials::paper::recreation::RecreatedTable;
use seatrial_app::trials::paper::{Agreement, Claim, ERRATA, Erratum, claims};
use serde::Serialize;

use crate::output::{Exit, Failure, Output, OutputPath};

/// Reproduces the paper's tables and claims: printed value beside recomputed value.
///
/// Every printed number that follows from other printed numbers is computed from them. A row agrees
/// where the result rounds to the print, lies within the rounding of its inputs where it does for
/// some inputs that round to theirs, and differs where it does for none. Tables II, III and V are also
/// identified again by simulated trials of vehicles that have the paper's values for truth. Writes paper.md,
/// paper.csv, recreated.csv and paper.json.
#[derive(clap::Args)]
#[command(after_help = "Example:\n  seatrial paper --out paper-tables")]
pub struct Args {
    /// Directory for the files; made where it is missing.
    #[arg(long, value_name = "DIR")]
    out: OutputPath,
}

#[derive(Serialize)]
struct Document {
    schema: &'static str,
    summary: Summary,
    claims: Vec<Claim>,
    errata: &'static [Erratum],
    recreated: Vec<RecreatedTable>,
}

#[derive(Serialize)]
struct Summary {
    rows: usize,
    agree: usize,
    within_input_rounding: usize,
    differ: usize,
}

/// Runs the verb.
pub fn run(args: &Args, output: &Output) -> Result<Exit, Failure> {
    let claims = claims();
    let count = |agreement| claims.iter().filter(|c| c.agreement == agreement).count();
    let document = Document {
        schema: "seatrial.paper.v1",
        summary: Summary {
            rows: claims.len(),
            agree: count(Agreement::Agrees),
            within_input_rounding: count(Agreement::WithinInputRounding),
            differ: count(Agreement::Differs),
        },
        claims,
        errata: &ERRATA,
        recreated: recreation::tables().map_err(Failure::internal)?,
    };
    let json = serde_json::to_string_pretty(&document).map_err(Failure::internal)?;
    let files = [
        ("paper.md", markdown(&document) + &recreation::markdown(&document.recreated)),
        ("recreated.csv", recreation::csv(&document.recreated)),
        ("paper.csv", csv(&document.claims)),
        ("paper.json", json + "\n"),
    ];
    output.save_in(&args.out, &files)?;
    output.print(&document, || text(&document, &args.out))?;
    Ok(Exit::Done)
}

impl Summary {
    fn text(&self) -> String {
        format!(
            "{} printed numbers recomputed: {} agree, {} within the rounding of their inputs, {} differ",
            self.rows, self.agree, self.within_input_rounding, self.differ
        )
    }
}

/// As many digits as printed, and as many as show the difference.
fn printed(claim: &Claim) -> String {
    let decimals = claim.decimals.max(0) as usize;
    format!("{:.decimals$}", claim.printed)
}

fn recomputed(claim: &Claim) -> String {
    let decimals = claim.decimals.max(0) as usize + 1;
    format!("{:.decimals$}", claim.recomputed)
}

fn text(document: &Document, out: &Path) -> String {
    let mut text = format!("{}.\n\nThe rows that differ:\n", document.summary.text());
    for claim in differing(&document.claims) {
        let _ = writeln!(
            text,
            "  {}, {}: printed {}, recomputed {} {}{}",
            claim.place,
            claim.quantity,
            printed(claim),
            recomputed(claim),
            claim.unit,
            claim.note.map_or(String::new(), |n| format!(" ({n})"))
        );
    }
    let _ = writeln!(text, "\nErrors in the text, and what holds instead:");
    for erratum in document.errata {
        let _ = writeln!(
            text,
            "  {}: {}. Instead: {}.",
            erratum.place, erratum.printed, erratum.instead
        );
    }
    let (inside, all) = recreation::covered(&document.recreated);
    let _ = writeln!(
        text,
        "\nTables II, III and V re-created by simulated trials: {inside} of {all} true parameters inside their 95 % intervals."
    );
    let _ = write!(text, "\nAll rows: {}", out.join("paper.md").display());
    text
}

fn differing(claims: &[Claim]) -> impl Iterator<Item = &Claim> {
    claims.iter().filter(|claim| claim.agreement == Agreement::Differs)
}

fn markdown(document: &Document) -> String {
    let mut text = format!(
        "# The paper's numbers, recomputed\n\n{}.\n\n\
         | place | quantity | unit | printed | recomputed | comparison | note |\n\
         |---|---|---|---:|---:|---|---|\n",
        document.summary.text()
    );
    let cell = |cell: &str| cell.replace('|', "\\|");
    for claim in &document.claims {
        let _ = writeln!(
            text,
            "| {} | {} | {} | {} | {} | {} | {} |",
            claim.place,
            cell(&claim.quantity),
            claim.unit,
            printed(claim),
            recomputed(claim),
            claim.agreement.words(),
            cell(claim.note.unwrap_or_default())
        );
    }
    text.push_str(
        "\n## Errors in the text\n\n| place | printed | what holds instead |\n|---|---|---|\n",
    );
    for erratum in document.errata {
        let _ = writeln!(
            text,
            "| {} | {} | {} |",
            erratum.place,
            cell(erratum.printed),
            cell(erratum.instead)
        );
    }
    text
}

fn csv(claims: &[Claim]) -> String {
    let mut text = String::from(
        "place,quantity,unit,printed,recomputed,recomputed_low,recomputed_high,comparison,note\n",
    );
    let quoted = |field: &str| format!("\"{}\"", field.replace('"', "\"\""));
    for claim in claims {
        let _ = writeln!(
            text,
            "{},{},{},{},{},{},{},{},{}",
            quoted(claim.place),
            quoted(&claim.quantity),
            quoted(claim.unit),
            printed(claim),
            claim.recomputed,
            claim.recomputed_range[0],
            claim.recomputed_range[1],
            quoted(claim.agreement.words()),
            quoted(claim.note.unwrap_or_default())
        );
    }
    text
}
