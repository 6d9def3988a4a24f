//! The container file: what BlueOS reads of it, and whether its parts agree; and its command at work. No image is built here.

mod at_work;
mod router;
mod sandbox;

use serde_json::Value;

pub use at_work::check as check_at_work;

const FILE: &str = "packaging/Containerfile";
/// Most memory at work, bytes.
const MEMORY: u64 = 100 << 20;

/// Fails on a container file whose labels, ports and command contradict each other.
pub fn check() -> Result<(), String> {
    let text = std::fs::read_to_string(FILE).map_err(|error| format!("{FILE}: {error}"))?;
    let faults = faults(&text);
    match faults.is_empty() {
        true => Ok(()),
        false => Err(faults.join("\n")),
    }
}

/// The arguments of an instruction, each time that it is there.
fn instructions<'a>(text: &'a str, name: &'a str) -> impl Iterator<Item = &'a str> {
    let lines = text.lines().filter(|line| !line.starts_with('#'));
    lines.filter_map(move |line| line.strip_prefix(name)?.strip_prefix(' '))
}

/// The words of the command.
fn arguments(text: &str) -> Vec<String> {
    let command = instructions(text, "CMD").last().unwrap_or_default();
    serde_json::from_str(command).unwrap_or_default()
}

/// The value of a label without its quotes.
fn label<'a>(text: &'a str, name: &'a str) -> Option<&'a str> {
    instructions(text, "LABEL")
        .find_map(|line| line.strip_prefix(name)?.strip_prefix('='))
        .map(|value| value.trim_matches(['"', '\'']))
}

/// Faults that are found one after another.
#[derive(Default)]
struct Faults(Vec<String>);

impl Faults {
    fn needs(&mut self, holds: bool, what: &str) {
        if !holds {
            self.0.push(format!("{FILE}: {what}"));
        }
    }
}

fn faults(text: &str) -> Vec<String> {
    let mut faults = Faults::default();
    in_labels(text, &mut faults);
    at_run_time(text, &mut faults);
    faults.0
}

/// A label that is JSON.
fn json(text: &str, name: &str) -> Option<Value> {
    label(text, name).and_then(|value| serde_json::from_str(value).ok())
}

/// What the store of extensions shows.
fn in_labels(text: &str, faults: &mut Faults) {
    let mut needs = |holds, what: &str| faults.needs(holds, what);
    let version = label(text, "version");
    needs(
        version == Some(env!("CARGO_PKG_VERSION")),
        "the label version is not that of the workspace",
    );
    for name in ["type", "requirements", "readme"] {
        needs(label(text, name).is_some(), &format!("no label {name}"));
    }
    for name in ["tags", "authors"] {
        let is_list = json(text, name).is_some_and(|value| value.is_array());
        needs(is_list, &format!("the label {name} is no JSON list"));
    }
    for name in ["company", "links"] {
        let is_object = json(text, name).is_some_and(|value| value.is_object());
        needs(is_object, &format!("the label {name} is no JSON object"));
    }
}

/// User, port, memory and volume.
fn at_run_time(text: &str, faults: &mut Faults) {
    let mut needs = |holds, what: &str| faults.needs(holds, what);
    let user = instructions(text, "USER").last().unwrap_or("root");
    let is_numbered = user
        .split(':')
        .all(|id| id.parse::<u32>().is_ok_and(|id| id > 0));
    needs(is_numbered, "USER is not a number other than root's");
    let permissions = json(text, "permissions").unwrap_or_default();
    let host = &permissions["HostConfig"];
    for port in instructions(text, "EXPOSE") {
        let is_open = permissions["ExposedPorts"][port].is_object();
        needs(
            is_open && host["PortBindings"][port].is_array(),
            "a port is exposed that the permissions do not open",
        );
        let number = port.split('/').next().unwrap_or_default();
        let listens = instructions(text, "CMD").any(|line| line.contains(&format!(":{number}\"")));
        needs(listens, "the command does not listen on the exposed port");
    }
    let memory = host["Memory"].as_u64();
    needs(
        memory == Some(MEMORY),
        "the memory is not limited to 100 MiB",
    );
    needs(
        host["Privileged"].is_null(),
        "an extension is not privileged",
    );
    let binds = host["Binds"].to_string();
    let keeps = arguments(text)
        .iter()
        .any(|argument| argument.starts_with("/data/"));
    needs(
        keeps && binds.contains(":/data\""),
        "the logbook is not on the volume",
    );
    // Docker makes a folder of the host that is not there as root's, and a volume as the image's folder is.
    needs(
        !binds.contains("\"/"),
        "the volume is a folder of the host, which the user may not write",
    );
    let places_files = instructions(text, "ENV").any(|line| line == "TMPDIR=/data");
    needs(
        places_files,
        "files that are dropped on the page have no place: ENV TMPDIR=/data",
    );
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text() -> String {
        let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR"))
            .join("..")
            .join(FILE);
        std::fs::read_to_string(path).unwrap()
    }

    #[test]
    fn exact_the_container_file_is_consistent() {
        assert_eq!(faults(&text()), Vec::<String>::new());
    }

    #[test]
    fn exact_contradictions_in_a_container_file_are_found() {
        for (part, by, fault) in [
            ("USER 1000:1000", "USER root", "USER is not"),
            ("EXPOSE 8042", "EXPOSE 80", "a port is exposed"),
            ("0.0.0.0:8042", "0.0.0.0:80", "does not listen"),
            ("104857600", "1", "memory"),
            ("tags='[", "tags='", "the label tags"),
            ("/data/seatrial.db", "/tmp/seatrial.db", "not on the volume"),
            (
                "seatrial:/data",
                "/var/seatrial:/data",
                "folder of the host",
            ),
            ("TMPDIR=/data", "TMPDIR=/tmp", "no place"),
            ("version=\"", "version=\"9", "the label version"),
        ] {
            let faults = faults(&text().replacen(part, by, 1));
            assert!(
                faults.iter().any(|found| found.contains(fault)),
                "{part}: {faults:?}"
            );
        }
    }
}
