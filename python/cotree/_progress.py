"""How far a call is that takes a while: a bar, a function, or an object such as those of tqdm."""

from __future__ import annotations

import importlib
import sys
import time
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, Protocol, runtime_checkable

#: Called with how much is done, and of how much.
Report = Callable[[int, int], object]
#: A bar is drawn no more often than this [s].
PACE = 0.1


@runtime_checkable
class Bar(Protocol):
    """An object that is told of each bit that is done, such as `tqdm.tqdm()`."""

    n: Any
    total: Any

    def update(self, n: Any = ..., /) -> Any:
        """So much more is done."""


#: What `progress` may be: True for a bar, a function, an object such as those of tqdm; None or False for nothing.
Progress = bool | Report | Bar


@contextmanager
def reporting(progress: Progress | None) -> Iterator[Report | None]:
    """What is to be called with how much is done, and of how much; None if nobody wants to know.

    Raises TypeError for what cannot be told.
    """
    if progress is None or progress is False:
        yield None
    elif progress is True:
        own = _own_bar()
        try:
            yield own
        finally:
            own.close()
    elif isinstance(progress, Bar) and not isinstance(progress, type):
        yield _updating(progress)
    elif callable(progress):
        yield progress
    else:
        raise TypeError(f"progress: {progress!r} is neither True nor a function of (done, all) nor a bar such as tqdm's")


def _updating(bar: Bar) -> Report:
    begun = bar.n

    def report(done: int, total: int) -> None:
        if bar.total is None:
            bar.total = begun + total
        bar.update(begun + done - bar.n)

    return report


class _Line:
    """A line on standard error that is written anew."""

    def __init__(self) -> None:
        self._last, self._is_open = 0.0, False

    def __call__(self, done: int, total: int) -> None:
        now = time.monotonic()
        if done < total and now - self._last < PACE:
            return
        self._last, self._is_open = now, True
        share = done / total if total else 1.0
        print(f"\r[{'#' * round(30 * share):30}] {done} of {total}", end="", file=sys.stderr, flush=True)

    def close(self) -> None:
        """Ends the line."""
        if self._is_open:
            print(file=sys.stderr)


class _Tqdm:
    """A bar of tqdm, which notebooks draw."""

    def __init__(self, make: Callable[..., Any]) -> None:
        self._make = make
        self._bar: Any = None

    def __call__(self, done: int, total: int) -> None:
        if self._bar is None:
            self._bar = self._make(total=total)
        self._bar.update(done - self._bar.n)

    def close(self) -> None:
        """Ends the bar."""
        if self._bar is not None:
            self._bar.close()


def _own_bar() -> _Line | _Tqdm:
    try:
        with warnings.catch_warnings():  # that a notebook could draw a nicer one
            warnings.simplefilter("ignore")
            return _Tqdm(importlib.import_module("tqdm.auto").tqdm)
    except ModuleNotFoundError:
        return _Line()
