"""Events in Model Exchange: fmpy's CVode at several tolerances against `cotree simulate --log`, and a master of its own whose searches end on either side of what they find.

usage: events.py COTREE MODELS WORK
"""

import csv
import ctypes
import subprocess
import sys
from pathlib import Path

import numpy as np
from fmpy import extract, read_model_description, simulate_fmu
from fmpy.fmi1 import FMICallException
from fmpy.fmi2 import FMU2Model
from fmpy.fmi3 import FMU3Model, FMU3Slave

HEAD = "format = 1\n"
DOUBLES = ctypes.POINTER(ctypes.c_double)
TOLERANCES = [1e-4, 1e-6, 1e-8, 1e-10]
# Models of the gallery in which something opens, rebounds, slips or is sampled, and no loop is closed at events.
HYBRID = ["chain_hoist", "end_stop", "stick_slip", "clutch_start", "worm_hoist", "friction_press", "play_train", "valve_train"]

# A cart whose drive turns round at two levels; the closed form is a sequence of exponentials.
RELAY = HEAD + """
name = "relay"
[bodies.cart]
mass = 2.0
[joints.rail]
type = "prismatic"
between = ["ground", "cart"]
axis = [1, 0]
damping = "0.8 N.s/m"
[sampled.relay]
period = "1e4 s"
offset = "5e3 s"
values = { push = 1, turns = 0 }
[events.high]
when = "HIGH"
set = { push = "-push", turns = "turns + 1" }
[events.low]
when = "LOW"
set = { push = "-push", turns = "turns + 1" }
[loads.drive]
type = "force"
on = "cart"
vector = ["push*3[N]", 0]
[initial]
"rail.s" = 0.0
"rail.v" = 0.0
[outputs]
variables = ["rail.s", "rail.v", "push", "turns"]
[experiment]
stop = "10 s"
step = "20 ms"
tolerance = 1e-9
"""
WRITTEN = {
    "sides": ("rail.s > 0.4", "rail.s < -0.4"),
    "difference": ("rail.s - 0.4[m] > 0", "rail.s + 0.4[m] < 0"),
}

# A weight on a swinging arm counts how often the arm turns round at the bottom of its swing.
SWINGS = HEAD + """
name = "swings"
gravity = [0, -9.81]
[bodies.arm]
mass = 2.0
inertia = 0.3
points = { eye = [-0.6, 0] }
[joints.pin]
type = "revolute"
between = ["ground", "arm.eye"]
[sampled.tally]
period = "1e4 s"
offset = "5e3 s"
values = { ups = 0 }
[events.up]
when = "arm.omega > 0"
set = { ups = "ups + 1" }
[initial]
"arm.angle" = 0.0
"arm.omega" = -0.2
[outputs]
variables = ["arm.angle", "arm.omega", "ups"]
[experiment]
stop = "10 s"
step = "20 ms"
tolerance = 1e-9
"""

BALL = HEAD + """
name = "ball"
gravity = [0, -9.81]
[bodies.ball]
mass = 0.4
[joints.fall]
type = "prismatic"
between = ["ground", "ball"]
axis = [0, 1]
limits = { min = "0 m", restitution = 0.6 }
[initial]
"fall.s" = 0.7
"fall.v" = 0.0
[outputs]
variables = ["fall.s", "fall.v", "fall.mode"]
[experiment]
stop = "3 s"
step = "10 ms"
tolerance = 1e-9
"""

# A weight lies on a table that swings: it lifts off, comes down again, and lies.
TABLE = HEAD + """
name = "table"
gravity = [0, -9.81]
[bodies]
table = { mass = 4.0 }
weight = { mass = 0.5 }
[joints.rail]
type = "prismatic"
between = ["ground", "table"]
axis = [0, 1]
[joints.rest]
type = "prismatic"
between = ["table", "weight"]
axis = [0, 1]
limits = { min = "0 m", restitution = 0.2 }
[loads.spring]
type = "spring"
between = ["ground", "table"]
stiffness = "2500 N/m"
length = "0.4 m"
[initial]
"rail.s" = 0.33
"rail.v" = 0.0
"rest.s" = 0.0
"rest.v" = 0.0
[outputs]
variables = ["rail.s", "rest.s", "rest.mode"]
[experiment]
stop = "1 s"
step = "10 ms"
tolerance = 1e-9
"""


class Fmu:
    """An exported scene."""

    def __init__(self, cotree, work, name, scene, version, runs):
        self.file, self.log = work / f"{name}-{version}.fmu", work / f"{name}.csv"
        if not isinstance(scene, Path):
            path = work / f"{name}.toml"
            path.write_text(scene, encoding="utf-8")
            scene = path
        self.name = name
        run = lambda *words: subprocess.run([cotree, *words], check=True, stdin=subprocess.DEVNULL, capture_output=True)
        run("export", scene, "--fmi", str(version), "-o", self.file)
        self.events = self.count(run, scene, work) if runs else None
        self.description = read_model_description(self.file)
        self.unzipped = extract(self.file, work / f"{name}-{version}")

    def count(self, run, scene, work):
        """What happens at one time is one event of an importer."""
        run("simulate", scene, "-o", work / f"{self.name}-table.csv", "--log", self.log)
        with open(self.log, newline="") as file:
            times = [float(row[0]) for row in list(csv.reader(file))[1:]]
        return len(np.unique(np.round(times, 9)))

    def outputs(self):
        return [own.name for own in self.description.modelVariables if own.causality == "output"]


class Counted:
    """Counts how often event mode is entered."""

    def __enter__(self):
        self.count, self.kept = 0, [(kind, kind.enterEventMode) for kind in (FMU2Model, FMU3Model)]
        for kind, enter in self.kept:
            kind.enterEventMode = lambda model, *more, enter=enter: (self.note(), enter(model, *more))[1]
        return self

    def note(self):
        self.count += 1

    def __exit__(self, *_):
        for kind, enter in self.kept:
            kind.enterEventMode = enter


def in_cvode(fmu, tolerance):
    """The last row, and how many events there were."""
    experiment = fmu.description.defaultExperiment
    with Counted() as counted:
        rows = simulate_fmu(
            str(fmu.unzipped),
            fmi_type="ModelExchange",
            model_description=fmu.description,
            relative_tolerance=tolerance,
            stop_time=float(experiment.stopTime),
            output_interval=float(experiment.stepSize),
            output=fmu.outputs(),
            record_events=False,
            timeout=120,
        )
    end = float(experiment.stopTime)
    assert abs(rows["time"][-1] - end) < 1e-9 * end, f"{fmu.name} at {tolerance:g} ends at {rows['time'][-1]} s"
    return rows[-1], counted.count


class Master:
    """Runge-Kutta steps of one length, and searches by halving whose ends are `enclosed` apart; events are handled at the end `after` or `before` the change."""

    def __init__(self, fmu, start=0.0):
        model = FMU3Model if fmu.description.fmiVersion.startswith("3") else FMU2Model
        self.is_new = model is FMU3Model
        own = fmu.description
        self.model = model(
            guid=own.guid,
            unzipDirectory=str(fmu.unzipped),
            modelIdentifier=own.modelExchange.modelIdentifier,
            instanceName="master",
        )
        self.model.instantiate()
        self.references = {variable.name: variable.valueReference for variable in own.modelVariables}
        self.states, self.indicators = own.numberOfContinuousStates, own.numberOfEventIndicators
        if self.is_new:
            self.model.enterInitializationMode(startTime=start)
        else:
            self.model.setupExperiment(startTime=start)
            self.model.enterInitializationMode()
        self.model.exitInitializationMode()
        self.time, self.events = start, 0
        self.update()

    def update(self):
        asks = self.model.updateDiscreteStates if self.is_new else self.model.newDiscreteStates
        while asks()[0]:
            pass
        self.model.enterContinuousTimeMode()

    def vector(self, get, count):
        values = np.zeros(count)
        get(values.ctypes.data_as(DOUBLES), count)
        return values

    def place(self, time, states):
        self.model.setTime(time)
        states = np.ascontiguousarray(states)
        pointer = states.ctypes.data_as(DOUBLES)
        self.model.setContinuousStates(pointer, self.states)

    def slope(self, time, states):
        self.place(time, states)
        get = self.model.getContinuousStateDerivatives if self.is_new else self.model.getDerivatives
        return self.vector(get, self.states)

    def signs(self, time, states):
        self.place(time, states)
        return self.vector(self.model.getEventIndicators, self.indicators) > 0

    def step(self, states, h):
        t = self.time
        a = self.slope(t, states)
        b = self.slope(t + h / 2, states + h / 2 * a)
        c = self.slope(t + h / 2, states + h / 2 * b)
        d = self.slope(t + h, states + h * c)
        return states + h / 6 * (a + 2 * b + 2 * c + d)

    def run(self, duration, h, enclosed, after):
        end = self.time + duration
        states = self.vector(self.model.getContinuousStates, self.states)
        while self.time < end - 1e-9 * h:
            length = min(h, end - self.time)
            signs = self.signs(self.time, states)
            changed = lambda share: np.any(self.signs(self.time + share, self.step(states, share)) != signs)
            found = changed(length)
            if found:
                low, high = 0.0, length
                while high - low > enclosed and low < 0.5 * (low + high) < high:
                    middle = 0.5 * (low + high)
                    low, high = (low, middle) if changed(middle) else (middle, high)
                length = high if after else low
            states = self.step(states, length)
            self.time += length
            self.place(self.time, states)
            if self.model.completedIntegratorStep()[0] or found:
                self.model.enterEventMode()
                self.update()
                self.events += 1
                assert self.events < 1000, f"events never end at t = {self.time}"
            states = self.vector(self.model.getContinuousStates, self.states)

    def read(self, name):
        get = self.model.getFloat64 if self.is_new else self.model.getReal
        return get([self.references[name]])[0]

    def free(self):
        self.model.terminate()
        self.model.freeInstance()


def relay_by_hand(duration):
    """m s'' + d s' = u between the levels, which are found by halving."""
    m, d, u, level = 2.0, 0.8, 3.0, 0.4
    s, v, t, turns, push = 0.0, 0.0, 0.0, 0, 1.0
    held = [False, False]

    def motion(time):
        rest = push * u / d
        decay = np.exp(-d / m * time)
        return s + rest * time + (v - rest) * m / d * (1 - decay), rest + (v - rest) * decay

    while True:
        first = None
        for share in np.arange(1e-3, duration - t + 1e-3, 1e-3):
            share = min(share, duration - t)
            now = [motion(share)[0] > level, motion(share)[0] < -level]
            begun = [index for index in range(2) if now[index] and not held[index]]
            if begun:
                first = (share, begun[0])
                break
            held = now
        if first is None:
            return motion(duration - t)[0], turns
        share, index = first
        low, high = share - 1e-3, share
        for _ in range(100):
            middle = 0.5 * (low + high)
            holds = motion(middle)[0] > level if index == 0 else motion(middle)[0] < -level
            low, high = (low, middle) if holds else (middle, high)
        s, v = motion(high)
        t, push, turns = t + high, -push, turns + 1
        held[index] = True


def check_masters(make):
    right, turns = relay_by_hand(10.0)
    for name, (high, low) in WRITTEN.items():
        scene = RELAY.replace("HIGH", high).replace("LOW", low)
        for version in (2, 3):
            fmu = make(f"relay_{name}", scene, version)
            for tolerance in (1e-6, 1e-9):
                row, _ = in_cvode(fmu, tolerance)
                assert row["turns"] == turns, f"{name} in CVode at {tolerance:g}: {row['turns']} turns, not {turns}"
                assert abs(row["rail.s"] - right) < 1e4 * tolerance, f"{name}: {row['rail.s']}, not {right}"
        for enclosed in (1e-8, 1e-10, 1e-12, 1e-13):
            for after in (True, False):
                for start in (0.0, 1000.0):
                    master = Master(fmu, start)
                    master.run(10.0, 0.01, enclosed, after)
                    found, counted = master.read("rail.s"), master.read("turns")
                    master.free()
                    what = f"{name}, searches to {enclosed:g}, {'after' if after else 'before'}, from {start:g} s"
                    assert counted == turns, f"{what}: {counted} turns, not {turns}"
                    assert abs(found - right) < 1e-6, f"{what}: {found}, not {right}"
    print(f"relay: {turns} turns, s = {right:.9f} m, in CVode and in 32 runs of masters")
    fmu = make("swings", SWINGS)
    # Twice a period the arm turns round, upwards in one of them.
    counts = set()
    for enclosed in (1e-8, 1e-11, 1e-13):
        for after in (True, False):
            master = Master(fmu)
            master.run(10.0, 0.01, enclosed, after)
            counts.add(master.read("ups"))
            master.free()
    expected = {float(np.loadtxt(fmu.log.with_name("swings-table.csv"), delimiter=",", skiprows=1)[-1, 3])}
    counts |= {in_cvode(fmu, tolerance)[0]["ups"] for tolerance in TOLERANCES}
    assert counts == expected, f"swings: {counts}, not {expected}"
    print(f"swings: {counts.pop():g} times upwards")


def check_counts(make, models):
    scenes = {"ball": BALL, "table": TABLE, **{name: models / name / "scene.toml" for name in HYBRID}}
    for name, scene in scenes.items():
        fmu = make(name, scene)
        counts = [in_cvode(fmu, tolerance)[1] for tolerance in TOLERANCES]
        print(f"{name}: {fmu.events} events, in CVode {counts}", flush=True)
        most = 3 * fmu.events + 3
        assert max(counts) <= most, f"{name}: {counts} events in CVode at {TOLERANCES}, {fmu.events} in the log"


# Turns of a wheel that drag slows down are counted; the eighth ends the run.
TURNS = HEAD + """
name = "turns"
[bodies.wheel]
mass = 2.0
inertia = 0.1
[joints.axle]
type = "revolute"
between = ["ground", "wheel"]
[loads.drag]
type = "torque"
on = "wheel"
value = "-1e-3*wheel.omega*abs(wheel.omega)"
[sampled.counter]
period = "1e4 s"
offset = "5e3 s"
values = { turns = 0 }
[events.turn]
when = "wheel.angle > 2*pi*(turns + 1)"
set = { turns = "turns + 1" }
[events.done]
when = "turns > 7.5"
stop = true
[initial]
"wheel.omega" = 30
[outputs]
variables = ["wheel.angle", "turns"]
[experiment]
stop = "10 s"
step = "0.1 s"
tolerance = 1e-10
"""


def check_ends(make):
    # J w' = -c w^2: the angle is J/c ln(1 + c w0 t/J).
    right = (np.exp(8 * 2 * np.pi * 1e-3 / 0.1) - 1) * 0.1 / (1e-3 * 30)
    for version in (2, 3):
        fmu = make("turns", TURNS, version)
        for early in (False, True)[: version - 1]:
            rows = simulate_fmu(str(fmu.unzipped), fmi_type="CoSimulation", early_return_allowed=early)
            assert right - 1e-6 < rows["time"][-1] < right + 0.1 + 1e-6, f"turns: {rows['time'][-1]} s, not {right}"
            assert rows["turns"][-1] == 8 and abs(rows["wheel.angle"][-1] - 16 * np.pi) < 1e-6, rows[-1]
    fmu = make("ball", BALL, 3)
    own = fmu.description
    for early in (False, True):
        slave = FMU3Slave(
            guid=own.guid,
            unzipDirectory=str(fmu.unzipped),
            modelIdentifier=own.coSimulation.modelIdentifier,
            instanceName="ball",
        )
        slave.instantiate(earlyReturnAllowed=early)
        slave.enterInitializationMode(startTime=0.0, stopTime=0.3)
        slave.exitInitializationMode()
        time = 0.0
        for _ in range(29):
            time = slave.doStep(time, 0.01)[3]
        # The sum of the steps is behind the stop time by a rounding error.
        *_, returned, time = slave.doStep(time, 0.3 + 1e-15 - time)
        assert not returned and abs(time - 0.3) < 1e-14, time
        try:
            slave.doStep(time, 0.01)
        except FMICallException:
            pass
        else:
            raise AssertionError("a step behind the stop time")
        slave.freeInstance()
    print(f"turns: ends at {right:.6f} s; the last step ends behind the stop time")


# Without a load nothing can be divided by it.
WITHOUT_START = BALL.replace("[initial]", """[parameters]
load = { value = 0.0 }
[sampled.balance]
period = "1 s"
values = { share = { start = "1/load" } }
[initial]""").replace('name = "ball"', 'name = "without_start"').replace('"fall.mode"]', '"fall.mode", "share"]')


def check_messages(cotree, make):
    for version in (2, 3):
        fmu = make("without_start", WITHOUT_START, version, runs=False)
        said = []
        try:
            simulate_fmu(str(fmu.unzipped), fmi_type="CoSimulation", logger=lambda *words: said.append(str(words)))
        except FMICallException:
            pass
        else:
            raise AssertionError("a start without a value")
        why = "`share` has no finite value"
        assert any(why in words for words in said), f"FMI {version}: {said}"
        told = subprocess.run([cotree, "info", fmu.file], check=True, capture_output=True, text=True).stdout
        assert any("fails" in line and why in line for line in told.splitlines()), told
    print("a start that fails is explained by cotree info and without debug logging")


def main(cotree, models, work):
    work = Path(work).resolve()
    make = lambda name, scene, version=2, runs=True: Fmu(cotree, work, name, scene, version, runs)
    check_ends(make)
    check_messages(cotree, make)
    check_masters(make)
    check_counts(make, Path(models))


if __name__ == "__main__":
    main(*sys.argv[1:])
