"""Fits a coupler curve to ten points, reached at equal times of a turn: python coupler.py [picture.svg]"""

import sys
from pathlib import Path

import numpy as np
from measure import compare
from scipy.optimize import least_squares

import cotree

#: A straight stroke and a return above it [m].
ANGLES = np.linspace(0, np.pi, 6)[1:-1]
POINTS = np.array(
    [[x, 0.0] for x in np.linspace(0.5, -0.5, 6)] + [[-0.5 * np.cos(angle), 0.4 * np.sin(angle)] for angle in ANGLES]
)
TIMES = np.arange(10) / 10
OF = ["coupler.pen.x", "coupler.pen.y"]


def main(picture=None):
    model = cotree.load(Path(__file__).with_suffix(".toml"))
    start = {name: variable.start for name, variable in model.variables.items() if variable.causality == "parameter"}
    to = [name for name in start if "." not in name]
    found = {}

    def at(values):
        """Positions of the pen and their derivatives: both come from one call."""
        key = tuple(values)
        if key not in found:
            found[key] = model.sensitivities(OF, to, TIMES, set=dict(zip(to, map(float, values), strict=True)))
        return found[key]

    def distances(values):
        try:
            return (at(values).values - POINTS).ravel()
        except (cotree.SceneError, cotree.RunError):
            return np.full(POINTS.size, 10.0)  # it cannot turn: farther away than anything else

    is_length = ["length" in name for name in to]
    first = np.array([start[name] for name in to])
    fit = least_squares(
        distances,
        first,
        jac=lambda values: at(values).derivatives.reshape(-1, len(to)),
        bounds=(np.where(is_length, 0.1, -np.inf), np.where(is_length, 2.0, np.inf)),
        x_scale=0.3,
    )
    rms = [np.sqrt(np.mean((at(values).values - POINTS) ** 2)) for values in (first, fit.x)]
    print(f"distance of the points: {1e3 * rms[0]:.1f} mm RMS, after {fit.nfev} evaluations {1e3 * rms[1]:.2f} mm")
    best = dict(zip(to, map(float, fit.x), strict=True))
    print(", ".join(f"{name} {value:.4f}" for name, value in best.items()))
    # The linkage has become another one: so have the guesses that pick its assembly.
    guesses = ["coupler.angle", "rocker.angle"]
    pose = model.sensitivities(guesses, "phase", [0], set=best).values[0]
    best |= dict(zip(guesses, map(float, pose), strict=True))
    compare(model, OF, to, TIMES, best)
    if picture:
        draw(model, {name: start[name] for name in to}, best, picture)


def draw(model, start, best, picture):
    from matplotlib import pyplot

    figure, axes = pyplot.subplots(figsize=(6, 4), layout="constrained")
    for settings, label, style in ((start, "start", "--"), (best, "fitted", "-")):
        run = model.simulate(set=settings)
        axes.plot(run[OF[0]], run[OF[1]], style, label=label)
    axes.plot(*POINTS.T, "o", color="black", markersize=4, label="points")
    axes.set(xlabel="x [m]", ylabel="y [m]", aspect="equal")
    axes.legend(loc="upper left")
    figure.savefig(picture)


if __name__ == "__main__":
    main(*sys.argv[1:])
