//! A vehicle of one's own: a boat whose autopilot speaks lines of text over a serial port or a socket.
//!
//! ```text
//! boat  12000 0471 -035     milliseconds, heading and the rudder that acts from now on, in tenths of a degree
//! we    RUDDER 120          tenths of a degree, positive to starboard
//! we    HOLD 0471           the autopilot keeps this heading
//! we    THRUST 60           percent
//! ```

use std::io::{self, BufRead, BufReader, Read, Write};

use seatrial_core::{Action, Event, Outcome, Plan, RunResult, Sample, Steering, Trial, Vehicle};

/// What a line of the boat says.
fn sample(line: &str) -> Option<Sample<f64>> {
    let mut words = line.split_whitespace();
    let mut next = || words.next()?.parse::<i32>().ok().map(f64::from);
    Some(Sample {
        time_s: next()? / 1000.0,
        heading_rad: (next()? / 10.0).to_radians(),
        rudder_rad: (next()? / 10.0).to_radians(),
        ..Sample::default()
    })
}

/// The lines that an action is.
fn commands(action: &Action<f64>) -> String {
    let tenths = |angle_rad: f64| (10.0 * angle_rad.to_degrees()).round();
    let steering = match action.steering {
        Steering::Rudder(rudder_rad) => format!("RUDDER {}\n", tenths(rudder_rad)),
        Steering::HoldHeading(heading_rad) => format!("HOLD {}\n", tenths(heading_rad)),
    };
    let thrust = action.thrust.map_or(String::new(), |thrust| {
        format!("THRUST {:.0}\n", 100.0 * thrust)
    });
    steering + &thrust
}

/// The boat at the other end of a link.
pub struct TextBoat<L: Read + Write> {
    link: BufReader<L>,
}

impl<L: Read + Write> TextBoat<L> {
    /// Over an open link.
    pub fn new(link: L) -> Self {
        Self {
            link: BufReader::new(link),
        }
    }

    fn send(&mut self, lines: &str) -> io::Result<()> {
        self.link.get_mut().write_all(lines.as_bytes())
    }
}

impl<L: Read + Write> Vehicle<f64> for TextBoat<L> {
    type Error = io::Error;

    fn next_sample(&mut self) -> io::Result<Option<Sample<f64>>> {
        loop {
            let mut line = String::new();
            if self.link.read_line(&mut line)? == 0 {
                return Ok(None);
            }
            // A damaged line is passed over: the trial's guard knows how long it may be without samples.
            if let Some(sample) = sample(&line) {
                return Ok(Some(sample));
            }
        }
    }

    fn act(&mut self, action: &Action<f64>) -> io::Result<()> {
        self.send(&commands(action))
    }

    fn is_live(&self) -> bool {
        true
    }
}

/// Whatever ends the program, the boat does not go on turning.
impl<L: Read + Write> Drop for TextBoat<L> {
    fn drop(&mut self) {
        let _ = self.send("RUDDER 0\nTHRUST 0\n");
    }
}

/// Runs a trial: the runs with their results, and how it ended.
pub fn run<L: Read + Write>(
    boat: &mut TextBoat<L>,
    plan: Plan<f64>,
) -> io::Result<(Vec<RunResult<f64>>, Option<Outcome>)> {
    let mut trial = Trial::new(plan).map_err(io::Error::other)?;
    let mut runs = Vec::new();
    while trial.outcome().is_none() {
        let Some(sample) = boat.next_sample()? else {
            break;
        };
        let action = trial.step(&sample);
        boat.act(&action)?;
        while let Some(event) = trial.take_event() {
            if let Event::RunFinished { result, .. } = event {
                runs.push(result);
            }
        }
    }
    Ok((runs, trial.outcome()))
}
