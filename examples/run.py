"""Runs an FMU over its default experiment, prints a table of its outputs, and plots them if matplotlib is installed.

usage: run.py MODEL.fmu [NAME=VALUE...]        sets parameters and inputs, in SI units
"""

import sys
from importlib.util import find_spec
from pathlib import Path
from zipfile import BadZipFile

from fmpy import read_model_description, simulate_fmu
from fmpy.fmi1 import FMICallException

ROWS = 10


def simulate(fmu, settings):
    description = read_model_description(fmu)
    settable = {v.name for v in description.modelVariables if v.causality in ("parameter", "input")}
    unknown = sorted(set(settings) - settable)
    if unknown:
        sys.exit(f"error: cannot set {', '.join(unknown)}; there are {', '.join(sorted(settable)) or 'none'}")
    stop = float(description.defaultExperiment.stopTime)
    start = float(description.defaultExperiment.startTime)
    return simulate_fmu(fmu, start_values=settings, output_interval=(stop - start) / (100 * ROWS))


def parse(setting):
    name, _, value = setting.partition("=")
    try:
        return name, float(value)
    except ValueError:
        sys.exit(f"error: {setting} is not of the form NAME=NUMBER")


def print_table(result):
    names = result.dtype.names
    widths = [max(12, len(name)) for name in names]
    print("  ".join(f"{name:>{width}}" for name, width in zip(names, widths)))
    for row in result[:: max(1, len(result) // ROWS)]:
        print("  ".join(f"{value:{width}.6g}" for value, width in zip(row, widths)))


def plot(result, path):
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    names = result.dtype.names[1:]
    figure, axes = pyplot.subplots(len(names), sharex=True, figsize=(8, 1 + 1.6 * len(names)), squeeze=False)
    for axis, name in zip(axes[:, 0], names):
        axis.plot(result["time"], result[name])
        axis.set_ylabel(name)
    axes[-1, 0].set_xlabel("time [s]")
    figure.tight_layout()
    figure.savefig(path)
    print(f"plot: {path}")


def main(fmu, *settings):
    result = simulate(fmu, dict(map(parse, settings)))
    print_table(result)
    if find_spec("matplotlib"):
        plot(result, Path(fmu).with_suffix(".png"))
    else:
        print("no plot: matplotlib is not installed")


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    try:
        main(*sys.argv[1:])
    except (FMICallException, BadZipFile, OSError) as failure:
        sys.exit(f"error: {failure}")
