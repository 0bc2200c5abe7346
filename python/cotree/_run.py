"""A run that is taken step by step."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ._cotree import RunError as _RunError
from ._faults import RunError, raised
from ._given import settings as settings_of
from ._results import Log

if TYPE_CHECKING:
    from ._given import Times, Value
    from ._model import Model


class Run:
    """A motion at a time, and the way on: for a controller in the loop, and for planners that try many futures from one state.

    `run.step("20 ms", push=1.2)` sets the input `push` and moves on; `run["pole.angle"]` is a value now, one of the outputs that were asked for, of parameters and inputs.
    `run.copy()` goes its own way from here on, and `run.reset()` begins again. It can be pickled.
    """

    def __init__(self, model: Model, times: Times, settings: list[tuple[str, Value]], outputs: list[str] | None) -> None:
        self._begun: tuple[Model, Times, list[tuple[str, Value]], list[str] | None] = model, times, settings, outputs
        with raised():
            self._running = model._core.start(times, settings, outputs)

    @property
    def time(self) -> float:
        """The time [s]."""
        return self._running.time

    @property
    def ended(self) -> str | None:
        """The event of the scene that has ended the run, at this time, if one has: there is no step beyond it."""
        return self._running.ended

    @property
    def log(self) -> Log:
        """What has happened up to now: events, impacts, what limits, contacts, ropes and frictions have done."""
        return Log.of(self._running.log())

    @property
    def units(self) -> dict[str, str]:
        """The SI units of the outputs, by name."""
        return dict(self._running.outputs())

    @property
    def outputs(self) -> dict[str, float]:
        """The outputs now; not a number where one has no value."""
        return dict(zip(self.units, self.to_numpy().tolist(), strict=True))

    def to_numpy(self) -> np.ndarray:
        """The outputs now, in their order."""
        with raised():
            return self._running.values()

    def __getitem__(self, name: str) -> float:
        try:
            return self._running.get(name)
        except _RunError as error:
            raise RunError(str(error)) from None

    def set(self, values: Mapping[str, Value]) -> None:
        """Sets inputs and tunable parameters: all of them, or none if one cannot be set. They hold until they are set again.

        Raises ValueError.
        """
        with raised():
            self._running.set(list(values.items()))

    def step(self, duration: Value, /, **inputs: Value) -> None:
        """Sets inputs as `set` does and moves on by a duration [s].

        Where an event of the scene ends the run within the step, it stays there, and `ended` names the event.

        Raises ValueError, and RunError if the motion cannot be continued: the run stays where it has come to.
        """
        try:
            if inputs:
                self._running.set(list(inputs.items()))
            self._running.step(duration, False)
        except _RunError as error:
            raise RunError(str(error)) from None

    def step_to(self, time: Value, /, **inputs: Value) -> None:
        """The same up to a time [s]."""
        with raised():
            self._running.set(list(inputs.items()))
            self._running.step(time, True)

    def reset(self, set: Mapping[str, Value] | None = None) -> None:
        """Begins again where `start` has begun, with other parameters, inputs and initial values if they are `set`; what `start` was given holds beside them.

        >>> run = model.start(set={"length": 2.0})
        >>> run.step(0.5)
        >>> run.reset({"bob.angle": "20 deg"})
        >>> run.time, run["length"]
        (0.0, 2.0)

        That is quicker than a new run, for environments of learning and for searches. Raises ValueError, and RunError if there is no start with these values: the run stays where it is.
        """
        model, times, begun, outputs = self._begun
        settings = list((dict(begun) | dict(settings_of(set))).items())
        with raised():
            if not self._running.restart(model._core, times, settings):
                self._running = model._core.start(times, settings, outputs)

    def copy(self) -> Run:
        """The same run once more, from here on for itself."""
        other = Run.__new__(Run)
        other._begun, other._running = self._begun, self._running.copy()
        return other

    __copy__ = copy

    def __deepcopy__(self, memo: object) -> Run:
        return self.copy()

    @property
    def state(self) -> bytes:
        """All that the future depends on. Set it, and the run is where it was; it is one of runs of the same model and outputs."""
        with raised():
            return self._running.save()

    @state.setter
    def state(self, state: bytes) -> None:
        with raised():
            self._running.restore(state)

    def directional(self, of: str | Sequence[str], along: Mapping[str, float]) -> np.ndarray:
        """How variables change now along a direction of inputs, parameters and states, everything else the same: one derivative for each of `of`.

        A state is a coordinate or its rate, as `model.linearize().states` names them. Raises ValueError for what does not depend on such a direction, or is none.
        """
        names = [of] if isinstance(of, str) else list(of)
        with raised():
            return np.array(self._running.directional(names, [(name, float(change)) for name, change in along.items()]))

    def __reduce__(self) -> tuple[Any, ...]:
        return _restored, (*self._begun, self.state, tuple(self._running.log()))

    def _ipython_key_completions_(self) -> list[str]:
        return list(self.units)

    def __repr__(self) -> str:
        return f"<Run of {self._begun[0].name!r} at {self.time:g} s>"


def _restored(model: Model, times: Times, settings: list[tuple[str, Value]], outputs: list[str] | None, state: bytes, log: tuple[Any, ...] = ()) -> Run:
    run = Run(model, times, settings, outputs)
    run.state = state
    run._running.remember(list(log))
    return run
