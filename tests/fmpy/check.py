"""Exports every model, runs its FMU in fmpy and compares it with the model's expected.csv.

usage: check.py COTREE MODELS WORK
"""

import csv
import subprocess
import sys
from pathlib import Path

import numpy as np
from fmpy import extract, instantiate_fmu, read_model_description, simulate_fmu
from fmpy.validation import validate_fmu

TOLERANCE = 1e-9
# Largest error of any output, relative to the largest value of its column.
LIMITS = {
    "slider_crank": 1e-7,
    "quick_return": 1e-9,
    "vibration": 1e-7,
    "pendulum": 1e-7,
    "double_pendulum": 1e-7,
    "four_bar": 1e-7,
    "cart_pole": 1e-7,
    "andrews": 1e-7,
    "bench_slider_crank": 1e-6,
    "planetary_gear": 1e-7,
    "rack_and_pinion": 1e-7,
    "rolling_disc": 1e-7,
    "scotch_yoke": 1e-7,
    "trammel": 1e-7,
    "friction": 1e-7,
    "gas_strut": 1e-7,
    "hydraulic_lever": 1e-6,
    "motor_four_bar": 1e-7,
    "excavator_arm": 1e-6,
    "balancing_cart": 1e-6,
    "barrier": 1e-5,
    "end_stop": 1e-5,
    "stick_slip": 1e-5,
    "chain_hoist": 1e-5,
    "gripper": 1e-6,
    "clutch_start": 1e-5,
    "worm_hoist": 1e-5,
    "friction_press": 1e-6,
    "play_train": 1e-5,
    "valve_train": 1e-5,
    "screw_lift": 1e-7,
    "metronome": 1e-7,
    "cam_follower": 1e-6,
    "cam_oscillating": 1e-6,
    "chebyshev": 1e-7,
    "double_wishbone": 1e-6,
    "engine": 1e-7,
    "excavator": 1e-7,
    "five_bar_robot": 1e-7,
    "gear_train": 1e-7,
    "geneva_slot": 1e-7,
    "jansen": 1e-7,
    "klann": 1e-7,
    "landing_gear": 1e-7,
    "peaucellier": 1e-7,
    "stephenson_six_bar": 1e-7,
    "toggle_press": 1e-7,
    "vibration_isolator": 1e-6,
    "watt_six_bar": 1e-7,
    "whitworth": 1e-7,
    "wiper": 1e-7,
}
ANDREWS_BETA = 15.8107711951537071  # rad, at 30 ms
MODEL_EXCHANGE_LIMIT = 1e-4  # the importer's own solver; the FMU asks for events to close its loops


class Model:
    """An exported FMU and what its outputs should be."""

    def __init__(self, cotree, folder, work):
        self.name = folder.name
        self.fmu = work / f"{self.name}.fmu"
        export = [cotree, "export", folder / "scene.toml", "-o", self.fmu]
        subprocess.run(export, check=True, stdin=subprocess.DEVNULL)
        self.unzipped = extract(self.fmu, work / self.name)
        self.description = read_model_description(self.unzipped)
        with open(folder / "expected.csv", newline="") as file:
            self.columns = next(csv.reader(file))[1:]
        table = np.loadtxt(folder / "expected.csv", delimiter=",", skiprows=1)
        self.times, self.expected = table[:, 0], table[:, 1:]
        self.references = [v.valueReference for v in self.description.modelVariables if v.name in self.columns]

    def simulate(self, fmi_type="CoSimulation", **more):
        result = simulate_fmu(
            self.unzipped,
            fmi_type=fmi_type,
            model_description=self.description,
            stop_time=self.times[-1],
            output_interval=self.times[1] - self.times[0],
            relative_tolerance=TOLERANCE,
            output=self.columns,
            record_events=False,
            **more,
        )
        return {name: result[name] for name in result.dtype.names}

    def instance(self):
        instance = instantiate_fmu(self.unzipped, self.description, "CoSimulation")
        self.start(instance)
        return instance

    def start(self, instance):
        instance.setupExperiment(tolerance=TOLERANCE, startTime=self.times[0])
        instance.enterInitializationMode()
        instance.exitInitializationMode()

    def step(self, instance, k):
        instance.doStep(self.times[k], self.times[k + 1] - self.times[k])
        return instance.getReal(self.references)


def free(instance):
    instance.terminate()
    instance.freeInstance()


def error(model, result):
    """The largest error relative to the column's scale, and the column's name."""
    worst = (0.0, "-")
    for column, expected in zip(model.columns, model.expected.T):
        assert len(result[column]) == len(expected), f"{len(result[column])} rows instead of {len(expected)}"
        scale = max(abs(expected))
        difference = max(abs(result[column] - expected)) / (scale if scale > 1e-6 else 1.0)
        if not difference <= worst[0]:  # also true for NaN
            worst = (difference, column)
    return worst


def check_values(model):
    result = model.simulate()
    worst, column = error(model, result)
    limit = LIMITS[model.name]
    assert worst <= limit, f"{column} is off by {worst:.1e} of its scale; limit {limit:.0e}"
    if model.name == "andrews":
        beta = result["beta"][-1]
        assert abs(beta - ANDREWS_BETA) <= 1e-8, f"beta(30 ms) = {beta!r}"
    return f"{worst:.1e} {column}"


def check_model_exchange(model):
    assert model.description.modelExchange is not None, "no driver follows an input, so there should be Model Exchange"
    worst, column = error(model, model.simulate("ModelExchange"))
    assert worst <= MODEL_EXCHANGE_LIMIT, f"{column} is off by {worst:.1e} of its scale"
    return f"{worst:.1e} {column}"


def check_independence(model):
    """Two instances in turns give the same bits as one alone."""
    steps = range(min(50, len(model.times) - 1))
    alone = model.instance()
    expected = [model.step(alone, k) for k in steps]
    free(alone)
    both = [model.instance(), model.instance()]
    for k in steps:
        for instance in both:
            assert model.step(instance, k) == expected[k], f"the instances differ at step {k}"
    for instance in both:
        free(instance)
    return "same bits"


def check_reset(model):
    """Run, terminate, reset and run again: the same bits."""
    steps = range(min(50, len(model.times) - 1))
    instance = model.instance()
    before = [model.step(instance, k) for k in steps]
    instance.terminate()
    instance.reset()
    model.start(instance)
    after = [model.step(instance, k) for k in steps]
    free(instance)
    assert before == after, "the second run differs"
    return "same bits"


def check_push(model):
    """A push of 2 N for one second on the cart: momentum and the rail's damping account for all of it."""
    table = np.array([(0, 2.0), (1, 2.0), (1, 0.0), (5, 0.0)], dtype=[("time", float), ("push", float)])
    r = model.simulate(input=table)
    cart_mass, pole_mass, half_pole, damping = 1.0, 0.2, 0.5, 0.5
    pole_speed = r["rail.v"] - half_pole * np.sin(r["pole.angle"]) * r["pole.omega"]
    momentum = cart_mass * r["rail.v"] + pole_mass * pole_speed + damping * r["rail.s"]
    worst = max(abs(momentum - 2.0 * np.minimum(r["time"], 1.0)))
    assert worst <= 1e-7, f"momentum is off by {worst:.1e} N.s"
    return f"{worst:.1e} N.s"


def check_valid(model):
    problems = validate_fmu(str(model.fmu))
    assert not problems, "; ".join(problems)
    return "no problems"


def main(cotree, models, work):
    checks = [check_valid, check_values, check_model_exchange, check_independence, check_reset]
    folders = sorted(scene.parent for scene in Path(models).glob("*/scene.toml"))
    assert {folder.name for folder in folders} == set(LIMITS), "LIMITS and the model folders differ"
    failures = 0
    for folder in folders:
        model = None
        extra = [check_push] if folder.name == "cart_pole" else []
        for check in checks + extra:
            try:
                model = model or Model(cotree, folder, Path(work).resolve())
                outcome = check(model)
            except Exception as fault:  # one model's failure must not hide the others'
                failures += 1
                outcome = f"FAILED: {fault}"
            print(f"{folder.name:20} {check.__name__[6:]:15} {outcome}", flush=True)
            if model is None:
                break
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
