//! The one way to every file that a command writes.
//!
//! A file is written beside its place and then takes it, so that a full disk leaves neither half a file nor an empty one.
//! Refused is what must not be lost: a file that the command reads or writes already (the file itself, whatever its name), and
//! whatever stands there that is no earlier output of the same kind. What is no file, as a device, is written to and never read.
//!
//! ```
//! use seatrial_app::outputs::Outputs;
//!
//! # let folder = tempfile::tempdir()?;
//! # let page = folder.path().join("page.html");
//! let outputs = Outputs::of(vec![page.clone()]);
//! outputs.save(&page, b"<meta name=\"generator\" content=\"seatrial\">")?;
//! let twice = Outputs::of(vec![page.clone(), page.clone()]);
//! assert!(twice.save(&page, b"").is_err());
//! // No page: the page stays.
//! assert!(outputs.save(&page, b"# Gains by seatrial").is_err());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod kind;

use std::fs::{self, File, Metadata, OpenOptions};
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};

pub use kind::head_of;
use tempfile::NamedTempFile;

/// Files that SQLite keeps beside a database.
const BESIDE_A_LOGBOOK: [&str; 3] = ["-wal", "-shm", "-journal"];

/// The end of the name of a file with what a trial has left changed on a vehicle.
const BACKUP: &str = ".restore.toml";

/// The files that a command reads and writes.
#[derive(Clone, Debug, Default)]
pub struct Outputs {
    named: Vec<PathBuf>,
}

/// The kind of an output that hours of work may come before.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OutputKind {
    /// A page.
    Page,
    /// A table of the results of many logs.
    Results,
}

/// Why a file was not written.
#[derive(Debug, thiserror::Error)]
pub enum OutputError {
    /// Something would be lost.
    #[error("{}: not written: {why}", .path.display())]
    Refused {
        /// The file.
        path: PathBuf,
        /// What would be lost.
        why: &'static str,
    },
    /// The system said no.
    #[error("{}: not saved: {error}", .path.display())]
    NotSaved {
        /// The file.
        path: PathBuf,
        /// What the system said.
        error: io::Error,
    },
}

impl OutputError {
    /// The error with the path of another place, of which the file is a copy.
    #[cfg(feature = "parquet")]
    pub(crate) fn of(mut self, place: &Path) -> Self {
        let (Self::Refused { path, .. } | Self::NotSaved { path, .. }) = &mut self;
        *path = place.into();
        self
    }
}

/// What a file holds that is not written over.
#[derive(Clone, Copy, PartialEq, Eq)]
enum ProtectedFile {
    Logbook,
    Log,
    Backup,
    /// Nothing that this program has written as an output of the same kind.
    Foreign,
}

impl Outputs {
    /// The outputs of a command that names these files, each as often as it does, inputs and outputs alike.
    pub fn of(named: Vec<PathBuf>) -> Self {
        Self { named }
    }

    /// May this output be written? Asked before work begins whose result would have no place.
    ///
    /// # Errors
    /// [`OutputError::Refused`] where the command names the file twice, or something is there that is no earlier output.
    pub fn check(&self, path: &Path) -> Result<(), OutputError> {
        match self.kept(path)? {
            Some(kept) => Err(kept.refused(path)),
            None => Ok(()),
        }
    }

    /// [Checks](Self::check) the place of an output whose kind is known before it is made.
    ///
    /// # Errors
    /// As [`check`](Self::check), and where the earlier output is of another kind.
    pub fn check_for(&self, path: &Path, planned: OutputKind) -> Result<(), OutputError> {
        self.check(path)?;
        match kind::is_planned(path, planned) {
            true => Ok(()),
            false => Err(ProtectedFile::Foreign.refused(path)),
        }
    }

    /// Writes a file whole.
    ///
    /// # Errors
    /// As [`check`](Self::check), and where the earlier output is of another kind; not where the file holds the same bytes already.
    /// [`OutputError::NotSaved`] where the disk does not take it, and the file is as it was before.
    pub fn save(&self, path: &Path, content: &[u8]) -> Result<(), OutputError> {
        self.save_with(path, |file| file.write_all(content))
    }

    /// [Saves](Self::save) what a function writes.
    pub fn save_with(
        &self,
        path: &Path,
        write: impl FnOnce(&mut File) -> io::Result<()>,
    ) -> Result<(), OutputError> {
        let kept = self.kept(path)?.filter(|kept| *kept != ProtectedFile::Foreign);
        if let Some(ProtectedFile::Logbook) = kept {
            return Err(ProtectedFile::Logbook.refused(path));
        }
        let not_saved = |error| not_saved(path, error);
        if let Some(mut device) = device(path).map_err(not_saved)? {
            return write(&mut device).map_err(not_saved);
        }
        let place = place_of(path);
        let mut beside = beside(&place).map_err(not_saved)?;
        write(beside.as_file_mut()).map_err(not_saved)?;
        let is_replaced = kind::is_replaced(&place, beside.path());
        let kept = kept.or_else(|| (!is_replaced).then_some(ProtectedFile::Foreign));
        match kept {
            Some(_) if has_same_bytes(beside.path(), &place).map_err(not_saved)? => Ok(()),
            Some(kept) => Err(kept.refused(path)),
            None => put(beside, &place).map(drop).map_err(not_saved),
        }
    }

    /// Begins a file that is read while it grows.
    ///
    /// # Errors
    /// As [`check`](Self::check), and where anything is there or the file cannot be made.
    pub fn grow(&self, path: &Path) -> Result<File, OutputError> {
        self.check(path)?;
        if !kind::head_of(path).is_empty() {
            return Err(ProtectedFile::Foreign.refused(path));
        }
        let begin = || match device(path)? {
            Some(device) => Ok(device),
            None => {
                let place = place_of(path);
                put(beside(&place)?, &place)
            }
        };
        begin().map_err(|error| not_saved(path, error))
    }

    fn kept(&self, path: &Path) -> Result<Option<ProtectedFile>, OutputError> {
        let here = self.named.iter().filter(|named| is_same(named, path));
        if here.count() > 1 {
            return Err(OutputError::Refused {
                path: path.into(),
                why: "this command reads this file, or writes it already; give another name",
            });
        }
        Ok(kept_at(path))
    }
}

/// Puts what a function writes in the place of a file that this program made there, and of no other. Gives the new file.
pub fn replace(
    path: &Path,
    before: &File,
    write: impl FnOnce(&mut File) -> io::Result<()>,
) -> io::Result<File> {
    if let Some(mut device) = device(path)? {
        write(&mut device)?;
        return Ok(device);
    }
    let place = place_of(path);
    if is_another(&place, before) {
        return Err(io::Error::other("another file was put in its place, and would be lost"));
    }
    let mut beside = beside(&place)?;
    write(beside.as_file_mut())?;
    put(beside, &place)
}

/// Is there a file, and another than this one?
#[cfg(unix)]
fn is_another(place: &Path, file: &File) -> bool {
    let there = fs::metadata(place);
    there.is_ok_and(|there| !file.metadata().is_ok_and(|file| is_one_file(&file, &there)))
}

/// Elsewhere an open file stays where it is.
#[cfg(not(unix))]
fn is_another(_: &Path, _: &File) -> bool {
    false
}

fn not_saved(path: &Path, error: io::Error) -> OutputError {
    OutputError::NotSaved { path: path.into(), error }
}

impl ProtectedFile {
    fn refused(self, path: &Path) -> OutputError {
        OutputError::Refused {
            path: path.into(),
            why: match self {
                Self::Logbook => {
                    "it is a logbook or another database, and would be lost; give another name"
                }
                Self::Log => "it is a log, and would be lost; give another name",
                Self::Backup => {
                    "it holds what `seatrial vehicle restore` puts back, and would be lost; give another name"
                }
                Self::Foreign => {
                    "what is there is no earlier output of this kind, and would be lost; give another name, or remove it first"
                }
            },
        }
    }
}

fn kept_at(path: &Path) -> Option<ProtectedFile> {
    let name = path.to_str().unwrap_or_default();
    let logbook = BESIDE_A_LOGBOOK.iter().find_map(|ending| name.strip_suffix(ending));
    if logbook.is_some_and(|logbook| is_database(Path::new(logbook))) || is_database(path) {
        return Some(ProtectedFile::Logbook);
    }
    let is_file = fs::metadata(path).is_ok_and(|about| about.is_file());
    if is_file && place_of(path).to_string_lossy().ends_with(BACKUP) {
        return Some(ProtectedFile::Backup);
    }
    match is_file && !kind::head_of(path).is_empty() {
        true if seatrial_logs::is_log(path) => Some(ProtectedFile::Log),
        true if !kind::is_output(path) => Some(ProtectedFile::Foreign),
        _ => None,
    }
}

fn is_database(path: &Path) -> bool {
    let mut start = [0; 16];
    let is_file = fs::metadata(path).is_ok_and(|about| about.is_file());
    let read =
        is_file && File::open(path).is_ok_and(|mut file| file.read_exact(&mut start).is_ok());
    read && start == *b"SQLite format 3\0"
}

/// Do both names lead to one file, or to where one would be made?
fn is_same(one: &Path, other: &Path) -> bool {
    match (fs::metadata(one), fs::metadata(other)) {
        (Ok(a), Ok(b)) => is_one_file(&a, &b) || place_of(one) == place_of(other),
        (Err(_), Err(_)) => place_of(one) == place_of(other),
        _ => false,
    }
}

#[cfg(unix)]
fn is_one_file(one: &Metadata, other: &Metadata) -> bool {
    use std::os::unix::fs::MetadataExt;
    one.is_file() && (one.dev(), one.ino()) == (other.dev(), other.ino())
}

/// Elsewhere their places decide.
#[cfg(not(unix))]
fn is_one_file(_: &Metadata, _: &Metadata) -> bool {
    false
}

/// Where a file is or will be, links followed.
fn place_of(path: &Path) -> PathBuf {
    if let Ok(place) = path.canonicalize() {
        return place;
    }
    // A link to a file that is not there yet.
    if let Ok(to) = path.read_link() {
        return place_of(&folder_of(path).join(to));
    }
    let folder = folder_of(path);
    let folder = folder.canonicalize().unwrap_or(folder);
    folder.join(path.file_name().unwrap_or_default())
}

fn folder_of(path: &Path) -> PathBuf {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder.into(),
        _ => PathBuf::from("."),
    }
}

/// What is no file, as a terminal or a pipe, is written to as it is.
fn device(path: &Path) -> io::Result<Option<File>> {
    match fs::metadata(path) {
        Ok(about) if !about.is_file() => OpenOptions::new().write(true).open(path).map(Some),
        _ => Ok(None),
    }
}

/// What the system said, without the name of a file that nobody asked for.
fn without_its_path(error: io::Error) -> io::Error {
    // The library puts the name behind what the system said.
    match error.to_string().split_once(" at path ") {
        Some((said, _)) => io::Error::new(error.kind(), said),
        None => error,
    }
}

/// An empty file in the same folder, with the permissions that the one in its place has or would get.
fn beside(place: &Path) -> io::Result<NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".seatrial-").suffix(".part");
    #[cfg(unix)]
    let any = <fs::Permissions as std::os::unix::fs::PermissionsExt>::from_mode(0o666);
    #[cfg(unix)]
    builder.permissions(any);
    let file = (builder.tempfile_in(folder_of(place))).map_err(without_its_path)?;
    if let Ok(about) = fs::metadata(place) {
        if about.permissions().readonly() {
            return Err(io::ErrorKind::PermissionDenied.into());
        }
        file.as_file().set_permissions(about.permissions())?;
    }
    Ok(file)
}

fn put(file: NamedTempFile, place: &Path) -> io::Result<File> {
    file.persist(place).map_err(|failed| failed.error)
}

fn has_same_bytes(one: &Path, other: &Path) -> io::Result<bool> {
    Ok(fs::metadata(one)?.len() == fs::metadata(other)?.len() && fs::read(one)? == fs::read(other)?)
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    const PLAN: &str = "# Trial plan by seatrial\nthrusts = [0.5]\n";
    const ANOTHER: &str = "# Trial plan by seatrial\nthrusts = [0.6]\n";
    const LOG: &str = "time_s,heading_deg,rudder_deg\n0,1,2\n1,2,3\n2,3,4\n";

    #[test]
    fn io_what_a_command_reads_or_writes_is_not_written_over_by_any_name() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::write(at("plan.toml"), PLAN).unwrap();
        std::os::unix::fs::symlink(at("plan.toml"), at("link")).unwrap();
        fs::hard_link(at("plan.toml"), at("hard")).unwrap();
        std::os::unix::fs::symlink(at("new"), at("dangling")).unwrap();
        for (input, output) in [
            ("plan.toml", "plan.toml"),
            ("plan.toml", "link"),
            ("link", "hard"),
            ("new", "./new"),
            ("new", "dangling"),
        ] {
            let outputs = Outputs::of(vec![at(input), at(output)]);
            let refused = outputs.save(&at(output), b"lost").unwrap_err();
            assert!(matches!(refused, OutputError::Refused { .. }), "{refused}");
            assert!(outputs.grow(&at(output)).is_err(), "{output}");
        }
        assert_eq!(fs::read_to_string(at("hard")).unwrap(), PLAN);
        assert!(!at("new").exists());
        // Named once, a link leads to the file that is written.
        Outputs::of(vec![at("link")]).save(&at("link"), ANOTHER.as_bytes()).unwrap();
        assert_eq!(fs::read_to_string(at("plan.toml")).unwrap(), ANOTHER);
        assert!(at("link").is_symlink());
    }

    #[test]
    fn io_logs_and_databases_are_not_written_over() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::write(at("run.csv"), LOG).unwrap();
        fs::write(at("run.mcap"), b"\x89MCAP0\r\n rest").unwrap();
        fs::write(at("a.db"), b"SQLite format 3\0 rest").unwrap();
        fs::write(at("a.db-wal"), b"").unwrap();
        let outputs = Outputs::default();
        for name in ["run.csv", "run.mcap", "a.db", "a.db-wal"] {
            let before = fs::read(at(name)).unwrap();
            assert!(outputs.check(&at(name)).is_err(), "{name}");
            assert!(outputs.save(&at(name), b"lost").is_err(), "{name}");
            assert_eq!(fs::read(at(name)).unwrap(), before, "{name}");
        }
        // The log that is there already is no loss, nor is a file of another kind.
        outputs.save(&at("run.csv"), LOG.as_bytes()).unwrap();
        for _ in 0..2 {
            outputs.save(&at("plan.toml"), PLAN.as_bytes()).unwrap();
        }
        let left: Vec<_> = fs::read_dir(folder.path()).unwrap().collect();
        assert_eq!(left.len(), 5, "{left:?}");
    }

    #[test]
    fn io_only_an_earlier_output_of_the_same_kind_is_written_over() {
        let folder = tempfile::tempdir().unwrap();
        let place = folder.path().join("out");
        let gains = "# PX4 rover parameters by seatrial\nA 1\n";
        let (json, other) =
            (r#"{"schema":"seatrial.truth.v1"}"#, r#"{"schema": "seatrial.model.v1"}"#);
        let page = "<html><meta name=\"generator\" content=\"seatrial\">";
        let table = "place,quantity,unit,printed\n1,2,3,4\n";
        let own = [PLAN, gains, json, other, page];
        let strange = [
            "a,b,c\n1,2,3\n2,3,4\n",
            "0 1 2\n1 2 3\n",
            "{\"t\": 1, \"heading\": 2}\n",
            "PK\x03\x04run.csv seatrial",
            "notes on seatrial\n",
            "<!doctype html><title>mine</title>",
        ];
        for before in own.iter().chain(&strange).chain([&table]) {
            for after in own {
                fs::write(&place, before).unwrap();
                let saved = Outputs::default().save(&place, after.as_bytes());
                assert_eq!(saved.is_ok(), *before == after, "{before} -> {after}");
                let there = fs::read_to_string(&place).unwrap();
                assert_eq!(there, *before);
            }
            let is_own = own.contains(before);
            assert_eq!(Outputs::default().check(&place).is_ok(), is_own, "{before}");
            assert!(Outputs::default().grow(&place).is_err(), "{before}");
        }
        // What has changed within its kind, and a table by its heading.
        for (before, after) in [(PLAN, ANOTHER), (table, "place,quantity,unit,printed\n")] {
            fs::write(&place, before).unwrap();
            Outputs::default().save(&place, after.as_bytes()).unwrap();
            assert_eq!(fs::read_to_string(&place).unwrap(), after);
        }
        fs::write(&place, "").unwrap();
        Outputs::default().save(&place, PLAN.as_bytes()).unwrap();
    }

    /// A device gives bytes without end.
    #[test]
    fn io_a_device_is_written_to_and_never_read() {
        let outputs = Outputs::default();
        let full = Path::new("/dev/full");
        assert_eq!(head_of(Path::new("/dev/zero")), b"");
        assert!(outputs.check(full).is_ok() && outputs.save(full, b"a").is_err());
        outputs.save(Path::new("/dev/null"), b"a").unwrap();
    }

    #[test]
    fn io_what_grows_takes_the_place_of_nothing_that_was_put_there() {
        let folder = tempfile::tempdir().unwrap();
        let place = folder.path().join("run.parquet");
        let mut file = Outputs::default().grow(&place).unwrap();
        for content in ["one", "two"] {
            let write = |file: &mut File| file.write_all(content.as_bytes());
            file = replace(&place, &file, write).unwrap();
            assert_eq!(fs::read_to_string(&place).unwrap(), content);
        }
        fs::rename(&place, folder.path().join("moved")).unwrap();
        fs::write(&place, LOG).unwrap();
        assert!(replace(&place, &file, |file| file.write_all(b"lost")).is_err());
        assert_eq!(fs::read_to_string(&place).unwrap(), LOG);
        // What is gone is written again.
        fs::remove_file(&place).unwrap();
        replace(&place, &file, |file| file.write_all(b"three")).unwrap();
        assert_eq!(fs::read_to_string(&place).unwrap(), "three");
    }

    #[test]
    fn io_an_error_names_no_file_that_nobody_asked_for() {
        let told =
            Outputs::default().save(Path::new("/proc/page.html"), b"a").unwrap_err().to_string();
        assert!(!told.contains(".part"), "{told}");
    }

    #[test]
    fn io_a_disk_that_takes_nothing_leaves_the_file_as_it_was() {
        let folder = tempfile::tempdir().unwrap();
        let page = folder.path().join("page.html");
        let full = |_: &mut File| Err(io::ErrorKind::StorageFull.into());
        assert!(Outputs::default().save_with(&page, full).is_err());
        assert!(!page.exists());
        fs::write(&page, PLAN).unwrap();
        assert!(Outputs::default().save_with(&page, full).is_err());
        assert_eq!(fs::read_to_string(&page).unwrap(), PLAN);
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }
}
