//! How the numbers came about, for those who check them.

use sha2::{Digest, Sha256};

use super::Fact;
use super::number::{MISSING, decimals, percent, significant, spoken};
use seatrial::campaign::{Campaign, Stage};
use seatrial::identification::Identification;
use seatrial::{Record, Window};
use seatrial_core::{Envelope, Excitation, Manoeuvre, Plan};

/// How an identification was made.
pub(super) fn method(identification: &Identification) -> Vec<Fact> {
    let settings = &identification.settings;
    let rejected = identification.samples_rejected;
    let mut facts = vec![
        (
            "Samples",
            format!(
                "{} used, {} rejected, {} gaps",
                identification.samples_used,
                rejected.total(),
                rejected.gaps
            ),
        ),
        (
            "Live estimator",
            format!(
                "{}, filter pole λ = {} rad/s ({})",
                identification.online.method.words(),
                significant(settings.lambda_rad_s, 3),
                spoken(&settings.lambda_because.to_string())
            ),
        ),
    ];
    match &identification.refined {
        Some(refined) => {
            facts.push(("Final estimate", refined.method.words()));
            facts.push((
                "Noise found",
                format!(
                    "compass {}°, yaw disturbance {} rad/s²",
                    significant(refined.heading_noise_rad.to_degrees(), 2),
                    significant(refined.disturbance_rad_s2, 2)
                ),
            ));
        }
        None => facts.push(("Final estimate", "the live one; there are no intervals".to_owned())),
    }
    facts
}

/// SHA-256 over the samples as they were recorded, in hexadecimal.
pub(super) fn fingerprint(records: &[&Record]) -> String {
    let mut digest = Sha256::new();
    for sample in records.iter().flat_map(|record| &record.samples) {
        let known = [sample.time_s, sample.heading_rad, sample.rudder_rad];
        let optional = [
            sample.surge_speed_m_s,
            sample.depth_m,
            sample.altitude_m,
            sample.roll_rad,
            sample.pitch_rad,
            sample.yaw_rate_rad_s,
            sample.north_m,
            sample.east_m,
        ];
        for value in known.into_iter().map(Some).chain(optional) {
            digest.update(value.unwrap_or(f64::NAN).to_le_bytes());
        }
    }
    digest.finalize().iter().map(|b| format!("{b:02x}")).collect()
}

/// What was recorded of a campaign.
pub(super) fn of_campaign(campaign: &Campaign) -> Vec<Fact> {
    let records: Vec<&Record> = campaign.runs.iter().map(|run| &run.record).collect();
    let samples: usize = records.iter().map(|record| record.samples.len()).sum();
    let thrusts: Vec<String> = {
        let mut thrusts: Vec<f64> = campaign.runs.iter().map(|run| run.thrust).collect();
        thrusts.dedup();
        thrusts.into_iter().map(percent).collect()
    };
    vec![
        ("Software", format!("seatrial {}", campaign.software_version)),
        ("Vehicle", campaign.vehicle.clone()),
        ("Configuration", campaign.configuration.clone()),
        (
            "Seed of the simulation",
            campaign.seed.map_or_else(|| MISSING.to_owned(), |seed| seed.to_string()),
        ),
        (
            "Rudder limit",
            format!(
                "{}° ({} rad)",
                decimals(campaign.rudder_limit_rad.to_degrees(), 1),
                decimals(campaign.rudder_limit_rad, 3)
            ),
        ),
        ("Thrusts as run", thrusts.join(", ")),
        ("Stages as run", stages_as_run(campaign)),
        ("Samples", format!("{samples} in {} runs", campaign.runs.len())),
        ("SHA-256 of all samples", fingerprint(&records)),
    ]
}

/// Mean duration of each stage.
fn stages_as_run(campaign: &Campaign) -> String {
    let stages =
        [(Stage::Settle, "settle"), (Stage::Train, "train"), (Stage::Validate, "validate")];
    let texts = stages.into_iter().filter_map(|(stage, name)| {
        let windows = campaign.runs.iter().filter_map(|run| run.stage(stage));
        let durations: Vec<f64> = windows.map(|w: Window| w.to_s - w.from_s).collect();
        let mean = durations.iter().sum::<f64>() / durations.len() as f64;
        mean.is_finite().then(|| format!("{name} {} s", decimals(mean, 1)))
    });
    let texts: Vec<String> = texts.collect();
    if texts.is_empty() { MISSING.to_owned() } else { format!("{} (mean)", texts.join(", ")) }
}

/// What a trial was told to do, one line for each setting that a person chooses.
pub(super) fn plan(plan: &Plan<f64>) -> Vec<Fact> {
    let thrusts: Vec<String> = plan.thrusts.iter().map(|thrust| percent(*thrust)).collect();
    let [shortest, longest] =
        [plan.settle.at_least_s, plan.settle.at_most_s].map(|time_s| significant(time_s, 3));
    let mut facts = vec![
        ("Speeds, thrust", thrusts.join(", ")),
        ("Settle", format!("{shortest} to {longest} s")),
        ("Train", manoeuvre(&plan.training)),
        ("Validate", manoeuvre(&plan.validation)),
        ("Largest rudder", degrees(plan.rudder_limit_rad)),
        (
            "Accepted from R²",
            format!(
                "{}, repeated {} times at most",
                decimals(plan.accept_from_r2, 2),
                plan.max_repeats
            ),
        ),
    ];
    facts.extend(limits(&plan.envelope));
    facts
}

fn degrees(angle_rad: f64) -> String {
    format!("{}°", decimals(angle_rad.to_degrees(), 1))
}

/// The limits within which a trial went on.
fn limits(limits: &Envelope<f64>) -> [Fact; 5] {
    [
        (
            "Depth",
            format!(
                "{} to {} m, {} m above the bottom",
                decimals(limits.depth_min_m, 1),
                decimals(limits.depth_max_m, 1),
                decimals(limits.altitude_min_m, 1)
            ),
        ),
        (
            "Roll, pitch at most",
            format!("{}, {}", degrees(limits.roll_max_rad), degrees(limits.pitch_max_rad)),
        ),
        (
            "Turning at most",
            format!(
                "{}/s, {} from the heading of the run",
                degrees(limits.yaw_rate_max_rad_s),
                degrees(limits.heading_excursion_max_rad)
            ),
        ),
        ("Change of speed at most", percent(limits.speed_drift_max)),
        (
            "Area",
            match limits.area.len() {
                0 => "anywhere".to_owned(),
                corners => format!("within {corners} corners"),
            },
        ),
    ]
}

/// A manoeuvre in a line: what the rudder does and for how long.
fn manoeuvre(manoeuvre: &Manoeuvre<f64>) -> String {
    let excitation = &manoeuvre.excitation;
    let kind = match excitation {
        Excitation::Doublet { .. } => "doublet",
        Excitation::ThreeTwoOneOne { .. } => "3-2-1-1",
        Excitation::Switched { .. } => "deflections to alternating sides",
        Excitation::Multisine { .. } => "multisine",
    };
    let seconds = |time_s: f64| significant(time_s, 3);
    format!(
        "{kind} of {}° over {} s, after {} s of steady course and before {} s of it",
        decimals(excitation.amplitude_rad().to_degrees(), 1),
        seconds(excitation.duration_s()),
        seconds(manoeuvre.lead_in_s),
        seconds(manoeuvre.observe_s)
    )
}
