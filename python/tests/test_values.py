"""A model is a value: it is edited, written, packed. What it answers with are data."""

import os
import pickle
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

import cotree

BAR = """name = "bar"          # falls
gravity = [0, -10]
[parameters]
length = { value = "100 cm", unit = "cm", min = "1 cm" }
[bodies.bob]
mass = 2.0              # kg
inertia = 0.0
points = { top = [0, "length"] }
[joints.hinge]
type = "revolute"
between = ["ground", "bob.top"]
[initial]
"bob.angle" = "90 deg"
[outputs]
variables = ["bob.omega", "hinge.fy"]
[experiment]
stop = "100 ms"
"""


def test_another_model_has_other_values_in_the_same_text():
    model = cotree.loads(BAR)
    other = model.replace({"length": 0.5, "bob.mass": 3, "experiment.stop": "0.2 s", "bob.angle": 0.0})
    # The number is in metres, though bare numbers of this parameter are in centimetres.
    assert other.variables["length"].start == 0.5 and model.variables["length"].start == 1.0
    assert other.text == BAR.replace('"100 cm"', '"0.5 m"').replace("2.0 ", "3.0 ").replace("100 ms", "0.2 s").replace('"90 deg"', '"0.0 rad"')
    assert other.simulate().time[-1] == 0.2
    assert other.equilibrium()["hinge.fy"] == pytest.approx(30.0)
    assert other.name == "bar" and "0.5 m" in pickle.loads(pickle.dumps(other)).text
    moon = model.replace({"gravity": [0, -1.6]})
    assert moon.equilibrium()["hinge.fy"] == pytest.approx(3.2)
    for of in (other.page(), other.equations(), other.steps(), other.drawing()):
        assert len(of) > 400
    for wrong, message in [({"lenght": 1}, "did you mean `length`"), ({"bob": 1}, r"bob\.mass"), ({"bob.mass": np.nan}, "finite")]:
        with pytest.raises(ValueError, match=message):
            model.replace(wrong)
    with pytest.raises(cotree.SceneError):
        model.replace({"bob.mass": -1})
    with pytest.raises(TypeError, match="mapping"):
        model.replace([("length", 1)])


def test_keys_that_the_scene_does_not_write_are_added():
    model = cotree.loads(BAR)
    other = model.replace({"hinge.damping": 0.5, "bob.omega": "2 rad/s", "experiment.step": "10 ms", "solver.method": "explicit", "parameters.unused": 3.0})
    assert other.to_dict()["solver"] == {"method": "explicit"} and other.variables["unused"].start == 3.0
    seen = other.simulate()
    assert seen["bob.omega"][0] == 2.0 and seen.time[1] == pytest.approx(0.01)
    # All that stood there still does.
    assert [line for line in other.text.splitlines() if line in BAR.splitlines()] == BAR.splitlines()
    as_json = cotree.from_dict(model.to_dict()).replace({"hinge.damping": 0.5, "solver.method": "explicit"})
    assert as_json.to_dict()["joints"]["hinge"]["damping"] == 0.5 and as_json.to_dict()["solver"] == {"method": "explicit"}
    # What was set for a fit is in its model.
    found = model.fit(model.simulate(set={"bob.omega": 1.5, "length": 0.8}), "length", set={"bob.omega": 1.5}).model
    assert found.simulate()["bob.omega"][0] == 1.5 and found.variables["length"].start == pytest.approx(0.8)
    with pytest.raises(cotree.SceneError, match="mass"):
        model.replace({"bob.mas": 1.0})
    with pytest.raises(ValueError, match="has no `rod.mass`"):
        model.replace({"rod.mass": 1.0})


def test_models_are_equal_where_their_texts_are(root):
    assert cotree.loads(BAR) == cotree.loads(BAR) != cotree.loads(BAR.replace("2.0 ", "2.5 "))
    assert cotree.loads(BAR) != BAR and len({cotree.loads(BAR), cotree.loads(BAR)}) == 1
    assert pickle.loads(pickle.dumps(cotree.load(root / "models/cam_follower/scene.toml"))) == cotree.load(root / "models/cam_follower/scene.toml")


def test_a_fit_gives_the_model_that_fits():
    model = cotree.loads(BAR)
    seen = model.simulate(set={"length": 0.8, "bob.angle": 1.0})
    found = model.fit({"time": seen.time, "bob.omega": seen["bob.omega"]}, "length", set={"bob.angle": 1.0})
    assert found.model.variables["length"].start == pytest.approx(0.8, abs=1e-6)
    assert np.allclose(found.model.simulate()["bob.omega"], seen["bob.omega"], atol=1e-6)


def test_a_scene_is_written_with_its_files(tmp_path):
    (tmp_path / "one/parts").mkdir(parents=True)
    part = tmp_path / "one/parts/cart.toml"
    part.write_text("[bodies.c]\nmass=2.0\n[joints.r]\ntype='prismatic'\nbetween=['ground','c']\naxis=[1,0]\n[loads.f]\ntype='force'\non='c'\nvector=[8,0]\n")
    scene = {"name": "a", "parts": {"x": {"file": "parts/cart.toml"}}, "outputs": {"variables": ["x_c.ax"]}}
    model = cotree.from_dict(scene, folder=tmp_path / "one")
    assert model.to_dict() == scene
    part.unlink()
    assert model.simulate(stop=0.1)["x_c.ax"][-1] == pytest.approx(4.0)
    (tmp_path / "two").mkdir()
    path = model.save(tmp_path / "two/a.json")
    again = cotree.load(path)
    assert again.to_dict() == scene and again.simulate(stop=0.1) == model.simulate(stop=0.1)
    (tmp_path / "two/parts/cart.toml").write_text("[bodies.c]\n")
    with pytest.raises(FileExistsError, match=r"cart\.toml"):
        model.save(tmp_path / "two/b.json")
    built = cotree.Builder("a").part("x", "parts/cart.toml").output("x_c.ax")
    with pytest.raises(cotree.SceneError):
        built.model(tmp_path)
    text = cotree.loads(BAR)
    assert cotree.load(text.save(tmp_path / "bar.toml")).text == BAR and text.to_dict()["gravity"] == [0, -10]


def test_the_builder_has_signals_and_units_of_display():
    model = cotree.Builder("a").signal("pull", "3 N").display("deg", length="mm").body("b", mass=1.0, inertia=1.0)
    model = model.load("f", "force", on="b", vector=["pull", 0]).output("b.ax", "b.angle").stop(1).model()
    assert model.simulate()["b.ax"][0] == pytest.approx(3.0)
    with pytest.raises(cotree.SceneError, match="furlong"):
        cotree.Builder("a").display("furlong").body("b", mass=1.0, inertia=1.0).model()


def test_the_builder_has_signals_with_a_type():
    model = cotree.Builder("a").body("b", mass=2.0, inertia=1.0).joint("rail", "prismatic", ["ground", "b"], axis=[1, 0])
    model = model.signal("slow", type="filter", input="rail.s", time="0.5 s").signal("u", type="pid", error="1[m] - slow", proportional="3 N/m")
    model = model.load("f", "force", on="b", vector=["u", 0]).initial("rail.s", 0.0).initial("rail.v", 0.0).output("u", "slow").stop(1).model()
    results = model.simulate()
    assert results["u"][0] == pytest.approx(3.0) and results["u"][-1] == pytest.approx(3.0 * (1 - results["slow"][-1]))
    with pytest.raises(cotree.SceneError, match="has neither of `time` or `cutoff`"):
        cotree.Builder("a").body("b", mass=1.0, inertia=1.0).signal("slow", type="filter", input="b.x").output("slow").model()


def test_the_builder_has_samplers_and_events(root):
    """The balancing cart as it is built gives the bits of the one that is written."""
    lean = "pi/2 - pole.angle"
    push = "max(-15[N], min(15[N], gain*new(lean) + reset*new(sum) + damp*(new(lean) - lean)/0.02[s] + 2[N/m]*rail.s + 4[N.s/m]*rail.v))"
    built = (
        cotree.Builder("balancing_cart")
        .gravity([0.0, -9.81])
        .parameter("pole_length", "0.8 m")
        .parameter("pole_mass", "0.3 kg")
        .parameter("gain", "55 N/rad", tunable=True)
        .parameter("reset", "30 N/rad/s", tunable=True)
        .parameter("damp", "11 N.s/rad", tunable=True)
        .ground_point("post", [-1.0, 0.0])
        .body("cart", mass=1.5)
        .body("pole", mass="pole_mass", inertia="pole_mass*pole_length^2/12", points={"foot": ["-pole_length/2", 0], "tip": ["pole_length/2", 0]})
        .prismatic("rail", "ground", "cart", [1, 0], damping=0.4)
        .revolute("hinge", "cart", "pole.foot")
        .sampled(
            "computer",
            "20 ms",
            {
                "lean": {"start": lean, "next": lean},
                "sum": {"start": 0, "next": "sum + 0.02[s]*new(lean)", "unit": "rad.s"},
                "push": {"start": 0, "next": push, "unit": "N"},
            },
            offset="5 ms",
        )
        .load("drive", "force", on="cart", vector=["push", 0])
        .load("tether", "spring", between=["ground.post", "cart"], stiffness="6 N/m", length="1 m")
        .event("release", "pole.angle > 86[deg]", remove=["tether"])
        .event("fallen", "sin(pole.angle) < 0", stop=True)
        .initial("rail.s", 0.0)
        .initial("rail.v", 0.0)
        .initial("pole.angle", "78 deg")
        .initial("pole.omega", 0.0)
        .output("rail.s", "rail.v", "pole.angle", "pole.omega", "push", "tether.force", "events.release.time")
        .stop("4 s")
        .step("20 ms")
        .tolerance(1e-9)
    )
    written = cotree.load(root / "models/balancing_cart/scene.toml")
    runs = [model.simulate() for model in (built.model(), written)]
    assert list(runs[0]) == list(runs[1]) and runs[0] == runs[1]
    # The computer has pulled the pole up, and the tether is off.
    assert abs(runs[0]["pole.angle"][-1] - np.pi / 2) < 0.02 and 0 < runs[0]["events.release.time"][-1] < 4
    with pytest.raises(ValueError, match="fallen"):
        built.event("fallen", "time > 1[s]")
    with pytest.raises(cotree.SceneError, match="tetherr"):
        cotree.Builder("a").body("b", mass=1.0).event("e", "b.x > 1", remove=["tetherr"]).model()


def test_results_are_read_as_numbers(pendulum):
    pandas, polars = pytest.importorskip("pandas"), pytest.importorskip("polars")
    results = pendulum.simulate(stop=0.1)
    assert np.asarray(results).shape == (101, 2) and np.asarray(results, dtype=np.float32).dtype == np.float32
    assert pandas.DataFrame(results).shape == (101, 2)
    assert results.to_polars().equals(polars.DataFrame(polars.from_arrow(results).struct.unnest()))
    with pytest.raises(ValueError, match="read-only"):
        results["bob.angle"][0] = 1.0
    assert results["bob.angle"].flags.c_contiguous and not results.time.flags.writeable
    same, other = pendulum.simulate(stop=0.1), pendulum.simulate(stop=0.1, set={"length": 2})
    assert results == same and results != other and results != 3
    assert pendulum.linearize() == pendulum.linearize() != pendulum.linearize(0.5)
    middle = results.at(0.0505)
    assert middle["bob.angle"] == pytest.approx(results["bob.angle"][50:52].mean())
    with pytest.raises(ValueError, match="outside"):
        results.at(0.2)
    table = pendulum.measure("max(bob.angle)", {"length": ["40 cm", 0.5, 0.6]}, stop=0.1)
    assert pandas.DataFrame(table).shape == (3, 2) and table["length"].tolist() == [0.4, 0.5, 0.6]
    with pytest.raises(KeyError, match="max"):
        table["max(bob.angel)"]
    with pytest.raises(KeyError, match=r"bob\.angle"):
        pendulum.equilibrium()["bob.angel"]


def test_frames_of_many_runs_have_what_was_varied(pendulum):
    pytest.importorskip("pandas")
    runs = pendulum.simulate_many({"length": [0.5, 0.7], "bob.angle": [0.1, 0.2]}, stop=0.01)
    frame = runs.to_pandas()
    assert frame.loc[1]["length"].unique() == [0.7] and frame.loc[1]["bob.angle (set)"].unique() == [0.2]
    assert runs.to_polars()["length"].to_list() == frame["length"].to_list()
    assert np.asarray(runs).shape == (2, 11, 2) and runs == pendulum.simulate_many({"length": [0.5, 0.7], "bob.angle": [0.1, 0.2]}, stop=0.01)


def test_a_data_set_has_units(pendulum):
    pytest.importorskip("xarray")
    data = pendulum.simulate(stop=0.1).to_xarray()
    assert data["bob.angle"].attrs["units"] == "rad" and data.sizes == {"time": 101}


def test_what_settings_cause_is_an_error_of_the_run(slider_crank):
    far = {"crank_length": 3.0, "crank.angle": 1.5}
    for call in (
        lambda: slider_crank.simulate(set=far),
        lambda: slider_crank.start(set=far),
        lambda: slider_crank.sensitivities("cylinder.s", "rod_length", 1, set=far),
        lambda: slider_crank.peaks("cylinder.s", "rod_length", set=far),
        lambda: slider_crank.linearize(set=far),
        lambda: slider_crank.fit({"time": [0, 1, 2], "cylinder.s": [1.8, 1.9, 1.7]}, "rod_length", set=far),
    ):
        with pytest.raises(cotree.RunError, match="crank_length") as caught:
            call()
        assert "1.5" in str(caught.value) and isinstance(caught.value, cotree.CotreeError)
    with pytest.raises(cotree.SceneError, match="rod.nothing"):
        slider_crank.sensitivities("rod.nothing", "rod_length", 1, set={"rod_length": 1.4})


def test_a_velocity_that_the_scene_leaves_open_can_be_set():
    model = cotree.loads(BAR)
    assert model.simulate(set={"bob.omega": 2.0}, stop=0.01)["bob.omega"][0] == 2.0
    assert model.simulate(stop=0.01)["bob.omega"][0] == 0.0
    runs = model.start(set={"bob.omega": "90 deg/s"})
    assert runs["bob.omega"] == pytest.approx(np.pi / 2)
    assert [run["bob.omega"][0] for run in model.simulate_many({"bob.omega": [1.0, "90 deg/s"]}, stop=0.01)] == [1.0, pytest.approx(np.pi / 2)]
    assert model.measure("first(bob.omega)", {"bob.omega": [1.0, 3.0]}, stop=0.01)["first(bob.omega)"].tolist() == [1.0, 3.0]
    assert model.linearize(set={"bob.omega": 2.0}).rates[0] == pytest.approx(2.0)
    with pytest.raises(cotree.RunError, match="hinge.fy"):
        model.simulate(set={"hinge.fy": 2.0})


def test_texts_with_units_where_times_are_given(pendulum):
    assert pendulum.linearize("0.5 s") == pendulum.linearize(0.5)
    assert pendulum.sensitivities("bob.angle", "length", (k / 10 for k in range(3))).time.tolist() == [0.0, 0.1, 0.2]
    assert pendulum.sensitivities("bob.angle", "length", ["100 ms", 0.2]).time.tolist() == [0.1, 0.2]
    found = pendulum.peaks("bob.angle", "length", crossing={"bob.angle": "0.5 deg"}, stop=1)
    assert [own.value for own in found if own.kind == "crossing"] == pytest.approx([np.radians(0.5)] * len(found[2:]))


LONG = {
    "one long step": "m.simulate(stop=3e5, step=3e5)",
    "a sampled run": "m.simulate(stop=1e6, step=1e4, inputs={'gas_force': lambda t: 0.0})",
    "sensitivities": "m.sensitivities('cylinder.s', 'rod_length', np.linspace(0, 20000, 20001))",
    "fit": "m.fit({'time': T, 'cylinder.s': np.cos(T) * 0.5 + 1.4}, vary=['rod_length', 'crank_length'], stop=200)",
    "threads": "m.simulate_many({'rod_length': [1.4, 1.5, 1.6]}, stop=3e5, step=3e5, threads=2)",
    "steps": "m.start().step(3e5)",
    "assemblies": "m.assemblies(starts=1000000)",
}


@pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")
@pytest.mark.parametrize("call", LONG.values(), ids=LONG)
def test_ctrl_c_ends_calls(call, root):
    code = (
        f"import cotree, numpy as np\nm = cotree.load({str(root / 'models/slider_crank/scene.toml')!r})\nT = np.linspace(0, 200, 20001)\n"
        f"print('ready', flush=True)\ntry:\n    {call}\nexcept KeyboardInterrupt:\n    print('interrupted', flush=True)\n"
    )
    process = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert process.stdout.readline() == "ready\n"
    time.sleep(0.3)
    process.send_signal(signal.SIGINT)
    assert process.communicate(timeout=60) == ("interrupted\n", "")


def test_the_package_is_a_command(tmp_path):
    done = subprocess.run([sys.executable, "-m", "cotree", "--version"], capture_output=True, text=True, cwd=tmp_path, check=True)
    assert done.stdout.split() == ["cotree", cotree.__version__]
