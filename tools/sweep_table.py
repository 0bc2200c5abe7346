"""Runs a second of many slider-cranks over 10 s: `cotree sweep`, its FMU in fmpy over a pool of processes, MuJoCo's threads, SymPy's equations in C.

    python tools/sweep_table.py path/to/cotree [runs]         needs fmpy; mujoco, sympy and a C compiler if there are

Every run has a crank of another length, and gives the angle of the crank at the end. All are measured in one go, in turns; the peers make fewer runs,
and their speed is taken as that of many. Errors are those of the nominal run, against a tolerance of 1e-12.
"""

import ctypes
import multiprocessing
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

SCENE = Path(__file__).parents[1] / "models/slider_crank/scene.toml"
CRANKS = (0.4, 0.6)
ROD, START, STOP, STEP = 1.5, 0.6, 10.0, 1e-3
ROUNDS = 3
MASS, INERTIA, GRAVITY = (2.0, 3.0, 1.0), (0.0416667, 0.5625), 9.81


def lengths(count):
    return [CRANKS[0] + (CRANKS[1] - CRANKS[0]) * index / (count - 1) for index in range(count)]


def measured(work):
    begin = time.perf_counter()
    result = work()
    return result, time.perf_counter() - begin


def report(name, workers, runs, seconds, angle, exact):
    error = "-" if angle is None else f"{abs(angle - exact):.0e}"
    print(f"| {name} | {workers} | {runs} | {runs / seconds:.0f} | {error} |", flush=True)


def cotree(program, runs, threads, folder):
    """Sweeps in a process of its own: the largest memory of all such processes so far [MB]."""
    out = folder / "sweep.csv"
    out.unlink(missing_ok=True)
    varied = f"crank_length={CRANKS[0]}..{CRANKS[1]}:{runs}"
    options = ["--step", "0.1", "--threads", str(threads), "--output", "crank.angle", "-o", out]
    command = [*program, "sweep", SCENE, "--set", varied, *options]
    _, seconds = measured(lambda: subprocess.run(list(map(str, command)), check=True, capture_output=True))
    assert sum(1 for _ in out.open()) == runs + 1
    return seconds, resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1024


def last(program, *options):
    command = [*program, "simulate", SCENE, "--variables", "crank.angle", "--step", "1", *options]
    rows = subprocess.run(list(map(str, command)), check=True, capture_output=True, text=True).stdout
    return float(rows.splitlines()[-1].split(",")[-1])


def begin_fmu(path, folder):
    global FMU
    import fmpy
    from fmpy.fmi2 import FMU2Slave

    description = fmpy.read_model_description(path)
    names = {variable.name: variable.valueReference for variable in description.modelVariables}
    slave = FMU2Slave(
        guid=description.guid,
        unzipDirectory=folder,
        modelIdentifier=description.coSimulation.modelIdentifier,
        instanceName="run",
    )
    slave.instantiate()
    FMU = slave, names


def run_fmu(length):
    """One instance for all runs of a process, and the fewest calls: what fmpy can do at best."""
    slave, names = FMU
    slave.reset()
    slave.setupExperiment(startTime=0.0, stopTime=STOP)
    slave.setReal([names["crank_length"]], [length])
    slave.enterInitializationMode()
    slave.exitInitializationMode()
    for index in range(100):
        slave.doStep(currentCommunicationPoint=index * 0.1, communicationStepSize=0.1)
    return slave.getReal([names["crank.angle"]])[0]


def fmpy_pool(program, folder, runs, workers):
    import fmpy

    path = folder / "slider_crank.fmu"
    if not path.exists():
        subprocess.run([*map(str, program), "export", str(SCENE), "-o", str(path)], check=True, capture_output=True)
    unpacked = fmpy.extract(str(path))
    with multiprocessing.get_context("spawn").Pool(workers, begin_fmu, (str(path), unpacked)) as pool:
        pool.map(run_fmu, lengths(4 * workers), chunksize=1)
        angles, seconds = measured(lambda: pool.map(run_fmu, [*lengths(runs - 1), 0.5], chunksize=8))
    return angles[-1], seconds


def mujoco_threads(runs, workers):
    import mujoco
    import numpy as np
    from mujoco import rollout

    def model(length):
        def inertial(place, mass, inertia):
            return f'<inertial pos="{place} 0 0" mass="{mass}" diaginertia="{inertia} {inertia} {inertia}"/>'

        return mujoco.MjModel.from_xml_string(
            f'<mujoco><option timestep="{STEP}" gravity="0 {-GRAVITY} 0" integrator="RK4" tolerance="1e-12"><flag contact="disable"/></option>'
            f'<worldbody><body><joint type="hinge" axis="0 0 1"/>{inertial(length / 2, MASS[0], INERTIA[0])}'
            f'<body name="rod" pos="{length} 0 0"><joint type="hinge" axis="0 0 1"/>{inertial(ROD / 2, MASS[1], INERTIA[1])}</body></body>'
            f'<body name="slider" pos="{length + ROD} 0 0"><joint type="slide" axis="1 0 0"/>{inertial(0, MASS[2], 1)}</body></worldbody>'
            f'<equality><connect body1="rod" body2="slider" anchor="{ROD} 0 0" solref="{2 * STEP} 1" solimp="0.9999 0.9999 0.001"/></equality></mujoco>'
        )

    def start(length):
        rod = -np.arcsin(length * np.sin(START) / ROD)
        return [0.0, START, rod - START, length * (np.cos(START) - 1) + ROD * (np.cos(rod) - 1), 0, 0, 0]

    cranks = [*lengths(runs - 1), 0.5]
    models = [model(length) for length in cranks]
    data = [mujoco.MjData(models[0]) for _ in range(workers)]
    size = mujoco.mj_stateSize(models[0], mujoco.mjtState.mjSTATE_FULLPHYSICS)
    states = np.zeros((runs, size))
    states[:, :7] = [start(length) for length in cranks]
    (found, _), seconds = measured(lambda: rollout.rollout(models, data, states, nstep=round(STOP / STEP)))
    return found[-1, -1, 1], seconds


SOLVER = """
void rhs(const double *y, double l, double *d);
double run(double length, double start, double rod, double step, int steps) {
  double y[4] = {start, rod, 0, 0}, k[4][4], z[4];
  for (int n = 0; n < steps; n++) {
    const double part[4] = {0, 0.5, 0.5, 1};
    for (int s = 0; s < 4; s++) {
      for (int i = 0; i < 4; i++) z[i] = y[i] + (s ? part[s] * step * k[s - 1][i] : 0);
      rhs(z, length, k[s]);
    }
    for (int i = 0; i < 4; i++) y[i] += step * (k[0][i] + 2 * k[1][i] + 2 * k[2][i] + k[3][i]) / 6;
  }
  return y[0];
}
"""


def sympy_in_c(folder):
    """Lagrange's equations with the loop as in the scene, solved by SymPy, printed as C, with the classical Runge-Kutta method."""
    import sympy

    a, b, u, v, length = sympy.symbols("a b u v l")
    crank = length * sympy.cos(a) / 2, length * sympy.sin(a) / 2
    rod = length * sympy.cos(a) + ROD * sympy.cos(b) / 2, length * sympy.sin(a) + ROD * sympy.sin(b) / 2
    slider = (length * sympy.cos(a) + ROD * sympy.cos(b), 0)
    q, w = sympy.Matrix([a, b]), sympy.Matrix([u, v])
    kinetic = (INERTIA[0] * u**2 + INERTIA[1] * v**2) / 2
    for mass, place in zip(MASS, (crank, rod, slider), strict=True):
        speed = sympy.Matrix(place).jacobian(q) * w
        kinetic += mass * speed.dot(speed) / 2
    potential = GRAVITY * (MASS[0] * crank[1] + MASS[1] * rod[1])
    momentum = sympy.Matrix([kinetic]).jacobian(w)
    mass = momentum.jacobian(w)
    load = sympy.Matrix([kinetic - potential]).jacobian(q).T - momentum.jacobian(q) * w
    loop = sympy.Matrix([length * sympy.sin(a) + ROD * sympy.sin(b)])
    rows = loop.jacobian(q)
    system = sympy.Matrix(sympy.BlockMatrix([[mass, rows.T], [rows, sympy.zeros(1, 1)]]))
    right = sympy.Matrix([*load, -((rows * w).jacobian(q) * w)[0]])
    shared, solved = sympy.cse(list(system.LUsolve(right)[:2]))
    lines = [f"double {name} = {sympy.ccode(value)};" for name, value in shared]
    lines += [f"d[{2 + index}] = {sympy.ccode(value)};" for index, value in enumerate(solved)]
    head = "double a = y[0], b = y[1], u = y[2], v = y[3]; d[0] = u; d[1] = v;"
    body = "\n".join(lines)
    (folder / "rhs.c").write_text(f"#include <math.h>\nvoid rhs(const double *y, double l, double *d) {{\n{head}\n{body}\n}}\n{SOLVER}")
    library = folder / "rhs.so"
    subprocess.run(["cc", "-O3", "-march=native", "-shared", "-fPIC", folder / "rhs.c", "-o", library, "-lm"], check=True)
    return str(library)


def begin_c(library):
    global RUN
    RUN = ctypes.CDLL(library).run
    RUN.restype = ctypes.c_double
    RUN.argtypes = [ctypes.c_double] * 4 + [ctypes.c_int]


def run_c(length):
    import math

    return RUN(length, START, -math.asin(length * math.sin(START) / ROD), STEP, round(STOP / STEP))


def c_pool(library, runs, workers):
    with multiprocessing.get_context("spawn").Pool(workers, begin_c, (library,)) as pool:
        pool.map(run_c, lengths(2 * workers), chunksize=1)
        angles, seconds = measured(lambda: pool.map(run_c, [*lengths(runs - 1), 0.5], chunksize=16))
    return angles[-1], seconds


def main(program, runs=100_000):
    program = program.split(",")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        exact = last(program, "--tolerance", "1e-12")
        # First: memory is the largest of all processes so far.
        all_seconds, memory = cotree(program, runs, 0, folder)
        library = []

        def in_c(count, workers):
            if not library:
                library.append(sympy_in_c(folder))
            return c_pool(library[0], count, workers)

        def swept(count, workers):
            return last(program), cotree(program, count, workers, folder)[0]

        peers = {
            "cotree sweep": (4000, swept),
            "its FMU, fmpy": (4000, lambda count, workers: fmpy_pool(program, folder, count, workers)),
            "MuJoCo, RK4 of 1 ms": (30, mujoco_threads),
            "SymPy in C, RK4 of 1 ms": (1000, in_c),
        }
        # Other work on the machine slows all of them: they take turns, and the fastest of each counts.
        best = {}
        for _ in range(ROUNDS):
            for name, (count, work) in peers.items():
                for workers in (1, 2):
                    try:
                        angle, seconds = work(count, workers)
                    except ImportError as missing:
                        print(f"{name}: {missing}")
                        break
                    best[name, workers] = min(best.get((name, workers), (seconds, angle)), (seconds, angle))
        print("| | workers | runs made | runs a second | error [rad] |\n|---|---:|---:|---:|---:|")
        for (name, workers), (seconds, angle) in best.items():
            report(name, workers, peers[name][0], seconds, angle, exact)
        report("cotree sweep", "all", runs, all_seconds, last(program), exact)
        print(f"\nlargest memory of the sweep: {memory:.0f} MB")


if __name__ == "__main__":
    main(sys.argv[1], *map(int, sys.argv[2:]))
