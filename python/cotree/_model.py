"""A mechanism, read from a scene: what can be asked of it."""

from __future__ import annotations

import importlib.resources
import json
import numbers
import os
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np

from . import _cotree
from ._faults import Fault, RunError, faults, raised
from ._results import Results, ResultsList, Table, formulas, frame, parameters
from ._studies import Equilibrium, Fit, Mode, Modes, Peak, Sensitivities, StateSpace, fitted, sensitivities

#: A number in SI units, or a text with a unit such as "120 mm".
Value = float | str


@dataclass(frozen=True, slots=True)
class Variable:
    """A parameter, input or output of a mechanism; numbers in SI units."""

    name: str
    description: str
    unit: str
    causality: str
    start: float | None
    min: float | None
    max: float | None


def load(path: str | os.PathLike[str]) -> Model:
    """Reads a scene file, TOML or JSON.

    Raises OSError if it cannot be read, SceneError with everything that is wrong with the scene.
    """
    return Model(Path(path).read_bytes(), os.fspath(path))


def loads(text: str, name: str = "scene") -> Model:
    """Reads a scene from a text in TOML or JSON; `name` stands for the file in messages.

    Raises SceneError with everything that is wrong with the scene.
    """
    return Model(text, name)


def from_dict(scene: Mapping[str, Any]) -> Model:
    """Makes a scene of nested dictionaries with the keys of the scene file.

    Raises SceneError with everything that is wrong with the scene, TypeError for what JSON cannot hold.
    """
    return Model(json.dumps(scene, indent=2, default=_plain), "scene.json")


def _plain(value: Any) -> Any:
    """Numbers and arrays of numpy as those of Python."""
    if isinstance(value, (np.ndarray, np.generic)):
        return value.tolist()
    raise TypeError(f"a scene has no place for {type(value).__name__}")


def _restored(text: bytes, name: str, files: list[tuple[str, str]]) -> Model:
    """The model that was read from these files, whatever became of them since."""
    model = Model.__new__(Model)
    model._text, model._name = text, name
    with raised():
        model._core = _cotree.Core.restored(files)
    return model


class Model:
    """A mechanism. It does not change; settings are given with each call.

    It can be pickled and sent to other processes, with all files that it was read from, and used from several threads at once: calls release the
    interpreter's lock and end with KeyboardInterrupt on Ctrl-C.
    """

    def __init__(self, text: str | bytes, name: str = "scene") -> None:
        self._text = text.encode() if isinstance(text, str) else text
        self._name = name
        with raised():
            self._core = _cotree.Core(self._text, name)
            # What is wrong with bodies and loops, beyond the form of the text. What is compiled for it is kept for the first run.
            self._core.check()

    def __reduce__(self):
        return _restored, (self._text, self._name, self._core.files())

    def __repr__(self) -> str:
        return f"<cotree.Model {self.name!r}>"

    def __str__(self) -> str:
        """The mechanism in figures and names, as `cotree show` prints it."""
        with raised():
            return self._core.summary()

    @property
    def name(self) -> str:
        """The scene's name."""
        return self._core.name()

    @property
    def text(self) -> str:
        """The text of the scene."""
        return self._text.decode()

    @property
    def variables(self) -> dict[str, Variable]:
        """Parameters, inputs and outputs by name."""
        with raised():
            listed = json.loads(self._core.variables())
        return {variable["name"]: Variable(**variable) for variable in listed}

    def check(self) -> tuple[Fault, ...]:
        """What is odd about the scene: its warnings."""
        with raised():
            report = self._core.check()
        return faults(report)[0] if report else ()

    def simulate(
        self,
        *,
        start: Value | None = None,
        stop: Value | None = None,
        step: Value | None = None,
        tolerance: float | None = None,
        set: Mapping[str, Value] | None = None,
        inputs: Any = None,
        outputs: str | Sequence[str] | None = None,
    ) -> Results:
        """Runs the code that runs in the FMU.

        `start`, `stop`, `step` [s] and `tolerance` are the scene's if not given; `set` gives parameters, constant inputs and initial values;
        `inputs` are inputs over time, a data frame with the index or column `time` [s] or a mapping with "time", linear between its rows and
        constant outside; `outputs` are names of variables, instead of those of the scene.

        Raises SceneError, ValueError for arguments, RunError if the motion cannot be continued: its `results` has what comes before.
        """
        [run] = self._members(
            _Times(start, stop, step, tolerance), _settings(set), outputs, inputs, [], np.zeros((1, 0)), 1
        )
        if run.failure:
            raise RunError(run.failure, run)
        return run

    def simulate_many(
        self,
        parameters: Any,
        *,
        start: Value | None = None,
        stop: Value | None = None,
        step: Value | None = None,
        tolerance: float | None = None,
        set: Mapping[str, Value] | None = None,
        inputs: Any = None,
        outputs: str | Sequence[str] | None = None,
        threads: int = 0,
    ) -> ResultsList:
        """Runs many sets of parameters, constant inputs or initial values: a data frame with a column for each, a mapping of names to arrays, or a
        sequence of mappings; numbers in SI units.

        `threads` are as many as there are processors if 0; the results have the same bits whatever their number. Runs that end early do not raise:
        they have `failure`. Other arguments are those of `simulate`.
        """
        names, values = _parameters(parameters)
        times = _Times(start, stop, step, tolerance)
        return ResultsList(self._members(times, _settings(set), outputs, inputs, names, values, _threads(threads)))

    def measure(
        self,
        measures: str | Sequence[str],
        parameters: Any,
        *,
        start: Value | None = None,
        stop: Value | None = None,
        step: Value | None = None,
        tolerance: float | None = None,
        set: Mapping[str, Value] | None = None,
        inputs: Any = None,
        threads: int = 0,
    ) -> Table:
        """As `simulate_many`, keeping only numbers of each run, so that a hundred thousand runs fit into memory.

        Measures are written "max(rod.angle)"; there are max, min, peak (of the magnitude), range, mean, rms, first, last, when_max, when_min, of the values
        at communication points. Runs that end early have nan, and the reason in `failures`.
        """
        names, values = _parameters(parameters)
        times = _Times(start, stop, step, tolerance)
        with raised():
            columns, table, failures = self._core.measure(
                times, _settings(set), _names(measures), _inputs(inputs), names, values, _threads(threads)
            )
        given = {name: values[:, place] for place, name in enumerate(names)}
        return Table(given, columns, table, failures)

    def _members(self, times, settings, outputs, inputs, names, values, threads) -> list[Results]:
        outputs = None if outputs is None else _names(outputs)
        with raised():
            columns = self._core.outputs(outputs)
            runs = self._core.simulate(
                times, settings, outputs, _inputs(inputs), names, values, threads
            )
        labels, units = [name for name, _ in columns], [unit for _, unit in columns]
        return [
            Results(time, labels, units, matrix, failure, dict(zip(names, row.tolist(), strict=True)))
            for (time, matrix, failure), row in zip(runs, values, strict=True)
        ]

    def export(self, path: str | os.PathLike[str] | None = None, *, fmi: int | str = 2) -> Path:
        """Writes the scene as an FMU for this platform, FMI 2.0 or 3.0 [default: the scene's name, .fmu, in the current folder]; returns its path.

        Raises SceneError, OSError.
        """
        target = Path(f"{self.name}.fmu") if path is None else Path(path)
        with raised():
            self._core.export(target, str(fmi).removesuffix(".0"))
        return target

    def equations(self, notation: str = "text") -> str:
        """The equations of motion as text, latex, html, c, fortran, rust, python or json."""
        with raised():
            return self._core.equations(notation)

    def steps(self, notation: str = "text") -> str:
        """How the equations are derived, as text, latex or html."""
        with raised():
            return self._core.steps(notation)

    def drawing(self) -> str:
        """The mechanism at its start, as SVG."""
        with raised():
            return self._core.drawing()

    def page(self) -> str:
        """A page for a browser that shows the mechanism in motion, with plots and sliders where the package has the solver for browsers."""
        module = importlib.resources.files(__package__) / "runtimes" / "web" / "cotree_runtime.wasm"
        with raised():
            return self._core.page(module.read_bytes() if module.is_file() else None)

    def linearize(
        self, at: float | Iterable[float] | Literal["equilibrium"] | None = None, *, set: Mapping[str, Value] | None = None
    ) -> StateSpace | list[StateSpace]:
        """A, B, C, D from the inputs of the scene to its outputs.

        `at` is a time [s], "equilibrium", several times (which give a list), or the start if it is not given. Raises SceneError, and RunError if there is no
        linear system there.
        """
        several = at is not None and not isinstance(at, str) and np.ndim(at) > 0
        if several and len(at) == 0:
            return []
        if isinstance(at, str) and at != "equilibrium":
            raise ValueError(f'at: {at!r} is neither "equilibrium" nor a time [s]')
        times = None if isinstance(at, str) else [] if at is None else _times("at", at)
        with raised():
            report = json.loads(self._core.linearize(times, _settings(set)))
        points = [_state_space(point) for point in report.get("points", [report])]
        return points if several else points[0]

    def equilibrium(self, *, set: Mapping[str, Value] | None = None) -> Equilibrium:
        """Where the mechanism rests, with all reactions; of several equilibria the scene's guess picks one.

        Raises SceneError, and RunError if none is found.
        """
        with raised():
            report = json.loads(self._core.equilibrium(_settings(set)))
        values = {name: value for group in report["values"].values() for name, value in group.items()}
        return Equilibrium(report["time"], report["stability"], report["moves_most"], values, report["values"])

    def modes(
        self,
        at: float | None = None,
        *,
        to: str | Sequence[str] | None = None,
        set: Mapping[str, Value] | None = None,
    ) -> Modes:
        """Natural frequencies, damping ratios and shapes about the equilibrium next to the start, or about the pose at a time [s].

        With `to`, names of parameters or constant inputs, each mode about an equilibrium has the `derivatives` of its eigenvalue by name [1/s per unit].

        Raises SceneError, and RunError if there is no equilibrium.
        """
        if to is not None and at is not None:
            raise ValueError("to: derivatives are those of modes about an equilibrium; leave `at` out")
        time = None if at is None else _times("at", at)[0]
        with raised():
            report = json.loads(self._core.modes(time, _settings(set)))
            changes = [{}] * len(report["modes"])
            if to is not None:
                found = json.loads(self._core.mode_sensitivities(_names(to), _settings(set)))
                changes = [mode["derivatives"] for mode in found["modes"]]
        return Modes(report["time"], [_mode(mode, own) for mode, own in zip(report["modes"], changes, strict=True)])

    def sensitivities(
        self,
        of: str | Sequence[str] | None = None,
        to: str | Sequence[str] | None = None,
        times: float | Iterable[float] | Literal["equilibrium"] | None = None,
        *,
        tolerance: float | None = None,
        set: Mapping[str, Value] | None = None,
    ) -> Sensitivities:
        """Derivatives of variables [default: the scene's outputs] with respect to parameters, constant inputs and initial values, at these times [s],
        or where the mechanism rests: "equilibrium".

        They are integrated beside the motion (variational equations), not differenced: as accurate as the motion. Where laws switch they jump as they should.
        Raises SceneError, ValueError, and RunError where there are no derivatives: at singular poses, where a law that jumps is touched without being crossed.
        """
        if to is None:
            raise ValueError("to: name what the derivatives are with respect to: parameters, constant inputs, initial values")
        if times is None:
            raise ValueError('times: give times [s], or "equilibrium"')
        asked = None if of is None else _names(of), _names(to), _settings(set)
        if isinstance(times, str):
            if times != "equilibrium":
                raise ValueError(f'times: {times!r} is neither "equilibrium" nor times')
            with raised():
                return sensitivities(*self._core.equilibrium_sensitivities(*asked))
        times = _times("times", times)
        with raised():
            return sensitivities(times, *self._core.sensitivities(times, tolerance, *asked))

    def peaks(
        self,
        of: str | Sequence[str] | None = None,
        to: str | Sequence[str] = (),
        *,
        crossing: Mapping[str, float] | None = None,
        stop: Value | None = None,
        step: Value | None = None,
        tolerance: float | None = None,
        set: Mapping[str, Value] | None = None,
    ) -> list[Peak]:
        """The largest and the smallest value of variables [default: the scene's outputs] and when they are reached, and the times at which variables cross given
        values (SI), with the derivatives of both with respect to parameters, constant inputs and initial values.

        The motion is looked at every `step`: what happens between two points and is gone again is not seen. Where there are no derivatives, at a corner or of
        two equal peaks, `refused` says why. Raises as `sensitivities` does.
        """
        levels = [(name, _times(f"crossing: {name}", level)[0]) for name, level in (crossing or {}).items()]
        with raised():
            report = self._core.peaks(
                _Times(None, stop, step, tolerance),
                None if of is None else _names(of),
                _names(to),
                levels,
                _settings(set),
            )
        return [Peak(**feature) for feature in json.loads(report)["features"]]

    def fit(
        self,
        measured: Any,
        vary: str | Sequence[str] | Mapping[str, tuple[Value | None, Value | None] | None],
        *,
        sigma: Mapping[str, Value] | None = None,
        stop: Value | None = None,
        tolerance: float | None = None,
        set: Mapping[str, Value] | None = None,
    ) -> Fit:
        """Values of parameters, constant inputs and initial values with which the motion is as near as possible to what was measured.

        `measured` is a data frame with the index or column `time` [s], or a mapping with "time", and columns named like variables, SI. `vary` are
        names, or a mapping of names to their bounds (low, high), where None is the scene's; the search begins at the scene's values, or those of `set`. `sigma` are
        standard deviations of columns; those that are not given are estimated from the residuals.

        Raises SceneError, ValueError with everything that is wrong with the arguments, RunError if what was measured does not determine the values.
        """
        columns = _inputs(measured, "measured")
        if columns is None:
            raise ValueError("measured: nothing was measured")
        named = {vary: None} if isinstance(vary, str) else vary if isinstance(vary, Mapping) else dict.fromkeys(vary)
        bounds = [(name, *(pair or (None, None))) for name, pair in named.items()]
        with raised():
            report = self._core.fit(
                _Times(None, stop, None, tolerance), _settings(set), columns, bounds, _settings(sigma, "sigma")
            )
        return fitted(json.loads(report))

    def bench(self) -> dict[str, Any]:
        """Speed against error: every method at many tolerances, on this very scene, as `cotree bench --json` gives it."""
        with raised():
            return json.loads(self._core.bench())

    def _repr_html_(self) -> str:
        return frame(self.page(), 640)

    def _repr_latex_(self) -> str:
        return formulas(self.equations("latex"))


class _Times:
    """Times and tolerance of a run; None is the scene's."""

    __slots__ = ("start", "step", "stop", "tolerance")

    def __init__(self, start: Value | None, stop: Value | None, step: Value | None, tolerance: float | None) -> None:
        for name, value in (("start", start), ("stop", stop), ("step", step)):
            _value(name, value)
        if tolerance is not None and not isinstance(tolerance, numbers.Real):
            raise TypeError(f"tolerance: {tolerance!r} is not a number")
        self.start, self.stop, self.step, self.tolerance = start, stop, step, tolerance


_parameters = parameters


def _value(name: str, value: Any) -> None:
    """Raises TypeError unless it is None, a number, or a text."""
    is_number = isinstance(value, numbers.Real) or (isinstance(value, np.ndarray) and value.ndim == 0)
    if value is not None and not is_number and not isinstance(value, str):
        raise TypeError(f"{name}: {value!r} is neither a number nor a text with a unit")


def _settings(given: Mapping[str, Value] | None, what: str = "set") -> list[tuple[str, Value]]:
    """Names and values; TypeError says which is none."""
    if given is None:
        return []
    if not isinstance(given, Mapping):
        raise TypeError(f"{what}: give a mapping of names to values, not {type(given).__name__}")
    for name, value in given.items():
        if value is None:
            raise TypeError(f"{what}: {name} has no value")
        _value(f"{what}: {name}", value)
    return [(str(name), value) for name, value in given.items()]


def _names(given: str | Iterable[str]) -> list[str]:
    """One name, or several."""
    return [given] if isinstance(given, str) else list(given)


def _times(name: str, given: Any) -> list[float]:
    """One number, or several."""
    try:
        return [float(value) for value in np.atleast_1d(np.asarray(given if np.ndim(given) else [given]))]
    except (TypeError, ValueError):
        raise TypeError(f"{name}: {given!r} is to be one number or several, in SI units") from None


def _threads(count: int) -> int:
    if count < 0:
        raise ValueError(f"threads: {count} is below 0, which stands for one for each processor")
    return count


def _inputs(given: Any, what: str = "inputs") -> tuple[list[float], list[str], list[list[float]]] | None:
    """Times, names and columns of values over time."""
    if given is None:
        return None
    if hasattr(given, "columns") and not isinstance(given, Mapping):
        columns = {str(name): given[name] for name in given.columns}
        if "time" not in columns and hasattr(given, "index"):
            columns["time"] = given.index
    else:
        columns = dict(given)
    if "time" not in columns:
        raise ValueError(f"{what}: there is no column `time`")
    times = np.asarray(columns.pop("time"), dtype=float).tolist()
    return times, list(columns), [np.asarray(column, dtype=float).tolist() for column in columns.values()]


def _state_space(point: dict[str, Any]) -> StateSpace:
    signals = {kind: tuple(signal["name"] for signal in point[kind]) for kind in ("states", "inputs", "outputs")}
    units = {signal["name"]: signal["unit"] for kind in signals for signal in point[kind]}
    size = {kind: len(names) for kind, names in signals.items()}
    shapes = {"A": ("states", "states"), "B": ("states", "inputs"), "C": ("outputs", "states"), "D": ("outputs", "inputs")}
    matrices = {
        name: np.array(point[name], dtype=float).reshape(size[rows], size[columns])
        for name, (rows, columns) in shapes.items()
    }
    return StateSpace(point["time"], **signals, units=units, **matrices, rates=np.array(point["rates"], dtype=float))


def _mode(mode: dict[str, Any], changes: dict[str, Any]) -> Mode:
    shape = {name: complex(*parts) for name, parts in mode["shape"].items()}
    return Mode(
        complex(*mode["eigenvalue"]),
        mode["frequency"],
        mode["natural_frequency"],
        mode["damping_ratio"],
        mode["free"],
        shape,
        {name: complex(*own["eigenvalue"]) for name, own in changes.items() if own},
    )
