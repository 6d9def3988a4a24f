//! `seatrial identify`: a model from a log.

use std::fmt::Write;
use std::path::PathBuf;

use seatrial::Identification;
use seatrial::figures::three_figures;
use seatrial::identification::{
    HigherOrder, LagEffect, Online, Refined, RejectedSamples, Settings, Validation, Verdict,
};
use seatrial::identify::{IdentifyError, IdentifySettings};
use seatrial::record::Window;
use seatrial_core::Nomoto;
use seatrial_core::estimator::Method;
use seatrial_core::heading_loop::LoopTiming;
use serde::Serialize;

use crate::log::{LogArgs, OpenedLog, Source};
use crate::output::{Exit, Failure, Output};
use crate::pitch::{self, Axis};
use crate::speeds::{self, SpeedModel};
use crate::windows::{Logs, WindowArgs, failure};
use seatrial_core::RudderUnit;

/// Identify a yaw model from a log, validate it on fresh data and judge it.
#[derive(clap::Args, Debug)]
#[command(after_help = "\
Without windows the manoeuvres of the log are looked for: for each speed (thrust, where the log has it) the best excited
one trains, joined with others, and another one validates. A log without manoeuvres, or that is one, is for training
as a whole, and nothing is validated. The rudder's work is over for the estimator when the rudder has been laid
to both hands and comes back from the second.

Exit code 0: the model, or one of several, is accepted; 4: none is, and the verdict says why.

Example:
  seatrial sim log --seed 1 --out run.csv && seatrial identify run.csv")]
pub struct Args {
    #[command(flatten)]
    log: LogArgs,
    /// The axis: yaw, or pitch from the columns pitch_rad and elevator_rad, or those of --heading and --rudder.
    #[arg(long, value_name = "AXIS", default_value = "yaw")]
    axis: Axis,
    #[command(flatten)]
    windows: WindowArgs,
    #[command(flatten)]
    estimator: EstimatorArgs,
    /// Write the accepted models of a log with manoeuvres at several speeds as a schedule for `gains` and `turn`.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["WindowArgs", "as_paper"])]
    schedule: Option<PathBuf>,
    /// Keep the estimate after every sample in the JSON document.
    #[arg(long)]
    trace: bool,
}

/// How to estimate.
#[derive(clap::Args, Debug)]
pub struct EstimatorArgs {
    /// Pole of the state variable filter, rad/s, or `auto` to derive it from the data (the paper's 1
    /// with --as-paper).
    #[arg(long, value_name = "auto|RAD_S", default_value = "auto", value_parser = lambda, allow_negative_numbers = true)]
    lambda: Lambda,
    /// Equations (16)-(31) and the recursion to the letter, without refinement.
    #[arg(long)]
    as_paper: bool,
    /// The estimator that runs along [default: instrumental-variable, with --as-paper least-squares].
    #[arg(long, value_name = "METHOD")]
    online: Option<OnlineMethod>,
}

#[derive(Clone, Copy, Debug)]
enum Lambda {
    Auto,
    RadS(f64),
}

fn lambda(text: &str) -> Result<Lambda, String> {
    if text == "auto" {
        return Ok(Lambda::Auto);
    }
    match text.parse() {
        Ok(value) if value > 0.0 && f64::is_finite(value) => Ok(Lambda::RadS(value)),
        _ => Err("expected `auto` or a positive number of rad/s".into()),
    }
}

#[derive(Clone, Copy, Debug, clap::ValueEnum)]
enum OnlineMethod {
    /// Recursive least squares throughout.
    LeastSquares,
    /// Recursive least squares during the excitation, the instrumental variable after it.
    InstrumentalVariable,
}

/// `identify --json`.
#[derive(Serialize)]
pub struct Document<'a> {
    schema: &'static str,
    source: UsedSource,
    /// The other log, where there was one.
    validation_source: Option<Source>,
    training: Option<Window>,
    settings: Option<&'a Settings>,
    online: Option<&'a Online>,
    refined: Option<&'a Refined>,
    nomoto: Option<Nomoto<f64>>,
    validation: Option<Validation>,
    higher_order: Option<&'a HigherOrder>,
    lag_effect: Option<LagEffect>,
    loop_timing: Option<LoopTiming<f64>>,
    verdict: &'a Verdict,
    /// Of a log with several manoeuvres: the model of each speed; the model above is the surest of them.
    models: Option<&'a [SpeedModel]>,
}

#[derive(Serialize)]
struct UsedSource {
    #[serde(flatten)]
    source: Source,
    samples_used: usize,
    samples_rejected: u32,
    rejected: RejectedSamples,
}

/// Identifies a model from a log.
pub fn run(args: &Args, output: &Output) -> Result<Exit, Failure> {
    if args.axis == Axis::Pitch {
        return pitch::identify(&args.log, &args.windows, output);
    }
    let logs = args.windows.open(&args.log)?;
    let looks_for_manoeuvres = !args.windows.are_given() && !args.estimator.as_paper;
    let settings = args.estimator.settings(args.trace);
    let found = Found::of(&logs, &settings, looks_for_manoeuvres)?;
    if args.schedule.is_some() && found.models.is_none() {
        return Err(Failure::rejected(format!(
            "{}: --schedule: no manoeuvres to both hands were found in it, or it is a single one",
            logs.log.path.display()
        )));
    }
    output.print(&found.document(&logs), || found.text(&logs))?;
    if let Some((path, models)) = args.schedule.as_ref().zip(found.models.as_ref()) {
        speeds::save_schedule(path, models, logs.log.rudder_unit)?;
    }
    Ok(Exit::of(found.verdict()))
}

/// What was found in a log: a model of each speed, or one of the whole, or why there is none.
pub struct Found {
    models: Option<Vec<SpeedModel>>,
    single: Result<Box<Identification>, Verdict>,
}

impl Found {
    /// Looks for manoeuvres, where that is wanted, and for one model where there are none.
    pub fn of(
        logs: &Logs,
        settings: &IdentifySettings,
        looks_for_manoeuvres: bool,
    ) -> Result<Self, Failure> {
        if looks_for_manoeuvres && let Some(models) = speeds::identify(&logs.log, settings)? {
            let foremost = speeds::foremost(&models);
            let single = foremost.identification.clone();
            return Ok(Self {
                single: single.map(Box::new).ok_or_else(|| foremost.verdict.clone()),
                models: Some(models),
            });
        }
        let record = &logs.log.record;
        let single =
            match seatrial::identify::identify(record, logs.training, logs.fresh(), settings) {
                Ok(identification) => Ok(Box::new(identification)),
                Err(IdentifyError::Refused(reason)) => Err(Verdict::refused(reason)),
                Err(error) => return Err(failure(&logs.log, error)),
            };
        Ok(Self {
            models: None,
            single,
        })
    }

    /// The model, or the surest of several.
    pub fn identification(&self) -> Option<&Identification> {
        self.single.as_deref().ok()
    }

    fn verdict(&self) -> &Verdict {
        match &self.single {
            Ok(identification) => &identification.verdict,
            Err(verdict) => verdict,
        }
    }

    /// As `--json` prints it.
    pub fn document(&self, logs: &Logs) -> Document<'_> {
        let document = match &self.single {
            Ok(identification) => Document::of(logs, identification),
            Err(verdict) => Document::without_model(logs, verdict),
        };
        Document {
            models: self.models.as_deref(),
            ..document
        }
    }

    fn text(&self, logs: &Logs) -> String {
        let source = || source_text("Log", &logs.log);
        match (&self.models, &self.single) {
            (Some(models), _) => speeds::text(models, logs.log.rudder_unit) + &source(),
            (None, Ok(identification)) => page(logs, identification),
            (None, Err(verdict)) => verdict_text(verdict) + &source(),
        }
    }
}

impl EstimatorArgs {
    /// The settings that these options stand for.
    pub fn settings(&self, trace: bool) -> IdentifySettings {
        let base = if self.as_paper {
            IdentifySettings::paper()
        } else {
            IdentifySettings::default()
        };
        IdentifySettings {
            method: match self.online {
                Some(OnlineMethod::LeastSquares) => Method::LeastSquares,
                Some(OnlineMethod::InstrumentalVariable) => Method::InstrumentalVariable,
                None => base.method,
            },
            lambda_rad_s: match self.lambda {
                Lambda::Auto => None,
                Lambda::RadS(value) => Some(value),
            },
            trace,
            ..base
        }
    }
}

impl<'a> Document<'a> {
    /// Of one model.
    fn of(logs: &Logs, identification: &'a Identification) -> Self {
        Self {
            source: UsedSource {
                source: logs.log.source(),
                samples_used: identification.samples_used,
                samples_rejected: identification.samples_rejected.total(),
                rejected: identification.samples_rejected,
            },
            training: Some(identification.training),
            settings: Some(&identification.settings),
            online: Some(&identification.online),
            refined: identification.refined.as_ref(),
            nomoto: identification.nomoto,
            validation: identification.validation,
            higher_order: identification.higher_order.as_ref(),
            lag_effect: identification.lag_effect,
            loop_timing: identification.loop_timing,
            ..Self::without_model(logs, &identification.verdict)
        }
    }

    /// Where there is none.
    fn without_model(logs: &Logs, verdict: &'a Verdict) -> Self {
        Self {
            schema: "seatrial.identification.v1",
            source: UsedSource {
                source: logs.log.source(),
                samples_used: 0,
                samples_rejected: 0,
                rejected: RejectedSamples::default(),
            },
            validation_source: logs.validation_log.as_ref().map(OpenedLog::source),
            training: None,
            settings: None,
            online: None,
            refined: None,
            nomoto: None,
            validation: None,
            higher_order: None,
            lag_effect: None,
            loop_timing: None,
            verdict,
            models: None,
        }
    }
}

/// The page for people: the verdict first.
fn page(logs: &Logs, identification: &Identification) -> String {
    let mut text = verdict_text(&identification.verdict);
    text += &model_text(identification, logs.log.rudder_unit);
    text += &fresh_text(identification.validation);
    text += "\n";
    text += &source_text("Log", &logs.log);
    if let Some(other) = &logs.validation_log {
        text += &source_text("Fresh log", other);
    }
    text += &training_text(identification);
    text
}

/// Accepted or not, and each reason in a paragraph.
pub fn verdict_text(verdict: &Verdict) -> String {
    let mut text = String::from(if verdict.accepted {
        "ACCEPTED\n"
    } else {
        "REJECTED\n"
    });
    for reason in &verdict.reasons {
        let _ = writeln!(text, "  {}: {}", reason.code, reason.text);
    }
    text + "\n"
}

/// Parameters and intervals; `unit` is that of the rudder.
pub fn model_text(identification: &Identification, unit: RudderUnit) -> String {
    let model = identification.model();
    let intervals = identification.refined.as_ref().map(|r| r.interval_95);
    let delta0 = model.delta0_rad();
    let rows = [
        (
            "a22",
            Some(model.a22_per_s),
            "1/s",
            intervals.map(|i| i.a22_per_s),
        ),
        (
            "b2",
            Some(model.b2_per_s2),
            "1/s^2",
            intervals.map(|i| i.b2_per_s2),
        ),
        (
            "C0",
            Some(model.c0_rad_per_s2),
            "rad/s^2",
            intervals.map(|i| i.c0_rad_per_s2),
        ),
        (
            "delta0",
            delta0,
            match unit {
                RudderUnit::Rad => "rad",
                RudderUnit::FullRudder => "of full",
            },
            intervals.and_then(|i| i.delta0_rad),
        ),
    ];
    let rudder = match unit {
        RudderUnit::Rad => "",
        RudderUnit::FullRudder => " (full rudder is 1)",
    };
    let mut text = format!("Model       psi' = r, r' = a22 r + b2 rudder + C0{rudder}\n");
    for (name, value, unit, interval) in rows {
        let Some(value) = value else { continue };
        let value = three_figures(value);
        let interval = interval.map_or(String::new(), |[low, high]| {
            format!("  95 % {} to {}", three_figures(low), three_figures(high))
        });
        let _ = writeln!(text, "  {name:<8}  {value:>9} {unit:<8}{interval}");
    }
    if let Some(nomoto) = identification.nomoto {
        let _ = writeln!(
            text,
            "  Nomoto    T {} s, K {} 1/s{}",
            three_figures(nomoto.t_s),
            three_figures(nomoto.k_per_s),
            unit.per()
        );
    }
    text
}

/// R^2 on fresh data.
pub fn fresh_text(validation: Option<Validation>) -> String {
    let Some(validation) = validation else {
        return "Fresh data  none\n".into();
    };
    let r2 = |value: Option<f64>| value.map_or_else(|| "unknown".into(), |r2| format!("{r2:.3}"));
    format!(
        "Fresh data  {}, {} samples: R^2 of heading {}, with the offset estimated again {}, of yaw rate {}\n",
        span_text(validation.window),
        validation.samples,
        r2(validation.r2_heading),
        r2(validation.r2_heading_offset_refit),
        r2(validation.r2_yaw_rate),
    )
}

fn span_text(window: Window) -> String {
    format!("{:.2} s to {:.2} s", window.from_s, window.to_s)
}

/// Where the samples came from and what was assumed on the way.
pub fn source_text(title: &str, log: &OpenedLog) -> String {
    let servo = log.servo.map_or_else(String::new, |servo| {
        format!(", rudder behind the command by {servo}")
    });
    format!(
        "{title:<11} {}, {} samples read{servo}, sha256 {}\n",
        log.path.display(),
        log.counts.samples,
        log.sha256
    )
}

/// How the estimate was made.
pub fn training_text(identification: &Identification) -> String {
    let settings = &identification.settings;
    let online = &identification.online;
    let [a22, b2, c0] = online.model.theta().map(three_figures);
    let rejected = identification.samples_rejected;
    let mut text = format!(
        "Training    {}, {} samples used, {} rejected, {} gaps\n",
        span_text(identification.training),
        identification.samples_used,
        rejected.total(),
        rejected.gaps
    );
    let _ = writeln!(
        text,
        "Filter      lambda {} rad/s: {}",
        three_figures(settings.lambda_rad_s),
        settings.lambda_because
    );
    let _ = writeln!(
        text,
        "Online      {}: a22 {a22}, b2 {b2}, C0 {c0}; {}",
        online.method.words(),
        match online.convergence.detected_s {
            Some(after_s) => format!("converged (39) after {after_s:.2} s"),
            None => "not converged (39)".into(),
        }
    );
    if let Some(refined) = &identification.refined {
        let _ = writeln!(
            text,
            "Refined     {}; heading noise {} deg, yaw disturbance {} rad/s^2",
            refined.method.words(),
            three_figures(refined.heading_noise_rad.to_degrees()),
            three_figures(refined.disturbance_rad_s2)
        );
    }
    text
}
