"""What is returned shows itself, keeps its axes when it is handed over, and says how far it is."""

import csv
import io
import pickle
from decimal import Decimal
from fractions import Fraction

import matplotlib
import numpy as np
import pytest

import cotree

matplotlib.use("Agg")


@pytest.fixture
def cart_pole(root):
    return cotree.load(root / "models/cart_pole/scene.toml")


def test_everything_shows_itself_in_a_notebook(slider_crank, pendulum, cart_pole):
    seen = pendulum.simulate(stop=1, step=0.05)
    fitted = pendulum.fit({"time": seen.time, "bob.angle": np.round(seen["bob.angle"], 5)}, "length")
    shown = [
        slider_crank.measure("max(cylinder.s)", {"rod_length": [1.4, 1.5]}),
        slider_crank.simulate_many({"rod_length": [1.4, 1.5]}, stop=0.1),
        fitted,
        pendulum.modes(),
        cart_pole.linearize(),
        pendulum.equilibrium(),
        pendulum.sensitivities("bob.angle", "length", [1.0]),
        seen.log,
        seen,
    ]
    for own in shown:
        page = own._repr_html_()
        assert page.count("<tr>") > 1 or own is seen.log, type(own)
        assert page.count("<table>") == page.count("</table>") >= 1
    assert "length" in str(fitted) and "standard error" in str(fitted)
    # Names are the user's: none is markup.
    table = cotree.Table({"a<b": np.zeros(1)}, [("max(<x>)", "m")], np.ones((1, 1)), ["it <failed>"])
    assert "<x>" not in table._repr_html_() and "&lt;failed&gt;" in table._repr_html_()
    assert cart_pole.drawing()._repr_svg_().startswith("<svg") and cart_pole.film(stop=0.1)._repr_svg_() and cart_pole.graph()._repr_svg_()
    assert not hasattr(cart_pole.drawing(format="dxf"), "_repr_svg_")


def test_long_tables_show_their_beginning(slider_crank):
    many = slider_crank.measure("max(cylinder.s)", {"rod_length": np.linspace(1.4, 1.5, 100)}, stop=0.1)
    assert many._repr_html_().count("<tr>") == 31 and "and 70 more" in many._repr_html_()


def test_a_grid_keeps_its_axes(slider_crank):
    xarray = pytest.importorskip("xarray")
    table = slider_crank.sweep("max(cylinder.s)", {"crank_length": [0.4, 0.5], "rod_length": ["1400 mm", 1.5, 1.6]}, stop=0.2)
    found = table.to_xarray()
    assert dict(found.sizes) == {"crank_length": 2, "rod_length": 3} and found["max(cylinder.s)"].attrs["units"] == "m" == found["rod_length"].attrs["units"]
    for run in range(6):
        at = found.sel(crank_length=table["crank_length"][run], rod_length=table["rod_length"][run])
        assert float(at["max(cylinder.s)"]) == table["max(cylinder.s)"][run]
    drawn = slider_crank.sweep("max(cylinder.s)", {"rod_length": "1.4..1.6"}, random=4, stop=0.2)
    assert drawn.axes is None and dict(drawn.to_xarray().sizes) == {"run": 4} and drawn.to_xarray()["rod_length"].dims == ("run",)
    # In parts, too, and where some runs fail.
    calls = []
    again = slider_crank.sweep("max(cylinder.s)", {"crank_length": [0.4, 0.5], "rod_length": ["1400 mm", 1.5, 1.6]}, stop=0.2, progress=lambda done, of: calls.append((done, of)))
    assert again == table and calls[-1] == (6, 6)
    failing = slider_crank.sweep("max(cylinder.s)", {"crank_length": [0.4, 3.0], "rod_length": [1.4, 1.5]}, stop=2).to_xarray()
    assert failing["failure"].dims == ("crank_length", "rod_length") and [bool(text) for text in failing["failure"].values.flat] == [False, False, True, True]
    assert isinstance(failing, xarray.Dataset) and np.isnan(failing["max(cylinder.s)"].values[1]).all()


def test_many_runs_are_a_data_set_of_runs_and_times(slider_crank, root):
    pytest.importorskip("xarray")
    runs = slider_crank.simulate_many({"rod_length": [1.4, 1.5, 1.6]}, stop=0.1)
    found = runs.to_xarray()
    assert found["cylinder.s"].dims == ("run", "time") and found["cylinder.s"].attrs["units"] == "m" and found["rod_length"].values.tolist() == [1.4, 1.5, 1.6]
    assert np.array_equal(found["cylinder.s"].values[1], runs[1]["cylinder.s"])
    # Runs that end at times of their own have no numbers at those of others.
    ending = cotree.loads(
        'name = "falls"\ngravity = [0, -9.81]\n[parameters]\nheight = "1 m"\n[bodies.stone]\nmass = 1\ninertia = 1\n[initial]\n"stone.y" = "height"\n'
        '[events.ground]\nwhen = "stone.y < 0[m]"\nstop = true\n[outputs]\nvariables = ["stone.y"]\n[experiment]\nstop = "1 s"\nstep = "0.1 s"\n'
    ).simulate_many({"height": [1.0, 2.0]})
    data = ending.to_xarray()["stone.y"]
    for index, run in enumerate(ending):
        own = data.isel(run=index).dropna("time")
        assert np.array_equal(own["time"], run.time) and np.array_equal(own.values, run["stone.y"]) and run.ended == "ground"


def test_systems_and_modes_are_handed_over_with_their_names(cart_pole, pendulum):
    pytest.importorskip("xarray")
    system = cart_pole.linearize()
    A, B, C, D = system
    frames, data = system.to_pandas(), system.to_xarray()
    for row in system.states:
        for column in system.states:
            assert frames["A"].loc[row, column] == float(data["A"].sel(rate=row, state=column)) == A[system.states.index(row), system.states.index(column)]
    assert frames["B"].loc["rail.v", "push"] == float(data["B"].sel(rate="rail.v", input="push")) and C.shape == (len(system.outputs), 4) and D.shape == (len(system.outputs), 1)
    assert data["state_units"].sel(state="rail.v") == "m/s"
    modes = pendulum.modes()
    assert modes == pendulum.modes() == pickle.loads(pickle.dumps(modes)) and modes != pendulum.modes(set={"length": 2.0})
    assert modes.to_pandas()["frequency"][0] == modes[0].frequency == modes.to_xarray()["frequency"].values[0]
    assert modes.to_xarray()["shape"].dims == ("mode", "coordinate")


def test_tables_are_written_without_pandas(pendulum, tmp_path):
    seen = pendulum.simulate(stop=0.01)
    head, *rows = csv.reader(io.StringIO(seen.to_csv()))
    assert head == ["time", *seen] and np.array_equal(np.array(rows, dtype=float)[:, 1], seen["bob.angle"])
    assert seen.to_csv(tmp_path / "run.csv") is None and (tmp_path / "run.csv").read_text() == seen.to_csv()
    table = pendulum.measure("max(bob.angle)", {"length": [0.5, 1.0]}, stop=0.1)
    head, *rows = csv.reader(io.StringIO(table.to_csv()))
    assert head == ["run", "length [m]", "max(bob.angle) [rad]", "failure"] and float(rows[1][2]) == table["max(bob.angle)"][1]
    runs = pendulum.simulate_many({"length": [0.5, 1.0]}, stop=0.01)
    head, *rows = csv.reader(io.StringIO(runs.to_csv()))
    assert head[:3] == ["run", "time", "length"] and len(rows) == 22 and float(rows[-1][3]) == runs[1]["bob.angle"][-1]


def test_results_are_cut_by_index_and_by_time(pendulum):
    seen = pendulum.simulate(stop=1, step=0.1)
    assert len(seen[0:3].time) == 3 and np.array_equal(seen[-2:]["bob.angle"], seen["bob.angle"][-2:]) and seen[::-1].time[0] == 1.0
    assert seen.sel(time=slice(0.2, 0.5)) == seen.between(0.2, 0.5)
    assert np.allclose(seen.between("200 ms", 0.5).time, [0.2, 0.3, 0.4, 0.5]) and len(seen.between(2.0).time) == 0
    values = seen.at(np.array([0.1, 0.25]))
    assert values["bob.angle"].shape == (2,) and values["bob.angle"][1] == seen.at(0.25)["bob.angle"]
    with pytest.raises(ValueError, match=r"at: 2 s is outside"):
        seen.at([0.1, 2.0])
    with pytest.raises(TypeError, match="`between` takes times"):
        seen[0.1:0.5]
    table = pendulum.measure("max(bob.angle)", {"length": [0.5, 1.0, 1.5]}, stop=0.1)
    assert table[1:].runs == 2 and table[1:]["length"].tolist() == [1.0, 1.5]
    assert "bob.angle" in seen._ipython_key_completions_() and "length" in table._ipython_key_completions_()


class Bar:
    """As those of tqdm."""

    def __init__(self):
        self.n, self.total = 0, None

    def update(self, n=1):
        self.n += n


def test_calls_that_take_long_say_how_far_they_are(slider_crank, pendulum, capsys):
    values, bar = {"length": np.linspace(0.5, 1.0, 40)}, Bar()
    runs = pendulum.simulate_many(values, stop=0.1, progress=bar)
    assert (bar.n, bar.total) == (40, 40) and runs == pendulum.simulate_many(values, stop=0.1)
    pendulum.measure("max(bob.angle)", values, stop=0.1, progress=True)
    assert "40" in capsys.readouterr().err
    seen, calls = pendulum.simulate(set={"length": 0.8}, step=0.05), []
    pendulum.fit({"time": seen.time, "bob.angle": seen["bob.angle"]}, "length", progress=lambda done, of: calls.append((done, of)))
    assert calls and all(0 < done <= of for done, of in calls)
    calls.clear()
    pendulum.optimize({"length": (0.5, 2.0)}, minimize="last(bob.angle)", starts=3, stop=0.5, progress=lambda done, of: calls.append((done, of)))
    assert calls[-1] == (3, 3)
    task = {"poses": {"at": [["0 mm", "0 mm", "0 deg"], ["35 mm", "20 mm", "14 deg"], ["80 mm", "60 mm", "38 deg"]]}}
    stages = Bar()
    cotree.synthesize(task, progress=stages)
    assert stages.n == stages.total
    with pytest.raises(TypeError, match="progress: 3 is neither"):
        pendulum.measure("max(bob.angle)", values, stop=0.1, progress=3)


@pytest.mark.parametrize("call", ["measure", "simulate_many", "fit", "optimize"])
def test_what_progress_raises_ends_the_call(call, pendulum):
    class Enough(Exception):
        pass

    def enough(done, of):
        raise Enough

    seen = pendulum.simulate(step=0.05)
    with pytest.raises(Enough):
        if call == "measure":
            pendulum.measure("max(bob.angle)", {"length": np.linspace(0.5, 1, 100)}, progress=enough)
        elif call == "simulate_many":
            pendulum.simulate_many({"length": np.linspace(0.5, 1, 100)}, progress=enough)
        elif call == "fit":
            pendulum.fit({"time": seen.time, "bob.angle": seen["bob.angle"]}, "length", progress=enough)
        else:
            pendulum.optimize({"length": (0.5, 2.0)}, minimize="last(bob.angle)", stop=0.5, progress=enough)


def test_axes_may_be_given(pendulum):
    import matplotlib.pyplot as plt

    _, one = plt.subplots()
    assert pendulum.simulate(stop=0.1).plot("bob.angle", ax=one) == [one] and len(one.lines) == 1
    _, grid = plt.subplots(2, 1)
    seen = pendulum.simulate(stop=0.1)
    axes = seen.plot(ax=grid)
    assert len(axes) == 2 and [own.get_ylabel() for own in axes] == ["rad", "J"]
    _, both = plt.subplots()
    assert seen.plot(ax=both) == [both] and both.get_legend().get_texts()[1].get_text() == "energy.total [J]"
    with pytest.raises(ValueError, match="3 axes for 2 units"):
        seen.plot(ax=plt.subplots(3, 1)[1])


def test_films_are_taken_with_other_values(pendulum):
    still, moved = pendulum.film(stop="100 ms"), pendulum.film(stop="100 ms", set={"length": "2 m", "bob.angle": 1.0})
    assert still != moved and len(pendulum.frames(fps=10, stop=0.5, width=100)) == 6 and len(pendulum.frames(fps=10, width=100)) == 21
    assert pendulum.drawing().save


def test_numbers_of_python_are_numbers_and_truth_values_are_not(pendulum):
    exact = pendulum.simulate(stop=0.1, set={"length": 1.5})
    assert pendulum.simulate(stop=Fraction(1, 10), set={"length": Decimal("1.5")}) == pendulum.simulate(stop=Decimal("0.1"), set={"length": Fraction(3, 2)}) == exact
    for wrong in (True, np.True_, np.array(True)):
        with pytest.raises(TypeError, match="neither a number"):
            pendulum.simulate(stop=0.1, set={"length": wrong})
    run = pendulum.start()
    run.step(Fraction(1, 100))
    with pytest.raises(TypeError, match="neither a number"):
        run.step(True)
    with pytest.raises(ValueError, match="no numbers"):
        pendulum.simulate_many({"length": [True, True]}, stop=0.1)
    with pytest.raises(TypeError, match="neither a number"):
        pendulum.simulate(stop=True)


def test_a_run_is_pickled_with_what_has_happened(root):
    run = cotree.load(root / "models/end_stop/scene.toml").start()
    run.step(1.0)
    again = pickle.loads(pickle.dumps(run))
    assert len(run.log) > 0 and again.log == run.log
    run.step(0.5), again.step(0.5)
    assert again.log == run.log and again.to_numpy().tobytes() == run.to_numpy().tobytes()


def test_a_run_begins_again_in_place(cart_pole):
    run, fresh = cart_pole.start(set={"cart_mass": 1.5}), cart_pole.start(set={"cart_mass": 1.5})
    run.step(0.5, push=2.0)
    run.reset()
    assert run.time == 0.0 and run["push"] == 0.0 and run.log == fresh.log
    run.step(0.3, push=1.0), fresh.step(0.3, push=1.0)
    assert run.to_numpy().tobytes() == fresh.to_numpy().tobytes()
    # With values that the scene leaves open, too: those of `start` hold beside them.
    run.reset({"rail.v": 0.5, "pole.angle": "100 deg"})
    other = cart_pole.start(set={"cart_mass": 1.5, "rail.v": 0.5, "pole.angle": "100 deg"})
    assert run["rail.v"] == 0.5 and run["cart_mass"] == 1.5
    run.step(0.3, push=1.0), other.step(0.3, push=1.0)
    assert run.to_numpy().tobytes() == other.to_numpy().tobytes()
    run.reset()
    assert run["rail.v"] == 0.0
    # Where there is no start it stays where it is.
    run.step(0.2)
    before = run.state
    with pytest.raises((ValueError, cotree.RunError)):
        run.reset({"cart_mass": -1.0})
    assert run.time == 0.2 and run.state == before
    assert len(pickle.loads(pickle.dumps(run)).log) == len(run.log)


def test_a_model_becomes_a_builder(pendulum, root):
    more = pendulum.builder().body("ball", mass=2, inertia=1).output("ball.y").model()
    assert "ball.y" in more.variables and "ball.y" not in pendulum.variables
    assert cotree.Builder.of(pendulum).model() == pendulum
    scene = root / "models/slider_crank/scene.toml"
    assert cotree.load(scene).builder().model().simulate(stop=0.1) == cotree.load(scene).simulate(stop=0.1)


def test_functions_are_inputs_of_many_runs(cart_pole):
    laws = {"push": lambda t, run: np.sin(5 * t) - run["rail.v"]}
    runs = cart_pole.simulate_many({"cart_mass": [1.0, 2.0]}, inputs=laws, stop=0.2)
    assert [run.parameters for run in runs] == [{"cart_mass": 1.0}, {"cart_mass": 2.0}]
    for run, mass in zip(runs, (1.0, 2.0), strict=True):
        assert np.array_equal(run.to_numpy(), cart_pole.simulate(inputs=laws, stop=0.2, set={"cart_mass": mass}).to_numpy())


def test_columns_of_arrow_are_inputs(cart_pole):
    pyarrow = pytest.importorskip("pyarrow")
    columns = {"time": [0.0, 1.0], "push": [0.0, 1.0]}
    assert cart_pole.simulate(inputs=pyarrow.table(columns), stop=1) == cart_pole.simulate(inputs=columns, stop=1)
    with pytest.raises(ValueError, match="truth values"):
        cart_pole.simulate(inputs={"time": [0.0, 1.0], "push": [False, True]}, stop=1)


def test_gradients_of_many_runs_are_those_of_each(slider_crank):
    lengths, cranks = [1.4, 1.5, 1.6, 1.7], [0.4, 0.5, 0.45, 0.42]
    values, gradients = slider_crank.value_and_gradient(["max(cylinder.s)", "rms(cylinder.s)"], {"rod_length": lengths, "crank_length": cranks}, stop=1)
    assert values.shape == (4, 2) and gradients.shape == (4, 2, 2)
    for index, (length, crank) in enumerate(zip(lengths, cranks, strict=True)):
        value, gradient = slider_crank.value_and_gradient(["max(cylinder.s)", "rms(cylinder.s)"], {"rod_length": length, "crank_length": crank}, stop=1)
        assert np.array_equal(values[index], value) and np.array_equal(gradients[index], gradient)
    alone = slider_crank.value_and_gradient(["max(cylinder.s)", "rms(cylinder.s)"], {"rod_length": lengths, "crank_length": cranks}, stop=1, threads=1)
    assert np.array_equal(alone[1], gradients)
    with pytest.raises(cotree.RunError):
        slider_crank.value_and_gradient("max(cylinder.s)", {"crank_length": [0.4, 0.5, 3.0, 0.45]}, stop=2)


def test_films_are_taken_of_results_and_with_inputs(cart_pole, root, tmp_path):
    push = {"time": [0, 0.2, 0.5], "push": [0.0, 8.0, -8.0]}
    seen = cart_pole.simulate(outputs=cart_pole.film_variables, inputs=push, stop=0.5, times=None, step=0.5 / 1920)
    film = cart_pole.film(inputs=push, stop=0.5)
    assert film == cart_pole.film(seen) and film != cart_pole.film(stop=0.5)
    # A run without inputs is the film of the scene, whoever has made it.
    plain = cart_pole.simulate(outputs=cart_pole.film_variables, stop=0.5, step=0.5 / 1920)
    assert cart_pole.film(plain) == cart_pole.film(stop=0.5)
    held = cart_pole.film(inputs={"push": lambda t, run: -5.0 * run["rail.v"] + 3.0}, stop=0.5)
    assert held not in (film, cart_pole.film(stop=0.5)) and held.startswith("<svg")
    # Any table will do, such as the rows that a controller has seen; lengths are those of what is set.
    rows = {"time": seen.time[::64], **{name: seen[name][::64] for name in ("cart.x", "cart.y", "cart.angle", "pole.x", "pole.y", "pole.angle")}}
    assert len(cart_pole.frames(rows, fps=4, width=120)) == 3
    assert cart_pole.film(rows, set={"pole_length": "2 m"}) != cart_pole.film(rows)
    member = cart_pole.simulate_many({"pole_length": [2.0]}, outputs=cart_pole.film_variables, stop=0.5)[0]
    assert cart_pole.film(member) == cart_pole.film(member, set={"pole_length": 2.0})
    with pytest.raises(ValueError, match="results: there is no 'cart.x'; `simulate\\(outputs=model.film_variables\\)`"):
        cart_pole.film(cart_pole.simulate(stop=0.1))
    with pytest.raises(TypeError, match="results have their own times and inputs"):
        cart_pole.film(seen, stop=0.1)
    # What ends early has what comes before, and marks what strikes.
    stopped = cotree.load(root / "models/end_stop/scene.toml")
    run = stopped.simulate(outputs=stopped.film_variables, stop=1)
    assert stopped.film(run).count("<animate") >= stopped.film({"time": run.time, **{name: run[name] for name in run if name.count(".") == 1 and name.split(".")[1] in ("x", "y", "angle")}}).count("<animate")
    far = cotree.loads(cart_pole.text + '[events.far]\nwhen = "rail.s > 0.05[m]"\nstop = true\n')
    with pytest.warns(RuntimeWarning, match="`far` has ended the run"):
        assert far.film(inputs={"time": [0], "push": [5.0]}).startswith("<svg")
