//! Scenarios that come with the program.

/// Names and texts of the files in `scenarios/`.
const SCENARIOS: [(&str, &str); 13] = [
    ("bad_compass", include_str!("../../scenarios/bad_compass.toml")),
    ("bad_link", include_str!("../../scenarios/bad_link.toml")),
    ("bad_rudder", include_str!("../../scenarios/bad_rudder.toml")),
    ("broken_fin", include_str!("../../scenarios/broken_fin.toml")),
    ("frozen_compass", include_str!("../../scenarios/frozen_compass.toml")),
    ("heavier_payload", include_str!("../../scenarios/heavier_payload.toml")),
    ("gremlins", include_str!("../../scenarios/gremlins.toml")),
    ("payload_swap", include_str!("../../scenarios/payload_swap.toml")),
    ("poor_compass", include_str!("../../scenarios/poor_compass.toml")),
    ("rough_sea", include_str!("../../scenarios/rough_sea.toml")),
    ("shoal", include_str!("../../scenarios/shoal.toml")),
    ("takeover", include_str!("../../scenarios/takeover.toml")),
    ("tidal_stream", include_str!("../../scenarios/tidal_stream.toml")),
];

/// The text of the scenario of this name, `bad_compass` or `scenarios/bad_compass.toml`.
pub(super) fn text_of(name: &str) -> Option<&'static str> {
    let name = name.strip_suffix(".toml").unwrap_or(name);
    let name = name.strip_prefix("scenarios/").unwrap_or(name);
    let mut scenarios = SCENARIOS.iter();
    let found = scenarios.find(|(of_it, _)| *of_it == name);
    found.map(|(_, text)| *text)
}

/// Names of all of them, each with the sentence that its file begins with.
pub(super) fn all() -> Vec<(&'static str, &'static str)> {
    let sentence = |text: &'static str| text.lines().next().unwrap_or_default();
    let about = |text| sentence(text).trim_start_matches("# ");
    SCENARIOS.iter().map(|(name, text)| (*name, about(text))).collect()
}

/// Names of all of them, for people.
pub(super) fn names() -> String {
    SCENARIOS.map(|(name, _)| name).join(", ")
}
