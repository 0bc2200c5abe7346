"""Equilibria, linear systems, vibrations."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, overload

import numpy as np

from ._faults import unknown
from ._results import Compared, same
from ._show import aligned, counted, matrix, table

if TYPE_CHECKING:
    import pandas
    import xarray

    from ._model import Model


@dataclass(frozen=True, eq=False)
class Equilibrium(Compared):
    """Where a mechanism rests: poses, reactions and loads by name [SI], and what a small disturbance does.

    `stability` is "held", "stable", "neutral", "undecided" or "unstable"; `moves_most` names the coordinate of the mode that decides.
    `standing` are the frictions and freewheels that hold where they were put, so that this is one place of many; those in `verging` hold all that they can.
    How those in `shared` share what they hold is not determined, and the values have one way.
    """

    time: float
    stability: str
    moves_most: str | None
    values: dict[str, float]
    groups: dict[str, dict[str, float]] = field(repr=False)
    standing: tuple[str, ...] = ()
    verging: tuple[str, ...] = ()
    shared: tuple[str, ...] = ()

    def __getitem__(self, name: str) -> float:
        if name not in self.values:
            raise unknown(name, self.values, "is no value of the equilibrium")
        return self.values[name]

    def _ipython_key_completions_(self) -> list[str]:
        return list(self.values)

    def _repr_html_(self) -> str:
        rows = [[group, name, value] for group, values in self.groups.items() for name, value in values.items()]
        return table(f"{self.stability} equilibrium", ["", "variable", "value"], rows)


@dataclass(frozen=True, eq=False)
class StateSpace(Compared):
    """dx/dt = A x + B u, y = C x + D u for small changes about a point of the motion, where dx/dt itself is `rates`: zero at rest."""

    time: float
    states: tuple[str, ...]
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    units: dict[str, str]
    A: np.ndarray
    B: np.ndarray
    C: np.ndarray
    D: np.ndarray
    rates: np.ndarray

    def __iter__(self) -> Iterator[np.ndarray]:
        """A, B, C, D, as control libraries take them: `scipy.signal.StateSpace(*system)`."""
        return iter((self.A, self.B, self.C, self.D))

    def _matrices(self) -> dict[str, tuple[tuple[str, ...], tuple[str, ...], np.ndarray]]:
        """Names of rows and columns, and numbers."""
        return {
            "A": (self.states, self.states, self.A),
            "B": (self.states, self.inputs, self.B),
            "C": (self.outputs, self.states, self.C),
            "D": (self.outputs, self.inputs, self.D),
        }

    def to_pandas(self) -> dict[str, pandas.DataFrame]:
        """Data frames "A", "B", "C", "D" with the names of states, inputs and outputs."""
        import pandas

        return {name: pandas.DataFrame(values, index=list(rows), columns=list(columns)) for name, (rows, columns, values) in self._matrices().items()}

    def to_xarray(self) -> xarray.Dataset:
        """A data set with A along `rate` and `state`, B along `rate` and `input`, C along `output` and `state`, D along `output` and `input`; `rate` has the states that change, and each its unit."""
        import xarray

        names = {"rate": self.states, "state": self.states, "input": self.inputs, "output": self.outputs}
        along = {"A": ("rate", "state"), "B": ("rate", "input"), "C": ("output", "state"), "D": ("output", "input")}
        units = {f"{name}_units": (name, [self.units[own] for own in listed]) for name, listed in names.items() if name != "rate"}
        coordinates: dict[str, Any] = {**{name: (name, list(listed)) for name, listed in names.items()}, **units}
        columns = {name: (along[name], values) for name, (_, _, values) in self._matrices().items()}
        return xarray.Dataset({**columns, "rates": ("rate", self.rates)}, coords=coordinates, attrs={"time": self.time})

    def _repr_html_(self) -> str:
        captions = {"A": "states by states", "B": "states by inputs", "C": "outputs by states", "D": "outputs by inputs"}
        return "".join(matrix(f"{name}: {captions[name]}", *own) for name, own in self._matrices().items())

    def poles(self) -> np.ndarray:
        """Eigenvalues of A [1/s]."""
        return np.linalg.eigvals(self.A) if len(self.A) else np.zeros(0, complex)


@dataclass(frozen=True)
class Mode:
    """A vibration: `shape` is the complex amplitude of every branch coordinate, the largest 1; `derivatives` are those of the eigenvalue that were
    asked for, none of free motions and of eigenvalues that are there twice."""

    eigenvalue: complex
    frequency: float
    natural_frequency: float
    damping_ratio: float | None
    free: bool
    shape: dict[str, complex]
    derivatives: dict[str, complex] = field(default_factory=dict)


class Modes(Sequence[Mode]):
    """The vibrations about a pose, slowest first."""

    def __init__(self, time: float, modes: Sequence[Mode]) -> None:
        self.time = time
        self._modes = tuple(modes)

    @overload
    def __getitem__(self, index: int) -> Mode: ...
    @overload
    def __getitem__(self, index: slice) -> Sequence[Mode]: ...
    def __getitem__(self, index: int | slice) -> Mode | Sequence[Mode]:
        return self._modes[index]

    def __len__(self) -> int:
        return len(self._modes)

    def __eq__(self, other: object) -> bool:
        return same((self.time, self._modes), (other.time, other._modes)) if isinstance(other, Modes) else NotImplemented

    __hash__ = None  # type: ignore[assignment]

    def _columns(self) -> dict[str, list[Any]]:
        names = ("eigenvalue", "frequency", "natural_frequency", "damping_ratio", "free")
        return {name: [getattr(mode, name) for mode in self._modes] for name in names}

    def to_pandas(self) -> pandas.DataFrame:
        """A data frame with a row for each mode: eigenvalue [1/s], frequencies [Hz], damping ratio, and the shape in a column for each coordinate."""
        import pandas

        coordinates = list(self._modes[0].shape) if self._modes else []
        shapes = {f"shape({name})": [mode.shape[name] for mode in self._modes] for name in coordinates}
        return pandas.DataFrame({**self._columns(), **shapes}, index=pandas.RangeIndex(len(self), name="mode"))

    def to_xarray(self) -> xarray.Dataset:
        """A data set along `mode`, with `shape` along `mode` and `coordinate`."""
        import xarray

        coordinates = list(self._modes[0].shape) if self._modes else []
        shape = np.array([[mode.shape[name] for name in coordinates] for mode in self._modes], dtype=complex).reshape(len(self), len(coordinates))
        kinds: dict[str, Any] = {"eigenvalue": complex, "free": bool}
        units = {"eigenvalue": "1/s", "frequency": "Hz", "natural_frequency": "Hz"}
        columns: dict[str, Any] = {
            name: ("mode", np.array(values, dtype=kinds.get(name, float)), {"units": units[name]} if name in units else {})
            for name, values in self._columns().items()
        }
        along: dict[str, Any] = {"mode": ("mode", np.arange(len(self))), "coordinate": ("coordinate", coordinates)}
        return xarray.Dataset({**columns, "shape": (("mode", "coordinate"), shape)}, coords=along, attrs={"time": self.time})

    def _repr_html_(self) -> str:
        columns = self._columns()
        rows = [[index, *row, _largest(mode)] for index, (row, mode) in enumerate(zip(zip(*columns.values(), strict=True), self._modes, strict=True))]
        return table(counted(len(self), "mode"), ["", "eigenvalue [1/s]", "frequency [Hz]", "natural frequency [Hz]", "damping ratio", "free", "moves most"], rows)

    def frequencies(self) -> np.ndarray:
        """Oscillations a second [Hz]."""
        return np.array([mode.frequency for mode in self._modes])

    def __repr__(self) -> str:
        listed = ", ".join(f"{mode.frequency:.4g} Hz" for mode in self._modes)
        return f"<{len(self)} modes: {listed}>"


def _largest(mode: Mode) -> str:
    """The coordinate that a mode moves most."""
    return max(mode.shape, key=lambda name: abs(mode.shape[name]), default="")


@dataclass(frozen=True)
class Experiment:
    """What was measured in one experiment, for `fit`: with what was set in it alone, where it began for example, and with inputs over time of its own."""

    measured: Any
    set: Mapping[str, Any] | None = None
    inputs: Any = None


@dataclass(frozen=True, eq=False)
class Fitted(Compared):
    """One experiment beside the motion that fits best.

    `fitted` and `residuals` (measured less fitted) are arrays at the measured times. Residuals are not a number where nothing was measured, and where a column has no value or no derivative in the
    first motion, at the times `left_out`.
    """

    time: np.ndarray
    left_out: np.ndarray
    fitted: dict[str, np.ndarray] = field(repr=False)
    residuals: dict[str, np.ndarray] = field(repr=False)


@dataclass(frozen=True, eq=False)
class Fit(Compared):
    """Values that fit what was measured, by name, SI: `fit["damping"]` is one of them.

    `errors` are standard errors and `limits` the 95 % limits, not a number where a value is at its bound; `correlation` has rows and columns in the order of
    `values`, and `deviations` are the standard deviations of the columns. `experiments` has what was measured beside the motions; of a single one `time`, `left_out`, `fitted` and `residuals` stand here, too.
    `ended` is "minimum", or "evaluations" if no minimum was reached. `model` is the model with these values.
    """

    values: dict[str, float]
    errors: dict[str, float]
    limits: dict[str, tuple[float, float]]
    start: dict[str, float]
    units: dict[str, str]
    correlation: np.ndarray
    experiments: tuple[Fitted, ...] = field(repr=False)
    deviations: dict[str, float]
    evaluations: int
    ended: str
    _origin: Model | None = field(default=None, repr=False, compare=False)
    _set: dict[str, Any] = field(default_factory=dict, repr=False, compare=False)

    def _single(self) -> Fitted:
        if len(self.experiments) != 1:
            raise ValueError(f"there are {len(self.experiments)} experiments: take one of `experiments`")
        return self.experiments[0]

    @property
    def time(self) -> np.ndarray:
        """The measured times [s]; raises ValueError where there are several experiments, as the next ones do."""
        return self._single().time

    @property
    def left_out(self) -> np.ndarray:
        """The times of what does not count [s]."""
        return self._single().left_out

    @property
    def fitted(self) -> dict[str, np.ndarray]:
        """The motion at the measured times."""
        return self._single().fitted

    @property
    def residuals(self) -> dict[str, np.ndarray]:
        """Measured less fitted."""
        return self._single().residuals

    def __getitem__(self, name: str) -> float:
        if name not in self.values:
            raise unknown(name, self.values, "was not varied")
        return self.values[name]

    def _ipython_key_completions_(self) -> list[str]:
        return list(self.values)

    def _rows(self) -> list[list[Any]]:
        return [[name, value, self.errors[name], *self.limits[name], self.units[name], self.start[name]] for name, value in self.values.items()]

    def _caption(self) -> str:
        deviations = ", ".join(f"{name} {own:.4g} {self.units[name]}".rstrip() for name, own in self.deviations.items())
        early = "" if self.ended == "minimum" else " (no minimum was reached)"
        return f"{counted(len(self.experiments), 'experiment')}, {counted(self.evaluations, 'motion')}{early}; standard deviations: {deviations}"

    def to_pandas(self) -> pandas.DataFrame:
        """A data frame with a row for each value: standard error, 95 % limits, unit, and where the search began."""
        import pandas

        names, *columns = zip(*self._rows(), strict=True) if self.values else [[] for _ in FITTED]
        return pandas.DataFrame(dict(zip(FITTED[1:], columns, strict=True)), index=pandas.Index(names, name="name"))

    def _repr_html_(self) -> str:
        return table(self._caption(), FITTED, self._rows())

    def __str__(self) -> str:
        return f"{aligned(FITTED, self._rows())}\n{self._caption()}"

    @property
    def model(self) -> Model:
        """The model with what was set and the values that fit best.

        Raises ValueError where the scene does not write one of them.
        """
        if self._origin is None:
            raise ValueError("model: the fit is not one of a model")
        return self._origin.replace({**self._set, **self.values})


#: The columns of a fit's table.
FITTED = ("name", "value", "standard error", "low", "high", "unit", "start")


def fitted(report: dict[str, Any], origin: Model, settings: dict[str, Any]) -> Fit:
    """From what the program hands over."""
    seen = report.get("experiments", [report])
    quantities = {own["name"]: own for own in report["quantities"]}
    columns = {own["name"]: own for experiment in seen for own in experiment["columns"]}
    nan = float("nan")

    def each(key: str) -> dict[str, Any]:
        return {name: own[key] for name, own in quantities.items()}

    def beside(own: dict[str, Any]) -> Fitted:
        fitted, residuals = (
            {column["name"]: np.array(column[key], dtype=float) for column in own["columns"]} for key in ("fitted", "residuals")
        )
        return Fitted(np.array(own["times"]), np.array(own["left_out"]), fitted, residuals)

    return Fit(
        values=each("value"),
        errors={name: nan if error is None else error for name, error in each("error").items()},
        limits={name: (nan, nan) if pair is None else tuple(pair) for name, pair in each("limits").items()},
        start=each("start"),
        units={name: own["unit"] for name, own in (quantities | columns).items()},
        correlation=np.array([own["correlation"] for own in quantities.values()], dtype=float),
        experiments=tuple(map(beside, seen)),
        deviations={name: own["deviation"] for name, own in columns.items()},
        evaluations=report["evaluations"],
        ended=report["ended"],
        _origin=origin,
        _set=settings,
    )


@dataclass(frozen=True)
class Peak:
    """A largest or smallest value, or a crossing ("max", "min", "crossing"): what, when [s], and the derivatives of both by name; None where `refused` says why."""

    output: str
    unit: str
    kind: str
    value: float
    time: float
    d_value: dict[str, float] | None
    d_time: dict[str, float] | None
    refused: str | None


@dataclass(frozen=True, eq=False)
class Sensitivities(Compared):
    """Derivatives of outputs at fixed time: `values` (time, of) and `derivatives` (time, of, to), SI.

    `sensitivities["rod.angle", "rod_length"]` is one of them over time; `units` has their units by the same pair.
    """

    time: np.ndarray
    of: tuple[str, ...]
    to: tuple[str, ...]
    units: dict[tuple[str, str], str]
    values: np.ndarray
    derivatives: np.ndarray

    def __getitem__(self, pair: tuple[str, str]) -> np.ndarray:
        of, to = pair
        if of not in self.of or to not in self.to:
            raise KeyError(f"{pair!r}: there are derivatives of {', '.join(self.of)} with respect to {', '.join(self.to)}")
        return self.derivatives[:, self.of.index(of), self.to.index(to)]

    def _ipython_key_completions_(self) -> list[tuple[str, str]]:
        return [(of, to) for of in self.of for to in self.to]

    def to_xarray(self) -> xarray.Dataset:
        """A data set along `time`: the outputs, and as `d(of)/d(to)` their derivatives, each with its unit."""
        import xarray

        columns: dict[str, Any] = {name: ("time", self.values[:, place]) for place, name in enumerate(self.of)}
        columns |= {f"d({of})/d({to})": ("time", self[of, to], {"units": self.units[of, to]}) for of in self.of for to in self.to}
        return xarray.Dataset(columns, coords={"time": ("time", self.time, {"units": "s"})})

    def to_pandas(self) -> pandas.DataFrame:
        """A data frame with `time` [s] as its index: the outputs, and as `d(of)/d(to)` their derivatives."""
        import pandas

        columns = {**{name: self.values[:, place] for place, name in enumerate(self.of)}, **{f"d({of})/d({to})": self[of, to] for of in self.of for to in self.to}}
        return pandas.DataFrame(columns, index=pandas.Index(self.time, name="time"))

    def _repr_html_(self) -> str:
        pairs = [(of, to) for of in self.of for to in self.to]
        rows = [[f"d({of})/d({to})", self.units[of, to], *(f(self[of, to]) if len(self.time) else None for f in (np.min, np.max)), self[of, to][-1] if len(self.time) else None] for of, to in pairs]
        return table(f"derivatives at {counted(len(self.time), 'time')}", ["derivative", "unit", "min", "max", "end"], rows)

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> np.ndarray:
        return np.array(self.derivatives, dtype=dtype)


def _quotient(of: str, to: str) -> str:
    """The unit of a derivative; empty where either is not known or a pure number."""
    if not of or not to:
        return of
    return "1" if of == to else f"{of}/({to})" if any(sign in to for sign in "./") else f"{of}/{to}"


def sensitivities(
    times: Iterable[float],
    outputs: Sequence[tuple[str, str]],
    parameters: Sequence[tuple[str, str]],
    values: np.ndarray,
    derivatives: np.ndarray,
) -> Sensitivities:
    """From what the program hands over."""
    units = {(of, to): _quotient(unit, per) for of, unit in outputs for to, per in parameters}
    of, to = (tuple(name for name, _ in signals) for signals in (outputs, parameters))
    return Sensitivities(np.array(list(times)), of, to, units, values, derivatives)
