"""Derivatives of the motion against finite differences of runs: how long, how accurate."""

from __future__ import annotations

import time

import numpy as np

#: Times that are measured; the fastest counts.
REPEATS = 3


def fastest(work):
    """The result and the time [s]."""
    taken = []
    for _ in range(REPEATS):
        begin = time.perf_counter()
        result = work()
        taken.append(time.perf_counter() - begin)
    return result, min(taken)


def compare(model, of, to, times, values):
    """Prints time and error of the derivatives of `of` by `to`, exact ones and forward differences as optimisers make them."""
    times = np.asarray(times, dtype=float)
    step = times[1] - times[0]
    stop = float(times[-1])

    def run(settings, tolerance=None):
        results = model.simulate(set=settings, outputs=of, stop=stop, step=step, tolerance=tolerance)
        return np.stack([results[name] for name in of], axis=1)

    def differences(relative, weights, tolerance=None):
        columns = []
        for name in to:
            size = relative * max(abs(values[name]), 1e-3)
            moved = [weight * run({**values, name: values[name] + place * size}, tolerance) for place, weight in weights.items()]
            columns.append(sum(moved) / size)
        return np.stack(columns, axis=2)

    reference = differences(1e-3, {-3: -1 / 60, -2: 3 / 20, -1: -3 / 4, 1: 3 / 4, 2: -3 / 20, 3: 1 / 60}, 1e-13)
    scale = np.abs(reference).max(axis=(0, 1))
    run(values)
    exact, exactly = fastest(lambda: model.sensitivities(of, to, times, set=values).derivatives)
    forward, roughly = fastest(lambda: differences(1.5e-8, {0: -1.0, 1: 1.0}))
    for name, found, taken in (("exact", exact, exactly), ("forward differences", forward, roughly)):
        error = (np.abs(found - reference) / scale).max()
        print(f"{name}: {1e3 * taken:.1f} ms, largest error {error:.1e}")
