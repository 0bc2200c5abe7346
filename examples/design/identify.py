"""Finds stiffness and friction from a noisy motion, with confidence limits: python identify.py [picture.svg]"""

import sys
import time
from pathlib import Path

import numpy as np
from measure import compare
from scipy.optimize import curve_fit

import cotree

TRUTH = {"stiffness": 640.0, "friction": 0.05, "drag": 1.8}
TIMES = np.linspace(0, 2, 201)
#: Standard deviation of what is measured [m].
NOISE = 0.5e-3


def main(picture=None):
    model = cotree.load(Path(__file__).with_suffix(".toml"))
    seen = model.simulate(set=TRUTH)["rail.s"] + NOISE * np.random.default_rng(1).normal(size=len(TIMES))
    begin = time.perf_counter()
    found = model.fit({"time": TIMES, "rail.s": seen}, list(TRUTH))
    taken = time.perf_counter() - begin
    for name, value in found.values.items():
        low, high = found.limits[name]
        print(f"{name}: {value:.5g} +- {found.errors[name]:.2g} {found.units[name]}, 95 % between {low:.5g} and {high:.5g}")
    print(f"residuals {1e3 * np.sqrt(np.mean(found.residuals['rail.s'] ** 2)):.4f} mm RMS")
    print(f"exact derivatives: {found.evaluations} motions, {1e3 * taken:.0f} ms")
    runs = 0

    def simulated(_, *values):
        nonlocal runs
        runs += 1
        return model.simulate(set=dict(zip(TRUTH, map(float, values), strict=True)))["rail.s"]

    begin = time.perf_counter()
    start = [model.variables[name].start for name in TRUTH]
    values, covariance = curve_fit(simulated, TIMES, seen, start, bounds=(0, np.inf), x_scale=start)
    taken = time.perf_counter() - begin
    errors = np.sqrt(np.diag(covariance))
    apart = (np.abs(values - list(found.values.values())) / errors).max()
    print(f"scipy.optimize.curve_fit with differences: {runs} runs, {1e3 * taken:.0f} ms, apart by {apart:.1e} standard errors")
    print(f"its standard errors differ by {np.abs(errors / list(found.errors.values()) - 1).max():.1e}")
    compare(model, ["rail.s"], list(TRUTH), TIMES, found.values)
    if picture:
        draw(found, seen, picture)


def draw(found, seen, picture):
    from matplotlib import pyplot

    figure, (above, below) = pyplot.subplots(2, figsize=(6, 4.5), sharex=True, layout="constrained")
    above.plot(TIMES, 1e3 * seen, ".", markersize=3, label="measured")
    above.plot(TIMES, 1e3 * found.fitted["rail.s"], label="fitted")
    above.set(ylabel="rail.s [mm]")
    above.legend()
    below.plot(TIMES, 1e3 * found.residuals["rail.s"], ".", markersize=3)
    below.axhline(0, linewidth=0.8, color="black")
    below.set(xlabel="time [s]", ylabel="residual [mm]")
    figure.savefig(picture)


if __name__ == "__main__":
    main(*sys.argv[1:])
