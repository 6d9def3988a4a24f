//! A root as a container has it, without a program for containers.

use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use super::instructions;
use crate::steps::ask_to_end;

const PATIENCE: Duration = Duration::from_secs(60);
/// Mounts the root read-only with the volume in it, then becomes the command.
const MOUNTED: &str = "set -e; root=$1; data=$2; shift 2; mount --bind \"$root\" \"$root\"; \
                       mount --bind \"$data\" \"$root/data\"; mount -o remount,bind,ro \"$root\"; exec \"$@\"";
/// What the command keeps on its volume.
const KEPT: [&str; 2] = ["seatrial.db", "seatrial.tokens.json"];

/// The files of an image and an empty volume.
pub struct Sandbox {
    root: PathBuf,
    data: PathBuf,
    user: String,
    environment: Vec<String>,
}

impl Sandbox {
    /// From the text of the container file and the command.
    pub fn made(folder: &Path, binary: &Path, text: &str, user: &str) -> Result<Self, String> {
        let _ = std::fs::remove_dir_all(folder);
        let sandbox = Self {
            root: folder.join("root"),
            data: folder.join("data"),
            user: user.to_owned(),
            environment: instructions(text, "ENV").map(String::from).collect(),
        };
        let failed = |error: std::io::Error| format!("{}: {error}", folder.display());
        for folder in ["data", "etc"] {
            std::fs::create_dir_all(sandbox.root.join(folder)).map_err(failed)?;
        }
        std::fs::create_dir_all(&sandbox.data).map_err(failed)?;
        std::fs::copy(binary, sandbox.root.join("seatrial")).map_err(failed)?;
        for licence in ["LICENSE-APACHE", "LICENSE-MIT"] {
            std::fs::copy(licence, sandbox.root.join(licence)).map_err(failed)?;
        }
        // Docker writes this file into every container.
        let hosts = "127.0.0.1 localhost host.docker.internal\n";
        std::fs::write(sandbox.root.join("etc/hosts"), hosts).map_err(failed)?;
        Ok(sandbox)
    }

    /// The bytes of the image's files.
    pub fn image_bytes(&self) -> Result<u64, String> {
        let files = std::fs::read_dir(&self.root).map_err(|error| error.to_string())?;
        let sizes = files.map(|file| file.and_then(|file| file.metadata()));
        let sizes: Result<Vec<_>, _> = sizes.collect();
        let sizes = sizes.map_err(|error| error.to_string())?;
        let sizes = sizes.iter().filter(|size| size.is_file());
        Ok(sizes.map(|size| size.len()).sum())
    }

    /// Starts the image's command with these words, and waits until it serves.
    pub fn run(&self, words: &[&str]) -> Result<Container, String> {
        let mut command = Command::new("unshare");
        command
            .args(["--map-root-user", "--mount", "sh", "-c", MOUNTED, "sh"])
            .args([&self.root, &self.data])
            .args(["/usr/bin/env", "-i"])
            .args(&self.environment)
            .args(["/usr/bin/unshare", "--pid", "--kill-child", "--wd=/data"])
            .arg(format!("--map-user={}", self.user))
            .arg(format!("--map-group={}", self.user))
            .arg(format!("--root={}", self.root.display()))
            .arg("/seatrial")
            .args(words)
            .stdout(Stdio::piped())
            .stderr(Stdio::piped());
        let child = command
            .spawn()
            .map_err(|error| format!("unshare: {error}"))?;
        Container::of(child)
    }

    /// Fails where there is more on the volume than what is to be kept.
    pub fn has_written_only_its_data(&self) -> Result<(), String> {
        let files = std::fs::read_dir(&self.data).map_err(|error| error.to_string())?;
        let names: Result<Vec<_>, _> = files.map(|file| file.map(|f| f.file_name())).collect();
        let mut names = names.map_err(|error| error.to_string())?;
        names.sort();
        match names == KEPT {
            true => Ok(()),
            false => Err(format!("/data has {names:?}; expected {KEPT:?}")),
        }
    }
}

/// The running command; killed when dropped.
pub struct Container {
    child: Child,
    said: Arc<Mutex<Vec<String>>>,
    /// The operator's.
    pub token: String,
}

impl Container {
    fn of(mut child: Child) -> Result<Self, String> {
        let said = Arc::new(Mutex::new(Vec::new()));
        let out = child.stdout.take().map(BufReader::new);
        let err = child.stderr.take().map(BufReader::new);
        for lines in [out.map(lines_of), err.map(lines_of)].into_iter().flatten() {
            let said = Arc::clone(&said);
            std::thread::spawn(move || {
                for line in lines {
                    if let Ok(mut said) = said.lock() {
                        said.push(line);
                    }
                }
            });
        }
        let mut container = Self {
            child,
            said,
            token: String::new(),
        };
        let begun = Instant::now();
        loop {
            let said = container.said();
            let token = said.lines().find_map(|line| {
                let word = line.trim().strip_prefix("operator ")?;
                Some(word.trim().to_owned())
            });
            if let (Some(token), true) = (token, said.contains("http://")) {
                container.token = token;
                return Ok(container);
            }
            let has_ended = !matches!(container.child.try_wait(), Ok(None));
            if has_ended || begun.elapsed() > PATIENCE {
                return Err(format!("the command does not serve:\n{}", container.said()));
            }
            std::thread::sleep(Duration::from_millis(20));
        }
    }

    /// Everything that it said so far.
    pub fn said(&self) -> String {
        self.said
            .lock()
            .map(|said| said.join("\n"))
            .unwrap_or_default()
    }

    /// The most memory that its process ever had, bytes.
    pub fn most_memory(&self) -> Result<u64, String> {
        let path = format!("/proc/{}/status", self.process()?);
        let status = std::fs::read_to_string(&path).map_err(|error| format!("{path}: {error}"))?;
        let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
        let kilobytes = line.and_then(|line| line.split_whitespace().next());
        let kilobytes = kilobytes.and_then(|number| number.parse::<u64>().ok());
        kilobytes
            .map(|number| number << 10)
            .ok_or_else(|| format!("{path}: no VmHWM"))
    }

    /// Stops it as `docker stop` does: process 1 has no default for the signal.
    pub fn ends_when_asked(&mut self) -> Result<(), String> {
        ask_to_end(self.process()?);
        let begun = Instant::now();
        while begun.elapsed() < PATIENCE {
            match self.child.try_wait() {
                Ok(Some(status)) if status.success() => return Ok(()),
                Ok(None) => std::thread::sleep(Duration::from_millis(20)),
                ended => return Err(format!("it ended with {ended:?}\n{}", self.said())),
            }
        }
        Err("it does not end when it is asked to".into())
    }

    /// The process that is number 1 inside.
    fn process(&self) -> Result<String, String> {
        let id = self.child.id();
        let path = format!("/proc/{id}/task/{id}/children");
        let children =
            std::fs::read_to_string(&path).map_err(|error| format!("{path}: {error}"))?;
        let first = children.split_whitespace().next();
        first
            .map(String::from)
            .ok_or_else(|| format!("the command has ended\n{}", self.said()))
    }
}

impl Drop for Container {
    fn drop(&mut self) {
        // The process inside is killed with its parent.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// The lines of a pipe as they come.
fn lines_of(pipe: impl BufRead + Send + 'static) -> Box<dyn Iterator<Item = String> + Send> {
    Box::new(pipe.lines().map_while(Result::ok))
}
