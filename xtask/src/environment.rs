//! Python environments of the project's own, and steps that a machine cannot take.

use std::path::Path;
use std::process::Command;

use crate::succeeds;

/// A virtual environment with what a file of requirements names.
pub struct Environment {
    /// Where it is.
    pub folder: &'static str,
    /// What is in it.
    pub requirements: &'static str,
}

impl Environment {
    /// Makes it where it is missing or not what the requirements name today. `false`: there is no Python that can.
    pub fn is_ready(&self) -> bool {
        self.is_made() || self.make()
    }

    /// A program of the environment.
    pub fn program(&self, name: &str, arguments: &[&str]) -> Command {
        let program = std::path::absolute(Path::new(self.folder).join("bin").join(name));
        let mut command = Command::new(program.unwrap_or_default());
        command.args(arguments);
        command
    }

    fn is_made(&self) -> bool {
        let installed = std::fs::read(self.installed());
        installed.is_ok_and(|installed| {
            std::fs::read(self.requirements).is_ok_and(|now| now == installed)
        })
    }

    fn make(&self) -> bool {
        let mut venv = Command::new("python3");
        venv.args(["-m", "venv", self.folder]);
        let install = ["-m", "pip", "install", "--quiet", "-r", self.requirements];
        succeeds(&mut venv)
            && succeeds(&mut self.program("python", &install))
            && std::fs::copy(self.requirements, self.installed()).is_ok()
    }

    fn installed(&self) -> std::path::PathBuf {
        Path::new(self.folder).join("installed.txt")
    }
}

/// A step for which something is missing: said and skipped; with `CI=true` a failure.
pub fn skipped(step: &str, missing: &str) -> Result<(), String> {
    match std::env::var("CI").as_deref() {
        Ok("true") => Err(missing.into()),
        _ => {
            eprintln!("== {step} skipped: {missing}");
            Ok(())
        }
    }
}

/// What is missing where no environment can be made.
pub const NO_PYTHON: &str = "python3 with venv, or what requirements.txt names, is missing";
