"""Validates descriptions of models, terminals and icons against the official schemas of their version of FMI, which come with fmpy.

usage: schema.py DESCRIPTION...
"""

import sys
from pathlib import Path

import fmpy
from lxml import etree


def main(files):
    valid = True
    for file in files:
        document = etree.parse(file)
        root = document.getroot()
        fmi = "fmi" + root.get("fmiVersion")[0]
        name = root.tag.replace("fmi", fmi, 1)
        schema = etree.XMLSchema(etree.parse(Path(fmpy.__file__).parent / f"schema/{fmi}/{name}.xsd"))
        if not schema.validate(document):
            valid = False
            print(f"{file}: {schema.error_log}")
    return 0 if valid else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
