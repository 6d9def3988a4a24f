//! `seatrial fleet` of object stores: an S3 server that is not ours (moto), behind a proxy that cuts connections, and a server of HTTPS.
#![cfg(unix)]

use std::fs::{self, File};
use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Command, Output, Stdio};

use parquet::file::reader::{FileReader, SerializedFileReader};
use seatrial_dev::{program, python_with};
use serde_json::Value;

/// How many logs are stored, unless `SEATRIAL_FLEET_LOGS` says so: enough for all threads, few enough for every run of the tests.
const LOGS: usize = 24;
const CUTS: usize = 2;

/// The servers and a folder with logs, which lie in the bucket, too.
struct Store {
    folder: tempfile::TempDir,
    ports: Value,
    server: Child,
    orders: ChildStdin,
    answers: BufReader<ChildStdout>,
    logs: usize,
}

impl Drop for Store {
    fn drop(&mut self) {
        let _ = self.server.kill();
        let _ = self.server.wait();
    }
}

impl Store {
    /// `None`: there is no moto.
    fn new() -> Option<Self> {
        let python = python_with("moto.server, cryptography")?;
        let folder = tempfile::tempdir().unwrap();
        let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/objects/store.py");
        let mut server = Command::new(python)
            .arg(script)
            .arg(folder.path())
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let mut answers = BufReader::new(server.stdout.take().unwrap());
        let mut line = String::new();
        answers.read_line(&mut line).unwrap();
        let stated = std::env::var("SEATRIAL_FLEET_LOGS");
        let mut store = Self {
            orders: server.stdin.take().unwrap(),
            ports: serde_json::from_str(&line).unwrap(),
            folder,
            server,
            answers,
            logs: stated.map_or(LOGS, |count| count.parse().unwrap()),
        };
        fs::create_dir(store.folder.path().join("logs")).unwrap();
        for number in 0..store.logs {
            let name = format!("logs/run{number:04}.csv");
            let log = store.path(&name);
            let seed = (number % LOGS).to_string();
            match number < LOGS {
                true => {
                    let args = ["sim", "log", "--thrust", "0.8", "--seed", &seed, "--out", &log];
                    assert!(program().args(args).output().unwrap().status.success());
                }
                false => {
                    let first = format!("logs/run{:04}.csv", number % LOGS);
                    fs::hard_link(store.path(&first), &log).unwrap();
                }
            }
            store.order(&format!("put {name} {log}"));
        }
        let bad = store.path("logs/bad.csv");
        fs::write(&bad, "time,heading\n").unwrap();
        store.order(&format!("put logs/bad.csv {bad}"));
        store.order(&format!("put logs/notes.md {bad}"));
        Some(store)
    }

    fn path(&self, name: &str) -> String {
        self.folder.path().join(name).to_str().unwrap().to_owned()
    }

    fn order(&mut self, order: &str) -> String {
        writeln!(self.orders, "{order}").unwrap();
        let mut answer = String::new();
        self.answers.read_line(&mut answer).unwrap();
        answer.trim().to_owned()
    }

    /// A job whose S3 is behind a port.
    fn fleet(&self, port: &str, input: &str, out: &str) -> Output {
        let endpoint = format!("http://127.0.0.1:{}", self.ports[port]);
        let mut command = program();
        command
            .args(["fleet", "--json", "--estimate", "online", input, "--out", out])
            .current_dir(self.folder.path())
            .env("AWS_ENDPOINT_URL", endpoint)
            .env("AWS_ALLOW_HTTP", "true")
            .env("AWS_ACCESS_KEY_ID", "someone")
            .env("AWS_SECRET_ACCESS_KEY", "secret")
            .env("SSL_CERT_FILE", self.path("certificate.pem"));
        command.output().unwrap()
    }

    fn done(&self, port: &str, input: &str, out: &str) -> Value {
        let said = self.fleet(port, input, out);
        assert_eq!(said.status.code(), Some(0), "{said:?}");
        serde_json::from_slice(&said.stdout).unwrap()
    }

    fn stored_table(&mut self, key: &str) -> Vec<u8> {
        let copy = self.path("copy.parquet");
        assert_eq!(self.order(&format!("get {key} {copy}")), "done");
        fs::read(copy).unwrap()
    }
}

/// Every cell of a table but where and when its log was found.
fn cells(table: &Path) -> Vec<Vec<(String, String)>> {
    let table = SerializedFileReader::new(File::open(table).unwrap()).unwrap();
    let rows = table.get_row_iter(None).unwrap();
    let cells = rows.map(|row| {
        let cells = row.unwrap().into_columns().into_iter();
        let name = |path: &str| path.rsplit('/').next().unwrap_or_default().to_owned();
        cells
            .filter(|(column, _)| !["modified", "etag"].contains(&column.as_str()))
            .map(|(column, cell)| match column.as_str() {
                "source" | "error_text" => (column, name(&cell.to_string())),
                _ => (column, cell.to_string()),
            })
            .collect()
    });
    cells.collect()
}

/// From a bucket to a bucket, with connections cut in the middle of logs: the rows of local files, and twice the same bytes. Again, only
/// what the store calls another version is read.
#[test]
fn io_logs_in_a_bucket_give_the_rows_of_local_files_whatever_is_cut() {
    let Some(mut store) = Store::new() else {
        return;
    };
    let logs = store.logs + 1;
    let local = store.path("local.out");
    let alone = store.done("s3", "logs", &local);
    let (bucket, out) = ("s3://boats/logs", "s3://boats/tables/fleet.parquet");
    let whole = store.done("s3", bucket, out);
    assert_eq!(whole["logs"], logs);
    assert_eq!((&whole["errors"], &whole["passed_over"]), (&1.into(), &1.into()));
    assert_eq!(whole["manoeuvres"], alone["manoeuvres"]);
    let table = store.stored_table("tables/fleet.parquet");
    assert_eq!(cells(Path::new(&local)), cells(Path::new(&store.path("copy.parquet"))));
    assert!(!Path::new(&store.path("fleet.parquet.journal")).exists());

    store.order(&format!("cut {CUTS}"));
    store.done("proxy", "s3://boats/logs/*.csv", "s3://boats/cut/fleet.parquet");
    assert_eq!(store.order("left"), "0");
    assert!(store.stored_table("cut/fleet.parquet") == table);

    // The bad one is tried again.
    let again = store.done("s3", bucket, out);
    assert_eq!(again["done_before"], logs - 1);
    assert!(store.stored_table("tables/fleet.parquet") == table);
    let (first, second) = (store.path("logs/run0000.csv"), store.path("logs/run0001.csv"));
    store.order(&format!("put logs/run0000.csv {second}"));
    let changed = store.done("s3", bucket, out);
    assert_eq!(changed["done_before"], logs - 2);
    // Written again as it was: the time is another, the version is not.
    store.order(&format!("put logs/run0000.csv {second}"));
    assert_eq!(store.done("s3", bucket, out)["done_before"], logs - 1);
    store.order(&format!("put logs/run0000.csv {first}"));
    store.done("s3", bucket, out);
    let rows = cells(Path::new(&local));
    store.stored_table("tables/fleet.parquet");
    assert_eq!(rows, cells(Path::new(&store.path("copy.parquet"))));
}

/// Logs of a list from a server of HTTPS; and what is said of one that is not there, of a bucket and of a server. An address
/// with a secret is refused, and one without encryption, but on this machine.
#[test]
fn io_logs_of_a_web_server_and_what_is_said_of_missing_ones() {
    let Some(store) = Store::new() else {
        return;
    };
    let server = format!("https://127.0.0.1:{}", store.ports["https"]);
    let list = format!("{server}/logs/run0000.csv\n{server}/logs/run0001.csv\n{server}/none.csv\n");
    fs::write(store.path("list.txt"), list).unwrap();
    let done = store.done("s3", "@list.txt", "web.out");
    assert_eq!((&done["logs"], &done["errors"]), (&3.into(), &1.into()));
    assert_eq!(done["error_codes"]["unreadable"], 1);
    // Without a version, the time that the server tells decides.
    assert_eq!(store.done("s3", "@list.txt", "web.out")["done_before"], 2);

    let no_bucket = store.fleet("s3", "s3://none/logs", "none.out");
    let said = String::from_utf8(no_bucket.stderr).unwrap();
    assert_eq!(no_bucket.status.code(), Some(3), "{said}");
    assert!(said.contains("s3://none/logs: ") && said.contains("AWS_ENDPOINT_URL"), "{said}");
    let folder = store.fleet("s3", &format!("{server}/logs/"), "none.out");
    let said = String::from_utf8(folder.stderr).unwrap();
    assert!(said.contains("@LIST"), "{said}");
    let plain = format!("http://0.0.0.0:{}/boats/logs/run0000.csv", store.ports["s3"]);
    let told = server.replace("//", "//someone:secret@");
    for (secret, expected) in [
        (format!("{server}/logs/run0000.csv?key=secret"), "read a bucket by s3://"),
        (format!("{told}/logs/run0000.csv"), "read a bucket by s3://"),
        (plain, "plain http is for this machine alone"),
    ] {
        let refused = store.fleet("s3", &secret, "none.out");
        let said = String::from_utf8(refused.stderr).unwrap();
        assert_eq!(refused.status.code(), Some(3), "{said}");
        assert!(said.contains(expected) && !Path::new(&store.path("none.out")).exists(), "{said}");
    }
    // The table's place is looked at before the work.
    let foreign = store.fleet("s3", "logs", "s3://boats/logs/run0000.csv");
    let said = String::from_utf8(foreign.stderr).unwrap();
    assert_eq!(foreign.status.code(), Some(2), "{said}");
    assert!(said.contains("s3://boats/logs/run0000.csv: not written"), "{said}");
}
