"""FMUs with C sources: compiled with all warnings, they move as the FMU with the full solver does, also with other inputs, parameters and initial values.

usage: sources.py COTREE MODELS WORK
"""

import subprocess
import sys
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
from fmpy import extract, read_model_description, simulate_fmu
from fmpy.validation import validate_fmu

STOP = 1.0
WARNINGS = ["-std=c99", "-pedantic", "-Wall", "-Wextra", "-Werror"]
STEP = ["--step", "1 ms"]
SERIES = ["--order", "8", "--step", "5 ms"]
SINGLE = [*STEP, "--real", "float"]
# Model, options, start values, and how far it may be from the full solver, relative to one or the value: what the method of order 4 misses with a step of 1 ms, that of order 8 with 5 ms, or single precision, and that events come at the end of a step.
CASES = [
    ("cart_pole", STEP, {}, 1e-8),
    ("cart_pole", STEP, {"push": 1.5, "cart_mass": 1.3, "pole.angle": 1.2}, 1e-8),
    ("four_bar", STEP, {}, 1e-5),
    ("four_bar", STEP, {"stall_torque": 6.0, "crank_length": 0.19}, 1e-5),
    ("motor_four_bar", STEP, {}, 1e-5),
    ("balancing_cart", STEP, {}, 5e-3),
    ("cart_pole", SERIES, {"push": 1.5, "cart_mass": 1.3, "pole.angle": 1.2}, 1e-8),
    ("four_bar", SERIES, {"stall_torque": 6.0, "crank_length": 0.19}, 1e-5),
    ("cart_pole", SINGLE, {"push": 1.5, "cart_mass": 1.3, "pole.angle": 1.2}, 1e-4),
    ("four_bar", SINGLE, {"stall_torque": 6.0, "crank_length": 0.19}, 1e-4),
    ("four_bar", [*SERIES, "--real", "float"], {}, 1e-4),
]


def listed(folder, version):
    """The files that are to be compiled, as the FMU says."""
    place, tag = [("modelDescription.xml", "File"), ("sources/buildDescription.xml", "SourceFile")][version - 2]
    return [file.get("name") for file in ElementTree.parse(folder / place).iter(tag)]


def compiled(fmu, version):
    """The FMU's folder, with a library for this machine."""
    folder = Path(extract(str(fmu)))
    description = read_model_description(str(folder))
    identifier = description.coSimulation.modelIdentifier
    assert description.modelExchange is None
    binaries = folder / "binaries" / ("linux64" if version == 2 else "x86_64-linux")
    binaries.mkdir(parents=True)
    sources = [folder / "sources" / name for name in listed(folder, version)]
    command = ["gcc", *WARNINGS, "-O2", "-fPIC", "-shared", "-I", folder / "sources", "-o", binaries / f"{identifier}.so", *sources, "-lm"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return folder


def export(cotree, scene, place, *options):
    done = subprocess.run([cotree, "export", scene, "-o", place, *options], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return place


def rows(fmu, start):
    return simulate_fmu(str(fmu), fmi_type="CoSimulation", start_values=start, stop_time=STOP, output_interval=0.05, relative_tolerance=1e-10)


def names(fmu):
    return [(v.name, v.valueReference, v.causality, v.unit, v.start) for v in read_model_description(str(fmu)).modelVariables]


def main(cotree, models, work):
    worst = []
    for version in (2, 3):
        for model, options, start, allowed in CASES:
            scene = Path(models) / model / "scene.toml"
            full = export(cotree, scene, Path(work) / f"full_{model}_{version}.fmu", "--fmi", str(version))
            lean = export(cotree, scene, Path(work) / f"sources_{model}_{version}.fmu", "--fmi", str(version), "--sources", *options)
            problems = validate_fmu(str(lean))
            assert not problems, problems
            # Event indicators are variables of FMI 3.0 for Model Exchange.
            assert [own for own in names(full) if not own[0].startswith("event_indicator_")] == names(lean)
            one, other = rows(full, start), rows(compiled(lean, version), start)
            assert one.dtype.names == other.dtype.names and len(one) == len(other)
            apart = max(float(np.max(np.abs(one[name] - other[name]) / (1 + np.abs(one[name])))) for name in one.dtype.names)
            worst.append(f"{model} {' '.join(options)} {start} FMI {version}: {apart:.1e}")
            assert apart < allowed, worst[-1]
    print("\n".join(worst))


if __name__ == "__main__":
    main(*sys.argv[1:])
