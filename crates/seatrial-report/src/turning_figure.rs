//! Turning limits over speed.

use seatrial_core::authority::{AuthorityFit, AuthorityForm};
use seatrial_core::schedule::SchedulePoint;
use seatrial_core::turning::{RadiusMinimum, Side, Turn, TurningOverSpeed};

use super::Figure;
use super::axis::extent;
use super::chart::{Chart, Layer, Mark, Panel};
use super::number::decimals;
use super::speed_figures::{Speed, evenly, identified, points};

/// Radii, yaw rate and time of a U-turn over speed, to both sides (Fig. 14).
pub(super) fn turning(speeds: &[Speed], rudder_limit_rad: f64) -> Option<Figure> {
    let turning = Turning::new(&points(speeds), rudder_limit_rad)?;
    let [slowest, fastest] = turning.with_constant.authority.speed_range_m_s;
    let [from, to] = turning.shown_m_s;
    let minimum = turning.with_constant.minimum_radius(from, to).ok();
    let minimum = minimum.flatten();
    let minimum_words = minimum.as_ref().map_or(String::new(), minimum_sentence);
    let chart = Chart {
        alt: format!(
            "Turning radii, yaw rate and U-turn time from {} to {} metres per second; identified from {} to {}.{minimum_words}",
            decimals(from, 1),
            decimals(to, 1),
            decimals(slowest, 2),
            decimals(fastest, 2)
        ),
        x_label: "Speed, m/s",
        x_range: [from, to],
        spans: vec![identified(slowest, fastest)],
        marks: minimum
            .map(|minimum| Mark { at: minimum.surge_speed_m_s, label: "least radius".to_owned() })
            .into_iter()
            .collect(),
        panels: turning.panels(),
    };
    Some(Figure::new(
        &chart,
        format!(
            "Turning under full rudder ({}°). Dots: each identified speed with its own offset, to either side; lines: mean damping and fitted \
             authority, without offset. Only the shaded speeds were measured; beyond them the lines are an assumption. The mean radius of a U-turn \
             includes its slow start and end, the steady radius is that of the circle in between.{minimum_words}",
            decimals(rudder_limit_rad.to_degrees(), 1)
        ),
    ))
}

/// Where the U-turn radius is least, one sentence after another.
fn minimum_sentence(minimum: &RadiusMinimum<f64>) -> String {
    format!(
        " The fit with a constant has its least U-turn radius away from rest at {} m/s: {} m{}.",
        decimals(minimum.surge_speed_m_s, 2),
        decimals(minimum.u_turn_mean_radius_m, 1),
        if minimum.extrapolated { ", outside the identified speeds, so an assumption" } else { "" }
    )
}

/// Both laws of turning over speed and the turns at the identified speeds.
struct Turning {
    with_constant: TurningOverSpeed<f64>,
    through_zero: TurningOverSpeed<f64>,
    /// Speed and turn at each identified speed.
    starboard: Vec<(f64, Turn<f64>)>,
    port: Vec<(f64, Turn<f64>)>,
    /// Ends of the horizontal axis.
    shown_m_s: [f64; 2],
}

/// A value of a turn at a speed.
type Quantity = fn(f64, &Turn<f64>) -> f64;

impl Turning {
    /// `None` where no law can be fitted.
    fn new(points: &[SchedulePoint<f64>], rudder_limit_rad: f64) -> Option<Self> {
        let over_speed = |form| {
            let authority = AuthorityFit::new(points, form).ok()?;
            let damping = points.iter().map(|p| p.model.a22_per_s);
            Some(TurningOverSpeed {
                a22_per_s: damping.sum::<f64>() / points.len() as f64,
                authority,
                rudder_limit_rad,
            })
        };
        let turns = |side| {
            let turns = points.iter().filter_map(|point| {
                let turn = Turn::new(&point.model, rudder_limit_rad, side).ok()?;
                Some((point.surge_speed_m_s?, turn))
            });
            turns.collect()
        };
        let with_constant = over_speed(AuthorityForm::WithConstant)?;
        let [slowest, fastest] = with_constant.authority.speed_range_m_s;
        Some(Self {
            with_constant,
            through_zero: over_speed(AuthorityForm::ThroughZero)?,
            starboard: turns(Side::Starboard),
            port: turns(Side::Port),
            shown_m_s: [0.4 * slowest, 1.8 * fastest],
        })
    }

    fn panels(&self) -> Vec<Panel> {
        vec![
            self.panel("U-turn mean radius, m", true, |v, turn| turn.u_turn_mean_radius_m(v)),
            self.panel("Steady turning radius, m", false, |v, turn| {
                turn.steady_turning_radius_m(v)
            }),
            self.panel("Greatest yaw rate, °/s", false, |_, turn| {
                turn.yaw_rate_rad_s.to_degrees()
            }),
            self.panel("Time of a U-turn, s", false, |_, turn| turn.u_turn_time_s()),
        ]
    }

    /// A quantity by both laws and at the identified speeds; `named` puts the names in the legend.
    fn panel(&self, label: &str, named: bool, quantity: Quantity) -> Panel {
        let main = self.curve(&self.with_constant, quantity);
        let starboard = dots(&self.starboard, quantity);
        let port = dots(&self.port, quantity);
        // The law through zero runs off to infinity at low speed.
        let shown = [&main, &starboard, &port].into_iter().flatten();
        let [low, high] = extent(shown.map(|p| p[1]).filter(|y| y.is_finite()));
        let name = |text: &'static str| if named { text } else { "" };
        let layers = vec![
            Layer::line("c", name("b₂ through zero"), self.curve(&self.through_zero, quantity)),
            Layer::line("b", name("with constant"), main),
            Layer::dots("a", name("starboard"), starboard),
            Layer::dots("hollow", name("port"), port),
        ];
        Panel::linear(label, 84.0, layers).with_range((low <= high).then_some([low, high]))
    }

    fn curve(&self, law: &TurningOverSpeed<f64>, quantity: Quantity) -> Vec<[f64; 2]> {
        let [from, to] = self.shown_m_s;
        let at = |v: f64| law.turn_at(v).map_or(f64::NAN, |turn| quantity(v, &turn));
        evenly(from, to, 90).map(|v| [v, at(v)]).collect()
    }
}

fn dots(turns: &[(f64, Turn<f64>)], quantity: Quantity) -> Vec<[f64; 2]> {
    let turns = turns.iter();
    turns.map(|(v, turn)| [*v, quantity(*v, turn)]).collect()
}
