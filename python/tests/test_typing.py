"""The package and programs that use it pass the strict checks of mypy."""

import subprocess
import sys
from pathlib import Path

import pytest

import cotree

PROGRAM = """
import numpy as np
import cotree

model = cotree.load("scene.toml")
poles: np.ndarray = model.linearize("equilibrium").poles()
along: list[cotree.StateSpace] = model.linearize(np.linspace(0, 1, 3))
first: cotree.Mode = model.modes("1 s")[0]
results = model.replace({"rod.mass": np.float32(2)}).simulate(stop=np.float32(1), inputs={"push": lambda t: 2 * t})
run = model.start(set={"push": "1 N"})
run.step("20 ms", push=0.1 * run["cart.x"])
built = cotree.Builder("a").gravity(np.array([0.0, -9.81])).ground_point("p", np.array([0.0, 1.0])).signal("s", 1).model()
value, gradient = built.value_and_gradient("max(cart.x)", {"mass": 2.0})
try:
    found = model.fit({"time": [0, 1], "cart.x": [0, 1]}, {"mass": (0, None)}).model
except cotree.CotreeError as error:
    print(error)
"""


def test_the_package_and_a_program_are_typed(tmp_path):
    pytest.importorskip("mypy")
    program = tmp_path / "program.py"
    program.write_text(PROGRAM)
    folder = Path(cotree.__file__).parent.parent
    # What is installed is found by itself; a package that lies elsewhere is not.
    environment = {} if folder.name == "site-packages" else {"MYPYPATH": str(folder)}
    for checked in ([str(program)], ["-p", "cotree"]):
        command = [sys.executable, "-m", "mypy", "--strict", "--cache-dir", str(tmp_path / "cache"), *checked]
        done = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path, env=environment, check=False)
        assert done.returncode == 0, done.stdout + done.stderr


def test_the_stubs_are_those_of_the_library(tmp_path):
    pytest.importorskip("mypy")
    done = subprocess.run([sys.executable, "-m", "mypy.stubtest", "cotree._cotree"], capture_output=True, text=True, cwd=tmp_path, check=False)
    assert done.returncode == 0, done.stdout
