#!/usr/bin/env python3
"""The keys of scenes as types for Python, from `schema/scene.schema.json`: writes `python/cotree/_keys.py`; with --check it says whether that is what would be written."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[2]
SCHEMA, TARGET = ROOT / "schema" / "scene.schema.json", ROOT / "python" / "cotree" / "_keys.py"

HEAD = '''"""The keys of scenes, made by tools/python/keys.py from schema/scene.schema.json."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Literal, Required, TypedDict

import numpy as np

#: A number in SI units, a text with a unit, or an expression.
Quantity = float | str | np.floating[Any] | np.integer[Any]
#: Components.
Vector = Sequence[Quantity] | np.ndarray
'''

#: What the methods of Builder have as arguments of their own.
GIVEN = {"Joint": {"type", "between"}, "Load": {"type"}, "Parameter": {"value"}, "Input": {"start"}, "State": {"rate", "start"},
         "Signal": {"value"}, "Output": {"value"}, "Part": {"file"}, "Sampler": {"period", "values"}, "Event": {"when"}}
#: Methods of their own, and which of the keys are their arguments.
KINDS = {"revolute": set(), "prismatic": {"axis"}, "weld": set()}
LONGEST = 120


def definitions() -> dict[str, Any]:
    schema: dict[str, Any] = json.loads(SCHEMA.read_text())
    return {**schema["$defs"], "solver": schema["properties"]["solver"]}


DEFINITIONS = definitions()


def kind(own: dict[str, Any]) -> str:
    """The type of a value."""
    if "$ref" in own:
        name = own["$ref"].removeprefix("#/$defs/")
        return {"quantity": "Quantity", "vector": "Vector", "name": "str", "shape": "Shape", "sampled_value": "SampledValue"}.get(name) or kind(DEFINITIONS[name])
    if "const" in own:
        return f"Literal[{own['const']!r}]"
    if "enum" in own:
        return f"Literal[{', '.join(map(repr, own['enum']))}]"
    if "allOf" in own:
        return kind(own["allOf"][0])
    if "anyOf" in own or "oneOf" in own:
        return " | ".join(dict.fromkeys(part for each in own.get("anyOf", own.get("oneOf")) for part in kind(each).split(" | ")))
    types = own.get("type")
    if isinstance(types, list):
        return "Quantity" if set(types) == {"number", "string"} else " | ".join(dict.fromkeys(kind({**own, "type": one}) for one in types))
    if types == "array":
        items = own.get("items")
        return f"Sequence[{kind(items)}]" if items else "Sequence[Any]"
    if types == "object":
        more = own.get("additionalProperties")
        return f"Mapping[str, {kind(more) if isinstance(more, dict) else 'Any'}]"
    return {"string": "str", "number": "float", "integer": "int", "boolean": "bool", None: "Any"}[types]


def objects(own: dict[str, Any]) -> list[dict[str, Any]]:
    """The tables that a definition permits."""
    if "properties" in own:
        return [own]
    return [table for each in own.get("oneOf", own.get("anyOf", [])) for table in objects(each)]


def keys(tables: list[dict[str, Any]], without: set[str]) -> dict[str, tuple[str, str, bool]]:
    """The keys of tables: type, description, and whether each table needs it."""
    found: dict[str, tuple[list[str], list[str], bool]] = {}
    for table in tables:
        for name, own in table["properties"].items():
            if name in without:
                continue
            types, said, _ = found.setdefault(name, ([], [], True))
            types.extend(part for part in kind(own).split(" | ") if part not in types)
            if (text := own.get("description")) and text not in said:
                said.append(text)
    needed = {name: all(name in table.get("required", []) for table in tables) for name in found}
    return {name: (" | ".join(types), "; ".join(said), needed[name]) for name, (types, said, _) in found.items()}


def written(name: str, tables: list[dict[str, Any]], without: set[str], about: str) -> str:
    lines = [f"class {name}(TypedDict, total=False):", f'    """{about}"""', ""]
    for key, (own, said, needed) in sorted(keys(tables, without).items()):
        if not key.isidentifier():
            raise SystemExit(f"{name}: {key!r} is no identifier")
        if said:
            lines += [f"    #: {said}"]
        lines += [f"    {key}: {f'Required[{own}]' if needed else own}"]
    return "\n".join(lines) + "\n"


def text() -> str:
    parts = [HEAD]
    parts.append(written("Shape", objects(DEFINITIONS["shape"]), set(), "Keys of the shapes of bodies."))
    parts.append(written("SampledValue", objects(DEFINITIONS["sampled_value"]), set(), "Keys of the values of samplers."))
    for name in ["Parameter", "Input", "State", "Signal", "Sampler", "Event", "Output", "Part", "Body", "Driver", "Solver"]:
        about = f"Keys of {'a' if name[0] not in 'AEIOU' else 'an'} {name.lower()}." if name != "Solver" else "Settings of the solver."
        parts.append(written(f"{name}Keys", objects(DEFINITIONS[name.lower()]), GIVEN.get(name, set()), about))
    for name in ["Joint", "Load"]:
        tables = objects(DEFINITIONS[name.lower()])
        types = [table["properties"]["type"]["const"] for table in tables if "const" in table["properties"].get("type", {})]
        listed = ", ".join(f'"{own}"' for own in types)
        parts.append(f"#: The kinds of {name.lower()}s.\n{name}Type = Literal[{listed}]\n")
        parts.append(written(f"{name}Keys", tables, GIVEN[name], f"Keys of {name.lower()}s, whatever their kind."))
        for own, table in zip(types, tables, strict=True):
            if name == "Joint" and own in KINDS:
                parts.append(written(f"{own.capitalize()}Keys", [table], GIVEN[name] | KINDS[own], f"Keys of a {own} joint."))
    return "\n\n".join(parts)


def main() -> int:
    made = text()
    if "--check" in sys.argv[1:]:
        if TARGET.read_text() != made:
            print(f"{TARGET.relative_to(ROOT)} is not what {SCHEMA.relative_to(ROOT)} says: run tools/python/keys.py")
            return 1
        return 0
    TARGET.write_text(made)
    return 0


if __name__ == "__main__":
    sys.exit(main())
