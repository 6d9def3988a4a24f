//! Python environments of the project's own.

use std::path::PathBuf;
use std::process::Command;

use crate::steps::succeeds;
use crate::target::in_target;

/// The Python of this machine.
pub const PYTHON: &str = "python3";

/// A virtual environment with what files of requirements name.
pub struct Environment {
    /// The Python that makes it.
    pub python: &'static str,
    /// Where it is, below the folder that cargo builds into.
    pub folder: &'static str,
    /// What is in it.
    pub requirements: &'static [&'static str],
}

impl Environment {
    /// Makes it where it is missing or not what the requirements name today. `false`: there is no Python that can.
    pub fn is_ready(&self) -> bool {
        let Ok(required) = self.required() else {
            return false;
        };
        let is_made = std::fs::read(self.installed()).is_ok_and(|installed| installed == required);
        is_made || self.make(&required)
    }

    /// A program of the environment.
    pub fn program(&self, name: &str, arguments: &[&str]) -> Command {
        let mut command = Command::new(self.path(name));
        command.args(arguments);
        command
    }

    /// Where a program of the environment is, once it is made.
    pub fn path(&self, name: &str) -> PathBuf {
        in_target(self.folder).join("bin").join(name)
    }

    fn required(&self) -> std::io::Result<Vec<u8>> {
        let files: Result<Vec<_>, _> = self.requirements.iter().map(std::fs::read).collect();
        files.map(|files| files.concat())
    }

    fn make(&self, required: &[u8]) -> bool {
        let mut venv = Command::new(self.python);
        venv.args(["-m", "venv"]).arg(in_target(self.folder));
        let mut install = self.program("python", &["-m", "pip", "install", "--quiet"]);
        for file in self.requirements {
            install.args(["-r", file]);
        }
        succeeds(&mut venv)
            && succeeds(&mut install)
            && std::fs::write(self.installed(), required).is_ok()
    }

    fn installed(&self) -> PathBuf {
        in_target(self.folder).join("installed.txt")
    }
}

/// What is missing where no environment can be made.
pub const NO_PYTHON: &str = "python3 with venv, or what requirements.txt names, is missing";
