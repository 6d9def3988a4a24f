//! Python environments of the project's own.

use std::path::PathBuf;

use anyhow::Result;

use crate::shell::{Run, command, shell};
use crate::steps::missing;
use crate::workspace::in_target;

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
    /// A program of the environment, which is made where it is missing or not what the requirements name today.
    pub fn program(&self, name: &str) -> Result<PathBuf> {
        let required: Vec<_> = self
            .requirements
            .iter()
            .map(|file| shell().read_file(file))
            .collect::<Result<_, _>>()?;
        let installed = in_target(self.folder).join("installed.txt");
        if shell().read_file(&installed).ok() != Some(required.concat()) {
            if self.make().is_err() {
                let what = self.requirements.join(" or ");
                return missing(format!(
                    "{} with venv, or what {what} names, is missing",
                    self.python
                ));
            }
            shell().write_file(installed, required.concat())?;
        }
        Ok(self.path(name))
    }

    /// Where a program of the environment is, once it is made.
    pub fn path(&self, name: &str) -> PathBuf {
        in_target(self.folder).join("bin").join(name)
    }

    fn make(&self) -> Result<()> {
        let (maker, folder, python) = (self.python, in_target(self.folder), self.path("python"));
        command!("{maker} -m venv {folder}").run()?;
        let files = self.requirements.iter().flat_map(|file| ["-r", file]);
        command!("{python} -m pip install --quiet {files...}").run()
    }
}
