//! Which crate may know which.

use serde_json::Value;

use crate::workspace::{packages, text};

/// The floor of each crate. An arrow runs from a crate down to the floors below it.
const FLOORS: [(&str, u8); 15] = [
    ("seatrial-core", 1),
    ("seatrial-mavlink", 1),
    ("seatrial", 2),
    ("seatrial-logs", 2),
    ("seatrial-links", 2),
    ("seatrial-logbook", 2),
    ("seatrial-report", 2),
    ("seatrial-sim", 2),
    ("seatrial-app", 3),
    ("seatrial-cli", 4),
    ("seatrial-dash", 4),
    ("seatrial-py", 4),
    ("seatrial-wasm", 4),
    ("seatrial-ffi", 4),
    ("seatrial-lab", 4),
];

/// The project's own tools: they may know every crate, and only tests may know them.
const TOOLS: [&str; 4] = ["seatrial-dev", "seatrial-instructions", "seatrial-parity", "xtask"];

/// Arrows along a floor that the plan draws.
const ALONG_A_FLOOR: [(&str, &str); 4] = [
    ("seatrial-logbook", "seatrial"),
    ("seatrial-report", "seatrial"),
    ("seatrial-cli", "seatrial-dash"),
    ("seatrial-lab", "seatrial-cli"),
];

/// Whether errors of a crate may be plain text: only where they are shown to a person.
pub fn is_edge(package: &str) -> bool {
    TOOLS.contains(&package) || floor(package) == Some(4)
}

fn floor(package: &str) -> Option<u8> {
    let found = FLOORS.iter().find(|(name, _)| *name == package);
    found.map(|(_, floor)| *floor)
}

/// Packages without a floor, and dependencies up, sideways or on a tool. Dependencies of tests are free.
pub fn violations(metadata: &Value) -> Vec<String> {
    let packages = packages(metadata);
    let is_ours = |name: &str| packages.iter().any(|ours| ours["name"] == name);
    let mut violations = Vec::new();
    for package in packages {
        let name = text(package, "name");
        if TOOLS.contains(&name) {
            continue;
        }
        let Some(from) = floor(name) else {
            violations.push(format!(
                "{name} has no floor: add it to FLOORS in xtask/src/house/floors.rs"
            ));
            continue;
        };
        for dependency in package["dependencies"].as_array().into_iter().flatten() {
            let to = text(dependency, "name");
            if dependency["kind"] == "dev" || !is_ours(to) || ALONG_A_FLOOR.contains(&(name, to)) {
                continue;
            }
            match floor(to) {
                Some(below) if below < from => {}
                Some(floor) => violations
                    .push(format!("{name} (floor {from}) depends on {to} (floor {floor})")),
                None => violations.push(format!("{name} depends on the tool {to}")),
            }
        }
    }
    violations
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn exact_arrows_up_sideways_and_from_nowhere_are_reported() {
        let depends_on = |name: &str, on: &[(&str, Value)]| {
            let on: Vec<_> =
                on.iter().map(|(name, kind)| json!({"name": name, "kind": kind})).collect();
            json!({"name": name, "dependencies": on})
        };
        let packages = [
            depends_on("seatrial-core", &[("seatrial", Value::Null)]),
            depends_on("seatrial", &[("seatrial-sim", "dev".into()), ("serde", Value::Null)]),
            depends_on("seatrial-sim", &[("seatrial", Value::Null)]),
            depends_on("seatrial-report", &[("seatrial", Value::Null)]),
            depends_on("seatrial-new", &[]),
        ];
        let found = violations(&json!({"packages": packages}));
        assert_eq!(found.len(), 3, "{found:?}");
        assert!(found[0].starts_with("seatrial-core (floor 1) depends on seatrial (floor 2)"));
        assert!(found[1].starts_with("seatrial-sim (floor 2) depends on seatrial (floor 2)"));
        assert!(found[2].starts_with("seatrial-new has no floor"));
    }
}
