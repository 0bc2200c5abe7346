"""A mechanism, read from a scene: what can be asked of it."""

from __future__ import annotations

import inspect
import json
import numbers
import os
import tomllib
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Unpack, overload

import numpy as np

from . import _cotree
from . import _given as given
from ._faults import Fault, RunError, faults, raised
from ._commands import Commands
from ._given import Number, RunOptions, Value
from ._gradient import course, measured, reduced
from ._pieces import Stored, steps_of
from ._progress import Progress, reporting
from ._results import Log, Results, ResultsList, Table, formulas, frame, parameters
from ._run import Run
from ._studies import Equilibrium, Experiment, Fit, Mode, Modes, Peak, Sensitivities, StateSpace, fitted, sensitivities

if TYPE_CHECKING:
    from ._build import Builder

#: More numbers are not kept of many runs, unless it is asked for: a gigabyte.
MOST_VALUES = 2**27


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


def from_dict(scene: Mapping[str, Any], *, folder: str | os.PathLike[str] | None = None) -> Model:
    """Makes a scene of nested dictionaries with the keys of the scene file; files of parts and tables are looked for in `folder` [default: the current one].

    Raises SceneError with everything that is wrong with the scene, TypeError for what JSON cannot hold.
    """
    name = "scene.json" if folder is None else os.path.join(os.fspath(folder), "scene.json")
    return Model(json.dumps(scene, indent=2, default=plain), name)


def plain(value: Any) -> Any:
    """Numbers and arrays of numpy as those of Python."""
    if isinstance(value, (np.ndarray, np.generic)):
        return value.tolist()
    raise TypeError(f"{type(value).__name__} cannot be written as JSON")


def _restored(text: bytes, name: str, files: list[tuple[str, str]]) -> Model:
    """The model that was read from these files, whatever became of them since."""
    with raised():
        return _of_core(text, name, _cotree.Core.restored(files))


def _of_core(text: bytes, name: str, core: _cotree.Core) -> Model:
    model = Model.__new__(Model)
    model._text, model._name, model._core = text, name, core
    return model


class Model(Commands):
    """A mechanism. It does not change; settings are given with each call, and `replace` gives another one.

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

    def __reduce__(self) -> tuple[Any, ...]:
        return _restored, (self._text, self._name, self._core.files())

    def __eq__(self, other: object) -> bool:
        """The same text, and the same files of parts and tables."""
        if not isinstance(other, Model):
            return NotImplemented
        mine, others = self._core.files(), other._core.files()
        return self._text == other._text and mine[1:] == others[1:]

    def __hash__(self) -> int:
        return hash(self._text)

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

    def to_dict(self) -> dict[str, Any]:
        """The scene as nested dictionaries with the keys of the scene file."""
        text = self.text.removeprefix("\ufeff")
        is_json = self._name.lower().endswith(".json") or text.lstrip().startswith("{")
        scene: dict[str, Any] = json.loads(text) if is_json else tomllib.loads(text)
        return scene

    def builder(self) -> Builder:
        """A builder with this scene, to add to it: `model.builder().output("rod.vx").model(folder)`.

        >>> "bob.omega" in model.builder().output("bob.omega").model().variables
        True
        """
        from ._build import Builder

        return Builder.of(self)

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Writes the scene as it is, with the files of its parts and tables beside it; returns its path.

        Raises ValueError where one of these files is not in the scene's folder, FileExistsError where another file is in its place.
        """
        target, folder = Path(path), Path(self._name).absolute().parent
        beside = []
        for name, text in self._core.files()[1:]:
            own = Path(os.path.normpath(Path(name).absolute()))
            if not own.is_relative_to(os.path.normpath(folder)):
                raise ValueError(f"save: {name} is not in the folder of the scene, {folder}")
            place = target.parent / own.relative_to(os.path.normpath(folder))
            if not place.exists():
                beside.append((place, text))
            elif place.read_bytes() != text.encode():
                raise FileExistsError(f"save: {place} is there already and has other text than {name}, which the scene uses")
        for place, text in beside:
            place.parent.mkdir(parents=True, exist_ok=True)
            place.write_bytes(text.encode())
        target.write_bytes(self._text)
        return target

    def replace(self, changes: Mapping[str, Any]) -> Model:
        """The model with other values in its scene, whose other text stays as it is: of parameters, inputs, initial values and signals by their names, of keys of bodies,
        joints, drivers and loads such as "rod.mass", of others by their whole path such as "experiment.stop". A key that the scene does not write is added to its table.

        >>> model.replace({"length": "2 m", "bob.mass": 3.0}).variables["length"].start
        2.0

        Numbers are in SI units; texts are written as in the scene, `"1.2 m"`; a list is one of components.

        Raises ValueError for a name that belongs to nothing in the scene, SceneError with everything that is wrong with the changed scene.
        """
        if not (isinstance(changes, Mapping) or hasattr(changes, "items")):
            raise TypeError(f"replace: give a mapping of names to values, not {type(changes).__name__}")
        known = self.variables
        written = [(str(name), _written(str(name), value, known)) for name, value in changes.items()]
        with raised():
            core = self._core.replaced(written)
            core.check()
        return _of_core(core.files()[0][1].encode(), self._name, core)

    @given.spelled_out
    def trace(
        self, *points: str, times: Value | Iterable[Value] | None = None, **run: Unpack[RunOptions]
    ) -> dict[str, np.ndarray]:
        """The curves that points draw [default: those of which the scene reports x and y], (time, xy) [m]: "rod.tip", or a body for its mass centre. Other arguments are those of `simulate`.

        Raises ValueError where there is nothing to trace, and as `simulate` does.
        """
        with raised():
            named = list(points) or _cotree.traced(self._core)
        if not named:
            raise ValueError("trace: the scene does not report x and y of a point; name points")
        seen = self.simulate(outputs=[f"{point}.{axis}" for point in named for axis in "xy"], times=times, **run)
        return {point: np.stack([seen[f"{point}.x"], seen[f"{point}.y"]], axis=1) for point in named}

    def check(self) -> tuple[Fault, ...]:
        """What is odd about the scene: its warnings."""
        with raised():
            report = self._core.check()
        return faults(report)[0] if report else ()

    @given.spelled_out
    def simulate(
        self,
        *,
        times: Value | Iterable[Value] | None = None,
        outputs: str | Sequence[str] | None = None,
        **run: Unpack[RunOptions],
    ) -> Results:
        """Runs the code that runs in the FMU.

        >>> results = model.simulate(stop="1 s", set={"length": "500 mm"})
        >>> round(float(results["bob.angle"][-1]), 4)
        -0.0502

        :class:`RunOptions` are `start`, `stop`, `step` [s], `tolerance`, `set` and `inputs`; `times` are communication points instead of `stop` and `step`, ascending.
        `set` gives parameters, constant inputs and initial values; `inputs` are inputs over time, a data frame with the index or column `time` [s], `Results`, a data set of xarray or a
        mapping with "time", linear between its rows and constant outside; or a mapping of names to functions of the time, or of the time and the run (a :class:`Run`: its variables by
        `run[name]`), which are called at every communication point and held until the next. `outputs` are names of variables, parameters and inputs, instead of those of the scene.

        Raises SceneError, ValueError for arguments, RunError if the motion cannot be continued: its `results` has what comes before.
        """
        asked = given.asked("simulate", run, times)
        laws = given.laws(asked.inputs)
        if laws is not None:
            seen = self._sampled(asked.times, asked.settings, outputs, laws)
        else:
            [seen] = self._members(asked, outputs, [], NOTHING_VARIED, 1)
        if seen.failure:
            raise RunError(seen.failure, seen)
        return seen

    def _sampled(
        self,
        times: given.Times,
        settings: list[tuple[str, Value]],
        outputs: str | Sequence[str] | None,
        laws: Mapping[str, Callable[[float, Run], float]],
        varied: Mapping[str, float] | None = None,
    ) -> Results:
        """A run whose inputs are set at every communication point; what is varied is set beside the settings."""
        settings = list((dict(settings) | dict(varied or {})).items())
        with raised():
            points = self._core.points(times)
        run = Run(self, times, settings, None if outputs is None else given.names("outputs", outputs))
        rows: list[np.ndarray] = []
        times_seen: list[float] = []
        failure = None
        try:
            for time in points.tolist():
                if time > run.time:
                    run.step_to(time)
                if run.ended is None:
                    run.set({name: law(time, run) for name, law in laws.items()})
                rows.append(run.to_numpy())
                times_seen.append(run.time if run.ended else time)
                if run.ended:
                    break
        except RunError as error:
            failure = str(error)
        units = run.units
        values = np.array(rows).reshape(len(rows), len(units))
        return Results(np.array(times_seen), list(units), list(units.values()), values, failure, varied, run.ended, run.log)

    @given.spelled_out
    def start(self, *, outputs: str | Sequence[str] | None = None, **run: Unpack[RunOptions]) -> Run:
        """Begins a run that is taken step by step, for controllers and planners: see :class:`Run`.

        >>> run = model.start()
        >>> run.step("20 ms")
        >>> run.time, round(run["bob.angle"], 4)
        (0.02, 0.1742)

        `set` gives parameters, inputs and initial values, `start` and `tolerance` are those of :class:`RunOptions`; `outputs` names variables to read beside parameters and inputs, instead
        of those of the scene.

        Raises SceneError, ValueError for arguments, RunError if there is no start with these values.
        """
        by_steps = "how far a run goes is said by its steps"
        asked = given.asked("start", run, stop=by_steps, step=by_steps, inputs="set them as the run goes on: `run.step(duration, name=value)`")
        names = None if outputs is None else given.names("outputs", outputs)
        return Run(self, asked.times, asked.settings, names)

    @given.spelled_out
    def simulate_many(
        self,
        parameters: Any,
        *,
        times: Value | Iterable[Value] | None = None,
        outputs: str | Sequence[str] | None = None,
        threads: int = 0,
        most_values: int = MOST_VALUES,
        progress: Progress | None = None,
        **run: Unpack[RunOptions],
    ) -> ResultsList:
        """Runs many sets of parameters, constant inputs or initial values: a data frame with a column for each, a mapping of names to arrays, or a
        sequence of mappings; numbers in SI units.

        >>> runs = model.simulate_many({"length": [0.5, 1.0]}, stop=1)
        >>> len(runs), runs[1].parameters
        (2, {'length': 1.0})

        `threads` are as many as there are processors if 0; the results have the same bits whatever their number. Runs that end early do not raise:
        they have `failure`. `progress` says how far it is: True for a bar, a function of (done, all), or a bar such as `tqdm.tqdm()`. Other arguments are those of `simulate`.

        Raises ValueError where the results would have more than `most_values` numbers, which are a gigabyte.
        """
        names, values = self._varied(parameters)
        asked = given.asked("simulate_many", run, times)
        self._check_size(len(values), asked, outputs, most_values)
        workers, laws = given.threads(threads), given.laws(asked.inputs)

        def part(begin: int, end: int) -> list[Results]:
            if laws is not None:
                return [self._sampled(asked.times, asked.settings, outputs, laws, dict(zip(names, row, strict=True))) for row in values[begin:end].tolist()]
            return self._members(asked, outputs, names, values[begin:end], workers)

        with reporting(progress) as report:
            if report is None:
                return ResultsList(part(0, len(values)))
            return ResultsList([member for _, members in steps_of(len(values), 0, part, report) for member in members])

    def _check_size(
        self, runs: int, asked: given.Asked, outputs: str | Sequence[str] | None, most_values: int
    ) -> None:
        """Raises ValueError where the results of runs would be too many."""
        with raised():
            points = len(self._core.points(asked.times))
        kept = 1 + (sum(own.causality == "output" for own in self.variables.values()) if outputs is None else len(given.names("outputs", outputs)))
        if runs * points * kept > most_values:
            raise ValueError(
                f"{runs} runs with {points} points of {kept} columns are {runs * points * kept * 8 / 1e9:.1f} GB; `measure` keeps a few numbers of each run; "
                "or give a larger `step` or fewer `outputs`, simulate some runs at a time, or raise `most_values`"
            )

    @overload
    def measure(
        self,
        measures: str | Sequence[str],
        parameters: Any,
        *,
        times: Value | Iterable[Value] | None = None,
        threads: int = 0,
        to: None = None,
        resume: bool = False,
        progress: Progress | None = None,
        **run: Unpack[RunOptions],
    ) -> Table: ...
    @overload
    def measure(
        self,
        measures: str | Sequence[str],
        parameters: Any,
        *,
        times: Value | Iterable[Value] | None = None,
        threads: int = 0,
        to: str | os.PathLike[str],
        resume: bool = False,
        progress: Progress | None = None,
        **run: Unpack[RunOptions],
    ) -> Stored: ...
    @given.spelled_out
    def measure(
        self,
        measures: str | Sequence[str],
        parameters: Any,
        *,
        times: Value | Iterable[Value] | None = None,
        threads: int = 0,
        to: str | os.PathLike[str] | None = None,
        resume: bool = False,
        progress: Progress | None = None,
        **run: Unpack[RunOptions],
    ) -> Table | Stored:
        """As `simulate_many`, keeping only numbers of each run, so that a hundred thousand runs fit into memory.

        >>> table = model.measure("max(bob.angle)", {"length": [0.5, 1.0]}, stop=1)
        >>> table["max(bob.angle)"].shape
        (2,)

        Measures are written "max(rod.angle)"; there are max, min, peak (of the magnitude), range, mean, rms, first, last, when_max, when_min, of the values
        at communication points. Runs that end early have nan, and the reason in `failures`. `progress` is that of `simulate_many`.

        The table is a :class:`Table`. With `to`, the name of a folder that ends with .parquet or .arrow, it goes there in pieces as it comes, memory holds one piece, and the result is
        :class:`Stored`; `resume` goes on with one that was stopped. That needs pyarrow. Raises FileExistsError where the folder has another table.
        """
        asked = given.asked("measure", run, times)
        return self._measured(measures, self._varied(parameters), asked, threads, to, resume, progress)

    def _varied(self, runs: Any) -> tuple[list[str], np.ndarray]:
        """Names and a row of numbers for each run."""
        return parameters(runs, self._core.numbers)

    def _members(
        self,
        run: given.Asked,
        outputs: str | Sequence[str] | None,
        names: list[str],
        values: np.ndarray,
        threads: int,
    ) -> list[Results]:
        asked = None if outputs is None else given.names("outputs", outputs)
        with raised():
            columns, runs = self._core.simulate(
                run.times, run.settings, asked, given.inputs(run.inputs), names, values, threads
            )
        labels, units = [name for name, _ in columns], [unit for _, unit in columns]
        return [
            Results(time, labels, units, matrix, failure, dict(zip(names, row.tolist(), strict=True)), event, Log.of(log))
            for (time, matrix, failure, event, log), row in zip(runs, values, strict=True)
        ]

    def equations(self, notation: str = "text") -> str:
        """The equations of motion as text, latex, html, c, fortran, rust, python or json."""
        with raised():
            return self._core.equations(notation)

    def steps(self, notation: str = "text") -> str:
        """How the equations are derived, as text, latex or html."""
        with raised():
            return self._core.steps(notation)

    @overload
    def linearize(
        self, at: Value | None = None, *, set: Mapping[str, Value] | None = None, inputs: Any = None
    ) -> StateSpace: ...
    @overload
    def linearize(
        self, at: Iterable[Number], *, set: Mapping[str, Value] | None = None, inputs: Any = None
    ) -> list[StateSpace]: ...
    def linearize(
        self, at: Value | Iterable[Value] | None = None, *, set: Mapping[str, Value] | None = None, inputs: Any = None
    ) -> StateSpace | list[StateSpace]:
        """A, B, C, D from the inputs of the scene to its outputs.

        >>> system = model.linearize("equilibrium")
        >>> system.states, np.round(system.A, 2).tolist()
        (('bob.angle', 'bob.omega'), [[0.0, 1.0], [-9.81, -0.0]])

        `at` is a time [s], "equilibrium", several times (which give a list), or the start if it is not given; `inputs` are inputs over time up to there. Rows of outputs
        that have no value or no derivative there are not numbers. Raises SceneError, and RunError if there is no linear system there.
        """
        rests = isinstance(at, str) and at == "equilibrium"
        if rests and inputs is not None:
            raise ValueError("inputs: a mechanism at rest has constant inputs; give them by `set`")
        several = at is not None and not isinstance(at, str) and np.ndim(at) > 0  # type: ignore[arg-type]
        times = None if rests else [] if at is None else given.times("at", at, 'neither "equilibrium" nor a time')
        if several and not times:
            return []
        with raised():
            report = json.loads(self._core.linearize(times, given.settings(set), given.inputs(inputs)))
        points = [_state_space(point) for point in report.get("points", [report])]
        return points if several else points[0]

    def equilibrium(self, *, set: Mapping[str, Value] | None = None) -> Equilibrium:
        """Where the mechanism rests, with all reactions; of several equilibria the scene's guess picks one.

        >>> model.equilibrium().stability
        'stable'

        Raises SceneError, and RunError if none is found.
        """
        with raised():
            report = json.loads(self._core.equilibrium(given.settings(set)))
        values = {name: value for group in report["values"].values() for name, value in group.items()}
        held = [tuple(report[name]) for name in ("standing", "verging", "shared")]
        return Equilibrium(report["time"], report["stability"], report["moves_most"], values, report["values"], *held)

    def modes(
        self,
        at: Value | None = None,
        *,
        to: str | Sequence[str] | None = None,
        set: Mapping[str, Value] | None = None,
        inputs: Any = None,
    ) -> Modes:
        """Natural frequencies, damping ratios and shapes about the equilibrium next to the start, or about the pose at a time [s].

        >>> round(model.modes()[0].frequency, 4)
        0.4985

        With `to`, names of parameters or constant inputs, each mode about an equilibrium has the `derivatives` of its eigenvalue by name [1/s per unit].

        Raises SceneError, and RunError if there is no equilibrium.
        """
        if to is not None and at is not None:
            raise ValueError("to: derivatives are those of modes about an equilibrium; leave `at` out")
        if at is None and inputs is not None:
            raise ValueError("inputs: a mechanism at rest has constant inputs; give them by `set`")
        time = None if at is None else given.times("at", at)[0]
        with raised():
            report = json.loads(self._core.modes(time, given.settings(set), given.inputs(inputs)))
            changes: list[dict[str, Any]] = [{}] * len(report["modes"])
            if to is not None:
                found = json.loads(self._core.mode_sensitivities(given.names("to", to), given.settings(set)))
                changes = [mode["derivatives"] for mode in found["modes"]]
        return Modes(report["time"], [_mode(mode, own) for mode, own in zip(report["modes"], changes, strict=True)])

    @given.spelled_out
    def sensitivities(
        self,
        of: str | Sequence[str] | None = None,
        to: str | Sequence[str] | None = None,
        times: Value | Iterable[Value] | None = None,
        **run: Unpack[RunOptions],
    ) -> Sensitivities:
        """Derivatives of variables [default: the scene's outputs] with respect to parameters, constant inputs, initial values and rows of `inputs` such as "push[3]", at these times [s], or at
        every `step` up to `stop`, or where the mechanism rests: "equilibrium". Other arguments are those of `simulate`.

        >>> found = model.sensitivities("bob.angle", to="length", times=[0.5, 1])
        >>> found["bob.angle", "length"].shape
        (2,)

        They are integrated beside the motion (variational equations), not differenced: as accurate as the motion. Where laws switch they jump as they should.
        Raises SceneError, ValueError, and RunError where there are no derivatives: at singular poses, where a discontinuity of a law is touched without being crossed.
        """
        if to is None:
            raise ValueError("to: name what the derivatives are with respect to: parameters, constant inputs, initial values")
        rests = isinstance(times, str) and times == "equilibrium"
        at = times if times is None or rests else given.times("times", times, 'neither "equilibrium" nor times')
        asked = given.asked("sensitivities", run, None if rests else at)
        names = None if of is None else given.names("of", of), given.names("to", to)
        if rests:
            if asked.inputs is not None:
                raise ValueError("inputs: a mechanism at rest has constant inputs; give them by `set`")
            with raised():
                return sensitivities(*self._core.equilibrium_sensitivities(*names, asked.settings))
        if times is None and run.get("stop") is None and run.get("step") is None:
            raise ValueError('times: give times [s], or "equilibrium"')
        with raised():
            points = self._core.points(asked.times)
            columns = given.inputs(asked.inputs)
            return sensitivities(points, *self._core.sensitivities(asked.times, *names, asked.settings, columns))

    @given.spelled_out
    def value_and_gradient(
        self,
        measures: str | Sequence[str],
        at: Mapping[str, Any],
        *,
        times: Value | Iterable[Value] | None = None,
        threads: int = 0,
        **run: Unpack[RunOptions],
    ) -> tuple[np.ndarray, np.ndarray]:
        """Measures of a run and their gradients, for optimisers: those of `measure` but the times of extremes.

        >>> value, gradient = model.value_and_gradient("last(bob.angle)", {"length": 1.0}, stop=0.5)
        >>> gradient.shape
        (1,)

        `at` are the values of what is differentiated by, names and numbers; where they are arrays, each row is a run, and runs are spread over `threads`, as many as there are processors if 0. The values are (run, measure) and the gradients
        (run, measure, name in the order of `at`), without the axis of the runs where `at` has numbers, and without that of the measures where one text is given.

        A name such as "push[3]" is the value of `inputs` in row 3, from 0 on, so that whole courses are optimised: `{f"push[{row}]": force for row, force in enumerate(forces)}`.
        Where an event ends the run, measures are those up to there, and the gradient has what its time changes: "last(time)" is that time.
        Raises as `sensitivities` does.
        """
        sought = [measured(text) for text in given.names("measures", measures)]
        of = list(dict.fromkeys(variable for _, variable in sought if variable != "time"))
        names, rows = self._varied(at)
        asked = given.asked("value_and_gradient", run, times)
        with raised():
            columns = given.inputs(asked.inputs)
        values = np.empty((len(rows), len(sought)))
        gradients = np.empty((*values.shape, len(names)))
        if len(rows):
            with raised():
                found, runs = self._core.sensitivities_many(asked.times, of, (names, rows), asked.settings, columns, given.threads(threads))
            for index, seen in enumerate(runs):
                for place, (measure, variable) in enumerate(sought):
                    values[index, place], gradients[index, place] = reduced(measure, *course(variable, found, seen))
        # A row of texts, numbers or one of each is one run.
        one_run = all(isinstance(value, str) or np.ndim(value) == 0 for value in at.values())
        chosen = (0 if one_run else slice(None), 0 if isinstance(measures, str) else slice(None))
        return values[chosen], gradients[chosen]

    @given.spelled_out
    def peaks(
        self,
        of: str | Sequence[str] | None = None,
        to: str | Sequence[str] = (),
        *,
        crossing: Mapping[str, Value] | None = None,
        times: Value | Iterable[Value] | None = None,
        **run: Unpack[RunOptions],
    ) -> list[Peak]:
        """The largest and the smallest value of variables [default: the scene's outputs] and when they are reached, and the times at which variables cross given
        values (SI), with the derivatives of both with respect to parameters, constant inputs and initial values.

        The motion is looked at every `step`, or at these `times` [s], ascending: what happens between two points and is gone again is not seen. Where there are no derivatives, at a corner or of
        two equal peaks, `refused` says why. Raises as `sensitivities` does.
        """
        levels, asked = given.settings(crossing, "crossing"), given.asked("peaks", run, times)
        with raised():
            report = self._core.peaks(
                asked.times,
                None if of is None else given.names("of", of),
                given.names("to", to),
                levels,
                asked.settings,
                given.inputs(asked.inputs),
            )
        return [Peak(**feature) for feature in json.loads(report)["features"]]

    @given.spelled_out
    def fit(
        self,
        measured: Any,
        vary: str | Sequence[str] | Mapping[str, tuple[Value | None, Value | None] | None],
        *,
        sigma: Mapping[str, Value] | None = None,
        progress: Progress | None = None,
        **run: Unpack[RunOptions],
    ) -> Fit:
        """Values of parameters, constant inputs and initial values with which the motion is as near as possible to what was measured.

        >>> seen = model.simulate(set={"length": 0.8}, step=0.05)
        >>> round(model.fit({"time": seen.time, "bob.angle": seen["bob.angle"]}, "length")["length"], 4)
        0.8

        `measured` is a data frame with the index or column `time` [s], `Results`, a data set of xarray or a mapping with "time", and columns named like variables, SI; what is not a number
        was not measured. A list of these, or of :class:`Experiment` with settings and inputs of their own, are experiments that are fitted together: one set of values for all.
        Other arguments are those of `simulate`. `vary` are
        names, or a mapping of names to their bounds (low, high), where None is the scene's; the search begins at the scene's values, or those of `set`. `sigma` are
        standard deviations of columns; those that are not given are estimated from the residuals. `progress`, which is that of `simulate_many`, is told of motions, and of how many at most.

        Raises SceneError, ValueError with everything that is wrong with the arguments, RunError if what was measured does not determine the values.
        """
        several = isinstance(measured, Sequence) and not isinstance(measured, str)
        listed = list(measured) if several else [measured]
        if not listed:
            raise ValueError("measured: nothing was measured")
        asked = given.asked("fit", run, step="the motion is compared at the measured times")
        experiments = [_experiment(own, asked.settings, asked.inputs) for own in listed]
        with reporting(progress) as told, raised():
            report = self._core.fit(asked.times, experiments, given.varied(vary), given.settings(sigma, "sigma"), told)
        return fitted(json.loads(report), self, dict(asked.settings))

    def bench(self) -> dict[str, Any]:
        """Speed against error: every method at many tolerances, on this very scene, as `cotree bench --json` gives it."""
        with raised():
            measured: dict[str, Any] = json.loads(self._core.bench())
        return measured

    def _repr_html_(self) -> str:
        return frame(self.page(), 640)

    def _repr_latex_(self) -> str:
        return formulas(self.equations("latex"))


def _experiment(own: Any, settings: list[tuple[str, Value]], inputs: Any) -> given.Fitted:
    """Settings, what was measured, and inputs over time of one experiment."""
    if not isinstance(own, Experiment):
        own = Experiment(own)
    columns = given.inputs(own.measured, "measured")
    if columns is None:
        raise ValueError("measured: nothing was measured")
    mine = dict(given.settings(own.set, "Experiment: set"))
    settings = [(name, value) for name, value in settings if name not in mine] + list(mine.items())
    return settings, columns, given.inputs(inputs if own.inputs is None else own.inputs)


#: The one run of `simulate` varies nothing.
NOTHING_VARIED = np.zeros((1, 0))


def _written(name: str, value: Any, known: Mapping[str, Variable]) -> str:
    """A value as it stands in a scene. Numbers of variables have their SI unit: the scene may give them another one."""
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False)
    if isinstance(value, bool) and name not in known:
        return "true" if value else "false"
    if isinstance(value, Sequence) or (isinstance(value, np.ndarray) and value.ndim):
        return f"[{', '.join(_written('', component, known) for component in value)}]"
    given.check_value(f"replace: {name}", value)
    if value is None or not np.isfinite(float(value)):
        raise ValueError(f"replace: {name}: {value!r} is not a finite number")
    unit = known[name].unit if name in known else ""
    return json.dumps(f"{float(value)!r} {unit}") if unit not in ("", "1") else repr(float(value))


def _state_space(point: dict[str, Any]) -> StateSpace:
    signals = {kind: tuple(signal["name"] for signal in point[kind]) for kind in ("states", "inputs", "outputs")}
    units = {signal["name"]: signal["unit"] for kind in signals for signal in point[kind]}
    size = {kind: len(names) for kind, names in signals.items()}
    shapes = {"A": ("states", "states"), "B": ("states", "inputs"), "C": ("outputs", "states"), "D": ("outputs", "inputs")}
    matrices = {
        name: np.array(point[name], dtype=float).reshape(size[rows], size[columns])
        for name, (rows, columns) in shapes.items()
    }
    rates = np.array(point["rates"], dtype=float)
    return StateSpace(
        point["time"],
        signals["states"],
        signals["inputs"],
        signals["outputs"],
        units,
        matrices["A"],
        matrices["B"],
        matrices["C"],
        matrices["D"],
        rates,
    )


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
