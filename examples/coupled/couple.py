"""Couples two FMUs, a slider-crank and its spring-damper load, and compares them with the same mechanism as one FMU.

usage: couple.py FOLDER        with crank.fmu, load.fmu and whole.fmu

The crank gives the slider's position and velocity, the load gives the force that it answers with. Four masters:

* At once: both move one step with what the other one gave at its beginning. The error is proportional to the step.
* Gauss-Seidel: the crank moves one step with the force of the step's beginning, then the load follows the slider's new
  position. The error is proportional to the step, too.
* Extrapolated: both move at once, with inputs that go on as the derivatives of the other's outputs say. Nothing is
  repeated; the error is proportional to the square of the step.
* Iterated: within a step force, position and velocity change linearly. The step is repeated from its saved beginning
  until the force at its end no longer changes. The error is proportional to the square of the step.
"""

import sys
from contextlib import contextmanager
from pathlib import Path
from zipfile import BadZipFile

import numpy as np
from fmpy import extract, instantiate_fmu, read_model_description, simulate_fmu
from fmpy.fmi1 import FMICallException

STOP = 2.0
STEPS = [200, 400, 2000]
TOLERANCE = 1e-10
FORCE_TOLERANCE = 1e-9  # N
MOST_ITERATIONS = 50


class Fmu:
    """One instance, with its variables by name."""

    def __init__(self, folder, name):
        path = folder / f"{name}.fmu"
        self.description = read_model_description(path)
        self.references = {v.name: v.valueReference for v in self.description.modelVariables}
        self.slave = instantiate_fmu(extract(path), self.description, "CoSimulation")
        self.slave.setupExperiment(tolerance=TOLERANCE, startTime=0.0, stopTime=STOP)
        self.slave.enterInitializationMode()

    def get(self, *names):
        return np.array(self.slave.getReal([self.references[name] for name in names]))

    def set(self, **values):
        self.slave.setReal([self.references[name] for name in values], list(values.values()))

    def get_derivatives(self, name, orders):
        """Derivatives of an output by time, of the orders from 1 on."""
        return [self.slave.getRealOutputDerivatives([self.references[name]], [order])[0] for order in range(1, orders + 1)]

    def set_series(self, name, value, derivatives):
        """The input goes on from a value with these derivatives during the next step."""
        reference = [self.references[name]]
        self.slave.setReal(reference, [value])
        for order, derivative in enumerate(derivatives, 1):
            self.slave.setRealInputDerivatives(reference, [order], [derivative])

    def set_line(self, begin, end, h, names):
        """The inputs go from `begin` to `end` in straight lines during the next step."""
        references = [self.references[name] for name in names]
        self.slave.setReal(references, list(begin))
        self.slave.setRealInputDerivatives(references, [1] * len(names), list((end - begin) / h))

    def step(self, time, h):
        self.slave.doStep(time, h, noSetFMUStatePriorToCurrentPoint=False)

    @contextmanager
    def saved(self):
        """The present state; call what is given to return to it."""
        state = self.slave.getFMUState()
        try:
            yield lambda: self.slave.setFMUState(state)
        finally:
            self.slave.freeFMUState(state)

    def close(self):
        self.slave.terminate()
        self.slave.freeInstance()


SLIDER = ("cylinder.s", "cylinder.v")
END = ("end_s", "end_v")


def at_once(crank, load, time, h, force):
    load.set(**dict(zip(END, crank.get(*SLIDER))))
    crank.set(pull=force[0])
    crank.step(time, h)
    load.step(time, h)
    return load.get("pull"), 1


def extrapolated(crank, load, time, h, force):
    begin, further = crank.get(*SLIDER), [crank.get_derivatives(name, orders) for name, orders in zip(SLIDER, (2, 1))]
    crank.set_series("pull", force[0], load.get_derivatives("pull", 1) if time > 0.0 else [])
    for name, value, derivatives in zip(END, begin, further):
        load.set_series(name, value, derivatives)
    crank.step(time, h)
    load.step(time, h)
    return load.get("pull"), 1


def gauss_seidel(crank, load, time, h, force):
    crank.set(pull=force[0])
    crank.step(time, h)
    load.set(**dict(zip(END, crank.get(*SLIDER))))
    load.step(time, h)
    return load.get("pull"), 1


def iterated(crank, load, time, h, force):
    begin, guess = crank.get(*SLIDER), force
    with crank.saved() as restore_crank, load.saved() as restore_load:
        for iteration in range(1, MOST_ITERATIONS + 1):
            crank.set_line(force, guess, h, ["pull"])
            crank.step(time, h)
            load.set_line(begin, crank.get(*SLIDER), h, END)
            load.step(time, h)
            answer = load.get("pull")
            if abs(answer - guess)[0] <= FORCE_TOLERANCE:
                return answer, iteration
            guess = answer
            restore_crank()
            restore_load()
    raise RuntimeError(f"the force does not settle at t = {time}; take a shorter step")


def couple(folder, master, steps):
    """Slider and sledge at all communication points, and the mean number of repetitions of a step."""
    crank, load = Fmu(folder, "crank"), Fmu(folder, "load")
    load.set(**dict(zip(END, crank.get(*SLIDER))))
    force = load.get("pull")
    crank.set(pull=force[0])
    for fmu in (crank, load):
        fmu.slave.exitInitializationMode()
    h, rows, iterations = STOP / steps, [], 0
    for k in range(steps):
        force, count = master(crank, load, k * h, h, force)
        rows.append([crank.get("cylinder.s")[0], load.get("rail.s")[0]])
        iterations += count
    for fmu in (crank, load):
        fmu.close()
    return np.array(rows), iterations / steps


def main(folder):
    folder = Path(folder)
    columns = ["cylinder.s", "rail.s"]
    whole = simulate_fmu(
        str(folder / "whole.fmu"),
        stop_time=STOP,
        output_interval=STOP / max(STEPS),
        relative_tolerance=TOLERANCE,
        output=columns,
        fmi_type="CoSimulation",
    )
    exact = np.array([whole[column] for column in columns]).T
    masters = {"at once": at_once, "Gauss-Seidel": gauss_seidel, "extrapolated": extrapolated, "iterated": iterated}
    print(f"{'step [ms]':>10}" + "".join(f"{name + ' [m]':>18}" for name in masters) + f"{'iterations':>12}")
    for steps in STEPS:
        every = max(STEPS) // steps
        results = [couple(folder, master, steps) for master in masters.values()]
        errors = [np.max(abs(rows - exact[every::every])) for rows, _ in results]
        print(f"{1e3 * STOP / steps:10g}" + "".join(f"{error:18.1e}" for error in errors) + f"{results[-1][1]:12.1f}", flush=True)


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    try:
        main(*sys.argv[1:])
    except (FMICallException, BadZipFile, OSError) as failure:
        sys.exit(f"error: {failure}")
