#!/usr/bin/env python3
"""What the constants of the runtime do: rewrites a copy of the project so that they can be changed at run time, and writes docs/constants.md.

    constants.py rewrite COPY    rewrites the runtime in a copy of the project
    constants.py list            the constants, one a line
    constants.py page STUDY...   writes docs/constants.md from the tables of studies

docs/constants.md says how the study is repeated.
"""

import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
# Scalars with a value in one line, of modules: `tests/house.rs` has the same rule.
CONSTANT = re.compile(r"^((?:pub(?:\([a-z]+\))? )?)const ([A-Z0-9_]+): (f64|usize|u32|u64|i32|u8) = (.*);$", re.M)
# Mathematics, numbers of interfaces.
OTHERS = ("coefficients.rs", "/math.rs", "/fmi2/", "/fmi3/")
# They stand in types, in lengths of arrays or in what other crates read, and cannot be functions. Their rows stay as they are.
FIXED = set(
    """ATTEMPTS DERIVATIVE_ORDER EARLIER FEW_REGISTERS GIVEN HEADER HELD LANE_DIRECTIONS LARGEST_PROGRAM LONGEST_COMMUNICATION_STEP MAX_ORDER MAX_SWITCHES MEMBERS MIDDLE NO_ROW OPTIONS ORDER
    ORDERS PARTS POLYNOMIAL_PLACES POWERS ROUNDING_OF_POINTS ROUNDING_OF_TIMES ROOM VARIED_DIRECTIONS WIDTH WINDOW""".split()
)
# Where the copy counts its work, after the line that begins with this.
WORK = [
    ("tape/run.rs", "pub fn run(&self", "self.instructions.len()"),
    ("tape/run.rs", "pub fn run_series(&self", "self.instructions.len()"),
    ("tape/run.rs", "pub fn run_tangent(&self", "self.instructions.len()"),
    ("tape/run.rs", "fn run_any_lanes_tangents(&self", "self.instructions.len()"),
    ("tape/run.rs", "fn run_any_lanes(&self", "self.instructions.len()"),
    ("tape/run.rs", "fn run_any_tangents(&self", "self.instructions.len()"),
    ("taylor/jet/start.rs", "fn pose_any(&mut self", "10 * self.shape.all() + 50"),
    ("taylor/jet/orders.rs", "fn advance_all(&mut self", "(first + last + 20) * (last + 1 - first) * self.shape.all()"),
]
FACTORISED = ("integrator/implicit/jacobian.rs", "context.statistics.factorisations += 1;", "context.model.coordinates().pow(3) * 10")


class Constant:
    def __init__(self, path, match):
        self.file, (self.visible, self.name, self.type, self.value) = path, match.groups()
        self.room = path.split("/")[0].removesuffix(".rs")
        self.fixed = self.name in FIXED


def code(text):
    """The text without its tests."""
    return re.split(r"^#\[cfg\(test\)\]\nmod \w+ \{", text, flags=re.M)[0]


def constants(root):
    found = []
    for path in sorted(Path(root, "fmu/src").rglob("*.rs")):
        name = path.relative_to(Path(root, "fmu/src")).as_posix()
        if any(part in "/" + name for part in OTHERS):
            continue
        found += [Constant(name, match) for match in CONSTANT.finditer(code(path.read_text()))]
    return found


def others(name, text, places):
    """Constants of a file that share a name with one that is varied elsewhere: arrays, those of types, coefficients."""
    here = set(re.findall(r"\bconst ([A-Z0-9_]+):", text)) - {constant.name for constant in places if constant.file == name}
    uses = re.findall(r"^use [^;]*coefficients[^;]*;", text, re.M)
    return here | set(re.findall(r"\b[A-Z][A-Z0-9_]+\b", " ".join(uses)))


def calls(values, part):
    """Reads of constants as calls of functions of their names."""
    return re.sub(rf"(?<![\w`:])((?:[a-z_]+::)*(?:{'|'.join(values)}))\b(?!\s*[:(])", r"\1()", part)


def rewritten(line, places, values):
    """A line of code with constants that can be changed; what must be known to the compiler keeps their values."""
    before, mark, comment = line.partition("//")
    match = CONSTANT.match(line)
    if match and match[2] in values:
        of, wide = ("real", "f64") if match[3] == "f64" else ("count_of", "u64")
        value = f"crate::tuning::{of}({places[match[2]]}, ({calls(values, match[4])}) as {wide}) as {match[3]}"
        return f"#[inline] #[allow(non_snake_case, missing_docs)] {match[1]}fn {match[2]}() -> {match[3]} {{ {value} }}"
    if re.match(r"\s*(pub(\([a-z]+\))? )?const \w+: ", line):
        head, equal, value = before.partition(" = ")
        return head + equal + re.sub(rf"\b({'|'.join(values)})\b", lambda read: f"({values[read[1]]})", value) + mark + comment
    return calls(values, before) + mark + comment


def rewrite(copy):
    varied = [constant for constant in constants(copy) if not constant.fixed]
    places = {constant.name: place for place, constant in enumerate(varied)}
    values = {constant.name: constant.value for constant in varied}
    assert len(places) == len(varied), "two constants of one name"
    for path in sorted(Path(copy, "fmu/src").rglob("*.rs")):
        name = path.relative_to(Path(copy, "fmu/src")).as_posix()
        # Unit tests are of the constants as they are.
        text = code(path.read_text())
        known = {constant: value for constant, value in values.items() if constant not in others(name, text, varied)}
        lines = []
        imports = False
        for line in text.split("\n"):
            imports = imports or bool(re.match(r"(pub(\([a-z]+\))? )?use ", line))
            lines.append(line if imports else rewritten(line, places, known))
            imports = imports and not line.rstrip().endswith(";")
        body = "\n".join(lines)
        for file, start, amount in WORK:
            if file == name:
                body, count = re.subn(rf"(^ *{re.escape(start)}[^\n]*\{{$)", rf"\1\ncrate::tuning::work({amount});", body, flags=re.M)
                assert count == 1, (file, start, count)
        if FACTORISED[0] == name:
            assert FACTORISED[1] in body
            body = body.replace(FACTORISED[1], f"{FACTORISED[1]} crate::tuning::work({FACTORISED[2]});")
        path.write_text(body)
    assert all(Path(copy, "fmu/src", file).exists() for file, *_ in [*WORK, FACTORISED])
    library = Path(copy, "fmu/src/lib.rs")
    library.write_text(library.read_text() + "pub mod tuning;\n")
    table = "".join(f'    ("{constant.file}", "{constant.name}"),\n' for constant in varied)
    tuning = Path(__file__).with_name("tuning.rs").read_text()
    tuning += f"/// File and name of each.\npub const NAMES: [(&str, &str); {len(varied)}] = [\n{table}];\n"
    Path(copy, "fmu/src/tuning.rs").write_text(tuning)
    example = Path(copy, "examples/constants")
    example.mkdir()
    for file, copied in [("driver.rs", "main.rs"), ("modes.rs", "modes.rs")]:
        Path(example, copied).write_text(Path(__file__).with_name(file).read_text())
    manifest = Path(copy, "crates/cli/Cargo.toml")
    manifest.write_text(manifest.read_text() + '\n[[example]]\nname = "constants"\npath = "../../examples/constants/main.rs"\n')


INTRODUCTION = """# The constants of the runtime

Written by `tools/constants/constants.py`. Each scalar constant of `fmu/src` that is a choice was halved and doubled, one at a time, over a suite of {runs} short runs, {failing} of which
fail with the constants as they are: they are of poses, tolerances and methods meant to be too hard.

- The suite: the hard set of `tests/support/hard`, one or two members of each family, without those whose references take long or whose motions last longer than 12 s; all models, at most
  2 s of each; scenes with modes (`tools/constants/modes.rs`): contacts, hard stops, ropes, play, freewheels, dry friction, profiles, joints that engage, samples; five ensembles; sensitivities of six
  models. Tolerances 1e-4, 1e-7 and 1e-10; the method that the program chooses at each of them, the explicit and the implicit method each at one; Model Exchange for one scene with modes in three.
- A cell begins with the number of runs whose results or work change at all. The figures are geometric means over these.
- Work: instructions of tapes, orders of series weighted by their length, factorisations. They are counted, so they are the same on every machine; times are not measured.
- Errors: against the references, or against the same run at 1e-12; or the drift of the energy if that is larger; in tolerances. Errors below 0.01 tolerances count as 0.01.
- A run fails if it is refused, comes to another branch or far off, or takes ten times the work. "2 fail": two that did not before. Of the {failing} runs at the edge, one or two come and go with any
  change of the steps. Runs of the explicit and the implicit method that come to a singular configuration are refused by design and left out.
- "last digits": work changes by less than 0.1 %, errors by less than 2 %.
- Some constants are shares below 1 or factors just above 1, half or twice of which cannot be chosen: their rows only show that they act.
- Counts are rounded; the least is 1.
- What the runtime decides when a scene becomes a program (the first assembly) shows only through the sensitivities: all other runs share programs made with the constants as they are. Which loop equations are redundant the exporter decides, with constants of its own (`src/redundancy`).
- {when}

The study is repeated in a copy of the project, in about half an hour:

```sh no_run
cp -a . ../copy
python3 tools/constants/constants.py rewrite ../copy
cd ../copy
cargo run --example constants -- 0.5,2 > study.tsv
cargo run --example constants -- 0.001,1000 FILE:NAME ... > extremes.tsv   # those that change nothing
cd -
python3 tools/constants/constants.py page ../copy/study.tsv ../copy/extremes.tsv
```

`cargo run --example constants -- suite` prints the runs. With `FILE:NAME ...` after the factors some constants are measured; all others keep their rows, and remarks stay. `tests/house.rs` checks that
every constant has its row here, with the value that it has in the code.
"""
# What was measured when.
WHEN = """All rows were measured at one commit of November 2026, those of scenes with modes for the first time. Since then five constants have gone: three with a rule for series that creep up to a singular
  configuration, which changed no run, a bound that no tolerance reaches, and one of two shares by which the times of importers are off."""
HEADS = {
    "Guards": ("Half and twice of these change no bit of the suite; a thousandth or a thousand times does something.", ["a thousandth", "a thousand times"]),
    "Beyond the suite": (
        "A thousandth and a thousand times change no bit either: the constants act only where no run of the suite comes, or choose between ways to the same numbers.",
        [],
    ),
    "Not measured": ("Set since the study.", ["what is known"]),
    "Not varied": ("They stand in types, in lengths of arrays or in what importers read.", ["why"]),
}


def cell(row, runs):
    """What a factor does, in a few words."""
    if row is None:
        return "not finished"
    changed, failed, healed, _ = (int(row[k]) for k in range(4))
    if changed == 0:
        return "nothing"
    # The means are over all runs: of those that differ at all, each counts for so many.
    work, error = (float(row[k]) ** (runs / changed) for k in (6, 4))
    words = []
    if abs(work - 1) >= 0.001:
        words.append(f"work {100 * (work - 1):+.1f} %" if abs(work - 1) < 0.1 else f"work {100 * (work - 1):+.0f} %")
    if abs(error - 1) >= 0.02:
        words.append(f"errors × {error:.2f}" if error < 10 else f"errors × {error:.0f}")
    if failed:
        words.append(f"{failed} fail")
    if healed:
        words.append(f"{healed} no longer fail")
    return f"{changed}: {', '.join(words) or 'last digits'}"


def rows(paths):
    """The rows of studies by file, name and factor."""
    table = {}
    for path in paths:
        for line in Path(path).read_text().splitlines():
            file, name, factor, *row = line.split("\t")
            table[file, name, float(factor)] = row
    return table


def known():
    """Of each constant on the page: the section and the cells of its row, and what is remarked of it."""
    placed, remarks, section = {}, {}, ""
    for line in Path(ROOT, "docs/constants.md").read_text().splitlines():
        if line.startswith("## "):
            section = line[3:]
        elif row := re.match(r"\| `(\w+)` \| `[^`]+` \| `[^`]+` \| ?(.*?) ?\|?$", line):
            cells = row[2].split(" | ") if row[2] else []
            placed[row[1]] = section, cells
            if HEADS.get(section, ("", []))[1] in (["what is known"], ["why"]):
                remarks[row[1]] = cells[0]
        elif remark := re.match(r"- `(\w+)`: (.*)$", line):
            remarks[remark[1]] = remark[2]
    return placed, remarks


def page(studies):
    table = rows(studies)
    runs, failing = map(int, table.pop(("suite", "", 1.0))[:2])
    placed, remarks = known()

    def place(constant):
        found = [table.get((constant.file, constant.name, factor)) for factor in (0.5, 2.0, 0.001, 1000.0)]
        if found[:2] == [None, None]:
            return placed.get(constant.name, ("Not varied" if constant.fixed else "Not measured", ["-"]))
        acts = [row is not None and int(row[0]) > 0 for row in found]
        section = constant.room if any(acts[:2]) else "Guards" if any(acts[2:]) else "Beyond the suite"
        shown = {"Guards": found[2:], "Beyond the suite": []}.get(section, found[:2])
        return section, [cell(row, runs) for row in shown]

    sections = {}
    for constant in constants(ROOT):
        section, cells = place(constant)
        sections.setdefault(section, {})[constant.name] = [f"`{constant.name}`", f"`{constant.file}`", f"`{constant.value}`", *cells]
    text = INTRODUCTION.format(runs=runs, failing=failing, when=WHEN)
    for section in sorted(sections.keys() - HEADS.keys()) + list(HEADS):
        if section == "Not measured":
            measured = [constant.name for constant in constants(ROOT) if place(constant)[0] not in ("Not measured", "Not varied")]
            text += "\n## Remarks\n\nWhat else is known of constants above.\n\n"
            text += "".join(f"- `{name}`: {remarks[name]}\n" for name in measured if name in remarks)
        if section not in sections:
            continue
        about, heads = HEADS.get(section, ("", ["half", "twice"]))
        all_heads = ["constant", "file", "value", *heads]
        text += f"\n## {section}\n\n" + (f"{about}\n\n" if about else "")
        text += "".join(f"| {' | '.join(row)} |\n" for row in [all_heads, *sections.get(section, {}).values()]).replace(" |\n", f" |\n|{'---|' * len(all_heads)}\n", 1)
    Path(ROOT, "docs/constants.md").write_text(text)


if __name__ == "__main__":
    match sys.argv[1:]:
        case ["rewrite", copy]:
            rewrite(copy)
        case ["list"]:
            for constant in constants(ROOT):
                print(constant.file, constant.name, constant.type, constant.value, constant.fixed or "", sep="\t")
        case ["page", *studies]:
            page(studies)
        case _:
            sys.exit(__doc__)
