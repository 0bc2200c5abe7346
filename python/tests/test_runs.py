"""Runs: numbers, units, settings, inputs, many at once."""

import os
import re
import signal
import subprocess
import sys
import threading
import time

import matplotlib
import matplotlib.pyplot
import numpy as np
import pytest

import cotree


def test_a_pendulum_swings_as_in_closed_form(pendulum):
    results = pendulum.simulate()
    assert results.units == {"bob.angle": "rad", "energy.total": "J"}
    # Small, but not infinitely: the period grows by a^2/16.
    amplitude = np.radians(1)
    rate = np.sqrt(9.81) / (1 + amplitude**2 / 16)
    assert np.allclose(results["bob.angle"], amplitude * np.cos(rate * results.time), atol=1e-8)
    assert np.ptp(results["energy.total"]) < 1e-9
    assert results["time"] is results.time and len(results) == 2
    with pytest.raises(KeyError, match=r"bob\.angle"):
        results["bob.angel"]


def test_the_numbers_are_those_of_the_command(tmp_path, root, slider_crank):
    scene = root / "models/slider_crank/scene.toml"
    table = tmp_path / "out.csv"
    subprocess.run([sys.executable, "-m", "cotree._command", "simulate", scene, "-o", table], check=True)
    lines = table.read_text().splitlines()
    rows = np.array([[float(value) for value in line.split(",")] for line in lines[1:]])
    results = slider_crank.simulate()
    assert np.array_equal(rows[:, 0], results.time)
    assert np.array_equal(rows[:, 1:], results.to_numpy())


def test_settings_are_numbers_or_texts_with_units(pendulum):
    in_metres = pendulum.simulate(set={"length": 0.5})
    assert np.array_equal(in_metres["bob.angle"], pendulum.simulate(set={"length": "500 mm"})["bob.angle"])
    assert pendulum.simulate(set={"bob.angle": "2 deg"})["bob.angle"][0] == np.radians(2.0)
    assert len(pendulum.simulate(stop="20 ms", step="5 ms").time) == 5
    for wrong, message in [
        ({"lenght": 1}, "length"),
        ({"length": "1 kg"}, "kg"),
        ({"length": 0}, "at least"),
        ({"length": np.nan}, "finite"),
    ]:
        with pytest.raises(ValueError, match=message):
            pendulum.simulate(set=wrong)
    for times in [{"stop": -1}, {"step": 0}, {"tolerance": 2}, {"step": 1e-12}]:
        with pytest.raises(ValueError):
            pendulum.simulate(**times)


def test_results_are_drawn_one_pair_of_axes_for_each_unit(pendulum):
    matplotlib.use("Agg")
    results = pendulum.simulate(outputs=["bob.angle", "hinge.fx", "hinge.fy"], step="10 ms")
    axes = results.plot()
    assert [own.get_ylabel() for own in axes] == ["rad", "N"] and axes[-1].get_xlabel() == "time [s]"
    angle, forces = axes[0].lines, axes[1].lines
    assert np.array_equal(angle[0].get_xdata(), results.time) and np.array_equal(angle[0].get_ydata(), results["bob.angle"])
    assert [line.get_label() for line in forces] == ["hinge.fx", "hinge.fy"]
    [own] = results.plot("hinge.fy", x="bob.angle")
    assert own.get_xlabel() == "bob.angle [rad]" and np.array_equal(own.lines[0].get_xdata(), results["bob.angle"])
    with pytest.raises(KeyError, match="was not reported"):
        results.plot("bob.x")
    matplotlib.pyplot.close("all")


def test_without_matplotlib_a_plot_says_so(pendulum, monkeypatch):
    class Missing:
        def find_spec(self, name, *_):
            if name == "matplotlib":
                raise ModuleNotFoundError("No module named 'matplotlib'", name=name)

    for name in [name for name in sys.modules if name.partition(".")[0] == "matplotlib"]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setattr(sys, "meta_path", [Missing(), *sys.meta_path])
    with pytest.raises(ImportError, match="pip install matplotlib"):
        pendulum.simulate(stop="0.1 s").plot()


def test_a_notebook_shows_ranges_and_courses(pendulum):
    results = pendulum.simulate(stop="2 s", step="0.1 ms")
    page = results._repr_html_()
    assert len(page) < 5000 and page.count("<svg") == 2
    row = re.search(r"<tr><td>bob\.angle</td><td>rad</td><td>.*?</td>(.*?)</tr>", page).group(1)
    shown = [float(cell) for cell in re.findall(r"<td>(.*?)</td>", row)]
    angle = results["bob.angle"]
    assert np.allclose(shown, [angle.min(), angle.max(), angle[-1]], rtol=1e-5)
    heights = [float(pair.split(",")[1]) for pair in re.search(r'points="(.*?)"', page).group(1).split()]
    assert heights[0] == min(heights) == 1.0 and 18.0 < max(heights) <= 19.0
    odd = cotree.Results(np.zeros(1), ["<b>"], ["<i>"], np.array([[np.nan]]), "so & so")._repr_html_()
    assert "<b>" not in odd and "<i>" not in odd and "so &amp; so" in odd and "<svg" not in odd
    many = cotree.Results(np.zeros(0), [f"v{index}" for index in range(40)], [""] * 40, np.zeros((0, 40)))._repr_html_()
    assert "and 10 more" in many and many.count("<tr>") == 31


def test_other_outputs_are_computed_on_request(pendulum):
    results = pendulum.simulate(outputs=["hinge.fy", "bob.x", "bob.x"], stop=0.1)
    assert list(results) == ["hinge.fy", "bob.x"]
    assert results["hinge.fy"][0] == pytest.approx(9.81, rel=1e-3)
    with pytest.raises(cotree.SceneError, match="hinge"):
        pendulum.simulate(outputs=["hinge.fz"])


@pytest.fixture
def cart():
    """A mass of 2 kg, pushed by an input."""
    return cotree.loads(
        "name='cart'\ndimension=1\n[inputs]\nforce={start=0.0,unit='N'}\n[bodies.cart]\nmass=2.0\n"
        "[loads.push]\ntype='force'\non='cart'\nvector=['force']\n[outputs]\nvariables=['cart.x']\n[experiment]\nstop=2.0\nstep=0.5\n"
    )


def test_inputs_over_time_move_a_mass(cart):
    pandas = pytest.importorskip("pandas")
    # F = 4 t: x = t^3/3.
    ramp = {"time": [0.0, 2.0], "force": [0.0, 8.0]}
    exact = np.array([0.0, 0.5, 1.0, 1.5, 2.0]) ** 3 / 3
    frames = [ramp, pandas.DataFrame(ramp), pandas.DataFrame(ramp).set_index("time")]
    for inputs in frames:
        assert np.allclose(cart.simulate(inputs=inputs)["cart.x"], exact, atol=1e-9)
    for wrong, message in [
        ({"force": [1]}, "time"),
        ({"time": [0], "froce": [1]}, "force"),
        ({"time": [1, 0], "force": [1, 1]}, "increasing"),
        ({"time": [0, 1], "force": [1]}, "values"),
    ]:
        with pytest.raises(ValueError, match=message):
            cart.simulate(inputs=wrong)


def test_a_run_that_cannot_go_on_keeps_what_comes_before():
    scene = "name='a'\ndimension=1\n[bodies.b]\nmass=1.0\n[loads.f]\ntype='force'\non='b'\nvector=['1/(1 - t) * 1 N*1 s']\n[outputs]\nvariables=['b.x']\n[experiment]\nstop=2.0\nstep=0.1\n"
    scene = scene.replace("1/(1 - t) * 1 N*1 s", "sqrt(1 - t)")
    with pytest.raises(cotree.RunError) as caught:
        cotree.loads(scene).simulate()
    kept = caught.value.results
    assert 0.5 < kept.time[-1] <= 1.0 and len(kept["b.x"]) == len(kept.time)
    assert kept.failure == str(caught.value)
    runs = cotree.loads(scene).simulate_many([{}, {}])
    assert set(runs.failures) == {0, 1}


def test_many_runs_are_single_runs(slider_crank):
    lengths = np.linspace(0.9, 1.6, 7)
    one = slider_crank.simulate_many({"rod_length": lengths}, stop=0.5, threads=1)
    two = slider_crank.simulate_many({"rod_length": lengths}, stop=0.5, threads=3)
    for length, first, second in zip(lengths, one, two, strict=True):
        alone = slider_crank.simulate(set={"rod_length": length}, stop=0.5)
        assert np.allclose(first.to_numpy(), alone.to_numpy(), rtol=1e-6, atol=1e-6)
        assert np.array_equal(first.to_numpy(), second.to_numpy())
        assert first.parameters == {"rod_length": length}
    assert one.to_numpy().shape == (7, len(alone.time), len(alone))


def test_parameters_come_in_any_shape(pendulum):
    pandas = pytest.importorskip("pandas")
    polars = pytest.importorskip("polars")
    table = {"length": [0.5, 1.0], "bob.angle": [0.1, 0.1]}
    rows = [{"length": 0.5, "bob.angle": 0.1}, {"length": 1.0, "bob.angle": 0.1}]
    shapes = [table, rows, pandas.DataFrame(table), polars.DataFrame(table), {"length": np.array([0.5, 1]), "bob.angle": 0.1}]
    first = [run.to_numpy() for run in pendulum.simulate_many(shapes[0], stop=0.1)]
    for shape in shapes[1:]:
        again = pendulum.simulate_many(shape, stop=0.1)
        assert all(np.array_equal(a, b.to_numpy()) for a, b in zip(first, again, strict=True))
    for wrong in [{"length": [1, 2], "bob.angle": [1, 2, 3]}, [{"length": 1}, {}], {"length": [[1]]}, {"length": [-1]}]:
        with pytest.raises(ValueError):
            pendulum.simulate_many(wrong)
    assert len(pendulum.simulate_many({"length": []})) == 0


def test_measures_are_those_of_the_whole_run(pendulum):
    lengths = [0.5, 1.0, 2.0]
    asked = ["max(bob.angle)", "min(bob.angle)", "when_min(bob.angle)", "mean(energy.total)", "hinge.fy"]
    table = pendulum.measure(asked, {"length": lengths})
    runs = pendulum.simulate_many({"length": lengths}, outputs=["bob.angle", "energy.total", "hinge.fy"])
    for index, run in enumerate(runs):
        assert table["max(bob.angle)"][index] == run["bob.angle"].max()
        assert table["min(bob.angle)"][index] == run["bob.angle"].min()
        assert table["when_min(bob.angle)"][index] == run.time[run["bob.angle"].argmin()]
        assert table["mean(energy.total)"][index] == pytest.approx(np.trapezoid(run["energy.total"], run.time) / 2)
        assert table["last(hinge.fy)"][index] == run["hinge.fy"][-1]
    assert table.units["when_min(bob.angle)"] == "s" and table.units["max(bob.angle)"] == "rad"
    assert list(table.to_pandas().columns)[0] == "length"
    with pytest.raises(ValueError, match="not one of max"):
        pendulum.measure("largest(bob.angle)", {"length": lengths})


def test_frames_have_the_numbers_and_the_units(pendulum):
    pytest.importorskip("pandas")
    pytest.importorskip("polars")
    results = pendulum.simulate(stop=0.1)
    frame = results.to_pandas()
    assert frame.index.name == "time" and frame.attrs["units"]["bob.angle"] == "rad"
    assert np.array_equal(frame["bob.angle"], results["bob.angle"])
    assert results.to_polars().columns == ["time", "bob.angle", "energy.total"]
    assert pendulum.simulate_many({"length": [1, 2]}, stop=0.1).to_pandas().index.names == ["run", "time"]


def test_runs_let_other_threads_work(pendulum):
    beats, done = [], threading.Event()

    def beat():
        while not done.is_set():
            beats.append(time.monotonic())
            time.sleep(0.001)

    other = threading.Thread(target=beat)
    other.start()
    pendulum.simulate_many({"length": np.linspace(0.5, 2, 300)}, stop=20, threads=1)
    done.set()
    other.join()
    assert len(beats) > 10


@pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")
def test_ctrl_c_ends_a_long_call(root):
    code = (
        "import cotree, sys, numpy as np\n"
        f"model = cotree.load({str(root / 'models/slider_crank/scene.toml')!r})\n"
        "print('ready', flush=True)\n"
        "try:\n"
        "    model.measure('cylinder.s', {'rod_length': np.linspace(1.2, 1.6, 1_000_000)}, threads=1)\n"
        "except KeyboardInterrupt:\n"
        "    print('interrupted', flush=True)\n"
    )
    process = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True)
    assert process.stdout.readline() == "ready\n"
    time.sleep(0.5)
    process.send_signal(signal.SIGINT)
    assert process.communicate(timeout=60)[0] == "interrupted\n"


def test_arguments_that_cannot_be_meant_are_named(pendulum):
    pandas = pytest.importorskip("pandas")
    twice = pandas.DataFrame([[0.5, 1.0]], columns=["length", "length"])
    for wrong, message in [
        (twice, "length given by more than one column"),
        (pandas.DataFrame({"length": ["70 kg"]}), "'length' has values that are no numbers"),
        ({"length": [1.0, np.nan]}, "'length' of run 1 is nan"),
        ({"length": [1, 2], "bob.angle": [1, 2, 3]}, "'length' 2, 'bob.angle' 3"),
    ]:
        with pytest.raises(ValueError, match=message):
            pendulum.simulate_many(wrong, stop=0.1)
    with pytest.raises(ValueError, match="threads"):
        pendulum.simulate_many({"length": [1.0]}, threads=-1)
    for wrong, message in [
        ({"stop": [1]}, r"stop: \[1\]"),
        ({"tolerance": "fine"}, "tolerance"),
        ({"set": {"length": None}}, "length has no value"),
        ({"set": {"length": [1]}}, "length"),
        ({"set": [("length", 1)]}, "set: give a mapping"),
    ]:
        with pytest.raises(TypeError, match=message):
            pendulum.simulate(**wrong)
    with pytest.raises(TypeError, match="parameters: give"):
        pendulum.simulate_many(None)
    with pytest.raises(ValueError) as wrong:
        pendulum.simulate(set={"lenght": 1, "length": "2 kg"})
    assert "lenght" in str(wrong.value) and "kg" in str(wrong.value)


def test_no_runs_one_name_and_many_threads_are_fine(pendulum):
    pytest.importorskip("pandas")
    pytest.importorskip("polars")
    assert list(pendulum.simulate(outputs="hinge.fy", stop=0.1)) == ["hinge.fy"]
    none = pendulum.simulate_many({"length": []}, stop=0.1)
    assert none.to_pandas().index.names == ["run", "time"] and len(none.to_polars()) == 0
    two = pendulum.simulate_many({"length": [1, 2]}, stop=0.1, threads=1_000_000)
    frame = two.to_polars()
    assert frame.columns[:2] == ["run", "time"] and np.array_equal(frame["bob.angle"][-101:], two[1]["bob.angle"])


def test_times_have_the_bits_of_communication_points(slider_crank, pendulum):
    steps = slider_crank.simulate(stop=1, step=0.05)
    listed = slider_crank.simulate(times=steps.time)
    assert listed == steps and not listed.time.flags.writeable
    uneven = [0.0, 0.137, 0.138, 0.9, 1.0]
    seen = slider_crank.simulate(times=uneven)
    assert seen.time.tolist() == uneven
    # The same run asked at more times has the same values at these.
    more = slider_crank.simulate(times=sorted({*uneven, *steps.time.tolist()}))
    for place, time in enumerate(uneven):
        assert seen.at(time) == more.at(time) and seen.to_numpy()[place].tolist() == list(more.at(time).values())
    # A pendulum's small swing is known at any time.
    swing = pendulum.simulate(times=["0.1 s", "700 ms"], set={"bob.angle": 1e-4})["bob.angle"]
    assert swing == pytest.approx(1e-4 * np.cos(np.sqrt(9.81) * np.array([0.1, 0.7])), rel=1e-6)
    many = slider_crank.simulate_many({"rod_length": [1.4, 1.5]}, times=uneven, threads=2)
    assert many[1].to_numpy().tolist() == slider_crank.simulate(times=uneven, set={"rod_length": 1.5}).to_numpy().tolist()
    table = slider_crank.measure("mean(cylinder.s)", {"rod_length": [1.4]}, times=uneven)
    assert table["mean(cylinder.s)"][0] == pytest.approx(np.trapezoid(many[0]["cylinder.s"], uneven))
    value, _ = slider_crank.value_and_gradient("max(cylinder.s)", {"rod_length": 1.4}, times=uneven)
    assert value == pytest.approx(many[0]["cylinder.s"].max(), abs=1e-6)


def test_times_that_are_none_are_said(pendulum):
    with pytest.raises(ValueError, match="leave `stop` and `step` out"):
        pendulum.simulate(times=[0, 1], stop=1)
    for times, told in (([], "at least one"), ([1, 0.5], "increasing"), ([-1, 1], "from the start"), ([0, np.nan], "increasing")):
        with pytest.raises(ValueError, match=told):
            pendulum.simulate(times=times)
    with pytest.raises(TypeError, match="not a time"):
        pendulum.simulate(times=[None])


def ramp(index):
    pandas = pytest.importorskip("pandas")
    return pandas.DataFrame({"push": [0.0, 5.0, 5.0]}, index=index)


@pytest.mark.parametrize("unit", ["s", "ms", "us", "ns"])
def test_durations_are_times_in_their_own_unit(root, unit):
    pandas = pytest.importorskip("pandas")
    pole = cotree.load(root / "models/cart_pole/scene.toml")
    seconds = pole.simulate(inputs={"time": [0, 1, 2], "push": [0, 5, 5]}, stop=1, step=0.5)
    durations = np.array([0, 1, 2], "timedelta64[s]").astype(f"timedelta64[{unit}]")
    for times in [durations, list(durations), [pandas.Timedelta(own) for own in durations], pandas.Index(durations)]:
        found = pole.simulate(inputs={"time": times, "push": [0, 5, 5]}, stop=np.timedelta64(1000, "ms"), step=0.5)
        assert np.array_equal(found.to_numpy(), seconds.to_numpy())
    found = pole.simulate(inputs=ramp(pandas.Index(durations, name="time")), stop=1, step=0.5)
    assert np.array_equal(found.to_numpy(), seconds.to_numpy())


def test_dates_and_durations_that_are_no_times_are_refused(root):
    pandas = pytest.importorskip("pandas")
    pole = cotree.load(root / "models/cart_pole/scene.toml")
    with pytest.raises(ValueError, match=r"time has dates.*index - index\[0\]"):
        pole.simulate(inputs=ramp(pandas.date_range("2026-01-01", periods=3, freq="s", name="time")), stop=1)
    with pytest.raises(ValueError, match="push has durations"):
        pole.simulate(inputs={"time": [0, 1], "push": np.array([0, 5], "timedelta64[ms]")}, stop=1)
    with pytest.raises(TypeError, match="push"):
        pole.simulate(set={"push": np.timedelta64(5, "ms")}, stop=1)
    with pytest.raises(ValueError, match="push"):
        pole.simulate_many({"push": np.array([0, 5], "timedelta64[ms]")}, stop=1)


def test_an_event_ends_a_run_whatever_its_inputs_are(root):
    text = (root / "models/cart_pole/scene.toml").read_text() + '\n[events.far]\nwhen = "rail.s > 0.05[m]"\nstop = true\n'
    pole = cotree.loads(text)
    constant, held = pole.simulate(set={"push": 10.0}, stop=2), pole.simulate(inputs={"push": lambda t: 10.0}, stop=2)
    assert held.ended == constant.ended == "far" and held.failure is None
    assert held.time[-1] == pytest.approx(constant.time[-1], abs=1e-7)
    run = pole.start(set={"push": 10.0})
    run.step(2)
    assert run.ended == run.copy().ended == "far" and run.time == pytest.approx(constant.time[-1], abs=1e-7)
    with pytest.raises(cotree.RunError, match="far"):
        run.step(1)


def test_models_of_the_same_text_are_the_same(root):
    scene = root / "models/slider_crank/scene.toml"
    assert cotree.load(scene) == cotree.load(scene) and hash(cotree.load(scene)) == hash(cotree.load(scene))
    assert cotree.load(scene) != cotree.load(root / "models/pendulum/scene.toml")


def test_what_happens_is_a_table(root, tmp_path):
    scene = root / "models/end_stop/scene.toml"
    table = tmp_path / "log.csv"
    subprocess.run([sys.executable, "-m", "cotree", "simulate", scene, "-o", tmp_path / "out.csv", "--log", table], check=True, capture_output=True)
    head, *rows = (line.split(",") for line in table.read_text().splitlines())
    written = [(float(time), name, what, float(impulse) if impulse else None) for time, name, what, impulse in rows]
    model = cotree.load(scene)
    log = model.simulate().log
    assert head == ["time", "name", "what", "impulse"] and list(log) == written
    hits = [own for own in log if own.what == "impact"]
    assert len(hits) > 3 and all(own.name == "guide.max" and own.impulse > 0 for own in hits) and log[-1].what == "closes"
    assert log.columns()["impulse"].shape == (len(log),) and log.to_pandas()["what"].tolist() == [own.what for own in log]
    assert log.to_polars().columns == ["time", "name", "what", "impulse"]
    # The same of many runs, of one that is taken step by step, and of one that goes back.
    soft, hard = model.simulate_many({"restitution": [0.3, 0.6]})
    assert hard.log == log and soft.log != log and soft != hard
    run = model.start()
    for _ in range(40):
        run.step("20 ms")
    kept, before = run.state, run.log
    while run.time < 3 - 1e-9:
        run.step("20 ms")
    assert [own.what for own in run.log] == [own.what for own in log]
    assert [own.time for own in run.log] == pytest.approx([own.time for own in log], abs=1e-8)
    run.state = kept
    assert run.log == before == run.copy().log and len(before) < len(log)


def test_what_has_happened_before_a_run_fails_or_ends_is_kept():
    scene = (
        "name='cart'\ndimension=1\n[inputs]\nforce={start=0.0,unit='N'}\n[bodies.cart]\nmass=2.0\n[loads.push]\ntype='force'\non='cart'\nvector=['force/(1 - cart.x/(1[m]))']\n"
        "[loads.spare]\ntype='force'\non='cart'\nvector=[0]\n[events.half]\nwhen='cart.x > 0.5[m]'\nremove=['spare']\n[initial]\n'cart.vx'=1.0\n[outputs]\nvariables=['cart.x']\n[experiment]\nstop=2.0\nstep=0.01\n"
    )
    failing = cotree.loads(scene)
    with pytest.raises(cotree.RunError) as caught:
        failing.simulate(set={"force": 1e3}, stop=3)
    assert [own.name for own in caught.value.results.log] == ["half"]
    [of_many, _] = failing.simulate_many({"force": [1e3, 0.0]}, stop=3)
    assert of_many.failure and of_many.log == caught.value.results.log
    ending = cotree.loads(scene.replace("remove=['spare']", "stop=true"))
    for seen in (ending.simulate(), ending.simulate(inputs={"force": lambda time: 0.0})):
        assert seen.ended == "half" and seen.time[-1] == pytest.approx(0.5) == seen.log[0].time and len(seen.log) == 1


def test_calls_say_what_they_take(slider_crank):
    import inspect

    names = ("simulate", "start", "simulate_many", "measure", "sensitivities", "value_and_gradient", "peaks", "fit", "sweep", "optimize")
    for name in names:
        shown = inspect.signature(getattr(cotree.Model, name)).parameters
        assert all(shown[option].kind is inspect.Parameter.KEYWORD_ONLY for option in cotree.RunOptions.__annotations__), name
    with pytest.raises(TypeError, match=r"simulate\(\) has no argument 'stopp'; did you mean 'stop'"):
        slider_crank.simulate(stopp=1)
    with pytest.raises(TypeError, match=r"start\(\) has no argument 'inputs': set them as the run goes on"):
        slider_crank.start(inputs={"time": [0, 1], "gas_force": [0, 1]})
    with pytest.raises(TypeError, match="at the measured times"):
        slider_crank.fit({"time": [0, 1], "cylinder.s": [1, 1]}, "rod_length", step=0.1)
    with pytest.raises(TypeError, match="not a measure.*function of your own.*value_and_gradient"):
        slider_crank.optimize("rod_length", minimize=lambda x: x)
    with pytest.raises(TypeError, match=r'not a measure: give a text such as "max\(rod.angle\)"'):
        slider_crank.optimize("rod_length", maximize=3)
    with pytest.raises(TypeError, match="poses.*not ndarray"):
        cotree.synthesize(np.zeros((3, 3)))
    poses = np.array([[0, 0, 0], [0.035, 0.02, np.radians(14)], [0.08, 0.06, np.radians(38)]])
    assert cotree.synthesize({"poses": {"at": poses}, "limits": {"transmission": "35 deg"}})["solutions"]


def test_studies_begin_where_runs_do(pendulum):
    late = {"start": 0.5, "stop": 1.5, "step": "50 ms"}
    seen = pendulum.simulate(**late)
    assert seen.time[0] == 0.5 and seen["bob.angle"][0] == pytest.approx(np.radians(1))
    found = pendulum.sensitivities("bob.angle", "length", **late)
    assert np.array_equal(found.time, seen.time) and np.allclose(found.values[:, 0], seen["bob.angle"], atol=1e-9)
    value, gradient = pendulum.value_and_gradient("last(bob.angle)", {"length": 1.0}, **late)
    assert value == pytest.approx(seen["bob.angle"][-1], abs=1e-9) and gradient[0] == pytest.approx(found.derivatives[-1, 0, 0])
    lowest = next(own for own in pendulum.peaks("bob.angle", "length", **late) if own.kind == "min")
    assert lowest.time == pytest.approx(seen.time[seen["bob.angle"].argmin()], abs=0.03)
    measured = pendulum.simulate(**late, set={"length": 1.1})
    assert pendulum.fit(measured, "length", start=0.5)["length"] == pytest.approx(1.1)
    table = pendulum.sweep("first(bob.angle)", {"length": [1.0]}, times=[0.0, 0.25])
    assert table["first(bob.angle)"][0] == pytest.approx(np.radians(1))


class Scalar:
    """An array without dimensions, as JAX has them for numbers."""

    ndim, dtype = 0, np.dtype(np.float32)

    def __init__(self, value):
        self.value = value

    def __float__(self):
        return float(self.value)


@pytest.mark.parametrize("kind", [np.float32, np.float64, np.asarray, Scalar], ids=["float32", "float64", "array", "JAX"])
def test_scalars_of_other_packages_are_numbers(kind, cart):
    seen = cart.simulate(stop=kind(1.0), step=kind(0.5), tolerance=kind(1e-6), set={"force": kind(4.0)}, times=None)
    assert seen.time.tolist() == [0.0, 0.5, 1.0] and seen["cart.x"][-1] == pytest.approx(1.0)
    assert cart.simulate(times=[kind(0.5), kind(1.0)], set={"force": 4.0})["cart.x"].tolist() == pytest.approx([0.25, 1.0])
    assert cart.replace({"cart.mass": kind(4.0)}).simulate(set={"force": 4.0}, stop=1)["cart.x"][-1] == pytest.approx(0.5)
    assert cart.measure("last(cart.x)", {"force": [kind(4.0)]}, stop=1)["last(cart.x)"][0] == pytest.approx(1.0)
    run = cart.start()
    run.step(kind(1.0), force=kind(4.0))
    assert run["cart.x"] == pytest.approx(1.0)
    held = cart.simulate(inputs={"force": lambda time: kind(4.0)}, stop=1)
    assert held["cart.x"][-1] == pytest.approx(1.0)


def test_parameters_and_inputs_are_reported(cart, slider_crank):
    seen = cart.simulate(outputs=["force", "cart.x"], inputs={"time": [0, 2], "force": [0, 4]}, step=1)
    assert seen["force"].tolist() == [0.0, 2.0, 4.0] and seen.units["force"] == "N"
    assert cart.simulate(outputs="force", inputs={"force": lambda time: 3 + time}, step=1)["force"].tolist() == [3.0, 4.0, 5.0]
    runs = slider_crank.simulate_many({"rod_length": [1.4, 1.6]}, outputs=["rod_length", "cylinder.s"], stop=0.1)
    assert [own["rod_length"][-1] for own in runs] == [1.4, 1.6]
    assert slider_crank.measure("mean(rod_length)", {"rod_length": [1.4]}, stop=0.1)["mean(rod_length)"][0] == pytest.approx(1.4)
