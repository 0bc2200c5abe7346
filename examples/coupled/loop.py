"""Couples two FMUs that form an algebraic loop, and compares them with the closed form.

usage: loop.py FOLDER        with cart.fmu and rider.fmu

The acceleration of the cart depends on the push of the same instant, the answer of the rider on the acceleration of the
same instant: answer = -m a, a = (push - k s)/M, push = answer. Going around the loop once multiplies an error of the push by -m/M.

* At once and Gauss-Seidel go around once in each step or two. Where m/M is above 1 errors grow, and the faster the shorter the steps are.
* Iterated goes around, from the saved beginning of the step, until the push at its end no longer changes: m/M must be below 1.
* Newton divides by the slope of the loop, from directional derivatives of both FMUs: it settles whatever m/M is.
"""

import sys
from pathlib import Path
from zipfile import BadZipFile

import numpy as np
from couple import FORCE_TOLERANCE, MOST_ITERATIONS, STOP, Fmu
from fmpy.fmi1 import FMICallException

STEPS = [200, 400, 2000]
CART, STIFFNESS, START = 2.0, 200.0, 0.1  # kg, N/m, m: those of cart.toml
RIDERS = [0.5, 4.0]  # kg
GROWS = 10.0  # m: a hundred times the amplitude


def slope(fmu, output, given):
    """How an output changes with an input of the same instant."""
    return fmu.slave.getDirectionalDerivative([fmu.references[output]], [fmu.references[given]], [1.0])[0]


def at_once(cart, rider, time, h, push):
    rider.set(accel=cart.get("rail.a")[0])
    cart.set(push=push)
    cart.step(time, h)
    rider.step(time, h)
    return rider.get("answer")[0], 1


def gauss_seidel(cart, rider, time, h, push):
    cart.set(push=push)
    cart.step(time, h)
    rider.set(accel=cart.get("rail.a")[0])
    rider.step(time, h)
    return rider.get("answer")[0], 1


def iterated(cart, rider, time, h, push, newton=False):
    begin, guess = cart.get("rail.a"), push
    with cart.saved() as restore_cart, rider.saved() as restore_rider:
        for iteration in range(1, MOST_ITERATIONS + 1):
            cart.set_line(np.array([push]), np.array([guess]), h, ["push"])
            cart.step(time, h)
            rider.set_line(begin, cart.get("rail.a"), h, ["accel"])
            rider.step(time, h)
            answer = rider.get("answer")[0]
            if abs(answer - guess) <= FORCE_TOLERANCE:
                return answer, iteration
            around = slope(rider, "answer", "accel") * slope(cart, "rail.a", "push") if newton else 0.0
            guess += (answer - guess) / (1.0 - around)
            restore_cart()
            restore_rider()
    raise RuntimeError("the push does not settle")


def newton(*step):
    return iterated(*step, newton=True)


def error(folder, mass, master, steps):
    """The largest error of the cart's position, and the mean number of repetitions of a step."""
    cart, rider = Fmu(folder, "cart"), Fmu(folder, "rider")
    rate = np.sqrt(STIFFNESS / (CART + mass))
    push = mass * rate**2 * START
    rider.set(mass=mass, accel=-(rate**2) * START)
    cart.set(push=push)
    for fmu in (cart, rider):
        fmu.slave.exitInitializationMode()
    h, worst, iterations = STOP / steps, 0.0, 0
    for k in range(steps):
        push, count = master(cart, rider, k * h, h, push)
        worst = max(worst, abs(cart.get("rail.s")[0] - START * np.cos(rate * (k + 1) * h)))
        if worst > GROWS:
            break
        iterations += count
    for fmu in (cart, rider):
        fmu.close()
    return worst, iterations / steps


def shown(worst, count):
    return f"{worst:.1e}" + f" ({count:.1f})" * (count > 1)


def main(folder):
    masters = {"at once": at_once, "Gauss-Seidel": gauss_seidel, "iterated": iterated, "Newton": newton}
    print(f"{'m/M':>5}{'step [ms]':>11}" + "".join(f"{name + ' [m]':>18}" for name in masters))
    for mass in RIDERS:
        for steps in STEPS:
            line = f"{mass / CART:5g}{1e3 * STOP / steps:11g}"
            for master in masters.values():
                try:
                    worst, count = error(Path(folder), mass, master, steps)
                    line += f"{'grows' if worst > GROWS else shown(worst, count):>18}"
                except RuntimeError:
                    line += f"{'does not settle':>18}"
            print(line, flush=True)


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    try:
        main(sys.argv[1])
    except (FMICallException, BadZipFile, OSError) as failure:
        sys.exit(f"error: {failure}")
