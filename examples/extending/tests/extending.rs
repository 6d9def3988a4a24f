//! What the pages in docs/extending/ promise.

use std::fmt::Write as _;
use std::io::{self, Read, Write};
use std::path::Path;

use seatrial::identify::{IdentifySettings, identify, validation};
use seatrial::{Record, Window};
use seatrial_app::{Options, identify_log};
use seatrial_core::model::YawState;
use seatrial_core::{List, Outcome, Plan, Sample, Trial, Vehicle, YawModel};
use seatrial_extending::text_boat::{self, TextBoat};
use seatrial_extending::{helm, integrated};
use seatrial_logs::{ChannelChoice, Format, open};
use seatrial_sim::{FirstOrderVehicle, VehicleConfig};

/// Of the simulated vehicle at the thrust of these tests.
const A22_PER_S: f64 = -1.07;
const B2_PER_S2: f64 = 1.08;

fn plan() -> Plan<f64> {
    Plan {
        thrusts: List::from_slice(&[0.8]).unwrap(),
        max_repeats: 0,
        ..Plan::paper()
    }
}

/// A trial at one speed: a manoeuvre to train, one to validate.
fn simulated(config: VehicleConfig, seed: u64) -> Vec<Sample<f64>> {
    let mut vehicle = FirstOrderVehicle::new(config, seed).unwrap();
    let mut trial = Trial::new(plan()).unwrap();
    let mut samples = Vec::new();
    while let Some(sample) = vehicle.next_sample().unwrap() {
        samples.push(sample);
        let action = trial.step(&sample);
        vehicle.act(&action).unwrap();
        if action.outcome.is_some() {
            break;
        }
    }
    samples
}

/// A recording of the made-up autopilot.
fn write_helm(path: &Path, seed: u64) {
    let mut text = "HELMLOG 1\n".to_owned();
    let tenths = |angle_rad: f64| (10.0 * angle_rad.to_degrees()).round();
    for sample in simulated(VehicleConfig::starfish(), seed) {
        let milliseconds = (1000.0 * sample.time_s).round();
        let heading = tenths(sample.heading_rad.rem_euclid(std::f64::consts::TAU));
        let to_port = -tenths(sample.rudder_rad);
        writeln!(text, "{milliseconds} SERVO {to_port}").unwrap();
        let rate = tenths(sample.yaw_rate_rad_s.unwrap_or(0.0));
        writeln!(text, "{milliseconds} COMPASS {heading:04} {rate}").unwrap();
    }
    std::fs::write(path, text).unwrap();
}

#[test]
fn recover_a_log_of_an_own_format_is_identified_as_any_other() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.hlm");
    write_helm(&path, 1);
    let mut options = Options::default();
    options.reading.channels.formats = helm::formats();
    let found = identify_log(&path, &options).unwrap();
    assert_eq!(
        found.verdict().outcome().name(),
        "use",
        "{:?}",
        found.verdict()
    );
    let [speed] = found.models.as_deref().unwrap() else {
        panic!("{:?}", found.models);
    };
    // Four times the standard deviation that the vehicle's noise leaves.
    let model = speed.identification.as_ref().unwrap().model();
    assert!((model.a22_per_s - A22_PER_S).abs() < 0.1, "{model:?}");
    assert!((model.b2_per_s2 - B2_PER_S2).abs() < 0.1, "{model:?}");
}

#[test]
fn io_damage_to_a_log_of_an_own_format_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.hlm");
    write_helm(&path, 1);
    let mut text = std::fs::read_to_string(&path).unwrap();
    let whole = text.len();
    text.insert_str(10 + text[10..].find('\n').unwrap(), "\nnoise");
    text.truncate(whole - 3);
    std::fs::write(&path, text).unwrap();
    let mut choice = ChannelChoice::default();
    choice.formats = helm::formats();
    let mut log = open(&path, &choice).unwrap();
    assert_eq!(log.description().format, Format::Other("helm".into()));
    assert!(log.by_ref().all(|sample| sample.is_ok()));
    let warnings = log.warnings().join("; ");
    assert!(warnings.contains("1 places are no messages"), "{warnings}");
    assert!(warnings.contains("cut off"), "{warnings}");
    // Without the format it is text, and no columns are known.
    assert!(open(&path, &ChannelChoice::default()).is_err());
}

/// Plays the boat at the other end: twenty lines a second, as the paper's plan asks for, a rudder that acts from the next line on.
struct Played {
    yaw: YawModel<f64>,
    state: YawState<f64>,
    rudder_rad: f64,
    commanded: Commanded,
    time_ms: u32,
    unread: Vec<u8>,
    commands: String,
}

#[derive(Clone, Copy)]
enum Commanded {
    Rudder(f64),
    Hold(f64),
}

impl Played {
    fn obey(&mut self) {
        for line in std::mem::take(&mut self.commands).lines() {
            let (word, number) = line.split_once(' ').unwrap();
            let angle_rad = (number.parse::<f64>().unwrap() / 10.0).to_radians();
            match word {
                "RUDDER" => self.commanded = Commanded::Rudder(angle_rad),
                "HOLD" => self.commanded = Commanded::Hold(angle_rad),
                _ => assert_eq!(word, "THRUST"),
            }
        }
    }
}

impl Read for Played {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        if self.unread.is_empty() {
            self.obey();
            self.state = self.yaw.advance(self.state, self.rudder_rad, 0.05);
            self.time_ms += 50;
            self.rudder_rad = match self.commanded {
                Commanded::Rudder(rudder_rad) => rudder_rad,
                Commanded::Hold(heading_rad) => {
                    let ahead_rad = heading_rad - self.state.heading_rad;
                    (0.5 * ahead_rad - 0.5 * self.state.yaw_rate_rad_s).clamp(-0.2, 0.2)
                }
            };
            let tenths = |angle_rad: f64| (10.0 * angle_rad.to_degrees()).round();
            self.unread = format!(
                "{} {} {}\n",
                self.time_ms,
                tenths(self.state.heading_rad),
                tenths(self.rudder_rad)
            )
            .into_bytes();
        }
        let count = buffer.len().min(self.unread.len());
        buffer[..count].copy_from_slice(&self.unread[..count]);
        self.unread.drain(..count);
        Ok(count)
    }
}

impl Write for Played {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.commands += std::str::from_utf8(bytes).unwrap();
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

fn played() -> TextBoat<Played> {
    TextBoat::new(Played {
        yaw: YawModel::from_theta([A22_PER_S, B2_PER_S2, 0.012]),
        state: YawState::default(),
        rudder_rad: 0.0,
        commanded: Commanded::Rudder(0.0),
        time_ms: 0,
        unread: Vec::new(),
        commands: String::new(),
    })
}

#[test]
fn recover_a_trial_on_an_own_vehicle_ends_in_its_model() {
    let mut boat = played();
    let (runs, outcome) = text_boat::run(&mut boat, plan()).unwrap();
    assert_eq!(outcome, Some(Outcome::Finished));
    let [run] = runs.as_slice() else {
        panic!("{runs:?}");
    };
    assert!(run.accepted, "{run:?}");
    // Angles in tenths of a degree are all the noise there is.
    let model = run.model;
    assert!((model.a22_per_s - A22_PER_S).abs() < 0.05, "{model:?}");
    assert!((model.b2_per_s2 - B2_PER_S2).abs() < 0.05, "{model:?}");
}

/// The two manoeuvres of a trial.
fn halves(samples: &[Sample<f64>]) -> [Window; 2] {
    let half_s = 0.5 * (samples[0].time_s + samples[samples.len() - 1].time_s);
    let window = |from_s, to_s| Window { from_s, to_s };
    [
        window(f64::NEG_INFINITY, half_s),
        window(half_s, f64::INFINITY),
    ]
}

#[test]
fn exact_the_integrated_estimator_gives_a_noise_free_vehicle_back() {
    let samples = simulated(VehicleConfig::starfish().noise_free(), 1);
    let record: Record = samples.iter().copied().collect();
    let [training, checked] = halves(&samples);
    let model = integrated::model(record.window(training)).unwrap();
    // Trapezoids of the heading at the paper's interval.
    assert!((model.a22_per_s - A22_PER_S).abs() < 0.02, "{model:?}");
    assert!((model.b2_per_s2 - B2_PER_S2).abs() < 0.02, "{model:?}");
    let judged = validation::validate(model, &record, checked).unwrap();
    assert!(judged.r2_heading.unwrap() > 0.99, "{judged:?}");
    assert_eq!(integrated::model(&samples[..4]), None);
}

/// Root mean squares of the errors of b2 over twenty trials: the integrated estimator's and that of `identify`.
#[test]
fn recover_the_page_names_the_error_of_the_integrated_estimator_and_of_identify() {
    let mut squares = [0.0, 0.0];
    for seed in 1..=20 {
        let samples = simulated(VehicleConfig::starfish(), seed);
        let record: Record = samples.iter().copied().collect();
        let [training, _] = halves(&samples);
        let own = integrated::model(record.window(training)).unwrap();
        let settings = IdentifySettings::default();
        let best = identify(&record, training, None, &settings)
            .unwrap()
            .model();
        for (sum, model) in squares.iter_mut().zip([own, best]) {
            *sum += (model.b2_per_s2 - B2_PER_S2).powi(2) / 20.0;
        }
    }
    let [own, best] = squares.map(f64::sqrt);
    let figures = format!("{own:.3} 1/s^2 for this one and {best:.3} for `identify`");
    let page = include_str!("../../../docs/extending/estimator.md");
    assert!(page.contains(&figures), "{figures}: {own} {best}");
}
