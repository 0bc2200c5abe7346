"""One task of a job array: the chunk with its number, into a file of its own. A task that was lost is simply run again.

With Slurm:

    sbatch --array=0-7 --cpus-per-task=1 --wrap "python examples/many/array_task.py 20000 8 out"
    sbatch --dependency=afterok:$JOB --wrap "python examples/many/array_task.py 20000 8 out --join"

usage: array_task.py RUNS TASKS FOLDER [--join]        the task's number is SLURM_ARRAY_TASK_ID
"""

import os
import sys
from pathlib import Path

import numpy as np
from runs import MEASURES, chunks, work

import cotree

SCENE = Path(__file__).parents[2] / "models/slider_crank/scene.toml"


def task(runs: int, tasks: int, folder: Path, number: int) -> None:
    place = folder / f"{number}.npy"
    if place.exists():
        return  # done by an earlier attempt
    rows, _ = work(cotree.load(SCENE), chunks(runs, tasks)[number])
    folder.mkdir(parents=True, exist_ok=True)
    unfinished = folder / f"{number}.{os.getpid()}.part"
    with unfinished.open("wb") as file:
        np.save(file, rows)
    unfinished.rename(place)


def join(tasks: int, folder: Path) -> None:
    missing = [number for number in range(tasks) if not (folder / f"{number}.npy").exists()]
    if missing:
        sys.exit(f"error: tasks {missing} are missing; submit them again with --array={','.join(map(str, missing))}")
    values = np.concatenate([np.load(folder / f"{number}.npy") for number in range(tasks)])
    for name, column in zip(MEASURES, values.T, strict=True):
        print(f"{name}: mean {column.mean():.9g}, standard deviation {column.std():.6g}")
    print(f"{len(values)} runs")


if __name__ == "__main__":
    if len(sys.argv) < 4:
        sys.exit(__doc__)
    if "--join" in sys.argv:
        join(int(sys.argv[2]), Path(sys.argv[3]))
    else:
        number, tasks = os.environ.get("SLURM_ARRAY_TASK_ID", ""), int(sys.argv[2])
        if not number.isdecimal() or int(number) >= tasks:
            sys.exit(f"error: SLURM_ARRAY_TASK_ID is {number!r}, not one of 0 to {tasks - 1}; an array of jobs sets it")
        task(int(sys.argv[1]), tasks, Path(sys.argv[3]), int(number))
