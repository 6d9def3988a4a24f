//! How fast logs are read, beside the formats' own libraries in Python and plain readers in Rust.
//!
//! `cargo run --release -- FOLDER` makes large logs in FOLDER from the logs in `native` of the shared data
//! (`SEATRIAL_DATA`) and reads each in a process of its own with every reader; `SEATRIAL_PYTHON` names a
//! Python with `requirements.txt` installed. What is printed is what was read, the
//! processor time it took and the peak memory.

mod make;

use std::env;
use std::error::Error;
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::Command;

use mavlink::dialects::ardupilotmega::MavMessage;
use seatrial_logs::{ChannelChoice, open};

type Outcome<T> = Result<T, Box<dyn Error>>;

const FORMATS: [&str; 3] = ["bin", "tlog", "mcap"];
/// The fastest run counts: others share the machine.
const RUNS: usize = 3;
/// Sizes of the logs: one that Python reads within minutes, one on which memory is measured.
const SIZES_MB: [u64; 2] = [50, 2000];

fn main() -> Outcome<()> {
    let arguments: Vec<String> = env::args().skip(1).collect();
    match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["read", reader, file] => read(reader, Path::new(file)),
        [folder] => compare(Path::new(folder)),
        _ => Err("usage: seatrial-bench FOLDER".into()),
    }
}

/// Reads a log to its end and prints messages or samples, seconds of processor time and MB of memory.
fn read(reader: &str, file: &Path) -> Outcome<()> {
    let is_mcap = file.extension().is_some_and(|suffix| suffix == "mcap");
    let count = match reader {
        "seatrial" => {
            let mut samples = 0_u64;
            for sample in open(file, &ChannelChoice::default())? {
                sample?;
                samples += 1;
            }
            samples
        }
        _ if is_mcap => {
            let map = unsafe { memmap2::Mmap::map(&File::open(file)?) }?;
            let mut messages = 0;
            for message in mcap::MessageStream::new(&map)? {
                messages += u64::from(!message?.data.is_empty());
            }
            messages
        }
        "ardupilot-binlog" => {
            let entries = ardupilot_binlog::File::open(file)?.entries()?;
            entries.filter(Result::is_ok).count() as u64
        }
        "mavlink" => {
            let mut reader = mavlink::MavlinkReader::with_capacity(1 << 16, File::open(file)?);
            let mut messages = 0;
            while reader.read_any_message::<MavMessage>().is_ok() {
                messages += 1;
            }
            messages
        }
        _ => return Err(format!("no reader {reader}").into()),
    };
    println!("{count} {:.3} {:.0}", processor_s()?, peak_mb()?);
    Ok(())
}

/// Time that this process had a processor, so that what else runs counts for nothing.
fn processor_s() -> Outcome<f64> {
    let text = fs::read_to_string("/proc/self/schedstat")?;
    let ns = text.split_whitespace().next().ok_or("no schedstat")?;
    Ok(ns.parse::<f64>()? / 1e9)
}

/// The most memory that this process held.
fn peak_mb() -> Outcome<f64> {
    let status = fs::read_to_string("/proc/self/status")?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let kb = line.and_then(|line| line.split_whitespace().next());
    Ok(kb.ok_or("no VmHWM")?.parse::<f64>()? / 1e3)
}

fn compare(folder: &Path) -> Outcome<()> {
    let data = env::var_os("SEATRIAL_DATA").map_or("../../shared/data".into(), PathBuf::from);
    let python = env::var("SEATRIAL_PYTHON").unwrap_or("python3".into());
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("read.py");
    let own = env::current_exe()?;
    fs::create_dir_all(folder)?;
    println!("| log | reader | read | processor s | MB/s | peak memory MB |");
    println!("|---|---|---|---|---|---|");
    for format in FORMATS {
        for megabytes in SIZES_MB {
            let log = folder.join(format!("{megabytes}.{format}"));
            if !log.exists() {
                let unfinished = folder.join("unfinished");
                make::log(format, &data.join("native"), &unfinished, megabytes * 1_000_000)?;
                fs::rename(unfinished, &log)?;
            }
            let crate_name = match format {
                "bin" => "ardupilot-binlog",
                "tlog" => "mavlink",
                _ => "mcap",
            };
            let mut readers = vec!["seatrial"];
            if megabytes == SIZES_MB[0] {
                readers.extend([crate_name, "python"]);
            }
            for reader in readers {
                let runs = if reader == "python" { 1 } else { RUNS };
                let mut fastest: Option<(f64, String, String)> = None;
                for _ in 0..runs {
                    let mut command = match reader {
                        "python" => Command::new(&python),
                        _ => Command::new(&own),
                    };
                    match reader {
                        "python" => command.arg(&script),
                        _ => command.args(["read", reader]),
                    };
                    let output = command.arg(&log).output()?;
                    let text = String::from_utf8_lossy(&output.stdout).into_owned();
                    let [count, seconds, peak] = text.split_whitespace().collect::<Vec<_>>()[..]
                    else {
                        let message = String::from_utf8_lossy(&output.stderr);
                        return Err(format!("{reader} {}: {message}", log.display()).into());
                    };
                    let seconds: f64 = seconds.parse()?;
                    if fastest.as_ref().is_none_or(|(least, ..)| seconds < *least) {
                        fastest = Some((seconds, count.into(), peak.into()));
                    }
                }
                let (seconds, count, peak) = fastest.ok_or("no run")?;
                let speed = fs::metadata(&log)?.len() as f64 / 1e6 / seconds;
                println!(
                    "| {megabytes} MB {format} | {reader} | {count} | {seconds:.3} | {speed:.0} | {peak} |"
                );
            }
        }
    }
    Ok(())
}
