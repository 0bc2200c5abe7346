"""Packs the two coupled FMUs and their connections as one file for tools that read SSP 1.0.

usage: ssp.py FOLDER OUT.ssp        with crank.fmu and load.fmu in FOLDER
"""

import sys
from pathlib import Path
from xml.etree import ElementTree as Xml
from zipfile import ZIP_DEFLATED, ZipFile, ZipInfo

SSD = "http://ssp-standard.org/SSP1/SystemStructureDescription"
SSC = "http://ssp-standard.org/SSP1/SystemStructureCommon"
OMS = "https://raw.githubusercontent.com/OpenModelica/OMSimulator/master/schema/oms.xsd"
COMPONENTS = {  # connectors: kind and unit
    "crank": {"pull": ("input", "N"), "cylinder.s": ("output", "m"), "cylinder.v": ("output", "m/s")},
    "load": {"end_s": ("input", "m"), "end_v": ("input", "m/s"), "pull": ("output", "N"), "rail.s": ("output", "m")},
}
UNITS = {"m": {"m": "1"}, "m/s": {"m": "1", "s": "-1"}, "N": {"kg": "1", "m": "1", "s": "-2"}}
STOP, STEP, TOLERANCE = "2", "0.001", "1e-9"
CONNECTIONS = [
    ("crank", "cylinder.s", "load", "end_s"),
    ("crank", "cylinder.v", "load", "end_v"),
    ("load", "pull", "crank", "pull"),
]


def structure():
    Xml.register_namespace("ssd", SSD)
    Xml.register_namespace("ssc", SSC)
    Xml.register_namespace("oms", OMS)
    name = f"{{{SSD}}}".__add__
    root = Xml.Element(name("SystemStructureDescription"), version="1.0", name="crank_and_load")
    system = Xml.SubElement(root, name("System"), name="crank_and_load")
    elements = Xml.SubElement(system, name("Elements"))
    for component, connectors in COMPONENTS.items():
        attributes = {"name": component, "type": "application/x-fmu-sharedlibrary", "source": f"resources/{component}.fmu"}
        element = Xml.SubElement(elements, name("Component"), attributes)
        ports = Xml.SubElement(element, name("Connectors"))
        for connector, (kind, unit) in connectors.items():
            port = Xml.SubElement(ports, name("Connector"), name=connector, kind=kind)
            Xml.SubElement(port, f"{{{SSC}}}Real", unit=unit)
    connections = Xml.SubElement(system, name("Connections"))
    for ends in CONNECTIONS:
        keys = ("startElement", "startConnector", "endElement", "endConnector")
        Xml.SubElement(connections, name("Connection"), dict(zip(keys, ends)))
    openmodelica(system, name, {"description": "oms-ma", "stepSize": STEP, "relativeTolerance": TOLERANCE})
    units = Xml.SubElement(root, name("Units"))
    for unit, exponents in UNITS.items():
        Xml.SubElement(Xml.SubElement(units, f"{{{SSC}}}Unit", name=unit), f"{{{SSC}}}BaseUnit", exponents)
    Xml.SubElement(root, name("DefaultExperiment"), startTime="0", stopTime=STOP)
    Xml.indent(root)
    return Xml.tostring(root, encoding="UTF-8", xml_declaration=True)


def openmodelica(system, name, master):
    """OMSimulator finds the kind of its master only in an annotation, and loads no system without one."""
    annotations = Xml.SubElement(system, name("Annotations"))
    annotation = Xml.SubElement(annotations, f"{{{SSC}}}Annotation", type="org.openmodelica")
    own = f"{{{OMS}}}".__add__
    information = Xml.SubElement(Xml.SubElement(annotation, own("Annotations")), own("SimulationInformation"))
    Xml.SubElement(information, own("FixedStepMaster"), master)


def main(folder, out):
    files = {"SystemStructure.ssd": structure()}
    for component in COMPONENTS:
        files[f"resources/{component}.fmu"] = (Path(folder) / f"{component}.fmu").read_bytes()
    with ZipFile(out, "w") as archive:
        for name, content in files.items():  # without dates: the same FMUs give the same file
            archive.writestr(ZipInfo(name), content, ZIP_DEFLATED)
    print(out)


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    try:
        main(*sys.argv[1:])
    except OSError as failure:
        sys.exit(f"error: {failure}")
