// @ts-check
// The mechanism: built once from the geometry, moved by transforms in every frame. Lengths of symbols are multiples of a pin.
import { round, svgElement } from "./common.js";
import { $, G, MODEL, smooth } from "./data.js";
import { surface } from "./canvas.js";
import { pointAt } from "./marks.js";
import { size } from "./controls.js";
import { eachPose } from "./main.js";
export const DEGREES = 180 / Math.PI, S = G.scale, PIN = G.pin;
/** @type {(at: number[]) => number[]} */
export const pixel = ([x, y]) => [S * x, -S * y];
/** @type {(a: number[], s: number, b: number[]) => number[]} */
export const add = ([a, b], s, [c, d]) => [a + s * c, b + s * d];
/** @type {(a: number[], b: number[]) => number[]} */
export const minus = ([a, b], [c, d]) => [a - c, b - d];
/** @type {(a: number[]) => number[]} */
export const unit = ([a, b]) => {
  const l = Math.hypot(a, b);
  return l > 0 ? [a / l, b / l] : [1, 0];
};
/** @type {(a: number[]) => number[]} */
export const normal = ([a, b]) => [-b, a];
export const line = (points) => "M" + points.map(([x, y]) => `${round(x)} ${round(y)}`).join("L");

export function element(tag, attributes, parent, text) {
  surface.stale = true;
  return svgElement(tag, attributes, parent, text);
}

/** Where the bodies are at the present time: x, y, angle, and the angle's sine and cosine. */
export const pose = G.bodies.map(({ start }) => [...start, Math.sin(start[2]), Math.cos(start[2])]);
/** Points of the bodies and of the ground: a parameter may move them, so every run gives its own. */
export const forms = G.bodies.map((body) => body.points.map((point) => [...point]));
/** @type {(body: number, at: number[]) => number[]} */
export const turned = (body, [x, y]) => {
  if (body === null) return [x, y];
  const sine = pose[body][3], cosine = pose[body][4];
  return [cosine * x - sine * y, sine * x + cosine * y];
};
export const local = (anchor) => anchor.moved ?? (anchor.point === null ? anchor.at : forms[anchor.body][anchor.point]);
export const world = (anchor) => anchor.body === null ? local(anchor) : add(pose[anchor.body], 1, turned(anchor.body, local(anchor)));
/** @type {(anchor: any) => number[]} */
export const spot = (anchor) => pixel(world(anchor));

/** How much of the motion is drawn: masses on a line stand where there is room for them, so theirs may have to be made smaller. */
export let gain = 1;
export function chooseGain(run) {
  if (!MODEL.line) return;
  const places = G.bodies.map((body) => body.start[0] + body.centre[0]), wide = Math.max(...places) - Math.min(...places);
  const far = Math.max(
    ...G.bodies.map((body) => Math.max(...run.columns.get(`${body.name}.x`).subarray(0, run.last + 1).map((x) => Math.abs(x - body.start[0])))),
  );
  const room = .4 * wide / Math.max(places.length - 1, 1);
  if (wide > 0 && far > room) gain = +(room / far).toPrecision(1);
}

/** The columns of the bodies in the run that was looked at last. */
const posed = { run: null, columns: [] };
export function takePose(run, at) {
  if (posed.run !== run) {
    posed.run = run;
    posed.columns = G.bodies.map(({ name }) => ["x", "y", "angle"].map((word) => run.columns.get(`${name}.${word}`)));
  }
  for (let index = 0; index < pose.length; index++) {
    const now = pose[index], { start } = G.bodies[index], columns = posed.columns[index];
    for (let axis = 0; axis < 3; axis++) now[axis] = columns[axis] ? start[axis] + gain * (smooth(run, columns[axis], at) - start[axis]) : start[axis];
    now[3] = Math.sin(now[2]);
    now[4] = Math.cos(now[2]);
  }
}

/** The convex hull, for outlines; of points in line, whatever their direction and their rounding errors, the two ends. */
export function hull(points) {
  if (points.length < 2) return points;
  const sorted = points.slice().sort((a, b) => a[0] - b[0] || a[1] - b[1]);
  const cross = (a, b, p) => (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]), distance = (a, b) => Math.hypot(b[0] - a[0], b[1] - a[1]);
  const farthest = (from) => sorted.reduce((best, p) => distance(from, p) > distance(from, best) ? p : best);
  const end = farthest(sorted[0]), start = farthest(end), length = distance(start, end);
  if (length === 0) return [start];
  if (sorted.every((p) => Math.abs(cross(start, end, p)) <= 1e-9 * length * length)) return [start, end];
  // Without a tolerance: along an upright side the order of the points is that of their rounding errors, and an end would be dropped.
  const half = (list) => {
    const out = [];
    for (const p of list) {
      while (out.length > 1 && cross(out.at(-2), out.at(-1), p) <= 0) out.pop();
      out.push(p);
    }
    return out;
  };
  return [...half(sorted).slice(0, -1), ...half(sorted.reverse()).slice(0, -1)];
}
export const extent = (points) => Math.max(0, ...points.flatMap((a) => points.map((b) => Math.hypot(a[0] - b[0], a[1] - b[1]))));

/** Where a point of a body was at the start. */
/** @type {(index: number, at: number[]) => number[]} */
export const first = (index, [x, y]) => {
  const [u, v, angle] = G.bodies[index].start, s = Math.sin(angle), c = Math.cos(angle);
  return pixel([u + c * x - s * y, v + s * x + c * y]);
};
/** What joins the points of a body, as they were at the start; its outline is that of its shape if it has one. */
export const outline = (index) => G.bodies[index].rim.length ? G.bodies[index].rim.map((at) => first(index, at)) : bar(index);
const bar = (index) => hull([...forms[index], ...(G.bodies[index].cornered ? [G.bodies[index].centre] : [])].map((at) => first(index, at)));
export const outlineData = (points) =>
  points.length === 0 ? "" : points.length === 1 ? `${line(points)}l0 0` : points.length === 2 ? line(points) : `${line(points)}Z`;
/** What is done in every frame, and what after every run. */
export const frames = [], renewals = [];
/** What lies outside of the document keeps its place as numbers. */
/** @type {(group: any, at: number[], angle?: number) => void} */
export const move = (group, [x, y], angle) =>
  group.isConnected
    ? group.setAttribute("transform", `translate(${round(x)} ${round(y)})${angle === undefined ? "" : ` rotate(${(-angle * DEGREES).toFixed(4)})`}`)
    : void (group.placed = [x, y, angle]);
/** Moves what is drawn as it was at the start: its anchor was there and is here now, turned by an angle. */
/** @type {(group: any, from: number[], to: number[], turn: number) => void} */
export const carry = (group, [u, v], [x, y], turn) => {
  const s = Math.sin(turn), c = Math.cos(turn);
  move(group, [x - c * u - s * v, y + s * u - c * v], turn);
};
export const turnOf = (body) => body === null ? 0 : pose[body][2] - G.bodies[body].start[2];
/** Bodies that are drawn, and which of them the groups belong to. */
export const bodies = G.parts.filter((part) => part.kind === "bar").map((part) => part.body), owners = new Map();

function follow(group, at, turns) {
  const before = spot(at), place = () => carry(group, before, spot(at), turns ? turnOf(at.body) : 0);
  if (at.body === null) {
    renewals.push(place);
    return;
  }
  frames.push(place);
  owners.set(group, at.body);
  group.addEventListener("pointerenter", () => pointAt(at.body));
  group.addEventListener("pointerleave", () => pointAt(null));
}

/** The ends of what something slides or rolls on, in the present pose. */
export const trackEnds = [];
/** How each kind of part follows the motion; what changes its shape has its lines drawn anew. */
const kinds = {
  body: (group, _, { body }) => follow(group, { body, at: [0, 0], point: null }, true),
  centre: (group, _, part) => kinds.body(group, _, part),
  at: (group, _, { at }) => follow(group, at, true),
  turn: (group, _, { at }) => follow(group, at, false),
  bar(group, paths, { body, drawn }) {
    group.classList.add("body");
    kinds.body(group, paths, { body });
    if (drawn) renewals.push(() => paths.slice(0, 2).forEach((path) => path.setAttribute("d", outlineData(bar(body)))));
  },
  stretch(_, paths, { ends, retreat, length, lines }) {
    frames.push(() => {
      const [a, b] = ends.map(spot),
        axis = unit(minus(b, a)),
        side = normal(axis),
        full = Math.hypot(...minus(b, a)),
        [from, to] = retreat.map((far) => Math.min(far, .3 * full));
      const now = (full - from - to) / PIN,
        place = ([x, y, slope]) => add(add(a, from + PIN * Math.min(Math.max(x + slope * (now - length), 0), now), axis), PIN * y, side);
      paths.forEach((path, k) => {
        const { closed, points } = lines[k % lines.length];
        path.setAttribute("d", line(points.map(place)) + (closed ? "Z" : ""));
      });
    });
  },
  band(_, paths, { ends, radii: [one, other] }) {
    frames.push(() => {
      const [a, b] = ends.map(spot),
        axis = unit(minus(b, a)),
        cosine = (one - other) / Math.hypot(...minus(b, a)),
        sine = Math.sqrt(Math.max(0, 1 - cosine * cosine));
      const touch = (centre, radius, side) => add(add(centre, radius * cosine, axis), side * radius * sine, normal(axis));
      paths.forEach((path, k) => path.setAttribute("d", line([touch(a, one, 1 - 2 * k), touch(b, other, 1 - 2 * k)])));
    });
  },
  track(group, paths, { base, axis, moving, rails }) {
    const along = () => turned(base.body, axis);
    let way = [0, 0];
    trackEnds.push(() => {
      const [u, v] = along();
      return rails.flatMap((rail) => cover(rail, way).map((s) => add(spot(base), s, [u, -v])));
    });
    renewals.push(() => {
      way = [Infinity, -Infinity];
      eachPose(() => {
        const [u, v] = along(), [x, y] = minus(world(moving), world(base)), s = S * (x * u + y * v);
        way = [Math.min(way[0], s), Math.max(way[1], s)];
      });
      paths.forEach((path, k) => path.setAttribute("d", Number.isFinite(way[0]) ? railData(rails[k], way) : ""));
    });
    frames.push(() => {
      const [u, v] = along();
      move(group, spot(base), Math.atan2(v, u));
    });
  },
};

/** From where to where a line along a way goes. */
/** @type {(rail: any, way: number[]) => number[]} */
const cover = ({ about, beyond }, [low, high]) => [Math.min(low - beyond[0], about?.[0] ?? Infinity), Math.max(high + beyond[1], about?.[1] ?? -Infinity)];

/** A line along a way, long enough for the whole run; it may be hatched, or have teeth. */
function railData(rail, way) {
  const { off, pattern: { hatch, teeth } } = rail, [from, to] = cover(rail, way);
  if (hatch) {
    return Array.from(
      { length: (to - from) / hatch.pitch },
      (_, k) =>
        `M${round((hatch.side > 0 ? from : to) + hatch.side * hatch.pitch * (k + .9))} ${round(off)}l${
          [-1, 1].map((way) => round(way * hatch.side * hatch.depth))
        }`,
    ).join("");
  }
  if (!teeth) return `M${round(from)} ${round(off)}H${round(to)}`;
  const [start, end] = [from, to].map((x) => Math.round((x - teeth.first) / teeth.pitch)),
    at = (share, y) => [teeth.first + share * teeth.pitch, off + y * teeth.height],
    corners = [at(end, 4), at(start, 4)];
  for (let gap = start; gap < end; gap++) for (const [share, y] of [[.17, 1], [.35, -1], [.65, -1], [.83, 1]]) corners.push(at(gap + share, y));
  return `${line(corners)}Z`;
}

/** Joints that can be pointed at. */
const joints = [];
/** The joint next to a place in the drawing, if it is near enough to be meant. */
export function jointAt(place) {
  let [nearest, least] = [null, Math.max(1.2 * PIN, 7 * size)];
  for (const joint of joints) {
    const far = Math.hypot(...minus(spot(joint.anchor), place));
    if (far < least) [nearest, least] = [joint, far];
  }
  return nearest;
}
/** @type {(body: number, at: number[]) => number[]} */
export const turnedBack = (body, [x, y]) => {
  const s = pose[body][3], c = pose[body][4];
  return [c * x + s * y, c * y - s * x];
};

/** Everything, from back to front. */
export function drawMechanism() {
  for (const part of G.parts) {
    const group = element("g", {}, $(part.layer)), name = part.kind === "bar" ? G.bodies[part.body].name : part.name;
    group.innerHTML = part.svg;
    kinds[part.kind](group, [...group.children], part);
    if (name) group.prepend(element("title", {}, null, name));
  }
  for (const { name, hold, ends: [base, at] } of G.joints) if (hold !== "slider") joints.push({ name, anchor: at.body === null ? base : at });
}
