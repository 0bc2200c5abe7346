"""Loops in Model Exchange: fmpy's CVode at three tolerances, with the events that the FMU requests to close the loops and with these ignored. Handling them must not cost accuracy, and they are few.

usage: drift.py COTREE MODELS WORK
"""

import csv
import subprocess
import sys
from pathlib import Path

import numpy as np
from fmpy import read_model_description, simulate_fmu
from fmpy.fmi2 import FMU2Model

TOLERANCES = [1e-4, 1e-6, 1e-8]
# Closed loops that nothing drives, and one with hard stops.
MODELS = ["bench_slider_crank", "andrews", "double_wishbone", "gripper"]
STOP = 2.0
# Errors are those of CVode, which begins anew at each event: they scatter.
SCATTER = 3.0
# The FMU requests no event for the loops before so many steps; fmpy completes one at each output.
STEPS = 100


class Counted:
    """Whether fmpy ignores requests, how many there have been, and the tolerance that is given to the FMU."""

    ignored, requests, tolerance = False, 0, None


completed, setup = FMU2Model.completedIntegratorStep, FMU2Model.setupExperiment


def complete(fmu, *arguments, **options):
    requested, ended = completed(fmu, *arguments, **options)
    Counted.requests += bool(requested)
    return requested and not Counted.ignored, ended


def set_up(fmu, **options):
    return setup(fmu, **{**options, "tolerance": Counted.tolerance})


FMU2Model.completedIntegratorStep, FMU2Model.setupExperiment = complete, set_up


def called(*command):
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


def reference(cotree, scene, stop, step):
    rows = list(csv.reader(called(cotree, "simulate", scene, "-o", "-", "--tolerance", "1e-12", "--stop", f"{stop} s", "--step", f"{step} s").splitlines()))
    values = np.array([[float(cell) for cell in row] for row in rows[1:]])
    return {head.split(" [")[0]: values[:, column] for column, head in enumerate(rows[0])}


def run(fmu, expected, outputs, stop, step, tolerance):
    """The largest error of an output relative to its largest value, and how many events were requested."""
    Counted.requests = 0
    found = simulate_fmu(str(fmu), fmi_type="ModelExchange", relative_tolerance=tolerance, stop_time=stop, output_interval=step, output=outputs, record_events=False)
    count = min(len(found), len(expected["time"]))
    errors = [np.max(np.abs(found[name][:count] - expected[name][:count])) / np.max(np.abs(expected[name])) for name in outputs]
    return max(errors), Counted.requests


def check(cotree, models, work, model):
    scene, fmu = models / model / "scene.toml", work / f"{model}.fmu"
    called(cotree, "export", scene, "-o", fmu)
    experiment = read_model_description(str(fmu)).defaultExperiment
    stop, step = min(STOP, float(experiment.stopTime)), float(experiment.stepSize)
    expected = reference(cotree, scene, stop, step)
    known = [variable.name for variable in read_model_description(str(fmu)).modelVariables if variable.causality == "output"]
    outputs = [name for name in known if np.max(np.abs(expected[name])) > 1e-6]
    for tolerance in TOLERANCES:
        Counted.ignored, Counted.tolerance = True, None
        ignored, _ = run(fmu, expected, outputs, stop, step, tolerance)
        Counted.ignored = False
        for Counted.tolerance in (None, tolerance):
            error, requests = run(fmu, expected, outputs, stop, step, tolerance)
            what = f"{model} at {tolerance:g}, given {Counted.tolerance}: error {error:.1e}, {requests} events; ignored {ignored:.1e}"
            print(what)
            assert error <= SCATTER * ignored + 1e-9, what
            # Those of stops and friction come on top: the gripper has eight.
            assert requests <= len(expected["time"]) / STEPS + 10, what


def main():
    cotree, models, work = (Path(argument) for argument in sys.argv[1:4])
    for model in MODELS:
        check(cotree, models, work, model)


if __name__ == "__main__":
    main()
