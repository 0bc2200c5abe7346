"""A Gymnasium environment of the cart-pole in 40 lines, and its rate of steps beside Gymnasium's own InvertedPendulum, which MuJoCo moves; then that of the two solvers alone.

usage: environment.py [STEPS]        needs gymnasium; the comparison needs mujoco and imageio too
"""

import sys
import time
from collections.abc import Callable
from pathlib import Path

import gymnasium
import numpy as np

import cotree

SCENE = Path(__file__).parents[2] / "models/cart_pole/scene.toml"


class CartPole(gymnasium.Env):
    """Keep a pole upright on a cart that is pushed with up to 3 N: 40 ms a step, as InvertedPendulum has; an episode ends 0.2 rad from upright or 1 m from the middle."""

    action_space = gymnasium.spaces.Box(-1.0, 1.0, (1,), np.float32)
    observation_space = gymnasium.spaces.Box(-np.inf, np.inf, (4,), np.float64)

    def __init__(self) -> None:
        model = cotree.load(SCENE)
        self.run = model.start(outputs=["rail.s", "pole.angle", "rail.v", "pole.omega"], tolerance=1e-6)

    def observe(self) -> np.ndarray:
        return self.run.to_numpy() - (0.0, np.pi / 2, 0.0, 0.0)

    def reset(self, *, seed: int | None = None, options: dict | None = None) -> tuple[np.ndarray, dict]:
        super().reset(seed=seed)
        s, angle, v, omega = self.np_random.uniform(-0.01, 0.01, 4)
        self.run.reset({"rail.s": s, "pole.angle": np.pi / 2 + angle, "rail.v": v, "pole.omega": omega})
        return self.observe(), {}

    def step(self, action: np.ndarray) -> tuple[np.ndarray, float, bool, bool, dict]:
        self.run.step(0.04, push=3.0 * float(action[0]))
        seen = self.observe()
        return seen, 1.0, bool(abs(seen[1]) > 0.2 or abs(seen[0]) > 1.0), False, {}


def rate(environment: gymnasium.Env, steps: int) -> tuple[float, float]:
    """Steps per second with pushes drawn at random, and the mean length of an episode."""
    pushes = np.random.default_rng(1).uniform(-1.0, 1.0, (steps, 1))
    environment.reset(seed=1)
    episodes, begun = 1, time.perf_counter()
    for push in pushes:
        _, _, fell, _, _ = environment.step(push)
        if fell:
            environment.reset()
            episodes += 1
    return steps / (time.perf_counter() - begun), steps / episodes


def solver_rate(step: Callable[[float], object], reset: Callable[[], object], steps: int) -> float:
    """Steps per second of a solver alone, with pushes drawn at random and a reset after 50 steps."""
    pushes = np.random.default_rng(1).uniform(-3.0, 3.0, steps).tolist()
    begun = time.perf_counter()
    for index, push in enumerate(pushes):
        if index % 50 == 0:
            reset()
        step(push)
    return steps / (time.perf_counter() - begun)


def main(steps: int) -> None:
    from gymnasium.utils.env_checker import check_env

    check_env(CartPole(), skip_render_check=True)
    print("the checks of Gymnasium hold")
    own, length = rate(CartPole(), steps)
    print(f"cotree: {own:.0f} steps of 40 ms per second, resets among them; {length:.1f} steps per episode")
    try:
        other = gymnasium.make("InvertedPendulum-v5").unwrapped
    except (gymnasium.error.DependencyNotInstalled, ImportError):
        print("MuJoCo is not installed")
        return
    theirs, length = rate(other, steps)
    print(f"InvertedPendulum: {theirs:.0f} steps of 40 ms per second, resets among them; {length:.1f} steps per episode")
    import mujoco

    def push(force: float) -> None:
        other.data.ctrl[0] = force / 100.0
        mujoco.mj_step(other.model, other.data, nstep=other.frame_skip)

    run = CartPole().run
    alone = solver_rate(lambda force: run.step(0.04, push=force), run.reset, steps)
    theirs = solver_rate(push, lambda: mujoco.mj_resetData(other.model, other.data), steps)
    print(f"alone: Run.step {alone:.0f}, mj_step {theirs:.0f} steps of 40 ms per second")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 20_000)
