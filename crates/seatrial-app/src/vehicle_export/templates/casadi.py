@HEADER@
import casadi as ca

NAME = "@NAME@"
THRUST = [@THRUST@]  # fraction of full
SPEED_M_S = [@SPEED@]  # steady, at that thrust
A22_PER_S = [@A22@]
B2_PER_S2 = [@B2@]  # per rad of rudder
C0_RAD_PER_S2 = [@C0@]
RUDDER_LIMIT_RAD = @LIMIT@
RUDDER_LAG_S = @LAG@
RUDDER_DELAY_S = @DELAY@
RUDDER_RATE_RAD_S = @RATE@
SURGE_TIME_CONSTANT_S = @SURGE_T@
DRAG_LENGTH_M = @DRAG@  # None: the speed follows with the time constant
TURNING_DRAG_M = @TURNING@
INF = float("inf")


def _scaled(x, at, values, power):
    """Linear between the points; beyond them the nearest one times a power of the ratio."""
    nearest = ca.fmin(ca.fmax(x, at[0]), at[-1])
    value = values[0]
    for k in range(1, len(at)):
        slope = (values[k] - values[k - 1]) / (at[k] - at[k - 1])
        value = value + slope * (ca.fmin(ca.fmax(nearest, at[k - 1]), at[k]) - at[k - 1])
    return value * (x / nearest) ** power


def symbols():
    """State [north, east, heading, speed, yaw rate, rudder], input [rudder command, thrust] and the state's derivative.

    For acados: model.x, model.u, model.f_expl_expr = symbols(), model.name = NAME.
    """
    x = ca.SX.sym("x", 6)
    u = ca.SX.sym("u", 2)
    _, _, heading, speed, rate, rudder = ca.vertsplit(x)
    command = ca.fmin(ca.fmax(u[0], -RUDDER_LIMIT_RAD), RUDDER_LIMIT_RAD)
    if RUDDER_LAG_S > 0.0:
        rudder_rate = (command - rudder) / RUDDER_LAG_S
        if RUDDER_RATE_RAD_S < INF:
            rudder_rate = ca.fmin(ca.fmax(rudder_rate, -RUDDER_RATE_RAD_S), RUDDER_RATE_RAD_S)
    else:
        rudder, rudder_rate = command, 0.0
    target = _scaled(u[1], THRUST, SPEED_M_S, 1)
    if DRAG_LENGTH_M is None:
        acceleration = (target - speed) / SURGE_TIME_CONSTANT_S
    else:
        acceleration = (target * ca.fabs(target) - speed * ca.fabs(speed)) / DRAG_LENGTH_M
        acceleration -= TURNING_DRAG_M * rate * rate * ca.sign(speed)
    a22 = _scaled(speed, SPEED_M_S, A22_PER_S, 1)
    b2 = _scaled(speed**2, [at**2 for at in SPEED_M_S], B2_PER_S2, 1)
    c0 = _scaled(speed, SPEED_M_S, C0_RAD_PER_S2, 2)
    derivative = ca.vertcat(
        speed * ca.cos(heading),
        speed * ca.sin(heading),
        rate,
        acceleration,
        a22 * rate + b2 * rudder + c0,
        rudder_rate,
    )
    return x, u, derivative


def model():
    """The derivative of the state as a function of state and input."""
    x, u, derivative = symbols()
    return ca.Function(NAME, [x, u], [derivative], ["x", "u"], ["xdot"])


def step(interval_s, count=10):
    """The state an interval later with constant input, in Runge and Kutta's steps of fourth order."""
    f = model()
    x = ca.SX.sym("x", 6)
    u = ca.SX.sym("u", 2)
    h = interval_s / count
    after = x
    for _ in range(count):
        k1 = f(after, u)
        k2 = f(after + 0.5 * h * k1, u)
        k3 = f(after + 0.5 * h * k2, u)
        k4 = f(after + h * k3, u)
        after = after + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
    return ca.Function("step", [x, u], [after])
