"""Studies of motions that inputs drive."""

import re

import numpy as np
import pytest

import cotree


def cart(law, more=""):
    """A mass on a line, pushed by an input through a law."""
    return cotree.loads(
        "name='cart'\ndimension=1\n[parameters]\nm={value=2.0,unit='kg'}\nlevel={value=0.5,unit='N'}\n[inputs]\npush={start=0.0,unit='N'}\n[bodies.c]\nmass='m'\n"
        f"[loads.f]\ntype='force'\non='c'\nvector=['{law}']\n[initial]\n'c.x'=0.0\n[outputs]\nvariables=['c.x']\n[experiment]\nstop=2.0\nstep=0.1\ntolerance=1e-9\n{more}"
    )


#: Bends at 0.5 s, jumps at 1 s, begins late and ends early.
PUSH = {"time": [0.2, 0.5, 1.0, 1.0, 1.6], "push": [1.0, 3.0, 2.0, -1.0, 4.0]}


def test_derivatives_of_a_pushed_mass():
    model = cart("push")
    times = np.linspace(0, 2, 21)
    found = model.sensitivities("c.x", ["m"], times, inputs=PUSH)
    x = model.simulate(inputs=PUSH)["c.x"]
    assert np.allclose(found.values[:, 0], x, atol=1e-8)
    # x is the second integral of push/m.
    assert np.allclose(found["c.x", "m"], -x / 2.0, atol=1e-8)
    fine = np.linspace(0, 2, 200_001)
    force = np.where(fine < 1, np.interp(fine, [0.2, 0.5, 1.0], [1, 3, 2]), np.interp(fine, [1.0, 1.6], [-1, 4]))
    speed = np.concatenate([[0], np.cumsum((force[1:] + force[:-1]) / 2)]) * 1e-5 / 2
    assert x[-1] == pytest.approx(np.trapezoid(speed, fine), abs=1e-4)


def test_a_law_that_an_input_switches_moves_with_its_level():
    model = cart("if(push > level, 6, 0)")
    ramp = {"time": [0.0, 4.0], "push": [0.0, 4.0]}
    found = model.sensitivities("c.x", "level", [0.4, 1.0, 2.0], inputs=ramp)
    # It pushes with 6 N from t = level on: x = 1.5 (t - level)^2.
    assert found.values[:, 0] == pytest.approx([0, 1.5 * 0.25, 1.5 * 2.25], abs=1e-7)
    assert found["c.x", "level"] == pytest.approx([0, -3 * 0.5, -3 * 1.5], abs=1e-6)
    # One that jumps over the level switches it then, whatever the level is.
    jump = {"time": [0.0, 1.0, 1.0], "push": [0.0, 0.0, 1.0]}
    found = model.sensitivities("c.x", "level", [2.0], inputs=jump)
    assert (found.values.item(), found.derivatives.item()) == (pytest.approx(1.5, abs=1e-7), pytest.approx(0, abs=1e-7))


def test_a_driven_system_is_identified_from_values_with_gaps():
    model = cart("push - 3*c.x")
    seen = model.simulate(inputs=PUSH, set={"m": 1.7}, outputs=["c.x", "c.vx"], step=0.02)
    x, v = seen["c.x"].copy(), seen["c.vx"].copy()
    x[::2], v[np.arange(len(v)) % 3 != 0] = np.nan, np.nan
    found = model.fit({"time": seen.time, "c.x": x, "c.vx": v}, "m", inputs=PUSH)
    assert found["m"] == pytest.approx(1.7, abs=1e-6)
    assert np.isnan(found.residuals["c.x"][0]) and np.allclose(found.fitted["c.x"], seen["c.x"], atol=1e-6)
    still = model.fit({"time": seen.time, "c.x": seen["c.x"]}, "m", inputs=PUSH)
    kept = ~np.isnan(x)
    without = model.fit({"time": seen.time[kept], "c.x": seen["c.x"][kept]}, "m", inputs=PUSH)
    gaps = model.fit({"time": seen.time, "c.x": x}, "m", inputs=PUSH)
    # What was not measured counts as if its rows were not there.
    assert gaps["m"] == without["m"] and gaps.errors == without.errors and still["m"] == pytest.approx(gaps["m"], abs=1e-6)
    with pytest.raises(ValueError, match=r"c\.vx.*no value"):
        model.fit({"time": seen.time, "c.x": x, "c.vx": v * np.nan}, "m", inputs=PUSH)


def test_several_experiments_determine_what_none_does_alone():
    model = cotree.loads(
        "name='loaded'\ndimension=1\n[parameters]\nm='1.5 kg'\nk='200 N/m'\nmore='0 kg'\n[inputs]\npush={start=0.0,unit='N'}\n[bodies.c]\nmass='m + more'\n"
        "[loads.s]\ntype='spring'\nbetween=['ground','c']\nstiffness='k'\nlength=0.0\n[loads.f]\ntype='force'\non='c'\nvector=['push']\n"
        "[initial]\n'c.x'=0.1\n'c.vx'=0.0\n[outputs]\nvariables=['c.x']\n[experiment]\nstop=1.0\ntolerance=1e-10\n"
    )
    t = np.linspace(0.05, 0.95, 19)
    alone = {"time": t, "c.x": 0.1 * np.cos(np.sqrt(250 / 2) * t)}
    x = 0.04 * np.cos(np.sqrt(250 / 5) * t)
    x[3] = np.nan
    loaded = cotree.Experiment({"time": t, "c.x": x}, set={"more": "3 kg", "c.x": 0.04})
    for one in (alone, loaded):
        with pytest.raises(cotree.RunError, match="do not determine"):
            model.fit([one], ["k", "m"])
    found = model.fit([alone, loaded], {"k": None, "m": (0.1, 10)})
    assert found["k"] == pytest.approx(250, abs=1e-4) and found["m"] == pytest.approx(2, abs=1e-6)
    assert [len(own.time) for own in found.experiments] == [19, 19] and np.isnan(found.experiments[1].residuals["c.x"][3])
    assert found.model.simulate(times=t)["c.x"] == pytest.approx(alone["c.x"], abs=1e-6)
    with pytest.raises(ValueError, match="2 experiments"):
        found.residuals
    # A frame alone is one experiment, as before; so is a list of one.
    one = model.fit(alone, "m", set={"k": 250})
    assert one == model.fit([alone], "m", set={"k": 250}) and len(one.residuals["c.x"]) == 19
    # Inputs of its own: what is pushed from rest tells the mass, whatever the spring is called.
    still = model.simulate(set={"c.x": 0.0, "k": 250, "m": 2}, inputs={"time": [0, 1], "push": [3.0, 9.0]}, times=t)
    pushed = cotree.Experiment({"time": t, "c.x": still["c.x"]}, set={"c.x": 0.0}, inputs={"time": [0, 1], "push": [3.0, 9.0]})
    assert model.fit([alone, pushed], ["k", "m"])["m"] == pytest.approx(2, abs=1e-6)
    with pytest.raises(ValueError, match="experiment 2: `m` is varied"):
        model.fit([alone, cotree.Experiment(loaded.measured, set={"m": 3})], ["k", "m"])
    with pytest.raises(ValueError, match="nothing was measured"):
        model.fit([], "k")


def test_peaks_and_linear_systems_along_a_driven_motion():
    model = cart("push - 8*c.x*push")
    for time, push in ((0.1, 1.0), (0.35, 2.0), (1.0, -1.0), (2.0, 4.0)):
        system = model.linearize(time, inputs=PUSH)
        assert system.A[1, 0] == pytest.approx(-8 * push / 2) and system.time == time
    [first, second] = model.linearize([0.35, 1.3], inputs=PUSH)
    assert first.A[1, 0] == pytest.approx(-8) and second.A[1, 0] == pytest.approx(-8 * 1.5 / 2)
    assert model.modes(2.0, inputs=PUSH)[0].frequency == pytest.approx(4 / (2 * np.pi))
    pushed = cart("push")
    [largest, _] = pushed.peaks("c.x", "m", inputs={"time": [0, 2], "push": [3.0, -9.0]})
    # x = (3 t^2/2 - t^3)/m is largest after 1 s.
    assert (largest.value, largest.time) == (pytest.approx(0.25), pytest.approx(1.0))
    assert largest.d_value["m"] == pytest.approx(-0.125) and largest.d_time["m"] == pytest.approx(0, abs=1e-6)


def test_what_cannot_be_driven_is_refused():
    model = cart("push")
    for call in (
        lambda: model.linearize("equilibrium", inputs=PUSH),
        lambda: model.modes(inputs=PUSH),
        lambda: model.sensitivities("c.x", "m", "equilibrium", inputs=PUSH),
        lambda: model.linearize(1.0, inputs={"time": [0], "pull": [1]}),
    ):
        with pytest.raises(ValueError, match="input"):
            call()
    with pytest.raises(cotree.RunError, match="`push` is an input over time"):
        model.sensitivities("c.x", "push", 1.0, inputs=PUSH)


def test_measures_have_gradients():
    optimize = pytest.importorskip("scipy.optimize")
    model = cart("push - 8*c.x")
    asked = ["max(c.x)", "min(c.x)", "peak(c.x)", "range(c.x)", "mean(c.x)", "rms(c.x)", "first(c.vx)", "c.vx"]
    at = {"m": [1.5, 2.0], "c.x": 0.1}
    values, gradients = model.value_and_gradient(asked, at, inputs=PUSH)
    table = model.measure(asked, at, inputs=PUSH)
    assert gradients.shape == (2, 8, 2)
    assert np.allclose(values, np.asarray(table)[:, 2:], atol=1e-8)
    step = 1e-4
    for place, name in enumerate(at):
        above, below = ({**at, name: np.array(at[name]) + by} for by in (step, -step))
        difference = (np.asarray(model.measure(asked, above, inputs=PUSH, tolerance=1e-12)) - np.asarray(model.measure(asked, below, inputs=PUSH, tolerance=1e-12)))[:, 2:]
        assert np.allclose(gradients[:, :, place], difference / (2 * step), atol=1e-6)
    value, gradient = model.value_and_gradient("rms(c.x)", {"m": "1500 g"}, inputs=PUSH, set={"c.x": 0.1})
    assert value == pytest.approx(values[0, 5]) and gradient == pytest.approx(gradients[0, 5, :1])
    with pytest.raises(ValueError, match="when_max"):
        model.value_and_gradient("when_max(c.x)", {"m": 1.0})
    # The mass with which the cart ends at 0.2 m.
    target = lambda m: model.value_and_gradient("c.x", {"m": m[0]}, inputs=PUSH)  # noqa: E731
    cost = lambda m: ((target(m)[0] - 0.2) ** 2, 2 * (target(m)[0] - 0.2) * target(m)[1])  # noqa: E731
    found = optimize.minimize(cost, [2.0], jac=True, bounds=[(0.5, 8.0)], tol=1e-16)
    assert model.simulate(set={"m": found.x[0]}, inputs=PUSH)["c.x"][-1] == pytest.approx(0.2, abs=1e-5)


def test_a_driven_angle_has_the_derivatives_of_its_loop():
    model = cotree.loads(
        "name='a'\n[parameters]\nl='1 m'\n[inputs]\nturn={start=0.0,unit='rad'}\n[bodies.arm]\nmass=1.0\ninertia=0.1\npoints={root=['-l',0]}\n[joints.h]\ntype='revolute'\n"
        "between=['ground','arm.root']\n[drivers.d]\njoint='h'\nangle={input='turn',as='position'}\n[outputs]\nvariables=['arm.x','arm.vx','h.fx']\n[experiment]\nstop=1.0\nstep=0.1\n"
    )
    turn = {"time": [0, 0.5, 1], "turn": [0, 1.0, 0.2]}
    found = model.sensitivities(to="l", times=np.linspace(0, 1, 11), inputs=turn)
    run = model.simulate(inputs=turn)
    assert np.allclose(found.values, run.to_numpy(), atol=1e-12)
    # x = l cos(turn), and all else is as long; at the end rates are those of the way there.
    assert np.allclose(found["arm.x", "l"], np.cos(np.interp(run.time, turn["time"], turn["turn"])))
    assert np.allclose(found.derivatives[:, :, 0], run.to_numpy(), atol=1e-9) and run["arm.vx"][-1] == pytest.approx(1.6 * np.sin(0.2))


def test_the_rms_of_what_is_zero_has_the_gradient_zero():
    from cotree._gradient import reduced

    value, gradient = reduced("rms", np.linspace(0, 1, 5), np.zeros(5), np.ones((5, 2)))
    assert value == 0 and gradient.tolist() == [0, 0]


#: A cart that a force pushes against a wall, with a law in pieces; it counts where it is beyond a mark.
WALL = """
name = "wall"
[parameters]
m = { value = 2.0, unit = "kg" }
far = "10 m"
[inputs]
push = { start = "0 N" }
[bodies.c]
mass = "m"
inertia = 1
[joints.rail]
type = "prismatic"
between = ["ground", "c"]
axis = [1, 0]
limits = { max = "0.3 m", restitution = 0.5 }
[loads.pull]
type = "force"
on = "c"
vector = ["push + PIECES - 0.4[N.s/m]*rail.v - 0.2[N]*tanh(rail.v/1[m/s])", 0]
[initial]
"rail.s" = 0
"rail.v" = 0
[events.gone]
when = "rail.s < -far"
stop = true
[outputs]
variables = ["rail.s", "rail.v", "rail.a"]
[experiment]
stop = "2 s"
step = "10 ms"
tolerance = 1e-10
"""
SMOOTH, PIECES = WALL.replace("PIECES", "0[N]"), WALL.replace("PIECES", "0.3[N]*max(0, push/1[N] - 0.5)")


def differences(model, measures, at, table, step=1e-4, **run):
    """Central differences of measures with respect to values of a table, and their values."""

    def measured(values):
        changed = {name: np.array(column, dtype=float) for name, column in table.items()}
        for name, value in values.items():
            column, row = name.rstrip("]").split("[")
            changed[column][int(row)] = value
        return np.asarray(model.measure(measures, {"m": [2.0]}, inputs=changed, tolerance=1e-12, **run))[0, 1:]

    columns = [(measured({**at, name: at[name] + step}) - measured({**at, name: at[name] - step})) / (2 * step) for name in at]
    return measured(at), np.array(columns).T


@pytest.mark.parametrize("text", [SMOOTH, PIECES])
def test_rows_of_a_table_of_inputs_have_derivatives(text):
    model = cotree.loads(text)
    # Two rows at one time are a jump; the wall is struck on the way.
    table = {"time": [0.0, 0.3, 0.7, 0.7, 1.2, 1.6], "push": np.zeros(6)}
    at = {f"push[{row}]": value for row, value in enumerate([1.0, 2.5, 0.3, 1.4, -1.0, 0.8])}
    measures = ["last(rail.s)", "mean(rail.v)", "rms(rail.s)", "max(rail.s)", "last(rail.a)"]
    value, gradient = model.value_and_gradient(measures, at, inputs=table)
    expected, difference = differences(model, measures, at, table)
    assert np.allclose(value, expected, atol=1e-8) and np.allclose(gradient, difference, atol=2e-6)
    assert np.abs(gradient[0]).min() > 1e-4
    # As one of many runs, and over time; what a table has counts where nothing else is said.
    twice, gradients = model.value_and_gradient(measures, {name: [own, own + 0.01] for name, own in at.items()}, inputs=table)
    assert np.array_equal(twice[0], value) and np.array_equal(gradients[0], gradient) and not np.array_equal(gradients[1], gradient)
    full = {"time": table["time"], "push": list(at.values())}
    found = model.sensitivities("rail.s", list(at), times=[1.0, 2.0], inputs=full)
    assert np.array_equal(found.derivatives[-1, 0], gradient[0]) and found["rail.s", "push[5]"][0] == 0 and found.units["rail.s", "push[0]"] == "m/N"
    # Beside a parameter, whose derivative does not depend on that.
    _, both = model.value_and_gradient("rail.s", {"m": 2.0, "push[1]": 2.5}, inputs=full)
    _, alone = model.value_and_gradient("rail.s", {"m": 2.0}, inputs=full)
    assert both[1] == pytest.approx(gradient[0, 1], rel=1e-9) and both[0] == pytest.approx(alone[0], rel=1e-9)


def test_rows_of_inputs_are_found_from_a_motion():
    model = cotree.loads(SMOOTH)
    times, forces = np.linspace(0, 2, 5), np.array([1.0, 0.5, -1.0, 0.3, 0.2])
    seen = model.simulate(inputs={"time": times, "push": forces}, step=0.05)
    found = model.fit({"time": seen.time, "rail.s": seen["rail.s"]}, ["push[1]", "push[2]"], inputs={"time": times, "push": [1.0, 0.0, 0.0, 0.3, 0.2]})
    assert (found["push[1]"], found["push[2]"]) == pytest.approx((0.5, -1.0), abs=1e-6) and found.start["push[2]"] == 0
    [peak] = [own for own in model.peaks("rail.s", "push[1]", inputs={"time": times, "push": forces}) if own.kind == "max"]
    assert peak.d_value["push[1]"] > 0.1


def test_rows_that_are_not_there_are_refused():
    model = cotree.loads(SMOOTH)
    table = {"time": [0.0, 1.0], "push": [0.0, 1.0]}
    for name in ("push[2]", "push[-1]", "push[x]"):
        with pytest.raises(ValueError, match=re.escape(f"`{name}`: the table of inputs has the rows 0 to 1")):
            model.value_and_gradient("rail.s", {name: 1.0}, inputs=table)
    # Also where derivatives for a longer table are known.
    model.sensitivities("rail.s", "push[2]", times=[1.0], inputs={"time": [0, 1, 2], "push": [0, 1, 2]})
    with pytest.raises(ValueError, match="rows 0 to 1"):
        model.sensitivities("rail.s", "push[2]", times=[1.0], inputs=table)
    with pytest.raises(cotree.RunError, match=re.escape("with respect to its rows, such as `push[0]`")):
        model.sensitivities("rail.s", "push", times=[1.0], inputs=table)
    with pytest.raises(ValueError, match="no parameter"):
        model.value_and_gradient("rail.s", {"push[0]": 1.0})
    with pytest.raises(ValueError, match="no parameter"):
        model.sensitivities("rail.s", "mass[0]", times=[1.0], inputs=table)


def test_rows_that_drivers_follow_have_derivatives():
    model = cotree.loads(
        "name='a'\n[parameters]\nl='1 m'\n[inputs]\nturn={start=0.0,unit='rad'}\n[bodies.arm]\nmass=1.0\ninertia=0.1\npoints={root=['-l',0]}\n[joints.h]\ntype='revolute'\n"
        "between=['ground','arm.root']\n[drivers.d]\njoint='h'\nangle={input='turn',as='position'}\n[outputs]\nvariables=['arm.x','arm.vx']\n[experiment]\nstop=1.0\nstep=0.1\n"
    )
    turn = {"time": [0, 0.5, 1], "turn": [0, 1.0, 0.2]}
    found = model.sensitivities(to=["turn[1]", "turn[2]"], times=[0.25, 0.75], inputs=turn)
    # x = cos(turn), halfway between two rows.
    assert found["arm.x", "turn[1]"] == pytest.approx([-0.5 * np.sin(0.5), -0.5 * np.sin(0.6)]) and found["arm.x", "turn[2]"] == pytest.approx([0, -0.5 * np.sin(0.6)])
    rate, angle = np.array([2.0, -1.6]), np.array([0.5, 0.6])
    assert found["arm.vx", "turn[1]"] == pytest.approx(-0.5 * rate * np.cos(angle) - np.array([2.0, -2.0]) * np.sin(angle))


def test_a_run_that_an_event_ends_has_a_gradient():
    stone = cotree.loads(
        'name = "falls"\n[parameters]\nheight = "1 m"\ng = 9.81\n[bodies.stone]\nmass = 1\ninertia = 1\n[loads.weight]\ntype = "force"\non = "stone"\nvector = [0, "-g*1[N]"]\n'
        '[initial]\n"stone.y" = "height"\n"stone.x" = 0\n"stone.angle" = 0\n[events.ground]\nwhen = "stone.y < 0[m]"\nstop = true\n'
        '[outputs]\nvariables = ["stone.y", "stone.vy"]\n[experiment]\nstop = "1 s"\nstep = "10 ms"\ntolerance = 1e-10\n'
    )
    at = {"height": 1.0, "g": 9.81}
    measures = ["last(stone.y)", "last(stone.vy)", "last(time)", "mean(stone.vy)", "rms(stone.vy)", "min(stone.vy)", "max(stone.y)"]
    value, gradient = stone.value_and_gradient(measures, at)
    g, h = 9.81, 1.0
    fall, speed = np.sqrt(2 * h / g), np.sqrt(2 * g * h)
    exact = {
        "last(stone.y)": (0.0, [0.0, 0.0]),
        "last(stone.vy)": (-speed, [-np.sqrt(g / (2 * h)), -np.sqrt(h / (2 * g))]),
        "last(time)": (fall, [fall / (2 * h), -fall / (2 * g)]),
        "mean(stone.vy)": (-speed / 2, [-np.sqrt(g / (8 * h)), -np.sqrt(h / (8 * g))]),
        "rms(stone.vy)": (speed / np.sqrt(3), [np.sqrt(g / (6 * h)), np.sqrt(h / (6 * g))]),
        "max(stone.y)": (1.0, [1.0, 0.0]),
    }
    for name, (own, slopes) in exact.items():
        assert value[measures.index(name)] == pytest.approx(own, abs=1e-9) and gradient[measures.index(name)] == pytest.approx(slopes, abs=1e-9), name
    # Runs that end at times of their own, and one that does not end.
    values, gradients = stone.value_and_gradient("last(time)", {"height": [0.5, 1.0, 9.0]})
    assert values == pytest.approx([np.sqrt(1.0 / g), fall, 1.0]) and gradients[:, 0] == pytest.approx([np.sqrt(1.0 / g), fall / 2, 0.0], abs=1e-9)
    with pytest.raises(cotree.RunError, match="event `ground` has ended the run"):
        stone.sensitivities("stone.y", "height", times=[1.0])
    assert stone.sensitivities("stone.y", "height", times=[0.2])["stone.y", "height"] == pytest.approx([1.0])


def test_an_event_ends_a_run_between_rows_of_inputs():
    model = cotree.loads(PIECES.replace('far = "10 m"', 'far = "0.1 m"'))
    table = {"time": [0.0, 0.5, 1.0, 2.0], "push": np.zeros(4)}
    at = {f"push[{row}]": value for row, value in enumerate([1.0, -3.0, -2.0, 1.0])}
    measures = ["last(rail.v)", "mean(rail.s)", "rms(rail.v)", "last(rail.a)"]
    assert model.simulate(inputs={**table, "push": list(at.values())}).ended == "gone"
    value, gradient = model.value_and_gradient(measures, at, inputs=table)
    expected, difference = differences(model, measures, at, table)
    assert np.allclose(value, expected, atol=1e-8) and np.allclose(gradient, difference, atol=1e-5)
