@HEADER@
import collections

import numpy as np

NAME = "@NAME@"
THRUST = np.array([@THRUST@])  # fraction of full
SPEED_M_S = np.array([@SPEED@])  # steady, at that thrust
A22_PER_S = np.array([@A22@])
B2_PER_S2 = np.array([@B2@])  # per rad of rudder
C0_RAD_PER_S2 = np.array([@C0@])
RUDDER_LIMIT_RAD = @LIMIT@
RUDDER_LAG_S = @LAG@
RUDDER_DELAY_S = @DELAY@
RUDDER_RATE_RAD_S = @RATE@
SURGE_TIME_CONSTANT_S = @SURGE_T@
DRAG_LENGTH_M = @DRAG@  # None: the speed follows with the time constant
TURNING_DRAG_M = @TURNING@
LONGEST_STEP_S = 0.01


def _scaled(x, at, values, power):
    """Linear between the points; beyond them the nearest one times a power of the ratio."""
    nearest = np.clip(x, at[0], at[-1])
    return np.interp(nearest, at, values) * (x / nearest) ** power


def steady_speed_m_s(thrust):
    return _scaled(thrust, THRUST, SPEED_M_S, 1)


def yaw_model(speed_m_s):
    """a22, b2 and C0 at a forward speed."""
    return (
        _scaled(speed_m_s, SPEED_M_S, A22_PER_S, 1),
        _scaled(speed_m_s**2, SPEED_M_S**2, B2_PER_S2, 1),
        _scaled(speed_m_s, SPEED_M_S, C0_RAD_PER_S2, 2),
    )


def derivative(state, rudder_command_rad, thrust):
    """The derivative of [north, east, heading, speed, yaw rate, rudder]; whole arrays at once, the state in the first axis.

    The dead time of the rudder is not in it: pass the command of RUDDER_DELAY_S ago.
    """
    _, _, heading, speed, rate, rudder = state
    a22, b2, c0 = yaw_model(speed)
    command = np.clip(rudder_command_rad, -RUDDER_LIMIT_RAD, RUDDER_LIMIT_RAD)
    if RUDDER_LAG_S > 0.0:
        rudder_rate = (command - rudder) / RUDDER_LAG_S
        rudder_rate = np.clip(rudder_rate, -RUDDER_RATE_RAD_S, RUDDER_RATE_RAD_S)
    else:
        rudder, rudder_rate = command, 0.0 * rudder
    target = steady_speed_m_s(thrust)
    if DRAG_LENGTH_M is None:
        acceleration = (target - speed) / SURGE_TIME_CONSTANT_S
    else:
        acceleration = (target * abs(target) - speed * abs(speed)) / DRAG_LENGTH_M
        acceleration = acceleration - TURNING_DRAG_M * rate * rate * np.sign(speed)
    return np.array(
        [
            speed * np.cos(heading),
            speed * np.sin(heading),
            rate,
            acceleration,
            a22 * rate + b2 * rudder + c0,
            rudder_rate,
        ]
    )


class Vehicle:
    """The vehicle, straight ahead at a thrust, without noise or disturbance."""

    def __init__(self, thrust=THRUST[0], heading_rad=0.0):
        speed = float(steady_speed_m_s(thrust))
        _, b2, c0 = yaw_model(speed)
        straight = float(-c0 / b2)
        self.state = np.array([0.0, 0.0, heading_rad, speed, 0.0, straight])
        self.time_s = 0.0
        self._acting = straight
        self._underway = collections.deque()

    @property
    def heading_rad(self):
        return self.state[2]

    @property
    def speed_m_s(self):
        return self.state[3]

    def step(self, rudder_command_rad, thrust, interval_s):
        """Goes on with constant commands (Runge and Kutta's fourth order)."""
        self._underway.append((self.time_s + RUDDER_DELAY_S, rudder_command_rad))
        count = max(1, int(np.ceil(interval_s / LONGEST_STEP_S)))
        h = interval_s / count
        for _ in range(count):
            while self._underway and self._underway[0][0] <= self.time_s + 0.5 * h:
                self._acting = self._underway.popleft()[1]
            x = self.state
            k1 = derivative(x, self._acting, thrust)
            k2 = derivative(x + 0.5 * h * k1, self._acting, thrust)
            k3 = derivative(x + 0.5 * h * k2, self._acting, thrust)
            k4 = derivative(x + h * k3, self._acting, thrust)
            self.state = x + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
            self.time_s += h
        return self.state
