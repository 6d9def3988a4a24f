//! The servo between the commanded and the acting rudder, as options of a trial and of a plan.

/// Where the vehicle reports the commanded rudder: how the rudder follows it. Every run is then identified as
/// `identify` does with these options.
#[derive(clap::Args, Clone, Copy, Debug, Default)]
pub struct ServoArgs {
    /// Dead time of the rudder behind the command that the vehicle reports [default: the plan's].
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    pub rudder_delay: Option<f64>,
    /// Time constant with which the rudder follows the command that the vehicle reports; every run's model is then the one
    /// behind the servo, as of `identify --rudder-lag` [default: the plan's].
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    pub rudder_lag: Option<f64>,
}
