"""What the examples beside this share: a sweep in chunks, each a task for whoever distributes them."""

import time

import numpy as np

import cotree

MEASURES = ["peak(cylinder.fn)", "range(cylinder.s)"]


def parameters(runs: int) -> dict[str, np.ndarray]:
    """Tolerances of two parts: the same for the same number of runs, wherever it is called."""
    draw = np.random.default_rng(1)
    return {"crank_length": draw.normal(0.5, 1e-3, runs), "rod_length": draw.normal(1.5, 2e-3, runs)}


def chunks(runs: int, tasks: int) -> list[dict[str, np.ndarray]]:
    """The runs of each task. A task of a second or more costs nothing to schedule."""
    table = parameters(runs)
    parts = np.array_split(np.arange(runs), tasks)
    return [{name: column[part] for name, column in table.items()} for part in parts]


def work(model: cotree.Model, chunk: dict[str, np.ndarray]) -> tuple[np.ndarray, float]:
    """A task: a row of numbers for each run, and how long it took [s]. One thread: the workers share the processors."""
    begin = time.perf_counter()
    table = model.measure(MEASURES, chunk, stop=2, threads=1)
    return np.column_stack([table[name] for name in MEASURES]), time.perf_counter() - begin


def report(rows: list[tuple[np.ndarray, float]], elapsed: float, workers: int) -> None:
    """Prints what came out, and the share of the time that was not spent in runs."""
    values = np.concatenate([values for values, _ in rows])
    spent = sum(seconds for _, seconds in rows) / workers
    for name, column in zip(MEASURES, values.T, strict=True):
        print(f"{name}: mean {column.mean():.9g}, standard deviation {column.std():.6g}")
    print(f"{len(values)} runs, {len(values) / elapsed:.0f} a second; {100 * max(0.0, 1 - spent / elapsed):.1f} % of the time for scheduling")
