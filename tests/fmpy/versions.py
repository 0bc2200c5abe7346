"""Validates an FMU of FMI 3.0, simulates it, and compares it bit by bit with the one of FMI 2.0 of the same scene.

With `exchange` it also compares Model Exchange with Co-Simulation, where it is offered.

usage: versions.py FMI2.fmu FMI3.fmu [exchange]
"""

import sys

import numpy
from fmpy import simulate_fmu
from fmpy.model_description import read_model_description
from fmpy.validation import validate_fmu


def simulated(fmu, interface, names):
    return simulate_fmu(fmu, fmi_type=interface, output=names, stop_time=0.5, output_interval=0.01, relative_tolerance=1e-9)


def main(second, third, exchange=None):
    problems = validate_fmu(third)
    if problems:
        sys.exit("\n".join(problems))
    names = [variable.name for variable in read_model_description(second).modelVariables if variable.causality == "output"]
    before, now = (simulated(fmu, "CoSimulation", names) for fmu in (second, third))
    for name in ["time", *names]:
        if before[name].tobytes() != now[name].tobytes():
            sys.exit(f"{name} differs between the versions by up to {numpy.abs(before[name] - now[name]).max()}")
    if not exchange or read_model_description(third).modelExchange is None:
        return
    exchanged = simulated(third, "ModelExchange", names)
    for name in names:
        at = numpy.interp(now["time"], exchanged["time"], exchanged[name])
        scale = max(1.0, numpy.abs(now[name]).max())
        if numpy.abs(at - now[name]).max() > 2e-2 * scale:
            sys.exit(f"{name} differs between the interfaces by up to {numpy.abs(at - now[name]).max()}")


if __name__ == "__main__":
    main(*sys.argv[1:])
