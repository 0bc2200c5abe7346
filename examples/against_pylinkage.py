"""Five poses of known four-bars: cotree and pylinkage on the same tasks, in one run.

    pip install pylinkage scipy
    python examples/against_pylinkage.py 40 cotree

A task is five poses of the coupler of a random four-bar. A program has the four-bar again if one of its answers has its four lengths
within a millionth. An answer meets a pose if both bars have their lengths there within a millionth.
"""

import cmath
import json
import math
import random
import resource
import subprocess
import sys
import tempfile
from pathlib import Path

from pylinkage.synthesis import Pose, motion_generation

NEAR = 1e-6
# Next to a dead point both ways of the body are near each other: small steps tell them apart.
STEPS = (1000, 100_000)


def four_bar(draw):
    """Pins in the body, pivots, lengths of both bars."""
    point = lambda: complex(draw.uniform(-1, 1), draw.uniform(-1, 1))
    return [(point(), point(), draw.uniform(0.2, 1.2)) for _ in range(2)]


def pose(bars, angle):
    """The body where the first bar has an angle: the position of its origin, and its turn; none out of reach."""
    (a, a0, r), (b, b0, s) = bars
    pin = a0 + cmath.rect(r, angle)
    to, body = b0 - pin, b - a
    cosine = (abs(to) ** 2 + abs(body) ** 2 - s**2) / (2 * abs(to) * abs(body))
    if abs(cosine) > 1:
        return None
    turn = cmath.phase(to / body) + math.acos(cosine)
    return pin - cmath.rect(1, turn) * a, turn


def tasks(count):
    draw = random.Random(5)
    while count:
        bars = four_bar(draw)
        poses = [pose(bars, angle) for angle in sorted(draw.uniform(0, math.tau) for _ in range(5))]
        if all(poses):
            count -= 1
            yield bars, poses


def lengths(bars):
    (a, a0, r), (b, b0, s) = bars
    return [abs(a0 - b0), r, abs(a - b), s]


def is_known(found, known):
    same = lambda order: all(abs(found[i] - known[order[i]]) < NEAR for i in range(4))
    return same([0, 1, 2, 3]) or same([0, 3, 2, 1])


def misses(bars, poses):
    """By how much the bars' lengths change from pose to pose, at most."""
    ways = [[abs(at + cmath.rect(1, turn) * pin - pivot) for at, turn in poses] for pin, pivot, _ in bars]
    return max(max(way) - min(way) for way in ways)


def carried(bars, poses, steps):
    """Does the first bar, turned evenly one way, carry the body through all poses, in order and without a dead point?"""
    (a, a0, _), (b, b0, s) = bars
    angles = [cmath.phase(at + cmath.rect(1, turn) * a - a0) for at, turn in poses]

    def body(angle, before):
        pin = a0 + cmath.rect(bars[0][2], angle)
        to, own = b0 - pin, b - a
        cosine = (abs(to) ** 2 + abs(own) ** 2 - s**2) / (2 * abs(to) * abs(own))
        if abs(cosine) > 1 + 1e-9:
            return None
        ways = [cmath.phase(to / own) + side * math.acos(max(-1.0, min(1.0, cosine))) for side in (1, -1)]
        return min(ways, key=lambda way: abs(cmath.phase(cmath.rect(1, way - before))))

    for sense in (1, -1):
        way, turn, angle = 0.0, poses[0][1], angles[0]
        for next_angle, (_, wanted) in zip(angles[1:], poses[1:]):
            step = sense * ((sense * (next_angle - angle)) % math.tau)
            way += abs(step)
            for part in range(1, steps + 1):
                turn = body(angle + step * part / steps, turn)
                if turn is None:
                    break
            if turn is None or abs(cmath.phase(cmath.rect(1, turn - wanted))) > NEAR:
                break
            angle = next_angle
        else:
            if way < math.tau:
                return True
    return False


def of_pylinkage(poses):
    given = [Pose(at.real, at.imag, turn) for at, turn in poses]
    result = motion_generation(given, max_solutions=None, require_grashof=False)
    answers = []
    (at, turn) = poses[0]
    for own in result.raw_solutions:
        pivots = [complex(*own.ground_pivot_a), complex(*own.ground_pivot_d)]
        pins = [(complex(*pin) - at) * cmath.rect(1, -turn) for pin in (own.crank_pivot_b, own.coupler_pivot_c)]
        answers.append([(pin, pivot, abs(at + cmath.rect(1, turn) * pin - pivot)) for pin, pivot in zip(pins, pivots)])
    return answers


def of_cotree(program, folder, poses):
    task = folder / "task.json"
    task.write_text(json.dumps({"name": "task", "poses": {"at": [[at.real, at.imag, turn] for at, turn in poses]}}))
    done = subprocess.run([program, "synthesize", str(task), "--json", "--all"], capture_output=True, text=True, check=True)
    answer = json.loads(done.stdout)
    bar = lambda own: (complex(*own["moving"]), complex(*own["ground"]), own["length"])
    good = [own for own in answer["solutions"] if own["reason"] is None]
    four_bars = lambda all: [
        [bar(own["first"]), bar(own["second"])] for own in all if own["first"]["kind"] == own["second"]["kind"] == "RR"
    ]
    return four_bars(answer["solutions"]), four_bars(good)


def used():
    return sum(own.ru_utime + own.ru_stime for own in map(resource.getrusage, (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)))


def main():
    count, program = int(sys.argv[1]), sys.argv[2]
    names = ("cotree", "pylinkage")
    known, answers, met, seconds, none = ({name: 0 for name in names} for _ in range(5))
    printed, defects, good = 0, 0, []
    with tempfile.TemporaryDirectory() as folder:
        for bars, poses in tasks(count):
            for name in names:
                begin = used()
                try:
                    if name == "cotree":
                        found, good = of_cotree(program, Path(folder), poses)
                    else:
                        found = of_pylinkage(poses)
                except Exception as error:  # an answer of its kind
                    print(f"{name}: {error}")
                    found = []
                seconds[name] += used() - begin
                if name == "cotree":
                    printed += len(good)
                    defects += sum(not any(carried(own, poses, steps) for steps in STEPS) for own in good)
                known[name] += any(is_known(lengths(own), lengths(bars)) for own in found)
                none[name] += not found
                answers[name] += len(found)
                met[name] += sum(misses(own, poses) < NEAR for own in found)
    for name in names:
        print(
            f"{name:10} {known[name]} of {count} four-bars again; {answers[name]} answers, {met[name]} of which meet all five poses; "
            f"{none[name]} tasks without an answer; {1e3 * seconds[name] / count:.1f} ms of processor time for a task"
        )
    print(f"cotree: {printed} answers are called good; {defects} of them do not carry the body through the poses in one motion")


if __name__ == "__main__":
    main()
