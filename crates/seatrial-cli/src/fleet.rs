//! `seatrial fleet`: many logs at once.

use std::num::NonZeroUsize;
use std::ops::ControlFlow;
use std::sync::Mutex;
use std::time::{Duration, Instant};

use seatrial_app::fleet::{Estimate, Job, JournalError, Options, Progress, Summary};
use seatrial_app::workers::threads;
use serde::Serialize;

use crate::choice::one_of;
use crate::log::ChannelArgs;
use crate::output::{Exit, Failure, Output, OutputPath, say};
use crate::progress::{self, Bar, in_words};
use crate::screen::{labelled, width};

/// Where standard error is no terminal, a line says this often how far the job is.
const SAID_EVERY: Duration = Duration::from_secs(10);

/// Identify every manoeuvre of many logs: one Parquet row each, and one for each log that cannot be read.
#[derive(clap::Args, Debug)]
#[command(after_help = "\
What is done is kept in OUT.journal at once, in the working folder where OUT is in an object store. After an interruption the same command with --resume goes on where it \
stopped; OUT is written when everything is done. The same command again reads only logs that are new or have changed \
(length and time, or check sum; in an object store length and version) or could not be read.

--estimate refined gives what `identify` reports, with 95 % intervals, in some 20 ms of a core for each manoeuvre. \
--estimate online gives the estimator that runs on the vehicle, without intervals, twenty times faster.

Exit code 0: done, whatever the logs hold; 3: not one of them could be read.

Example:
  mkdir -p logs && seatrial sim log --seed 1 --out logs/run.csv && \\
      seatrial fleet logs --out fleet.parquet")]
pub struct Args {
    /// Folders, logs, patterns such as 'logs/**/*.csv', or @FILE with a name a line; also of s3://, gs:// and https://.
    #[arg(required = true, value_name = "DIR|GLOB|@LIST")]
    inputs: Vec<String>,
    /// The Parquet file, here or in an object store.
    #[arg(long, value_name = "FILE")]
    out: OutputPath,
    /// Which estimate.
    #[arg(long, value_name = "WHICH", default_value = "refined", value_parser = one_of(ESTIMATES))]
    estimate: Estimate,
    /// The column that tells the runs of a file apart; the rows of a run stand together, in order of time.
    #[arg(long, value_name = "COLUMN")]
    run_column: Option<String>,
    /// Threads [default: one a core].
    #[arg(long, value_name = "N")]
    workers: Option<NonZeroUsize>,
    /// Go on with a job that was interrupted.
    #[arg(long)]
    resume: bool,
    #[command(flatten)]
    channels: ChannelArgs,
}

/// The values of `--estimate`.
const ESTIMATES: [(Estimate, &str, &str); 2] = [
    (Estimate::Refined, "refined", "From the whole manoeuvre, with intervals"),
    (Estimate::Online, "online", "As on the vehicle, without intervals"),
];

/// `fleet --json`.
#[derive(Serialize)]
struct Document {
    schema: &'static str,
    out: String,
    estimate: Estimate,
    workers: usize,
    files: usize,
    /// Files in folders whose names do not end like those of logs.
    passed_over: usize,
    #[serde(flatten)]
    summary: Summary,
    wall_s: f64,
    /// Manoeuvres per minute of this job, without what was kept from before.
    manoeuvres_per_minute: f64,
}

/// Identifies every manoeuvre of many logs.
pub fn run(args: &Args, output: &Output) -> Result<Exit, Failure> {
    let found = seatrial_app::fleet::find(&args.inputs, &args.out).map_err(Failure::input)?;
    if found.passed_over > 0 {
        say(format_args!(
            "{} files whose names do not end like those of logs are passed over",
            found.passed_over
        ));
    }
    let mut options = Options::default();
    options.estimate = args.estimate;
    options.channels = args.channels.chosen()?;
    options.run_column = args.run_column.clone();
    let job = Job {
        sources: found.sources,
        options,
        out: args.out.to_path_buf(),
        workers: threads(args.workers),
        resume: args.resume,
    };
    let teller = Teller::new();
    let summary = job.run(|progress| teller.tell(progress)).map_err(failure)?;
    let wall_s = teller.begun.elapsed().as_secs_f64();
    let manoeuvres = teller.finish();
    let document = Document {
        schema: "seatrial.fleet.v1",
        out: args.out.display().to_string(),
        estimate: args.estimate,
        workers: job.workers,
        files: job.sources.len(),
        passed_over: found.passed_over,
        summary: summary.unwrap_or_default(),
        wall_s,
        manoeuvres_per_minute: manoeuvres as f64 * 60.0 / wall_s,
    };
    output.print(&document, || text(&document))?;
    Ok(match document.summary.manoeuvres {
        0 => Exit::Input,
        _ => Exit::Done,
    })
}

fn failure(error: JournalError) -> Failure {
    match error {
        JournalError::NotSaved { .. } | JournalError::Object(_) => Failure::not_saved(error),
        JournalError::Output(error) => error.into(),
        _ => Failure::usage(error),
    }
}

/// What goes on from a table of verdicts.
const NEXT: &str = "`seatrial identify LOG` explains the verdict on one log and says what to do";

fn text(document: &Document) -> String {
    let summary = &document.summary;
    let width = width();
    let read = format!("{}, {} of which could not be read", summary.logs, summary.errors);
    let found =
        format!("{} manoeuvres, {} of which are accepted", summary.manoeuvres, summary.accepted);
    let mut text = labelled("Logs      ", &read, width) + &labelled("Found     ", &found, width);
    for (title, counts) in [("Verdicts", &summary.verdicts), ("Errors", &summary.error_codes)] {
        let mut counts: Vec<(&String, &u64)> = counts.iter().collect();
        counts.sort_by_key(|(_, number)| std::cmp::Reverse(**number));
        let words = |code: &str| match code {
            "ok" => "usable".to_owned(),
            code => code.replace('_', " "),
        };
        let counts: Vec<String> =
            counts.iter().map(|(code, number)| format!("{} {number}", words(code))).collect();
        if !counts.is_empty() {
            text += &labelled(&format!("{title:<9} "), &counts.join(", "), width);
        }
    }
    if summary.done_before > 0 {
        let kept = format!("{} logs as they were read before", summary.done_before);
        text += &labelled("Kept      ", &kept, width);
    }
    let rate = match document.manoeuvres_per_minute {
        0.0 => "no new manoeuvre".to_owned(),
        rate => format!("{rate:.0} manoeuvres a minute"),
    };
    let (wall_s, workers) = (document.wall_s, document.workers);
    let rate = format!("{rate}, {wall_s:.1} s on {workers} threads");
    text += &labelled("Rate      ", &rate, width);
    text += &labelled("Written   ", &document.out, width);
    text + &labelled("Next      ", NEXT, width)
}

/// Says how far the job is.
struct Teller {
    begun: Instant,
    bar: Bar,
    last_said: Mutex<(Instant, Progress)>,
}

impl Teller {
    fn new() -> Self {
        let begun = Instant::now();
        Self {
            begun,
            bar: progress::of_bytes_with_a_note(),
            last_said: Mutex::new((begun, Progress::default())),
        }
    }

    fn tell(&self, progress: &Progress) -> ControlFlow<()> {
        let Ok(mut last_said) = self.last_said.lock() else {
            return ControlFlow::Continue(());
        };
        last_said.1 = *progress;
        let elapsed = self.begun.elapsed();
        let per_minute = progress.manoeuvres as f64 * 60.0 / elapsed.as_secs_f64();
        let rate = format!("{per_minute:.0} manoeuvres/min, {} errors", progress.errors);
        if self.bar.is_shown() {
            self.bar.set(progress.bytes_done, progress.bytes, rate);
        } else if last_said.0.elapsed() > SAID_EVERY {
            last_said.0 = Instant::now();
            let done = progress.bytes_done as f64 / progress.bytes.max(1) as f64;
            let left = elapsed.mul_f64((1.0 - done).max(0.0) / done.max(1e-9));
            say(format_args!("{:.0} % read, {rate}, {} left", 100.0 * done, in_words(left)));
        }
        ControlFlow::Continue(())
    }

    /// How many manoeuvres there were.
    fn finish(self) -> u64 {
        self.bar.clear();
        self.last_said.into_inner().map_or(0, |(_, last_said)| last_said.manoeuvres)
    }
}
