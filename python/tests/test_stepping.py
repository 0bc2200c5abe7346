"""Runs that are taken step by step, and inputs that are functions."""

import copy
import pickle

import numpy as np
import pytest

import cotree


@pytest.fixture
def oscillator():
    """1 kg on a spring of 16 N/m, pushed: x'' = push - 16 x."""
    return cotree.loads(
        "name='oscillator'\ndimension=1\n[inputs]\npush={start=0.0,unit='N',min=-50}\n[parameters]\nk={value='16 N/m',tunable=true}\n[bodies.cart]\nmass=1.0\n"
        "[loads.pull]\ntype='force'\non='cart'\nvector=['push - k*cart.x']\n[initial]\n'cart.x'=0.5\n[outputs]\nvariables=['cart.x','cart.vx']\n"
        "[experiment]\nstop=2.0\nstep=0.1\ntolerance=1e-10\n"
    )


def held(x, v, push, dt):
    """The exact way on with a constant push: a rotation about the rest at push/16."""
    rest, rate = push / 16, 4.0
    c, s = np.cos(rate * dt), np.sin(rate * dt)
    return rest + (x - rest) * c + v / rate * s, -(x - rest) * rate * s + v * c


def test_a_controller_in_the_loop_has_the_motion_of_the_closed_form(oscillator):
    run = oscillator.start(set={"cart.x": "40 cm"})
    x, v = 0.4, 0.0
    for sample in range(50):
        assert run.time == pytest.approx(0.03 * sample)
        assert [run["cart.x"], run["cart.vx"]] == pytest.approx([x, v], abs=1e-9)
        push = -3.0 * run["cart.vx"] + 1.0
        x, v = held(x, v, push, 0.03)
        run.step("30 ms", push=push)
    assert run.outputs == {"cart.x": run["cart.x"], "cart.vx": run["cart.vx"]} and run.units["cart.vx"] == "m/s"


def test_copies_and_states_go_their_own_way(oscillator):
    run = oscillator.start()
    run.step(0.7, push=2.0)
    kept, one, packed = run.state, run.copy(), pickle.dumps(run)
    others = [one, copy.deepcopy(run), pickle.loads(packed)]
    run.step(0.4)
    for other in others:
        other.step(0.4)
        assert np.array_equal(other.to_numpy(), run.to_numpy())
    after = run.to_numpy()
    one.step(0.4, push=5.0)
    assert np.array_equal(run.to_numpy(), after)
    run.state = kept
    assert run.time == 0.7
    run.step(0.4)
    assert np.array_equal(run.to_numpy(), after)
    with pytest.raises(ValueError, match="state"):
        run.state = b"none"


def test_what_is_read_set_and_differentiated(oscillator):
    run = oscillator.start(outputs=["cart.ax", "cart.x"])
    assert run["cart.ax"] == pytest.approx(-8.0)
    run.set({"push": "2 N", "k": 4.0})
    assert run["push"] == 2.0 and run["cart.ax"] == pytest.approx(0.0)
    assert run.directional("cart.ax", {"push": 1.0}) == pytest.approx([1.0])
    assert run.directional("cart.ax", {"k": 1.0, "push": 3.0}) == pytest.approx([2.5])
    run.step_to(1.0)
    assert run.time == 1.0 and run["cart.x"] == pytest.approx(0.5)
    with pytest.raises(KeyError, match=r"cart\.x"):
        run["cart.xx"]
    for wrong, message in [({"pusch": 1}, "push"), ({"push": -51}, "push"), ({"push": "1 kg"}, "push: "), ({"cart.ax": 1}, "cart.ax")]:
        with pytest.raises(ValueError, match=message):
            run.set({"k": 9.0, **wrong})
        assert run["k"] == 4.0
    for duration in (-1, float("nan"), "1 kg"):
        with pytest.raises(ValueError, match="step"):
            run.step(duration)


def test_inputs_may_be_functions_of_time_and_of_the_run(oscillator):
    x, v = 0.5, 0.0
    expected = [x]
    for k in range(20):
        x, v = held(x, v, np.sin(0.1 * k), 0.1)
        expected.append(x)
    for law in (np.sin, lambda t: np.sin(t), lambda t, run: np.sin(run.time)):
        found = oscillator.simulate(inputs={"push": law})
        assert np.allclose(found["cart.x"], expected, atol=1e-9) and len(found.time) == 21
    for wrong in ({"time": [0, 1], "push": np.sin}, {"push": np.sin, "k": 3}):
        with pytest.raises(TypeError, match="function"):
            oscillator.simulate(inputs=wrong)


def test_a_run_that_cannot_go_on_stays_where_it_is():
    scene = "name='a'\ndimension=1\n[bodies.b]\nmass=1.0\n[loads.f]\ntype='force'\non='b'\nvector=['sqrt(1 - t)']\n[outputs]\nvariables=['b.x']\n"
    run = cotree.loads(scene).start()
    run.step(0.5)
    before = run["b.x"]
    with pytest.raises(cotree.RunError):
        run.step(1.0)
    assert 0.5 <= run.time <= 1.0 and run["b.x"] >= before
