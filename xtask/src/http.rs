//! Requests to a dashboard on this machine, as a browser and BlueOS send them, by curl.

use std::path::Path;

use anyhow::{Context, Result, ensure};
use serde_json::Value;

use crate::shell::{Run, command, has};
use crate::steps::missing;

/// Longer than a long log takes on a busy machine, s.
const PATIENCE: &str = "300";

/// A browser.
pub struct Client {
    address: String,
    /// The name that a person types, NAME:PORT.
    pub host: String,
    /// Headers of every request.
    pub headers: Vec<String>,
}

impl Client {
    /// A browser of the server at ADDRESS:PORT.
    pub fn of(address: &str) -> Result<Self> {
        if !has("curl") {
            return missing("curl is missing");
        }
        Ok(Self { address: address.into(), host: address.into(), headers: Vec::new() })
    }

    /// The body of the answer to GET.
    pub fn get(&self, path: &str) -> Result<String> {
        self.ask(path, &[])
    }

    /// The answer to GET, a JSON document.
    pub fn document(&self, path: &str) -> Result<Value> {
        json(&self.get(path)?)
    }

    /// The JSON document of the answer to POST of a file.
    pub fn post(&self, path: &str, file: &Path) -> Result<Value> {
        let content = format!("@{}", file.display());
        json(&self.ask(
            path,
            &["--data-binary", &content, "-H", "Content-Type: application/octet-stream"],
        )?)
    }

    /// The JSON document of the answer to POST of another one.
    pub fn order(&self, path: &str, body: &Value) -> Result<Value> {
        json(&self.ask(
            path,
            &["--data-raw", &body.to_string(), "-H", "Content-Type: application/json"],
        )?)
    }

    /// The files that the page names, each with its text.
    pub fn page(&self) -> Result<Vec<(String, String)>> {
        let page = self.get("/")?;
        let named = page.split("\"./").skip(1).filter_map(|rest| rest.split('"').next());
        let files = named.filter(|name| name.starts_with("assets/"));
        let files = files.map(|name| Ok((name.to_owned(), self.get(&format!("/{name}"))?)));
        let files: Vec<_> = files.collect::<Result<_>>()?;
        ensure!(!files.is_empty(), "the page names no files:\n{page}");
        Ok(files)
    }

    fn ask(&self, path: &str, more: &[&str]) -> Result<String> {
        let (host, address) = (&self.host, &self.address);
        let headers = self.headers.iter().flat_map(|header| ["-H", header]);
        command!("curl --silent --show-error --fail-with-body --max-time {PATIENCE} --connect-to ::{address} {headers...} {more...} http://{host}{path}").read()
    }
}

fn json(text: &str) -> Result<Value> {
    serde_json::from_str(text).with_context(|| format!("no JSON: {text}"))
}
