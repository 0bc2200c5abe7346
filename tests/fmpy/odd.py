"""Odd scenes as FMUs in fmpy, by Co-Simulation and by Model Exchange, against what can be worked out by hand.

usage: odd.py COTREE WORK
"""

import subprocess
import sys
from pathlib import Path

import numpy as np
import schema
from fmpy import extract, instantiate_fmu, read_model_description, simulate_fmu
from fmpy.fmi1 import FMICallException
from fmpy.validation import validate_fmu

HEAD = "format = 1\n"
CS, ME = "CoSimulation", "ModelExchange"
MODELS = Path(__file__).resolve().parents[2] / "models"

DRIVEN = HEAD + """
name = "driven"
[inputs]
speed = "1 rad/s"
[bodies.crank]
points = { pin = [-1, 0], tip = [1, 0] }
[joints.bearing]
type = "revolute"
between = ["ground", "crank.pin"]
[drivers.motor]
joint = "bearing"
angle = { input = "speed", as = "velocity" }
[initial]
"crank.angle" = 0.0
[outputs]
variables = ["crank.angle", "crank.omega", "crank.alpha", "crank.tip.x"]
"""

PENDULUM = HEAD + """
name = "pendulum"
gravity = [0, -9.81]
[parameters]
length = { value = "500 mm", min = "1 mm" }
mass = { value = 2.0, unit = "kg", tunable = true }
[bodies.rod]
mass = "mass"
inertia = "mass*length^2/12"
points = { pin = [0, "length/2"] }
[joints.pin]
type = "revolute"
between = ["ground", "rod.pin"]
[initial]
"rod.angle" = "0.01 rad"
[outputs]
variables = ["rod.angle", "energy.total"]
"""

STOP = HEAD + """
name = "stop"
gravity = [0, -9.81]
[ground.points]
floor = [0, 0]
[bodies.ball]
mass = 1.0
[joints.guide]
type = "prismatic"
between = ["ground", "ball"]
axis = [0, 1]
[loads.buffer]
type = "force"
on = "ball"
vector = [0, "max(0, -10000*guide.s)"]
[initial]
"guide.s" = 1.0
[outputs]
variables = ["guide.s", "energy.kinetic"]
[experiment]
tolerance = 1e-9
"""

LINE = HEAD + """
name = "line"
dimension = 1
[ground.points]
wall = [0, 0]
[bodies.m]
mass = 2.0
[loads.k]
type = "spring"
between = ["ground.wall", "m"]
stiffness = 8.0
[initial]
"m.x" = 0.5
[outputs]
variables = ["m.x", "k.force"]
"""

FLOATING = HEAD + """
name = "4 floating stones, Größe 1"
description = "<no> & \\"joints\\""
gravity = [0, -10]
[bodies.stone]
mass = 1.0
inertia = 0.1
points = { corner = [0.1, 0] }
[initial]
"stone.vx" = 2.0
"stone.vy" = 5.0
"stone.omega" = 3.0
[outputs]
variables = ["stone.x", "stone.y", "stone.angle", "stone.corner.ax"]
"""

FIXED = HEAD + """
name = "fixed"
gravity = [0, -10]
[inputs]
push = "1 N"
[bodies.post]
mass = 2.0
inertia = 0.1
points = { foot = [0, -1] }
[joints.foot]
type = "weld"
between = ["ground", "post.foot"]
angle = "30 deg"
[loads.wind]
type = "force"
on = "post"
vector = ["push", 0.0]
[outputs]
variables = ["foot.fx", "foot.fy", "post.angle"]
"""

CROSSING = HEAD + """
name = "crossing"
[bodies.crank]
mass = 1.0
inertia = "1/12"
points = { a = [-0.5, 0], b = [0.5, 0] }
[bodies.rod]
mass = 1.0
inertia = "1/12"
points = { a = [-0.5, 0], b = [0.5, 0] }
[bodies.slider]
mass = 0.7
[joints.bearing]
type = "revolute"
between = ["ground", "crank.a"]
[joints.pin]
type = "revolute"
between = ["crank.b", "rod.a"]
[joints.wrist]
type = "revolute"
between = ["rod.b", "slider"]
[joints.guide]
type = "prismatic"
between = ["ground", "slider"]
axis = [1, 0]
[initial]
"crank.angle" = 0.5
"crank.omega" = 3.0
"rod.angle" = { guess = -0.5 }
[outputs]
variables = ["crank.angle", "rod.angle"]
"""

EMPTY = FIXED.replace('[inputs]\npush = "1 N"\n', "").replace('"push"', "0.0").replace('"foot.fx", "foot.fy", "post.angle"', "")

SILENT = PENDULUM.replace('variables = ["rod.angle", "energy.total"]', "variables = []")


class Fmu:
    def __init__(self, cotree, work, name, scene, arguments=()):
        file = work / f"{name}.toml"
        file.write_text(scene, encoding="utf-8")
        self.path = work / f"{name}.fmu"
        subprocess.run([cotree, "export", file, "-o", self.path, *arguments], check=True, capture_output=True)
        problems = validate_fmu(str(self.path))
        assert not problems, problems
        self.folder = extract(self.path, work / name)
        self.description = read_model_description(self.folder)

    def run(self, kind, stop, interval, **more):
        more.setdefault("relative_tolerance", 1e-9)
        return simulate_fmu(
            self.folder, fmi_type=kind, model_description=self.description, stop_time=stop,
            output_interval=interval, record_events=False, **more,
        )

    def reference(self, name):
        return next(v.valueReference for v in self.description.modelVariables if v.name == name)


def close(found, expected, limit, what):
    worst = np.max(np.abs(np.asarray(found) - expected))
    assert worst <= limit, f"{what} is off by {worst:.1e}"


def check_driven(make):
    """A crank without mass whose speed is an input with derivatives: its angle is the integral."""
    fmu = make("driven", DRIVEN)
    assert fmu.description.modelExchange is None, "importers do not tell rates of inputs"
    slave = instantiate_fmu(fmu.folder, fmu.description, CS)
    slave.setupExperiment(startTime=0.0)
    slave.enterInitializationMode()
    slave.exitInitializationMode()
    speed, names = fmu.reference("speed"), ["crank.angle", "crank.omega", "crank.alpha"]
    references = [fmu.reference(name) for name in names]
    time, angle, value = 0.0, 0.0, 1.0
    for _ in range(20):
        slave.setReal([speed], [value])
        slave.setRealInputDerivatives([speed, speed], [1, 2], [0.5, 2.0])
        slave.doStep(time, 0.1)
        time += 0.1
        angle += 0.1 * value + 0.5 * 0.5 * 0.1**2 + 2.0 * 0.1**3 / 6
        value += 0.5 * 0.1 + 0.5 * 2.0 * 0.1**2
        close(slave.getReal(references), [angle, value, 0.7], 1e-12, names)
        close(slave.getRealOutputDerivatives([references[0]] * 4, [1, 2, 3, 4]), [value, 0.7, 2.0, 0.0], 1e-9, "rates")
    slave.terminate()
    slave.freeInstance()
    steps = np.array([(0, 1.0), (1, 1.0), (1, 3.0), (2, 3.0)], dtype=[("time", float), ("speed", float)])
    result = fmu.run(CS, 2.0, 0.1, input=steps)
    close(result["crank.angle"], np.where(result["time"] <= 1, result["time"], 3 * result["time"] - 2), 1e-9, "angle")


def check_parameters(make):
    """Small swings: omega^2 = 3 g / 2 l, whatever the mass."""
    fmu = make("pendulum", PENDULUM)
    for kind, limit in [(CS, 1e-6), (ME, 1e-5)]:
        for length in (0.5, 1.5):
            result = fmu.run(kind, 2.0, 0.02, start_values={"length": length, "mass": 0.3})
            expected = 0.01 * np.cos(np.sqrt(1.5 * 9.81 / length) * result["time"])
            close(result["rod.angle"], expected, limit, f"{kind}, length {length}")
    result = fmu.run(CS, 2.0, 0.02, start_values={"rod.angle": 0.005})
    close(result["rod.angle"][0], 0.005, 1e-15, "the initial value")
    units = {v.name: (v.unit, v.displayUnit) for v in fmu.description.modelVariables}
    assert units["length"] == ("m", "mm") and units["rod.angle"][0] == "rad", units


def check_stop(make):
    """A ball falls on a buffer and comes back to the height it fell from."""
    fmu = make("stop", STOP)
    fall, g, k = np.sqrt(2 / 9.81), 9.81, 10000.0
    for kind, limit in [(CS, 1e-6), (ME, 2e-4)]:
        result = fmu.run(kind, 3.0, 0.01)
        w, v = np.sqrt(k), g * fall
        contact = (2 * np.pi - 2 * np.arctan(v * w / g)) / w
        period = 2 * fall + contact
        since = result["time"] % period
        air = 1 - 0.5 * g * np.where(since > period / 2, period - since, since) ** 2
        inside = since - fall
        buffer = -g / k + g / k * np.cos(w * inside) - v / w * np.sin(w * inside)
        expected = np.where((inside > 0) & (inside < contact), buffer, air)
        close(result["guide.s"], expected, limit, kind)


def check_switches(make):
    """Inputs exactly where laws switch, each law on a cart of its own: strict comparisons are false, the others true, for as long as the input stays."""
    laws = {"if(1*on < X, 5, 1)": 1, "if(1*on <= X, 5, 1)": 5, "if(1*on > X, 5, 1)": 1, "if(1*on >= X, 5, 1)": 5, "if(X < 1*on, 5, 1)": 1,
            "if(X <= 1*on, 5, 1)": 5, "sign(on - (X))": 0, "2*floor(on - (X) + 2)": 4, "if(abs(on - (X)) > 0, 5, 1)": 1,
            "if(max(on, X) <= X, 5, 1)": 5, "if(min(on, X) < X, 5, 1)": 1, "if(smoothstep(on - (X)) > 0, 5, 1)": 1}
    for on in (0.0, 0.5):
        scene = HEAD + f'name = "switches"\n[inputs]\non = {{ start = {on} }}\n[bodies]\n'
        scene += "".join(f"c{i} = {{ mass = 1.0 }}\n" for i in range(len(laws)))
        for i, law in enumerate(laws):
            scene += f'[joints.r{i}]\ntype = "prismatic"\nbetween = ["ground", "c{i}"]\naxis = [1, 0]\n'
            scene += f'[loads.l{i}]\ntype = "force"\non = "c{i}"\nvector = ["{law.replace("X", str(on))}", 0]\n'
        outputs = [f"c{i}.{name}" for i in range(len(laws)) for name in ("vx", "ax")]
        scene += f"[outputs]\nvariables = {outputs}\n"
        fmu = make(f"switches_{int(2 * on)}", scene)
        for kind in (CS, ME):
            result = fmu.run(kind, 1.0, 0.25, output=outputs)
            for i, (law, push) in enumerate(laws.items()):
                close(result[f"c{i}.vx"], push * result["time"], 1e-6, f"{kind}, {law} at {on}")
                close(result[f"c{i}.ax"], push, 1e-12, f"{kind}, {law} at {on}")


def check_line(make):
    fmu = make("line", LINE)
    for kind, limit in [(CS, 1e-7), (ME, 1e-5)]:
        result = fmu.run(kind, 5.0, 0.05)
        close(result["m.x"], 0.5 * np.cos(2 * result["time"]), limit, kind)
        close(result["k.force"], 8 * result["m.x"], 1e-9, "force")


def check_floating(make):
    fmu = make("floating", FLOATING)
    for kind, limit in [(CS, 1e-9), (ME, 1e-6)]:
        result = fmu.run(kind, 2.0, 0.1)
        t = result["time"]
        close(result["stone.x"], 2 * t, limit, f"{kind} x")
        close(result["stone.y"], 5 * t - 5 * t**2, limit, f"{kind} y")
        close(result["stone.angle"], 3 * t, limit, f"{kind} angle")
        close(result["stone.corner.ax"], -0.9 * np.cos(3 * t), 10 * limit, f"{kind} corner")


def check_fixed(make):
    """No freedom at all: the weld carries weight and wind."""
    fmu = make("fixed", FIXED)
    for kind in (CS, ME):
        result = fmu.run(kind, 1.0, 0.1, start_values={"push": 3.0})
        close(result["foot.fx"], -3.0, 1e-9, "wind")
        close(result["foot.fy"], 20.0, 1e-9, "weight")
        close(result["post.angle"], np.pi / 6, 1e-12, "angle")


def check_impossible(make):
    """A crank too long for the rod: an error that names what does not fit, and the instance takes another value."""
    fmu = make("impossible", (MODELS / "slider_crank/scene.toml").read_text())
    messages = []
    logger = lambda environment, name, status, category, message: messages.append(message.decode())
    for kind in (CS, ME):
        slave = instantiate_fmu(fmu.folder, fmu.description, kind, logger=logger)
        crank = [fmu.reference("crank_length")]
        slave.setupExperiment(startTime=0.0)
        slave.setReal(crank, [5.0])
        slave.enterInitializationMode()
        try:
            slave.exitInitializationMode()
            raise AssertionError("a loop that cannot be closed was closed")
        except FMICallException:
            assert any("crank.angle" in message for message in messages), messages
        slave.setReal(crank, [0.5])
        slave.exitInitializationMode()
        angle = slave.getReal([fmu.reference("rod.angle")])
        close(angle, [-np.arcsin(0.5 * np.sin(0.6) / 1.5)], 1e-9, "the rod's angle")
        if kind == CS:
            slave.doStep(0.0, 0.1)
        slave.terminate()
        slave.freeInstance()


def check_crossing(make):
    """Crank and rod of the same length: Co-Simulation passes the upright crank, Model Exchange says why it cannot."""
    fmu = make("crossing", CROSSING)
    result = fmu.run(CS, 2.0, 0.01)
    close(result["rod.angle"], -result["crank.angle"], 1e-8, "the branch")
    assert result["crank.angle"][-1] > np.pi
    messages = []
    logger = lambda environment, name, status, category, message: messages.append(message.decode())
    for interval in (0.01, 0.1):
        messages.clear()
        try:
            fmu.run(ME, 2.0, interval, logger=logger)
            raise AssertionError("CVode went on along any of the branches")
        except FMICallException as fault:
            assert fault.function == "fmi2CompletedIntegratorStep", fault
            assert "use Co-Simulation" in messages[-1] and "`guide`" in messages[-1], messages


def check_silent(make):
    """A scene that asks for nothing has its states all the same."""
    fmu = make("silent", SILENT)
    for kind in (CS, ME):
        result = fmu.run(kind, 1.0, 0.1, output=["rod.angle"])
        close(result["rod.angle"][-1], 0.01 * np.cos(np.sqrt(1.5 * 9.81 / 0.5)), 1e-5, kind)


def check_empty(make):
    """Nothing that moves and nothing asked for: a description needs a variable all the same."""
    fmu = make("empty", EMPTY)
    assert [(v.name, v.causality, v.unit) for v in fmu.description.modelVariables] == [("time", "independent", "s")]
    assert schema.main([Path(fmu.folder) / "modelDescription.xml"]) == 0
    for kind in (CS, ME):
        result = fmu.run(kind, 1.0, 0.1, output=["time"])
        close(result["time"][-1], 1.0, 1e-12, kind)


def check_all(make):
    """With --all every variable of the pendulum and the ball can be read."""
    for name, scene in [("all_pendulum", PENDULUM), ("all_ball", STOP), ("all_driven", DRIVEN), ("all_line", LINE)]:
        fmu = make(name, scene, ["--all"])
        outputs = [v.name for v in fmu.description.modelVariables if v.causality == "output"]
        result = fmu.run(CS, 0.5, 0.1, output=outputs)
        assert all(np.all(np.isfinite(result[output])) for output in outputs)


def main(cotree, work):
    work = Path(work).resolve()
    failures = 0
    for name, check in list(globals().items()):
        if not name.startswith("check_"):
            continue
        try:
            check(lambda *arguments: Fmu(cotree, work, *arguments))
            outcome = "as expected"
        except Exception as fault:  # one scene's failure must not hide the others'
            failures += 1
            outcome = f"FAILED: {type(fault).__name__}: {fault} {getattr(fault, 'stderr', None) or ''}"
        print(f"{name[6:]:12} {outcome}", flush=True)
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
