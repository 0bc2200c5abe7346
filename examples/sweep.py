"""Runs the slider-crank's FMU for many lengths of crank and rod, on all cores, with Dask.

usage: sweep.py SLIDER_CRANK.fmu [POINTS] [WORKERS]        POINTS lengths of either, 6 if not said
"""

import sys
from zipfile import BadZipFile

import numpy as np
from dask.distributed import Client, LocalCluster, as_completed
from fmpy import read_model_description, simulate_fmu
from fmpy.fmi1 import FMICallException

STOP = 2.0


def stroke(fmu, crank, rod):
    """How far the slider travels; not a number if crank and rod do not fit."""
    try:
        result = simulate_fmu(
            fmu,
            fmi_type="CoSimulation",
            start_values={"crank_length": crank, "rod_length": rod},
            stop_time=STOP,
            output_interval=0.01,
            output=["cylinder.s"],
        )
    except FMICallException:  # the FMU has said why
        return np.nan
    return float(np.ptp(result["cylinder.s"]))


def main(fmu, points=6, workers=None):
    read_model_description(fmu)  # a file that is no FMU is told once, not by every worker
    cranks = np.linspace(0.3, 0.6, points)
    rods = np.linspace(1.2, 2.0, points)
    with LocalCluster(n_workers=workers, threads_per_worker=1, dashboard_address=None) as cluster, Client(cluster) as client:
        runs = {client.submit(stroke, fmu, c, r): (i, j) for i, c in enumerate(cranks) for j, r in enumerate(rods)}
        strokes = np.empty((points, points))
        for done, run in enumerate(as_completed(runs), 1):
            strokes[runs[run]] = run.result()
            print(f"\r{done}/{len(runs)} runs", end="", file=sys.stderr, flush=True)
        print(file=sys.stderr)
    print("stroke [m]; crank length [m] down, rod length [m] across")
    print(" " * 8 + "".join(f"{rod:10.3f}" for rod in rods))
    for crank, row in zip(cranks, strokes):
        print(f"{crank:8.3f}" + "".join(f"{value:10.6f}" for value in row))


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    try:
        main(sys.argv[1], *map(int, sys.argv[2:]))
    except (BadZipFile, OSError, ValueError) as failure:
        sys.exit(f"error: {failure}")
