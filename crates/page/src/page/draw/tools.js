// @ts-check
// What the tools do: each action is an edit of the text.
import { digits12, written } from "../common.js";
import { called, far, gridStep, minus, plus, points, turned, view, world } from "./stage.js";
import { drawing } from "./main.js";
export const tool = { name: "move", first: null, typed: "", cursor: [0, 0], met: null, grabbed: null, keys: false };
const number = (name) => drawing.sketch.numbers.find((own) => own.name === name);
const oneWay = (angle) => Math.atan2(Math.sin(angle), Math.cos(angle));

/** Where the origin of a body's own frame is in the world, by one of its points whose coordinates are plain numbers. */
function origin(body) {
  const { name, start: [, , angle] } = drawing.sketch.geometry.bodies[body];
  for (const point of points().filter((own) => own.body === body)) {
    const [x, y] = ["x", "y"].map((axis) => number(`${name}.${point.name}.${axis}`));
    if (x && y) return minus(point.at, turned([x.value, y.value], angle));
  }
  throw new Error(`the points of \`${name}\` are written as expressions: add a point to it in the text`);
}
/** Digits of what is drawn: poses are known to some more. What is a short number but for rounding is that number. */
const drawn = (value) => {
  const short = +value.toPrecision(6);
  return `${Math.abs(short - value) <= 2e-9 * Math.abs(value) ? short : +value.toPrecision(10)}`;
};
/** A length on the grid, where rounding alone keeps it off that. */
function onStep(value) {
  const step = gridStep(), near = Math.round(1e3 * value / step) * step / 1e3;
  return Math.abs(value - near) < 1e-7 * step ? near : value;
}
/** A length as it is drawn, in millimetres. */
export function metres(value) {
  const length = onStep(value);
  return Math.abs(length) < 5e-13 ? "0" : `"${drawn(1e3 * length)} mm"`;
}
export const degrees = (value) => `"${drawn(180 / Math.PI * value)} deg"`;
const vector = (at) => `[${at.map(metres).join(", ")}]`;

/** What a tool does at once: edits of the text, which the front end makes, and the names that they give. */
export class Plan {
  constructor(text) {
    this.text = text;
    this.names = new Set();
    this.edits = [];
  }
  /** A name that nothing has. */
  name(wanted) {
    for (let k = 1;; k++) {
      const name = k === 1 ? wanted : `${wanted}${k}`;
      if (this.names.has(name) || new RegExp(`(?<![A-Za-z0-9_])${name}(?![A-Za-z0-9_])`).test(this.text)) continue;
      this.names.add(name);
      return name;
    }
  }
  /** A table with its keys under a name of its own. */
  add(table, wanted, keys) {
    const name = this.name(wanted);
    this.edits.push({ edit: "add", path: [table, name], keys });
    return name;
  }
  point(owner, name, at) {
    this.edits.push({ edit: "point", owner, name, at: vector(at) });
    return `${owner}.${name}`;
  }
  initial(name, value) {
    this.edits.push({ edit: "set", path: ["initial", name], value: `{ guess = ${value} }` });
  }
  /** A place as joints and loads name it; a point is made where there is none. */
  place({ kind, owner, name, body, at }, wanted) {
    if (kind === "point") return `${owner}.${name}`;
    if (kind !== "body") return this.point("ground", this.name(wanted), at);
    const { start: [, , angle] } = drawing.sketch.geometry.bodies[body];
    return this.point(owner, this.name(wanted === "pivot" ? "pin" : wanted), turned(minus(at, origin(body)), -angle));
  }
  join(type, name, ends, more = []) {
    this.add("joints", name, [["type", `"${type}"`], ["between", `["${ends[0]}", "${ends[1]}"]`], ...more]);
  }
  /** A load between two places, with its keys for their distance. */
  stretch(type, from, to, keys) {
    if (from.body === to.body && from.kind !== "free" && to.kind !== "free") throw new Error(`a ${type} joins two bodies, or a body and the ground`);
    const ends = [from, to].map((end) => this.place(end, "anchor"));
    this.add("loads", type, [["type", `"${type}"`], ["between", `["${ends[0]}", "${ends[1]}"]`], ...keys(far(from.at, to.at))]);
  }
  remove(name, tables) {
    this.edits.push({ edit: "remove", name, tables });
  }
}

export const TOOLS = {
  move: { key: "v", say: "Move", hint: "drag a point: what hangs on it follows; drag the ground to move the view" },
  bar: {
    key: "b",
    say: "Bar",
    count: 2,
    hint: "from one end to the other; an end on a point or a bar is pinned to it; a length can be typed: 120, or 120<45; 1 kg per metre, `density` in the text",
    act(plan, from, to) {
      const length = far(from.at, to.at);
      if (length * view.scale < 6) throw new Error("a bar needs two ends that are apart");
      const name = plan.add("bodies", "bar", [["points", `{ a = [0, 0], b = [${metres(length)}, 0] }`], ["shape", `{ rod = ["a", "b"], density = "1 kg/m" }`]]);
      for (const [end, at] of [["a", from], ["b", to]]) if (at.kind !== "free") plan.join("revolute", "pin", [plan.place(at, "pin"), `${name}.${end}`]);
      const middle = plus(from.at, to.at).map((value) => value / 2), way = minus(to.at, from.at);
      if (from.kind === "free" && to.kind === "free") ["x", "y"].forEach((axis, k) => plan.initial(`${name}.${axis}`, metres(middle[k])));
      plan.initial(`${name}.angle`, degrees(Math.atan2(way[1], way[0])));
    },
  },
  pin: {
    key: "p",
    say: "Pin",
    count: 1,
    hint: "on a point: pins it to what lies there, else to the ground",
    act(plan, at) {
      if (at.kind === "point" && at.body !== null) {
        const joints = drawing.sketch.geometry.joints,
          holds = (one, other) =>
            joints.some(({ ends }) =>
              [[0, 1], [1, 0]].some(([i, k]) => ends[i].body === one && ends[k].body === other && far(world(ends[i]), at.at) < 1e-9 * (1 + Math.abs(at.at[0])))
            );
        const other = points().find((own) => own.body !== at.body && far(own.at, at.at) * view.scale < 3 && !holds(own.body, at.body));
        if (other) {
          plan.join("revolute", "pin", [`${other.owner}.${other.name}`, `${at.owner}.${at.name}`]);
          return;
        }
      }
      if (at.kind === "point" && at.body === null) throw new Error(`${called(at)} is in the ground already`);
      if (at.kind === "free") {
        plan.place(at, "pivot");
        return;
      }
      const body = plan.place(at, "pin");
      plan.join("revolute", "pin", [plan.place({ kind: "free", at: at.at }, "pivot"), body]);
    },
  },
  slider: {
    key: "s",
    say: "Slider",
    count: 2,
    hint: "on a point, then where its rail leads: a block on the ground",
    act(plan, at, to) {
      if (at.kind === "free") throw new Error("a slider begins at a point of a body");
      const way = axis(at.at, to.at),
        end = plan.place(at, "pin"),
        block = plan.add("bodies", "block", [["mass", `"0.1 kg"`]]),
        rail = plan.place({ kind: "free", at: at.at }, "rail");
      plan.join("revolute", "pin", [end, block]);
      plan.join("prismatic", "slider", [rail, block], [["axis", way]]);
    },
  },
  slot: {
    key: "o",
    say: "Slot",
    count: 2,
    hint: "on a point, then where the slot leads: a slot in the ground",
    act(plan, at, to) {
      if (at.kind === "free") throw new Error("a slot begins at a point of a body");
      const way = axis(at.at, to.at), end = plan.place(at, "pin"), ground = plan.place({ kind: "free", at: at.at }, "rail");
      plan.join("slot", "slot", [ground, end], [["axis", way]]);
    },
  },
  spring: {
    key: "g",
    say: "Spring",
    count: 2,
    hint: "from one end to the other",
    act: (plan, from, to) => plan.stretch("spring", from, to, (length) => [["stiffness", `"1000 N/m"`], ["length", metres(length)]]),
  },
  damper: {
    key: "d",
    say: "Damper",
    count: 2,
    hint: "from one end to the other",
    act: (plan, from, to) => plan.stretch("damper", from, to, () => [["damping", `"10 N.s/m"`]]),
  },
  motor: {
    key: "m",
    say: "Motor",
    count: 1,
    hint: "on a pin: it turns once in a second",
    act(plan, at) {
      const joint = drawing.sketch.geometry?.joints.filter(({ hold }) => hold === "pin").map((own) => [far(world(own.ends[1]), at.at) * view.scale, own])
        .filter(([d]) => d < 14).sort((a, b) => Number(a[1].ends[0].body !== null) - Number(b[1].ends[0].body !== null))[0]?.[1];
      if (!joint) throw new Error("a motor turns a pin: choose one");
      plan.add("drivers", "motor", [["joint", `"${joint.name}"`], ["angle", `"${drawn(180 / Math.PI * jointAngle(joint))}[deg] + 2*pi*t"`]]);
    },
  },
  tracer: {
    key: "t",
    say: "Tracer",
    count: 1,
    hint: "on a body: its path is drawn",
    act(plan, at) {
      if (at.kind === "free" || at.body === null) throw new Error("a tracer is a point of a body");
      const point = plan.place(at, "tracer");
      for (const axis of ["x", "y"]) plan.edits.push({ edit: "output", name: `${point}.${axis}` });
    },
  },
  load: {
    key: "l",
    say: "Load",
    count: 2,
    hint: "from a point of a body, the way the force acts: 100 pixels are 10 N",
    act(plan, at, to) {
      if (at.kind === "free" || at.body === null) throw new Error("a force acts on a body");
      const point = plan.place(at, "grip"), force = minus(to.at, at.at).map((value) => Math.round(value * view.scale / 10));
      if (!force[0] && !force[1]) throw new Error("a force needs a direction: draw it away from the body");
      plan.add("loads", "load", [["type", `"force"`], ["on", `"${point}"`], ["vector", `[${force.map((value) => `"${value} N"`).join(", ")}]`]]);
    },
  },
  remove: {
    key: "x",
    say: "Remove",
    count: 1,
    hint: "a joint, a load, a point or a body: what is shown on top there",
    act(plan, at, _, target) {
      const part = target?.closest?.("[data-load],[data-joint]"), name = part?.dataset.load ?? part?.dataset.joint;
      if (name) {
        plan.remove(name, ["joints", "drivers", "loads"]);
        return;
      }
      if (at.kind === "free") throw new Error("there is nothing to remove here");
      // A joint lies over the points that it joins; the keyboard has no target, so this is by the place.
      const joint = at.kind === "point"
        ? drawing.sketch.geometry?.joints.findLast(({ ends }) => ends.some((end) => far(world(end), at.at) * view.scale < 1))
        : null;
      if (joint) plan.remove(joint.name, ["joints"]);
      else if (at.kind === "point") plan.edits.push({ edit: "remove_point", owner: at.owner, name: at.name });
      else plan.remove(at.owner, ["bodies"]);
    },
  },
};
const axis = (from, to) => {
  const way = minus(to, from), length = Math.hypot(...way);
  if (length * view.scale < 6) throw new Error("draw the way that it leads");
  return `[${way.map((value) => digits12(+(value / length).toFixed(12))).join(", ")}]`;
};
/** The angle of a joint: the second body's minus the first's. */
function jointAngle({ ends }, angles = drawing.sketch.geometry.bodies.map(({ start }) => start[2])) {
  const [one, other] = ends.map(({ body }) => body === null ? 0 : angles[body]);
  return oneWay(other - one);
}
/** The edits by which a point, with all that is pinned there, is somewhere else: the other points stay. */
export function moved(grabbed, to) {
  const plan = new Plan(""),
    all = points(),
    here = all.filter((own) => far(own.at, grabbed.at) * view.scale < .5),
    places = [],
    angles = drawing.sketch.geometry?.bodies.map(({ start }) => start[2]) ?? [];
  const known = (name) => {
    const own = number(name);
    if (!own) throw new Error(`\`${name}\` is not written as a plain number: change what it is made of, in the text or under “Change” below`);
    return own;
  };
  const set = (name, value) => {
    const own = known(name);
    if (Math.abs(own.value - value) > 1e-13 * (1 + Math.abs(value))) {
      places.push([...own.place, own.is_bare_zero ? metres(value) : written(onStep(value), own)]);
    }
  };
  const guess = (name, value, isNeeded) => {
    const own = number(name), text = name.endsWith("angle") ? degrees(value) : metres(value);
    if (own) places.push([...own.place, text]);
    else if (isNeeded) plan.initial(name, text);
  };
  for (const point of here) {
    if (point.body === null) {
      ["x", "y"].forEach((word, k) => set(`ground.${point.name}.${word}`, to[k]));
      continue;
    }
    const { start: [, , angle] } = drawing.sketch.geometry.bodies[point.body], own = all.filter((other) => other.body === point.body), [first, second] = own;
    const zeros = own.length === 2 && [`${first.name}.x`, `${first.name}.y`, `${second.name}.y`].every((word) =>
      number(`${point.owner}.${word}`)?.value === 0
    ) && number(`${point.owner}.${second.name}.x`)?.value > 0;
    if (zeros) {
      const [a, b] = own.map((other) => here.includes(other) ? to : other.at), way = minus(b, a), now = angle + oneWay(Math.atan2(way[1], way[0]) - angle);
      if (Math.hypot(...way) < 1e-9) throw new Error("the ends of a bar are apart");
      set(`${point.owner}.${second.name}.x`, Math.hypot(...way));
      guess(`${point.owner}.angle`, now, true);
      ["x", "y"].forEach((word, k) => guess(`${point.owner}.${word}`, (a[k] + b[k]) / 2, false));
      angles[point.body] = now;
    } else {
      for (const word of ["x", "y"]) known(`${point.owner}.${point.name}.${word}`);
      const at = turned(minus(to, origin(point.body)), -angle);
      ["x", "y"].forEach((word, k) => set(`${point.owner}.${point.name}.${word}`, at[k]));
    }
  }
  // Motors begin where the bars are now.
  for (const joint of drawing.sketch.geometry?.joints ?? []) {
    const by = oneWay(jointAngle(joint, angles) - jointAngle(joint));
    if (Math.abs(by) >= 1e-12) plan.edits.push({ edit: "turn", joint: joint.name, by });
  }
  return [{ edit: "write", places }, ...plan.edits];
}
