"""What strikes and what rubs: cotree, MuJoCo and Exudyn on the same two mechanisms, in one run.

    pip install mujoco exudyn fmpy scipy
    python examples/against_simulators.py cotree

A four-bar falls from rest; its rocker strikes a stop four times. A block slides up a slope and stays there. Both have references of
their own: the four-bar in its one coordinate with its loop in closed form, by SciPy; the block's parabola. Printed are errors and the
processor time of the run alone, model built and started, the fastest of five. The other two programs make stops of springs and
dampers: theirs have the damping that loses the same share of the speed, and many stiffnesses and steps are tried.
"""

import cmath
import math
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import exudyn
import exudyn.itemInterface as exu
import fmpy
import mujoco
import numpy
from fmpy.fmi2 import FMU2Slave
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

G = 9.81
LENGTHS, BASE = (0.2, 0.5, 0.4), 0.5
MASSES, INERTIAS = (1.0, 0.8, 0.6), (0.01, 0.017, 0.008)
START, STOP, SHARE = math.radians(60), math.radians(115), 0.7
TIMES = [0.1 * k for k in range(1, 15)]

SLOPE, MU, SPEED = math.radians(20), 0.5, 3.0
LATER = [float(k) for k in range(1, 11)]


def four_bar():
    """As a scene. The angle of each bar is that of the line from its first end to its second."""
    bar = lambda name, k, ends: (
        f"[bodies.{name}]\nmass = {MASSES[k]}\ninertia = {INERTIAS[k]}\n"
        f"points = {{ {ends[0]} = [{-LENGTHS[k] / 2}, 0], {ends[1]} = [{LENGTHS[k] / 2}, 0] }}\n"
    )
    pin = lambda name, a, b, rest="": f'[joints.{name}]\ntype = "revolute"\nbetween = ["{a}", "{b}"]\n{rest}'
    _, _, angles = moving(START)
    return "\n".join(
        [
            f'format = 1\nname = "bouncing"\ngravity = [0, {-G}]\n[ground.points]\npivot = [{BASE}, 0]',
            bar("crank", 0, "ab"),
            bar("coupler", 1, "bc"),
            bar("rocker", 2, "dc"),
            pin("a", "ground", "crank.a"),
            pin("b", "crank.b", "coupler.b"),
            pin("c", "coupler.c", "rocker.c"),
            pin("d", "ground.pivot", "rocker.d", f"limits = {{ max = {STOP!r}, restitution = {SHARE} }}\n"),
            f'[initial]\n"crank.angle" = {START!r}\n"crank.omega" = 0\n"coupler.angle" = {{ guess = {angles[1]!r} }}',
            f'"rocker.angle" = {{ guess = {angles[2]!r} }}\n[outputs]\nvariables = ["crank.angle"]',
            f'[experiment]\nstop = "{TIMES[-1]!r} s"\nstep = "0.1 s"',
        ]
    )


def block():
    level = MU * G * math.cos(SLOPE)
    return (
        f'format = 1\nname = "block"\ngravity = [{-G * math.sin(SLOPE)!r}, {-G * math.cos(SLOPE)!r}]\n[bodies.block]\nmass = 1\n'
        f'[joints.slope]\ntype = "prismatic"\nbetween = ["ground", "block"]\naxis = [1, 0]\nfriction = {{ coulomb = {level!r} }}\n'
        f'[initial]\n"slope.s" = 0\n"slope.v" = {SPEED}\n[outputs]\nvariables = ["slope.s"]\n'
        f'[experiment]\nstop = "{LATER[-1]} s"\nstep = "1 s"'
    )


def moving(crank):
    """Directions of the bars; their rates and accelerations for each of the crank's; their angles."""
    pin = cmath.rect(LENGTHS[0], crank)
    to = BASE - pin
    coupler = cmath.phase(to) + math.acos((LENGTHS[1] ** 2 + abs(to) ** 2 - LENGTHS[2] ** 2) / (2 * LENGTHS[1] * abs(to)))
    angles = (crank, coupler, cmath.phase(pin + cmath.rect(LENGTHS[1], coupler) - BASE))
    bars = [cmath.rect(length, angle) for length, angle in zip(LENGTHS, angles)]
    closed = lambda right: numpy.linalg.solve(
        [[(1j * bars[1]).real, (-1j * bars[2]).real], [(1j * bars[1]).imag, (-1j * bars[2]).imag]], [right.real, right.imag]
    )
    rates = (1.0, *closed(-1j * bars[0]))
    seconds = (0.0, *closed(bars[0] + rates[1] ** 2 * bars[1] - rates[2] ** 2 * bars[2]))
    return bars, (rates, seconds), angles


def equation(crank):
    """Inertia, half its derivative and the torque of weight in the crank's angle."""
    bars, (rates, seconds), _ = moving(crank)
    way = [1j * bar * rate for bar, rate in zip(bars, rates)]
    bend = [bar * (1j * second - rate**2) for bar, rate, second in zip(bars, rates, seconds)]
    way, bend = ([own[0] / 2, own[0] + own[1] / 2, own[2] / 2] for own in (way, bend))
    inertia = sum(i * rate**2 + m * abs(w) ** 2 for i, rate, m, w in zip(INERTIAS, rates, MASSES, way))
    half = sum(
        i * rate * second + m * (w.conjugate() * b).real
        for i, rate, second, m, w, b in zip(INERTIAS, rates, seconds, MASSES, way, bend)
    )
    return inertia, half, G * sum(m * w.imag for m, w in zip(MASSES, way))


def reference():
    """The crank's angle at the times, and at the stop the inertia in the rocker's angle."""

    def rate(_, state):
        inertia, half, weight = equation(state[0])
        return [state[1], -(half * state[1] ** 2 + weight) / inertia]

    strikes = lambda _, state: moving(state[0])[2][2] - STOP
    strikes.terminal, strikes.direction = True, 1
    begin, state, angles = 0.0, [START, 0.0], []
    while True:
        to = [time for time in TIMES if time > begin]
        run = solve_ivp(rate, (begin, to[-1]), state, "DOP853", to, rtol=1e-13, atol=1e-14, max_step=0.01, events=strikes)
        angles += list(run.y[0])
        if run.status == 0:
            return numpy.array(angles), at_stop
        begin, state = run.t_events[0][0], run.y_events[0][0] * [1, -SHARE]
        at_stop = equation(state[0])[0] / moving(state[0])[1][0][2] ** 2


def fastest(start, run):
    """Processor time of the run alone, in milliseconds, the fastest of five or of what five seconds allow; the result of the last."""
    best, spent = math.inf, 0.0
    for _ in range(5):
        own = start()
        begin = time.process_time()
        answer = run(own)
        took = time.process_time() - begin
        best, spent = min(best, took), spent + took
        if spent > 5:
            break
    return 1e3 * best, answer


def of_cotree(program, scene, variable, tolerance, times):
    with tempfile.TemporaryDirectory() as folder:
        text, fmu = Path(folder) / "scene.toml", Path(folder) / "own.fmu"
        text.write_text(scene)
        subprocess.run([program, "export", text, "-o", fmu], check=True, capture_output=True)
        described, unpacked = fmpy.read_model_description(fmu), fmpy.extract(fmu, folder)
        reference = {v.name: v.valueReference for v in described.modelVariables}[variable]
        own = FMU2Slave(
            guid=described.guid, unzipDirectory=unpacked, instanceName="own", modelIdentifier=described.coSimulation.modelIdentifier
        )
        own.instantiate()

        def start():
            own.reset()
            own.setupExperiment(tolerance=tolerance, startTime=0.0)
            own.enterInitializationMode()
            own.exitInitializationMode()

        def run(_):
            now, values = 0.0, []
            for then in times:
                own.doStep(now, then - now)
                now = then
                values.append(own.getReal([reference])[0])
            return values

        try:
            return fastest(start, run)
        finally:
            own.terminate()
            own.freeInstance()


def of_mujoco(text, prepare, step, times):
    model = mujoco.MjModel.from_xml_string(text)

    def start():
        data = mujoco.MjData(model)
        prepare(data)
        return data

    def run(data):
        done, values = 0, []
        for then in times:
            mujoco.mj_step(model, data, nstep=round(then / step) - done)
            done = round(then / step)
            values.append(data.qpos[0])
        return values

    return fastest(start, run)


def mujoco_four_bar(step, stiffness, integrator):
    """Loop and stop by `solref`: the loop as stiff as its time constant of two steps permits."""
    angles = moving(START)[2]
    damping = 2 * spread(released=True) * math.sqrt(stiffness)
    body = lambda k, at, turn, rest="": (
        f'<body pos="{at!r} 0 0" euler="0 0 {turn!r}"><joint axis="0 0 1"{rest}/>'
        f'<inertial pos="{LENGTHS[k] / 2} 0 0" mass="{MASSES[k]}" diaginertia="{INERTIAS[k]} {INERTIAS[k]} {INERTIAS[k]}"/>'
    )
    limit = (
        f' limited="true" range="-9 {STOP - angles[2]!r}" solreflimit="{-stiffness!r} {-damping!r}" solimplimit="0.9999 0.9999 1e-9"'
    )
    return (
        f'<mujoco><compiler angle="radian"/><option timestep="{step!r}" gravity="0 {-G} 0" integrator="{integrator}" tolerance="1e-14"/>'
        f'<worldbody>{body(0, 0.0, angles[0])}{body(1, LENGTHS[0], angles[1] - angles[0])}<site name="c" pos="{LENGTHS[1]} 0 0"/>'
        f'</body></body>{body(2, BASE, angles[2], limit)}<site name="d" pos="{LENGTHS[2]} 0 0"/></body></worldbody>'
        f'<equality><connect site1="c" site2="d" solref="{2 * step!r} 1" solimp="0.9999 0.9999 1e-9"/></equality></mujoco>'
    )


def mujoco_block(step, noslip, hard):
    hard = f'solreffriction="{2 * step!r} 1" solimpfriction="0.9999 0.9999 1e-9"' if hard else ""
    return (
        f'<mujoco><option timestep="{step!r}" gravity="{-G * math.sin(SLOPE)!r} 0 {-G * math.cos(SLOPE)!r}" integrator="RK4" '
        f'noslip_iterations="{noslip}" tolerance="1e-14"/><worldbody><body><joint type="slide" axis="1 0 0" '
        f'frictionloss="{MU * G * math.cos(SLOPE)!r}" {hard}/><geom size="0.1" mass="1"/></body></worldbody></mujoco>'
    )


def spread(released):
    """The ratio of damping at which a spring and a damper lose the share: they let go at the place of first touch, or without force."""

    def share(ratio):
        free = math.sqrt(1 - ratio**2)
        angle = math.pi - math.atan2(2 * ratio * free, 1 - 2 * ratio**2) if released else math.pi
        return math.exp(-ratio / free * angle)

    return brentq(lambda ratio: share(ratio) - SHARE, 1e-6, 0.7)


def connector(system, marker, **keys):
    """Exudyn's spring with stops and friction, between the ground and a coordinate."""
    ground = system.AddMarker(exu.MarkerNodeCoordinate(nodeNumber=system.AddNode(exu.NodePointGround()), coordinate=0))
    memory = system.AddNode(exu.NodeGenericData(numberOfDataCoordinates=3, initialCoordinates=keys.pop("memory", [0, 0, 0])))
    system.AddObject(exu.ObjectConnectorCoordinateSpringDamperExt(markerNumbers=[ground, marker], nodeNumber=memory, **keys))


def exudyn_four_bar(stiffness, inertia):
    container = exudyn.SystemContainer()
    system = container.AddSystem()
    bars, _, angles = moving(START)
    centres = [bars[0] / 2, bars[0] + bars[1] / 2, BASE + bars[2] / 2]
    fixed = system.AddObject(exu.ObjectGround())
    nodes, bodies = [], []
    for k in range(3):
        place = [centres[k].real, centres[k].imag, angles[k]]
        nodes.append(system.AddNode(exu.NodeRigidBody2D(referenceCoordinates=place)))
        bodies.append(system.AddObject(exu.ObjectRigidBody2D(mass=MASSES[k], inertia=INERTIAS[k], nodeNumber=nodes[k])))
    at = lambda body, x: system.AddMarker(exu.MarkerBodyPosition(bodyNumber=body, localPosition=[x, 0, 0]))
    for k in range(3):
        system.AddLoad(exu.Force(markerNumber=at(bodies[k], 0), loadVector=[0, -G * MASSES[k], 0]))
    half = [length / 2 for length in LENGTHS]
    crank, coupler, rocker = bodies
    for one, other in [
        (at(fixed, 0), at(crank, -half[0])),
        (at(crank, half[0]), at(coupler, -half[1])),
        (at(coupler, half[1]), at(rocker, half[2])),
        (at(fixed, BASE), at(rocker, -half[2])),
    ]:
        system.AddObject(exu.ObjectJointRevolute2D(markerNumbers=[one, other]))
    connector(
        system,
        system.AddMarker(exu.MarkerNodeCoordinate(nodeNumber=nodes[2], coordinate=2)),
        useLimitStops=True,
        limitStopsUpper=STOP - angles[2],
        limitStopsLower=-9,
        limitStopsStiffness=stiffness * inertia,
        limitStopsDamping=2 * spread(released=False) * math.sqrt(stiffness) * inertia,
    )
    return finished(container, system, nodes[0])


def exudyn_block(stiffness):
    container = exudyn.SystemContainer()
    system = container.AddSystem()
    node = system.AddNode(exu.Node1D(referenceCoordinates=[0], initialVelocities=[SPEED]))
    system.AddObject(exu.ObjectMass1D(mass=1, nodeNumber=node))
    along = lambda: system.AddMarker(exu.MarkerNodeCoordinate(nodeNumber=node, coordinate=0))
    system.AddLoad(exu.LoadCoordinate(markerNumber=along(), load=-G * math.sin(SLOPE)))
    level = MU * G * math.cos(SLOPE)
    damping = 2 * math.sqrt(stiffness)
    connector(system, along(), dynamicFrictionForce=level, stickingStiffness=stiffness, stickingDamping=damping, memory=[1, 0, 0])
    return finished(container, system, node)


def finished(container, system, node):
    kept = exu.SensorNode(nodeNumber=node, writeToFile=False, storeInternal=True, outputVariableType=exudyn.OutputVariableType.Coordinates)
    sensor = system.AddSensor(kept)
    system.Assemble()
    return container, system, sensor


def of_exudyn(make, coordinate, step, times):
    settings = exudyn.SimulationSettings()
    own = settings.timeIntegration
    own.numberOfSteps, own.endTime, own.verboseMode = round(times[-1] / step), times[-1], 0
    settings.solution.file.write, settings.solution.sensors.writePeriod = False, times[0]

    def run(made):
        _, system, sensor = made
        if not system.SolveDynamic(settings, solverType=exudyn.DynamicSolverType.TrapezoidalIndex2):
            return [math.nan] * len(times)
        kept = system.GetSensorStoredData(sensor)
        return [kept[round(time / times[0]), 1 + coordinate] for time in times]

    return fastest(make, run)


def strikes(program):
    """Of each program what it takes to miss no more than so much at any of the times; and all that was tried."""
    angles, inertia = reference()
    tries = []

    def note(name, how, measured):
        took, values = measured
        tries.append((name, how, float(abs(numpy.array(values) - angles).max()), took))

    for tolerance in (1e-4, 1e-6, 1e-8, 1e-10, 1e-12):
        note("cotree", f"{tolerance:.0e}", of_cotree(program, four_bar(), "crank.angle", tolerance, TIMES))
    for step in (1e-3, 1e-4, 1e-5):
        for lasts in (5, 10, 20, 50, 100, 200):
            how, stiffness = f"step {step:.0e} s, an impact takes {lasts}", (math.pi / (lasts * step)) ** 2
            for integrator in ("implicitfast", "RK4"):
                took, turned = of_mujoco(mujoco_four_bar(step, stiffness, integrator), lambda _: None, step, TIMES)
                note("MuJoCo", f"{integrator}, {how}", (took, START + numpy.array(turned)))
            took, turned = of_exudyn(lambda: exudyn_four_bar(stiffness, inertia), 2, step, TIMES)
            note("Exudyn", how, (took, START + numpy.array(turned)))
    for name, how, error, took in tries:
        print(f"  {name:7} {how:50} misses {error:.1e} rad in {took:.3g} ms")
    for limit in (1e-1, 3e-2, 1e-2, 3e-3, 1e-3, 1e-6, 1e-9, 1e-12):
        best = {}
        for name, _, error, took in tries:
            if error <= limit:
                best[name] = min(took, best.get(name, math.inf))
        print(f"| {limit:.0e} | " + " | ".join(f"{best[name]:.3g}" if name in best else "-" for name in ("cotree", "MuJoCo", "Exudyn")) + " |")


def rests(program):
    """By how much the block's place is wrong when it has come to rest, and how far it creeps in the nine seconds after."""
    exact = SPEED**2 / (2 * G * (math.sin(SLOPE) + MU * math.cos(SLOPE)))

    def say(name, measured):
        took, values = measured
        print(f"| {name} | {abs(values[0] - exact):.0e} | {abs(values[-1] - values[0]):.0e} | {took:.3g} |")

    def throw(data):
        data.qvel[0] = SPEED

    say("cotree, tolerance 1e-4", of_cotree(program, block(), "slope.s", 1e-4, LATER))
    for step in (1e-2, 1e-3, 1e-4):
        say(f"MuJoCo, as it is, {step:g} s", of_mujoco(mujoco_block(step, 0, False), throw, step, LATER))
        say(f"MuJoCo, hard, {step:g} s", of_mujoco(mujoco_block(step, 0, True), throw, step, LATER))
        say(f"MuJoCo, hard, without slip, {step:g} s", of_mujoco(mujoco_block(step, 50, True), throw, step, LATER))
        for stiffness in (1e4, 1e6, 1e8):
            say(f"Exudyn, bristles of {stiffness:.0e} N/m, {step:g} s", of_exudyn(lambda: exudyn_block(stiffness), 0, step, LATER))


if __name__ == "__main__":
    strikes(sys.argv[1])
    rests(sys.argv[1])
