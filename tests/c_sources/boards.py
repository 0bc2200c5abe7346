"""C sources on boards, under qemu: double precision on a Cortex-M7 and single precision on a Cortex-M4F have the bits of this machine, and every step takes the same number of instructions.

usage: boards.py COTREE MODELS WORK
Needs arm-none-eabi-gcc with newlib, and qemu-system-arm.
"""

import struct
import subprocess
import sys
from pathlib import Path

STEPS = 2000
MODELS = {"cart_pole": 2, "bench_slider_crank": 2, "four_bar": 3}
FLAGS = ["-std=c99", "-O2", "-ffp-contract=off", "-Wall", "-Wextra", "-Werror"]
# The processor, its floating-point unit, and the machine of qemu that has it.
BOARDS = {
    "cortex-m7": ("fpv5-d16", "mps2-an500"),
    "cortex-m4": ("fpv4-sp-d16", "mps2-an386"),
}
HERE = Path(__file__).parent
# How far single precision may be from double precision, and by how much two steps may differ in their instructions.
APART = 5e-4
SPREAD = 0.01
# Pairs of runs, whose difference is a step; the first is from the start.
COUNTED = [0, 1, 1, 2, 2, 3, 40, 41, 99, 100]


def output(*command):
    done = subprocess.run([str(part) for part in command], capture_output=True, text=True, check=False)
    assert done.returncode == 0, f"{command}: {done.stdout}{done.stderr}"
    return done.stdout


def built(source, board, steps, coordinates, place):
    """A program for a board, or for this machine."""
    printed = [f"-DCOORDINATES={coordinates}"] if coordinates else []
    command = ["gcc", HERE / "board.c"]
    if board is not None:
        options = ["-mthumb", f"-mcpu={board}", f"-mfpu={BOARDS[board][0]}", "-mfloat-abi=hard", "--specs=rdimon.specs"]
        command = ["arm-none-eabi-gcc", *options, "-T", HERE / "board.ld", HERE / "start.c", HERE / "board.c"]
    output(*command, *FLAGS, f'-DMODEL_FILE="{source}"', f"-DSTEPS={steps}", *printed, "-o", place, "-lm")
    return place


def run(board, program, *options):
    machine = ["-M", BOARDS[board][1], "-nographic", "-semihosting-config", "enable=on,target=native"]
    return output("qemu-system-arm", *machine, *options, "-kernel", program)


def numbers(text):
    return [struct.unpack(">d", bytes.fromhex(line))[0] for line in text.split()]


def state(source, board, coordinates, work):
    program = built(source, board, STEPS, coordinates, work / "program")
    return output(program) if board is None else run(board, program)


def instructions(source, board, steps, work):
    """How many a run executes: one line of the log each."""
    program, log = built(source, board, steps, 0, work / "counted"), work / "instructions"
    run(board, program, "-singlestep", "-d", "exec,nochain", "-D", log)
    with log.open() as lines:
        return sum(line.startswith("Trace") for line in lines)


def counts(source, board, work):
    """Instructions of a few steps."""
    runs = [instructions(source, board, steps, work) for steps in COUNTED]
    return [later - before for before, later in zip(runs[::2], runs[1::2])]


def main(cotree, models, work):
    work = Path(work).resolve()
    work.mkdir(parents=True, exist_ok=True)
    for model, coordinates in MODELS.items():
        for order in ("4", "8"):
            sources = {}
            for real in ("double", "float"):
                sources[real] = work / f"{model}_{order}_{real}.c"
                scene = Path(models) / model / "scene.toml"
                output(cotree, "export", scene, "--c", sources[real], "--step", "1 ms", "--order", order, "--real", real)
            here = {real: state(sources[real], None, coordinates, work) for real in sources}
            for board, real in (("cortex-m7", "double"), ("cortex-m4", "float")):
                assert state(sources[real], board, coordinates, work) == here[real], f"{model}, order {order}, {real}: other bits"
            apart = max(abs(a - b) for a, b in zip(numbers(here["float"]), numbers(here["double"])))
            assert apart < APART, f"{model}, order {order}: {apart}"
            for board, real in (("cortex-m7", "double"), ("cortex-m4", "float")):
                steps = counts(sources[real], board, work)
                assert max(steps) - min(steps) < SPREAD * min(steps), f"{model}, order {order}, {real}: {steps}"
                print(f"{model}, order {order}, {board} ({real}): {steps} instructions in a step")
            print(f"{model}, order {order}: the bits of this machine; float is within {apart:.1e} of double")


if __name__ == "__main__":
    main(*sys.argv[1:])
