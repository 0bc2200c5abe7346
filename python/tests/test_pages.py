"""The pages' code in Python runs as it is written, from top to bottom, in a folder with the models."""

import re
import shutil

import matplotlib
import pytest

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
