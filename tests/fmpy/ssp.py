"""Simulates the coupled example from its SSP file at two steps: the shorter one is closer to the undivided mechanism.

usage: ssp.py WHOLE.fmu BOTH.ssp        with crank.fmu and load.fmu beside WHOLE.fmu
"""

import sys
from pathlib import Path
from xml.etree import ElementTree as Xml
from zipfile import ZipFile

from fmpy import read_model_description, simulate_fmu
from fmpy.ssp.simulation import simulate_ssp

STOP = 0.5


def position(ssp, step):
    """The slider's position at the end: `simulate_ssp` labels a row with the time at which its step begins."""
    result = simulate_ssp(ssp, stop_time=STOP - step / 2, step_size=step)
    assert abs(result["time"][-1] + step - STOP) < 1e-9, result["time"][-1]
    return result["crank.cylinder.s"][-1]


def starts_fit(folder):
    """A master that does not carry values over before the first step starts without a kick: the inputs start where the outputs do."""
    starts, values = {}, {}
    for name in ("crank", "load"):
        path = str(folder / f"{name}.fmu")
        outputs = [v.name for v in read_model_description(path).modelVariables if v.causality == "output"]
        starts |= {v.name: float(v.start) for v in read_model_description(path).modelVariables if v.causality == "input"}
        values |= dict(zip(outputs, list(simulate_fmu(path, fmi_type="CoSimulation", stop_time=0.01, output=outputs)[0])[1:]))
    for start, output in (("end_s", "cylinder.s"), ("end_v", "cylinder.v"), ("pull", "pull")):
        assert abs(starts[start] - values[output]) < 1e-9, (start, starts[start], values[output])


def units_fit(folder, ssp):
    """Importers compare the units of connectors with those of the FMU's variables."""
    with ZipFile(ssp) as archive:
        structure = Xml.fromstring(archive.read("SystemStructure.ssd"))
    for component in structure.findall(".//{*}Component"):
        name = component.get("name")
        units = {v.name: v.unit for v in read_model_description(str(folder / f"{name}.fmu")).modelVariables}
        for connector in component.findall(".//{*}Connector"):
            wanted, given = connector.find("{*}Real").get("unit"), units[connector.get("name")]
            assert wanted == given, (name, connector.get("name"), wanted, given)


def main(whole, ssp):
    units_fit(Path(whole).parent, ssp)
    starts_fit(Path(whole).parent)
    exact = simulate_fmu(whole, fmi_type="CoSimulation", stop_time=STOP, output_interval=0.1)["cylinder.s"][-1]
    errors = [abs(position(ssp, step) - exact) for step in (0.01, 0.0025)]
    print(f"errors of the slider's position: {errors[0]:.2e} m, {errors[1]:.2e} m")
    assert errors[0] < 0.1 and errors[1] < errors[0] / 3, errors


if __name__ == "__main__":
    main(*sys.argv[1:])
