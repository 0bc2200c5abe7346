"""Variables over time, by name."""

from __future__ import annotations

import html
import importlib
import os
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import fields, is_dataclass
from typing import TYPE_CHECKING, Any, NamedTuple, overload

import numpy as np

from ._faults import unknown
from ._show import MOST_ROWS, Markup, counted, table, titled, to_csv

if TYPE_CHECKING:
    import matplotlib.axes
    import pandas
    import polars
    import xarray

    from ._commands import Report
    from ._given import Value

#: How many points the lines of variables have in a notebook.
MOST_POINTS = 100


def _columns(results: Results) -> dict[str, np.ndarray]:
    return {"time": results.time, **results}


def fixed(values: np.ndarray) -> np.ndarray:
    """An array that nobody changes, each column in one piece."""
    kept = np.asfortranarray(values)
    kept.setflags(write=False)
    return kept


def same(one: Any, other: Any) -> bool:
    """Are two values the same, arrays and what is not a number among them?"""
    if isinstance(one, np.ndarray) or isinstance(other, np.ndarray):
        return bool(np.array_equal(one, other, equal_nan=np.asarray(one).dtype.kind in "fc"))
    if isinstance(one, dict) and isinstance(other, dict):
        return list(one) == list(other) and all(same(one[key], other[key]) for key in one)
    if isinstance(one, float) and isinstance(other, float):
        return one == other or (one != one and other != other)
    if isinstance(one, tuple | list) and type(one) is type(other):
        return len(one) == len(other) and all(map(same, one, other))
    return bool(one == other)


class Compared:
    """A dataclass with arrays that `==` compares."""

    def __eq__(self, other: object) -> bool:
        if type(self) is not type(other) or not is_dataclass(self):
            return NotImplemented
        compared = [field.name for field in fields(self) if field.compare]
        return all(same(getattr(self, name), getattr(other, name)) for name in compared)

    __hash__ = None  # type: ignore[assignment]


class Mapped(Mapping[str, np.ndarray]):
    """Columns by name that numpy, pandas and readers of Arrow take as numbers."""

    def _frame(self) -> dict[str, Any]:
        """All columns of a frame."""
        return dict(self)

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> np.ndarray:
        raise NotImplementedError

    def __arrow_c_stream__(self, requested_schema: object = None) -> object:
        """For readers of Arrow's stream interface; needs polars or pyarrow."""
        try:
            import polars
        except ModuleNotFoundError:
            pyarrow = importlib.import_module("pyarrow")
            return pyarrow.table(self._frame()).__arrow_c_stream__(requested_schema)
        return polars.DataFrame(self._frame()).__arrow_c_stream__(requested_schema)

    def _ipython_key_completions_(self) -> list[str]:
        return list(self)

    __hash__ = None  # type: ignore[assignment]


class Logged(NamedTuple):
    """Something that has happened: an event of the scene, an impact, or what a limit, contact, rope or friction has done."""

    #: [s]
    time: float
    #: An event, a limit, contact or rope such as "guide.max", or a friction such as "guide.friction".
    name: str
    #: "event", "impact", "closes", "opens", "sticks", "slips" or "turns".
    what: str
    #: Of an impact [N.s, or N.m.s of an angle].
    impulse: float | None


class Log(tuple[Logged, ...]):
    """What has happened in a run, in order: a table that `cotree simulate --log` writes."""

    __slots__ = ()

    @classmethod
    def of(cls, rows: Iterable[tuple[float, str, str, float | None]]) -> Log:
        """From the rows that the program hands over."""
        return cls(Logged(*row) for row in rows)

    def columns(self) -> dict[str, np.ndarray]:
        """The table by its columns; what has no impulse is not a number there."""
        kinds = {"time": float, "name": str, "what": str, "impulse": float}
        return {name: np.array([getattr(row, name) for row in self], dtype=kind) for name, kind in kinds.items()}

    def to_pandas(self) -> pandas.DataFrame:
        """A data frame with a row for each."""
        import pandas

        return pandas.DataFrame(self.columns())

    def to_polars(self) -> polars.DataFrame:
        """A data frame with a row for each."""
        import polars

        return polars.DataFrame(self.columns())

    @overload
    def to_csv(self, path: None = None) -> str: ...
    @overload
    def to_csv(self, path: str | os.PathLike[str]) -> None: ...
    def to_csv(self, path: str | os.PathLike[str] | None = None) -> str | None:
        """The table as CSV: a text, or a file."""
        return to_csv(self.columns(), path)

    def _repr_html_(self) -> str:
        return table(counted(len(self), "event"), ["time [s]", "name", "what", "impulse"], list(self))


class Results(Mapped):
    """The reported variables of a run: `results["rod.angle"]` is an array with a value for each of `results.time`, which cannot be changed.

    `units` has their SI units ("" where there is none or none is known). `parameters` is what the run was given beyond the scene's values.
    `failure` says why the run ended early, if it did; the values are those before. `ended` is the event of the scene that has ended it, at the last time, if one has.
    `log` is what has happened: events, impacts, what limits, contacts, ropes and frictions have done.
    """

    def __init__(
        self,
        time: np.ndarray,
        names: Sequence[str],
        units: Sequence[str],
        values: np.ndarray,
        failure: str | None = None,
        parameters: Mapping[str, float] | None = None,
        ended: str | None = None,
        log: Iterable[Logged] = (),
    ) -> None:
        self.time = fixed(time)
        self._values = fixed(values)
        self._places = {name: place for place, name in enumerate(names)}
        self.units: dict[str, str] = dict(zip(names, units, strict=True))
        self.failure = failure
        self.ended = ended
        self.log = Log(log)
        self.parameters: dict[str, float] = dict(parameters or {})

    @overload
    def __getitem__(self, name: str) -> np.ndarray: ...
    @overload
    def __getitem__(self, name: slice) -> Results: ...
    def __getitem__(self, name: str | slice) -> np.ndarray | Results:
        if isinstance(name, slice):
            return self._rows(by_index(name, "results", "`between` takes times"))
        if name == "time" and name not in self._places:
            return self.time
        if name not in self._places:
            known = ", ".join(self._places) or "nothing"
            raise KeyError(f"{name!r} was not reported; there is {known}")
        return self._values[:, self._places[name]]

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Results):
            return NotImplemented
        mine, others = ((own.units, own.time, own._values, own.failure, own.ended, own.log, own.parameters) for own in (self, other))
        return same(mine, others)

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> np.ndarray:
        return np.array(self._values, dtype=dtype) if copy or dtype is not None else self._values

    def _frame(self) -> dict[str, np.ndarray]:
        return _columns(self)

    @overload
    def at(self, time: Value) -> dict[str, float]: ...
    @overload
    def at(self, time: list[Value] | list[float] | tuple[Value, ...] | np.ndarray) -> dict[str, np.ndarray]: ...
    def at(self, time: Any) -> dict[str, float] | dict[str, np.ndarray]:
        """The values at a time [s], linear between the two communication points around it; of several times an array for each variable.

        >>> results.at([0.25, "0.5 s"])["bob.angle"].shape
        (2,)

        Raises ValueError outside the run.
        """
        from ._given import times

        is_one = isinstance(time, str) or np.ndim(time) == 0
        sought = np.array(times("at", time))
        for outside in sought[~((self.time[:1].sum() <= sought) & (sought <= self.time[-1:].sum()))] if len(self.time) else sought:
            raise ValueError(f"at: {outside:g} s is outside the run: {self!r}")
        values = {name: np.interp(sought, self.time, self[name]) for name in self}
        return {name: float(own[0]) for name, own in values.items()} if is_one else values

    def between(self, start: Value | None = None, stop: Value | None = None) -> Results:
        """The communication points from a time [s] up to another one, both among them; None is the end of the run.

        >>> results.between("0.5 s", 1).time[[0, -1]]
        array([0.5, 1. ])
        """
        from ._given import times

        [first] = [-np.inf] if start is None else times("between", start)
        [last] = [np.inf] if stop is None else times("between", stop)
        return self._rows(slice(int(np.searchsorted(self.time, first)), int(np.searchsorted(self.time, last, "right"))))

    def sel(self, time: slice) -> Results:
        """As of xarray, `results.sel(time=slice(0.5, 1))`: see `between`."""
        if not isinstance(time, slice) or time.step is not None:
            raise TypeError(f"sel: {time!r} is not a slice of times, such as slice(0.5, 1); `at` takes single ones")
        return self.between(time.start, time.stop)

    def _rows(self, rows: slice) -> Results:
        """Some of the communication points, with what has happened between them."""
        time = self.time[rows]
        log = [own for own in self.log if len(time) and time.min() <= own.time <= time.max()]
        is_end = bool(len(time)) and time[-1] == self.time[-1]
        end = (self.failure, self.ended) if is_end else (None, None)
        return Results(time, list(self.units), list(self.units.values()), self._values[rows], end[0], self.parameters, end[1], log)

    def __iter__(self) -> Iterator[str]:
        return iter(self._places)

    def __len__(self) -> int:
        return len(self._places)

    def to_numpy(self) -> np.ndarray:
        """All values: a row for each time, a column for each variable."""
        return self._values

    def to_pandas(self) -> pandas.DataFrame:
        """A data frame with `time` [s] as its index; `attrs["units"]` has the units."""
        import pandas

        frame = pandas.DataFrame(self._values, index=pandas.Index(self.time, name="time"), columns=list(self))
        frame.attrs["units"] = dict(self.units)
        return frame

    def to_polars(self) -> polars.DataFrame:
        """A data frame whose first column is `time` [s]."""
        import polars

        return polars.DataFrame(_columns(self))

    def to_xarray(self) -> xarray.Dataset:
        """A data set along `time`; each variable has its unit as the attribute `units`."""
        import xarray

        columns = {name: ("time", self[name], {"units": self.units[name]}) for name in self}
        return xarray.Dataset(columns, coords={"time": ("time", self.time, {"units": "s"})}, attrs=dict(self.parameters))

    @overload
    def to_csv(self, path: None = None) -> str: ...
    @overload
    def to_csv(self, path: str | os.PathLike[str]) -> None: ...
    def to_csv(self, path: str | os.PathLike[str] | None = None) -> str | None:
        """The table that `cotree simulate` writes: a row for each time; a text, or a file."""
        return to_csv(_columns(self), path)

    def summary(self) -> Report:
        """The run in figures, as `cotree simulate --summary` gives them: extremes and when they are, mean, RMS and end of each variable."""
        from ._commands import summary

        return summary(self)

    def plot(
        self, *names: str, x: str = "time", ax: matplotlib.axes.Axes | Sequence[matplotlib.axes.Axes] | None = None
    ) -> Sequence[matplotlib.axes.Axes]:
        """Draws these variables [default: all] over time, or over another one: a pair of axes for each unit, one below the other.

        `ax` are axes to draw into: one for everything, or one for each unit.

        Raises ImportError if matplotlib is not installed, KeyError for what was not reported.
        """
        pyplot = _pyplot()
        along, across = self[x], self._unit(x)
        units: dict[str, list[str]] = {}
        for name in names or self:
            units.setdefault(self._unit(name), []).append(name)
        if not units:
            raise ValueError("plot: there are no variables; name some in `outputs`")
        axes = _axes(pyplot, ax, units)
        shared = len(axes) < len(units)
        for own, (unit, group) in zip(axes * len(units) if shared else axes, units.items(), strict=True):
            for name in group:
                own.plot(along, self[name], label=titled(name, unit) if shared else name)
            if not shared:
                own.set_ylabel(unit)
            own.legend()
        axes[-1].set_xlabel(f"{x} [{across}]" if across else x)
        return axes

    def _repr_html_(self) -> str:
        """A line for each variable: its course in small, its range, its end."""
        heads = ("variable", "unit", "course", "min", "max", "end")
        return table(repr(self)[1:-1], heads, [self._row(name) for name in list(self)[:MOST_ROWS]], len(self))

    def _unit(self, name: str) -> str:
        """The unit of what can be asked for by `[]`; raises KeyError for the rest as that does."""
        _ = self[name]
        return self.units.get(name, "s")

    def _row(self, name: str) -> list[Any]:
        values = self[name]
        figures = [values.min(), values.max(), values[-1]] if len(values) else [""] * 3
        return [name, self.units[name], Markup(_sparkline(values)), *figures]

    def __repr__(self) -> str:
        ended = f", ended early: {self.failure}" if self.failure else ""
        span = f"{self.time[0]:g} s to {self.time[-1]:g} s" if len(self.time) else "no time"
        return f"<Results of {len(self)} variables at {len(self.time)} times, {span}{ended}>"


def _pyplot() -> Any:
    """matplotlib's pyplot, or an error that says how to get it."""
    try:
        import matplotlib.pyplot
    except ModuleNotFoundError as missing:
        if missing.name != "matplotlib":
            raise
        raise ImportError("plot: matplotlib is not installed: pip install matplotlib", name="matplotlib") from None
    return matplotlib.pyplot


def _axes(pyplot: Any, ax: Any, units: Mapping[str, list[str]]) -> list[Any]:
    """New axes, one for each unit, or those that were given."""
    if ax is None:
        _, grid = pyplot.subplots(len(units), 1, sharex=True, squeeze=False, layout="constrained")
        return list(grid[:, 0])
    given = list(np.asarray(ax, dtype=object).flat)
    if len(given) not in (1, len(units)):
        raise ValueError(f"plot: ax: {len(given)} axes for {len(units)} units ({', '.join(unit or '1' for unit in units)}); give one, or one for each unit")
    return given


def by_index(rows: slice, name: str, instead: str) -> slice:
    """A slice that counts; TypeError for one that does not."""
    for end in (rows.start, rows.stop, rows.step):
        if end is not None and not hasattr(end, "__index__"):
            raise TypeError(f"{name}: {end!r} is not an index; {instead}")
    return rows


def _sparkline(values: np.ndarray) -> str:
    """A line of a few points from left to right, between the smallest and the largest value."""
    points = values[np.linspace(0, len(values) - 1, min(len(values), MOST_POINTS)).astype(int)]
    if len(points) < 2 or not np.isfinite(points).all():
        return ""
    height = np.ptp(points)
    heights = 19 - 18 * (points - points.min()) / height if height > 0 else np.full(len(points), 10.0)
    line = " ".join(f"{across:.0f},{up:.1f}" for across, up in zip(np.linspace(1, 119, len(points)), heights, strict=True))
    return f'<svg width="120" height="20"><polyline points="{line}" fill="none" stroke="currentColor"/></svg>'


def _varied(run: Results) -> dict[str, float]:
    """What a run was given, under names that no variable has."""
    return {f"{name} (set)" if name in run else name: value for name, value in run.parameters.items()}


def _failure_column(names: Iterable[str]) -> str:
    """What the column of failures is called, beside columns of these names."""
    return "failure" if "failure" not in names else "failure (run)"


#: So many variables of each of many runs are shown.
MOST_SHOWN = 6


class ResultsList(Sequence[Results]):
    """The results of many runs, in the order that they were asked for."""

    def __init__(self, members: Sequence[Results]) -> None:
        self._members = list(members)

    @overload
    def __getitem__(self, index: int) -> Results: ...
    @overload
    def __getitem__(self, index: slice) -> ResultsList: ...
    def __getitem__(self, index: int | slice) -> Results | ResultsList:
        if isinstance(index, slice):
            return ResultsList(self._members[index])
        return self._members[index]

    def __len__(self) -> int:
        return len(self._members)

    def __eq__(self, other: object) -> bool:
        return self._members == other._members if isinstance(other, ResultsList) else NotImplemented

    __hash__ = None  # type: ignore[assignment]

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> np.ndarray:
        return self.to_numpy().astype(dtype or float, copy=False)

    @property
    def failures(self) -> dict[int, str]:
        """Which runs ended early, and why."""
        return {index: run.failure for index, run in enumerate(self._members) if run.failure}

    def to_numpy(self) -> np.ndarray:
        """All values: run, time, variable. Runs that ended early have no numbers (nan) from there on."""
        longest = max((len(run.time) for run in self._members), default=0)
        width = len(self._members[0]) if self._members else 0
        values = np.full((len(self), longest, width), np.nan)
        for index, run in enumerate(self._members):
            values[index, : len(run.time)] = run.to_numpy()
        return values

    def to_xarray(self) -> xarray.Dataset:
        """A data set along `run` and `time`, each variable with its unit; what was varied is along `run`.

        Times are those of all runs together: a run has no numbers (nan) at those that it has not reached or not reported, such as that of an event that has ended another one. Where
        runs ended early `failure` says why.
        """
        import xarray

        if not self._members:
            return xarray.Dataset(coords={"run": ("run", np.arange(0)), "time": ("time", np.zeros(0), {"units": "s"})})
        time = np.unique(np.concatenate([run.time for run in self._members]))
        values = np.full((len(self), len(time), len(self._members[0])), np.nan)
        for index, run in enumerate(self._members):
            # Two points at one time are a jump: the later one counts.
            values[index, np.searchsorted(time, run.time)] = run.to_numpy()
        columns = {name: (("run", "time"), values[:, :, place], {"units": unit}) for place, (name, unit) in enumerate(self._members[0].units.items())}
        varied = [_varied(run) for run in self._members]
        along: dict[str, Any] = {name: ("run", np.array([own[name] for own in varied])) for name in varied[0]}
        if self.failures:
            along[_failure_column(self._members[0])] = ("run", np.array([run.failure or "" for run in self._members]))
        return xarray.Dataset(columns, coords={"run": ("run", np.arange(len(self))), "time": ("time", time, {"units": "s"}), **along})

    @overload
    def to_csv(self, path: None = None) -> str: ...
    @overload
    def to_csv(self, path: str | os.PathLike[str]) -> None: ...
    def to_csv(self, path: str | os.PathLike[str] | None = None) -> str | None:
        """One long table with `run`, `time`, what was varied, and the variables; a text, or a file."""
        lengths = [len(run.time) for run in self._members]
        columns: dict[str, Any] = {"run": np.repeat(np.arange(len(self)), lengths), "time": np.concatenate([np.zeros(0), *(run.time for run in self._members)])}
        for name in _varied(self._members[0]) if self._members else ():
            columns[name] = np.repeat([_varied(run)[name] for run in self._members], lengths)
        for name in self._members[0] if self._members else ():
            columns[name] = np.concatenate([run[name] for run in self._members])
        return to_csv(columns, path)

    def to_pandas(self) -> pandas.DataFrame:
        """One long data frame with the index (run, time); what was varied stands in columns of its own, and where runs ended early `failure` says why."""
        import pandas

        if not self._members:
            return pandas.DataFrame(index=pandas.MultiIndex.from_arrays([[], []], names=["run", "time"]))
        failure = {_failure_column(self._members[0])} if self.failures else set()
        frames = [
            run.to_pandas().assign(**_varied(run), **{name: pandas.Series(run.failure, run.time, object) for name in failure})
            for run in self._members
        ]
        return pandas.concat(frames, keys=range(len(self)), names=["run"])

    def to_polars(self) -> polars.DataFrame:
        """One long data frame whose first columns are `run` and `time` [s]; what was varied stands in columns of its own, and where runs ended early `failure` says why."""
        import polars

        failure = {_failure_column(self._members[0])} if self.failures else set()
        frames = [
            run.to_polars()
            .with_columns(polars.lit(value).alias(name) for name, value in _varied(run).items())
            .with_columns(polars.lit(run.failure, dtype=polars.String).alias(name) for name in failure)
            .select(polars.lit(index, dtype=polars.Int64).alias("run"), polars.all())
            for index, run in enumerate(self._members)
        ]
        return polars.concat(frames) if frames else polars.DataFrame(schema={"run": polars.Int64, "time": polars.Float64})

    def _repr_html_(self) -> str:
        """A line for each run: what was varied, its end, and why it ended early."""
        if not self._members:
            return table(repr(self)[1:-1], ["run"], [])
        first = self._members[0]
        varied, units = list(_varied(first)), first.units
        heads = ["run", *varied, *(titled(f"last({name})", units[name]) for name in list(first)[:MOST_SHOWN]), "failure"]
        rows = [
            [index, *_varied(run).values(), *(run[name][-1] if len(run.time) else None for name in list(first)[:MOST_SHOWN]), run.failure]
            for index, run in enumerate(self._members[:MOST_ROWS])
        ]
        return table(repr(self)[1:-1], heads, rows, len(self))

    def __repr__(self) -> str:
        return f"<{len(self)} runs, {len(self.failures)} of them ended early>"


class Table(Mapped):
    """A number for each run and measure: `table["max(rod.angle)"]`, and the parameters of the runs by their names.

    `table[10:20]` are some of the runs. `units` has the units of measures and parameters (SI), `axes` of a grid the levels of each parameter, the last one fastest.
    """

    def __init__(
        self,
        parameters: Mapping[str, np.ndarray],
        columns: Sequence[tuple[str, str]],
        values: np.ndarray,
        failures: Sequence[str | None],
        parameter_units: Mapping[str, str] | None = None,
        shape: Sequence[int] | None = None,
    ) -> None:
        values = fixed(values)
        self._measured = [name for name, _ in columns]
        measured = {name: values[:, place] for place, name in enumerate(self._measured)}
        self._columns = {**{name: fixed(own) for name, own in parameters.items()}, **measured}
        self.units: dict[str, str] = {**(parameter_units or {}), **dict(columns)}
        self.axes: dict[str, np.ndarray] | None = None
        if shape is not None:
            self.axes = {name: np.moveaxis(own.reshape(shape), place, -1).reshape(-1, shape[place])[0] for place, (name, own) in enumerate(parameters.items())}
        #: Which runs ended early, and why; their measures are nan.
        self.failures: dict[int, str] = {index: failure for index, failure in enumerate(failures) if failure}
        #: How many runs there are.
        self.runs = len(failures)

    @classmethod
    def joined(cls, tables: Sequence[Table], shape: Sequence[int] | None = None) -> Table:
        """The runs of tables with the same columns, one table after the other; `shape` has the levels of each parameter of a grid."""
        first = tables[0]
        own: dict[str, np.ndarray] = {name: np.concatenate([table[name] for table in tables]) for name in first}
        failures = [table.failures.get(run) for table in tables for run in range(table.runs)]
        return first._of(own, failures, shape)

    def _of(self, columns: Mapping[str, np.ndarray], failures: Sequence[str | None], shape: Sequence[int] | None = None) -> Table:
        """Other runs with the same columns."""
        values = np.stack([columns[name] for name in self._measured], axis=1) if self._measured else np.zeros((len(failures), 0))
        varied = {name: column for name, column in columns.items() if name not in self._measured}
        units = {name: self.units[name] for name in varied if name in self.units}
        return Table(varied, [(name, self.units[name]) for name in self._measured], values, failures, units, shape)

    @overload
    def __getitem__(self, name: str) -> np.ndarray: ...
    @overload
    def __getitem__(self, name: slice) -> Table: ...
    def __getitem__(self, name: str | slice) -> np.ndarray | Table:
        if isinstance(name, slice):
            runs = range(self.runs)[by_index(name, "table", "name a column, or count runs")]
            return self._of({own: column[name] for own, column in self._columns.items()}, [self.failures.get(run) for run in runs])
        if name not in self._columns:
            raise unknown(name, self._columns, "is no column of the table")
        return self._columns[name]

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Table):
            return NotImplemented
        mine, others = ((own._columns, own.units, own.failures, own.axes) for own in (self, other))
        return same(mine, others)

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> np.ndarray:
        columns = list(self._columns.values())
        return np.array(np.stack(columns, axis=1) if columns else np.zeros((self.runs, 0)), dtype=dtype)

    def __iter__(self) -> Iterator[str]:
        return iter(self._columns)

    def __len__(self) -> int:
        return len(self._columns)

    def _frame(self) -> dict[str, Any]:
        """All columns of a frame; where runs have failed the reasons among them."""
        reasons = [self.failures.get(run) for run in range(self.runs)]
        return {**self._columns, **({_failure_column(self._columns): reasons} if self.failures else {})}

    def to_pandas(self) -> pandas.DataFrame:
        """A data frame with a row for each run; where runs have failed `failure` says why."""
        import pandas

        frame = pandas.DataFrame(self._frame(), index=pandas.RangeIndex(self.runs, name="run"))
        frame.attrs["units"] = dict(self.units)
        return frame

    def to_polars(self) -> polars.DataFrame:
        """A data frame with a row for each run; where runs have failed `failure` says why."""
        import polars

        return polars.DataFrame(self._frame())

    def to_xarray(self) -> xarray.Dataset:
        """A data set of the measures with their units: of a grid, as `sweep` makes it, along each of its parameters; else along `run`, with the parameters along it. Where runs have failed
        `failure` says why.

        >>> grid = model.sweep("max(bob.angle)", {"length": [0.5, 1.0, 2.0]}, stop=0.1)
        >>> dict(grid.to_xarray().sizes)
        {'length': 3}
        """
        import xarray

        reasons = np.array([self.failures.get(run, "") for run in range(self.runs)])
        if self.axes is not None:
            along, shape = tuple(self.axes), tuple(map(len, self.axes.values()))
            coordinates: dict[str, Any] = {name: (name, levels, self._attributes(name)) for name, levels in self.axes.items()}
        else:
            along, shape = ("run",), (self.runs,)
            varied = [name for name in self._columns if name not in self._measured]
            coordinates = {"run": ("run", np.arange(self.runs)), **{name: ("run", self[name], self._attributes(name)) for name in varied}}
        if self.failures:
            coordinates[_failure_column(self._columns)] = (along, reasons.reshape(shape))
        measures = {name: (along, self[name].reshape(shape), self._attributes(name)) for name in self._measured}
        return xarray.Dataset(measures, coords=coordinates)

    def _attributes(self, name: str) -> dict[str, str]:
        return {"units": self.units[name]} if name in self.units else {}

    @overload
    def to_csv(self, path: None = None) -> str: ...
    @overload
    def to_csv(self, path: str | os.PathLike[str]) -> None: ...
    def to_csv(self, path: str | os.PathLike[str] | None = None) -> str | None:
        """The table that `cotree sweep` writes: a row for each run with its number, headings with units, why it has failed; a text, or a file."""
        reasons = [self.failures.get(run) for run in range(self.runs)]
        columns = {titled(name, self.units.get(name, "")): column for name, column in self._columns.items()}
        return to_csv({"run": np.arange(self.runs), **columns, _failure_column(self._columns): reasons}, path)

    def _repr_html_(self) -> str:
        heads = ["run", *(titled(name, self.units.get(name, "")) for name in self), *(["failure"] if self.failures else [])]
        shown = range(min(self.runs, MOST_ROWS))
        rows = [[run, *(column[run] for column in self._columns.values()), *([self.failures.get(run)] if self.failures else [])] for run in shown]
        return table(repr(self)[1:-1], heads, rows, self.runs)

    def __repr__(self) -> str:
        return f"<Table of {self.runs} runs: {', '.join(self)}>"


def frame(page: str, height: int) -> str:
    """A page inside a notebook, with nothing of the notebook inside the page."""
    return (
        f'<iframe srcdoc="{html.escape(page)}" style="width:100%;height:{height}px;border:0" '
        'sandbox="allow-scripts" title="mechanism"></iframe>'
    )


def formulas(document: str) -> str:
    """The formulas of a document in LaTeX, in the form that notebooks show: the coordinates by their numbers, then every group of equations."""
    rows = re.findall(r"^\$(q_\{\d+\})\$ & \$(.*?)\$ &", document, re.MULTILINE)
    coordinates = [r"\begin{align*}" + r" \\ ".join(f"{name} &= {symbol}" for name, symbol in rows) + r"\end{align*}"] if rows else []
    return "\n\n".join(coordinates + re.findall(r"\\begin\{align\*\}.*?\\end\{align\*\}", document, re.DOTALL))


#: Reads texts with units: the values of a name as numbers.
Reader = Callable[[str, list[Any]], list[float]]


def parameters(given: Any, read: Reader) -> tuple[list[str], np.ndarray]:
    """Names and a row of numbers for each run, from a data frame, a mapping of arrays, or a sequence of mappings."""
    if hasattr(given, "columns") and hasattr(given, "to_numpy"):
        names = [str(name) for name in given.columns]
        again = sorted({name for name in names if names.count(name) > 1})
        if again:
            raise ValueError(f"parameters: {', '.join(again)} given by more than one column")
        columns = [_numbers(name, given[own], read) for name, own in zip(names, given.columns, strict=True)]
        return _table(names, columns, len(given))
    if isinstance(given, Mapping):
        names = [str(name) for name in given]
        columns = [_numbers(name, values, read) for name, values in zip(names, given.values(), strict=True)]
        lengths = {len(column) for column in columns} - {1} or ({1} if columns else {0})
        if len(lengths) > 1:
            each = ", ".join(f"{name!r} {len(column)}" for name, column in zip(names, columns, strict=True))
            raise ValueError(f"parameters: the lists differ in length: {each}")
        [rows] = lengths
        return _table(names, [np.broadcast_to(column, rows) for column in columns], rows)
    try:
        runs = list(given)
    except TypeError:
        runs = [None]
    if not all(isinstance(run, Mapping) for run in runs):
        raise TypeError("parameters: give a data frame, a mapping of names to arrays, or a list of mappings")
    names = list(dict.fromkeys(name for run in runs for name in run))
    missing = {name for name in names if any(name not in run for run in runs)}
    if missing:
        raise ValueError(f"parameters: {', '.join(sorted(missing))} not given in every run")
    return _table([str(name) for name in names], [_numbers(str(name), [run[name] for run in runs], read) for name in names], len(runs))


def _numbers(name: str, values: Any, read: Reader) -> np.ndarray:
    """A column of finite numbers."""
    listed = [values] if isinstance(values, str) else values if np.ndim(values) == 1 else None
    if listed is not None and any(isinstance(value, str) for value in listed):
        try:
            return np.array(read(name, list(listed)))
        except (TypeError, ValueError) as error:
            raise ValueError(f"parameters: {name!r} has values that are no numbers: {error}") from None
    try:
        raw = np.atleast_1d(np.asarray(values))
        if raw.dtype.kind in "mM":
            raise TypeError(raw.dtype)
        if raw.dtype.kind == "b" or (raw.dtype.kind == "O" and any(isinstance(value, bool | np.bool_) for value in raw.flat)):
            raise TypeError("truth values")
        column = np.asarray(raw, dtype=float)
    except (TypeError, ValueError):
        raise ValueError(f"parameters: {name!r} has values that are no numbers; give them in SI units, or texts with units") from None
    if column.ndim != 1:
        raise ValueError(f"parameters: {name!r} is to be one number or a list of numbers")
    for run in np.flatnonzero(~np.isfinite(column))[:1]:
        raise ValueError(f"parameters: {name!r} of run {run} is {column[run]}, not a finite number")
    return column


def _table(names: list[str], columns: Sequence[np.ndarray], rows: int) -> tuple[list[str], np.ndarray]:
    return names, np.ascontiguousarray(np.stack(columns, axis=1) if columns else np.zeros((rows, 0)))
