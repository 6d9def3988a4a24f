//! A root as a container has it, without a program for containers.

use std::fs::File;
use std::path::{Path, PathBuf};
use std::process::Stdio;
use std::time::Duration;

use anyhow::{Context, Result, bail, ensure};

use super::{arguments, instructions, user};
use crate::shell::{Run, Running, ask_to_end, command, empty_folder, files, patiently, put, shell};

const PATIENCE: Duration = Duration::from_secs(60);
/// Mounts the root read-only with the volume in it, then becomes the command.
const MOUNTED: &str = "set -e; root=$1; data=$2; shift 2; mount --bind \"$root\" \"$root\"; \
                       mount --bind \"$data\" \"$root/data\"; mount -o remount,bind,ro \"$root\"; exec \"$@\"";
/// What the command keeps on its volume.
const KEPT: [&str; 2] = ["seatrial.db", "seatrial.tokens.json"];

/// The command of the container file, running in the files of its image and a volume.
pub struct Container {
    folder: PathBuf,
    process: Running,
    /// The operator's.
    pub token: String,
}

impl Container {
    /// Starts the command, and waits until it serves. `folder` becomes its own.
    pub fn start(folder: &Path, binary: &Path, text: &str) -> Result<Self> {
        empty_folder(folder)?;
        let [root, data] = ["root", "data"].map(|name| folder.join(name));
        shell().create_dir(root.join("data"))?;
        shell().create_dir(&data)?;
        put(binary, root.join("seatrial"))?;
        for licence in ["LICENSE-APACHE", "LICENSE-MIT"] {
            put(licence, root.join(licence))?;
        }
        // Docker writes this file into every container.
        shell().write_file(root.join("etc/hosts"), "127.0.0.1 localhost host.docker.internal\n")?;
        let said = File::create(folder.join("said.txt"))?;
        let user = user(text).context("no USER")?;
        let (environment, words) = (instructions(text, "ENV"), arguments(text));
        let process = command!("unshare --map-root-user --mount sh -c {MOUNTED} sh {root} {data} /usr/bin/env -i {environment...} /usr/bin/unshare --pid --kill-child --wd=/data --map-user={user} --map-group={user} --root={root} /seatrial {words...}")
            .stdin(Stdio::null())
            .stdout(said.try_clone()?)
            .stderr(said)
            .begin()?;
        let mut container = Self { folder: folder.to_owned(), process, token: String::new() };
        container.token = patiently(PATIENCE, "the command serves", || {
            let said = container.said();
            if let Some(status) = container.process.0.try_wait()? {
                bail!("the command does not serve: {status}\n{said}");
            }
            let token = said.lines().find_map(|line| line.trim().strip_prefix("operator "));
            Ok(token.filter(|_| said.contains("http://")).map(|token| token.trim().to_owned()))
        })?;
        Ok(container)
    }

    /// The bytes of the image's files.
    pub fn image_bytes(&self) -> Result<u64> {
        let sizes = files(&self.folder.join("root"), "")?
            .into_iter()
            .map(|file| Ok(std::fs::metadata(file)?.len()));
        sizes.sum()
    }

    /// Everything that it said so far.
    pub fn said(&self) -> String {
        shell().read_file(self.folder.join("said.txt")).unwrap_or_default()
    }

    /// The most memory that its process ever had, bytes.
    pub fn most_memory(&self) -> Result<u64> {
        let status = shell().read_file(format!("/proc/{}/status", self.process()?))?;
        let most = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
        let kilobytes = most.and_then(|line| line.split_whitespace().next()).context("no VmHWM")?;
        Ok(kilobytes.parse::<u64>()? << 10)
    }

    /// Stops it as `docker stop` does: process 1 has no default for the signal. Fails where there is more on the volume than what is
    /// to be kept.
    pub fn ends_when_asked(&mut self) -> Result<()> {
        ask_to_end(self.process()?);
        let status =
            patiently(PATIENCE, "it ends when asked", || Ok(self.process.0.try_wait()?))?;
        ensure!(status.success(), "it ended with {status}\n{}", self.said());
        let kept = files(&self.folder.join("data"), "")?;
        let names: Vec<_> = kept.iter().filter_map(|path| path.file_name()).collect();
        ensure!(names == KEPT, "/data has {names:?}; expected {KEPT:?}");
        Ok(())
    }

    /// The process that is number 1 inside.
    fn process(&self) -> Result<String> {
        let id = self.process.0.id();
        let children = shell().read_file(format!("/proc/{id}/task/{id}/children"))?;
        let first = children.split_whitespace().next();
        Ok(first.with_context(|| format!("the command has ended\n{}", self.said()))?.to_owned())
    }
}
