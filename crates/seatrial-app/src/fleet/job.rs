//! All logs on all cores.

use std::any::Any;
use std::ops::ControlFlow;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::thread;

use seatrial_logs::{Run, Runs};

use super::journal::{Entry, Journal, JournalError, Summary};
use super::log::{self, Options};
use super::{Row, Source, objects};

/// Many logs, and where their rows go.
pub struct Job {
    /// The logs.
    pub sources: Vec<Source>,
    /// How to read and identify.
    pub options: Options,
    /// The Parquet file.
    pub out: PathBuf,
    /// Threads.
    pub workers: usize,
    /// Go on with the journal of a job that was interrupted.
    pub resume: bool,
}

/// How far a job is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Progress {
    /// Bytes of all logs.
    pub bytes: u64,
    /// Bytes of the logs that are read.
    pub bytes_done: u64,
    /// Manoeuvres of this job, without what was kept from before.
    pub manoeuvres: u64,
    /// Error rows written, those of earlier parts of the job included.
    pub errors: u64,
}

/// A log, or a run of it, to be worked on.
enum Work {
    Log(Source),
    Run(Source, Run),
    /// A file of runs that cannot be read, or no further.
    Failed(Box<Row>),
}

impl Work {
    fn rows(self, options: &Options) -> Vec<Row> {
        match self {
            Self::Log(source) => log::rows_of_log(&source, options),
            Self::Run(source, run) => log::rows_of_run(&source, run, options),
            Self::Failed(row) => vec![*row],
        }
    }
}

/// Hands out the work, in order.
struct Queue<'a> {
    sources: &'a [Source],
    options: &'a Options,
    next: usize,
    /// The file that is being read run by run, and how many runs it gave.
    runs: Option<(Runs, u64)>,
    bytes_before: u64,
}

/// A piece of work: the index of its source, which run of it, what to do.
type Piece = (usize, u64, Work);

impl<'a> Queue<'a> {
    fn new(sources: &'a [Source], options: &'a Options) -> Self {
        Self { sources, options, next: 0, runs: None, bytes_before: 0 }
    }

    /// The next piece of work of which nothing is kept: no such run, and not all of its log.
    fn next(
        &mut self,
        is_done: impl Fn(usize, u64) -> bool,
        is_whole: impl Fn(usize) -> bool,
    ) -> Option<Piece> {
        loop {
            if let Some(piece) = self.next_run() {
                if !is_done(piece.0, piece.1) {
                    return Some(piece);
                }
                continue;
            }
            let index = self.next;
            let source = self.sources.get(index)?;
            self.next += 1;
            self.bytes_before += source.bytes;
            if is_whole(index) {
                continue;
            }
            let Some(column) = &self.options.run_column else {
                return Some((index, 0, Work::Log(source.clone())));
            };
            let opened = caught(|| {
                let held = objects::held(source)?;
                Runs::open_in(&source.path, &held, &self.options.choice(), column)
            });
            match failure(source, opened) {
                Ok(runs) => self.runs = Some((runs, 0)),
                Err(_) if is_done(index, 0) => {}
                Err(row) => return Some((index, 0, Work::Failed(row))),
            }
        }
    }

    /// The next run of the file that is open.
    fn next_run(&mut self) -> Option<Piece> {
        let index = self.next.checked_sub(1)?;
        let source = &self.sources[index];
        let (runs, given) = self.runs.as_mut()?;
        let number = *given;
        *given += 1;
        let run = caught(|| runs.next().transpose());
        match failure(source, run) {
            Ok(Some(run)) => Some((index, number, Work::Run(source.clone(), run))),
            Ok(None) => {
                self.runs = None;
                None
            }
            Err(row) => {
                self.runs = None;
                Some((index, number, Work::Failed(row)))
            }
        }
    }

    fn bytes_done(&self) -> u64 {
        match (&self.runs, self.next.checked_sub(1)) {
            (Some((runs, _)), Some(index)) => {
                self.bytes_before - self.sources[index].bytes + runs.bytes_read()
            }
            _ => self.bytes_before,
        }
    }
}

/// The error row of what failed or panicked.
fn failure<T>(
    source: &Source,
    result: Result<Result<T, seatrial_logs::ReadError>, Panic>,
) -> Result<T, Box<Row>> {
    let read = result.map_err(|panic| panicked(source, &panic))?;
    read.map_err(|error| log::failed(log::blank(source), &error).into())
}

/// A panic, by its message.
struct Panic(String);

fn panicked(source: &Source, Panic(message): &Panic) -> Row {
    let mut row = log::blank(source);
    let path = source.path.display();
    row.failed(
        "panic",
        format!("{path}: a bug in its reader or in the estimator: {message}; please report it with the log"),
    );
    row
}

/// What `work` gives, or its panic.
fn caught<T>(work: impl FnOnce() -> T) -> Result<T, Panic> {
    catch_unwind(AssertUnwindSafe(work)).map_err(|panic: Box<dyn Any + Send>| {
        let text = panic.downcast_ref::<String>().map(String::as_str);
        let text = text.or_else(|| panic.downcast_ref::<&str>().copied());
        Panic(text.unwrap_or("no message").to_owned())
    })
}

/// Does a piece of work; a panic becomes its error row.
fn entry(source: &Source, run: u64, work: impl FnOnce() -> Vec<Row>) -> Entry {
    Entry {
        source: source.path.clone(),
        bytes: source.bytes,
        modified_ns: source.modified_ns,
        etag: source.etag.clone(),
        run,
        rows: caught(work).unwrap_or_else(|panic| vec![panicked(source, &panic)]),
    }
}

/// What a worker on another machine makes of a log: an entry for it, or one for each of its runs.
pub fn work_on(source: &Source, options: &Options) -> Vec<Entry> {
    let sources = [source.clone()];
    let mut queue = Queue::new(&sources, options);
    let mut entries = Vec::new();
    while let Some((_, run, work)) = queue.next(|_, _| false, |_| false) {
        entries.push(entry(source, run, || work.rows(options)));
    }
    entries
}

/// What the workers share besides the queue.
struct JobState {
    journal: Journal,
    progress: Progress,
    failure: Option<JournalError>,
    is_stopped: bool,
}

impl Job {
    /// Does everything that is not done and writes the Parquet file. `None` where `watch`, which sees the progress after
    /// every log, stopped the job; the journal then stays.
    pub fn run(
        &self,
        watch: impl Fn(&Progress) -> ControlFlow<()> + Sync,
    ) -> Result<Option<Summary>, JournalError> {
        let journal = Journal::open(&self.out, &self.sources, &self.options, self.resume)?;
        let kept = Mutex::new(JobState {
            journal,
            progress: Progress {
                bytes: self.sources.iter().map(|source| source.bytes).sum(),
                ..Progress::default()
            },
            failure: None,
            is_stopped: false,
        });
        let queue = Mutex::new(Queue::new(&self.sources, &self.options));
        thread::scope(|scope| {
            for _ in 0..self.workers {
                scope.spawn(|| self.worker(&queue, &kept, &watch));
            }
        });
        let kept = kept.into_inner().unwrap_or_else(PoisonError::into_inner);
        match (kept.failure, kept.is_stopped) {
            (Some(failure), _) => Err(failure),
            (None, true) => Ok(None),
            (None, false) => kept.journal.finish().map(Some),
        }
    }

    fn worker(
        &self,
        queue: &Mutex<Queue>,
        kept: &Mutex<JobState>,
        watch: &impl Fn(&Progress) -> ControlFlow<()>,
    ) {
        loop {
            let (piece, bytes_done) = {
                let mut queue = locked(queue);
                let is_done = |source, run| locked(kept).journal.is_done(source, run);
                let is_whole = |source| locked(kept).journal.is_whole(source);
                (queue.next(is_done, is_whole), queue.bytes_done())
            };
            let Some((index, run, work)) = piece else {
                return;
            };
            let entry = entry(&self.sources[index], run, || work.rows(&self.options));
            let mut kept = locked(kept);
            if kept.is_stopped {
                return;
            }
            let errors = entry.rows.iter().filter(|row| row.error.is_some()).count() as u64;
            kept.progress.errors += errors;
            kept.progress.manoeuvres += entry.rows.len() as u64 - errors;
            kept.progress.bytes_done = kept.progress.bytes_done.max(bytes_done);
            if let Err(failure) = kept.journal.keep(&entry) {
                kept.failure = Some(failure);
                kept.is_stopped = true;
            }
            if watch(&kept.progress).is_break() {
                kept.is_stopped = true;
            }
        }
    }
}

fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    #[test]
    fn regress_a_panic_becomes_the_error_row_of_its_log() {
        let source = Source::of(Path::new("run.csv"));
        let made = entry(&source, 0, || panic!("index out of range"));
        let [row] = made.rows.as_slice() else {
            panic!("{made:?}");
        };
        assert_eq!(row.error.as_deref(), Some("panic"));
        assert!(row.error_text.as_ref().unwrap().contains("index out of range"));
        assert_eq!(row.source, "run.csv");
    }
}
