"""The package and programs that use it pass the strict checks of mypy."""

import json
import re
import subprocess
import sys
from pathlib import Path

import pytest

import cotree

PROGRAM = """
from decimal import Decimal

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
controlled = cotree.Builder("b").signal("u", type="pid", error="0.3[m] - cart.x", proportional="40 N/m", period="20 ms").model()
part: cotree.Results = results[0:10]
several: dict[str, np.ndarray] = results.at([0.1, 0.2])
once: dict[str, float] = results.at("20 ms")
grid: cotree.Table = model.sweep("max(cart.x)", {"rod.mass": [1, 2]}, progress=True, stop=1)
runs = model.simulate_many({"rod.mass": [1.0, 2.0]}, progress=lambda done, of: print(done, of), set={"push": Decimal("1.5")})
run.reset({"push": 1.0})
picture: cotree.Drawing = model.drawing()
film: cotree.Drawing = model.film(results, speed=2)
pictures: list[bytes] = model.frames(inputs={"push": lambda t, run: -run["cart.x"]}, fps=10)
costs, slopes = model.value_and_gradient(["last(cart.x)"], {f"push[{row}]": 0.5 for row in range(3)}, inputs={"time": [0, 1, 2], "push": np.zeros(3)})
A, B, C, D = model.linearize()
more: cotree.Model = model.builder().output("rod.x").model()
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


def test_a_program_passes_another_checker(tmp_path):
    pytest.importorskip("pyright")
    program = tmp_path / "program.py"
    program.write_text(PROGRAM)
    (tmp_path / "pyrightconfig.json").write_text(json.dumps({"pythonVersion": "3.11", "extraPaths": [str(Path(cotree.__file__).parent.parent)]}))
    command = [sys.executable, "-m", "pyright", "--pythonpath", sys.executable, str(program)]
    done = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path, check=False)
    assert done.returncode == 0, done.stdout + done.stderr


def test_wrong_keys_of_a_builder_are_found(tmp_path):
    pytest.importorskip("mypy")
    program = tmp_path / "program.py"
    program.write_text(
        "import cotree\n\nbuilt = cotree.Builder('a').body('b', mass=1, point={'p': [0, 1]})\n"
        "built.load('s', 'spirng', between=['ground', 'b'])\nbuilt.prismatic('j', 'ground', 'b', [1, 0], angle='3 deg', friction={'coulomb': 1, 'velocity': 0.01})\n"
        "built.sampled('c', 0.1, {'u': {'start': 0, 'nxt': 'u + 1'}}).event('e', 'b.x > 1', stops=True)\n"
    )
    folder = Path(cotree.__file__).parent.parent
    environment = {} if folder.name == "site-packages" else {"MYPYPATH": str(folder)}
    command = [sys.executable, "-m", "mypy", "--strict", "--cache-dir", str(tmp_path / "cache"), str(program)]
    done = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path, env=environment, check=False)
    wrong = [line for line in done.stdout.splitlines() if "error:" in line]
    assert len(wrong) == 4 and '"point"' in wrong[0] and "spirng" in wrong[1], done.stdout
    assert '"stops"' in wrong[2] and '"nxt"' in wrong[3], done.stdout


def test_the_types_of_keys_are_those_of_the_schema(root):
    done = subprocess.run([sys.executable, str(root / "tools/python/keys.py"), "--check"], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout


def test_the_programs_of_the_pages_are_typed(root, tmp_path):
    pytest.importorskip("mypy")
    pages = ["README.md", "docs/python.md", "docs/sensitivities.md"]
    for page in pages:
        blocks = re.findall(r"^```python\n(.*?)^```", (root / page).read_text(), re.MULTILINE | re.DOTALL)
        (tmp_path / f"{Path(page).stem.lower()}_page.py").write_text("\n".join(blocks))
    folder = Path(cotree.__file__).parent.parent
    environment = {} if folder.name == "site-packages" else {"MYPYPATH": str(folder)}
    # Of the packages that pages use some bring no types.
    command = [sys.executable, "-m", "mypy", "--strict", "--disable-error-code=import-untyped"]
    programs = sorted(map(str, tmp_path.glob("*_page.py")))
    done = subprocess.run([*command, "--cache-dir", str(tmp_path / "cache"), *programs], capture_output=True, text=True, cwd=tmp_path, env=environment, check=False)
    assert done.returncode == 0, done.stdout + done.stderr


def test_the_stubs_are_those_of_the_library(tmp_path):
    pytest.importorskip("mypy")
    done = subprocess.run([sys.executable, "-m", "mypy.stubtest", "cotree._cotree"], capture_output=True, text=True, cwd=tmp_path, check=False)
    assert done.returncode == 0, done.stdout
