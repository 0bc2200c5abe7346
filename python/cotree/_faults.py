"""What is wrong with a scene, and where."""

from __future__ import annotations

import difflib
import json
from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

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


class CotreeError(Exception):
    """What this package raises beside the usual exceptions for arguments and files: SceneError, RunError and InternalError."""


class SceneError(CotreeError, ValueError):
    """A scene has errors. Its text lists each of them with its lines; `faults` has them as objects."""

    faults: tuple[Fault, ...]
    file: str

    def __init__(self, message: str, faults: tuple[Fault, ...] = (), file: str = "") -> None:
        super().__init__(message)
        self.faults, self.file = faults, file

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (str(self), self.faults, self.file)


class RunError(CotreeError, RuntimeError):
    """The solver failed; `results` has the motion before, if there is any."""

    results: Results | None

    def __init__(self, message: str, results: Results | None = None) -> None:
        super().__init__(message)
        self.results = results

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (str(self), self.results)


class InternalError(CotreeError, RuntimeError):
    """An error of cotree itself (`cotree::internal`), not of the scene: please report it with the scene file."""


def _place(place: dict[str, int]) -> Place:
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


class raised:
    """Turns the exceptions of the part written in Rust into those of this package."""

    def __enter__(self) -> None:
        return None

    def __exit__(self, kind: object, error: BaseException | None, trace: object) -> None:
        if isinstance(error, _cotree.SceneError):
            text, report = error.args
            raise SceneError(text, *faults(report)) from None
        if isinstance(error, _cotree.RunError):
            raise RunError(str(error)) from None
        if isinstance(error, _cotree.PanicException):
            raise InternalError(f"cotree::internal: {error}; please report it with the scene file") from None


def meant(name: object, known: Iterable[str]) -> str:
    """What may have been meant by a name that is not known."""
    names = list(known)
    near = difflib.get_close_matches(str(name), names, 1)
    return f"did you mean {near[0]!r}?" if near else f"there is {', '.join(names) or 'nothing'}"


def unknown(name: object, known: Iterable[str], what: str) -> KeyError:
    """That there is nothing of that name, and what may have been meant."""
    return KeyError(f"{name!r} {what}; {meant(name, known)}")
