// What the tools do: each action is an edit of the text.
const tool = { name: "move", first: null, typed: "", cursor: [0, 0], met: null, grabbed: null, keys: false };
const number = name => drawing.sketch.numbers.find(own => own.name === name);
const oneWay = angle => Math.atan2(Math.sin(angle), Math.cos(angle));

/** Where the origin of a body's own frame is in the world, by one of its points whose coordinates are plain numbers. */
function origin(body) {
  const { name, start: [, , angle] } = drawing.sketch.geometry.bodies[body];
  for (const point of points().filter(own => own.body === body)) {
    const [x, y] = ["x", "y"].map(axis => number(`${name}.${point.name}.${axis}`));
    if (x && y) return minus(point.at, turned([x.value, y.value], angle));
  }
  throw new Error(`the points of \`${name}\` are written as expressions: add a point to it in the text`);
}
/** The name of a place for joints and loads, with the text in which it is. */
function named(text, { kind, owner, name, body, at }, wanted) {
  if (kind === "point") return [text, `${owner}.${name}`];
  if (kind === "body") {
    const fresh = freshName(text, wanted === "pivot" ? "pin" : wanted), { start: [, , angle] } = drawing.sketch.geometry.bodies[body];
    return [addPoint(text, owner, fresh, turned(minus(at, origin(body)), -angle)), `${owner}.${fresh}`];
  }
  const fresh = freshName(text, wanted);
  return [addLine(text, "ground.points", `${fresh} = [${at.map(metres).join(", ")}]`), `ground.${fresh}`];
}
const joined = (text, type, name, ends, more = []) => addTable(text, `joints.${freshName(text, name)}`, [`type    = "${type}"`, `between = [${ends.map(end => `"${end}"`).join(", ")}]`, ...more]);

const TOOLS = {
  move: { key: "v", say: "Move", hint: "drag a point: the parts connected to it follow; drag the background to move the view" },
  bar: {
    key: "b", say: "Bar", count: 2, hint: "from one end to the other; an end on a point or a bar is pinned to it; a length can be typed: 120, or 120<45; 1 kg per metre, `density` in the text",
    act(text, from, to) {
      const length = far(from.at, to.at), name = freshName(text, "bar");
      if (length * view.scale < 6) throw new Error("a bar needs two different ends");
      text = addTable(text, `bodies.${name}`, [`points = { a = [0, 0], b = [${metres(length)}, 0] }`, `shape  = { rod = ["a", "b"], density = "1 kg/m" }`]);
      for (const [end, at] of [["a", from], ["b", to]]) {
        if (at.kind === "free") continue;
        const [more, other] = named(text, at, "pin");
        text = joined(more, "revolute", "pin", [other, `${name}.${end}`]);
      }
      const middle = plus(from.at, to.at).map(value => value / 2), way = minus(to.at, from.at);
      if (from.kind === "free" && to.kind === "free") ["x", "y"].forEach((axis, k) => { text = addLine(text, "initial", `"${name}.${axis}" = { guess = ${metres(middle[k])} }`); });
      return addLine(text, "initial", `"${name}.angle" = { guess = ${degrees(Math.atan2(way[1], way[0]))} }`);
    },
  },
  pin: {
    key: "p", say: "Pin", count: 1, hint: "on a point: pins it to another body there, else to the ground",
    act(text, at) {
      if (at.kind === "point" && at.body !== null) {
        const joints = drawing.sketch.geometry.joints, holds = (one, other) => joints.some(({ ends }) => [[0, 1], [1, 0]].some(([i, k]) => ends[i].body === one && ends[k].body === other && far(world(ends[i]), at.at) < 1e-9 * (1 + Math.abs(at.at[0]))));
        const other = points().find(own => own.body !== at.body && far(own.at, at.at) * view.scale < 3 && !holds(own.body, at.body));
        if (other) return joined(text, "revolute", "pin", [`${other.owner}.${other.name}`, `${at.owner}.${at.name}`]);
      }
      if (at.kind === "point" && at.body === null) throw new Error(`${called(at)} is in the ground already`);
      if (at.kind === "free") return named(text, at, "pivot")[0];
      const [first, body] = named(text, at, "pin"), [second, ground] = named(first, { kind: "free", at: at.at }, "pivot");
      return joined(second, "revolute", "pin", [ground, body]);
    },
  },
  slider: {
    key: "s", say: "Slider", count: 2, hint: "on a point, then in the direction of its rail: a slider on the ground",
    act(text, at, to) {
      if (at.kind === "free") throw new Error("a slider begins at a point of a body");
      const [first, end] = named(text, at, "pin"), block = freshName(first, "block");
      const [second, rail] = named(addTable(first, `bodies.${block}`, [`mass = "0.1 kg"`]), { kind: "free", at: at.at }, "rail");
      return joined(joined(second, "revolute", "pin", [end, block]), "prismatic", "slider", [rail, block], [`axis    = ${axis(at.at, to.at)}`]);
    },
  },
  slot: {
    key: "o", say: "Slot", count: 2, hint: "on a point, then in the direction of the slot: a slot in the ground",
    act(text, at, to) {
      if (at.kind === "free") throw new Error("a slot begins at a point of a body");
      const [first, end] = named(text, at, "pin"), [second, ground] = named(first, { kind: "free", at: at.at }, "rail");
      return joined(second, "slot", "slot", [ground, end], [`axis    = ${axis(at.at, to.at)}`]);
    },
  },
  spring: { key: "g", say: "Spring", count: 2, hint: "from one end to the other", act: (text, from, to) => stretched(text, from, to, "spring", length => [`stiffness = "1000 N/m"`, `length    = ${metres(length)}`]) },
  damper: { key: "d", say: "Damper", count: 2, hint: "from one end to the other", act: (text, from, to) => stretched(text, from, to, "damper", () => [`damping = "10 N.s/m"`]) },
  motor: {
    key: "m", say: "Motor", count: 1, hint: "on a pin: it turns once per second",
    act(text, at) {
      const joint = drawing.sketch.geometry?.joints.filter(({ hold }) => hold === "pin").map(own => [far(world(own.ends[1]), at.at) * view.scale, own]).filter(([d]) => d < 14).sort((a, b) => (a[1].ends[0].body !== null) - (b[1].ends[0].body !== null))[0]?.[1];
      if (!joint) throw new Error("a motor turns a pin: choose one");
      const law = `${drawn(180 / Math.PI * jointAngle(joint))}[deg] + 2*pi*t`;
      return addTable(text, `drivers.${freshName(text, "motor")}`, [`joint = "${joint.name}"`, `angle = "${law}"`]);
    },
  },
  tracer: {
    key: "t", say: "Tracer", count: 1, hint: "on a body: its path is drawn",
    act(text, at) {
      if (at.kind === "free" || at.body === null) throw new Error("a tracer is a point of a body");
      const [more, point] = named(text, at, "tracer");
      return addOutputs(more, [`${point}.x`, `${point}.y`]);
    },
  },
  load: {
    key: "l", say: "Load", count: 2, hint: "from a point of a body, the way the force acts: 100 pixels are 10 N",
    act(text, at, to) {
      if (at.kind === "free" || at.body === null) throw new Error("a force acts on a body");
      const [more, point] = named(text, at, "grip"), force = minus(to.at, at.at).map(value => Math.round(value * view.scale / 10));
      if (!force[0] && !force[1]) throw new Error("a force needs a direction: draw it away from the body");
      return addTable(more, `loads.${freshName(more, "load")}`, [`type   = "force"`, `on     = "${point}"`, `vector = [${force.map(value => `"${value} N"`).join(", ")}]`]);
    },
  },
  remove: {
    key: "x", say: "Remove", count: 1, hint: "removes the topmost joint, load, point or body",
    act(text, at, _, target) {
      const part = target?.closest?.("[data-load],[data-joint]"), name = part?.dataset.load ?? part?.dataset.joint;
      if (name) return without(text, name, ["joints", "drivers", "loads"]);
      if (at.kind === "free") throw new Error("there is nothing to remove here");
      // A joint lies over the points that it joins; the keyboard has no target, so this is by the place.
      const joint = at.kind === "point" ? drawing.sketch.geometry?.joints.findLast(({ ends }) => ends.some(end => far(world(end), at.at) * view.scale < 1)) : null;
      if (joint) return without(text, joint.name, ["joints"]);
      if (at.body !== null) return (at.kind === "point" && withoutPoint(text, at)) || without(text, at.owner, ["bodies"]);
      return withoutUsers(removeLines(text, "ground.points", key => key === at.name), `ground.${at.name}`);
    },
  },
};
const axis = (from, to) => {
  const way = minus(to, from), length = Math.hypot(...way);
  if (length * view.scale < 6) throw new Error("draw its direction");
  return `[${way.map(value => digits12(+(value / length).toFixed(12))).join(", ")}]`;
};
function stretched(text, from, to, type, more) {
  if (from.body === to.body && from.kind !== "free" && to.kind !== "free") throw new Error(`a ${type} joins two bodies, or a body and the ground`);
  const [first, one] = named(text, from, "anchor"), [second, other] = named(first, to, "anchor");
  return addTable(second, `loads.${freshName(second, type)}`, [`type    = "${type}"`, `between = ["${one}", "${other}"]`, ...more(far(from.at, to.at))]);
}
/** The angle of a joint: the second body's minus the first's. */
function jointAngle({ ends }, angles = drawing.sketch.geometry.bodies.map(({ start }) => start[2])) {
  const [one, other] = ends.map(({ body }) => body === null ? 0 : angles[body]);
  return oneWay(other - one);
}
/** The text without a point of a body, and what names it; null where the shape of the body needs it. */
function withoutPoint(text, { owner, name }) {
  const shape = valueAt(text, `bodies.${owner}`, "shape"), form = table(text, `bodies.${owner}.shape`);
  const end = shape < 0 ? -1 : closing(text, shape), shaped = form ? text.slice(form.body, form.end) : end < 0 ? "" : text.slice(shape, end);
  if (shaped.includes(`"${name}"`)) return null;
  const removed = table(text, `bodies.${owner}.points`) ? removeLines(text, `bodies.${owner}.points`, key => key === name) : removeItem(text, `bodies.${owner}`, "points", name);
  return removed === text ? null : withoutUsers(withoutOutputs(removed, `${owner}.${name}`), `${owner}.${name}`);
}
/** Removes an entry and what names it. */
function without(text, name, sections) {
  for (const section of sections) text = removeTable(text, `${section}.${name}`);
  text = removeLines(text, "initial", key => key.startsWith(`${name}.`));
  return withoutUsers(withoutOutputs(text, name), name);
}
/** Removes joints, loads and drivers that name a body or a point. */
function withoutUsers(text, name) {
  const uses = new RegExp(`"${name.replaceAll(".", "\\.")}(?:\\.[^"]*)?"`);
  for (;;) {
    const user = tables(text).find(own => /^(joints|drivers|loads)\./.test(own.name) && uses.test(text.slice(own.body, own.end)));
    if (!user) return text;
    const gone = user.name.split(".").slice(1).join(".");
    text = withoutUsers(withoutOutputs(removeLines(removeTable(text, user.name), "initial", key => key.startsWith(`${gone}.`)), gone), gone);
  }
}
/** Removes the outputs of an entry. */
function withoutOutputs(text, name) {
  const at = valueAt(text, "outputs", "variables"), end = at < 0 ? -1 : closing(text, at);
  if (end < 0) return text;
  const list = text.slice(at, end + 1), left = list.replace(new RegExp(`\\s*"${name}\\.[^"]*"\\s*,?`, "g"), "").replace(/,(\s*\])$/, "$1");
  return /"/.test(left) ? text.slice(0, at) + left + text.slice(end + 1) : removeLines(text, "outputs", key => key === "variables");
}

/** The text in which a point, with all that is pinned there, is somewhere else: the other points stay. */
function moved(text, grabbed, to) {
  const all = points(), here = all.filter(own => far(own.at, grabbed.at) * view.scale < .5), places = [], lines = [], angles = drawing.sketch.geometry?.bodies.map(({ start }) => start[2]) ?? [];
  const known = name => {
    const own = number(name);
    if (!own) throw new Error(`\`${name}\` is not written as a plain number: change what it is made of, in the text or under “Change” below`);
    return own;
  };
  const set = (name, value) => {
    const own = known(name);
    if (Math.abs(own.value - value) > 1e-13 * (1 + Math.abs(value))) places.push([own.place, lengthText(value, own, text)]);
  };
  const guess = (name, value, isNeeded) => {
    const own = number(name), written = name.endsWith("angle") ? degrees(value) : metres(value);
    if (own) places.push([own.place, written]);
    else if (isNeeded) lines.push(`"${name}" = { guess = ${written} }`);
  };
  for (const point of here) {
    if (point.body === null) { ["x", "y"].forEach((word, k) => set(`ground.${point.name}.${word}`, to[k])); continue; }
    const { start: [, , angle] } = drawing.sketch.geometry.bodies[point.body], own = all.filter(other => other.body === point.body), [first, second] = own;
    const zeros = own.length === 2 && [`${first.name}.x`, `${first.name}.y`, `${second.name}.y`].every(word => number(`${point.owner}.${word}`)?.value === 0) && number(`${point.owner}.${second.name}.x`)?.value > 0;
    if (zeros) {
      const [a, b] = own.map(other => here.includes(other) ? to : other.at), way = minus(b, a), now = angle + oneWay(Math.atan2(way[1], way[0]) - angle);
      if (Math.hypot(...way) < 1e-9) throw new Error("the ends of a bar must be different");
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
  let changed = retimed(spliced(text, places), angles);
  for (const line of lines) changed = addLine(changed, "initial", line);
  return changed;
}
/** A length as it was written: in its unit, or in millimetres where it was a bare zero. */
function lengthText(value, { place, unit }, text) {
  const old = textOf(bytesOf(text).subarray(...place));
  return /^["']?-?0(?:\.0*)?["']?$/.test(old) ? metres(value) : inText(value, { unit: unit ?? { name: "m", factor: 1 }, bare: false }, old);
}
/** Motors begin where the bars are now. */
function retimed(text, angles) {
  for (const joint of drawing.sketch.geometry?.joints ?? []) {
    const driver = tables(text).find(own => own.name.startsWith("drivers.") && new RegExp(`joint\\s*=\\s*"${joint.name}"`).test(text.slice(own.body, own.end)));
    const turn = oneWay(jointAngle(joint, angles) - jointAngle(joint));
    if (!driver || Math.abs(turn) < 1e-12) continue;
    // A law that begins with a number, in degrees or in radians.
    const begun = (_, head, number, unit = "") => `${head}${drawn(Number(number) + (unit ? 180 / Math.PI : 1) * turn)}${unit}`;
    const body = text.slice(driver.body, driver.end).replace(/(angle\s*=\s*")(-?\d[\d.]*(?:e[+-]?\d+)?)(\[deg\])?(?=\s*[+-])/, begun);
    text = text.slice(0, driver.body) + body + text.slice(driver.end);
  }
  return text;
}
