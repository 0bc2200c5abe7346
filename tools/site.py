#!/usr/bin/env python3
"""A site of plain files: the gallery, each model as a page that moves, and the page to draw in. Any server of files can hand it out.

    tools/site.py FOLDER [--cotree target/release/cotree] [--runtimes target/runtimes] [--models four_bar,jansen]

Needs the program, and the runtimes for browsers (tools/build-runtimes.sh web).
"""

import argparse
import base64
import html
import pathlib
import re
import shutil
import subprocess
import zlib

ROOT = pathlib.Path(__file__).resolve().parent.parent
PAGE = """<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta http-equiv="Content-Security-Policy" content="default-src 'none'; style-src 'unsafe-inline'; img-src 'self' data:; base-uri 'none'; form-action 'none'">
<link rel="icon" href="data:,">
<title>cotree: mechanisms in motion</title>
<style>
:root{color-scheme:light dark;--line:#8885}
body{margin:0 auto;max-width:76rem;padding:20px;font:15px/1.5 system-ui,sans-serif}
ul{list-style:none;padding:0;display:grid;grid-template-columns:repeat(auto-fill,minmax(min(18rem,100%),1fr));gap:14px}
li{border:1px solid var(--line);border-radius:10px;overflow:hidden;display:flex;flex-direction:column}
img{width:100%;height:11rem;object-fit:contain;background:#fff}
li div{padding:10px 14px;flex:1}
h2{font-size:16px;margin:0}
p{margin:4px 0;opacity:.8}
nav{display:flex;border-top:1px solid var(--line)}
nav a,.begin{flex:1;min-height:44px;display:grid;place-items:center}
.begin{display:inline-grid;padding:0 18px;border:1px solid var(--line);border-radius:8px}
</style>
</head>
<body>
<h1>Mechanisms in motion</h1>
<p>Each moves with the solver that is in its FMU, and can be pulled and changed. Draw your own, and take its FMU away with you.</p>
<p><a class="begin" href="draw.html">Draw a mechanism</a></p>
<ul>
{{cards}}
</ul>
</body>
</html>
"""


def value(text, key):
    found = re.search(rf'^{key}\s*=\s*"([^"]*)"', text, re.M)
    return found[1] if found else ""


def card(name, text, drawable):
    title = html.escape(name.replace("_", " "))
    packed = base64.urlsafe_b64encode(zlib.compress(text.encode(), 9)).decode().rstrip("=")
    draw = f'<a href="draw.html#scene={packed}">Draw</a>' if drawable else ""
    return (
        f'<li><img src="{name}.svg" alt="" loading="lazy"><div><h2>{title}</h2><p>{html.escape(value(text, "description"))}</p></div>'
        f'<nav><a href="{name}.html" aria-label="{title} in motion">Motion</a>{draw}</nav></li>'
    )


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--cotree", default=str(ROOT / "target/release/cotree"))
    parser.add_argument("--runtimes", default=str(ROOT / "target/runtimes"))
    parser.add_argument("--models", help="some of them, by name and with commas [default: all]")
    options = parser.parse_args()
    options.folder.mkdir(parents=True, exist_ok=True)
    folders = sorted(path.parent for path in (ROOT / "models").glob("*/scene.toml"))
    wanted = options.models.split(",") if options.models else [folder.name for folder in folders]
    missing = set(wanted) - {folder.name for folder in folders}
    if missing:
        raise SystemExit(f"there is no model {', '.join(sorted(missing))}")
    cards = []
    for folder in folders:
        if folder.name not in wanted:
            continue
        page = options.folder / f"{folder.name}.html"
        subprocess.run([options.cotree, "view", folder / "scene.toml", "-o", page, "--runtimes", options.runtimes], check=True)
        shutil.copyfile(folder / "picture.svg", options.folder / f"{folder.name}.svg")
        # A page reads no files: scenes with parts or tables of their own are not drawn in it.
        others = {path.suffix for path in folder.iterdir() if path.name not in ("scene.toml", "expected.csv")}
        cards.append(card(folder.name, (folder / "scene.toml").read_text(), not others & {".toml", ".csv"}))
    subprocess.run([options.cotree, "draw", "-o", options.folder / "draw.html", "--runtimes", options.runtimes], check=True)
    (options.folder / "index.html").write_text(PAGE.replace("{{cards}}", "\n".join(cards)))
    print(options.folder / "index.html")


if __name__ == "__main__":
    main()
