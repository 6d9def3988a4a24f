//! The container file, and its command at work. No image is built here; tests hold against each other what BlueOS reads of the file.

mod at_work;
mod sandbox;

use anyhow::Result;

use crate::shell::shell;
use crate::workspace::root;

pub use at_work::check as check_at_work;

/// Most memory at work, bytes.
const MEMORY: u64 = 100 << 20;

fn text() -> Result<String> {
    Ok(shell().read_file(root().join("packaging/Containerfile"))?)
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

/// The user's number.
fn user(text: &str) -> Option<&str> {
    instructions(text, "USER").last()?.split(':').next()
}

#[cfg(test)]
mod tests {
    use serde_json::Value;

    use super::*;

    /// The value of a label without its quotes.
    fn label<'a>(text: &'a str, name: &'a str) -> Option<&'a str> {
        instructions(text, "LABEL")
            .find_map(|line| line.strip_prefix(name)?.strip_prefix('='))
            .map(|value| value.trim_matches(['"', '\'']))
    }

    fn faults(text: &str) -> Vec<String> {
        let json = |name: &str| {
            let value = serde_json::from_str(label(text, name)?);
            value.ok().filter(|value: &Value| value.is_array() || value.is_object())
        };
        let mut ids = instructions(text, "USER").last().unwrap_or("root").split(':');
        let is_user = ids.all(|id| id.parse::<u32>().is_ok_and(|id| id > 0));
        let has_version = label(text, "version") == Some(env!("CARGO_PKG_VERSION"));
        let mut faults = runtime_faults(text, &json("permissions").unwrap_or_default());
        for name in ["type", "requirements", "readme"] {
            faults.push((label(text, name).is_none(), format!("no label {name}")));
        }
        for name in ["tags", "authors", "company", "links"] {
            faults.push((
                json(name).is_none(),
                format!("the label {name} is no JSON list or object"),
            ));
        }
        faults.push((!has_version, "the label version is not that of the workspace".into()));
        faults.push((!is_user, "USER is not a number other than root's".into()));
        let found = faults.into_iter().filter(|(is_found, _)| *is_found);
        found.map(|(_, fault)| fault).collect()
    }

    /// Whether ports, memory and volume are not as they should be, with what to say then. What the command does with them is tried at work.
    fn runtime_faults(text: &str, permissions: &Value) -> Vec<(bool, String)> {
        let host = &permissions["HostConfig"];
        let is_open = |port: &str| {
            permissions["ExposedPorts"][port].is_object() && host["PortBindings"][port].is_array()
        };
        let listens = |port: &str| {
            let address = format!(":{}", port.trim_end_matches("/tcp"));
            arguments(text).iter().any(|word| word.ends_with(&address))
        };
        let mut ports = instructions(text, "EXPOSE");
        let binds = host["Binds"].to_string();
        // Docker makes a folder of the host that is not there as root's, and a volume as the image's folder is.
        let is_volume = binds.contains(":/data\"") && !binds.contains("\"/");
        let faults = [
            (!ports.all(is_open), "a port is exposed that the permissions do not open"),
            (
                !instructions(text, "EXPOSE").all(listens),
                "the command does not listen on the exposed port",
            ),
            (host["Memory"].as_u64() != Some(MEMORY), "the memory is not limited to 100 MiB"),
            (!host["Privileged"].is_null(), "an extension is not privileged"),
            (!is_volume, "/data is a folder of the host, which the user may not write, or none"),
        ];
        faults.map(|(is_found, fault)| (is_found, fault.to_owned())).into()
    }

    #[test]
    fn exact_the_container_file_is_consistent() {
        assert_eq!(faults(&text().unwrap()), Vec::<String>::new());
    }

    #[test]
    fn exact_contradictions_in_a_container_file_are_found() {
        for (part, by, fault) in [
            ("USER 1000:1000", "USER root", "USER is not"),
            ("EXPOSE 8042", "EXPOSE 80", "a port is exposed"),
            ("0.0.0.0:8042", "0.0.0.0:80", "does not listen"),
            ("104857600", "1", "memory"),
            ("tags='[", "tags='", "the label tags"),
            ("seatrial:/data", "/var/seatrial:/data", "folder of the host"),
            ("version=\"", "version=\"9", "the label version"),
        ] {
            let faults = faults(&text().unwrap().replacen(part, by, 1));
            assert!(faults.iter().any(|found| found.contains(fault)), "{part}: {faults:?}");
        }
    }
}
