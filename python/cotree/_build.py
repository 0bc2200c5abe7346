"""Builds scenes in Python, with the words of the scene file."""

from __future__ import annotations

import copy
import os
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, Unpack

from ._given import Value
from ._keys import (
    BodyKeys,
    DriverKeys,
    EventKeys,
    InputKeys,
    JointKeys,
    JointType,
    LoadKeys,
    LoadType,
    OutputKeys,
    ParameterKeys,
    PartKeys,
    PrismaticKeys,
    RevoluteKeys,
    SampledValue,
    SamplerKeys,
    SignalKeys,
    SolverKeys,
    StateKeys,
    Vector,
    WeldKeys,
)
from ._model import Model, from_dict


class Builder:
    """A scene in the making. Each method adds something and returns the builder; `model()` reads what was built.

    >>> model = (
    ...     Builder("pendulum")
    ...     .gravity([0, -9.81])
    ...     .body("bob", mass=1, inertia=0, points={"top": [0, 1]})
    ...     .revolute("hinge", "ground", "bob.top")
    ...     .initial("bob.angle", "10 deg")
    ...     .output("bob.angle")
    ...     .stop("2 s")
    ...     .model()
    ... )
    """

    def __init__(
        self,
        name: str,
        *,
        dimension: int = 2,
        description: str | None = None,
        author: str | None = None,
        version: str | None = None,
        license: str | None = None,
        copyright: str | None = None,
    ) -> None:
        about = {
            "description": description,
            "author": author,
            "version": version,
            "license": license,
            "copyright": copyright,
        }
        self._scene: dict[str, Any] = {"name": name}
        if dimension != 2:
            self._scene["dimension"] = dimension
        self._scene |= {key: text for key, text in about.items() if text is not None}

    @classmethod
    def of(cls, model: Model) -> Builder:
        """A builder with the scene of a model, to add to it. Files of its parts and tables are looked for in the folder of `model`, as those of any builder."""
        own = cls(model.name)
        own._scene = model.to_dict()
        return own

    def _table(self, name: str) -> dict[str, Any]:
        table: dict[str, Any] = self._scene.setdefault(name, {})
        return table

    def _add(self, table: str, name: str, value: Any) -> Builder:
        entries = self._table(table)
        if name in entries:
            raise ValueError(f"{table}: there is a {name!r} already")
        entries[name] = value
        return self

    def gravity(self, gravity: Vector) -> Builder:
        """Acceleration of gravity [m/s2]."""
        self._scene["gravity"] = list(gravity)
        return self

    def parameter(self, name: str, value: Value, **keys: Unpack[ParameterKeys]) -> Builder:
        """A parameter; keys are unit, description, min, max, tunable."""
        return self._add("parameters", name, {"value": value, **keys} if keys else value)

    def input(self, name: str, start: Value = 0.0, **keys: Unpack[InputKeys]) -> Builder:
        """An input with its start value; keys are unit, description, min, max."""
        return self._add("inputs", name, {"start": start, **keys})

    def state(self, name: str, rate: Value, start: Value = 0.0, **keys: Unpack[StateKeys]) -> Builder:
        """A quantity with its rate and its value at the start; keys are unit, nominal, description."""
        return self._add("states", name, {"rate": rate, "start": start, **keys})

    def signal(self, name: str, value: Value | None = None, **keys: Unpack[SignalKeys]) -> Builder:
        """A law with a name that others use; keys are unit, description. With the type pid, filter or delay it has no value, but the keys of its type."""
        if value is None:
            return self._add("signals", name, dict(keys))
        return self._add("signals", name, {"value": value, **keys} if keys else value)

    def sampled(
        self, name: str, period: Value, values: Mapping[str, SampledValue], **keys: Unpack[SamplerKeys]
    ) -> Builder:
        """Values that change at ticks only, by their names, with the time from tick to tick [s]; offset is the time of the first sample."""
        return self._add("sampled", name, {"period": period, "values": dict(values), **keys})

    def event(self, name: str, when: str, **keys: Unpack[EventKeys]) -> Builder:
        """What happens when a comparison begins to hold; keys are set, remove, stop, once, description."""
        return self._add("events", name, {"when": when, **keys})

    def part(self, name: str, file: str | os.PathLike[str], **keys: Unpack[PartKeys]) -> Builder:
        """A mechanism from another file; keys are parameters, on, at, angle, mirror. Its path counts from the folder of `model`."""
        return self._add("parts", name, {"file": os.fspath(file), **keys})

    def display(self, *units: str, **kinds: str) -> Builder:
        """Units that results are shown in: one for each kind of value, such as `"deg", "mm"`, or by kind, such as `angle="deg"`."""
        self._table("display").update({"units": list(units)} if units else {}, **kinds)
        return self

    def ground_point(self, name: str, at: Vector) -> Builder:
        """A point of the ground [m]."""
        points = self._table("ground").setdefault("points", {})
        if name in points:
            raise ValueError(f"ground: there is a point {name!r} already")
        points[name] = list(at)
        return self

    def ground_outline(self, outline: Mapping[str, Any]) -> Builder:
        """The outline of the ground, for pictures and clearance, such as `{"disc": [0, 0], "radius": "60 mm"}`."""
        if "outline" in self._table("ground"):
            raise ValueError("ground: there is an outline already")
        self._table("ground")["outline"] = dict(outline)
        return self

    def clearance(self, *pairs: Sequence[str], least: Value | None = None) -> Builder:
        """Pairs of bodies, or of a body and `"ground"`, whose least distance `motion` reports, and the least that is permitted [m].

        Without pairs all that share no joint.
        """
        table = self._table("clearance")
        if pairs:
            table.setdefault("pairs", []).extend([list(pair) for pair in pairs])
        if least is not None:
            table["least"] = least
        return self

    def body(self, name: str, **keys: Unpack[BodyKeys]) -> Builder:
        """A body; keys are those of the scene file, such as mass, inertia, com, points, shape, outline."""
        return self._add("bodies", name, keys)

    def joint(self, name: str, type: JointType, between: Sequence[str], **keys: Unpack[JointKeys]) -> Builder:
        """A joint between two points."""
        return self._joint(name, type, between, dict(keys))

    def _joint(self, name: str, type: str, between: Sequence[str], keys: dict[str, Any]) -> Builder:
        return self._add("joints", name, {"type": type, "between": list(between), **keys})

    def revolute(self, name: str, first: str, second: str, **keys: Unpack[RevoluteKeys]) -> Builder:
        """A pin that joins two points."""
        return self._joint(name, "revolute", (first, second), dict(keys))

    def prismatic(self, name: str, first: str, second: str, axis: Vector, **keys: Unpack[PrismaticKeys]) -> Builder:
        """A guide along an axis in the frame of the first body."""
        return self._joint(name, "prismatic", (first, second), {"axis": list(axis), **keys})

    def weld(self, name: str, first: str, second: str, **keys: Unpack[WeldKeys]) -> Builder:
        """Two bodies made one."""
        return self._joint(name, "weld", (first, second), dict(keys))

    def driver(self, name: str, **keys: Unpack[DriverKeys]) -> Builder:
        """A prescribed motion."""
        return self._add("drivers", name, keys)

    def load(self, name: str, type: LoadType, **keys: Unpack[LoadKeys]) -> Builder:
        """A load."""
        return self._add("loads", name, {"type": type, **keys})

    def initial(self, variable: str, value: Value) -> Builder:
        """A position or velocity that is known at the start."""
        return self._add("initial", variable, value)

    def guess(self, variable: str, value: Value) -> Builder:
        """A guess that picks the assembly."""
        return self._add("initial", variable, {"guess": value})

    def output(self, *variables: str) -> Builder:
        """Variables to report."""
        self._table("outputs").setdefault("variables", []).extend(variables)
        return self

    def output_expression(self, name: str, value: Value, **keys: Unpack[OutputKeys]) -> Builder:
        """An expression to report; keys are unit, description."""
        return self._add("outputs", name, {"value": value, **keys} if keys else value)

    def start(self, time: Value) -> Builder:
        """Start of the run [s]."""
        self._table("experiment")["start"] = time
        return self

    def stop(self, time: Value) -> Builder:
        """End of the run [s]."""
        self._table("experiment")["stop"] = time
        return self

    def step(self, time: Value) -> Builder:
        """Time between reported values [s]."""
        self._table("experiment")["step"] = time
        return self

    def tolerance(self, tolerance: float) -> Builder:
        """Relative tolerance of the solver."""
        self._table("experiment")["tolerance"] = tolerance
        return self

    def solver(self, **keys: Unpack[SolverKeys]) -> Builder:
        """Settings of the solver."""
        self._table("solver").update(keys)
        return self

    def preset(self, preset: str) -> Builder:
        """Chooses the trees: recommended, absolute or joint."""
        self._table("coordinates")["preset"] = preset
        return self

    def translation(self, branches: Iterable[str]) -> Builder:
        """Names the branches of the translational tree."""
        self._table("coordinates")["translation"] = list(branches)
        return self

    def rotation(self, branches: Iterable[str]) -> Builder:
        """Names the branches of the rotational tree."""
        self._table("coordinates")["rotation"] = list(branches)
        return self

    def to_dict(self) -> dict[str, Any]:
        """The scene so far, with the keys of the scene file."""
        return copy.deepcopy(self._scene)

    def model(self, folder: str | os.PathLike[str] | None = None) -> Model:
        """Reads the scene; files of parts and tables are looked for in a folder [default: the current one].

        Raises SceneError with everything that is wrong with it.
        """
        return from_dict(self._scene, folder=folder)
