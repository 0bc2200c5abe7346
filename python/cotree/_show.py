"""How results show themselves in notebooks, and as text for spreadsheets."""

from __future__ import annotations

import csv
import html
import io
import os
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, overload

import numpy as np

#: A notebook shows so many rows and columns of a table.
MOST_ROWS, MOST_COLUMNS = 30, 20


class Markup(str):
    """HTML, which is a cell as it is."""

    __slots__ = ()


class Drawing(str):
    """A picture (SVG): a text that a notebook shows as the picture."""

    __slots__ = ()

    def _repr_svg_(self) -> str:
        return str(self)

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Writes the picture; returns its path. A name that ends with .png writes it as PNG."""
        target = Path(path)
        if target.suffix.lower() == ".png":
            from ._commands import png

            target.write_bytes(png(self))
        else:
            target.write_text(self, encoding="utf-8")
        return target


def shown(value: Any) -> str:
    """A cell: numbers with six digits."""
    if isinstance(value, Markup):
        return value
    if isinstance(value, complex | np.complexfloating):
        text = f"{value.real:.6g}" if value.imag == 0 else f"{value.real:.6g} {'-' if value.imag < 0 else '+'} {abs(value.imag):.6g}i"
    elif isinstance(value, float | np.floating):
        text = f"{value + 0.0:.6g}"  # no -0
    else:
        text = "" if value is None else str(value)
    return html.escape(text)


def table(caption: str, heads: Sequence[str], rows: Sequence[Sequence[Any]], all_rows: int | None = None) -> str:
    """A table as HTML, the first rows of `all_rows`."""
    listed = list(rows[:MOST_ROWS])
    left = (len(rows) if all_rows is None else all_rows) - len(listed)
    head = "".join(f"<th>{html.escape(name)}</th>" for name in heads)
    body = "".join("<tr>" + "".join(f"<td>{shown(cell)}</td>" for cell in row) + "</tr>" for row in listed)
    more = f"<p>and {left} more</p>" if left > 0 else ""
    return f"<p>{html.escape(caption)}</p><table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>{more}"


def matrix(caption: str, rows: Sequence[str], columns: Sequence[str], values: np.ndarray) -> str:
    """A matrix with the names of its rows and columns."""
    few = list(columns[:MOST_COLUMNS])
    heads = ["", *few, *(["..."] if len(few) < len(columns) else [])]
    return table(caption, heads, [[name, *row[: len(few)], *([""] if len(few) < len(columns) else [])] for name, row in zip(rows, values, strict=True)])


def aligned(heads: Sequence[str], rows: Iterable[Sequence[Any]]) -> str:
    """A table as text: the first column to the left, the others to the right."""
    cells = [list(heads), *([shown_plain(cell) for cell in row] for row in rows)]
    widths = [max(map(len, column)) for column in zip(*cells, strict=True)]
    lines = ("  ".join(cell.ljust(width) if place == 0 else cell.rjust(width) for place, (cell, width) in enumerate(zip(row, widths, strict=True))) for row in cells)
    return "\n".join(line.rstrip() for line in lines)


def shown_plain(value: Any) -> str:
    """A cell of a text."""
    return html.unescape(shown(value))


def counted(count: int, noun: str) -> str:
    """So many of them."""
    return f"{count} {noun}{'' if count == 1 else 's'}"


def titled(name: str, unit: str) -> str:
    """The heading of a column, as the command writes it."""
    return f"{name} [{unit}]" if unit else name


def _cell(value: Any) -> str:
    if value is None or (isinstance(value, float) and value != value):
        return ""
    return repr(value) if isinstance(value, float) else str(value)


@overload
def to_csv(columns: Mapping[str, Any], path: None) -> str: ...
@overload
def to_csv(columns: Mapping[str, Any], path: str | os.PathLike[str]) -> None: ...
@overload
def to_csv(columns: Mapping[str, Any], path: str | os.PathLike[str] | None) -> str | None: ...
def to_csv(columns: Mapping[str, Any], path: str | os.PathLike[str] | None) -> str | None:
    """Columns by their headings as CSV: numbers that are read back with the same bits, nothing where there is none. A text, or a file."""
    listed = [column.tolist() if isinstance(column, np.ndarray) else list(column) for column in columns.values()]
    out = io.StringIO() if path is None else open(path, "w", newline="", encoding="utf-8")  # noqa: SIM115
    with out:
        writer = csv.writer(out, lineterminator="\n")
        writer.writerow(columns)
        writer.writerows([_cell(value) for value in row] for row in zip(*listed, strict=True))
        return out.getvalue() if isinstance(out, io.StringIO) else None
