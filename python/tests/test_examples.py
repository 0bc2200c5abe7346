"""The examples do what their pages say."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import cotree

MANY = Path(__file__).parents[2] / "examples/many"


def run(script, *arguments, **environment):
    command = [sys.executable, str(MANY / script), *map(str, arguments)]
    return subprocess.run(command, env={**os.environ, **environment}, capture_output=True, text=True, check=False)


def printed(script, *arguments, **environment):
    done = run(script, *arguments, **environment)
    assert done.returncode == 0, done.stderr
    return done.stdout.splitlines()


@pytest.fixture(scope="module")
def alone():
    """The numbers of 400 runs in this process."""
    sys.path.insert(0, str(MANY))
    import runs

    values, _ = runs.work(cotree.load(MANY.parents[1] / "models/slider_crank/scene.toml"), runs.parameters(400))
    named = zip(runs.MEASURES, values.T, strict=True)
    return [f"{name}: mean {column.mean():.9g}, standard deviation {column.std():.6g}" for name, column in named]


def test_dask_gives_the_numbers_of_one_process(alone):
    pytest.importorskip("dask.distributed")
    assert printed("dask_runs.py", 400, 2)[:2] == alone


def test_ray_gives_the_numbers_of_one_process(alone):
    pytest.importorskip("ray")
    assert [line for line in printed("ray_runs.py", 400, 2) if "mean" in line] == alone


def test_a_dask_worker_that_dies_loses_nothing(alone):
    distributed = pytest.importorskip("dask.distributed")
    code = (
        "import os, sys, threading, time\n"
        f"sys.path.insert(0, {str(MANY)!r})\n"
        "import dask_runs\n"
        "def main():\n"
        "    made = dask_runs.LocalCluster\n"
        "    def cluster(**keys):\n"
        "        found = made(**keys)\n"
        "        worker = next(iter(found.workers.values()))\n"
        "        threading.Timer(0.3, worker.process.process.kill).start()\n"
        "        return found\n"
        "    dask_runs.LocalCluster = cluster\n"
        "    dask_runs.main(400, 2)\n"
        "if __name__ == '__main__':\n"
        "    main()\n"
    )
    assert distributed
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0 and done.stdout.splitlines()[:2] == alone, done.stderr


def test_an_array_of_jobs_goes_on_where_it_was_stopped(tmp_path, alone):
    for number in [0, 2]:
        printed("array_task.py", 400, 3, tmp_path / "out", SLURM_ARRAY_TASK_ID=str(number))
    early = run("array_task.py", 400, 3, tmp_path / "out", "--join")
    assert early.returncode == 1 and "--array=1" in early.stderr
    written = (tmp_path / "out/0.npz").stat().st_mtime_ns
    for number in range(3):
        printed("array_task.py", 400, 3, tmp_path / "out", SLURM_ARRAY_TASK_ID=str(number))
    assert (tmp_path / "out/0.npz").stat().st_mtime_ns == written
    lines = printed("array_task.py", 400, 3, tmp_path / "out", "--join")
    assert lines[:2] == alone and lines[2] == "400 runs"
    assert np.load(tmp_path / "out/1.npz")["rows"].shape == (133, 2)


def designed(name, picture):
    """What an example of design prints, by the word before the colon; its numbers."""
    pytest.importorskip("scipy")
    lines = printed(MANY.parent / "design" / f"{name}.py", *([picture] if picture else []))
    numbers = re.compile(r"[-+]?\d+\.?\d*(?:e[-+]?\d+)?")
    return {line.split(":")[0]: [float(text) for text in numbers.findall(line.partition(":")[2])] for line in lines if ":" in line}, lines


def test_a_coupler_curve_comes_near_its_points(tmp_path):
    pytest.importorskip("matplotlib")
    found, _ = designed("coupler", tmp_path / "curve.svg")
    start, _, fitted = found["distance of the points"]
    assert start > 200 and fitted < 36
    assert found["exact"][1] < 1e-9 and (tmp_path / "curve.svg").stat().st_size > 10_000


def test_a_balanced_slider_crank_is_that_of_linear_least_squares():
    found, lines = designed("balance", None)
    assert found["balanced"][0] < 0.5 * found["without"][0] and found["exact"][1] < 1e-8
    # The force is linear in the weight: F = f + m g, least where m = -f.g / g.g.
    model = cotree.load(MANY.parent / "design/balance.toml")
    force = lambda weight: np.concatenate(  # noqa: E731
        [model.simulate(set={"counterweight": weight, "angle": 0}, step="0.62831853071795864 ms")[of] for of in ("push", "lift")]
    )
    fixed, share = force(0.0), force(1.0) - force(0.0)
    exact = -(fixed @ share) / (share @ share)
    weight = next(float(line.split()[1]) for line in lines if line.startswith("counterweight"))
    assert weight == pytest.approx(1e3 * exact, abs=2e-3)


def test_friction_is_identified_with_its_limits():
    found, _ = designed("identify", None)
    for name, truth in (("stiffness", 640), ("friction", 0.05), ("drag", 1.8)):
        value, error = found[name][:2]
        assert abs(value - truth) < 3.5 * error
    assert found["exact"][1] < 1e-6


def test_a_drive_with_a_spring_is_smaller():
    found, _ = designed("drive", None)
    assert found["sized"][0] < 0.3 * found["without spring"][0] and found["sized"][2] < 0.3 * found["without spring"][2]
    assert found["exact"][1] < 1e-9


def test_the_notebook_runs(tmp_path):
    nbclient = pytest.importorskip("nbclient")
    nbformat = pytest.importorskip("nbformat")
    notebook = nbformat.read(MANY.parent / "notebook.ipynb", as_version=4)
    nbclient.NotebookClient(notebook, timeout=300, resources={"metadata": {"path": str(MANY.parent)}}).execute()
    shown = [output for cell in notebook.cells if cell.cell_type == "code" for output in cell.outputs]
    kinds = {kind for output in shown for kind in output.get("data", {})}
    assert {"text/html", "text/latex"} <= kinds
    assert not [output for output in shown if output.output_type == "error"]


def test_dask_workers_need_no_file_of_the_scene(tmp_path):
    """Parts are gone and the workers are in another folder: the model that is sent has all that it has read."""
    pytest.importorskip("dask.distributed")
    (tmp_path / "elsewhere").mkdir()
    code = (
        "import os, shutil, sys\n"
        "import cotree\n"
        "from dask.distributed import Client, LocalCluster\n"
        "def worker(model):\n"
        "    return os.getcwd(), model.simulate(stop=0.1, step=0.1)['car.y'].tolist()\n"
        "if __name__ == '__main__':\n"
        "    model = cotree.load('axle/scene.toml')\n"
        "    here = model.simulate(stop=0.1, step=0.1)['car.y'].tolist()\n"
        "    shutil.rmtree('axle')\n"
        "    os.chdir('elsewhere')\n"
        "    with LocalCluster(n_workers=1, threads_per_worker=1, dashboard_address=None) as cluster, Client(cluster) as client:\n"
        "        [(folder, there)] = client.gather([client.submit(worker, model)])\n"
        "    print(folder.endswith('elsewhere'), here == there)\n"
    )
    shutil.copytree(MANY.parents[1] / "models/double_wishbone", tmp_path / "axle")
    script = tmp_path / "sent.py"
    script.write_text(code)
    done = subprocess.run([sys.executable, str(script)], capture_output=True, text=True, check=False, cwd=tmp_path)
    assert done.returncode == 0 and done.stdout.split() == ["True", "True"], done.stderr


CONTROL = Path(__file__).parents[2] / "examples/control"


def controlled(script, *arguments):
    done = subprocess.run([sys.executable, str(CONTROL / script), *map(str, arguments)], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_an_environment_is_accepted_by_gymnasium():
    pytest.importorskip("gymnasium")
    printed = controlled("environment.py", 2000)
    assert "the checks of Gymnasium hold" in printed and "cotree: " in printed


def test_gains_of_the_linear_system_hold_the_pole():
    pytest.importorskip("scipy")
    printed = controlled("lqr.py")
    left = re.search(r"after 15 s: (\S+) deg and (\S+) mm", printed)
    assert float(left[1]) < 0.01 and float(left[2]) < 1, printed


def test_a_fit_to_noisy_measurements_has_true_limits():
    within = re.search(r"in (\d+) of 40 cases", controlled("fit.py"))
    # Of 40 that each have 95 %, 33 or fewer are one case in 10 000.
    assert int(within[1]) > 33, within


def test_a_trajectory_is_found_by_its_derivatives():
    pytest.importorskip("scipy")
    try:
        import jax  # noqa: F401

        options = ["jax"]
    except ModuleNotFoundError:
        options = []
    printed = controlled("trajectory.py", *options)
    left = re.search(r"at the end (\S+) deg and (\S+) mm", printed)
    assert float(left[1]) < 5 and float(left[2]) < 100, printed
    if options:
        assert float(re.search(r"within (\S+)$", printed.strip())[1]) < 1e-9, printed
