"""The examples do what their pages say."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

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

    import cotree

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
    written = (tmp_path / "out/0.npy").stat().st_mtime_ns
    for number in range(3):
        printed("array_task.py", 400, 3, tmp_path / "out", SLURM_ARRAY_TASK_ID=str(number))
    assert (tmp_path / "out/0.npy").stat().st_mtime_ns == written
    lines = printed("array_task.py", 400, 3, tmp_path / "out", "--join")
    assert lines[:2] == alone and lines[2] == "400 runs"
    assert np.load(tmp_path / "out/1.npy").shape == (133, 2)


def test_the_notebook_runs(tmp_path):
    nbclient = pytest.importorskip("nbclient")
    nbformat = pytest.importorskip("nbformat")
    notebook = nbformat.read(MANY.parent / "notebook.ipynb", as_version=4)
    nbclient.NotebookClient(notebook, timeout=300, resources={"metadata": {"path": str(MANY.parent)}}).execute()
    shown = [output for cell in notebook.cells if cell.cell_type == "code" for output in cell.outputs]
    kinds = {kind for output in shown for kind in output.get("data", {})}
    assert {"text/html", "text/latex"} <= kinds
    assert not [output for output in shown if output.output_type == "error"]
