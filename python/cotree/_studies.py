"""Equilibria, linear systems, vibrations."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, overload

import numpy as np

from ._faults import unknown
from ._results import Compared

if TYPE_CHECKING:
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

    def frequencies(self) -> np.ndarray:
        """Oscillations a second [Hz]."""
        return np.array([mode.frequency for mode in self._modes])

    def __repr__(self) -> str:
        listed = ", ".join(f"{mode.frequency:.4g} Hz" for mode in self._modes)
        return f"<{len(self)} modes: {listed}>"


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

    @property
    def model(self) -> Model:
        """The model with what was set and the values that fit best.

        Raises ValueError where the scene does not write one of them.
        """
        if self._origin is None:
            raise ValueError("model: the fit is not one of a model")
        return self._origin.replace({**self._set, **self.values})


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
