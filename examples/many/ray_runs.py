"""Spreads runs over a Ray cluster: the model is put into its store once, and a task that is lost is made again elsewhere.

usage: ray_runs.py [RUNS] [WORKERS]
"""

import sys
import time
from pathlib import Path

import ray
from runs import chunks, report, work

import cotree

SCENE = Path(__file__).parents[2] / "models/slider_crank/scene.toml"


def main(runs: int = 20_000, workers: int = 2) -> None:
    # A cluster elsewhere: ray.init("auto").
    ray.init(num_cpus=workers, include_dashboard=False, log_to_driver=False)
    task = ray.remote(num_cpus=1, max_retries=3)(work)
    model = ray.put(cotree.load(SCENE))
    ray.get([task.remote(model, chunk) for chunk in chunks(workers, workers)])  # processes are there before the clock runs
    begin = time.perf_counter()
    rows = ray.get([task.remote(model, chunk) for chunk in chunks(runs, 4 * workers)])
    report(rows, time.perf_counter() - begin, workers)
    ray.shutdown()


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
