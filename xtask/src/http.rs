//! Requests to a dashboard on this machine, as a browser and BlueOS send them.

use std::io::{Read, Write};
use std::net::TcpStream;
use std::time::Duration;

use anyhow::{Context, Result, bail, ensure};
use serde_json::Value;

/// Longer than a long log takes on a busy machine.
const PATIENCE: Duration = Duration::from_secs(300);

/// A browser.
pub struct Client {
    /// The server, ADDRESS:PORT.
    pub address: String,
    /// The name that a person types.
    pub host: String,
    /// Headers of every request, each with its line end.
    pub headers: String,
}

impl Client {
    /// A browser without a token.
    pub fn of(address: &str) -> Self {
        Self {
            address: address.into(),
            host: address.into(),
            headers: String::new(),
        }
    }

    /// The body of the answer to GET.
    pub fn get(&self, path: &str) -> Result<String> {
        self.ask("GET", path, "text/plain", &[])
    }

    /// The answer to GET, a JSON document.
    pub fn document(&self, path: &str) -> Result<Value> {
        json(&self.get(path)?)
    }

    /// The JSON document of the answer to POST of bytes.
    pub fn post(&self, path: &str, body: &[u8]) -> Result<Value> {
        json(&self.ask("POST", path, "application/octet-stream", body)?)
    }

    /// The JSON document of the answer to POST of another one.
    pub fn order(&self, path: &str, body: &Value) -> Result<Value> {
        json(&self.ask(
            "POST",
            path,
            "application/json",
            body.to_string().as_bytes(),
        )?)
    }

    /// The page and the files that it names, each with its text.
    pub fn page(&self) -> Result<Vec<(String, String)>> {
        let page = self.get("/")?;
        let named = page
            .split("\"./")
            .skip(1)
            .filter_map(|rest| rest.split('"').next());
        let files = named.filter(|name| name.starts_with("assets/"));
        let files = files.map(|name| Ok((name.to_owned(), self.get(&format!("/{name}"))?)));
        let files: Vec<_> = files.collect::<Result<_>>()?;
        ensure!(!files.is_empty(), "the page names no files:\n{page}");
        Ok(files)
    }

    fn ask(&self, method: &str, path: &str, kind: &str, body: &[u8]) -> Result<String> {
        let asked = || format!("{method} {path}");
        let mut stream = TcpStream::connect(&self.address).with_context(asked)?;
        stream.set_read_timeout(Some(PATIENCE))?;
        let (host, length) = (&self.host, body.len());
        let head = format!(
            "{method} {path} HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\nContent-Type: {kind}\r\nContent-Length: {length}\r\n{}\r\n",
            self.headers
        );
        stream
            .write_all(&[head.as_bytes(), body].concat())
            .with_context(asked)?;
        let mut answer = Vec::new();
        stream.read_to_end(&mut answer).with_context(asked)?;
        let answer = String::from_utf8_lossy(&answer);
        let (head, body) = answer.split_once("\r\n\r\n").unwrap_or_default();
        match head.split(' ').nth(1).unwrap_or("no answer") {
            status if status.starts_with('2') => Ok(body.to_owned()),
            status => bail!("{method} {path}: {status}: {body}"),
        }
    }
}

fn json(text: &str) -> Result<Value> {
    serde_json::from_str(text).with_context(|| format!("no JSON: {text}"))
}
