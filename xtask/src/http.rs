//! Requests to a dashboard on this machine, as a browser and BlueOS send them.

use std::io::{Read, Write};
use std::net::TcpStream;
use std::time::Duration;

use serde_json::Value;

/// Longer than a long log takes on a busy machine.
const PATIENCE: Duration = Duration::from_secs(300);

/// A browser.
pub struct Client {
    /// The server, ADDRESS:PORT.
    pub address: String,
    /// The name that a person types.
    pub host: String,
    /// Sent to the programming interface.
    pub token: Option<String>,
}

impl Client {
    /// A browser without a token.
    pub fn of(address: &str) -> Self {
        Self {
            address: address.into(),
            host: address.into(),
            token: None,
        }
    }

    /// The body of the answer to GET.
    pub fn get(&self, path: &str) -> Result<String, String> {
        self.ask("GET", path, &[], &[])
    }

    /// The JSON document of the answer to POST.
    pub fn post(&self, path: &str, headers: &[(&str, &str)], body: &[u8]) -> Result<Value, String> {
        json(&self.ask("POST", path, headers, body)?)
    }

    fn ask(
        &self,
        method: &str,
        path: &str,
        headers: &[(&str, &str)],
        body: &[u8],
    ) -> Result<String, String> {
        let failed = |error: std::io::Error| format!("{method} {path}: {error}");
        let mut stream = TcpStream::connect(&self.address).map_err(failed)?;
        stream.set_read_timeout(Some(PATIENCE)).map_err(failed)?;
        let mut head = format!(
            "{method} {path} HTTP/1.1\r\nHost: {}\r\nConnection: close\r\nContent-Length: {}\r\n",
            self.host,
            body.len()
        );
        if let Some(token) = self.token.as_ref().filter(|_| path.starts_with("/api/")) {
            head += &format!("Authorization: Bearer {token}\r\n");
        }
        for (name, value) in headers {
            head += &format!("{name}: {value}\r\n");
        }
        let request = [(head + "\r\n").as_bytes(), body].concat();
        stream.write_all(&request).map_err(failed)?;
        let mut answer = Vec::new();
        stream.read_to_end(&mut answer).map_err(failed)?;
        let answer = String::from_utf8_lossy(&answer).into_owned();
        let (head, body) = answer.split_once("\r\n\r\n").unwrap_or_default();
        let status = head.split_whitespace().nth(1).unwrap_or("no answer");
        match status.starts_with('2') {
            true => Ok(body.to_owned()),
            false => Err(format!("{method} {path}: {status}: {body}")),
        }
    }
}

/// The document of an answer.
pub fn json(text: &str) -> Result<Value, String> {
    serde_json::from_str(text).map_err(|error| format!("no JSON: {error}: {text}"))
}
