"""Equations, equilibria, linear systems, vibrations, FMUs, pages."""

import json
import subprocess
import sys
import time
import zipfile
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import cotree


def test_equations_are_written_in_every_notation(slider_crank):
    for notation in ["text", "latex", "html", "c", "fortran", "rust", "python", "json"]:
        assert len(slider_crank.equations(notation)) > 500
    assert "documentclass" in slider_crank.equations("latex")
    assert len(slider_crank.steps("text")) > 1000
    with pytest.raises(ValueError, match="not one of text"):
        slider_crank.equations("fortran77")


def test_a_hanging_pendulum_rests_and_vibrates_as_in_closed_form(pendulum):
    rest = pendulum.equilibrium()
    assert rest.stability == "stable" and rest["bob.angle"] == pytest.approx(0, abs=1e-9)
    assert rest["hinge.fy"] == pytest.approx(9.81)
    [mode] = pendulum.modes(set={"length": 0.5})
    assert mode.frequency == pytest.approx(np.sqrt(9.81 / 0.5) / (2 * np.pi), rel=1e-9)
    system = pendulum.linearize("equilibrium")
    assert np.allclose(sorted(system.poles().imag), [-np.sqrt(9.81), np.sqrt(9.81)])


def test_linear_systems_predict_small_changes(root):
    model = cotree.load(root / "models/cart_pole/scene.toml")
    along = model.linearize([0.0, 0.1])
    assert [point.time for point in along] == [0.0, 0.1] and along[0].A.shape == (4, 4)
    at = model.linearize(0.1)
    assert np.array_equal(at.A, along[1].A) and at.B.shape == (4, len(at.inputs))
    with pytest.raises(ValueError, match="increasing"):
        model.linearize([0.2, 0.1])


def test_an_fmu_is_written_and_runs(tmp_path, slider_crank):
    fmpy = pytest.importorskip("fmpy")
    path = slider_crank.export(tmp_path / "slider_crank.fmu")
    ours = slider_crank.simulate(stop=1.0, step=0.01)
    theirs = fmpy.simulate_fmu(str(path), stop_time=1.0, output_interval=0.01)
    assert np.allclose(theirs["crank.angle"], ours["crank.angle"], atol=1e-9)
    assert slider_crank.export(tmp_path / "three.fmu", fmi=3).is_file()
    with pytest.raises(ValueError, match="not one of 2, 3"):
        slider_crank.export(tmp_path / "four.fmu", fmi=4)
    with pytest.raises(OSError):
        slider_crank.export(tmp_path / "none" / "a.fmu")


def test_derivatives_are_those_of_the_closed_form(pendulum):
    times = np.linspace(0, 2, 9)
    found = pendulum.sensitivities("bob.angle", ["length", "bob.angle"], times, set={"length": "500 mm"})
    assert found.derivatives.shape == (9, 1, 2) and found.units["bob.angle", "length"] == "rad/m"
    amplitude, length = np.radians(1), 0.5
    rate = np.sqrt(9.81 / length) / (1 + amplitude**2 / 16)
    exact = amplitude * np.sin(rate * times) * times * rate / (2 * length)
    # But for the third harmonic of the swing.
    assert np.allclose(found["bob.angle", "length"], exact, atol=1e-4 * abs(exact).max())
    assert np.allclose(found["bob.angle", "bob.angle"], np.cos(rate * times), atol=1e-3)
    step = 1e-5
    above, below = (pendulum.simulate(set={"length": 0.5 + by}, step=0.25, tolerance=1e-13) for by in (step, -step))
    difference = (above["bob.angle"] - below["bob.angle"]) / (2 * step)
    assert np.allclose(found["bob.angle", "length"], difference, atol=1e-8)
    with pytest.raises(ValueError, match="lenght"):
        pendulum.sensitivities(to="lenght", times=[1])
    with pytest.raises(ValueError, match="increasing"):
        pendulum.sensitivities(to="length", times=[1, 0])


def test_peaks_equilibria_and_modes_have_derivatives(pendulum):
    start = {"length": 0.5, "bob.angle": -1.4}
    peaks = {(peak.output, peak.kind): peak for peak in pendulum.peaks("bob.angle", "length", step=0.02, set=start)}
    highest = peaks["bob.angle", "max"]
    # Half a swing from -1.4 rad: it comes to the other side of the vertical, for any length, later by the root of the length.
    assert highest.time == pytest.approx(2 * 0.5 * highest.d_time["length"], rel=1e-6)
    assert highest.d_value["length"] == pytest.approx(0, abs=1e-6)
    [crossing, *_] = [own for own in pendulum.peaks("bob.angle", "length", step=0.02, set=start, crossing={"bob.angle": 0.0}) if own.kind == "crossing"]
    assert crossing.time == pytest.approx(2 * 0.5 * crossing.d_time["length"], rel=1e-6)
    times = np.linspace(0, 2, 101)
    assert pendulum.peaks("bob.angle", "length", times=times, set=start) == list(peaks.values())
    # Before the first of the times nothing is looked at.
    late = pendulum.peaks("bob.angle", times=times[60:90], set=start)
    assert {own.kind: own.value for own in late}["max"] < 0.99 * highest.value
    with pytest.raises(ValueError, match="leave `stop` and `step` out"):
        pendulum.peaks("bob.angle", times=times, step=0.02)
    rest = pendulum.sensitivities("bob.angle", "length", "equilibrium")
    assert abs(rest["bob.angle", "length"]).max() < 1e-9 and rest.time.shape == (1,)
    [mode] = pendulum.modes(to="length", set={"length": 0.5})
    # s = i sqrt(g / l)
    assert mode.derivatives["length"] == pytest.approx(-mode.eigenvalue / (2 * 0.5), rel=1e-9)
    with pytest.raises(ValueError, match="equilibrium"):
        pendulum.modes(1.0, to="length")
    with pytest.raises(ValueError, match="neither"):
        pendulum.sensitivities("bob.angle", "length", "rest")


def test_values_that_fit_are_those_of_scipy(pendulum):
    optimize = pytest.importorskip("scipy.optimize")
    times = np.linspace(0, 3, 61)
    truth = pendulum.simulate(set={"length": 0.53, "bob.angle": -1.4}, step=0.05, stop=3)["bob.angle"]
    seen = truth + 0.01 * np.random.default_rng(4).normal(size=len(times))
    start = {"length": 0.5, "bob.angle": -1.45}
    found = pendulum.fit({"time": times, "bob.angle": seen}, list(start), set=start, stop=3, tolerance=1e-9)
    assert found.ended == "minimum" and found.units["length"] == "m"

    def simulated(_, length, angle):
        settings = {"length": length, "bob.angle": angle}
        return pendulum.simulate(set=settings, step=0.05, stop=3, tolerance=1e-11)["bob.angle"]

    values, covariance = optimize.curve_fit(simulated, times, seen, list(start.values()), epsfcn=1e-10)
    errors = np.sqrt(np.diag(covariance))
    assert np.allclose(list(found.values.values()), values, atol=1e-3 * errors.min())
    assert np.allclose(list(found.errors.values()), errors, rtol=1e-4)
    assert found.correlation[0, 1] == pytest.approx(covariance[0, 1] / errors.prod(), abs=1e-4)
    assert np.allclose(found.fitted["bob.angle"] + found.residuals["bob.angle"], seen)
    for (low, high), exact in zip(found.limits.values(), (0.53, -1.4), strict=True):
        assert low - (high - low) < exact < high + (high - low)
    with pytest.raises(ValueError, match="varied") as wrong:
        pendulum.fit({"time": [0, 9], "bob.angle": [0, 0]}, {})
    assert "cannot determine" in str(wrong.value) or "outside" in str(wrong.value)


def test_times_and_names_of_studies_may_be_one_or_many(pendulum):
    points = pendulum.linearize(np.linspace(0, 1, 3))
    assert [point.time for point in points] == [0, 0.5, 1] and pendulum.linearize([]) == []
    assert np.array_equal(pendulum.linearize(np.float64(0.5)).A, points[1].A)
    one = pendulum.sensitivities("bob.angle", "length", 1.0)
    assert np.array_equal(one["bob.angle", "length"], pendulum.sensitivities(["bob.angle"], ["length"], [1])["bob.angle", "length"])
    with pytest.raises(KeyError, match="with respect to length"):
        one["bob.angle", "mass"]
    for wrong, message in [
        ({"at": "1 kg"}, "equilibrium"),
        ({"at": "here"}, "equilibrium"),
    ]:
        with pytest.raises(ValueError, match=message):
            pendulum.linearize(**wrong)
    for wrong, message in [
        ({"to": "length"}, "times"),
        ({"times": 1}, "to"),
        ({"to": "lenght", "times": 1}, "lenght"),
    ]:
        with pytest.raises(ValueError, match=message):
            pendulum.sensitivities(**wrong)
    with pytest.raises(ValueError, match="lenght"):
        pendulum.modes(to="lenght")


def test_speed_and_error_are_measured(pendulum):
    bench = pendulum.bench()
    assert json.dumps(bench).count("error") > 2


def test_notebooks_show_the_page_in_a_frame_of_its_own(slider_crank):
    html = slider_crank._repr_html_()
    assert html.startswith("<iframe") and "<script" not in html and 'sandbox="allow-scripts"' in html
    assert slider_crank.drawing().startswith("<svg")
    # What MathJax can show: formulas, not a document.
    formulas = slider_crank._repr_latex_()
    assert formulas.startswith(r"\begin{align*}q_{1} &= ") and r"\mathbf{M}" in formulas and "document" not in formulas
    assert formulas.count(r"\begin{align*}") == formulas.count(r"\end{align*}") > 3


def test_the_package_has_the_command(tmp_path):
    run = subprocess.run([sys.executable, "-m", "cotree._command", "--version"], capture_output=True, text=True, check=True)
    assert run.stdout.split() == ["cotree", cotree.__version__]
    wrong = subprocess.run([sys.executable, "-m", "cotree._command", "check", str(tmp_path / "none.toml")], check=False)
    assert wrong.returncode == 2


def test_pages_have_the_solver_that_the_package_brings_along(tmp_path, monkeypatch, slider_crank):
    from cotree import _command, _commands

    fmu = zipfile.ZipFile(slider_crank.export(tmp_path / "own.fmu", lean=True))
    [library] = [name for name in fmu.namelist() if name.startswith("binaries/")]
    module = tmp_path / "runtimes" / "web" / "cotree_runtime.wasm"
    module.parent.mkdir(parents=True)
    module.write_bytes(b"\0asm")
    with pytest.raises(OSError, match="version"):
        slider_crank.page(runtimes=tmp_path / "runtimes")
    # One that says of itself which programs it reads, as the library in FMUs does.
    module.write_bytes(b"\0asm" + fmu.read(library))
    assert 'id="solver"></script>' in slider_crank.page()
    assert 'id="solver"></script>' not in slider_crank.page(runtimes=tmp_path / "runtimes")
    monkeypatch.setattr(_commands, "__file__", str(tmp_path / "_commands.py"))
    assert 'id="solver"></script>' not in slider_crank.page()
    # The command looks there too, unless another folder is named.
    monkeypatch.setattr(_command, "__file__", str(tmp_path / "_command.py"))
    monkeypatch.setattr(_command.signal, "signal", lambda *_: None)
    seen = []
    monkeypatch.setattr(_command._cotree, "command", lambda _: seen.append(_command.os.environ["COTREE_RUNTIMES"]) or 0)
    for environment, expected in [({}, str(tmp_path / "runtimes")), ({"COTREE_RUNTIMES": "elsewhere"}, "elsewhere")]:
        monkeypatch.setattr(_command.os, "environ", environment)
        _command.main()
        assert seen[-1] == expected


def test_the_examples_in_the_documentation_run():
    import doctest

    import cotree._build

    for module in (cotree, cotree._build):
        result = doctest.testmod(module, extraglobs={"Builder": cotree.Builder})
        assert result.attempted and not result.failed


def test_what_was_formulated_serves_the_next_call(root):
    path = root / "models/slider_crank/scene.toml"
    model = cotree.load(path)

    def called(**given):
        begin = time.perf_counter()
        found = model.sensitivities("cylinder.s", "rod_length", [0.0, 1e-6], **given)
        return time.perf_counter() - begin, found

    first, found = called()
    again = min(called()[0] for _ in range(20))
    other = min(called(set={"rod_length": 1.5 + 0.001 * index, "crank_length": 0.45})[0] for index in range(20))
    # Equations are formulated and differentiated in the first call alone, whatever is set afterwards.
    assert max(again, other) < 0.5 * first, (first, again, other)
    assert called()[1] == found


def test_kept_equations_give_what_new_ones_give(root):
    path = root / "models/slider_crank/scene.toml"
    model, times = cotree.load(path), [0.3, 0.9]
    model.sensitivities("cylinder.s", "rod_length", times)
    for values in ({"rod_length": 1.7}, {"crank_length": 0.35, "rod_length": 1.3}):
        kept = model.sensitivities("cylinder.s", ["rod_length"], times, set=values)
        new = model.replace(values).sensitivities("cylinder.s", ["rod_length"], times)
        assert np.allclose(kept.derivatives, new.derivatives, rtol=1e-7, atol=1e-9)
        peaks = model.peaks("cylinder.s", "rod_length", set=values, stop=2)
        others = model.replace(values).peaks("cylinder.s", "rod_length", stop=2)
        assert [own.value for own in peaks] == pytest.approx([own.value for own in others], rel=1e-7)
    # Many threads ask one model at once.
    with ThreadPoolExecutor(4) as pool:
        lengths = np.linspace(1.3, 1.7, 12)
        found = list(pool.map(lambda own: model.sensitivities("cylinder.s", "rod_length", times, set={"rod_length": own}), lengths))
    for own, one in zip(lengths, found, strict=True):
        assert one == model.sensitivities("cylinder.s", "rod_length", times, set={"rod_length": own})


#: Analyses at a point, with numbers that are compared.
AT_A_POINT = {
    "equilibrium": lambda model, **given: np.array(list(model.equilibrium(**given).values.values())),
    "modes": lambda model, **given: np.array([mode.eigenvalue for mode in model.modes(**given)]),
    "shapes": lambda model, **given: np.array([list(mode.shape.values()) for mode in model.modes(**given)]),
    "modes on the way": lambda model, **given: np.array([mode.eigenvalue for mode in model.modes(0.2, **given)]),
    "linear systems": lambda model, **given: np.concatenate([point.A.ravel() for point in model.linearize([0, 0.2], **given)]),
}


@pytest.mark.parametrize("name, values", [("double_wishbone", {"tyre_stiffness": 1.4e5}), ("slider_crank", {"crank_length": 0.4, "rod_length": 1.3})])
def test_kept_equations_at_a_point_give_what_new_ones_give(root, name, values):
    model = cotree.load(root / "models" / name / "scene.toml")
    other = model.replace(values)
    for what, numbers in AT_A_POINT.items():
        own, found, expected = numbers(model), numbers(model, set=values), numbers(other)
        change = np.abs(expected - own).max()
        assert np.abs(found - expected).max() < 1e-4 * change, what
        assert np.array_equal(numbers(model), own), what


@pytest.mark.parametrize("what", AT_A_POINT)
def test_equations_at_a_point_are_made_in_the_first_call_alone(root, what):
    model, numbers = cotree.load(root / "models/slider_crank/scene.toml"), AT_A_POINT[what]
    model.check()
    took = []
    for index in range(20):
        begin = time.perf_counter()
        numbers(model, **({"set": {"rod_length": 1.4 + 0.01 * index}} if index else {}))
        took.append(time.perf_counter() - begin)
    assert min(took[1:]) < 0.5 * took[0], took


#: Three cranks: with these lengths a truss, with others a parallelogram, whose loop equations repeat each other.
CRANKS = """
name = "cranks"
gravity = [0.0, -9.81]
[parameters]
third = "0.5 m"
x = "0.34645 m"
y = "-7.1443 mm"
drag = "0.4 N.m.s"
[ground.points]
right = [1.0, 0.0]
middle = ["x", "y"]
[bodies]
a = { mass = 1.0, inertia = 0.02, points = { base = [-0.2, 0.0], tip = [0.2, 0.0] } }
b = { mass = 1.0, inertia = 0.02, points = { base = [-0.2, 0.0], tip = [0.2, 0.0] } }
c = { mass = 0.5, inertia = 0.01, points = { base = ["-third/2", 0.0], tip = ["third/2", 0.0] } }
coupler = { mass = 2.0, inertia = 0.1, points = { left = [-0.5, 0.0], middle = [0.0, 0.0], right = [0.5, 0.0] } }
[joints]
o = { type = "revolute", between = ["ground", "a.base"], damping = "drag" }
p = { type = "revolute", between = ["ground.right", "b.base"] }
q = { type = "revolute", between = ["ground.middle", "c.base"] }
l = { type = "revolute", between = ["a.tip", "coupler.left"] }
m = { type = "revolute", between = ["c.tip", "coupler.middle"] }
r = { type = "revolute", between = ["b.tip", "coupler.right"] }
[initial]
"a.angle" = { guess = "52.5 deg" }
"b.angle" = { guess = "52.5 deg" }
"c.angle" = { guess = "52.5 deg" }
"coupler.angle" = { guess = 0.0 }
[outputs]
variables = ["a.angle", "coupler.x"]
[experiment]
stop = 0.3
"""


def test_values_that_change_which_loops_count_are_no_trap():
    truss, moving = cotree.loads(CRANKS), {"third": 0.4, "x": 0.5, "y": 0.0}
    parallel = truss.replace(moving)
    times = [0.05, 0.1, 0.2]
    expected = parallel.simulate(times=times)["a.angle"]
    assert np.ptp(expected) > 0.1
    truss.sensitivities("a.angle", "drag", times)
    kept = truss.sensitivities("a.angle", "drag", times, set=moving)
    new = parallel.sensitivities("a.angle", "drag", times)
    assert np.allclose(kept.values, new.values, atol=1e-4) and np.allclose(kept.derivatives, new.derivatives, rtol=1e-3)
    # At a point, too: a truss has no motion, a parallelogram has one.
    assert len(truss.modes(0)) == 0 and len(truss.modes(0, set=moving)) == len(parallel.modes(0)) > 0
    assert truss.linearize(0.1, set=moving).A == pytest.approx(parallel.linearize(0.1).A, rel=1e-6)
    assert len(parallel.modes(0, set={"third": 0.5, "x": 0.34645, "y": -0.0071443})) == 0
    # The other way round nothing can be assembled as the parallelogram is, and what is found stands still.
    back = {"third": 0.5, "x": 0.34645, "y": -0.0071443}
    parallel.sensitivities("a.angle", "drag", times)
    still = parallel.sensitivities("a.angle", "drag", times, set=back)
    assert np.ptp(still.values) < 1e-6 and np.allclose(still.values, truss.simulate(times=times)["a.angle"][:, None], atol=1e-5)
