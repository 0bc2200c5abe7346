"""Validates model descriptions against the official FMI 2.0 schema, which comes with fmpy.

usage: schema.py MODEL_DESCRIPTION...
"""

import sys
from pathlib import Path

import fmpy
from lxml import etree


def main(files):
    schema = etree.XMLSchema(etree.parse(Path(fmpy.__file__).parent / "schema/fmi2/fmi2ModelDescription.xsd"))
    valid = True
    for file in files:
        if not schema.validate(etree.parse(file)):
            valid = False
            print(f"{file}: {schema.error_log}")
    return 0 if valid else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
