//! The dashboard's programming interface under schemathesis, which makes requests from its OpenAPI document.

use std::io::{BufRead, BufReader};
use std::process::{Child, Command, Stdio};

use crate::environment::{Environment, NO_PYTHON, PYTHON};
use crate::http::Client;
use crate::steps::{run, skipped};
use crate::target::{binary, in_target};

const ENVIRONMENT: Environment = Environment {
    python: PYTHON,
    folder: "python-dash",
    requirements: &["crates/seatrial-dash/tests/schemathesis/requirements.txt"],
};
const CONFIG: &str = "crates/seatrial-dash/tests/schemathesis/schemathesis.toml";
/// Its operation in the document.
const GIVES_CONTROL_BACK: &str = "release";
const LOGBOOK: &str = "schemathesis.db";

/// Makes the environment where it is missing.
pub fn prepare() {
    ENVIRONMENT.is_ready();
}

/// Makes the environment where it is missing and tries the server of the binary that the tests built. Where there is no Python that
/// can, this is said and skipped; with `CI=true` it is a failure.
pub fn check() -> Result<(), String> {
    if !ENVIRONMENT.is_ready() {
        return skipped("schemathesis", NO_PYTHON);
    }
    for suffix in ["", "-wal", "-shm"] {
        let _ = std::fs::remove_file(in_target(format!("{LOGBOOK}{suffix}")));
    }
    let mut trial = Command::new(binary());
    trial
        .args(["trial", "--logbook"])
        .arg(in_target(LOGBOOK))
        .stdout(Stdio::null());
    run(&mut trial, "seatrial trial")?;
    let mut server = Served::start()?;
    let schema = format!("http://{}/api/v1/openapi.json", server.address);
    let lease = format!("seatrial-lease: {}", server.control()?);
    // Without control other commands would not be looked at: giving it back is tried last.
    for which in ["--exclude-operation-id", "--include-operation-id"] {
        let arguments = [
            "--config-file",
            CONFIG,
            "run",
            &schema,
            which,
            GIVES_CONTROL_BACK,
            "--header",
            &lease,
            "--warnings",
            "off",
        ];
        run(
            &mut ENVIRONMENT.program("schemathesis", &arguments),
            format!("schemathesis {which} {GIVES_CONTROL_BACK}"),
        )?;
    }
    match server.process.try_wait() {
        Ok(None) => Ok(()),
        ended => Err(format!("the server did not outlive it: {ended:?}")),
    }
}

/// A server of the binary that the tests built, ended when dropped.
struct Served {
    process: Child,
    address: String,
}

impl Served {
    fn start() -> Result<Self, String> {
        let mut process = Command::new(binary())
            .args(["serve", "--listen", "127.0.0.1:0", "--logbook"])
            .arg(in_target(LOGBOOK))
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .map_err(|error| format!("{}: {error}; build it first", binary().display()))?;
        let mut url = String::new();
        if let Some(stdout) = &mut process.stdout {
            BufReader::new(stdout)
                .read_line(&mut url)
                .map_err(|error| error.to_string())?;
        }
        let address = url
            .trim()
            .trim_start_matches("http://")
            .trim_end_matches('/');
        Ok(Self {
            process,
            address: address.into(),
        })
    }

    /// Takes control, so that commands are looked at; the lease.
    fn control(&self) -> Result<String, String> {
        let client = Client::of(&self.address);
        let name = br#"{"name":"schemathesis"}"#;
        let answer = client.post(
            "/api/v1/control",
            &[("Content-Type", "application/json")],
            name,
        )?;
        let lease = answer["lease"].as_str();
        lease.map(String::from).ok_or_else(|| answer.to_string())
    }
}

impl Drop for Served {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}
