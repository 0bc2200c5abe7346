"""Packs the two coupled FMUs and their connections as one file for tools that read SSP 1.0.

usage: ssp.py FOLDER OUT.ssp        with crank.fmu and load.fmu in FOLDER
"""

import sys
from pathlib import Path
from xml.etree import ElementTree as Xml
from zipfile import ZIP_DEFLATED, ZipFile, ZipInfo

SSD = "http://ssp-standard.org/SSP1/SystemStructureDescription"
SSC = "http://ssp-standard.org/SSP1/SystemStructureCommon"
COMPONENTS = {
    "crank": {"pull": "input", "cylinder.s": "output", "cylinder.v": "output"},
    "load": {"end_s": "input", "end_v": "input", "pull": "output", "rail.s": "output"},
}
CONNECTIONS = [
    ("crank", "cylinder.s", "load", "end_s"),
    ("crank", "cylinder.v", "load", "end_v"),
    ("load", "pull", "crank", "pull"),
]


def structure():
    Xml.register_namespace("ssd", SSD)
    Xml.register_namespace("ssc", SSC)
    name = f"{{{SSD}}}".__add__
    root = Xml.Element(name("SystemStructureDescription"), version="1.0", name="crank_and_load")
    system = Xml.SubElement(root, name("System"), name="crank_and_load")
    elements = Xml.SubElement(system, name("Elements"))
    for component, connectors in COMPONENTS.items():
        attributes = {"name": component, "type": "application/x-fmu-sharedlibrary", "source": f"resources/{component}.fmu"}
        element = Xml.SubElement(elements, name("Component"), attributes)
        ports = Xml.SubElement(element, name("Connectors"))
        for connector, kind in connectors.items():
            port = Xml.SubElement(ports, name("Connector"), name=connector, kind=kind)
            Xml.SubElement(port, f"{{{SSC}}}Real")
    connections = Xml.SubElement(system, name("Connections"))
    for ends in CONNECTIONS:
        keys = ("startElement", "startConnector", "endElement", "endConnector")
        Xml.SubElement(connections, name("Connection"), dict(zip(keys, ends)))
    Xml.indent(root)
    return Xml.tostring(root, encoding="UTF-8", xml_declaration=True)


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
