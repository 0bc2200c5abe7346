// @ts-check
// What can be touched: bodies are pulled, points and lengths are moved, with the pointer, a finger, or keys.
import { all, round, unpack } from "./common.js";
import { $, G, INDEX, MODEL, place, smooth, START, VARIABLES } from "./data.js";
import { Solver } from "./solver.js";
import { add, forms, hull, local, minus, PIN, pixel, pose, S, spot, takePose, turned, turnedBack, unit, world } from "./figure.js";
import { sizes } from "./marks.js";
import { askAgain, inScene, knobs, pause, seek, settings, size, view } from "./controls.js";
import { commit } from "./edit.js";
import { paint, solveAgain, state, tell } from "./main.js";
export const TOUCH = MODEL.touch;
/** Pixels from a body, or a handle, within which it is meant: half a finger, and the tip of a mouse. */
export const REACH = { touch: 22, mouse: 7 };
/** Half of a block that slides, in pins. */
const BLOCK = 2.5;
/** Pulls that the program which serves the page solves at a time: a request takes up to two frames. */
const MOST_REQUESTS = 2;
/** Time of a picture that pulling may take [ms]. */
export const SHARE_OF_FRAME = 8;
export const touching = { mode: "pull", hold: null, handles: [], drag: null };
export const say = (text) => {
  if ($("said").textContent !== text) $("said").textContent = text;
};

/** Parameters of the scene's numbers join the variables; their program is another. */
export async function makeTouchable() {
  const program = TOUCH && await unpack("loose");
  if (!program) return;
  for (
    const { variable } of [
      ...TOUCH.numbers,
      ...TOUCH.laws.filter((law) => !INDEX.has(law.parameter)).map((law) => ({
        variable: {
          name: law.parameter,
          text: `added to the law of ${law.driver}`,
          kind: "parameter",
          unit: law.angle ? "rad" : "m",
          display: null,
          start: 0,
          min: null,
          max: null,
          initial: false,
        },
      })),
    ]
  ) {
    INDEX.set(variable.name, VARIABLES.length);
    VARIABLES.push({ ...variable, loose: true });
  }
  state.loose = await Solver.load(state.code, program, TOUCH.variables);
}
/** The solver of what is set now: the scene's own program as long as none of its numbers is another. */
export const solverNow = () => state.loose && (state.pose || knobs.some((knob) => knob.loose && knob.value !== knob.start)) ? state.loose : state.solver;

/** The body next to a place in the drawing: the one whose outline is not farther than a reach. */
export function bodyNear([x, y], reach) {
  let [nearest, least] = [null, reach * size];
  const away = (a, b) => {
    const [u, v] = minus(b, a), square = u * u + v * v, share = square > 0 ? Math.min(1, Math.max(0, ((x - a[0]) * u + (y - a[1]) * v) / square)) : 0;
    return Math.hypot(x - a[0] - share * u, y - a[1] - share * v);
  };
  G.bodies.forEach((body, index) => {
    const shape = body.rim.length ? body.rim : [...forms[index], ...(body.cornered || !forms[index].length ? [body.centre] : [])];
    const ring = hull(shape.map((at) => pixel(add(pose[index], 1, turned(index, at))))), side = (k) => [ring[k], ring[(k + 1) % ring.length]];
    const within = ring.length > 2 && ring.every((_, k) => {
      const [[a, b], [c, d]] = side(k);
      return (c - a) * (y - b) - (d - b) * (x - a) >= 0;
    });
    // A body with one place is a block.
    const far = within ? 0 : Math.min(...ring.map((_, k) => away(...side(k)))) - (ring.length > 1 ? 0 : BLOCK * PIN);
    if (far < least || far === least && nearest !== null && sizes[index] < sizes[nearest]) [nearest, least] = [index, far];
  });
  for (const { centre, radius } of G.wheels) {
    if (centre.body !== null && nearest === null && Math.hypot(...minus(spot(centre), [x, y])) < S * Math.abs(radius) + least) nearest = centre.body;
  }
  return nearest;
}

/** What the arrow keys pull of a body: what is farthest from its mass centre. */
function keyPoint(index) {
  const { rim, centre } = G.bodies[index], wheel = G.wheels.find((wheel) => wheel.centre.body === index), far = (at) => Math.hypot(...minus(at, centre));
  const places = [...forms[index], ...rim, ...(wheel ? [add(local(wheel.centre), Math.abs(wheel.radius), [0, 1])] : [])];
  return places.reduce((best, at) => far(at) > far(best) ? at : best, centre);
}
const keyPlace = (index) => add(pose[index], 1, turned(index, keyPoint(index)));

/** Takes hold of a body at a place in the world. The mechanism stands; what drivers prescribe is free. */
/** @type {(body: number, at: number[]) => any} */
export function hold(body, [x, y]) {
  pause();
  const at = place(state.run, state.time), { loose } = state, values = settings(), time = state.time;
  takePose(state.run, at);
  const angles = TOUCH.coordinates.map((name) => smooth(state.run, state.run.columns.get(name), at));
  const released = TOUCH.laws.map(({ parameter, angle }) => ({ name: parameter, angle }));
  const grip = loose.prepare(values, time) ? null : loose.grip(angles, released, G.bodies[body].name);
  if (!grip) {
    tell(`${G.bodies[body].name} cannot be pulled: ${loose.message()}`);
    return false;
  }
  const names = MODEL.recorded.filter((name) => loose.index.has(name));
  touching.hold = {
    grip,
    body,
    time,
    names,
    before: state.run,
    local: turnedBack(body, minus([x, y], pose[body])),
    target: [x, y],
    due: false,
    frame: 0,
    solving: 0,
    found: null,
    steps: 0,
    end: 0,
  };
  $("stage").classList.add("pulling");
  return true;
}
/** The held point shall be there; the next picture shows it. */
export function pullTo(target) {
  const { hold } = touching;
  Object.assign(hold, { target, due: true });
  nextFrame(hold);
}
function nextFrame(hold) {
  hold.frame ||= requestAnimationFrame(() => {
    hold.frame = 0;
    if (touching.hold === hold) pullOn(hold);
  });
}
/** One frame. The program that serves the page solves for the next frames while this one shows what it found for the last. */
function pullOn(hold) {
  if (hold.due && hold.solving < MOST_REQUESTS) {
    const answer = hold.grip.follow(hold.local, hold.target, hold.names, SHARE_OF_FRAME);
    Object.assign(hold, { due: false, solving: hold.solving + 1, steps: hold.steps + 1 });
    if (answer instanceof Promise) {
      answer.then((found) => receive(hold, found), (fault) => {
        hold.solving--;
        tell(fault.message);
      });
    } else receive(hold, answer);
  }
  if (hold.found) showPulled(hold);
}
function receive(hold, found) {
  Object.assign(hold, { end: found.end ?? hold.end, found, solving: hold.solving - 1, due: hold.due || found.end === 1 });
  nextFrame(hold);
}
function showPulled(hold) {
  const { values } = hold.found;
  hold.found = null;
  state.run = {
    times: Float64Array.of(hold.time),
    columns: new Map(hold.names.map((name, k) => [name, Float64Array.of(values[k])])),
    last: 0,
    error: null,
    warning: null,
    ms: 0,
  };
  paint();
  tell(pullWords(hold), true);
}
function pullWords({ end, body }) {
  const { name } = G.bodies[body];
  return {
    2: `Dead point: ${name} cannot move farther in this direction. Drag another body to pass it.`,
    3: `Singular configuration: branches of the motion meet here, and dragging ${name} does not choose one.`,
    4: `${name} does not move: drag it farther from its centre of rotation.`,
    5: `${name} cannot be pulled: joints and drivers leave 0 degrees of freedom.`,
  }[end] ?? "";
}
/** Lets go: the pose is the new start, and the run from there is solved. Or the pose is given up. */
export function letGo(keep) {
  const { hold } = touching, { grip } = hold;
  touching.hold = null;
  $("stage").classList.remove("pulling");
  state.run = hold.before;
  if (keep && hold.steps) {
    // The answer to the last request comes too late.
    if (hold.solving || hold.due) grip.pull(hold.local, hold.target);
    startFrom(grip);
    state.time = START;
    commit(`${G.bodies[hold.body].name} pulled`);
  }
  grip.letGo();
  tell("");
  if (keep && hold.steps) solveAgain();
  else seek(hold.time);
}
/** The values that give the run its start in a pose: those of drivers, and what is known at the start. */
function startFrom(grip) {
  const before = grip.values(TOUCH.laws.map((law) => law.output)), added = grip.values(TOUCH.laws.map((law) => law.parameter));
  grip.setTime(START);
  const after = grip.values(TOUCH.laws.map((law) => law.output));
  TOUCH.laws.forEach(({ parameter, output }, k) => setKnob(parameter, added[k] + (output === parameter ? 0 : before[k] - after[k])));
  const known = knobs.filter(({ name }) => {
    const { initial, unit } = VARIABLES[INDEX.get(name)];
    return initial && (unit === "rad" || unit === "m");
  });
  const found = grip.values(known.map((knob) => knob.name));
  known.forEach((knob, k) => {
    if (Number.isFinite(found[k])) setKnob(knob.name, found[k]);
  });
  state.pose = null;
  const wanted = Array.from(grip.values(TOUCH.coordinates)), there = solverNow().start(settings(), TOUCH.coordinates);
  const same = there.last === 0 && TOUCH.coordinates.every((name, k) => Math.abs(there.columns.get(name)[0] - wanted[k]) <= 1e-6 * (1 + Math.abs(wanted[k])));
  if (!same) state.pose = wanted;
}
function setKnob(name, value) {
  const knob = knobs.find((knob) => knob.name === name);
  knob.value = value;
  knob.moves = [];
  knob.show();
}

/** The values that a coordinate is made of, and the one of the solver that has it. */
const numberOf = (name) => TOUCH.numbers.find((own) => own.name === name), formulaOf = (name) => TOUCH.formulas.find((own) => own.name === name);
const madeOf = (name) =>
  [...(formulaOf(name)?.text.match(/[A-Za-z_]\w*/g) ?? []), numberOf(name)?.variable.name].map((own) => knobs.find((knob) => knob.name === own)).filter(
    (knob) => knob && !knob.isInput,
  );
const axesOf = (name) => ["x", "y"].map((axis) => `${name}.${axis}`);

/** Handles: points of the ground, pins of two bodies, which move in both, other points, mass centres, lengths. `parts` are the coordinates that move, and in whose axes. */
function makePointHandles() {
  const add = (name, anchor, parts, ends) => {
    const moved = [...new Set(parts.flatMap(({ keys }) => keys).flatMap(madeOf))];
    if (moved.length) touching.handles.push({ name, anchor, parts, ends, knobs: moved, button: handleButton(name) });
  };
  const pinned = new Set(),
    nameOf = ({ body, point }) => `${G.bodies[body].name}.${MODEL.points[body][point]}`,
    isNamed = ({ body, point }) => body !== null && MODEL.points[body][point] !== undefined;
  for (const { name, hold, ends } of G.joints) {
    if (hold === "pin") {
      ends.filter(isNamed).forEach((end) => pinned.add(nameOf(end)));
      if (ends.every(isNamed)) add(name, () => world(ends[1]), ends.map((end) => ({ body: end.body, keys: axesOf(nameOf(end)) })));
    }
  }
  MODEL.points.forEach((names, body) =>
    names.forEach((_, point) => {
      const end = { body, point }, name = nameOf(end);
      if (!pinned.has(name)) add(name, () => world({ ...end, at: forms[body][point] }), [{ body, keys: axesOf(name) }]);
    })
  );
  G.bodies.forEach((own, body) => add(`${own.name}.com`, () => pose[body], [{ body, keys: axesOf(`${own.name}.com`) }]));
  for (const { name, ends } of [...G.springs, ...G.joints]) {
    add(
      `${name}.length`,
      () => {
        const [a, b] = ends.map(world);
        return [(a[0] + b[0]) / 2, (a[1] + b[1]) / 2];
      },
      [{ keys: [`${name}.length`] }],
      ends,
    );
  }
  MODEL.ground.forEach(({ name, at }) =>
    add(`ground.${name}`, () => ["x", "y"].map((axis, k) => state.run.columns.get(`ground.${name}.${axis}`)?.[0] ?? at[k]), [{
      body: null,
      keys: axesOf(`ground.${name}`),
    }])
  );
}
function handleButton(name) {
  const button = document.createElement("button");
  button.type = "button";
  button.className = "handle";
  button.title = name;
  button.setAttribute("aria-label", `${name}: drag it, or press arrow keys; Enter types its values`);
  $("handles").append(button);
  return button;
}
/** By coordinate of a handle: how it changes with each of the values. */
function gainsOf({ parts, knobs: moved }) {
  const keys = parts.flatMap(({ keys }) => keys),
    outputs = keys.map((name) => formulaOf(name)?.output).filter(Boolean),
    columns = TOUCH.coordinates.map((name) => state.run.columns.get(name)[0]),
    set = new Map(/** @type {any} */ (settings()));
  const found = (values) => {
    const grip = state.loose.prepare([...values]) ? null : state.loose.grip(columns, [], G.bodies[0].name), own = grip?.values(outputs);
    grip?.letGo();
    return own && new Map(outputs.map((name, k) => [name, own[k]]));
  };
  const before = outputs.length ? found(set) : null;
  const after = moved.map((knob) => {
    const by = 1e-6 * (Math.abs(knob.value) || PIN / S);
    return before && { by, values: found(new Map([...set, [knob.name, knob.value + by]])) };
  });
  return keys.map((name) =>
    moved.map((knob, k) => {
      if (numberOf(name)?.variable.name === knob.name) return 1;
      const output = formulaOf(name)?.output;
      return output && after[k]?.values ? (after[k].values.get(output) - before.get(output)) / after[k].by : 0;
    })
  );
}
/** The smallest changes of values that change coordinates by this, as far as they can: least squares. */
function smallest(gains, wanted) {
  const normal = gains.map((row) => gains.map((other) => row.reduce((sum, gain, k) => sum + gain * other[k], 0))),
    trace = normal.reduce((sum, row, k) => sum + row[k], 0),
    right = [...wanted];
  normal.forEach((row, k) => {
    row[k] += 1e-9 * trace || 1;
  });
  // Positive definite: no pivot is zero.
  normal.forEach((row, k) => {
    for (let below = k + 1; below < normal.length; below++) {
      const share = normal[below][k] / row[k];
      normal[below] = normal[below].map((value, j) => value - share * row[j]);
      right[below] -= share * right[k];
    }
  });
  for (let k = normal.length - 1; k >= 0; k--) {
    for (let j = k + 1; j < normal.length; j++) right[k] -= normal[k][j] * right[j];
    right[k] /= normal[k][k];
  }
  return gains[0].map((_, knob) => gains.reduce((sum, row, k) => sum + row[knob] * right[k], 0));
}
/** What is missing of a handle's way, in the axes of its parts. A length grows by twice the way of its middle. */
function missingOf({ parts, ends }, missing) {
  if (!ends) return parts.flatMap(({ body }) => body === null ? missing : turnedBack(body, missing));
  const [from, to] = ends.map(world), [u, v] = unit(minus(to, from));
  return [2 * (missing[0] * u + missing[1] * v)];
}

function beginDrag(handle) {
  pause();
  takePose(state.run, place(state.run, state.time));
  touching.drag = {
    handle,
    gains: gainsOf(handle),
    from: handle.anchor(),
    target: null,
    share: 1,
    missing: Infinity,
    tries: 0,
    changed: false,
    before: handle.knobs.map((knob) => knob.value),
  };
}
/** The handle shall be there, in the world. The run answers; what is still missing then is added again. */
function dragTo(target) {
  Object.assign(touching.drag, { target, share: 1, missing: Infinity, tries: 0 });
  dragOn();
}
function dragOn() {
  const { drag } = touching, { handle, gains, target } = drag;
  takePose(state.run, place(state.run, state.time));
  // What has a length may not move with it.
  const missing = minus(target, handle.ends ? drag.from : handle.anchor()), far = Math.hypot(...missing);
  if (far > drag.missing) drag.share /= 2;
  drag.missing = far;
  const changes = smallest(gains, missingOf(handle, missing));
  handle.knobs.forEach((knob, k) => {
    const { min, max } = VARIABLES[knob.index];
    knob.value = Math.min(Math.max((handle.ends ? drag.before[k] : knob.solved ?? knob.start) + drag.share * changes[k], min ?? -Infinity), max ?? Infinity);
    knob.moves = [];
    knob.show();
  });
  drag.changed = true;
  say(`${handle.name}: ${handle.knobs.map((knob) => `${knob.title} ${knob.told()}`).join(", ")}`);
  askAgain();
}
/** After each run: half a pixel is near enough, and four answers are enough. */
export function dragAnswered() {
  const { drag } = touching;
  if (!drag?.target || drag.handle.ends || drag.tries++ >= 4) return;
  takePose(state.run, place(state.run, state.time));
  if (Math.hypot(...minus(drag.target, drag.handle.anchor())) * S > .5 * size) dragOn();
}
function endDrag(keep) {
  const { drag } = touching;
  touching.drag = null;
  if (!drag?.changed) return;
  if (keep) commit(`${drag.handle.name} moved`);
  else {drag.handle.knobs.forEach((knob, k) => {
      knob.value = drag.before[k];
      knob.show();
    });}
  // At all of its times.
  askAgain();
}

/** Arrows move what has the focus by a pixel, with Shift by ten. */
const arrow = (event) => {
  const step = (event.shiftKey ? 10 : 1) * size / S;
  return { ArrowLeft: [-step, 0], ArrowRight: [step, 0], ArrowUp: [0, step], ArrowDown: [0, -step] }[event.key];
};
export const inWorld = (event) => {
  const { x, y } = inScene(event);
  return [x / S, -y / S];
};

function listenToHandle(handle) {
  const { button } = handle;
  let held = null, off = [0, 0];
  button.addEventListener("pointerdown", (event) => {
    event.stopPropagation();
    held = event.pointerId;
    button.setPointerCapture(held);
    beginDrag(handle);
    off = minus(handle.anchor(), inWorld(event));
  });
  button.addEventListener("pointermove", (event) => {
    if (event.pointerId === held) dragTo(add(inWorld(event), 1, off));
  });
  for (const [name, keep] of [["pointerup", true], ["pointercancel", false]]) {
    button.addEventListener(name, (event) => {
      if (event.pointerId === held) {
        held = null;
        endDrag(keep);
      }
    });
  }
  button.addEventListener("keydown", (event) => {
    const by = arrow(event);
    if (by) {
      event.preventDefault();
      event.stopPropagation();
      if (touching.drag?.handle !== handle) beginDrag(handle);
      dragTo(add(touching.drag.target ?? handle.anchor(), 1, by));
    } else if (event.key === "Escape") endDrag(false);
    else if (event.key === "Enter") {
      event.preventDefault();
      endDrag(true);
      handle.knobs[0].type();
    }
  });
  button.addEventListener("blur", () => {
    if (held === null && touching.drag?.handle === handle) endDrag(true);
  });
  button.addEventListener("keyup", (event) => {
    if (held === null && arrow(event) && touching.drag?.handle === handle) endDrag(true);
  });
}

/** A body is pulled by keys, too. */
function makePullButtons() {
  G.bodies.forEach((body, index) => {
    const button = document.createElement("button");
    button.type = "button";
    button.className = "pull";
    button.setAttribute("aria-label", `Pull ${body.name}: arrow keys; Enter keeps the pose, Escape puts it back`);
    button.title = body.name;
    button.addEventListener("pointerdown", (event) => event.preventDefault());
    button.addEventListener("keydown", (event) => {
      const by = arrow(event);
      if (by) {
        event.preventDefault();
        event.stopPropagation();
        takePose(state.run, place(state.run, state.time));
        if (!touching.hold && !hold(index, keyPlace(index))) return;
        pullTo(add(touching.hold.target, 1, by));
        say(`${body.name} pulled`);
      } else if (event.key === "Enter" || event.key === "Escape") {
        event.preventDefault();
        if (touching.hold) letGo(event.key === "Enter");
      }
    });
    button.addEventListener("blur", () => {
      if (touching.hold?.body === index) letGo(true);
    });
    $("handles").append(button);
    pullButtons.push({ index, button });
  });
}
const pullButtons = [];

/** Handles are where their points are. */
export function paintTouch() {
  if (!state.loose) return;
  /** @type {(button: any, at: number[]) => void} */
  const put = (button, [x, y]) => {
    button.style.transform = `translate(${round((S * x - view[0]) / size)}px,${round((-S * y - view[1]) / size)}px)`;
  };
  if (touching.mode === "change") { for (const { button, anchor } of touching.handles) put(button, anchor()); }
  else if ($("handles").contains(document.activeElement)) {
    for (const { index, button } of pullButtons) {
      put(button, touching.hold?.body === index ? add(pose[index], 1, turned(index, touching.hold.local)) : keyPlace(index));
    }
  }
}
function setMode(mode) {
  touching.mode = mode;
  $("handles").dataset.mode = mode;
  for (const button of all("[data-mode-of]")) button.setAttribute("aria-checked", button.dataset.modeOf === mode);
  paint();
}
export function listenToTouch() {
  makePointHandles();
  touching.handles.forEach(listenToHandle);
  makePullButtons();
  $("handles").addEventListener("focusin", paintTouch);
  for (const button of all("[data-mode-of]")) button.addEventListener("click", () => setMode(button.dataset.modeOf));
  $("touch").hidden = false;
  $("numbers").hidden = !TOUCH.numbers.length;
  setMode("pull");
}
