"""What the command does beside runs and studies: reports, drawings, films, FMUs, sweeps, optima."""

from __future__ import annotations

import csv
import html
import io
import json
import os
import warnings
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, Unpack, overload

import numpy as np

from . import _cotree
from . import _given as given
from ._faults import RunError, raised, unknown
from ._given import RunOptions, Value
from ._pieces import Stored, mark, steps, stored
from ._progress import Progress, reporting
from ._results import Compared, Results, Table
from ._show import Drawing

if TYPE_CHECKING:
    import pandas

    from ._model import Model

#: A table in memory has no more numbers than this: eight gigabytes.
MOST_NUMBERS = 2**30

#: So many points of a motion with inputs over time are shown by a film.
FILM_POINTS = 1921

#: What the Rust part hands over: JSON, text, table, picture.
Told = tuple[str, str, str, str | None]


class Report(Mapping[str, Any]):
    """What a command finds: `report["range"]` is a part of its JSON, SI; `str(report)` is what it prints, `csv` its table, `picture` its picture (SVG), if it has one."""

    def __init__(self, told: Told) -> None:
        data, self.text, self.csv, picture = told
        self.picture: Drawing | None = None if picture is None else Drawing(picture)
        self.data: dict[str, Any] = json.loads(data)

    def __getitem__(self, name: str) -> Any:
        if name not in self.data:
            raise unknown(name, self.data, "is not in the report")
        return self.data[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self.data)

    def __len__(self) -> int:
        return len(self.data)

    def __str__(self) -> str:
        return self.text

    def __repr__(self) -> str:
        return f"<{type(self).__name__}: {', '.join(self)}>"

    def __eq__(self, other: object) -> bool:
        mine, others = ((type(own), getattr(own, "data", None), getattr(own, "text", None), getattr(own, "csv", None)) for own in (self, other))
        return mine == others

    __hash__ = None  # type: ignore[assignment]

    def _ipython_key_completions_(self) -> list[str]:
        return list(self)

    def columns(self) -> dict[str, np.ndarray]:
        """The table by its columns, SI; what is not a number is a text."""
        head, *rows = csv.reader(io.StringIO(self.csv)) if self.csv.strip() else [[]]
        return {name: _column([row[place] for row in rows]) for place, name in enumerate(head)}

    def to_pandas(self) -> pandas.DataFrame:
        """The table as a data frame."""
        import pandas

        return pandas.DataFrame(self.columns())

    def _repr_html_(self) -> str:
        return f"<pre>{html.escape(self.text)}</pre>{self.picture or ''}"


def _column(texts: list[str]) -> np.ndarray:
    try:
        return np.array([float(text) if text else np.nan for text in texts])
    except ValueError:
        return np.array(texts)


class Best(Report):
    """The best values that `optimize` has found: `best.optimum["rod"]` is one of them, SI; `model` is the model with them."""

    def __init__(self, told: Told, origin: Model, settings: Mapping[str, Any]) -> None:
        super().__init__(told)
        self.optimum: dict[str, float] = {own["name"]: own["value"] for own in self["quantities"]}
        self._origin, self._set = origin, dict(settings)

    @property
    def model(self) -> Model:
        """The model with what was set and the best values."""
        return self._origin.replace({**self._set, **self.optimum})


@dataclass(frozen=True)
class Assembly:
    """An assembly mode: positions and angles by name, SI, and how many starts led to it; `own` if it is that of the scene."""

    values: dict[str, float]
    found: int
    own: bool


@dataclass(frozen=True, eq=False)
class Profile(Compared):
    """The outline of a cam in its own axes with the shaft as origin: `contact` and the curve of the follower's point, `pitch`, are (angle, xy) [m] at the cam's `angle` [rad]."""

    angle: np.ndarray = field(repr=False)
    contact: np.ndarray = field(repr=False)
    pitch: np.ndarray = field(repr=False)


def dxf(curves: Mapping[str, np.ndarray]) -> str:
    """Curves as a drawing for CAD: names, and places (point, xy) [m]."""
    with raised():
        return _cotree.curves([(name, np.asarray(places, dtype=float).tolist()) for name, places in curves.items()])


def png(svg: str, *, width: int = 1280) -> bytes:
    """A picture as PNG, so many pixels wide."""
    with raised():
        return _cotree.png(svg, float(width))


def summary(results: Results) -> Report:
    """A run in figures."""
    columns = [(name, results.units[name], results[name].tolist()) for name in results]
    with raised():
        return Report(_cotree.summary(results.time.tolist(), columns))


class Commands:
    """What a model can be asked as on the command line."""

    _core: _cotree.Core
    name: Any
    replace: Any

    def export(
        self,
        path: str | os.PathLike[str] | None = None,
        *,
        fmi: int | str = 2,
        all: bool = False,
        platforms: str | Sequence[str] = (),
        runtimes: str | os.PathLike[str] | None = None,
        lean: bool = False,
    ) -> Path:
        """Writes the scene as an FMU, FMI 2.0 or 3.0 [default: the scene's name, .fmu, in the current folder]; returns its path.

        >>> model.export("pendulum.fmu", fmi=3).name
        'pendulum.fmu'

        With `all` it has every variable. It is for this platform, or for others, such as "win64", whose runtimes lie in the folder `runtimes`
        (tools/build-runtimes.sh makes them). Its page has the solver for browsers where the package has it, unless it is to be `lean`.

        Raises SceneError, ValueError for a platform that there is not, OSError.
        """
        target = Path(f"{self.name}.fmu") if path is None else Path(path)
        names = given.names("platforms", platforms)
        with raised():
            _cotree.export(self._core, target, str(fmi).removesuffix(".0"), names, _folder(runtimes), (all, lean))
        return target

    def page(self, *, runtimes: str | os.PathLike[str] | None = None, served: bool = True) -> str:
        """A page for a browser that shows the mechanism in motion, with plots and sliders.

        It has the solver inside where the package, or the folder `runtimes`, has that for browsers. Otherwise this process is its solver, for pages in files and notebooks of this machine and
        as long as it lasts, and afterwards the page plays the run that is stored in it; with `served=False` it does so at once.
        """
        with raised():
            return self._core.page(_folder(runtimes), served)

    @overload
    def drawing(self, at: Value | None = None, *, set: Mapping[str, Value] | None = None, format: Literal["svg"] = "svg") -> Drawing: ...
    @overload
    def drawing(self, at: Value | None = None, *, set: Mapping[str, Value] | None = None, format: str) -> str: ...
    def drawing(self, at: Value | None = None, *, set: Mapping[str, Value] | None = None, format: str = "svg") -> str:
        """The mechanism at its start, or at a time [s]: as SVG, which a notebook shows, or for CAD ("dxf")."""
        time = None if at is None else given.times("at", at)[0]
        with raised():
            return _drawn(_cotree.drawing(self._core, time, given.settings(set), format), format)

    @overload
    def graph(self, *, format: Literal["svg"] = "svg") -> Drawing: ...
    @overload
    def graph(self, *, format: str) -> str: ...
    def graph(self, *, format: str = "svg") -> str:
        """The linear graphs with their trees: as SVG, or for Graphviz ("dot")."""
        with raised():
            return _drawn(_cotree.graph(self._core, format), format)

    @property
    def film_variables(self) -> list[str]:
        """The variables that a film shows: where the bodies are, paths of points, and what marks parts that hold or strike.

        >>> model.film_variables[:3]
        ['bob.x', 'bob.y', 'bob.angle']
        """
        with raised():
            poses, others = _cotree.film_variables(self._core)
        return [*poses, *others]

    def film(
        self,
        results: Any = None,
        *,
        speed: float = 1.0,
        start: Value | None = None,
        stop: Value | None = None,
        set: Mapping[str, Value] | None = None,
        inputs: Any = None,
    ) -> Drawing:
        """A picture that moves by itself (SVG), with so many seconds of the mechanism in one, from `start` to `stop` [s], with parameters, constant inputs and initial values that are `set` and with
        `inputs` over time, as `simulate` takes them.

        Or of `results`: what a run has given, or a data frame or mapping with "time", such as the rows that a controller has seen.

        >>> seen = model.simulate(outputs=model.film_variables, stop=1)
        >>> model.film(seen, speed=0.5).startswith("<svg")
        True

        Lengths are those of the scene and of `set`. Where the motion ends early it has what comes before, and a RuntimeWarning says why. Raises ValueError where results lack a variable.
        """
        film, _ = self._filmed(results, inputs, (start, stop, set), speed, None)
        return Drawing(film)

    def frames(
        self,
        results: Any = None,
        *,
        fps: float = 25.0,
        speed: float = 1.0,
        width: int = 1280,
        start: Value | None = None,
        stop: Value | None = None,
        set: Mapping[str, Value] | None = None,
        inputs: Any = None,
    ) -> list[bytes]:
        """The pictures of a film, PNG; as `film` otherwise."""
        _, frames = self._filmed(results, inputs, (start, stop, set), speed, (fps, float(width)))
        return frames

    def _filmed(
        self,
        results: Any,
        inputs: Any,
        scene: tuple[Value | None, Value | None, Mapping[str, Value] | None],
        speed: float,
        pictures: tuple[float, float] | None,
    ) -> tuple[str, list[bytes]]:
        start, stop, set = scene
        cut = None
        if results is not None:
            if any(own is not None for own in (start, stop, inputs)):
                raise TypeError("film: results have their own times and inputs; `results.between(start, stop)` is a part of them")
            set = {**(getattr(results, "parameters", None) or {}), **dict(given.settings(set))}
        model = self._set_to(set, start, stop)
        if results is None and inputs is not None:
            results, cut = model._motion(inputs)
        with raised():
            motion = None if results is None else model._shown(results)
            film, frames, own = _cotree.filmed(model._core, motion, speed, pictures)
        if cut or own:
            warnings.warn(cut or own or "", RuntimeWarning, stacklevel=3)
        return film, frames

    def _motion(self: Model, inputs: Any) -> tuple[Results, str | None]:  # type: ignore[misc]
        """A run that shows all that a film does, and why it ends early if it does. Functions are called at the communication points of the scene."""
        with raised():
            points = self._core.points(given.Times(None, None, None, None))
        times = None if given.laws(inputs) else np.linspace(points[0], points[-1], FILM_POINTS)
        try:
            seen = self.simulate(outputs=self.film_variables, times=times, inputs=inputs)
        except RunError as error:
            if error.results is None or not len(error.results.time):
                raise
            return error.results, f"{error}; the film has what comes before"
        return seen, f"event `{seen.ended}` has ended the run; the film has what comes before" if seen.ended else None

    def _shown(self, results: Any) -> given.Columns | None:
        """What a film shows of results."""
        columns = given.inputs(results, "results")
        poses, others = _cotree.film_variables(self._core)
        if columns is None:
            return None
        times, names, values = columns
        for name in poses:
            if name not in names:
                raise ValueError(f"results: there is no {name!r}; `simulate(outputs=model.film_variables)` has all that a film shows")
        kept = [(name, column) for name, column in zip(names, values, strict=True) if name in {*poses, *others}]
        return times, [name for name, _ in kept], [column for _, column in kept]

    def _set_to(self, set: Mapping[str, Value] | None, start: Value | None, stop: Value | None) -> Model:
        """The model with these values and times in place of its own."""
        times = {f"experiment.{name}": time for name, time in (("start", start), ("stop", stop)) if time is not None}
        for name, time in times.items():
            given.check_value(name.removeprefix("experiment."), time)
        values = {**dict(given.settings(set)), **{name: given.duration(time) for name, time in times.items()}}
        model: Model = self  # type: ignore[assignment]
        return model.replace(values) if values else model

    def motion(
        self,
        input: str | None = None,
        output: str | None = None,
        *,
        speed: Value | None = None,
        range: tuple[Value, Value] | None = None,
        every: Value | None = None,
        point: str | None = None,
        dwell: Value | None = None,
        fluctuation: float | None = None,
        set: Mapping[str, Value] | None = None,
    ) -> Report:
        """What the mechanism does in one turn or stroke of its input: range, limits, transmission, drive, reactions, shaking, cams; with a row of its table for `every` so much.

        >>> turn = bar.motion("crank_pivot", every="30 deg")
        >>> turn["input"]["name"]
        'crank_pivot'

        `input` is the joint that is driven, `output` what is of interest, `speed` that of the input, `range` from where to where; `point` is one whose path is of interest,
        `dwell` how near an end of its stroke the output is to stay, `fluctuation` that of the speed for a flywheel. Raises SceneError, ValueError, RunError.
        """
        with raised():
            told = _cotree.turned(
                self._core, (input, output, point), speed, range, every, dwell, fluctuation, given.settings(set)
            )
        return Report(told)

    def assemblies(self, *, starts: int = 200, set: Mapping[str, Value] | None = None) -> list[Assembly]:
        """The assembly modes, from so many starts, the scene's first; raises RunError if configurations are not isolated."""
        with raised():
            found = json.loads(_cotree.assemblies(self._core, starts, given.settings(set)))
        if found["continuous"]:
            raise RunError(f"more than {len(found['poses']) - 1} configurations: they are not isolated")
        each = enumerate(zip(found["poses"], found["found"], strict=True))
        return [Assembly({**found["held"], **pose}, count, bool(found["own"] and index == 0)) for index, (pose, count) in each]

    def profile(self, cam: str, *, points: int = 720, set: Mapping[str, Value] | None = None) -> Profile:
        """The outline of a cam, by the name of its joint. Raises ValueError where there is no such cam."""
        with raised():
            return Profile(*_cotree.profile(self._core, cam, points, given.settings(set)))

    def compare(self) -> Report:
        """What other trees would cost, as `cotree show --compare` says it."""
        with raised():
            return Report(_cotree.comparison(self._core))

    def _measured(
        self,
        measures: str | Sequence[str],
        runs: tuple[list[str], np.ndarray | _cotree.Runs],
        asked: given.Asked,
        threads: int,
        to: str | os.PathLike[str] | None,
        resume: bool,
        progress: Progress | None,
        shape: Sequence[int] | None = None,
    ) -> Table | Stored:
        """Measures of runs: names, and a row of values for each run. The table, or where it is stored; `shape` has the levels of each name of a grid."""
        (names, values), sought, inputs = runs, given.names("measures", measures), given.inputs(asked.inputs)
        workers = given.threads(threads)
        with raised():
            units = dict(zip(names, self._core.units(names), strict=True))

        def part(begin: int, end: int) -> Table:
            own = np.ascontiguousarray(values[begin:end] if isinstance(values, np.ndarray) else values.rows(begin, end))
            with raised():
                columns, table, failures = self._core.measure(
                    asked.times, asked.settings, sought, inputs, names, own, workers
                )
            return Table({name: own[:, place] for place, name in enumerate(names)}, columns, table, failures, units)

        if to is None and len(values) * (len(names) + len(sought)) > MOST_NUMBERS:
            raise ValueError(f"{len(values)} runs do not fit into memory as a table; name a folder in `to`, such as \"runs.parquet\"")
        if to is None and resume:
            raise ValueError("resume: there is nothing to go on with; name the folder in `to`")
        with reporting(progress) as report:
            if to is not None:
                rows = values if isinstance(values, np.ndarray) else (len(values), values.digest())
                own = mark([text for _, text in self._core.files()], sought, names, rows, asked.times.given(), asked.settings, inputs)
                return stored(Path(to), own, len(values), part, resume, report)
            if report is None:
                tables = [part(0, len(values))]
            else:
                tables = [part(0, 0), *(table for _, table in steps(len(values), 0, part, report))]
        return tables[0] if len(tables) == 1 and shape is None else Table.joined(tables, shape)

    @overload
    def sweep(
        self,
        measures: str | Sequence[str],
        values: Mapping[str, Value | Sequence[Value]],
        *,
        random: int | None = None,
        latin: int | None = None,
        seed: int = 0,
        times: Value | Iterable[Value] | None = None,
        threads: int = 0,
        to: None = None,
        resume: bool = False,
        progress: Progress | None = None,
        **run: Unpack[RunOptions],
    ) -> Table: ...
    @overload
    def sweep(
        self,
        measures: str | Sequence[str],
        values: Mapping[str, Value | Sequence[Value]],
        *,
        random: int | None = None,
        latin: int | None = None,
        seed: int = 0,
        times: Value | Iterable[Value] | None = None,
        threads: int = 0,
        to: str | os.PathLike[str],
        resume: bool = False,
        progress: Progress | None = None,
        **run: Unpack[RunOptions],
    ) -> Stored: ...
    @given.spelled_out
    def sweep(
        self,
        measures: str | Sequence[str],
        values: Mapping[str, Value | Sequence[Value]],
        *,
        random: int | None = None,
        latin: int | None = None,
        seed: int = 0,
        times: Value | Iterable[Value] | None = None,
        threads: int = 0,
        to: str | os.PathLike[str] | None = None,
        resume: bool = False,
        progress: Progress | None = None,
        **run: Unpack[RunOptions],
    ) -> Table | Stored:
        """As `measure`, of the runs that `cotree sweep` makes: all combinations of `values`, which are written as there ("0.4..0.6:21", "1,1.2 m"), or lists; with `random` or `latin`,
        a number of runs, values are drawn, also from ranges ("0.4..0.6", "0.5+-2%", "0.5~0.01").

        >>> grid = model.sweep("max(bob.angle)", {"length": "0.5..1:3", "bob.angle": ["10 deg", "20 deg"]}, stop=1)
        >>> grid.runs, grid.axes["length"]
        (6, array([0.5 , 0.75, 1.  ]))
        """
        if random is not None and latin is not None:
            raise ValueError("random, latin: give one of them")
        drawn = (False, random) if random is not None else (True, latin) if latin is not None else None
        with raised():
            factors = [f"{name}={self._levels(name, own)}" for name, own in values.items()]
            runs = _cotree.design(self._core, factors, drawn, seed)
        return self._measured(measures, (runs.names(), runs), given.asked("sweep", run, times), threads, to, resume, progress, runs.shape())

    def _levels(self, name: str, values: Any) -> str:
        """Values as the command reads them; each of a list may have a unit of its own."""
        if isinstance(values, str):
            return values
        listed = list(values) if isinstance(values, Sequence | np.ndarray) else [values]
        for value in listed:
            given.check_value(f"values: {name}", value)
        return ",".join(map(repr, self._core.numbers(name, listed)))

    @given.spelled_out
    def optimize(
        self,
        vary: str | Sequence[str] | Mapping[str, tuple[Value | None, Value | None] | None],
        *,
        minimize: str | None = None,
        maximize: str | None = None,
        match: Any = None,
        subject_to: str | Sequence[str] = (),
        turn: str | None = None,
        of: str | None = None,
        starts: int | None = None,
        seed: int = 0,
        threads: int = 0,
        progress: Progress | None = None,
        **run: Unpack[RunOptions],
    ) -> Best:
        """The best values of parameters, constant inputs and initial values, by many searches with exact derivatives, as `cotree optimize` finds them.

        >>> best = model.optimize({"length": (0.5, 2.0)}, minimize="last(bob.angle)", starts=2, stop=0.5)
        >>> sorted(best.optimum)
        ['length']

        `vary` are names, or a mapping of names to their bounds; a measure such as "peak(pivot.torque)" is made small or large, or columns over time are to be matched (as those of `fit`);
        `subject_to` are limits such as "max(ram.s) <= 3 mm". With `turn`, a joint, the measures are figures of one turn of it, and `of` is what is of interest there.
        Raises SceneError, ValueError, RunError where no values meet the limits.
        """
        aims = {"minimize": minimize, "maximize": maximize, "match": match}
        sought = [name for name, aim in aims.items() if aim is not None]
        if len(sought) != 1:
            raise ValueError("give one of minimize, maximize, match")
        [aim] = sought
        goal, table = (None, given.inputs(match, "match")) if aim == "match" else (_goal(aim, aims[aim]), None)
        asked = given.asked("optimize", run, inputs="its runs have constant inputs; give them by `set`, or use `value_and_gradient` with scipy.optimize")
        # As on the command line: searches of a turn take longer.
        searches = starts if starts is not None else 64 if turn is None else 8
        with reporting(progress) as report, raised():
            told = _cotree.optimized(
                self._core,
                asked.times,
                asked.settings,
                given.varied(vary),
                (aim, goal, table),
                given.names("subject_to", subject_to),
                None if turn is None else (turn, of),
                (searches, seed, given.threads(threads)),
                report,
            )
        return Best(told, self, dict(asked.settings))  # type: ignore[arg-type]


def _goal(aim: str, goal: Any) -> str:
    """A measure, as a text."""
    if not isinstance(goal, str):
        own = "; a function of your own goes to an optimiser such as scipy.optimize, with the derivatives of `value_and_gradient`"
        raise TypeError(
            f'{aim}: {goal!r} is not a measure: give a text such as "max(rod.angle)"{own if callable(goal) else ""}'
        )
    return goal


def _folder(runtimes: str | os.PathLike[str] | None) -> str | None:
    """A folder of runtimes: that which is given, else the package's if it has one."""
    own = Path(__file__).parent / "runtimes"
    return os.fspath(runtimes) if runtimes is not None else os.fspath(own) if own.is_dir() else None


def _drawn(text: str, format: str) -> str:
    """A picture that notebooks show, or a text for another program."""
    return Drawing(text) if format == "svg" else text
