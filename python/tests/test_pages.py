"""The pages' code in Python runs as it is written, from top to bottom, in a folder with the models."""

import re
import shutil

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
