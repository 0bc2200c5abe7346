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
# They stand in types, in lengths of arrays or in other constants, or are no choice.
FIXED = {
    ("integrator/explicit/stages.rs", "LATE"): "a stage of the method",
    ("integrator/explicit/stages.rs", "LATE_NODE"): "the node of a stage",
    ("integrator/implicit/jacobian.rs", "MIDDLE"): "a place on a step, in a constant",
    ("integrator/implicit/passage.rs", "MIDDLE"): "a place on a passage, in a constant",
    ("integrator/implicit/watch.rs", "POWERS"): "a length of an array",
    ("integrator/taylor/member.rs", "FEW"): "a width that is compiled",
    ("linalg/lane.rs", "WIDTH"): "a length of an array",
    ("program/contour.rs", "HELD"): "a length of an array",
    ("program/seal.rs", "HEADER"): "a file format",
    ("fmi/component.rs", "LONGEST"): "of the functions of FMI",
    ("fmi/component.rs", "OFFSET"): "of the functions of FMI",
    ("fmi/component.rs", "ROUNDING"): "of the functions of FMI",
    ("fmi/resource.rs", "LARGEST"): "of the functions of FMI",
    ("singular/branch.rs", "WINDOW"): "a length of an array",
    ("tape/file.rs", "FEW_REGISTERS"): "a length of an array",
    ("tape/lanes.rs", "DIRECTIONS"): "a length of an array",
    ("tape/series.rs", "ORDER"): "a length of an array",
    ("taylor/jet/members/frames.rs", "MOST_FRAMES"): "a length of an array",
    ("taylor/jet/members/frames.rs", "MOST_EQUATIONS"): "a length of an array",
    ("taylor/jet/members/variation.rs", "DIRECTIONS"): "a length of an array",
    ("taylor/mod.rs", "MAX_ORDER"): "a length of an array",
    ("taylor/mod.rs", "ORDERS"): "a length of an array",
    ("events/switch.rs", "MAX_SWITCHES"): "a length of an array",
    ("instance/derivatives.rs", "DERIVATIVE_ORDER"): "the order of the derivatives",
}
# Where the copy counts its work, after the line that begins with this.
WORK = [
    ("tape/operations.rs", "pub fn run(&self", "self.instructions.len()"),
    ("tape/series.rs", "pub fn run_series(&self", "self.instructions.len()"),
    ("tape/tangent.rs", "pub fn run_tangent(&self", "self.instructions.len()"),
    ("tape/lanes.rs", "fn run_any_lanes_tangents(&self", "self.instructions.len()"),
    ("tape/lanes.rs", "fn run_any_lanes(&self", "self.instructions.len()"),
    ("tape/lanes.rs", "fn run_any_tangents(&self", "self.instructions.len()"),
    ("taylor/jet/start.rs", "fn pose_any(&mut self", "10 * self.shape.all() * WIDTH + 50"),
    ("taylor/jet/members/orders.rs", "pub(super) fn advance_all(&mut self", "(first + last + 20) * (last + 1 - first) * self.arms.len()"),
    ("taylor/jet/orders.rs", "fn advance_all(&mut self", "(first + last + 20) * (last + 1 - first) * self.shape.all()"),
]
FACTORISED = ("integrator/implicit/jacobian.rs", "context.statistics.factorisations += 1;", "context.model.coordinates().pow(3) * 10")


class Constant:
    def __init__(self, path, match):
        self.file, (self.visible, self.name, self.type, self.value) = path, match.groups()
        self.room = path.split("/")[0].removesuffix(".rs")
        self.fixed = FIXED.get((path, self.name))

    def is_at(self, name):
        return not self.fixed and self.name == name


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


def imported(text):
    """The names of use declarations, but those of coefficients."""
    uses = re.findall(r"^(?:pub(?:\([a-z]+\))? )?use [^;]*;", text, re.M)
    return set(re.findall(r"\b[A-Z][A-Z0-9_]+\b", " ".join(use for use in uses if "coefficients" not in use)))


def rewrite(copy):
    varied = [constant for constant in constants(copy) if not constant.fixed]
    shared = {constant.name for constant in varied}
    for path in sorted(Path(copy, "fmu/src").rglob("*.rs")):
        name = path.relative_to(Path(copy, "fmu/src")).as_posix()
        text = path.read_text()
        body = code(text)
        own = {constant.name: place for place, constant in enumerate(varied) if constant.file == name}
        local = {match[2] for match in CONSTANT.finditer(body)} - own.keys()
        names = own.keys() | (imported(body) & shared - local)
        qualified = "|".join(shared)
        lines = []
        skipping = False
        for line in body.split("\n"):
            skipping = skipping or bool(re.match(r"(pub(\([a-z]+\))? )?use ", line))
            if skipping:
                skipping = not line.rstrip().endswith(";")
                lines.append(line)
                continue
            before, mark, comment = line.partition("//")
            match = CONSTANT.match(line)
            used = lambda part: re.sub(rf"(?<![\w:`])({'|'.join(names) or '(?!)'})\b(?!\s*[:(])", r"\1()", part)
            used_at = lambda part: re.sub(rf"\b((?:[a-z_]+::)+(?:{qualified}))\b(?!\()", r"\1()", used(part))
            if match and match[2] in own:
                of = "real" if match[3] == "f64" else "count_of"
                value = used_at(match[4])
                body_of = f"crate::tuning::{of}({own[match[2]]}, ({value}) as {'f64' if of == 'real' else 'u64'}) as {match[3]}"
                lines.append(f"#[inline] #[allow(non_snake_case, missing_docs)] {match[1]}fn {match[2]}() -> {match[3]} {{ {body_of} }}")
            else:
                lines.append(used_at(before) + mark + comment)
        body = "\n".join(lines)
        for file, start, amount in WORK:
            if file == name:
                body, count = re.subn(rf"(^ *{re.escape(start)}[^\n]*\{{$)", rf"\1\ncrate::tuning::work({amount});", body, flags=re.M)
                assert count == 1, (file, start, count)
        if FACTORISED[0] == name:
            assert FACTORISED[1] in body
            body = body.replace(FACTORISED[1], f"{FACTORISED[1]} crate::tuning::work({FACTORISED[2]});")
        # Unit tests are of the constants as they are.
        path.write_text(body)
    library = Path(copy, "fmu/src/lib.rs")
    library.write_text(library.read_text() + "pub mod tuning;\n")
    table = "".join(f'    ("{constant.file}", "{constant.name}"),\n' for constant in varied)
    tuning = Path(__file__).with_name("tuning.rs").read_text()
    tuning += f"/// File and name of each.\npub const NAMES: [(&str, &str); {len(varied)}] = [\n{table}];\n"
    Path(copy, "fmu/src/tuning.rs").write_text(tuning)
    Path(copy, "examples/constants.rs").write_text(Path(__file__).with_name("driver.rs").read_text())
    manifest = Path(copy, "crates/cli/Cargo.toml")
    manifest.write_text(manifest.read_text() + '\n[[example]]\nname = "constants"\npath = "../../examples/constants.rs"\n')


INTRODUCTION = """# The constants of the runtime

Written by `tools/constants/constants.py`. Each scalar constant of `fmu/src` that is a choice was halved and doubled, one at a time, over a suite of {runs} short runs, {failing} of which
fail with the constants as they are: they are of poses, tolerances and methods meant to be too hard.

- The suite: the hard set of `tests/support/hard`, one or two members of each family, without those whose references take long or whose motions last longer than 12 s; all models, at most
  2 s of each; five ensembles; sensitivities of three models. Tolerances 1e-4, 1e-7 and 1e-10; the method that the program chooses at each of them, the explicit and the implicit method each
  at one.
- A cell begins with the number of runs whose results or work change at all. The figures are geometric means over these.
- Work: instructions of tapes, orders of series weighted by their length, factorisations. They are counted, so they are the same on every machine; times are not measured.
- Errors: against the references, or against the same run at 1e-12; or the drift of the energy if that is larger; in tolerances. Errors below 0.01 tolerances count as 0.01.
- A run fails if it is refused, comes to another branch or far off, or takes ten times the work. "2 fail": two that did not before. Of the {failing} runs at the edge, one or two come and go with any
  change of the steps.
- "last digits": work changes by less than 0.1 %, errors by less than 2 %.
- Some constants are shares below 1 or factors just above 1, half or twice of which is no choice: their rows only show that they act.
- Counts are rounded; the least is 1.
- Constants of one meaning that stood in several files when they were measured, and are one now, have the row of that which did most: it was halved and doubled in its own place alone.
- What the runtime decides when a scene becomes a program (the first assembly) shows only through the sensitivities: all other runs share programs made with the constants as they are. Which loop equations are redundant the exporter decides, with constants of its own (`src/redundancy`).

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

`cargo run --example constants -- suite` prints the runs. `tests/house.rs` checks that every constant has its row here, with the value that it has in the code.
"""


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


def page(studies):
    table = rows(studies)
    runs, failing = map(int, table.pop(("suite", "", 1.0)))
    text = INTRODUCTION.format(runs=runs, failing=failing)
    all_of_them = constants(ROOT)
    head = lambda constant: f"| `{constant.name}` | `{constant.file}` | `{constant.value}` |"
    at = lambda constant, factor: table.get((constant.file, constant.name, factor))
    changes = lambda row: row is None or int(row[0]) > 0
    acts = lambda constant: any(changes(at(constant, factor)) for factor in (0.5, 2.0))
    varied = [constant for constant in all_of_them if not constant.fixed]
    for room in sorted({constant.room for constant in varied if acts(constant)}):
        text += f"\n## {room}\n\n| constant | file | value | half | twice |\n|---|---|---|---|---|\n"
        for constant in varied:
            if constant.room == room and acts(constant):
                text += f"{head(constant)} {cell(at(constant, 0.5), runs)} | {cell(at(constant, 2.0), runs)} |\n"
    idle = [constant for constant in varied if not acts(constant)]
    text += "\n## Guards\n\nHalf and twice of these change no bit of the suite; a thousandth or a thousand times does something.\n"
    text += "\n| constant | file | value | a thousandth | a thousand times |\n|---|---|---|---|---|\n"
    extreme = lambda constant: [at(constant, factor) for factor in (0.001, 1000.0)]
    guards = [constant for constant in idle if any(row is not None and int(row[0]) > 0 for row in extreme(constant))]
    for constant in guards:
        text += f"{head(constant)} {' | '.join(cell(row, runs) for row in extreme(constant))} |\n"
    text += "\n## Beyond the suite\n\nA thousandth and a thousand times change no bit either: the constants act only where no run of the suite comes, or choose between ways to the same numbers. Those that no\ntest of the project needs either are candidates for removal.\n"
    text += "\n| constant | file | value |\n|---|---|---|\n"
    text += "".join(f"{head(constant)}\n" for constant in idle if constant not in guards)
    text += "\n## Not varied\n\n| constant | file | value | why |\n|---|---|---|---|\n"
    text += "".join(f"{head(constant)} {constant.fixed} |\n" for constant in all_of_them if constant.fixed)
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
