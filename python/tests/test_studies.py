"""Equations, equilibria, linear systems, vibrations, FMUs, pages."""

import json
import subprocess
import sys

import numpy as np
import pytest

import cotree


def test_equations_are_written_in_every_notation(slider_crank):
    for notation in ["text", "latex", "html", "c", "fortran", "rust", "python", "json"]:
        assert len(slider_crank.equations(notation)) > 500
    assert "documentclass" in slider_crank.equations("latex")
    assert len(slider_crank.steps("text")) > 1000
    with pytest.raises(ValueError, match="none of text"):
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
    with pytest.raises(ValueError, match="ascending"):
        model.linearize([0.2, 0.1])


def test_an_fmu_is_written_and_runs(tmp_path, slider_crank):
    fmpy = pytest.importorskip("fmpy")
    path = slider_crank.export(tmp_path / "slider_crank.fmu")
    ours = slider_crank.simulate(stop=1.0, step=0.01)
    theirs = fmpy.simulate_fmu(str(path), stop_time=1.0, output_interval=0.01)
    assert np.allclose(theirs["crank.angle"], ours["crank.angle"], atol=1e-9)
    assert slider_crank.export(tmp_path / "three.fmu", fmi=3).is_file()
    with pytest.raises(ValueError, match="neither"):
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
    with pytest.raises(cotree.RunError, match="lenght"):
        pendulum.sensitivities(to="lenght", times=[1])
    with pytest.raises(ValueError, match="ascending"):
        pendulum.sensitivities(to="length", times=[1, 0])


def test_speed_and_error_are_measured(pendulum):
    bench = pendulum.bench()
    assert json.dumps(bench).count("error") > 2


def test_notebooks_show_the_page_in_a_frame_of_its_own(slider_crank):
    html = slider_crank._repr_html_()
    assert html.startswith("<iframe") and "<script" not in html and 'sandbox="allow-scripts"' in html
    assert slider_crank.drawing().startswith("<svg")
    assert "documentclass" in slider_crank._repr_latex_()


def test_the_package_has_the_command(tmp_path):
    run = subprocess.run([sys.executable, "-m", "cotree._command", "--version"], capture_output=True, text=True, check=True)
    assert run.stdout.split() == ["cotree", cotree.__version__]
    wrong = subprocess.run([sys.executable, "-m", "cotree._command", "check", str(tmp_path / "none.toml")], check=False)
    assert wrong.returncode == 2


def test_the_examples_in_the_documentation_run():
    import doctest

    import cotree._build

    for module in (cotree, cotree._build):
        result = doctest.testmod(module, extraglobs={"Builder": cotree.Builder})
        assert result.attempted and not result.failed
