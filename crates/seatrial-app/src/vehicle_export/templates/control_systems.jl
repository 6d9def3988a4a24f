@HEADER@
#
# include("vehicle.jl"); bodeplot(vehicle_models[end]); step(vehicle_rate_model(1), 20)
using ControlSystems

# A row of each speed, the slowest first.
const vehicle_thrust = [@THRUST@]                # fraction of full
const vehicle_speed_m_s = [@SPEED@]              # steady, at that thrust
const vehicle_a22_per_s = [@A22@]                # yaw damping, negative where the vehicle is stable on its course
const vehicle_b2_per_s2 = [@B2@]                 # per rad of rudder; a positive rudder increases the heading where it is positive
const vehicle_c0_rad_per_s2 = [@C0@]             # yaw acceleration at neutral rudder
const vehicle_rudder_limit_rad = @LIMIT@
const vehicle_rudder_rate_rad_s = @RATE@
const vehicle_rudder_lag_s = @LAG@
const vehicle_rudder_delay_s = @DELAY@

# The rudder, rad, that holds a straight course: the rudder of the models is what is added to it.
const vehicle_straight_rudder_rad = -vehicle_c0_rad_per_s2 ./ vehicle_b2_per_s2

# From the rudder that is commanded to the one that acts, rad to rad: e^(-delay s) / (lag s + 1).
function vehicle_rudder_model()
    lag = vehicle_rudder_lag_s > 0 ? tf([1.0], [vehicle_rudder_lag_s, 1.0]) : tf([1.0], [1.0])
    return vehicle_rudder_delay_s > 0 ? lag * delay(vehicle_rudder_delay_s) : lag
end

# From the commanded rudder, rad, to the yaw rate, rad/s, positive where the heading increases: b2 / (s - a22) behind the rudder.
vehicle_rate_model(k) = tf([vehicle_b2_per_s2[k]], [1.0, -vehicle_a22_per_s[k]]) * vehicle_rudder_model()

# From the commanded rudder, rad, to the heading, rad, clockwise as a compass counts: b2 / (s (s - a22)) behind the rudder.
vehicle_heading_model(k) = tf([vehicle_b2_per_s2[k]], [1.0, -vehicle_a22_per_s[k], 0.0]) * vehicle_rudder_model()

const vehicle_models = [vehicle_heading_model(k) for k in eachindex(vehicle_speed_m_s)]
