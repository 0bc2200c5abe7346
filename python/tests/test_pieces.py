"""Tables of many runs that go into files as they come."""

import json
import os
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

import cotree

LENGTHS = np.linspace(1.2, 1.8, 500)
MEASURES = ["max(cylinder.s)", "last(crank.angle)"]


@pytest.mark.parametrize("kind", ["parquet", "arrow"])
def test_a_table_in_files_is_the_table(kind, slider_crank, tmp_path):
    pytest.importorskip("pyarrow")
    runs = {"rod_length": LENGTHS, "crank_length": np.where(np.arange(500) % 50 == 7, 1.9, 0.5), "crank.angle": 1.5}
    table = slider_crank.measure(MEASURES, runs, stop=0.2)
    assert 0 < len(table.failures) < 500
    kept = slider_crank.measure(MEASURES, runs, stop=0.2, to=tmp_path / f"runs.{kind}")
    assert (kept.runs, kept.failed) == (500, len(table.failures))
    frame = kept.to_pandas()
    assert frame["run"].tolist() == list(range(500))
    for name in table:
        assert np.array_equal(frame[name], table[name], equal_nan=True), name
    assert {run: why for run, why in enumerate(frame["failure"]) if isinstance(why, str)} == table.failures
    with pytest.raises(FileExistsError, match="go on with resume=True"):
        slider_crank.measure(MEASURES, runs, stop=0.2, to=kept.path)
    with pytest.raises(FileExistsError, match="another table"):
        slider_crank.measure(MEASURES, runs, stop=0.3, to=kept.path, resume=True)
    with pytest.raises(FileExistsError, match="another table"):
        slider_crank.replace({"rod.mass": 2.5}).measure(MEASURES, runs, stop=0.2, to=kept.path, resume=True)
    assert slider_crank.measure(MEASURES, runs, stop=0.2, to=kept.path, resume=True) == kept


def test_readers_of_parquet_take_the_folder_as_one_table(slider_crank, tmp_path, monkeypatch):
    pytest.importorskip("pyarrow")
    import pandas
    import pyarrow.dataset

    from cotree import _pieces

    monkeypatch.setattr(_pieces, "PIECE", 64)
    table = slider_crank.sweep("max(cylinder.s)", {"rod_length": LENGTHS}, stop=0.2)
    kept = slider_crank.sweep("max(cylinder.s)", {"rod_length": LENGTHS}, stop=0.2, to=tmp_path / "runs.parquet")
    assert len(list(kept.path.glob("run-*.parquet"))) > 3
    data = pyarrow.dataset.dataset(kept.path)
    assert data.schema.field("max(cylinder.s)").metadata == {b"unit": b"m"}
    assert np.array_equal(np.sort(data.to_table()["max(cylinder.s)"].to_numpy()), np.sort(table["max(cylinder.s)"]))
    assert np.array_equal(pandas.read_parquet(kept.path).sort_values("run")["max(cylinder.s)"], table["max(cylinder.s)"])
    # A file that is lost is noticed.
    sorted(kept.path.glob("run-*.parquet"))[1].unlink()
    with pytest.raises(FileExistsError, match="files have been removed"):
        slider_crank.sweep("max(cylinder.s)", {"rod_length": LENGTHS}, stop=0.2, to=kept.path, resume=True)


@pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")
def test_a_killed_table_goes_on_and_is_the_same(root, tmp_path):
    pytest.importorskip("pyarrow")
    program = (
        "import sys, cotree, numpy as np\nfrom cotree import _pieces\n_pieces.PIECE = 100\n"
        f"model = cotree.load({str(root / 'models/slider_crank/scene.toml')!r})\n"
        "model.measure('max(cylinder.s)', {'rod_length': np.linspace(1.2, 1.8, 1000)}, stop=4, step=0.02, threads=1, to=sys.argv[1], resume=True, progress=print)\n"
    )
    whole, cut = tmp_path / "whole.parquet", tmp_path / "cut.parquet"
    process = subprocess.Popen([sys.executable, "-c", program, cut], stdout=subprocess.DEVNULL)
    deadline = time.monotonic() + 120
    while not list(cut.glob("run-*")) and time.monotonic() < deadline:
        time.sleep(0.01)
    process.send_signal(signal.SIGKILL)
    process.wait()
    before = len(list(cut.glob("run-*")))
    for folder in (cut, whole):
        done = subprocess.run([sys.executable, "-c", program, folder], capture_output=True, text=True, check=True)
        assert done.stdout.splitlines()[-1] == "1000 1000"
    # That there was something to go on with.
    assert 0 < before < len(list(cut.glob("run-*")))
    import pandas

    frames = [pandas.read_parquet(folder).sort_values("run", ignore_index=True) for folder in (cut, whole)]
    assert frames[0].equals(frames[1]) and len(frames[0]) == 1000


def test_progress_is_told_and_changes_nothing(slider_crank):
    seen = []
    table = slider_crank.measure(MEASURES, {"rod_length": LENGTHS}, stop=0.2, progress=lambda done, all: seen.append((done, all)))
    assert table == slider_crank.measure(MEASURES, {"rod_length": LENGTHS}, stop=0.2)
    assert seen == sorted(seen) and seen[-1] == (500, 500) and len(seen) > 1
    assert slider_crank.measure(MEASURES, {"rod_length": []}, stop=0.2, progress=print).runs == 0


def test_what_cannot_be_written_says_so(slider_crank, tmp_path, monkeypatch):
    with pytest.raises(ValueError, match=r"must end with \.parquet or \.arrow"):
        slider_crank.measure(MEASURES, {"rod_length": [1.5]}, to=tmp_path / "runs.csv")
    with pytest.raises(ValueError, match="nothing to go on with"):
        slider_crank.measure(MEASURES, {"rod_length": [1.5]}, resume=True)
    other = tmp_path / "runs.parquet"
    other.mkdir()
    (other / "mine.txt").write_text("mine")
    pytest.importorskip("pyarrow")
    with pytest.raises(FileExistsError, match="other files"):
        slider_crank.measure(MEASURES, {"rod_length": [1.5]}, to=other)
    for name in [name for name in sys.modules if name.partition(".")[0] == "pyarrow"]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    with pytest.raises(ImportError, match="pip install pyarrow"):
        slider_crank.measure(MEASURES, {"rod_length": [1.5]}, to=tmp_path / "new.parquet")


def test_more_numbers_than_memory_has_are_refused(slider_crank):
    with pytest.raises(ValueError, match=r"3000 runs with 100001 points of 2 columns are 4\.8 GB; `measure` keeps"):
        slider_crank.simulate_many({"rod_length": np.full(3000, 1.5)}, stop=100, step=0.001, outputs="cylinder.s")
    with pytest.raises(ValueError, match="most_values"):
        slider_crank.simulate_many({"rod_length": [1.4, 1.5]}, stop=1, most_values=10)
    assert len(slider_crank.simulate_many({"rod_length": [1.4, 1.5]}, stop=1)) == 2


def test_a_mark_is_of_everything_that_changes_a_run(slider_crank, tmp_path):
    pytest.importorskip("pyarrow")
    marks = set()
    calls = [{}, {"stop": 0.2}, {"step": 0.05}, {"tolerance": 1e-7}, {"set": {"crank_length": 0.45}}, {"times": [0, 0.1]}, {"inputs": {"time": [0, 1], "gas_force": [0, 1]}}]
    for index, options in enumerate(calls):
        kept = slider_crank.measure("max(cylinder.s)", {"rod_length": [1.5]}, to=tmp_path / f"{index}.arrow", **{"stop": 0.1} | options if "times" not in options else options)
        marks.add(json.loads((kept.path / "_cotree.json").read_text())["mark"])
    assert len(marks) == len(calls)
