"""Sizes the drive of a lifting arm: the spring with which its motor needs the least effective torque: python drive.py [picture.svg]"""

import sys
from pathlib import Path

import numpy as np
from measure import compare
from scipy.optimize import least_squares

import cotree

OF = ["motor.torque"]
TO = ["stiffness", "anchor", "grip"]
#: A cycle without its end, which is its beginning.
TIMES = np.arange(100) / 50
LOW, HIGH = [0.0, 0.3, 0.1], [2000.0, 0.7, 0.6]


def main(picture=None):
    model = cotree.load(Path(__file__).with_suffix(".toml"))
    start = {name: model.variables[name].start for name in TO}

    def at(values):
        return model.sensitivities(OF, TO, TIMES, set=dict(zip(TO, map(float, values), strict=True)))

    fit = least_squares(
        lambda values: at(values).values.ravel(),
        list(start.values()),
        jac=lambda values: at(values).derivatives.reshape(-1, len(TO)),
        bounds=(LOW, HIGH),
        x_scale=[100, 0.1, 0.1],
    )
    best = dict(zip(TO, map(float, fit.x), strict=True))
    cycles = {}
    for name, settings in (("without spring", {"stiffness": 0.0}), ("start", start), ("sized", best)):
        run = cycles[name] = model.simulate(set=settings)
        torque, power = run["motor.torque"], run["motor.power"]
        effective = np.sqrt(np.mean(torque[:-1] ** 2))
        print(
            f"{name}: effective torque {effective:.2f} N.m, largest {abs(torque).max():.1f} N.m, "
            f"largest power {abs(power).max():.0f} W"
        )
    print(", ".join(f"{name} {value:.4g}" for name, value in best.items()) + f", after {fit.nfev} evaluations")
    compare(model, OF, TO, TIMES, best)
    if picture:
        draw(cycles, picture)


def draw(cycles, picture):
    from matplotlib import pyplot

    figure, axes = pyplot.subplots(figsize=(6, 3.6), layout="constrained")
    for (name, run), style in zip(cycles.items(), (":", "--", "-"), strict=True):
        axes.plot(run.time, run["motor.torque"], style, label=name)
    axes.set(xlabel="time [s]", ylabel="torque of the motor [N.m]")
    axes.legend()
    figure.savefig(picture)


if __name__ == "__main__":
    main(*sys.argv[1:])
