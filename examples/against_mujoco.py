"""Runs a MJCF file in MuJoCo and the scene that `cotree import` made of it from the same state: against_mujoco.py FILE SCENE [--stop S] [--step S] [--cotree PROGRAM]

Prints how far the mass centre of each body and the angles are apart. MuJoCo holds loops, stops and friction softly: they differ by what `solref` and `solimp` let give.
Needs `pip install mujoco`.
"""

import argparse
import csv
import io
import re
import subprocess
import tomllib

import mujoco
import numpy as np



def scene_rows(program, scene, names, stop, samples):
    command = [program, "simulate", scene, "--stop", repr(stop), "--step", repr(stop / samples), "--variables", ",".join(names)]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode:
        raise SystemExit(done.stderr)
    table = list(csv.reader(io.StringIO(done.stdout)))
    heads = [re.sub(r" \[.*", "", head) for head in table[0]]
    return [dict(zip(heads, map(float, row))) for row in table[1:]]


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("file")
    parser.add_argument("scene")
    parser.add_argument("--stop", type=float, default=1.0)
    parser.add_argument("--step", type=float, help="the time step of MuJoCo instead of the file's")
    parser.add_argument("--cotree", default="cotree")
    options = parser.parse_args()
    with open(options.scene, "rb") as file:
        text = file.read().decode()
    scene = tomllib.loads(text)
    plane = re.search(r"^# plane: ([xyz]-[xyz])", text, re.M)
    if not plane:
        raise SystemExit("the scene does not say which plane of the world it is in")
    across = ["xyz".index(axis) for axis in plane[1].split("-")]
    model = mujoco.MjModel.from_xml_path(options.file)
    data = mujoco.MjData(model)
    if options.step:
        model.opt.timestep = options.step
    if model.nkey == 1:
        mujoco.mj_resetDataKeyframe(model, data, 0)
    bodies = [name for name in scene["bodies"] if mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, name) > 0]
    samples = 20
    rows = scene_rows(options.cotree, options.scene, [f"{body}.{v}" for body in bodies for v in "xy"], options.stop, samples)
    worst = dict.fromkeys(bodies, 0.0)
    for row in rows:
        while data.time < row["time"] - model.opt.timestep / 2:
            mujoco.mj_step(model, data)
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        for body in bodies:
            # A body that others are fixed to has its mass centre with theirs.
            top = model.body(body).id
            members = [i for i in range(model.nbody) if model.body_weldid[i] == model.body_weldid[top]]
            weights = model.body_mass[members]
            centre = weights @ data.xipos[members] / weights.sum()
            apart = np.hypot(*(row[f"{body}.{v}"] - centre[axis] for v, axis in zip("xy", across)))
            worst[body] = max(worst[body], float(apart))
    for body, apart in worst.items():
        print(f"{body}: at most {apart:.3e} m apart in {options.stop:g} s")


if __name__ == "__main__":
    main()
