//! What is asked of the ratios.

use crate::table::Goal;

/// Each ratio of interest and the most that it should be.
pub const GOALS: [Goal; 12] = {
    const fn goal(work: &'static str, beside: &'static str, most: f64, text: &'static str) -> Goal {
        Goal { work, beside, most, text }
    }
    [
        goal("online", "online C++ by hand", 0.9, "0.9"),
        goal("online", "online nalgebra", 0.65, "0.65"),
        goal("online", "online Eigen", 0.4, "0.4"),
        goal("online", "online padasip", 1.0 / 700.0, "1/700"),
        goal("online", "online Octave", 1.0 / 1500.0, "1/1500"),
        goal("online", "bound of the online step", 1.35, "1.35"),
        goal("batch", "batch scipy", 1.0 / 7.0, "1/7"),
        // With its covariance, which takes a third of the time and which the others do not have.
        goal("refined", "refined, own simplex + RK4", 1.0 / 15.0, "1/15"),
        goal("refined", "refined scipy least_squares", 1.0 / 40.0, "1/40"),
        goal("refined", "refined scipy simplex, Python RK4", 1.0 / 1700.0, "1/1700"),
        goal("online, a trial's estimator", "online", 5.0, "5"),
        // No goal: what the instrument adds, with an exponential of a22 for every sample.
        goal("online, a trial's instrument", "online", f64::INFINITY, "none"),
    ]
};
