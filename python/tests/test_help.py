"""What `help` shows: examples that run, signatures with the options by their names."""

import doctest
import inspect

import pytest

import cotree
from cotree import _build, _commands, _model, _results, _run

#: Calls that take the options of a run.
CALLS = ("simulate", "start", "simulate_many", "measure", "sweep", "sensitivities", "value_and_gradient", "peaks", "fit", "optimize", "trace")


@pytest.mark.parametrize("module", [cotree, _build, _commands, _model, _results, _run], ids=lambda own: own.__name__)
def test_the_examples_run(module, root, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    names = {}
    exec("\n".join(line for line in _examples(cotree.__doc__)), names)
    import numpy

    names |= {"np": numpy, "results": names["model"].simulate(), "bar": cotree.load(root / "models/four_bar/scene.toml")}
    found = doctest.testmod(module, extraglobs=names)
    assert found.failed == 0 and (found.attempted > 0)


def _examples(text):
    return [example.source for example in doctest.DocTestParser().get_examples(text)][:2]


@pytest.mark.parametrize("name", CALLS)
def test_signatures_name_the_options(name):
    shown = inspect.signature(getattr(cotree.Model, name))
    assert set(cotree.RunOptions.__annotations__) <= set(shown.parameters) and "run" not in shown.parameters
    assert "ForwardRef" not in str(shown)


@pytest.mark.parametrize("name", [*(own for own in CALLS if own not in ("trace", "peaks")), "linearize", "equilibrium", "modes", "motion", "replace", "export"])
def test_main_methods_have_an_example(name):
    assert ">>>" in getattr(cotree.Model, name).__doc__


def test_everything_public_is_explained():
    classes = [getattr(cotree, name) for name in cotree.__all__ if inspect.isclass(getattr(cotree, name))]
    public = [(own, name, member) for own in classes for name, member in vars(own).items() if not name.startswith("_") and callable(member)]
    assert [f"{own.__name__}.{name}" for own, name, member in public if not inspect.getdoc(member)] == []
