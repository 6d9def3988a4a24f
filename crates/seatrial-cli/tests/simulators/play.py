"""Plays rudder and thrust through an exported vehicle, in the engine that it is for.

play.py ENGINE FILE COMMANDS.csv: rows of time, rudder and thrust; writes rows of heading and speed.
"""

import importlib.util
import sys

import numpy as np


def load(path):
    spec = importlib.util.spec_from_file_location("exported", path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def of_class(module, times, rudder, thrust):
    vehicle = module.Vehicle(thrust[0])
    for k, interval_s in enumerate(np.diff(times)):
        yield vehicle.heading_rad, vehicle.speed_m_s
        vehicle.step(rudder[k], thrust[k], interval_s)
    yield vehicle.heading_rad, vehicle.speed_m_s


def of_casadi(module, times, rudder, thrust):
    interval_s = times[1] - times[0]
    step = module.step(interval_s)
    late = round(module.RUDDER_DELAY_S / interval_s)
    speed = np.interp(thrust[0], module.THRUST, module.SPEED_M_S)
    b2 = np.interp(speed, module.SPEED_M_S, module.B2_PER_S2)
    straight = -np.interp(speed, module.SPEED_M_S, module.C0_RAD_PER_S2) / b2
    state = np.array([0.0, 0.0, 0.0, speed, 0.0, straight])
    for k in range(len(times)):
        yield state[2], state[3]
        command = rudder[k - late] if k >= late else straight
        state = np.array(step(state, [command, thrust[k]])).ravel()


def of_fmu(path, times, rudder, thrust):
    import fmpy

    # An importer of FMI interpolates inputs but at equal times, where they step: each command holds until the next.
    rows = [(at, *command) for k, command in enumerate(zip(rudder, thrust)) for at in times[k : k + 2]]
    names = [("time", float), ("rudder_command_rad", float), ("thrust", float)]
    played = fmpy.simulate_fmu(
        path,
        start_time=times[0],
        stop_time=times[-1],
        output_interval=times[1] - times[0],
        input=np.array(rows, dtype=names),
        output=["heading_rad", "speed_m_s"],
    )
    yield from zip(played["heading_rad"], played["speed_m_s"])


engine, path, commands = sys.argv[1:]
times, rudder, thrust = np.loadtxt(commands, delimiter=",").T
if engine == "fmu":
    played = of_fmu(path, times, rudder, thrust)
else:
    play = of_casadi if engine == "casadi" else of_class
    played = play(load(path), times, rudder, thrust)
for heading, speed in played:
    print(f"{heading!r},{speed!r}".replace("np.float64(", "").replace(")", ""))
