"""Checks a Functional Mock-up Unit: check_fmu.py FILE.fmu."""

import subprocess
import sys

import fmpy
from fmpy.fmi3 import FMU3Slave
from fmpy.validation import validate_fmu

path = sys.argv[1]
assert not (problems := validate_fmu(path)), problems
description = fmpy.read_model_description(path)
reference = {v.name: v.valueReference for v in description.modelVariables}
folder = fmpy.extract(path)


def started(**parameters):
    unit = FMU3Slave(
        guid=description.guid,
        unzipDirectory=folder,
        modelIdentifier=description.coSimulation.modelIdentifier,
        instanceName="boat",
    )
    unit.instantiate()
    unit.enterInitializationMode()
    for name, value in parameters.items():
        values = value if isinstance(value, list) else [value]
        unit.setFloat64([reference[name]], values)
    unit.exitInitializationMode()
    return unit


def heading_after(unit, start_s, count):
    for k in range(count):
        unit.setFloat64([reference["rudder_command_rad"]], [0.3])
        unit.doStep(start_s + 0.1 * k, 0.1)
    return unit.getFloat64([reference["heading_rad"]])[0]


# The state is that of the start in initialization mode, and a parameter has its effect.
unit = started(thrust=0.5, initial_heading_rad=1.0)
assert unit.getFloat64([reference["speed_m_s"], reference["heading_rad"]]) == [1.0, 1.0]
plain = heading_after(started(), 0.0, 50)
assert heading_after(started(rudder_limit_rad=0.1), 0.0, 50) < 0.5 * plain
assert heading_after(started(b2_per_s2=[1.4, 3.2]), 0.0, 50) > 1.5 * plain

# A state that is taken and set again goes on as it did, commands within the dead time too.
unit = started()
heading_after(unit, 0.0, 1)
state = unit.getFMUState()
once = heading_after(unit, 0.1, 30)
unit.setFMUState(state)
assert heading_after(unit, 0.1, 30) == once
unit.freeFMUState(state)
unit.reset()
assert unit.getFloat64([reference["heading_rad"]]) == [0.0]
unit.terminate()
unit.freeInstance()


def refused(what):
    try:
        what()
    except Exception:
        return True
    return False


assert refused(lambda: started(rudder_limit_rad=-1.0))
assert refused(lambda: started(rudder_limit_rad=float("nan")))
assert refused(lambda: started(thrust_points=[0.9, 0.5]))
unit = started()
assert refused(lambda: unit.setFloat64([reference["rudder_limit_rad"]], [0.1]))
assert refused(lambda: unit.getFloat64([99]))

# The source code compiles without a warning.
subprocess.run(
    ["cc", "-std=c99", "-Wall", "-Wextra", "-Wno-unused-parameter", "-Werror", "-fsyntax-only", f"{folder}/sources/vehicle.c"],
    check=True,
)
