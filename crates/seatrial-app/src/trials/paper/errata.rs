use serde::Serialize;

/// A statement of the paper that does not hold and what this software does instead.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Erratum {
    /// Equation, table or figure.
    pub place: &'static str,
    /// What is printed.
    pub printed: &'static str,
    /// What holds.
    pub instead: &'static str,
}

/// Errors and inconsistencies of the paper, in its own order.
pub const ERRATA: [Erratum; 11] = [
    Erratum {
        place: "(9), (45)-(50)",
        printed: "delta0 enters with the opposite sign of (6)",
        instead: "(6) everywhere: -delta0 holds a constant heading, and the hands turn with delta_max + delta0 and delta_max - delta0",
    },
    Erratum {
        place: "(29)",
        printed: "a dot over x(t_k+1)",
        instead: "no dot: (29) is the discrete-time state",
    },
    Erratum {
        place: "section III-C, \"O(N^3) to O(N^2)\"",
        printed: "recursion lowers the complexity from cubic to quadratic in the record",
        instead: "batch least squares is already linear in the record for a fixed number of parameters",
    },
    Erratum {
        place: "section III-C, P(t_k)",
        printed: "P is multiplied by the scalar 1 - K^T Phi: it never learns a direction",
        instead: "P <- (I - K Phi^T) P",
    },
    Erratum {
        place: "(48)",
        printed: "t1 = 4/-a22 reaches 100 % of the final value",
        instead: "it is the 2 % settling time, so (50) is the mean radius of a U-turn; the steady radius V/psi_dot_max is given beside it",
    },
    Erratum {
        place: "(51)",
        printed: "b2 = 0.31 V^2 + 0.26: a constant of 43 % of b2 at 60 % thrust",
        instead: "the force of a fin goes through zero: both fits are offered, extrapolation is marked",
    },
    Erratum {
        place: "Fig. 14",
        printed: "a U-turn at 0.25 m/s takes about 48 s",
        instead: "51.2 s by (54); 48 s is its first term alone",
    },
    Erratum {
        place: "Fig. 14",
        printed: "minimum turning radius 5.9 m at 4.2 m/s",
        instead: "7.63 m at 2.99 m/s by (52)",
    },
    Erratum {
        place: "Table IV",
        printed: "delta0 = 0.04 beside 9.90 deg/s, 20.65 s, 9.20 m",
        instead: "0.04 gives 9.73 deg/s, 20.98 s, 9.35 m; the printed row needs 0.036, which rounds to 0.04",
    },
    Erratum {
        place: "(55)",
        printed: "the closed loop upside down, psi_d/psi",
        instead: "psi/psi_d = K_p b2/(s^2 - a22 s + K_p b2)",
    },
    Erratum {
        place: "Table V, 60 and 70 %",
        printed: "delta0 = 0.016 and 0.020",
        instead: "C0/b2 = 0.0198 and 0.0163: the two are swapped",
    },
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn io_the_page_of_the_paper_has_every_erratum() {
        let page = include_str!("../../../../../docs/explanation/paper.md");
        for Erratum { place, printed, instead } in ERRATA {
            let row = format!("| {place} | {printed} | {instead} |");
            assert!(page.contains(&row), "{row}");
        }
    }
}
