"""Linkages from elsewhere: found for a task, or drawn with another program."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from . import _cotree
from ._commands import Report, Told
from ._faults import raised
from ._model import Model, loads, plain
from ._progress import Progress, reporting


class Linkages(Report):
    """What was found for a task: `models` are the linkages that are good, best first."""

    def __init__(self, told: Told, scenes: list[str]) -> None:
        super().__init__(told)
        self.models: list[Model] = [loads(scene) for scene in scenes]


def synthesize(
    task: str | os.PathLike[str] | Mapping[str, Any], *, all: bool = False, progress: Progress | None = None
) -> Linkages:
    """Finds linkages for a task, a body through poses, a function, a path or a stroke: a task file, or nested dictionaries with its keys; with `all`, those that are not good are in the report, too.

    `progress` is True for a bar, a function of (done, all), or a bar such as `tqdm.tqdm()`; it is told of each stage of the search.

    Raises SceneError with everything that is wrong with the task, or why it has no answer.
    """
    with reporting(progress) as report, raised():
        if isinstance(task, Mapping):
            found = _cotree.synthesize(json.dumps(task, default=plain), None, all, report)
        elif isinstance(task, str | os.PathLike):
            found = _cotree.synthesize(None, os.fspath(task), all, report)
        else:
            poses = '{"poses": {"at": [[x, y, angle], ...]}}'
            raise TypeError(f"task: give the path of a task file, or its tables as dictionaries such as {poses}, not {type(task).__name__}")
    return Linkages(*found)


def load_linkage(path: str | os.PathLike[str]) -> tuple[Model, tuple[str, ...]]:
    """Takes over a linkage of PMKS+ (`.pmks`, or a shared address in a text file) or of pylinkage (JSON): the model, and what was assumed or left out.

    Raises OSError, ValueError with everything that keeps it from being read.
    """
    file = Path(path)
    with raised():
        text, notes = _cotree.imported(file.stem, file.read_text(encoding="utf-8"))
    return loads(text, f"{file.stem}.toml"), tuple(notes)


def inspect(fmu: str | os.PathLike[str]) -> tuple[str, Model | None]:
    """What is in an FMU that cotree has made, as `cotree info` says it, and the model of its scene, if it was read from a file."""
    with raised():
        text, scene = _cotree.contents(os.fspath(fmu))
    return text, None if scene is None else loads(scene)
