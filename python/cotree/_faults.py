"""What is wrong with a scene, and where."""

from __future__ import annotations

import contextlib
import json
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

from . import _cotree

if TYPE_CHECKING:
    from ._results import Results


@dataclass(frozen=True, slots=True)
class Place:
    """Lines and columns count from 1, columns in characters; the end is after the last character."""

    line: int
    column: int
    end_line: int
    end_column: int


@dataclass(frozen=True, slots=True)
class Fault:
    """One thing that is wrong with a scene, or only odd (severity "warning")."""

    code: str
    severity: str
    message: str
    label: str
    help: str
    place: Place | None
    also: tuple[Place, ...] = ()


class SceneError(ValueError):
    """A scene is at fault. Its text shows every fault with its lines; `faults` has them as objects."""

    faults: tuple[Fault, ...]
    file: str

    def __init__(self, message: str, faults: tuple[Fault, ...] = (), file: str = "") -> None:
        super().__init__(message)
        self.faults, self.file = faults, file

    def __reduce__(self):
        return type(self), (str(self), self.faults, self.file)


class RunError(RuntimeError):
    """The numbers do not work out; `results` has what comes before, if there is anything."""

    results: Results | None

    def __init__(self, message: str, results: Results | None = None) -> None:
        super().__init__(message)
        self.results = results

    def __reduce__(self):
        return type(self), (str(self), self.results)


def _place(place: dict) -> Place:
    return Place(place["line"], place["column"], place["end_line"], place["end_column"])


def faults(text: str) -> tuple[tuple[Fault, ...], str]:
    """Faults and the name of the file from the program's JSON."""
    report = json.loads(text)
    found = [
        Fault(
            fault["code"],
            fault["severity"],
            fault["message"],
            fault["label"],
            fault["help"],
            fault["place"] and _place(fault["place"]),
            tuple(_place(place) for place in fault["also"]),
        )
        for fault in report["faults"]
    ]
    return tuple(found), report["file"]


@contextlib.contextmanager
def raised() -> Iterator[None]:
    """Turns the exceptions of the part written in Rust into those of this package."""
    try:
        yield
    except _cotree.SceneError as error:
        text, report = error.args
        raise SceneError(text, *faults(report)) from None
    except _cotree.RunError as error:
        raise RunError(str(error)) from None
