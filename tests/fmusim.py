"""Runs every model in fmusim of the Reference-FMUs, in both versions and both interfaces, and compares its outputs with `cotree simulate`.

Nothing builds fmusim here: version 0.0.39 is the last one in C, and needs libxml2, minizip and the CVODE of SUNDIALS.

usage: fmusim.py FMUSIM COTREE MODELS
"""

import csv
import subprocess
import sys
import tempfile
from pathlib import Path

EVENTS = ["--event-mode-used", "--early-return-allowed", "--record-intermediate-values"]
# Version of FMI, interface, further options, largest difference: CVode has a tolerance, the integrator inside is the same.
RUNS = [
    ("2", "cs", [], 1e-9),
    ("3", "cs", [], 1e-9),
    ("3", "cs", EVENTS, 1e-9),
    ("2", "me", ["--tolerance", "1e-10"], 1e-6),
    ("3", "me", ["--tolerance", "1e-10"], 1e-6),
]


def run(*command):
    done = subprocess.run([str(part) for part in command], capture_output=True, text=True, check=False)
    if done.returncode:
        sys.exit(f"{command}: {done.returncode}\n{done.stdout}{done.stderr}")


def table(file):
    """The columns by name; of rows at one instant the last."""
    with open(file, newline="") as text:
        names, *rows = csv.reader(text)
    rows = {round(float(row[0]), 9): [float(value) for value in row] for row in rows}
    return names[1:], {time: row[1:] for time, row in rows.items()}


def difference(expected, found):
    """The largest difference of any output where both have a row, as a share of the output's largest value."""
    (names, rows), (others, points) = expected, found
    times = rows.keys() & points.keys()
    if len(times) < 10:
        sys.exit(f"only {len(times)} rows to compare")
    largest = 0.0
    for place, name in enumerate(names):
        other = others.index(name)
        scale = max(1.0, *(abs(row[place]) for row in rows.values()))
        largest = max(largest, *(abs(rows[time][place] - points[time][other]) / scale for time in times))
    return largest


def main(fmusim, cotree, models):
    wrong = 0
    for scene in sorted(Path(models).glob("*/scene.toml")):
        model = scene.parent.name
        with tempfile.TemporaryDirectory() as folder:
            work = Path(folder)
            # Model Exchange drifts with time: a short run is enough to see that it is the same motion.
            stop, step = 0.5, 0.01
            if model == "andrews":
                stop, step = 0.03, 0.0001
            run(cotree, "simulate", scene, "--stop", f"{stop} s", "--step", f"{step} s", "-o", work / "own.csv")
            own = table(work / "own.csv")
            for version, interface, options, limit in RUNS:
                fmu = work / f"{model}{version}.fmu"
                run(cotree, "export", scene, "--fmi", version, "-o", fmu)
                settings = ["--interface-type", interface, "--stop-time", stop, "--output-interval", step, *options]
                if interface == "me":
                    settings += ["--solver", "cvode"]
                run(fmusim, *settings, "--output-file", work / "out.csv", fmu)
                found = difference(own, table(work / "out.csv"))
                words = f"{'CS' if interface == 'cs' else 'ME'}{' with events' if options == EVENTS else ''}"
                print(f"{model} FMI {version}.0 {words}: {found:.1e}{'' if found <= limit else '  TOO MUCH'}")
                wrong += found > limit
    sys.exit(f"{wrong} runs differ" if wrong else 0)


if __name__ == "__main__":
    main(*sys.argv[1:])
