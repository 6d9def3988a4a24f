//! The folder in which uploads lie while they are read. A server that is killed leaves its own, which the next one removes.

use std::fs::File;
use std::io;
use std::path::Path;

use tempfile::TempDir;

const PREFIX: &str = "seatrial-uploads-";
/// Locked by the server that the folder belongs to, as long as it runs.
const OWNER: &str = "owner";

/// The folder of this server.
#[derive(Debug)]
pub struct Uploads {
    folder: TempDir,
    _owner: File,
}

impl Uploads {
    /// Removes what killed servers left, and makes a folder.
    pub fn begin() -> io::Result<Self> {
        Self::begin_in(&std::env::temp_dir())
    }

    fn begin_in(place: &Path) -> io::Result<Self> {
        remove_left(place);
        let folder = tempfile::Builder::new().prefix(PREFIX).tempdir_in(place)?;
        let owner = File::create_new(folder.path().join(OWNER))?;
        owner.lock()?;
        Ok(Self { folder, _owner: owner })
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        self.folder.path()
    }
}

/// What cannot be removed is somebody else's.
fn remove_left(place: &Path) {
    for entry in std::fs::read_dir(place).into_iter().flatten().flatten() {
        let is_ours = entry.file_name().to_string_lossy().starts_with(PREFIX)
            && entry.file_type().is_ok_and(|kind| kind.is_dir());
        let owner = is_ours.then(|| File::open(entry.path().join(OWNER)));
        if let Some(Ok(owner)) = owner
            && owner.try_lock().is_ok()
        {
            let _ = std::fs::remove_dir_all(entry.path());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn io_the_folder_of_a_killed_server_is_removed_and_that_of_a_running_one_is_not() {
        let place = tempfile::tempdir().unwrap();
        let killed = place.path().join("seatrial-uploads-killed");
        std::fs::create_dir(&killed).unwrap();
        std::fs::write(killed.join(OWNER), "").unwrap();
        std::fs::write(killed.join("log.csv"), "a log").unwrap();
        let running = Uploads::begin_in(place.path()).unwrap();
        assert!(!killed.exists());
        let another = Uploads::begin_in(place.path()).unwrap();
        assert!(running.path().exists() && another.path().exists());
    }
}
