"""The pages' code in Python runs as it is written, from top to bottom, in a folder with the models. Pages that Python makes have their solver in its process."""

import json
import os
import re
import shutil
import subprocess
import sys
import time
import urllib.error
import urllib.request

import matplotlib
import numpy
import pytest

import cotree

matplotlib.use("Agg")


@pytest.mark.parametrize("page", ["README.md", "docs/python.md", "docs/sensitivities.md"])
def test_the_code_of_a_page_runs(page, root, tmp_path, monkeypatch):
    shutil.copytree(root / "models", tmp_path / "models")
    monkeypatch.chdir(tmp_path)
    blocks = re.findall(r"^```python\n(.*?)^```", (root / page).read_text(), re.MULTILINE | re.DOTALL)
    assert blocks
    names = {}
    for block in blocks:
        exec(compile(block, page, "exec"), names)
    if page == "docs/python.md":
        assert names["results"].units["crank.angle"] == "rad"
        assert abs(names["model"].fit(names["measured"], vary="rod_length")["rod_length"] - 1.45) < 1e-3


@pytest.mark.parametrize("framework", ["jax", "torch"])
def test_the_gradients_for_frameworks_are_those_of_differences(framework, root, tmp_path, monkeypatch):
    pytest.importorskip(framework)
    shutil.copytree(root / "models", tmp_path / "models")
    monkeypatch.chdir(tmp_path)
    blocks = re.findall(r"^```python(?: no_run)?\n(.*?)^```", (root / "docs/python.md").read_text(), re.MULTILINE | re.DOTALL)
    names = {"np": numpy, "model": cotree.load("models/slider_crank/scene.toml")}
    [course] = [own for own in blocks if "def both" in own]
    [block] = [own for own in blocks if f"import {framework}\n" in own]
    exec(compile(course, "docs/python.md", "exec"), names)
    *before, last = block.strip().splitlines()
    exec(compile("\n".join(before), "docs/python.md", "exec"), names)
    gradient = numpy.asarray(eval(last, names))
    cost = lambda x: (names["both"](numpy.array(x))[0] ** 2).sum()
    for place, by in enumerate(numpy.eye(2) * 1e-6):
        assert gradient[place] == pytest.approx((cost([1.5, 0.5] + by) - cost([1.5, 0.5] - by)) / 2e-6, rel=1e-6)


def asked(address, call, origin):
    """What a page of this origin is told."""
    request = urllib.request.Request(f"{address}call/{call}", data=b"", headers={"Origin": origin}, method="POST")
    with urllib.request.urlopen(request, timeout=20) as answer:
        return answer.headers, json.load(answer)


def test_a_page_has_its_solver_in_this_process(slider_crank):
    page = slider_crank.page()
    [address] = re.findall(r'window\.cotreeServer = "(http://127\.0\.0\.1:\d+/\w{32}/)"', page)
    assert f"connect-src {address}" in page and address in cotree.loads(slider_crank.text).page()
    # The program, and the run that plays when this process has ended.
    assert all(re.search(f'id="{part}">[A-Za-z0-9+/=]{{100}}', page) for part in ("program", "run"))
    headers, models = asked(address, "front_gallery", "null")
    assert headers["Access-Control-Allow-Origin"] == "null" and "four_bar" in [own["name"] for own in models]
    with pytest.raises(urllib.error.HTTPError, match="403"):
        asked(address, "front_gallery", "http://elsewhere.example")
    still = slider_crank.page(served=False)
    assert "cotreeServer" not in still.split("<body", 1)[0] and 'id="program"></script>' in still


@pytest.mark.skipif(sys.platform != "linux", reason="xdg-open opens browsers on Linux")
def test_a_demo_opens_a_mechanism_that_moves(tmp_path):
    opened = tmp_path / "opened"
    browser = tmp_path / "xdg-open"
    browser.write_text(f'#!/bin/sh\necho "$1" > {opened}.new && mv {opened}.new {opened}\n')
    browser.chmod(0o755)
    environment = {**os.environ, "PATH": f"{tmp_path}:{os.environ['PATH']}"}
    process = subprocess.Popen([sys.executable, "-m", "cotree", "demo"], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, env=environment)
    try:
        address = process.stdout.readline().strip()
        deadline = time.monotonic() + 60
        while not opened.exists() and time.monotonic() < deadline:
            time.sleep(0.05)
        assert opened.read_text().strip() == address
        with urllib.request.urlopen(address, timeout=60) as answer:
            page = answer.read().decode()
        assert "jansen" in page and re.search('id="program">[A-Za-z0-9+/=]{100}', page)
    finally:
        process.kill()
        process.communicate()
