"""Runs an FMU over its default experiment and prints a table of its outputs.

usage: run.py MODEL.fmu
"""

import sys

from fmpy import read_model_description, simulate_fmu


def main(fmu, rows=10):
    experiment = read_model_description(fmu).defaultExperiment
    start, stop = float(experiment.startTime), float(experiment.stopTime)
    result = simulate_fmu(fmu, output_interval=(stop - start) / rows)
    widths = [max(12, len(name)) for name in result.dtype.names]
    print("  ".join(f"{name:>{width}}" for name, width in zip(result.dtype.names, widths)))
    for row in result:
        print("  ".join(f"{value:{width}.6g}" for value, width in zip(row, widths)))


if __name__ == "__main__":
    main(sys.argv[1])
