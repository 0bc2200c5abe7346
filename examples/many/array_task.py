"""One task of a job array: the chunk with its number, into a file of its own. A task that was lost is simply run again.

Each file has the mark of its campaign: the scene, the measures, the parameters of all runs and the number of tasks. A folder holds one campaign; another one is refused.

With Slurm:

    sbatch --array=0-7 --cpus-per-task=1 --wrap "python examples/many/array_task.py 20000 8 out"
    sbatch --dependency=afterok:$JOB --wrap "python examples/many/array_task.py 20000 8 out --join"

usage: array_task.py RUNS TASKS FOLDER [--join]        the task's number is SLURM_ARRAY_TASK_ID
"""

import hashlib
import os
import sys
from pathlib import Path

import numpy as np
from runs import MEASURES, chunks, parameters, work

import cotree

SCENE = Path(__file__).parents[2] / "models/slider_crank/scene.toml"


def mark(runs: int, tasks: int) -> str:
    """Names the campaign: whatever changes a run or its place changes this."""
    digest = hashlib.sha256(SCENE.read_bytes())
    digest.update(repr((runs, tasks, MEASURES)).encode())
    for name, column in parameters(runs).items():
        digest.update(name.encode() + column.tobytes())
    return digest.hexdigest()


def refuse_others(folder: Path, own: str) -> None:
    """Ends the program if the folder has files of another campaign."""
    others = sorted(place.name for place in folder.glob("*.npz") if str(np.load(place)["mark"]) != own)
    if others:
        sys.exit(f"error: {folder} has files of another campaign (other runs, tasks, measures or scene): {', '.join(others)}; choose another folder")


def task(runs: int, tasks: int, folder: Path, number: int) -> None:
    place, own = folder / f"{number}.npz", mark(runs, tasks)
    refuse_others(folder, own)
    if place.exists():
        return  # done by an earlier attempt
    rows, _ = work(cotree.load(SCENE), chunks(runs, tasks)[number])
    folder.mkdir(parents=True, exist_ok=True)
    unfinished = folder / f"{number}.{os.getpid()}.part"
    with unfinished.open("wb") as file:
        np.savez(file, rows=rows, mark=own)
    unfinished.rename(place)


def join(runs: int, tasks: int, folder: Path) -> None:
    refuse_others(folder, mark(runs, tasks))
    missing = [number for number in range(tasks) if not (folder / f"{number}.npz").exists()]
    if missing:
        sys.exit(f"error: tasks {missing} are missing; submit them again with --array={','.join(map(str, missing))}")
    values = np.concatenate([np.load(folder / f"{number}.npz")["rows"] for number in range(tasks)])
    for name, column in zip(MEASURES, values.T, strict=True):
        print(f"{name}: mean {column.mean():.9g}, standard deviation {column.std():.6g}")
    print(f"{len(values)} runs")


if __name__ == "__main__":
    if len(sys.argv) < 4:
        sys.exit(__doc__)
    if "--join" in sys.argv:
        join(int(sys.argv[1]), int(sys.argv[2]), Path(sys.argv[3]))
    else:
        number, tasks = os.environ.get("SLURM_ARRAY_TASK_ID", ""), int(sys.argv[2])
        if not number.isdecimal() or int(number) >= tasks:
            sys.exit(f"error: SLURM_ARRAY_TASK_ID is {number!r}, not one of 0 to {tasks - 1}; an array of jobs sets it")
        task(int(sys.argv[1]), tasks, Path(sys.argv[3]), int(number))
