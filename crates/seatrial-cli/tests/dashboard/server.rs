//! A served dashboard, and who speaks with it.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Child, Stdio};
use std::time::{Duration, Instant};

use seatrial_dev::program;
use serde_json::{Value, json};
use tungstenite::client::IntoClientRequest;
use tungstenite::{Message, WebSocket};

/// Longer than anything here takes on a busy machine.
pub const PATIENCE: Duration = Duration::from_secs(60);

pub struct Server {
    pub child: Child,
    pub address: String,
    /// What it says on standard error up to its tokens.
    pub tokens: Vec<String>,
    pub token: Option<String>,
}

impl Server {
    pub fn start(folder: &Path, options: &[&str]) -> Self {
        let logbook = folder.join("seatrial.db");
        let mut child = program()
            .args(["serve", "--listen", "127.0.0.1:0", "--logbook"])
            .arg(&logbook)
            .args(options)
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let mut tokens = Vec::new();
        if options.contains(&"--require-token") {
            let said = BufReader::new(child.stderr.take().unwrap());
            let lines = said.lines().map_while(Result::ok);
            let words = lines.skip(1).take(2);
            tokens = words.map(|line| line.split_whitespace().last().unwrap().to_owned()).collect();
        }
        let mut line = String::new();
        BufReader::new(child.stdout.as_mut().unwrap()).read_line(&mut line).unwrap();
        let address = line.trim().trim_start_matches("http://").trim_end_matches('/').to_owned();
        Self { child, address, token: tokens.first().cloned(), tokens }
    }

    pub fn ask(&self, method: &str, path: &str) -> Request<'_> {
        Request {
            server: self,
            method: method.into(),
            path: format!("/api/v1{path}"),
            headers: Vec::new(),
            host: self.address.clone(),
            body: Vec::new(),
        }
    }

    /// Something outside the programming interface.
    pub fn ask_page(&self, path: &str) -> Request<'_> {
        Request { path: path.into(), ..self.ask("GET", "") }
    }

    pub fn get(&self, path: &str) -> Value {
        let (status, body) = self.ask("GET", path).send();
        assert_eq!(status, 200, "{path}: {body}");
        body
    }

    /// Takes control under a name; the lease.
    pub fn control(&self, name: &str) -> String {
        let (status, lease) = self.ask("POST", "/control").json(&json!({"name": name})).send();
        assert_eq!(status, 200, "{lease}");
        lease["lease"].as_str().unwrap().to_owned()
    }

    /// Starts a trial; the number of its campaign.
    pub fn start_trial(&self, lease: &str, order: &Value) -> i64 {
        let (status, trial) = self.ask("POST", "/trial").lease(lease).json(order).send();
        assert_eq!(status, 201, "{trial}");
        trial["campaign"].as_i64().unwrap()
    }

    pub fn wait_for_end(&self) -> Value {
        let begun = Instant::now();
        loop {
            let trial = self.get("/status")["trial"].clone();
            if trial["running"] == false {
                return trial;
            }
            assert!(begun.elapsed() < PATIENCE, "{trial}");
            std::thread::sleep(Duration::from_millis(20));
        }
    }

    pub fn viewer(&self, hello: &Value) -> Viewer {
        let mut request =
            format!("ws://{}/api/v1/live", self.address).into_client_request().unwrap();
        let origin = format!("http://{}", self.address).parse().unwrap();
        request.headers_mut().insert("origin", origin);
        let stream = TcpStream::connect(&self.address).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        let (mut socket, _) = tungstenite::client(request, stream).unwrap();
        socket.send(Message::text(hello.to_string())).unwrap();
        Viewer { socket }
    }

    /// Ends it as Ctrl-C does; the exit code.
    pub fn interrupt(mut self) -> Option<i32> {
        crate::signal::send(self.child.id(), "INT");
        self.child.wait().unwrap().code()
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

pub struct Request<'a> {
    server: &'a Server,
    method: String,
    path: String,
    headers: Vec<(String, String)>,
    host: String,
    body: Vec<u8>,
}

impl Request<'_> {
    pub fn header(mut self, name: &str, value: &str) -> Self {
        self.headers.push((name.into(), value.into()));
        self
    }

    pub fn host(mut self, host: &str) -> Self {
        self.host = host.into();
        self
    }

    pub fn lease(self, lease: &str) -> Self {
        self.header("seatrial-lease", lease)
    }

    pub fn json(mut self, body: &Value) -> Self {
        self.body = body.to_string().into_bytes();
        self.header("Content-Type", "application/json")
    }

    pub fn bytes(mut self, body: Vec<u8>) -> Self {
        self.body = body;
        self.header("Content-Type", "application/octet-stream")
    }

    /// Status and body, text where it is no JSON.
    pub fn send(self) -> (u16, Value) {
        let (status, body) = self.send_for_bytes();
        let text = String::from_utf8_lossy(&body).into_owned();
        (status, serde_json::from_slice(&body).unwrap_or(Value::String(text)))
    }

    pub fn send_for_bytes(self) -> (u16, Vec<u8>) {
        let mut stream = TcpStream::connect(&self.server.address).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        let mut head = format!(
            "{} {} HTTP/1.1\r\nHost: {}\r\nConnection: close\r\nContent-Length: {}\r\n",
            self.method,
            self.path,
            self.host,
            self.body.len()
        );
        if let Some(token) = &self.server.token {
            head += &format!("Authorization: Bearer {token}\r\n");
        }
        for (name, value) in &self.headers {
            head += &format!("{name}: {value}\r\n");
        }
        stream.write_all((head + "\r\n").as_bytes()).unwrap();
        // A body that is refused on the way is not read to its end.
        let _ = stream.write_all(&self.body);
        let mut answer = Vec::new();
        let _ = stream.read_to_end(&mut answer);
        let end = answer.windows(4).position(|four| four == b"\r\n\r\n").expect("a head");
        let head = String::from_utf8_lossy(&answer[..end]).into_owned();
        let status = head.split_whitespace().nth(1).unwrap().parse().unwrap();
        for expected in
            ["content-security-policy: default-src 'none'", "x-content-type-options: nosniff"]
        {
            assert!(head.contains(expected), "{head}");
        }
        (status, answer[end + 4..].to_vec())
    }
}

pub struct Viewer {
    pub socket: WebSocket<TcpStream>,
}

impl Viewer {
    pub fn next(&mut self) -> Value {
        loop {
            if let Message::Text(text) = self.socket.read().unwrap() {
                return serde_json::from_str(&text).unwrap();
            }
        }
    }

    /// Everything up to the first message that is wanted, and it.
    pub fn until(&mut self, is_wanted: impl Fn(&Value) -> bool) -> Vec<Value> {
        let begun = Instant::now();
        let mut seen = Vec::new();
        loop {
            let message = self.next();
            let found = is_wanted(&message);
            seen.push(message);
            if found {
                return seen;
            }
            assert!(begun.elapsed() < PATIENCE, "{:?}", seen.last());
        }
    }
}
