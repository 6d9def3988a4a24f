//! Requests of a browser and of BlueOS.

use std::io::{Read, Write};
use std::net::{Ipv4Addr, TcpStream};
use std::time::Duration;

use serde_json::Value;

/// Longer than a long log takes on a busy machine.
const PATIENCE: Duration = Duration::from_secs(300);

pub struct Client {
    pub port: u16,
    /// The name that a person types.
    pub host: String,
    pub token: String,
}

impl Client {
    /// A file of the page, without a token.
    pub fn page(&self, path: &str) -> Result<String, String> {
        self.ask("GET", path, &[], &[])
    }

    pub fn get_text(&self, path: &str) -> Result<String, String> {
        let path = format!("/api/v1{path}");
        self.ask("GET", &path, &[("Authorization", &self.bearer())], &[])
    }

    pub fn get(&self, path: &str) -> Result<Value, String> {
        parsed(&self.get_text(path)?)
    }

    pub fn post(&self, path: &str, body: &Value, lease: Option<&str>) -> Result<Value, String> {
        let bearer = self.bearer();
        let mut headers = vec![
            ("Authorization", bearer.as_str()),
            ("Content-Type", "application/json"),
        ];
        headers.extend(lease.map(|lease| ("seatrial-lease", lease)));
        let path = format!("/api/v1{path}");
        parsed(&self.ask("POST", &path, &headers, body.to_string().as_bytes())?)
    }

    /// Sends a log.
    pub fn send(&self, path: &str, log: &[u8]) -> Result<Value, String> {
        let path = format!("/api/v1{path}");
        parsed(&self.ask("POST", &path, &[("Authorization", &self.bearer())], log)?)
    }

    fn bearer(&self) -> String {
        format!("Bearer {}", self.token)
    }

    fn ask(
        &self,
        method: &str,
        path: &str,
        headers: &[(&str, &str)],
        body: &[u8],
    ) -> Result<String, String> {
        let failed = |error: std::io::Error| format!("{method} {path}: {error}");
        let mut stream = TcpStream::connect((Ipv4Addr::LOCALHOST, self.port)).map_err(failed)?;
        stream.set_read_timeout(Some(PATIENCE)).map_err(failed)?;
        let mut head = format!(
            "{method} {path} HTTP/1.1\r\nHost: {}\r\nConnection: close\r\nContent-Length: {}\r\n",
            self.host,
            body.len()
        );
        for (name, value) in headers {
            head += &format!("{name}: {value}\r\n");
        }
        stream
            .write_all((head + "\r\n").as_bytes())
            .map_err(failed)?;
        stream.write_all(body).map_err(failed)?;
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

fn parsed(text: &str) -> Result<Value, String> {
    serde_json::from_str(text).map_err(|error| format!("no JSON: {error}: {text}"))
}
