from pathlib import Path

import pytest

import cotree

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture
def root():
    return ROOT


@pytest.fixture
def slider_crank():
    return cotree.load(ROOT / "models/slider_crank/scene.toml")


@pytest.fixture
def pendulum():
    """A point mass on a rod without mass: everything is known in closed form."""
    return (
        cotree.Builder("pendulum")
        .gravity([0, -9.81])
        .parameter("length", "1 m", min="1 mm")
        .body("bob", mass=1.0, inertia=0.0, points={"top": [0, "length"]})
        .revolute("hinge", "ground", "bob.top")
        .initial("bob.angle", "1 deg")
        .output("bob.angle", "energy.total")
        .stop("2 s")
        .step("1 ms")
        .tolerance(1e-9)
        .model()
    )
