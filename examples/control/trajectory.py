"""Swing a pole up with a force over time that is found by its derivatives.

The force is a table of inputs, straight between its rows; `value_and_gradient` differentiates the end of the motion by the value in each row. scipy minimises; with JAX
(`trajectory.py jax`) the same gradient comes through `custom_vjp`, and `vmap` takes several forces at once.

usage: trajectory.py [jax]        needs scipy; jax where it is asked for
"""

import sys
from pathlib import Path

import numpy as np
import scipy.optimize

import cotree

SCENE = Path(__file__).parents[2] / "models/cart_pole/scene.toml"
#: The force has so many rows over so many seconds.
VALUES, STOP = 12, 2.0
NAMES = [f"push[{row}]" for row in range(VALUES)]
INPUTS = {"time": np.linspace(0, STOP, VALUES), "push": np.zeros(VALUES)}
#: At the end the pole is to stand, and everything to rest in the middle.
ENDS = {"rail.s": 0.0, "pole.angle": np.pi / 2, "rail.v": 0.0, "pole.omega": 0.0}


MODEL = cotree.load(SCENE)


def ends(force: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """What is left at the end, and its derivatives: (run, what) and (run, what, value), without the axis of the runs for a single force."""
    at = dict(zip(NAMES, np.moveaxis(force, -1, 0), strict=True))
    values, gradients = MODEL.value_and_gradient(list(ENDS), at, inputs=INPUTS, set={"pole.angle": "-90 deg"}, times=[STOP], tolerance=1e-8)
    return values - np.array(list(ENDS.values())), gradients


def with_scipy() -> np.ndarray:
    effort = 0.005

    def residuals(force: np.ndarray) -> np.ndarray:
        return np.concatenate([ends(force)[0], effort * force])

    def jacobian(force: np.ndarray) -> np.ndarray:
        return np.concatenate([ends(force)[1], effort * np.eye(VALUES)])

    start = 4 * np.sin(np.linspace(0, 4 * np.pi, VALUES))
    found = scipy.optimize.least_squares(residuals, start, jac=jacobian)
    left = ends(found.x)[0]
    print(f"scipy: {found.nfev} motions; at the end {np.degrees(abs(left[1])):.2g} deg and {1e3 * abs(left[0]):.2g} mm are left, the force is {np.abs(found.x).max():.3g} N at most")
    return found.x


def with_jax(force: np.ndarray) -> None:
    import jax

    jax.config.update("jax_enable_x64", True)

    def shapes(force: jax.Array) -> tuple[jax.ShapeDtypeStruct, jax.ShapeDtypeStruct]:
        runs = force.shape[:-1]
        return jax.ShapeDtypeStruct((*runs, len(ENDS)), float), jax.ShapeDtypeStruct((*runs, len(ENDS), VALUES), float)

    def both(force: jax.Array) -> tuple[jax.Array, jax.Array]:
        # A batch is one call: its runs are spread over all cores.
        return jax.pure_callback(lambda own: ends(np.asarray(own)), shapes(force), force, vmap_method="broadcast_all")

    end = jax.custom_vjp(lambda force: both(force)[0])
    end.defvjp(lambda force: both(force), lambda jacobian, change: (change @ jacobian,))
    gradient = jax.grad(lambda force: (end(force) ** 2).sum())
    several = np.stack([force, 0.9 * force, 1.1 * force])
    batch = np.asarray(jax.vmap(gradient)(several))
    alone = np.stack([np.asarray(gradient(own)) for own in several])
    print(f"jax: gradients of {len(several)} forces at once, as of each alone within {np.abs(batch - alone).max():.1g}")


if __name__ == "__main__":
    best = with_scipy()
    if "jax" in sys.argv[1:]:
        with_jax(best)
