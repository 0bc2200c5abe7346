"""Copies the licence texts of everything that is linked into `cotree`, a folder for each crate, with a list of all.

usage: cargo metadata --format-version 1 --filter-platform TRIPLE | licences.py FOLDER
"""

import json
import re
import shutil
import sys
from pathlib import Path

TEXT = re.compile(r"(licen[cs]e|copying|copyright|notice|unlicense)", re.IGNORECASE)


def linked(metadata):
    """The packages that the program needs when it runs, without itself."""
    nodes = {node["id"]: node for node in metadata["resolve"]["nodes"]}
    found, waiting = set(), [package["id"] for package in metadata["packages"] if package["name"] == "cotree-cli"]
    while waiting:
        for dependency in nodes[waiting.pop()]["deps"]:
            if dependency["pkg"] not in found and any(kind["kind"] is None for kind in dependency["dep_kinds"]):
                found.add(dependency["pkg"])
                waiting.append(dependency["pkg"])
    return sorted((package for package in metadata["packages"] if package["id"] in found and package["source"]), key=lambda package: package["id"])


def main(folder):
    rows = []
    for package in linked(json.load(sys.stdin)):
        name = f"{package['name']}-{package['version']}"
        root = Path(package["manifest_path"]).parent
        texts = [path for path in root.iterdir() if path.is_file() and TEXT.match(path.name)]
        if package["license_file"]:
            texts.append(root / package["license_file"])
        for text in set(texts):
            (folder / name).mkdir(parents=True, exist_ok=True)
            shutil.copyfile(text, folder / name / text.name)
        rows.append(f"{name}: {package['license']}, {package['repository'] or ', '.join(package['authors'])}")
    if not rows:
        sys.exit("nothing is linked: is this the metadata of cotree?")
    (folder / "LIST.txt").write_text("\n".join(rows) + "\n")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
