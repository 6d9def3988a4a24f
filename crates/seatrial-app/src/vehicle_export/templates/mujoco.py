@HEADER@
import collections

import mujoco
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
MASS_KG = 1.0  # any: forces are made from accelerations
INERTIA_KG_M2 = 1.0

# x north, y west, z up: the yaw of MuJoCo is counterclockwise, minus the heading.
XML = f"""
<mujoco model="{NAME}">
  <option timestep="0.005" gravity="0 0 0" integrator="implicitfast"/>
  <worldbody>
    <body name="vehicle">
      <joint name="north" type="slide" axis="1 0 0"/>
      <joint name="west" type="slide" axis="0 1 0"/>
      <joint name="yaw" type="hinge" axis="0 0 1"/>
      <inertial pos="0 0 0" mass="{MASS_KG}" diaginertia="{INERTIA_KG_M2} {INERTIA_KG_M2} {INERTIA_KG_M2}"/>
      <geom name="hull" type="ellipsoid" size="0.8 0.1 0.1" contype="0" conaffinity="0"/>
      <site name="centre"/>
    </body>
  </worldbody>
  <actuator>
    <motor name="surge" site="centre" gear="1 0 0 0 0 0"/>
    <motor name="sway" site="centre" gear="0 1 0 0 0 0"/>
    <motor name="turn" site="centre" gear="0 0 0 0 0 1"/>
  </actuator>
</mujoco>
"""


def _scaled(x, at, values, power):
    """Linear between the points; beyond them the nearest one times a power of the ratio."""
    nearest = np.clip(x, at[0], at[-1])
    return float(np.interp(nearest, at, values) * (x / nearest) ** power)


class Vehicle:
    """The vehicle in MuJoCo's engine, straight ahead at a thrust, without noise or disturbance.

    In a scene of your own: put the body and its motors there, and call `control` before each mj_step.
    """

    def __init__(self, thrust=THRUST[0], heading_rad=0.0):
        self.model = mujoco.MjModel.from_xml_string(XML)
        self.data = mujoco.MjData(self.model)
        speed = _scaled(thrust, THRUST, SPEED_M_S, 1)
        b2 = _scaled(speed**2, SPEED_M_S**2, B2_PER_S2, 1)
        self.rudder_rad = -_scaled(speed, SPEED_M_S, C0_RAD_PER_S2, 2) / b2
        self._acting = self.rudder_rad
        self._underway = collections.deque()
        self.data.qpos[2] = -heading_rad
        self.data.qvel[0] = speed * np.cos(heading_rad)
        self.data.qvel[1] = -speed * np.sin(heading_rad)

    @property
    def heading_rad(self):
        return -self.data.qpos[2]

    @property
    def speed_m_s(self):
        north, west, _ = self.data.qvel
        return north * np.cos(self.heading_rad) - west * np.sin(self.heading_rad)

    def _rudder(self, command_rad, interval_s):
        self._underway.append((self.data.time + RUDDER_DELAY_S, command_rad))
        while self._underway and self._underway[0][0] <= self.data.time + 0.5 * interval_s:
            self._acting = self._underway.popleft()[1]
        acting = np.clip(self._acting, -RUDDER_LIMIT_RAD, RUDDER_LIMIT_RAD)
        lag = -np.expm1(-interval_s / RUDDER_LAG_S) if RUDDER_LAG_S > 0.0 else 1.0
        most = RUDDER_RATE_RAD_S * interval_s
        before = self.rudder_rad
        self.rudder_rad += np.clip(lag * (acting - before), -most, most)
        return 0.5 * (before + self.rudder_rad) if RUDDER_LAG_S > 0.0 else self.rudder_rad

    def control(self, rudder_command_rad, thrust):
        """Sets the forces of the next mj_step."""
        rudder = self._rudder(rudder_command_rad, self.model.opt.timestep)
        speed, rate = self.speed_m_s, -self.data.qvel[2]
        north, west, _ = self.data.qvel
        aside = -north * np.sin(self.heading_rad) - west * np.cos(self.heading_rad)
        target = _scaled(thrust, THRUST, SPEED_M_S, 1)
        if DRAG_LENGTH_M is None:
            ahead = (target - speed) / SURGE_TIME_CONSTANT_S
        else:
            ahead = (target * abs(target) - speed * abs(speed)) / DRAG_LENGTH_M
            ahead -= TURNING_DRAG_M * rate * rate * np.sign(speed)
        turn = (
            _scaled(speed, SPEED_M_S, A22_PER_S, 1) * rate
            + _scaled(speed**2, SPEED_M_S**2, B2_PER_S2, 1) * rudder
            + _scaled(speed, SPEED_M_S, C0_RAD_PER_S2, 2)
        )
        # The velocity stays along the heading: the force of the turn, and what drifted goes within 0.1 s.
        starboard = speed * rate - aside / 0.1
        self.data.ctrl[:] = [MASS_KG * ahead, -MASS_KG * starboard, -INERTIA_KG_M2 * turn]

    def step(self, rudder_command_rad, thrust, interval_s):
        """Goes on with constant commands."""
        for _ in range(max(1, round(interval_s / self.model.opt.timestep))):
            self.control(rudder_command_rad, thrust)
            mujoco.mj_step(self.model, self.data)
