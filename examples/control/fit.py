"""Find the masses and the friction of a cart-pole from measurements with noise, with standard errors; how often the truth lies within the 95 % limits.

usage: fit.py [TRIALS]
"""

import sys
from pathlib import Path

import numpy as np

import cotree

SCENE = Path(__file__).parents[2] / "models/cart_pole/scene.toml"
TRUE = {"cart_mass": 1.3, "pole_mass": 0.25}


def main(trials: int) -> None:
    model = cotree.load(SCENE)
    t = np.linspace(0, 3, 301)
    push = {"time": t, "push": 2 * np.sin(4 * t)}
    motion = model.simulate(inputs=push, set=TRUE, stop=3, step="20 ms", outputs=["rail.s", "pole.angle"])
    noise, within = np.random.default_rng(7), 0
    for trial in range(trials):
        measured = {"time": motion.time, "rail.s": motion["rail.s"] + noise.normal(0, 2e-3, motion.time.size), "pole.angle": motion["pole.angle"] + noise.normal(0, 5e-3, motion.time.size)}
        found = model.fit(measured, list(TRUE), inputs=push, stop=3)
        within += sum(found.limits[name][0] <= true <= found.limits[name][1] for name, true in TRUE.items())
        if trial == 0:
            print(found)
    print(f"the truth is within the limits in {within} of {2 * trials} cases")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 20)
