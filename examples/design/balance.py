"""Balances a slider-crank: the counterweight and its angle with the least shaking force: python balance.py [picture.svg]"""

import sys
from pathlib import Path

import numpy as np
from measure import compare
from scipy.optimize import least_squares

import cotree

OF = ["push", "lift"]
TO = ["counterweight", "angle"]
#: A turn.
TIMES = np.linspace(0, 2 * np.pi / 100, 101)


def main(picture=None):
    model = cotree.load(Path(__file__).with_suffix(".toml"))
    start = {name: model.variables[name].start for name in TO}

    def at(values):
        return model.sensitivities(OF, TO, TIMES, set=dict(zip(TO, map(float, values), strict=True)))

    fit = least_squares(
        lambda values: at(values).values.ravel(),
        list(start.values()),
        jac=lambda values: at(values).derivatives.reshape(-1, len(TO)),
        bounds=([0, -np.pi], [10, np.pi]),
        x_scale=[1, 0.1],
    )
    best = dict(zip(TO, map(float, fit.x), strict=True))
    forces = {}
    for name, settings in (("without", {"counterweight": 0.0}), ("start", start), ("balanced", best)):
        run = model.simulate(set=settings, outputs=OF)
        forces[name] = [run[push] for push in OF]
        force = np.hypot(*forces[name])
        print(f"{name}: shaking force {np.sqrt(np.mean(force**2)):.2f} N RMS, at most {force.max():.2f} N")
    weight = f"counterweight {1e3 * best['counterweight']:.3f} g, {np.degrees(best['angle']):.6f} deg out of line"
    print(f"{weight}, after {fit.nfev} evaluations")
    compare(model, OF, TO, TIMES, best)
    if picture:
        draw(forces, picture)


def draw(forces, picture):
    from matplotlib import pyplot

    figure, axes = pyplot.subplots(figsize=(5.5, 4.5), layout="constrained")
    for (name, pair), style in zip(forces.items(), (":", "--", "-"), strict=True):
        axes.plot(*pair, style, label=name)
    axes.set(xlabel="shaking force along the cylinder [N]", ylabel="across it [N]", aspect="equal")
    axes.legend(loc="upper right")
    figure.savefig(picture)


if __name__ == "__main__":
    main(*sys.argv[1:])
