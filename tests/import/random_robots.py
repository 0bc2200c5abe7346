"""Random MJCF files against MuJoCo: random_robots.py PROGRAM [--trees N] [--loops N] [--seed S] [--no-armature]

Trees: 1 to 8 hinges and slides in one of six plane directions, with random frames, classes, geoms and inertials. Masses, mass centres, moments of inertia and the
accelerations at the start are those of MuJoCo within 1e-9. Loops: the same with a `connect`; the accelerations are those of MuJoCo's mass matrix with exact
closures, M a + J' l = f and J a = -J' v, within 1e-7.
"""

import argparse
import csv
import io
import pathlib
import re
import subprocess
import sys
import tempfile
import tomllib

import mujoco
import numpy as np

PLANES = {"x": ((0, 1, 0), (0, 0, 1)), "y": ((1, 0, 0), (0, 0, 1)), "z": ((1, 0, 0), (0, 1, 0))}


def numbers(values):
    return " ".join(f"{v:.17g}" for v in np.atleast_1d(values))


def rotation(q):
    matrix = np.zeros(9)
    mujoco.mju_quat2Mat(matrix, q)
    return matrix.reshape(3, 3)


class RandomRobot:
    """A robot whose joints move in one plane."""

    def __init__(self, seed, armature):
        self.rng = np.random.default_rng(seed)
        axis = "xyz"[seed % 3]
        self.plane = [np.array(v, float) for v in PLANES[axis]]
        self.normal = np.cross(*self.plane)
        self.flip = 1 if seed % 6 < 3 else -1
        self.armature = armature
        self.names = []
        self.bodies = []
        self.sites = []

    def unit(self):
        vector = self.rng.normal(size=4)
        return vector / np.linalg.norm(vector)

    def geom(self):
        r = self.rng
        kind = r.choice(["sphere", "capsule", "cylinder", "box", "ellipsoid"])
        size = r.uniform(0.01, 0.08, {"sphere": 1, "capsule": 2, "cylinder": 2, "box": 3, "ellipsoid": 3}[kind])
        amount = "" if r.random() < 0.4 else f' density="{r.uniform(500, 8000):.17g}"' if r.random() < 0.5 else f' mass="{r.uniform(0.1, 2):.17g}"'
        ends = r.random() < 0.3 and kind != "sphere"
        pose = f'fromto="{numbers(r.normal(size=6) * 0.2)}"' if ends else f'pos="{numbers(r.normal(size=3) * 0.1)}" quat="{numbers(self.unit())}"'
        shell = ' shellinertia="true" mass="0.7"' if r.random() < 0.15 and kind in ("sphere", "box") else amount
        return f'<geom type="{kind}" size="{numbers(size)}" {pose}{shell} contype="0" conaffinity="0"/>'

    def inertial(self):
        r = self.rng
        a = r.normal(size=(3, 3))
        spread = a @ a.T * 0.01
        tensor = np.trace(spread) * np.eye(3) - spread
        if r.random() < 0.5:
            values, vectors = np.linalg.eigh(tensor)
            return f'<inertial pos="{numbers(r.normal(size=3) * 0.1)}" euler="{numbers(r.uniform(-90, 90, 3))}" mass="{r.uniform(0.1, 3):.17g}" diaginertia="{numbers(values)}"/>'
        full = [tensor[0, 0], tensor[1, 1], tensor[2, 2], tensor[0, 1], tensor[0, 2], tensor[1, 2]]
        return f'<inertial pos="{numbers(r.normal(size=3) * 0.1)}" mass="{r.uniform(0.1, 3):.17g}" fullinertia="{numbers(full)}"/>'

    def joint(self, world):
        r = self.rng
        name = f"j{len(self.names)}"
        slide = r.random() < 0.3
        if slide:
            angle = r.uniform(0, 2 * np.pi)
            axis = np.cos(angle) * self.plane[0] + np.sin(angle) * self.plane[1]
        else:
            axis = self.normal * self.flip * r.choice([1, -1])
        self.names.append((name, slide, float(axis @ self.normal)))
        keys = f'name="{name}" type="{"slide" if slide else "hinge"}" axis="{numbers(world.T @ axis * r.uniform(0.5, 2))}" pos="{numbers(r.normal(size=3) * 0.1)}"'
        if r.random() < 0.4:
            keys += f' damping="{r.uniform(0.01, 1):.17g}"'
        if r.random() < 0.3:
            keys += f' stiffness="{r.uniform(0.1, 5):.17g}" springref="{r.uniform(-30, 30):.17g}"'
        if r.random() < 0.3:
            keys += f' ref="{r.uniform(-40, 40) if not slide else r.uniform(-0.3, 0.3):.17g}"'
        if self.armature and r.random() < 0.4:
            keys += f' armature="{r.uniform(0.001, 0.5):.17g}"'
        if r.random() < 0.3:
            keys += ' class="heavy"'
        return f"<joint {keys}/>"

    def body(self, world, place, depth, left):
        r = self.rng
        name = f"b{len(self.bodies)}"
        self.bodies.append(name)
        turn = self.unit()
        inner = world @ rotation(turn)
        offset = r.normal(size=3) * 0.3
        place = place + world @ offset
        text = f'<body name="{name}" pos="{numbers(offset)}" quat="{numbers(turn)}">'
        # A second joint is across the first, so that no two do the same.
        text += self.joint(inner)
        if r.random() < 0.15 and left > 1:
            text += self.joint(inner)
        text += self.inertial() if r.random() < 0.3 else "".join(self.geom() for _ in range(r.integers(1, 3)))
        if r.random() < 0.2:
            # At the height of the hook, so that the tendon is in the plane.
            self.sites.append(f"s{len(self.bodies)}")
            text += f'<site name="{self.sites[-1]}" pos="{numbers(inner.T @ (self.normal * -(self.normal @ place)))}"/>'
        if r.random() < 0.3:
            turn = self.unit()
            text += f'<frame pos="{numbers(r.normal(size=3) * 0.1)}" quat="{numbers(turn)}">{self.geom()}</frame>'
        if r.random() < 0.2:
            text += f'<body pos="{numbers(r.normal(size=3) * 0.2)}" euler="{numbers(r.uniform(-90, 90, 3))}">{self.geom()}</body>'
        while len(self.names) < self.wanted and r.random() < 0.7 and depth < 6:
            text += self.body(inner, place, depth + 1, self.wanted - len(self.names))
        return text + "</body>"

    def forces(self):
        """Tendons and actuators, with the keyframe's `ctrl` and `act`."""
        r = self.rng
        tendons, actuators, control, states = "", "", [], []
        for index in range(r.integers(0, 2)):
            chosen = r.choice(len(self.names), min(2, len(self.names)), replace=False)
            terms = "".join(f'<joint joint="{self.names[k][0]}" coef="{r.uniform(-2, 2):.17g}"/>' for k in chosen)
            length = "" if r.random() < 0.5 else f' springlength="{numbers(np.sort(r.uniform(-0.5, 0.5, 2)))}"'
            tendons += f'<fixed name="fixed{index}" stiffness="{r.uniform(0, 9):.17g}" damping="{r.uniform(0, 2):.17g}"{length}>{terms}</fixed>'
        if self.sites:
            length = "" if r.random() < 0.5 else f' springlength="{numbers(np.sort(r.uniform(0.1, 0.5, 2)))}"'
            ends = f'<site site="{r.choice(self.sites)}"/><site site="hook"/>'
            tendons += f'<spatial name="coil" stiffness="{r.uniform(0, 90):.17g}" damping="{r.uniform(0, 2):.17g}"{length}>{ends}</spatial>'
        for index in range(r.integers(0, 4)):
            kind = r.choice(["motor", "position", "velocity", "intvelocity", "damper", "general", "filter"])
            target = f'joint="{self.names[r.integers(len(self.names))][0]}"'
            if "fixed0" in tendons and r.random() < 0.3:
                target = 'tendon="fixed0"'
            keys = {
                "motor": "",
                "position": f'kp="{r.uniform(1, 9):.17g}" kv="{r.uniform(0, 2):.17g}"',
                "velocity": f'kv="{r.uniform(1, 9):.17g}"',
                "intvelocity": f'kp="{r.uniform(1, 9):.17g}" actrange="-1 1"',
                "damper": f'kv="{r.uniform(1, 9):.17g}" ctrlrange="0 1"',
                "general": f'gainprm="{r.uniform(1, 9):.17g}" biastype="affine" biasprm="{numbers(r.normal(size=3))}"',
                "filter": f'gainprm="{r.uniform(1, 9):.17g}" dyntype="filter" dynprm="0.2"',
            }[kind]
            limits = "" if kind == "damper" or r.random() < 0.5 else ' ctrlrange="-0.6 0.5" forcerange="-3 2"'
            element = "general" if kind == "filter" else kind
            actuators += f'<{element} name="u{index}" {target} gear="{r.uniform(-3, 3):.17g}" {keys}{limits}/>'
            control.append(r.uniform(0 if kind == "damper" else -1, 1))
            if kind in ("intvelocity", "filter"):
                states.append(r.uniform(-1, 1))
        start = f' ctrl="{numbers(control)}"' if control else ""
        start += f' act="{numbers(states)}"' if states else ""
        return (f"<tendon>{tendons}</tendon>" if tendons else "") + (f"<actuator>{actuators}</actuator>" if actuators else ""), start

    def text(self, loop=False):
        r = self.rng
        self.wanted = int(r.integers(3 if loop else 1, 9))
        bodies = ""
        while len(self.names) < self.wanted:
            bodies += self.body(np.eye(3), np.zeros(3), 0, self.wanted - len(self.names))
        qpos = r.uniform(-1, 1, len(self.names)) * [0.2 if slide else 1.0 for _, slide, _ in self.names]
        # Some stand still: rates that are zero are a part of the start, too.
        qvel = r.uniform(-2, 2, len(self.names)) * (r.random(len(self.names)) < 0.7)
        forces, inputs = ("", "") if loop else self.forces()
        start = "" if loop else f'<keyframe><key qpos="{numbers(qpos)}" qvel="{numbers(qvel)}"{inputs}/></keyframe>'
        close = forces
        if loop:
            first, second = r.choice(self.bodies, 2, replace=False)
            close = f'<equality><connect name="close" body1="{first}" body2="{second}" anchor="{numbers(r.normal(size=3) * 0.3)}"/></equality>'
        gravity = numbers(r.normal(size=3) * 6)
        return (
            f'<mujoco model="random"><option gravity="{gravity}"/><compiler angle="degree"/>'
            '<default><geom density="1500"/><default class="heavy"><joint damping="0.3"/></default></default>'
            f'<worldbody><site name="hook" pos="{numbers(self.plane[0] * 0.4 + self.plane[1] * 0.7)}"/>{bodies}</worldbody>'
            f"{close}{start}</mujoco>"
        )


def closed(model, data):
    """Accelerations at rest with exact closures in the plane, by the pseudoinverse; and how many directions they hold."""
    n = model.nv
    mass = np.zeros((n, n))
    mujoco.mj_fullM(model, data, mass)
    jacobian = []
    for e in range(model.neq):
        a, b = model.eq_obj1id[e], model.eq_obj2id[e]
        rows = []
        for body, point in ((a, model.eq_data[e][:3]), (b, model.eq_data[e][3:6])):
            at = data.xpos[body] + data.xmat[body].reshape(3, 3) @ point
            own = np.zeros((3, n))
            mujoco.mj_jac(model, data, own, None, at, body)
            rows.append(own)
        jacobian.append(rows[0] - rows[1])
    return mass, np.vstack(jacobian)


def check(program, robot, text, folder, loop):
    file, scene = folder / "robot.xml", folder / "scene.toml"
    file.write_text(text)
    scene.unlink(missing_ok=True)
    plane = {0: "yz", 1: "xz", 2: "xy"}[int(np.argmax(np.abs(robot.normal)))]
    done = subprocess.run([program, "import", file, "-o", scene, "--plane", plane], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    parsed = tomllib.loads(scene.read_text())
    model = mujoco.MjModel.from_xml_string(text)
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
    data = mujoco.MjData(model)
    if model.nkey:
        mujoco.mj_resetDataKeyframe(model, data, 0)
    mujoco.mj_forward(model, data)
    acceleration = data.qacc.copy()
    if loop:
        mass, jacobian = closed(model, data)
        if np.linalg.matrix_rank(jacobian, 1e-6) in (0, model.nv):
            return None
        inverse = np.linalg.inv(mass)
        held = jacobian @ inverse @ jacobian.T
        acceleration = acceleration - inverse @ jacobian.T @ np.linalg.pinv(held, 1e-9) @ (jacobian @ acceleration)
    joints = [name for name, *_ in robot.names]
    names = [f"{name}.{'a' if slide else 'alpha'}" for name, slide, _ in robot.names]
    places = [f"{body}.{v}" for body in robot.bodies for v in "xy"]
    done = subprocess.run(
        [program, "simulate", scene, "--stop", "1e-6", "--step", "1e-6", "--variables", ",".join(names + places)], capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr + scene.read_text()
    table = list(csv.reader(io.StringIO(done.stdout)))
    row = {re.sub(r" \[.*", "", head): float(value) for head, value in zip(table[0], table[1])}
    worst = 0.0
    scale = 1 + np.max(np.abs(acceleration))
    for (name, slide, sign), variable, own in zip(robot.names, names, acceleration):
        sign = 1 if slide else np.sign(sign)
        worst = max(worst, abs(row[variable] * sign - own) / scale)
    # Bodies without joints are parts of their parents.
    groups = {}
    for index in range(1, model.nbody):
        groups.setdefault(int(model.body_weldid[index]), []).append(index)
    for top, members in groups.items():
        name = model.body(top).name
        mass = sum(model.body_mass[i] for i in members)
        centre = sum(model.body_mass[i] * data.xipos[i] for i in members) / mass
        inertia = 0.0
        for i in members:
            turn = data.ximat[i].reshape(3, 3)
            own = robot.normal @ turn @ np.diag(model.body_inertia[i]) @ turn.T @ robot.normal
            arm = data.xipos[i] - centre
            arm = arm - robot.normal * (robot.normal @ arm)
            inertia += own + model.body_mass[i] * arm @ arm
        body = parsed["bodies"][name]
        worst = max(worst, abs(body["mass"] - mass) / mass, abs(body["inertia"] - inertia) / inertia)
        for axis, part in zip(robot.plane, "xy"):
            worst = max(worst, abs(row[f"{name}.{part}"] - centre @ axis))
    return worst


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program")
    parser.add_argument("--trees", type=int, default=300)
    parser.add_argument("--loops", type=int, default=100)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--no-armature", action="store_true")
    options = parser.parse_args()
    program = str(pathlib.Path(options.program).resolve())
    failed = 0
    with tempfile.TemporaryDirectory() as folder:
        for loop, count, bound in ((False, options.trees, 1e-9), (True, options.loops, 1e-7)):
            worst, done = 0.0, 0
            for seed in range(options.seed, options.seed + count):
                robot = RandomRobot(seed + (100_000 if loop else 0), not options.no_armature)
                try:
                    own = check(program, robot, robot.text(loop), pathlib.Path(folder), loop)
                except Exception as error:
                    failed += 1
                    print(f"seed {seed} {'loop' if loop else 'tree'}: {str(error)[:600]}")
                    continue
                if own is None:
                    continue
                done += 1
                worst = max(worst, own)
                if not own < bound:
                    failed += 1
                    print(f"seed {seed} {'loop' if loop else 'tree'}: differs by {own:.2e}")
            print(f"{'loops' if loop else 'trees'}: {done} of {count} compared, largest difference {worst:.1e}")
    sys.exit(failed > 0)


if __name__ == "__main__":
    main()
