"""Tables of many runs that are written as they come: a folder of Parquet or Arrow files, which pandas, polars, DuckDB and others read as one table."""

from __future__ import annotations

import hashlib
import importlib
import json
import os
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from . import _cotree
from ._progress import Report
from ._results import Table

if TYPE_CHECKING:
    import pandas

#: A file has so many runs, or those of so many seconds: that much is lost where a machine is.
PIECE, PATIENCE = 10_000, 60.0
#: After so long whoever waits is told how far it is [s].
PACE = 0.5
#: The mark of what is in a folder. Readers of tables pass over names that begin like this.
MARK = "_cotree.json"

#: What some of the runs have given.
Part = TypeVar("Part")
#: Measures the runs from one number up to another.
Measure = Callable[[int, int], Table]


@dataclass(frozen=True)
class Stored:
    """A table of many runs in a folder of files."""

    path: Path
    runs: int
    #: How many of them have failed; the column `failure` says why.
    failed: int

    def to_pandas(self) -> pandas.DataFrame:
        """All of it as a data frame."""
        import pandas

        reader = _format(self.path).read
        frame: pandas.DataFrame = pandas.concat([reader(piece).to_pandas() for piece in _pieces(self.path)], ignore_index=True)
        return frame


@dataclass(frozen=True)
class _Format:
    read: Callable[[Path], Any]
    write: Callable[[Any, Path], object]
    rows: Callable[[Path], tuple[int, int]]


def _format(path: Path) -> _Format:
    """How the files of a folder are read and written, by its name; ValueError for others, ImportError without pyarrow."""
    if path.suffix not in (".parquet", ".arrow"):
        raise ValueError(f"to: {os.fspath(path)!r} must end with .parquet or .arrow")
    try:
        feather, parquet = (importlib.import_module(f"pyarrow.{name}") for name in ("feather", "parquet"))
    except ModuleNotFoundError as missing:
        raise ImportError(f"to: {path.suffix} files need pyarrow: pip install pyarrow", name=missing.name) from None

    def rows(piece: Path) -> tuple[int, int]:
        failure = read(piece, columns=["failure"])["failure"]
        return len(failure), len(failure) - failure.null_count

    is_parquet = path.suffix == ".parquet"
    read = parquet.read_table if is_parquet else feather.read_table
    return _Format(read, parquet.write_table if is_parquet else feather.write_feather, rows)


def _pieces(folder: Path) -> list[Path]:
    """The files of a folder in the order of their runs."""
    return sorted(folder.glob(f"run-*{folder.suffix}"))


def steps(count: int, begin: int, measure: Measure, progress: Report | None) -> Iterator[tuple[int, Table]]:
    """As `steps_of`, of tables."""
    return steps_of(count, begin, measure, progress)


def steps_of(count: int, begin: int, measure: Callable[[int, int], Part], progress: Report | None) -> Iterator[tuple[int, Part]]:
    """Makes runs from `begin` on, some at a time: as many as take about half a second. Yields the first number and the results of each part."""
    size = max(1, os.cpu_count() or 1)
    while begin < count:
        end, clock = min(begin + size, count), time.monotonic()
        table = measure(begin, end)
        yield begin, table
        begin = end
        if time.monotonic() - clock < PACE:
            size = min(2 * size, PIECE)
        if progress is not None:
            progress(begin, count)


def mark(*parts: Any) -> str:
    """Names what a table is of: whatever changes a run or its place changes this."""
    digest = hashlib.sha256(_cotree.__version__.encode())
    for part in parts:
        digest.update(part.tobytes() if isinstance(part, np.ndarray) else repr(part).encode())
        digest.update(b"\0")
    return digest.hexdigest()


def stored(path: Path, own: str, count: int, measure: Measure, resume: bool, progress: Report | None) -> Stored:
    """Writes the table of runs into a folder, or goes on with it.

    Raises FileExistsError where another table is there, or one that is not to be continued.
    """
    kind = _format(path)
    if path.exists() and not path.is_dir():
        raise FileExistsError(f"to: {os.fspath(path)!r} is a file; the table is a folder of files")
    there = path / MARK
    if there.exists():
        if json.loads(there.read_text())["mark"] != own:
            raise FileExistsError(f"to: {os.fspath(path)!r} has the runs of another table: scene, runs, measures or times differ; choose another folder")
        if not resume:
            raise FileExistsError(f"to: {os.fspath(path)!r} has runs of this table: go on with resume=True, or remove it")
    elif path.exists() and any(path.iterdir()):
        raise FileExistsError(f"to: {os.fspath(path)!r} has other files; choose another folder")
    path.mkdir(parents=True, exist_ok=True)
    _put(there, lambda place: place.write_text(json.dumps({"mark": own, "runs": count, "cotree": _cotree.__version__}) + "\n"))
    begin = failed = 0
    for piece in _pieces(path):
        if piece.name != _name(path, begin):
            raise FileExistsError(f"to: {os.fspath(piece)!r} follows no other file: files have been removed; choose another folder")
        runs, wrong = kind.rows(piece)
        begin, failed = begin + runs, failed + wrong
    kept: list[Table] = []
    clock = time.monotonic()
    for first, table in steps(count, begin, measure, progress):
        kept.append(table)
        runs, failed = sum(own.runs for own in kept), failed + len(table.failures)
        if runs >= PIECE or time.monotonic() - clock > PATIENCE or first + table.runs == count:
            _put(path / _name(path, begin), partial(kind.write, _arrow(kept, begin)))
            begin, kept, clock = begin + runs, [], time.monotonic()
    return Stored(path, count, failed)


def _name(folder: Path, first: int) -> str:
    return f"run-{first:012}{folder.suffix}"


def _put(place: Path, write: Callable[[Path], object]) -> None:
    """Writes a file whole, or not at all."""
    unfinished = place.with_name(f"_{place.name}.{os.getpid()}")
    write(unfinished)
    os.replace(unfinished, place)


def _arrow(tables: list[Table], begin: int) -> Any:
    """Tables one after another as one of Arrow: the number of each run, what was varied, what was measured with its unit, and why the run has failed."""
    pyarrow = importlib.import_module("pyarrow")
    runs = sum(own.runs for own in tables)
    fields, columns = [pyarrow.field("run", pyarrow.int64())], [np.arange(begin, begin + runs)]
    for name in tables[0]:
        unit = tables[0].units.get(name)
        fields.append(pyarrow.field(name, pyarrow.float64(), metadata=None if unit is None else {"unit": unit}))
        columns.append(np.concatenate([table[name] for table in tables]))
    fields.append(pyarrow.field("failure", pyarrow.string()))
    reasons = [table.failures.get(run) for table in tables for run in range(table.runs)]
    return pyarrow.table([pyarrow.array(own, field.type) for own, field in zip([*columns, reasons], fields, strict=True)], pyarrow.schema(fields))
