//! `seatrial report`: the self-contained HTML page of a trial or a log.

use std::path::{Path, PathBuf};

use seatrial_app::log_page::page;
use seatrial_app::outputs::head_of;
use seatrial_app::trials::campaign_models::{Purpose, chosen_campaign};
use seatrial_app::trials::campaign_page::campaign_page;
use seatrial_core::Axis;
use seatrial_logbook::Logbook;
use serde::Serialize;

use crate::choice::{AXES, one_of};
use crate::damage;
use crate::identify::EstimatorArgs;
use crate::log::{ChannelArgs, LogArgs};
use crate::output::{Exit, Failure, Output, OutputPath, say as say_on_stderr};
use crate::windows::WindowArgs;

/// One HTML page that shows a trial of a logbook, or a log with its model.
#[derive(clap::Args)]
#[command(after_help = "\
A log is identified as by `seatrial identify`, with the same windows, options and exit codes; it is drawn whether or \
not it gives a model. Of a log with manoeuvres at several speeds the surest model is drawn and the others are named.

Examples:
  seatrial trial --logbook seatrial.db && \\
      seatrial report --logbook seatrial.db
  seatrial sim log --seed 1 --out run.csv && \\
      seatrial report run.csv --out run.html")]
pub struct Args {
    /// The log, whatever its format: that is found by its content; `-` is CSV on standard input.
    log: Option<PathBuf>,
    /// The logbook that holds the trial.
    #[arg(
        long,
        value_name = "FILE",
        conflicts_with_all = ["log", "ChannelArgs", "WindowArgs", "EstimatorArgs"]
    )]
    logbook: Option<PathBuf>,
    /// Number of the campaign, or name of a configuration; without, the last that finished with an accepted model, else the
    /// last.
    #[arg(long, value_name = "CAMPAIGN", requires = "logbook")]
    campaign: Option<String>,
    /// The axis of the log: yaw, or pitch. A campaign of the logbook has its own.
    #[arg(
        long,
        value_name = "AXIS",
        default_value = "yaw",
        value_parser = one_of(AXES),
        conflicts_with = "logbook"
    )]
    axis: Axis,
    /// The page [default: the name of the log, as run.html of run.csv; of a logbook, and of standard input, report.html].
    #[arg(long, value_name = "FILE")]
    out: Option<OutputPath>,
    #[command(flatten)]
    channels: ChannelArgs,
    #[command(flatten)]
    windows: WindowArgs,
    #[command(flatten)]
    estimator: EstimatorArgs,
}

/// Runs the verb.
pub fn run(args: &Args, output: &Output) -> Result<Exit, Failure> {
    let (page, exit) = match (&args.log, &args.logbook) {
        (Some(log), _) => of_log(log, args)?,
        (None, Some(logbook)) => (of_logbook(logbook, args)?, Exit::Done),
        (None, None) => {
            return Err(Failure::usage(
                "nothing to report: name a log, or a logbook as in --logbook seatrial.db",
            ));
        }
    };
    let out = args.out();
    if let Some(shown) = title_of(&out).filter(|shown| !page.contains(shown)) {
        let shown = shown.trim_start_matches("<title>");
        say_on_stderr(format!("{}: takes the place of `{shown}`", out.display()));
    }
    output.save(&out, &page)?;
    say(&out, &page, output)?;
    Ok(exit)
}

impl Args {
    /// Where the page goes: beside nothing, into this folder.
    fn out(&self) -> PathBuf {
        if let Some(out) = &self.out {
            return out.to_path_buf();
        }
        let log = self.log.as_deref().filter(|log| *log != Path::new("-"));
        let name = log.and_then(Path::file_stem);
        name.map_or("report.html".into(), |name| {
            let mut page = name.to_owned();
            page.push(".html");
            page.into()
        })
    }
}

/// The title of the page that is there.
fn title_of(path: &Path) -> Option<String> {
    let page = String::from_utf8_lossy(&head_of(path)).into_owned();
    let from = page.find("<title>")?;
    let length = page[from..].find("</title>")?;
    Some(page[from..from + length].to_owned())
}

fn of_logbook(path: &Path, args: &Args) -> Result<String, Failure> {
    let logbook = Logbook::open_read_only(path)?;
    let chosen = chosen_campaign(&logbook, args.campaign.as_deref(), Purpose::Record)?;
    chosen.passed_over.iter().for_each(say_on_stderr);
    damage::warn_of_missing(&logbook);
    let entry = damage::warn(&logbook, chosen.entry.id)?;
    Ok(campaign_page(&logbook, &entry)?)
}

fn of_log(path: &Path, args: &Args) -> Result<(String, Exit), Failure> {
    let log = LogArgs { log: path.to_path_buf(), channels: args.channels.clone() };
    let found = args.estimator.identify(args.axis, (&log, &[]), &args.windows, true, false)?;
    Ok((page(&found, path), Exit::of(found.verdict())))
}

#[derive(Serialize)]
struct ReportDocument<'a> {
    schema: &'static str,
    path: &'a Path,
    bytes: usize,
}

fn say(path: &Path, page: &str, output: &Output) -> Result<(), Failure> {
    let saved = ReportDocument { schema: "seatrial.report.v1", path, bytes: page.len() };
    output.print(&saved, || {
        format!("{} ({} kB): open it in a browser", path.display(), page.len() / 1000)
    })
}
