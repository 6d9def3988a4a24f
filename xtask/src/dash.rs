//! The dashboard's programming interface under schemathesis, which makes requests from its OpenAPI document.

use std::io::{BufRead, BufReader};
use std::process::Stdio;

use anyhow::{Context, Result, ensure};
use serde_json::json;

use crate::environment::Environment;
use crate::http::Client;
use crate::shell::{Run, command, shell};
use crate::workspace::{binary, in_target};

pub const ENVIRONMENT: Environment = Environment {
    python: "python3",
    folder: "python-dash",
    requirements: &["crates/seatrial-dash/tests/schemathesis/requirements.txt"],
};
const CONFIG: &str = "crates/seatrial-dash/tests/schemathesis/schemathesis.toml";
/// Its operation in the document.
const GIVES_CONTROL_BACK: &str = "release";

/// Tries the server of the binary that the tests built.
pub fn check() -> Result<()> {
    let schemathesis = ENVIRONMENT.program("schemathesis")?;
    let (seatrial, folder) = (binary(), in_target("schemathesis"));
    shell().remove_path(&folder)?;
    shell().create_dir(&folder)?;
    let logbook = folder.join("logbook.db");
    command!("{seatrial} trial --logbook {logbook}").read()?;
    let mut server = command!("{seatrial} serve --listen 127.0.0.1:0 --logbook {logbook}");
    let mut server = server.stdout(Stdio::piped()).stderr(Stdio::null()).begin()?;
    let mut url = String::new();
    let stdout = server.0.stdout.as_mut().context("no pipe")?;
    BufReader::new(stdout).read_line(&mut url)?;
    let address = url.trim().trim_start_matches("http://").trim_end_matches('/');
    // With control, so that commands are looked at.
    let control =
        Client::of(address)?.order("/api/v1/control", &json!({"name": "schemathesis"}))?;
    let lease = control["lease"].as_str().context("no lease")?;
    // Without control other commands would not be looked at: giving it back is tried last.
    for which in ["--exclude-operation-id", "--include-operation-id"] {
        command!("{schemathesis} --config-file {CONFIG} run http://{address}/api/v1/openapi.json {which} {GIVES_CONTROL_BACK}")
            .args(["--header", &format!("seatrial-lease: {lease}"), "--warnings", "off"])
            .run()?;
    }
    let ended = server.0.try_wait()?;
    ensure!(ended.is_none(), "the server did not outlive it: {ended:?}");
    Ok(())
}
