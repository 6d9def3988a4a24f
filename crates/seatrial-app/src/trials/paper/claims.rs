use seatrial_core::authority::{AuthorityFit, AuthorityForm};
use seatrial_core::turning::TurningOverSpeed;
use seatrial_core::{HeadingGain, HeadingLoop, SchedulePoint, Side, Turn, YawModel};

use super::tables::{
    RUDDER_LIMIT_RAD, Row, TABLE_II, TABLE_III, TABLE_III_ITERATIONS, TABLE_V, TABLE_V_GAINS,
    exact, printed,
};
use super::{Claim, PrintedNumber};

const ZETA_OF_57: f64 = std::f64::consts::FRAC_1_SQRT_2;

/// Every printed number that follows from other printed numbers, in the order of the paper.
pub fn claims() -> Vec<Claim> {
    let mut claims = protocol();
    claims.extend(offsets("Table II", &TABLE_II));
    claims.extend(table_ii());
    claims.extend(equation_51());
    claims.extend(offsets("Table III", &TABLE_III));
    claims.extend(table_iii());
    claims.extend(figure_14());
    claims.extend(table_iv());
    claims.extend(offsets("Table V", &TABLE_V).into_iter().map(|claim| {
        let swapped = claim.quantity.contains("60 %") || claim.quantity.contains("70 %");
        if swapped { claim.noting("the values of 60 and 70 % are swapped in print") } else { claim }
    }));
    claims.extend(table_v());
    claims.extend(figure_18());
    claims
}

fn protocol() -> Vec<Claim> {
    let stage = "Section IV-B";
    vec![
        Claim::new(
            stage,
            "length of the training stage",
            "s",
            printed(16.5, 1),
            &[exact(2.0), exact(4.0), exact(10.5)],
            |x| x.iter().sum(),
        ),
        Claim::new(
            stage,
            "samples of a stage",
            "",
            printed(330.0, 0),
            &[exact(16.5), exact(20.0)],
            |x| x[0] * x[1],
        ),
    ]
}

fn offsets(place: &'static str, rows: &[Row]) -> Vec<Claim> {
    let mut claims: Vec<Claim> = Vec::new();
    for row in rows {
        let quantity = named(&claims, format!("delta0 = C0/b2 at {} %", row.thrust_percent));
        let inputs = [row.c0(), row.b2()];
        claims.push(Claim::new(place, quantity, "rad", row.delta0(), &inputs, |x| x[0] / x[1]));
    }
    claims
}

/// Tells the second run at one thrust from the first.
fn named(claims: &[Claim], quantity: String) -> String {
    if claims.iter().any(|claim| claim.quantity == quantity) {
        quantity + ", second run"
    } else {
        quantity
    }
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// b2 over V^2 through (V, b2, V, b2, ...).
fn authority(speeds_and_b2: &[f64], form: AuthorityForm) -> AuthorityFit<f64> {
    let points: Vec<SchedulePoint<f64>> = speeds_and_b2
        .chunks_exact(2)
        .map(|pair| SchedulePoint {
            thrust: None,
            surge_speed_m_s: Some(pair[0]),
            model: YawModel::from_theta([-1.0, pair[1], 0.0]),
        })
        .collect();
    AuthorityFit::new(&points, form).expect("five printed points at different speeds")
}

fn table_ii() -> Vec<Claim> {
    let r2 = TABLE_II.map(|row| row.r2());
    vec![
        Claim::new(
            "Table II",
            "mean magnitude of a22",
            "1/s",
            printed(1.1, 1),
            &TABLE_II.map(|row| row.a22()),
            |x| -mean(x),
        ),
        Claim::new("Section IV-C", "least R^2", "%", printed(78.0, 0), &r2, |x| {
            100.0 * x.iter().copied().fold(f64::INFINITY, f64::min)
        }),
        Claim::new("Section IV-C", "greatest R^2", "%", printed(92.0, 0), &r2, |x| {
            100.0 * x.iter().copied().fold(0.0, f64::max)
        }),
        Claim::new("Section V", "mean R^2 online", "", printed(0.868, 3), &r2, mean),
    ]
}

/// (51), fitted to Table II.
fn equation_51() -> Vec<Claim> {
    let speeds_and_b2: Vec<PrintedNumber> =
        TABLE_II.iter().flat_map(|row| [row.speed(), row.b2()]).collect();
    let fit = |x: &[f64]| authority(x, AuthorityForm::WithConstant);
    let through_zero =
        "the paper fits a constant too; a fin's force gives none: k = 0.387 through zero";
    vec![
        Claim::new(
            "(51)",
            "k of b2 = k V^2 + c fitted to Table II",
            "1/m^2",
            printed(0.31, 2),
            &speeds_and_b2,
            |x| fit(x).per_speed_squared_per_m2,
        )
        .noting(through_zero),
        Claim::new(
            "(51)",
            "c of b2 = k V^2 + c fitted to Table II",
            "1/s^2",
            printed(0.26, 2),
            &speeds_and_b2,
            |x| fit(x).constant_per_s2,
        )
        .noting("43 % of b2 at 60 % thrust: do not extrapolate to low speed"),
    ]
}

fn table_iii() -> Vec<Claim> {
    vec![
        Claim::new(
            "Section V",
            "mean R^2 offline",
            "",
            printed(0.857, 3),
            &TABLE_III.map(|row| row.r2()),
            mean,
        ),
        Claim::new(
            "Section V",
            "mean iterations of the simplex, \"around 100\"",
            "",
            printed(100.0, -1),
            &TABLE_III_ITERATIONS.map(|n| exact(f64::from(n))),
            mean,
        ),
    ]
}

/// (52)-(54), whose coefficients are exact as printed.
fn figure_14() -> Vec<Claim> {
    let over_speed = TurningOverSpeed {
        a22_per_s: -1.1,
        authority: AuthorityFit {
            form: AuthorityForm::WithConstant,
            per_speed_squared_per_m2: 0.31,
            constant_per_s2: 0.26,
            rms_residual_per_s2: 0.0,
            speed_range_m_s: [1.07, 2.19],
        },
        rudder_limit_rad: RUDDER_LIMIT_RAD,
    };
    let slow = over_speed.turn_at(0.25).expect("stable, with authority");
    let minimum = over_speed
        .minimum_radius(0.5, 5.0)
        .expect("stable, with authority")
        .expect("a minimum inside the range of the figure");
    let claim = |quantity: &str, unit, printed, value: f64| {
        Claim::new("Fig. 14", quantity, unit, printed, &[], |_| value)
    };
    vec![
        Claim::new(
            "(48)",
            "part of the final yaw rate reached after t1 = 4/-a22",
            "%",
            printed(100.0, 0),
            &[],
            |_| 100.0 * (1.0 - (-4.0_f64).exp()),
        )
        .noting("4/-a22 is the 2 % settling time: (50) is a U-turn's mean radius, not the steady radius"),
        claim(
            "turning radius (52) at 0.25 m/s",
            "m",
            printed(4.0, 0),
            slow.u_turn_mean_radius_m(0.25),
        ),
        claim(
            "U-turn time (54) at 0.25 m/s",
            "s",
            printed(48.0, 0),
            slow.u_turn_time_s(),
        )
        .noting("48 s is the first term of (54) alone"),
        claim(
            "least turning radius (52) at higher speeds",
            "m",
            printed(5.9, 1),
            minimum.u_turn_mean_radius_m,
        )
        .noting("does not follow from (52)"),
        claim(
            "speed of the least turning radius",
            "m/s",
            printed(4.2, 1),
            minimum.surge_speed_m_s,
        )
        .noting("does not follow from (52)"),
    ]
}

/// The turn to the side that the paper gives, with the effective rudder delta_max - delta0.
fn turn(a22: f64, b2: f64, delta0: f64) -> Turn<f64> {
    let model = YawModel::from_theta([a22, b2, b2 * delta0]);
    Turn::new(&model, RUDDER_LIMIT_RAD, Side::Port).expect("stable, with authority")
}

fn table_iv() -> Vec<Claim> {
    let needs = "the printed row needs delta0 = 0.036";
    let mut claims = vec![
        Claim::new(
            "Section VI-A",
            "effective rudder delta_max - delta0",
            "rad",
            printed(0.22, 2),
            &[exact(RUDDER_LIMIT_RAD), printed(0.04, 2)],
            |x| x[0] - x[1],
        )
        .noting("one hand; by (6) the other has delta_max + delta0 = 0.30 rad"),
    ];
    for (delta0, with, note) in
        [(printed(0.04, 2), "", Some(needs)), (exact(0.036), " with delta0 = 0.036", None)]
    {
        let parameters = [printed(-1.62, 2), printed(1.25, 2), delta0];
        let with_speed = [parameters[0], parameters[1], delta0, printed(1.4, 1)];
        let rows = [
            Claim::new(
                "Table IV",
                format!("psi_dot_max{with}"),
                "deg/s",
                printed(9.90, 2),
                &parameters,
                |x| turn(x[0], x[1], x[2]).yaw_rate_rad_s.to_degrees(),
            ),
            Claim::new(
                "Table IV",
                format!("T_pi{with}"),
                "s",
                printed(20.65, 2),
                &parameters,
                |x| turn(x[0], x[1], x[2]).u_turn_time_s(),
            ),
            Claim::new(
                "Table IV",
                format!("R at 1.4 m/s{with}"),
                "m",
                printed(9.20, 2),
                &with_speed,
                |x| turn(x[0], x[1], x[2]).u_turn_mean_radius_m(x[3]),
            ),
        ];
        claims.extend(rows.map(|claim| Claim { note, ..claim }));
    }
    claims
}

fn table_v() -> Vec<Claim> {
    let mut claims: Vec<Claim> = Vec::new();
    for (row, gain) in TABLE_V.iter().zip(TABLE_V_GAINS) {
        let quantity = named(&claims, format!("K_p (57) at {} %", row.thrust_percent));
        claims.push(Claim::new(
            "Table V",
            quantity,
            "rad/rad",
            printed(gain, 2),
            &[row.a22(), row.b2()],
            |x| design(x[0], x[1]).proportional_gain,
        ));
    }
    for (row, radius) in TABLE_V[2..4].iter().zip([9.20, 9.25]) {
        let quantity = named(&claims, "turning radius (50) at 80 %".into());
        claims.push(Claim::new(
            "Section VI-B",
            quantity,
            "m",
            printed(radius, 2),
            &[row.a22(), row.b2(), row.delta0(), row.speed()],
            |x| turn(x[0], x[1], x[2]).u_turn_mean_radius_m(x[3]),
        ));
    }
    claims.push(
        Claim::new(
            "Section VI-B",
            "overshoot at zeta = 0.7071, \"approximately 5 %\"",
            "%",
            printed(5.0, 0),
            &[],
            |_| {
                let model = YawModel::from_theta([-1.0, 1.0, 0.0]);
                let gain = design(-1.0, 1.0).proportional_gain;
                let closed = HeadingLoop::new(&model, gain).expect("stable by design");
                100.0 * closed.overshoot()
            },
        )
        .noting("e^-pi, rounded up by the paper"),
    );
    claims.push(Claim::new(
        "Section IV-C",
        "smallest R^2 so far",
        "",
        printed(0.61, 2),
        &TABLE_V.map(|row| row.r2()),
        |x| x.iter().copied().fold(f64::INFINITY, f64::min),
    ));
    claims
}

fn design(a22: f64, b2: f64) -> HeadingGain<f64> {
    HeadingGain::design(&YawModel::from_theta([a22, b2, 0.0]), ZETA_OF_57)
        .expect("stable, with authority")
}

/// "Matches the K_p obtained via the individual identified results."
fn figure_18() -> Vec<Claim> {
    let ends = [printed(TABLE_V_GAINS[0], 2), printed(TABLE_V_GAINS[5], 2)];
    let mut claims: Vec<Claim> = Vec::new();
    for (row, gain) in TABLE_V.iter().zip(TABLE_V_GAINS).skip(1).take(4) {
        let fraction = f64::from(row.thrust_percent - 60) / 40.0;
        let quantity = format!("K_p at {} % on the line from 60 to 100 %", row.thrust_percent);
        let quantity = named(&claims, quantity);
        let claim = Claim::new("Fig. 18", quantity, "rad/rad", printed(gain, 2), &ends, |x| {
            x[0] + fraction * (x[1] - x[0])
        });
        claims.push(claim.noting("said to match; printed is the gain identified at this thrust"));
    }
    claims
}

#[cfg(test)]
mod tests {
    use super::super::Agreement;
    use super::*;

    /// The rows that NOTES of the paper list as errors differ, and nothing else that they call consistent.
    #[test]
    fn val_paper_rows_that_differ() {
        let differing: Vec<String> = claims()
            .into_iter()
            .filter(|claim| claim.agreement == Agreement::Differs)
            .map(|claim| format!("{}: {}", claim.place, claim.quantity))
            .collect();
        assert_eq!(
            differing,
            [
                "(48): part of the final yaw rate reached after t1 = 4/-a22",
                "Fig. 14: U-turn time (54) at 0.25 m/s",
                "Fig. 14: least turning radius (52) at higher speeds",
                "Fig. 14: speed of the least turning radius",
                "Table V: delta0 = C0/b2 at 60 %",
                "Table V: delta0 = C0/b2 at 70 %",
                "Section VI-B: overshoot at zeta = 0.7071, \"approximately 5 %\"",
                "Fig. 18: K_p at 80 % on the line from 60 to 100 %",
                "Fig. 18: K_p at 90 % on the line from 60 to 100 %",
            ]
        );
    }

    #[test]
    fn val_paper_recomputed_values() {
        let claims = claims();
        let recomputed = |place: &str, quantity: &str| {
            let found =
                claims.iter().find(|c| c.place == place && c.quantity.starts_with(quantity));
            found.expect(quantity).recomputed
        };
        for (place, quantity, expected, half_unit) in [
            ("Table IV", "psi_dot_max", 9.73, 0.005),
            ("Table IV", "T_pi", 20.98, 0.005),
            ("Table IV", "R at", 9.35, 0.005),
            ("Fig. 14", "turning radius (52) at 0.25", 4.08, 0.005),
            ("Fig. 14", "U-turn time", 51.2, 0.05),
            ("Fig. 14", "least turning radius", 7.63, 0.005),
            ("Fig. 14", "speed of the least", 2.99, 0.005),
            ("Section VI-B", "turning radius (50) at 80 %", 9.20, 0.005),
            ("Section VI-B", "turning radius (50) at 80 %, second", 9.25, 0.005),
            ("(51)", "k of", 0.311, 0.0005),
            ("(51)", "c of", 0.259, 0.0005),
            ("Section V", "mean R^2 online", 0.868, 0.0005),
            ("Section V", "mean R^2 offline", 0.857, 0.0005),
            ("Table V", "delta0 = C0/b2 at 60 %", 0.0198, 0.00005),
            ("Table V", "delta0 = C0/b2 at 70 %", 0.0163, 0.000051),
        ] {
            // Half a unit of the last digit that NOTES of the paper give.
            let found = recomputed(place, quantity);
            assert!((found - expected).abs() <= half_unit, "{quantity}: {found}");
        }
    }

    #[test]
    fn exact_agreement_by_rounding() {
        let claim = |printed_value, input: PrintedNumber| {
            Claim::new("", "", "", printed(printed_value, 1), &[input], |x| 2.0 * x[0]).agreement
        };
        assert_eq!(claim(2.0, exact(1.02)), Agreement::Agrees);
        assert_eq!(claim(2.1, printed(1.0, 1)), Agreement::WithinInputRounding);
        assert_eq!(claim(2.1, exact(1.0)), Agreement::Differs);
        assert_eq!(claim(2.1, printed(1.0, 2)), Agreement::Differs);
    }
}
