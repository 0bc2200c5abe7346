"""What the command has, Python has: both say the same."""

import json
import subprocess
import sys

import numpy as np
import pytest

import cotree

FOUR_BAR, CAM = "models/four_bar/scene.toml", "models/cam_oscillating/scene.toml"


def command(*arguments):
    done = subprocess.run([sys.executable, "-m", "cotree", *map(str, arguments)], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.fixture
def four_bar(root):
    return cotree.load(root / FOUR_BAR)


def test_motion_is_that_of_the_command(root, four_bar):
    found = four_bar.motion("crank_pivot", speed="2 rad/s", every="30 deg")
    options = ["--input", "crank_pivot", "--speed", "2 rad/s", "--every", "30 deg"]
    assert str(found) == command("motion", root / FOUR_BAR, *options)
    assert found.data == json.loads(command("motion", root / FOUR_BAR, *options, "--json"))
    assert found.picture.startswith("<svg") and len(next(iter(found.columns().values()))) > 10
    assert list(found.to_pandas().columns) == list(found.columns())
    with pytest.raises(ValueError, match="there is no joint `no_joint` that can be driven"):
        four_bar.motion("no_joint")
    with pytest.raises(KeyError, match="is not in the report"):
        found["rnage"]


def test_assemblies_are_those_of_the_command(root, four_bar):
    found = four_bar.assemblies(starts=60)
    said = command("assemblies", root / FOUR_BAR, "--starts", 60)
    assert f"close in {len(found)} assembly mode" in said and found[0].own and not found[1].own
    assert sum(own.found for own in found) <= 61 and len({tuple(own.values.values()) for own in found}) == len(found)


def test_traces_and_profiles_are_those_of_the_command(root, four_bar, tmp_path):
    text = command("trace", root / FOUR_BAR, "coupler", "--units", "si")
    rows = np.array([[float(cell) for cell in row.split(",")] for row in text.splitlines()[1:]])
    curves = four_bar.trace("coupler")
    assert np.array_equal(curves["coupler"], rows[:, 1:])
    command("trace", root / FOUR_BAR, "coupler", "-o", tmp_path / "curve.dxf")
    assert cotree.dxf(curves) == (tmp_path / "curve.dxf").read_bytes().decode()
    assert np.array_equal(four_bar.trace("coupler", times=rows[::7, 0])["coupler"], rows[::7, 1:])
    cam = cotree.load(root / CAM)
    name = "cam"
    text = command("trace", root / CAM, name, "--units", "si")
    rows = np.array([[float(cell) for cell in row.split(",")] for row in text.splitlines()[1:]])
    own = cam.profile(name)
    assert np.array_equal(np.column_stack([own.angle, own.contact, own.pitch]), rows)
    with pytest.raises(ValueError, match="the scene has no cam `rod`"):
        cam.profile("rod")


def test_a_summary_is_that_of_the_command(root, slider_crank):
    found = slider_crank.simulate(stop=1).summary()
    said = json.loads(command("simulate", root / "models/slider_crank/scene.toml", "--stop", 1, "--summary", "--json", "--units", "si"))
    assert found["variables"] == said["variables"] and found["span"] == [0, 1] and "RMS" in str(found)


def test_sweeps_are_those_of_the_command(root, slider_crank):
    scene = root / "models/slider_crank/scene.toml"
    options = ["--set", "crank_length=0.4..0.5:3", "--set", "rod_length=1.4,1.5", "--output", "max(cylinder.s)", "--stop", 0.5, "--units", "si"]
    rows = [row.split(",") for row in command("sweep", scene, *options).splitlines()[1:]]
    found = slider_crank.sweep("max(cylinder.s)", {"crank_length": "0.4..0.5:3", "rod_length": [1.4, "150 cm"]}, stop=0.5)
    assert np.array_equal(np.asarray(found), np.array([[float(cell) for cell in row[1:4]] for row in rows]))
    drawn = slider_crank.sweep("last(cylinder.s)", {"rod_length": "1.4..1.6"}, latin=5, seed=3, stop=0.1)
    rows = command("sweep", scene, "--set", "rod_length=1.4..1.6", "--latin", 5, "--seed", 3, "--output", "last(cylinder.s)", "--stop", 0.1, "--units", "si")
    assert [float(row.split(",")[1]) for row in rows.splitlines()[1:]] == drawn["rod_length"].tolist()
    with pytest.raises(ValueError, match="range but no values"):
        slider_crank.sweep("max(cylinder.s)", {"rod_length": "1.4..1.6"})
    with pytest.raises(ValueError, match="give one of them"):
        slider_crank.sweep("max(cylinder.s)", {"rod_length": 1.5}, random=3, latin=3)


def test_drawings_and_films_are_those_of_the_command(root, four_bar, tmp_path):
    for name, text in [
        ("start.svg", four_bar.drawing()),
        ("later.svg", four_bar.drawing("0.3 s")),
        ("later.dxf", four_bar.drawing(0.3, format="dxf")),
    ]:
        at = [] if name == "start.svg" else ["--at", "0.3 s"]
        command("show", root / FOUR_BAR, "--drawing", tmp_path / name, *at)
        assert text == (tmp_path / name).read_bytes().decode()
    assert four_bar.drawing() != four_bar.drawing("0.3 s")
    command("show", root / FOUR_BAR, "--graph", tmp_path / "graph.dot")
    assert four_bar.graph(format="dot") == (tmp_path / "graph.dot").read_text()
    command("view", root / FOUR_BAR, "--svg", "-o", tmp_path / "film.svg", "--speed", 2)
    assert four_bar.film(speed=2) == (tmp_path / "film.svg").read_text()
    frames = four_bar.frames(fps=2, speed=2, width=200)
    command("view", root / FOUR_BAR, "--frames", tmp_path / "frames", "--fps", 2, "--speed", 2, "--width", 200)
    assert frames == [file.read_bytes() for file in sorted((tmp_path / "frames").iterdir())]
    assert cotree.png(four_bar.drawing(), width=300).startswith(b"\x89PNG")
    with pytest.raises(ValueError, match="before the start"):
        four_bar.drawing(-1)
    with pytest.raises(ValueError, match="not one of svg, dxf"):
        four_bar.drawing(format="bmp")


def test_a_drawing_has_what_was_set(root, slider_crank):
    longer = slider_crank.drawing(set={"rod_length": 1.9})
    assert longer != slider_crank.drawing() and longer == slider_crank.replace({"rod_length": 1.9}).drawing()


def test_linkages_are_found_and_taken_over(tmp_path):
    task = {
        "poses": {"at": [["0 mm", "0 mm", "0 deg"], ["35 mm", "20 mm", "14 deg"], ["80 mm", "60 mm", "38 deg"]]},
        "limits": {"transmission": "35 deg"},
    }
    found = cotree.synthesize(task)
    assert found.models and found.models[0].simulate().failure is None and "<svg" in found.picture
    file = tmp_path / "task.json"
    file.write_text(json.dumps(task))
    assert cotree.synthesize(file).data == found.data
    assert str(found) == command("synthesize", file)
    with pytest.raises(cotree.SceneError):
        cotree.synthesize({"poses": {"at": []}})


def test_linkages_of_other_programs(root, tmp_path):
    file = next((root / "tests").rglob("*.pmks"))
    model, notes = cotree.load_linkage(file)
    command("import", file, "-o", tmp_path / f"{file.stem}.toml")
    assert model.text == (tmp_path / f"{file.stem}.toml").read_text() and isinstance(notes, tuple)
    nothing = tmp_path / "nothing.json"
    nothing.write_text("{}")
    with pytest.raises(ValueError):
        cotree.load_linkage(nothing)


def test_optima_are_those_of_the_command(root, slider_crank):
    scene = root / "models/slider_crank/scene.toml"
    vary = {"rod_length": (1.2, 1.8), "crank_length": (0.3, 0.6)}
    found = slider_crank.optimize(vary, minimize="rms(cylinder.s)", subject_to="range(cylinder.s) = 0.8 m", starts=4, stop=2)
    options = ["--minimize", "rms(cylinder.s)", "--subject-to", "range(cylinder.s) = 0.8 m", "--starts", 4, "--stop", 2, "--json"]
    said = json.loads(command("optimize", scene, "--vary", "rod_length=1.2..1.8,crank_length=0.3..0.6", *options))
    assert found.data == said and list(found.optimum) == list(vary)
    motion = found.model.simulate(stop=2)["cylinder.s"]
    assert np.ptp(motion) == pytest.approx(0.8, abs=1e-5)
    seen = slider_crank.simulate(set={"rod_length": 1.45}, stop=1, step=0.05)
    matched = slider_crank.optimize({"rod_length": (1.3, 1.7)}, match={"time": seen.time, "cylinder.s": seen["cylinder.s"]}, starts=3, stop=1)
    assert matched.optimum["rod_length"] == pytest.approx(1.45, abs=1e-6)
    with pytest.raises(ValueError, match="give one of"):
        slider_crank.optimize("rod_length")
    with pytest.raises(ValueError, match="subject_to"):
        slider_crank.optimize(vary, minimize="rms(cylinder.s)", subject_to="range(cylinder.s)")


def test_fmus_for_other_platforms_and_what_is_in_them(slider_crank, tmp_path):
    path = slider_crank.export(tmp_path / "own.fmu", lean=True)
    text, model = cotree.inspect(path)
    assert "slider_crank" in text and model.text == slider_crank.text
    everything = slider_crank.export(tmp_path / "all.fmu", all=True, lean=True)
    assert len(cotree.inspect(everything)[0].splitlines()) > len(text.splitlines())
    with pytest.raises(ValueError, match="platforms: "):
        slider_crank.export(tmp_path / "no.fmu", platforms="amiga")
    with pytest.raises(OSError):
        slider_crank.export(tmp_path / "no.fmu", platforms=["win64"], runtimes=tmp_path)


def test_other_trees_are_compared(root, slider_crank):
    heads = lambda text: [line.split()[:3] for line in text.splitlines() if line.startswith("  ") and "," not in line]  # noqa: E731
    said = command("show", root / "models/slider_crank/scene.toml", "--compare")
    # Times differ from run to run.
    assert [own[:1] for own in heads(str(slider_crank.compare()))] == [own[:1] for own in heads(said)]
