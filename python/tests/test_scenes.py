"""Scenes: read, built, wrong, pickled."""

import copy
import json
import pickle
import subprocess
import sys
import tomllib

import numpy as np
import pytest

import cotree


def test_a_scene_is_the_same_from_file_text_and_dictionary(root, slider_crank):
    path = root / "models/slider_crank/scene.toml"
    others = [cotree.loads(path.read_text()), cotree.from_dict(tomllib.loads(path.read_text()))]
    first = slider_crank.simulate(stop=0.5)
    for other in others:
        again = other.simulate(stop=0.5)
        assert list(again) == list(first)
        assert np.array_equal(again.to_numpy(), first.to_numpy())


def test_every_model_is_read(root):
    scenes = sorted(root.glob("models/*/scene.toml"))
    assert len(scenes) > 15
    for scene in scenes:
        model = cotree.load(scene)
        model.check()
        assert model.variables and model.name in repr(model)
        assert len(str(model)) > 100


def test_all_faults_come_at_once_with_their_places():
    text = "name = 'a'\n[bodies.bar]\nmas = 2\npoints = { end = [1, 0] }\n[joints.hinge]\ntype = 'revolut'\nbetween = ['ground', 'bar.ende']\n"
    with pytest.raises(cotree.SceneError) as caught:
        cotree.loads(text, "bar.toml")
    faults = caught.value.faults
    assert len(faults) >= 2 and caught.value.file == "bar.toml"
    key = next(fault for fault in faults if "mas" in fault.message)
    assert key.severity == "error" and (key.place.line, key.place.column) == (3, 1)
    assert "did you mean" in str(caught.value)
    again = pickle.loads(pickle.dumps(caught.value))
    assert again.faults == faults and str(again) == str(caught.value)


def test_a_copy_keeps_the_files_that_were_read(tmp_path, monkeypatch):
    """Also when they are changed or gone, and from another folder."""
    (tmp_path / "parts").mkdir()
    part = tmp_path / "parts/bob.toml"
    part.write_text(
        """
        [bodies.bob]
        mass = 2.0
        inertia = 0.1
        [joints.rail]
        type = "prismatic"
        between = ["ground", "bob"]
        axis = [1, 0]
        [loads.push]
        type = "force"
        on = "bob"
        vector = ['table("push.csv", t)', 0]
        """
    )
    (tmp_path / "parts/push.csv").write_text("0, 3\n10, 3\n")
    (tmp_path / "scene.toml").write_text('name = "pushed"\n[parts.one]\nfile = "parts/bob.toml"\n[outputs]\nvariables = ["one_bob.x"]\n')
    monkeypatch.chdir(tmp_path)
    model = cotree.load("scene.toml")
    stored = pickle.dumps(model)
    # Half of the acceleration of 3 N on 2 kg, after a second.
    where = lambda model: model.simulate(stop=1.0)["one_bob.x"][-1]
    assert where(model) == pytest.approx(0.75)
    part.write_text(part.read_text().replace("mass = 2.0", "mass = 4.0"))
    (tmp_path / "parts/push.csv").write_text("0, 5\n10, 5\n")
    assert where(cotree.load("scene.toml")) == pytest.approx(0.625)
    for copied in (pickle.loads(stored), copy.deepcopy(model), copy.copy(model), pickle.loads(pickle.dumps(pickle.loads(stored)))):
        assert where(copied) == pytest.approx(0.75) and copied.text == model.text
    part.unlink()
    (tmp_path / "parts/push.csv").unlink()
    monkeypatch.chdir("/")
    assert where(pickle.loads(stored)) == pytest.approx(0.75)


def test_what_is_wrong_with_bodies_and_loops_is_raised_by_reading(root, tmp_path):
    """As by the command: the same faults, from text, file, dictionary and builder."""
    text = (root / "models/four_bar/scene.toml").read_text().replace('base_length    = "0.5 m"', 'base_length = "5 m"').replace("0.017", "-1")
    (tmp_path / "long.toml").write_text(text)
    report = subprocess.run(
        [sys.executable, "-m", "cotree._command", "check", "long.toml", "--message-format", "json"], cwd=tmp_path, capture_output=True
    )
    told = [fault["code"] for fault in json.loads(report.stdout)["faults"] if fault["severity"] == "error"]
    assert told
    for read in (
        lambda: cotree.loads(text),
        lambda: cotree.load(tmp_path / "long.toml"),
        lambda: cotree.from_dict(tomllib.loads(text)),
    ):
        with pytest.raises(cotree.SceneError) as caught:
            read()
        assert [fault.code for fault in caught.value.faults if fault.severity == "error"] == told
    open_loop = text.replace("-1", "0.017")
    with pytest.raises(cotree.SceneError, match="loop"):
        cotree.loads(open_loop)


def test_warnings_are_objects():
    scene = "name = 'a'\n[bodies.bar]\nmass = 1\ninertia = 1\n[joints.hinge]\ntype = 'revolute'\nbetween = ['ground', 'bar']\n[joints.again]\ntype = 'revolute'\nbetween = ['ground', 'bar']\n"
    warnings = cotree.loads(scene).check()
    assert warnings and all(fault.severity == "warning" for fault in warnings)


def test_models_are_pickled(slider_crank):
    again = pickle.loads(pickle.dumps(slider_crank))
    assert again.text == slider_crank.text
    assert np.array_equal(again.simulate(stop=0.1).to_numpy(), slider_crank.simulate(stop=0.1).to_numpy())


def test_a_file_that_is_no_text_is_a_fault_and_a_missing_one_an_error(tmp_path):
    (tmp_path / "odd.toml").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(cotree.SceneError):
        cotree.load(tmp_path / "odd.toml")
    with pytest.raises(FileNotFoundError):
        cotree.load(tmp_path / "none.toml")


def test_the_builder_gives_the_scene_that_was_meant(pendulum):
    scene = json.loads(pendulum.text)
    assert scene["joints"]["hinge"] == {"type": "revolute", "between": ["ground", "bob.top"]}
    with pytest.raises(ValueError, match="already"):
        cotree.Builder("a").body("b", mass=1).body("b", mass=2)
    with pytest.raises(TypeError, match="object"):
        cotree.from_dict({"name": object()})
    numbers = cotree.from_dict({"name": "a", "gravity": np.array([0.0, -9.81]), "bodies": {"b": {"mass": np.float64(1)}}})
    assert "9.81" in numbers.text


def test_variables_have_units_and_bounds(pendulum):
    length = pendulum.variables["length"]
    assert (length.unit, length.start, length.min, length.causality) == ("m", 1.0, 1e-3, "parameter")


def test_outlines_and_their_distances():
    scene = (
        cotree.Builder("a")
        .ground_outline({"disc": [0.9, 0], "radius": 0.2})
        .body("crank", points={"a": [0, 0], "b": [0.5, 0]}, outline={"disc": "b", "radius": "100 mm"})
        .revolute("pin", "ground", "crank.a")
        .clearance(("crank", "ground"), least="50 mm")
    )
    found = scene.model().motion("pin")["clearance"][0]
    assert found["pair"] == ["crank", "ground"]
    assert abs(found["least"] - 0.1) < 1e-10
    with pytest.raises(ValueError, match="outline"):
        scene.ground_outline({"disc": [0, 0], "radius": 1})
