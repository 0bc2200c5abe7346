"""What calls are given: values by name, times, names, inputs over time; each is checked where it is read."""

from __future__ import annotations

import datetime
import inspect
import math
import numbers
from collections.abc import Callable, Iterable, Mapping, Sequence
from decimal import Decimal
from fractions import Fraction
from typing import TYPE_CHECKING, Any, NamedTuple, TypedDict, TypeVar

import numpy as np

from . import _cotree
from ._faults import meant
from ._results import Results

if TYPE_CHECKING:
    from ._run import Run

#: A number in SI units.
Number = float | np.floating[Any] | np.integer[Any] | Decimal | Fraction
#: A number in SI units, or a text with a unit such as "120 mm".
Value = Number | str
#: Times, names and columns of values over time.
Columns = tuple[list[float], list[str], list[list[float]]]
#: An experiment: settings, what was measured, inputs over time.
Fitted = tuple[list[tuple[str, Value]], Columns, Columns | None]


class RunOptions(TypedDict, total=False):
    """What runs and studies of them may be given; what is not, or None, is the scene's."""

    #: Start of the run [s].
    start: Value | None
    #: End of the run [s].
    stop: Value | None
    #: Time between communication points [s].
    step: Value | None
    #: Relative tolerance of the solver.
    tolerance: float | None
    #: Parameters, constant inputs and initial values by name.
    set: Mapping[str, Value] | None
    #: Inputs over time: a data frame with the index or column `time` [s], `Results`, a data set of xarray or a mapping with "time"; linear between its rows and constant outside.
    inputs: Any


F = TypeVar("F", bound=Callable[..., Any])


def spelled_out(call: F) -> F:
    """The same call, whose signature `help` shows with the names of :class:`RunOptions` in place of `**run`."""
    signature = inspect.signature(call)
    before = [own for own in signature.parameters.values() if own.kind is not inspect.Parameter.VAR_KEYWORD]
    types = {name: f"{kind}".removeprefix("ForwardRef('").removesuffix("')") for name, kind in RunOptions.__annotations__.items()}
    options = [inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=None, annotation=types[name]) for name in types]
    call.__signature__ = signature.replace(parameters=[*before, *options])  # type: ignore[attr-defined]
    return call


class Asked(NamedTuple):
    """What a run is given, read."""

    times: Times
    settings: list[tuple[str, Value]]
    inputs: Any


def asked(call: str, run: RunOptions, at: Value | Iterable[Value] | None = None, **refused: str) -> Asked:
    """The options of a call, with its communication points; `refused` are those that it has no use for, with what to do instead.

    Raises TypeError for others than those of `RunOptions`.
    """
    given: dict[str, Any] = dict(run)
    for name, value in given.items():
        if name not in RunOptions.__annotations__:
            raise TypeError(f"{call}() has no argument {name!r}; {meant(name, RunOptions.__annotations__)}")
        if name in refused and value is not None:
            raise TypeError(f"{call}() has no argument {name!r}: {refused[name]}")
    times = Times(given.get("start"), given.get("stop"), given.get("step"), given.get("tolerance"), at)
    return Asked(times, settings(given.get("set")), given.get("inputs"))


class Times:
    """Times and tolerance of a run; None is the scene's. `at` are communication points in place of `stop` and `step`."""

    __slots__ = ("at", "start", "step", "stop", "tolerance")

    def __init__(
        self,
        start: Value | None,
        stop: Value | None,
        step: Value | None,
        tolerance: float | None,
        at: Value | Iterable[Value] | None = None,
    ) -> None:
        start, stop, step = (value if value is None else duration(value) for value in (start, stop, step))
        for name, value in (("start", start), ("stop", stop), ("step", step)):
            if value is not None:
                _finite(name, value)
        if tolerance is not None:
            check_value("tolerance", tolerance)
            if isinstance(tolerance, str):
                raise TypeError(f"tolerance: {tolerance!r} is not a number")
            tolerance = float(tolerance)
        if at is not None and not (stop is None and step is None):
            raise ValueError("times: they are the communication points; leave `stop` and `step` out")
        self.at = None if at is None else times("times", at)
        self.start, self.stop, self.step, self.tolerance = start, stop, step, tolerance

    def given(self) -> tuple[Any, ...]:
        """All of it."""
        return self.start, self.stop, self.step, self.tolerance, self.at


def _finite(name: str, value: Any) -> None:
    """Raises TypeError unless it is a number or a text, ValueError for a number that is not finite."""
    check_value(name, value)
    if not isinstance(value, str) and not math.isfinite(value):
        raise ValueError(f"{name}: {value!r} is not a finite number")


def check_value(name: str, value: Any) -> None:
    """Raises TypeError unless it is None, a number, or a text. Truth values are no numbers."""
    if value is None or isinstance(value, float | str):
        return
    if isinstance(value, bool) or getattr(getattr(value, "dtype", None), "kind", "") == "b":
        raise TypeError(f"{name}: {value!r} is neither a number nor a text with a unit")
    # numpy counts its durations among the integers; arrays of JAX and others without dimensions are numbers, too.
    is_time = getattr(getattr(value, "dtype", None), "kind", "") in ("m", "M")
    is_number = isinstance(value, numbers.Real | Decimal) or getattr(value, "ndim", None) == 0
    if is_time or not is_number:
        raise TypeError(f"{name}: {value!r} is neither a number nor a text with a unit")


def duration(value: Any) -> Any:
    """A duration of Python, numpy or pandas in seconds; anything else as it is."""
    if isinstance(value, datetime.timedelta | np.timedelta64) or getattr(getattr(value, "dtype", None), "kind", "") == "m":
        return float(in_seconds(np.asarray([value]))[0])
    return value


def in_seconds(values: np.ndarray) -> np.ndarray:
    """Durations in seconds, whatever their unit; anything else as it is.

    Raises ValueError for dates, which are no times of a run, and for durations without a unit.
    """
    kinds = {type(value) for value in values.flat} if values.dtype.kind == "O" else set()
    if values.dtype.kind == "M" or any(issubclass(kind, datetime.date | np.datetime64) for kind in kinds):
        raise ValueError("dates; give the seconds since the start, such as `index - index[0]`")
    if kinds and all(issubclass(kind, datetime.timedelta) for kind in kinds):
        return np.array([value.total_seconds() for value in values.flat]).reshape(values.shape)
    if any(issubclass(kind, datetime.timedelta | np.timedelta64) for kind in kinds):
        raise ValueError("durations among other values; give numbers [s]")
    if values.dtype.kind != "m":
        return values
    if np.datetime_data(values.dtype)[0] == "generic":
        raise ValueError("durations without a unit; give numbers [s]")
    return values / np.timedelta64(1, "s")


def settings(given: Mapping[str, Value] | None, what: str = "set") -> list[tuple[str, Value]]:
    """Names and values; TypeError says which is none."""
    if given is None:
        return []
    if not (isinstance(given, Mapping) or (hasattr(given, "items") and hasattr(given, "index"))):
        raise TypeError(f"{what}: give a mapping of names to values, not {type(given).__name__}")
    for name, value in given.items():
        if value is None:
            raise TypeError(f"{what}: {name} has no value")
        check_value(f"{what}: {name}", value)
    return [(str(name), value) for name, value in given.items()]


def names(what: str, given: str | Iterable[str]) -> list[str]:
    """One name, or several."""
    try:
        names = [given] if isinstance(given, str) else list(given)
    except TypeError:
        names = [given]  # type: ignore[list-item]
    for name in names:
        if not isinstance(name, str):
            raise TypeError(f"{what}: {name!r} is not a name; give one or several")
    return names


def times(name: str, given: Any, neither: str = "not a time") -> list[float]:
    """One time, or several [s]."""
    is_one = isinstance(given, str) or not isinstance(given, Iterable) or getattr(given, "ndim", None) == 0
    listed = [given] if is_one else list(given)
    if any(isinstance(value, np.ndarray) and value.ndim for value in listed):
        raise TypeError(f"{name}: {given!r} is to be one time or several")
    return [seconds(name, value, neither) for value in listed]


def seconds(name: str, value: Any, neither: str) -> float:
    if isinstance(value, str):
        try:
            return _cotree.seconds(value)
        except ValueError as error:
            raise ValueError(f"{name}: {value!r} is {neither}: {error}") from None
    if getattr(getattr(value, "dtype", None), "kind", "") == "M":
        raise TypeError(f"{name}: {value!r} is {neither}: it is a date; times are numbers [s] or texts such as '20 ms'")
    try:
        return float(duration(value))
    except (TypeError, ValueError):
        raise TypeError(f"{name}: {value!r} is {neither}; times are numbers [s] or texts such as '20 ms'") from None


def varied(vary: str | Iterable[str] | Mapping[str, Any]) -> list[tuple[str, Value | None, Value | None]]:
    """Names of what is varied, each with its bounds."""
    named = {vary: None} if isinstance(vary, str) else vary if isinstance(vary, Mapping) else dict.fromkeys(vary)
    return [(name, *bounds(name, pair)) for name, pair in named.items()]


def bounds(name: str, pair: Any) -> tuple[Value | None, Value | None]:
    """The bounds of what is varied."""
    if pair is None:
        return None, None
    if isinstance(pair, str) or not isinstance(pair, Sequence | np.ndarray) or len(pair) != 2:
        raise TypeError(f"vary: {name}: {pair!r} is to be its bounds (low, high), where None is the scene's, or None for both")
    for value in pair:
        check_value(f"vary: {name}", value)
    low, high = pair
    return low, high


def laws(inputs: Any) -> dict[str, Callable[[float, Run], float]] | None:
    """Inputs that are functions, each of the time and the run; none if there is a table."""
    if not isinstance(inputs, Mapping) or "time" in inputs or not any(map(callable, inputs.values())):
        return None
    for name, law in inputs.items():
        if not callable(law):
            raise TypeError(f"inputs: {name}: {law!r} is no function, as others are; give a constant input by `set`")
    return {str(name): one_law(law) for name, law in inputs.items()}


def one_law(law: Callable[..., Any]) -> Callable[[float, Run], float]:
    """A function of the time, or of the time and the run."""
    try:
        named = inspect.signature(law).parameters.values()
    except ValueError:  # functions of numpy have none
        return lambda time, run: float(law(time))
    needed = [own for own in named if own.default is own.empty and own.kind in (own.POSITIONAL_ONLY, own.POSITIONAL_OR_KEYWORD)]
    if len(needed) > 1:
        return lambda time, run: float(law(time, run))
    return lambda time, run: float(law(time))


def threads(count: int) -> int:
    if count < 0:
        raise ValueError(f"threads: {count} is below 0, which stands for one for each processor")
    return count


def inputs(given: Any, what: str = "inputs") -> Columns | None:
    """Times, names and columns of values over time."""
    if given is None:
        return None
    if isinstance(given, Results):
        columns = {"time": given.time, **given}
    elif hasattr(given, "data_vars"):  # of xarray, whose times are a coordinate
        columns = {str(name): given[name] for name in (*given.data_vars, *(name for name in given.coords if name == "time"))}
    elif hasattr(given, "columns") and not isinstance(given, Mapping) and not hasattr(given, "column_names"):
        columns = {str(name): given[name] for name in given.columns}
        if "time" not in columns and hasattr(given, "index"):
            columns["time"] = given.index
    elif isinstance(given, Mapping):
        columns = {str(name): column for name, column in given.items()}
    elif hasattr(given, "column_names") and hasattr(given, "column"):  # of pyarrow
        columns = {str(name): given.column(name) for name in given.column_names}
    else:
        raise TypeError(f"{what}: give a data frame or a mapping with a column `time`, not {type(given).__name__}")
    if "time" not in columns:
        raise ValueError(f"{what}: there is no column `time`")
    times = (over_time(what, "time", columns["time"]) * _unit_of_time(what, columns.pop("time"))).tolist()
    return times, list(columns), [over_time(what, name, column).tolist() for name, column in columns.items()]


def _unit_of_time(what: str, column: Any) -> float:
    """Seconds of one unit of these times, where they are an array of xarray that says one."""
    if not hasattr(column, "dims") or column.dtype.kind == "m":
        return 1.0
    written = column.attrs.get("units", "s")
    try:
        return _cotree.seconds(f"1 {written}")
    except ValueError as error:
        raise ValueError(f"{what}: time has the unit {written!r}: {error}") from None


def over_time(what: str, name: str, column: Any) -> np.ndarray:
    """Numbers over time; of the times themselves durations, too."""
    if callable(column):
        raise TypeError(f"{what}: {name} is a function; functions stand in a mapping without `time`, and only `simulate` takes them")
    try:
        raw = np.asarray(column)
    except ValueError:
        raise ValueError(f"{what}: {name} is to be a list of numbers, one for each time") from None
    try:
        found = in_seconds(raw)
    except ValueError as error:
        raise ValueError(f"{what}: {name} has {error}") from None
    if raw.dtype.kind == "b":
        raise ValueError(f"{what}: {name} has truth values; give numbers, such as 0.0 and 1.0")
    if found is not raw and name != "time":
        raise ValueError(f"{what}: {name} has durations; give numbers in SI units")
    try:
        values = np.asarray(found, dtype=float)
    except (TypeError, ValueError):
        raise ValueError(f"{what}: {name} has values that are no numbers; give them in SI units") from None
    if values.ndim != 1:
        raise ValueError(f"{what}: {name} is to be a list of numbers, one for each time")
    return values
