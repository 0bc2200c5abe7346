"""Measures of a run and their derivatives, for optimisers."""

from __future__ import annotations

import re

import numpy as np

#: What has a derivative; `when_max` and `when_min` are communication points and have none.
MEASURES = ("max", "min", "peak", "range", "mean", "rms", "first", "last")


def measured(text: str) -> tuple[str, str]:
    """The measure and the variable of a text such as "max(rod.angle)"; a variable alone is its last value."""
    found = re.fullmatch(r"\s*(\w+)\s*\(\s*(.+?)\s*\)\s*", text)
    if found is None:
        return "last", text.strip()
    if found[1] not in MEASURES:
        raise ValueError(f"measures: {text!r}: {found[1]!r} is not one of {', '.join(MEASURES)}, which have derivatives")
    return found[1], found[2]


def course(
    variable: str, names: list[str], run: tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray | None]
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray | None]:
    """Times, a variable and its derivatives, and how the end moves; `time` is a variable, whose last value moves with the end."""
    time, values, derivatives, moves = run
    if variable != "time":
        column = names.index(variable)
        return time, values[:, column], derivatives[:, column], moves
    slopes = np.zeros((len(time), derivatives.shape[2]))
    if moves is not None:
        slopes[-1] = moves
    return time, time, slopes, moves


def reduced(
    measure: str, time: np.ndarray, values: np.ndarray, derivatives: np.ndarray, moves: np.ndarray | None = None
) -> tuple[float, np.ndarray]:
    """A measure of values over time, straight in between, and its derivatives; those of the values are (time, parameter).

    Where an event ends the run, its time moves so much with each parameter, and the last derivatives are those along with it.
    """
    ends = {"first": 0, "last": -1, "max": values.argmax(), "min": values.argmin(), "peak": np.abs(values).argmax()}
    if measure in ends:
        place = ends[measure]
        sign = -1.0 if measure == "peak" and values[place] < 0 else 1.0
        return float(sign * values[place]), sign * derivatives[place]
    if measure == "range":
        high, low = values.argmax(), values.argmin()
        return float(values[high] - values[low]), derivatives[high] - derivatives[low]
    step, (old, new) = np.diff(time), (values[:-1], values[1:])
    span, by = step.sum(), (derivatives[:-1], derivatives[1:])
    if span == 0:
        return reduced("last" if measure == "mean" else "peak", time, values, derivatives)
    longer = np.zeros(derivatives.shape[1]) if moves is None else moves
    if measure == "mean":
        mean = step @ (old + new) / (2 * span)
        return float(mean), (step @ (by[0] + by[1]) + (old[-1] + new[-1] - 2 * mean) * longer) / (2 * span)
    squares = old**2 + old * new + new**2
    rms = np.sqrt(step @ squares / (3 * span))
    change = (step * (2 * old + new)) @ by[0] + (step * (old + 2 * new)) @ by[1] + (squares[-1] - 3 * rms**2) * longer
    # Where all values are zero, the rms is at its least and has a corner there: zero is among its slopes, and an optimiser stays.
    return float(rms), change / (6 * span * rms) if rms > 0 else np.zeros_like(change)
