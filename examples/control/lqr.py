"""Hold a pole upright: the cart-pole is linearised there, scipy solves the Riccati equation, and the whole motion is simulated with the gains.

usage: lqr.py        needs scipy
"""

from pathlib import Path

import numpy as np
import scipy.linalg

import cotree

SCENE = Path(__file__).parents[2] / "models/cart_pole/scene.toml"
UPRIGHT = {"pole.angle": "90 deg"}


def gains(model: cotree.Model) -> tuple[dict[str, float], np.ndarray]:
    """The gain of each state by its name, and the poles of the loop that they close."""
    system = model.linearize(set=UPRIGHT)
    A, B, _, _ = system
    # A metre counts as much as a radian, and as a newton.
    riccati = scipy.linalg.solve_continuous_are(A, B, np.diag([1.0 if name in ("rail.s", "pole.angle") else 0.1 for name in system.states]), np.eye(1))
    gain = (B.T @ riccati)[0]
    return dict(zip(system.states, gain, strict=True)), np.linalg.eigvals(A - np.outer(B, gain))


def main() -> None:
    model = cotree.load(SCENE)
    gain, poles = gains(model)
    print("gains:", ", ".join(f"{name} {value:.3f}" for name, value in gain.items()))
    print("poles:", ", ".join(f"{pole:.3f}" for pole in sorted(poles, key=lambda pole: (pole.real, pole.imag))))
    target = {name: np.pi / 2 if name == "pole.angle" else 0.0 for name in gain}

    def push(time: float, run: cotree.Run) -> float:
        return -sum(value * (run[name] - target[name]) for name, value in gain.items())

    seen = model.simulate(inputs={"push": push}, outputs=list(gain), set={"pole.angle": "70 deg"}, stop="15 s", step="5 ms")
    left = {name: abs(values - target[name]) for name, values in seen.at(15.0).items()}
    print(f"from 20 deg off, after 15 s: {np.degrees(left['pole.angle']):.2g} deg and {1e3 * left['rail.s']:.2g} mm off")
    print(f"on the way the cart moves {1e3 * np.abs(seen['rail.s']).max():.0f} mm at most")


if __name__ == "__main__":
    main()
