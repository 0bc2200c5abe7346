"""Validates an FMU of FMI 3.0, simulates it, and compares it bit by bit with the one of FMI 2.0 of the same scene: every variable that is calculated, with
every parameter and input set by its name. Its value references are the places of its variables: some importers take one for the other.

With `exchange` it also compares Model Exchange with Co-Simulation, where it is offered.

usage: versions.py FMI2.fmu FMI3.fmu [exchange]
"""

import sys

import numpy
from fmpy import simulate_fmu
from fmpy.model_description import read_model_description
from fmpy.validation import validate_fmu


def simulated(fmu, interface, names, starts):
    settings = dict(stop_time=0.5, output_interval=0.01, relative_tolerance=1e-9)
    return simulate_fmu(fmu, fmi_type=interface, output=names, start_values=starts, **settings)


def main(second, third, exchange=None):
    problems = validate_fmu(third)
    if problems:
        sys.exit("\n".join(problems))
    variables = read_model_description(third).modelVariables
    if [variable.valueReference for variable in variables] != list(range(1, len(variables) + 1)):
        sys.exit("a value reference is not the place of its variable")
    variables = read_model_description(second).modelVariables
    names = [variable.name for variable in variables if variable.causality == "output"]
    others = [variable.name for variable in variables if variable.causality == "local"]
    starts = {variable.name: float(variable.start) for variable in variables if variable.causality in ("parameter", "input")}
    before, now = (simulated(fmu, "CoSimulation", names + others, starts) for fmu in (second, third))
    for name in ["time", *names, *others]:
        if before[name].tobytes() != now[name].tobytes():
            sys.exit(f"{name} differs between the versions by up to {numpy.abs(before[name] - now[name]).max()}")
    if not exchange or read_model_description(third).modelExchange is None:
        return
    exchanged = simulated(third, "ModelExchange", names, starts)
    for name in names:
        at = numpy.interp(now["time"], exchanged["time"], exchanged[name])
        scale = max(1.0, numpy.abs(now[name]).max())
        if numpy.abs(at - now[name]).max() > 2e-2 * scale:
            sys.exit(f"{name} differs between the interfaces by up to {numpy.abs(at - now[name]).max()}")


if __name__ == "__main__":
    main(*sys.argv[1:])
