// @ts-check
// What is drawn over the mechanism: paths, poses, forces, torques, velocities and names.
import { round } from "./common.js";
import { $, between, G, INDEX, MODEL, newtons, START, STOP } from "./data.js";
import { surface } from "./canvas.js";
import {
  add,
  bodies,
  carry,
  element,
  first,
  line,
  minus,
  move,
  normal,
  outline,
  outlineData,
  PIN,
  pixel,
  pose,
  spot,
  takePose,
  turned,
  turnOf,
  unit,
  world,
} from "./figure.js";
import { transport, view } from "./controls.js";
import { paintHandles, reach } from "./handles.js";
import { touching } from "./touch.js";
import { changedKnobs } from "./edit.js";
import { eachPose, eachSample, paint, state } from "./main.js";
export const layers = { traces: true, forces: true, velocities: false, ghosts: false, names: true };

/** An arrow as a filled outline: shaft and notched head, in screen pixels times `unitSize`. */
/** @type {(from: number[], tip: number[], size: number) => any} */
function arrowData([x, y], [dx, dy], size) {
  const length = Math.hypot(dx, dy);
  if (!(length >= 5 * size)) return "";
  const [u, v] = [dx / length, dy / length], shaft = 1.5 * size, head = Math.min(11 * size, .6 * length), wide = .46 * head;
  const at = (s, o) => [x + u * s - v * o, y + v * s + u * o];
  return line([
    at(0, shaft),
    at(length - .8 * head, shaft),
    at(length - head, wide),
    at(length, 0),
    at(length - head, -wide),
    at(length - .8 * head, -shaft),
    at(0, -shaft),
  ]) + "Z";
}

const column = (name) => INDEX.has(name) && state.run.columns.get(name);
/** Reads a variable; its column is looked up once a run. */
function reader(name) {
  let run = null, own = null;
  return (at) => {
    if (run !== state.run) {
      run = state.run;
      own = column(name);
    }
    return own ? between(own, at) : 0;
  };
}
/** What is set every frame but seldom changes. */
export function write(text, value) {
  if ((text.told ?? text.textContent) !== value) text.textContent = text.told = value;
}
function draw(path, data) {
  if (path.drawn !== data) {
    path.drawn = data;
    path.setAttribute("d", data);
  }
}
/** The body that a side of a part belongs to, by its name. */
const bodyOf = (anchor) => anchor.body === null ? "ground" : G.bodies[anchor.body].name;
/** Where forces act, on which body, and which columns they are: force(run, at) gives newtons in the world at the present pose. */
function forceSources() {
  const has = (name) => MODEL.recorded.includes(name), out = [];
  const pair = (name, anchor, on, load) => {
    const fx = reader(`${name}.fx`), fy = reader(`${name}.fy`);
    out.push({ name, anchor, on, load, force: (at) => [fx(at), fy(at)] });
  };
  const along = (name, word, anchor, on, direction) => {
    const size = reader(`${name}.${word}`);
    out.push({
      name,
      anchor,
      on,
      force: (at) => {
        const f = size(at), [u, v] = direction();
        return [f * u, f * v];
      },
    });
  };
  for (const joint of G.joints) {
    const moving = joint.ends[1].body === null ? joint.ends[0] : joint.ends[1];
    const on = bodyOf(joint.ends[1]);
    if (has(`${joint.name}.fx`)) pair(joint.name, moving, on);
    else if (joint.axis && has(`${joint.name}.fn`)) along(joint.name, "fn", moving, on, () => normal(turned(joint.ends[0].body, joint.axis)));
  }
  for (const spring of G.springs) {
    if (has(`${spring.name}.force`)) {
      const end = spring.ends[1].body === null ? 0 : 1;
      along(spring.name, "force", spring.ends[end], bodyOf(spring.ends[end]), () => unit(minus(world(spring.ends[end]), world(spring.ends[1 - end]))));
    }
  }
  for (const mark of [...G.forces, ...G.targets]) {
    if (has(`${mark.name}.fx`)) pair(mark.name, mark.at, bodyOf(mark.at), true);
    else if (has(`${mark.name}.force`) && mark.direction) along(mark.name, "force", mark.at, bodyOf(mark.at), () => unit(mark.direction));
  }
  return out;
}

/** The size that nearly all values stay below: a single peak does not shrink all arrows. */
function typicalPeak(read) {
  const sizes = [];
  eachPose((at) => sizes.push(...read(at)));
  const finite = sizes.filter(Number.isFinite).sort((a, b) => a - b);
  return finite.length ? finite[Math.min(finite.length - 1, Math.floor(.985 * finite.length))] || finite.at(-1) : 0;
}

/** All arrows of a kind are one path. */
export const arrows = element("path", { class: "arrow many" }, $("forces")), rates = element("path", { class: "speed many" }, $("velocities"));
export const forces = forceSources().map((source) => ({ ...source, text: element("text", { class: "value" }, $("forces")) }));
const turns = G.turns.filter((turn) => MODEL.recorded.includes(`${turn.name}.torque`)).map((turn) => {
  const group = element("g", {}, $("turns"));
  element("title", {}, group, turn.name);
  return {
    ...turn,
    group,
    torque: reader(`${turn.name}.torque`),
    arc: element("path", { class: "turn", "stroke-width": 1.8 }, group),
    head: element("path", { class: "turn-head" }, group),
  };
});
const velocities = G.bodies.flatMap((body, index) =>
  MODEL.recorded.includes(`${body.name}.vx`) ? [{ index, rates: ["vx", "vy"].map((word) => reader(`${body.name}.${word}`)) }] : []
);
export const names = G.bodies.map((body, index) => ({
  index,
  name: body.name,
  text: element("text", { class: "name", style: `fill:color-mix(in oklab,var(--e${index % 8}),var(--text) 35%)` }, $("names"), body.name),
}));
export const scales = { newton: 0, torque: 0, speed: 0 };

/** One scale for all runs, from the first. */
export function chooseScales(fit) {
  const room = .33 * Math.min(fit[2], fit[3]);
  const force = typicalPeak((at) => forces.map((f) => Math.hypot(...f.force(at)))),
    speed = typicalPeak((at) => velocities.map((v) => Math.hypot(...v.rates.map((rate) => rate(at)))));
  const largest = force > 0 ? force : reach();
  scales.newton = largest > 0 ? room / largest : 0;
  scales.speed = speed > 0 ? room / speed : 0;
  scales.torque = typicalPeak((at) => turns.map((turn) => Math.abs(turn.torque(at))));
}

/** Room for texts: each is a rectangle by its middle, half width and half height, and none covers another, nor the head of an arrow. */
const MOST_LABELS = 40, CHARACTER = 3.9, LINE = 8.5;
export const taken = [], heads = [], halfWidth = (letters, size, height) => (letters * CHARACTER + 3) * size * height / 13;
/** @type {(at: number[], letters: number, size: number, height: number) => boolean} */
function claim([x, y], letters, size, height) {
  const wide = halfWidth(letters, size, height), high = LINE * size, meets = ([u, v, w, h]) => Math.abs(u - x) < w + wide && Math.abs(v - y) < h + high;
  if (taken.length >= MOST_LABELS || taken.some(meets) || heads.some(meets)) return false;
  taken.push([x, y, wide, high]);
  return true;
}
/** What is seen of the world: from where to where, without margins on all sides. */
const seen = (margins) => [0, 1].map((axis) => [view[axis] + margins[axis], view[axis] + view[axis + 2] - margins[axis + 2]]);
const lies = (place, ranges) => place.every((value, axis) => value >= ranges[axis][0] && value <= ranges[axis][1]);
/** The share of an arrow that fits into what is seen, if its foot does. */
function fits(from, tip, size) {
  const ranges = seen([8, 8, 8, 34].map((margin) => margin * size));
  if (!lies(from, ranges)) return 1;
  return Math.min(1, ...tip.map((way, axis) => way ? (ranges[axis][way > 0 ? 1 : 0] - from[axis]) / way : 1));
}
/** An arrow that is too long for the picture: a gap says so. */
/** @type {(from: number[], tip: number[], size: number) => any} */
function brokenData(from, tip, size) {
  const length = Math.hypot(...tip),
    half = .5 * size * 6 / length,
    shaft = [-1.5 * size * tip[1] / length, 1.5 * size * tip[0] / length],
    at = (share) => add(from, share, tip);
  if (!(length >= 24 * size)) return arrowData(from, tip, size);
  const [a, b] = [at(0), at(.5 - half)];
  return line([add(a, 1, shaft), add(b, 1, shaft), add(b, -1, shaft), add(a, -1, shaft)]) + "Z" +
    arrowData(at(.5 + half), tip.map((way) => way * (.5 - half)), size);
}
/** Where the value of an arrow may stand: beyond its head, beside it, beside its middle. Clear of the buttons above and the scales below, if its foot is seen. */
function placeOfValue(from, tip, words, size) {
  const length = Math.hypot(...tip), [u, v] = tip.map((way) => way / length), wide = halfWidth(words.length, size, 11.5), high = LINE * size;
  // So far from the middle of the text to its edge, along the arrow and across, and the width of a head.
  const along = Math.min(wide / Math.abs(u), high / Math.abs(v)) + 7 * size, across = wide * Math.abs(v) + high * Math.abs(u) + 7 * size;
  const beside = (share, side) => [from[0] + share * tip[0] - side * across * v, from[1] + share * tip[1] + side * across * u];
  const places = [[from[0] + tip[0] + along * u, from[1] + tip[1] + along * v], beside(1, 1), beside(1, -1), beside(.5, 1), beside(.5, -1)];
  const room = seen([wide, 56 * size, wide, 40 * size]), isSeen = lies(from, seen([0, 0, 0, 0]));
  return places.find((place) => (!isSeen || lies(place, room)) && claim(place, words.length, size, 11.5));
}
/** A transform moves a text without setting it anew. */
function put(text, place) {
  move(text, place);
}

/** Nobody reads digits that change sixty times a second: while the mechanism runs they change ten times. */
export const LEGIBLE = 100, digits = { due: true, last: 0 };
export function ageDigits() {
  const now = performance.now();
  digits.due = !transport.playing || now - digits.last >= LEGIBLE;
  if (digits.due) digits.last = now;
}

export function paintForces(at, size) {
  let drawn = "";
  const labelled = [];
  for (const { anchor, on, force, text } of layers.forces ? forces : []) {
    const [fx, fy] = force(at), strength = Math.hypot(fx, fy), whole = [fx * scales.newton, -fy * scales.newton], from = spot(anchor);
    const share = Number.isFinite(strength) ? fits(from, whole, size) : 1, tip = whole.map((way) => way * share), length = Math.hypot(...tip);
    if (Number.isFinite(length)) drawn += (share < 1 ? brokenData : arrowData)(from, tip, size);
    if (!(length > 24 * size)) {
      write(text, "");
      continue;
    }
    const [x, y] = add(from, 1 - 5 * size / length, tip);
    heads.push([x, y, 5 * size, 5 * size]);
    if (digits.due || !text.value) text.value = newtons(strength);
    labelled.push({ from, tip, on, text });
  }
  for (const { from, tip, on, text } of labelled) {
    // With the body that feels it where there is room for both.
    let place;
    const free = [`${text.value} on ${on}`, text.value].find((words) => place = placeOfValue(from, tip, words, size));
    write(text, free ?? "");
    if (free) put(text, place);
  }
  draw(arrows, drawn);
  if (!layers.forces) forces.forEach(({ text }) => write(text, ""));
  paintHandles(at);
  for (const turn of turns) paintTurn(turn, at);
}

/** A torque: an arc that is longer the larger it is, and turns as it does. */
function paintTurn({ torque: read, at: anchor, group, arc, head }, at) {
  const torque = read(at), share = scales.torque > 0 ? Math.min(Math.abs(torque) / scales.torque, 1) : 0, r = 2.9 * PIN;
  const sweep = share * 4.7, sign = torque < 0 ? -1 : 1, point = (angle, radius) => [radius * Math.cos(angle), -radius * Math.sin(angle)];
  move(group, spot(anchor));
  if (!layers.forces || !(sweep >= .15)) {
    draw(arc, "");
    draw(head, "");
    return;
  }
  const begin = -Math.PI / 2, end = begin + sign * sweep, [a, b] = [point(begin, r), point(end, r)];
  draw(arc, `M${a.map(round).join(" ")}A${r} ${r} 0 ${sweep > Math.PI ? 1 : 0} ${sign > 0 ? 0 : 1} ${b.map(round).join(" ")}`);
  const tip = point(end + sign * 2 * PIN / r, r);
  draw(head, line([tip, point(end, r + .8 * PIN), point(end, r - .8 * PIN)]) + "Z");
}

export function paintVelocities(at, size) {
  let drawn = "";
  for (const { index, rates: [vx, vy] } of layers.velocities ? velocities : []) {
    drawn += arrowData(pixel(pose[index]), [vx(at) * scales.speed, -vy(at) * scales.speed], size);
  }
  draw(rates, drawn);
}

/** Rings around what is closed or sticks, and for how long a star is seen where something has struck [s]. */
const FLASH = .15, STAR = `${line(Array.from({ length: 16 }, (_, k) => [Math.cos, Math.sin].map((way) => (k % 2 ? 1.9 : 4) * PIN * way(Math.PI * k / 8))))}Z`;
const ring = (sticks, parent) =>
  [{ width: .95, colour: "ink" }, { width: .65, colour: "held" }].forEach(({ width, colour }) =>
    element("circle", {
      r: 1.75 * PIN,
      style: `fill:none;stroke:var(--${colour});stroke-width:${width * PIN}${sticks ? `;stroke-dasharray:${1.75 * PIN * Math.PI / 6}` : ""}`,
    }, parent)
  );
export const held = (G.held ?? []).filter((own) => own.while.every(([name]) => MODEL.recorded.includes(name))).map((own) => {
  const group = element("g", {}, $("held")), star = element("path", { class: "star hide", d: STAR }, group), rings = element("g", { class: "hide" }, group);
  element("title", {}, group, own.name);
  ring(own.sticks, rings);
  return { ...own, group, star, rings, text: element("text", { class: "name" }, $("held")), run: null, strikes: [] };
});
const show = (node, is) => {
  if (node.seen !== is) {
    node.seen = is;
    node.classList.toggle("hide", !is);
  }
};
/** When it has struck in the present run: its impulse is another than before. */
function strikesOf(own) {
  if (own.run === state.run) return own.strikes;
  const { times, columns, last } = own.run = state.run, impulses = own.impulse && columns.get(own.impulse);
  own.strikes = impulses ? Array.from(times.subarray(1, last + 1)).filter((_, k) => impulses[k + 1] !== impulses[k]) : [];
  return own.strikes;
}
/** @type {(at: number[], size: number) => void} */
export function paintHeld([k], size) {
  for (const own of held) {
    const holds = own.while.every(([name, value]) => column(name)?.[k] === value),
      before = strikesOf(own).findLast((time) => time <= state.time),
      strikes = state.time - before < FLASH * transport.speed;
    show(own.rings, holds);
    show(own.star, strikes);
    const seen = holds || strikes, there = world(own.at), at = seen && pixel(own.off ? add(there, 1, turned(own.off.body, own.off.at)) : there);
    if (seen) move(own.group, at);
    const place = seen && layers.names &&
      [1, -1].map((side) => [at[0], at[1] - side * (4 * PIN + 8 * size)]).find((place) => claim(place, own.name.length, size, 13));
    write(own.text, place ? own.name : "");
    if (place) put(own.text, place);
  }
}
/** Stops, the last of the joints' parts, stand where they were at the start: what would move them takes them away. */
export function showStops() {
  const stops = G.stops ?? [], groups = [...$("pins").children].slice(-stops.length || Infinity), changed = changedKnobs();
  stops.forEach(({ needs }, k) => show(groups[k], !changed.some(({ name, loose }) => loose || needs.includes(name))));
}
/** What the signs mean, of those that can be seen. */
export function explainHeld() {
  const legend = $("held-legend"),
    sign = (word, paint, far = 3) => {
      const picture = element("svg", { viewBox: [-far, -far, 2 * far, 2 * far].map((x) => x * PIN).join(" ") }, legend);
      paint(picture);
      legend.append(word);
    };
  legend.hidden = !held.length;
  if (held.some((own) => !own.sticks)) sign("closed", (picture) => ring(false, picture));
  if (held.some((own) => own.sticks)) sign("sticks", (picture) => ring(true, picture));
  if (held.some((own) => own.impulse)) sign("strikes", (picture) => element("path", { class: "star", d: STAR }, picture), 4.5);
}

/** The body under the pointer: it has a name even where there is no room. */
export let pointed = null;
export function pointAt(index) {
  pointed = index;
  if (!transport.playing) paint();
}
/** Names above the mass centres; below if something is there, and none where it would cover another. */
export function paintNames(size) {
  const order = pointed === null ? names : [names[pointed], ...names];
  const done = new Set();
  for (const { index, name, text } of order) {
    if (done.has(index)) continue;
    done.add(index);
    const [x, y] = spot({ body: index, at: G.bodies[index].centre, point: null }), above = [x, y - PIN - 10 * size], below = [x, y + PIN + 10 * size];
    const wanted = layers.names && sizes[index] / size >= 40;
    let place = wanted ? [above, below].find((place) => claim(place, name.length, size, 13)) : undefined;
    if (!place && index === pointed) place = above;
    if (text.shown !== Boolean(place)) {
      text.shown = Boolean(place);
      text.classList.toggle("hide", !place);
    }
    if (place) put(text, place);
  }
}
export const sizes = G.bodies.map(() => 0);

/** Paths: of the points that the scene reports, and of every joint that is clicked. */
export const paths = [];
function addPath(key, read) {
  const all = element("path", { class: "path all" }, $("traces")),
    tail = element("path", { class: "path tail" }, $("traces")),
    dot = element("circle", { class: "tracer", r: .72 * PIN }, $("traces"));
  paths.push({ key, read, all, tail, dot, points: [] });
}
export function togglePath(anchor) {
  const key = JSON.stringify([anchor.body, anchor.at]), found = paths.findIndex((path) => path.key === key);
  if (found < 0) addPath(key, () => world(anchor));
  else for (const part of ["all", "tail", "dot"]) paths[found][part].remove();
  if (found >= 0) paths.splice(found, 1);
  surface.stale = true;
  renewPaths();
  paint();
}
export function reportedPaths() {
  for (const name of MODEL.outputs.filter((name) => name.endsWith(".x"))) {
    const [x, y] = [name, `${name.slice(0, -1)}y`];
    if (!MODEL.line && MODEL.recorded.includes(y)) addPath(name, (at) => [between(column(x), at), between(column(y), at)]);
  }
}
export function renewPaths() {
  for (const path of paths) path.points = [];
  eachSample((at) => paths.forEach((path) => path.points.push(pixel(path.read(at)))));
  for (const { all, points } of paths) all.setAttribute("d", points.length > 1 ? line(points) : "");
}
export function paintPaths(at) {
  const [k] = at;
  for (const { read, tail, dot, points } of paths) {
    const here = pixel(read(at)), back = state.run.times[k] - .35 * Math.min(1, STOP - START);
    let from = k;
    while (from > 0 && state.run.times[from - 1] > back) from--;
    // A pose that is pulled has no past.
    draw(tail, touching.hold ? "" : line([...points.slice(from, k + 1), here]));
    dot.setAttribute("cx", round(here[0]));
    dot.setAttribute("cy", round(here[1]));
  }
}

/** Poses on the way: outlines at seven times, faint. */
export function renewGhosts() {
  $("ghosts").replaceChildren();
  if (!layers.ghosts) return;
  const { run } = state, count = 6;
  for (let ghost = 0; ghost <= count; ghost++) {
    takePose(run, [Math.round(run.last * ghost / count), 0]);
    for (const index of bodies) {
      const path = element("path", {
        d: outlineData(outline(index)),
        style: `fill:none;stroke:var(--e${index % 8});stroke-width:${2.4 * PIN};stroke-linejoin:round;stroke-linecap:round`,
        opacity: .16,
      }, $("ghosts"));
      carry(path, first(index, [0, 0]), pixel(pose[index]), turnOf(index));
    }
  }
}
