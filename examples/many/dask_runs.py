"""Spreads runs over a Dask cluster: the model is pickled once, and a task that is lost is made again elsewhere.

usage: dask_runs.py [RUNS] [WORKERS]
"""

import sys
import time
from pathlib import Path

from dask.distributed import Client, LocalCluster
from runs import chunks, report, work

import cotree

SCENE = Path(__file__).parents[2] / "models/slider_crank/scene.toml"


def main(runs: int = 20_000, workers: int = 2) -> None:
    model = cotree.load(SCENE)
    # A cluster elsewhere: Client("tcp://scheduler:8786").
    with LocalCluster(n_workers=workers, threads_per_worker=1, dashboard_address=None) as cluster, Client(cluster) as client:
        client.run(lambda: __import__("cotree").__version__)  # imported everywhere before the clock runs
        begin = time.perf_counter()
        everywhere = client.scatter(model, broadcast=True)
        tasks = [client.submit(work, everywhere, chunk) for chunk in chunks(runs, 4 * workers)]
        report(client.gather(tasks), time.perf_counter() - begin, workers)


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
