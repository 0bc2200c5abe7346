// @ts-check
// The drawing: the mechanism at its start, and what can be met in it.
import { round, svgElement } from "../common.js";
import { wished } from "./find.js";
import { drawing, paintTool } from "./main.js";
/** @type {(id: string) => any} */
export const $ = (id) => document.getElementById(id);
/** Middle of what is seen [m], and pixels of a metre. */
export const view = { x: .2, y: .1, scale: 800 };
export const size = () => {
  const { clientWidth: width, clientHeight: height } = $("board");
  return [width || 600, height || 400];
};
/** @type {(at: number[]) => number[]} */
export const pixel = ([x, y]) => {
  const [w, h] = size();
  return [w / 2 + (x - view.x) * view.scale, h / 2 - (y - view.y) * view.scale];
};
/** @type {(at: number[]) => number[]} */
export const metre = ([u, v]) => {
  const [w, h] = size();
  return [view.x + (u - w / 2) / view.scale, view.y - (v - h / 2) / view.scale];
};
/** @type {(a: number[], b: number[]) => number} */
export const far = ([a, b], [c, d]) => Math.hypot(a - c, b - d);
/** @type {(at: number[], angle: number) => number[]} */
export const turned = ([x, y], angle) => {
  const s = Math.sin(angle), c = Math.cos(angle);
  return [c * x - s * y, s * x + c * y];
};
/** @type {(a: number[], b: number[]) => number[]} */
export const plus = ([a, b], [c, d]) => [a + c, b + d];
/** @type {(a: number[], b: number[]) => number[]} */
export const minus = ([a, b], [c, d]) => [a - c, b - d];

/** The step of the grid [m]: one, two or five times a power of ten. */
export function gridStep() {
  const least = 18 / view.scale, power = 10 ** Math.floor(Math.log10(least));
  return power * [1, 2, 5, 10].find((part) => part * power >= least);
}
export const onGrid = (at) => {
  const step = gridStep();
  return at.map((value) => +(Math.round(value / step) * step).toPrecision(12));
};

const place = (body, at) => {
  const { start: [x, y, angle] } = drawing.sketch.geometry.bodies[body];
  return plus([x, y], turned(at, angle));
};
export const world = (anchor) => anchor.body === null ? anchor.at : place(anchor.body, anchor.at);
/** Every named point: of whom, its name, where it is. */
export function points() {
  const { sketch } = drawing;
  if (!sketch) return [];
  const own = sketch.points.flatMap((names, body) =>
    names.map((name, k) => ({ body, owner: sketch.geometry.bodies[body].name, name, at: place(body, sketch.geometry.bodies[body].points[k]) }))
  );
  return [...own, ...sketch.ground.map(({ name, at }) => ({ body: null, owner: "ground", name, at }))];
}
/** The ends of a body, or the corners of its shape, in the world. */
function outline(body) {
  const { points, rim, centre } = drawing.sketch.geometry.bodies[body], corners = rim.length ? rim : points;
  return hull((corners.length ? corners : [centre]).map((at) => place(body, at)));
}
function hull(all) {
  const sorted = [...all].sort((a, b) => a[0] - b[0] || a[1] - b[1]).filter((at, k, list) => !k || far(at, list[k - 1]) > 1e-12);
  if (sorted.length < 3) return sorted;
  const half = (list) => {
    const out = [];
    for (const p of list) {
      while (out.length > 1 && (out.at(-1)[0] - out.at(-2)[0]) * (p[1] - out.at(-2)[1]) - (out.at(-1)[1] - out.at(-2)[1]) * (p[0] - out.at(-2)[0]) <= 0) {
        out.pop();
      }
      out.push(p);
    }
    return out;
  };
  return [...half(sorted).slice(0, -1), ...half(sorted.reverse()).slice(0, -1)];
}
/** How far a place is from a line between two others. */
function beside(at, a, b) {
  const way = minus(b, a),
    length = Math.hypot(...way) || 1,
    along = Math.min(1, Math.max(0, ((at[0] - a[0]) * way[0] + (at[1] - a[1]) * way[1]) / length ** 2));
  return far(at, plus(a, way.map((value) => along * value)));
}
/** What is met at a place: a point, a body, or a free place on the grid. */
export function met(at, reach = 14) {
  const near = points().map((point) => [far(point.at, at) * view.scale, point]).filter(([d]) => d <= reach).sort((a, b) =>
    a[0] - b[0] || Number(a[1].body === null) - Number(b[1].body === null)
  );
  if (near.length) return { kind: "point", ...near[0][1] };
  const bodies = (drawing.sketch?.geometry?.bodies ?? []).map((_, body) => {
    const corners = outline(body);
    return [Math.min(...corners.map((corner, k) => beside(at, corner, corners[(k + 1) % corners.length]))) * view.scale, body];
  }).filter(([d]) => d <= reach * .8).sort((a, b) => a[0] - b[0]);
  const snapped = $("snap").getAttribute("aria-pressed") === "true" ? onGrid(at) : at.map((value) => +value.toPrecision(6));
  if (bodies.length) return { kind: "body", body: bodies[0][1], owner: drawing.sketch.geometry.bodies[bodies[0][1]].name, at: snapped, exact: at };
  return { kind: "free", at: snapped };
}
/** What a place is called, for those who cannot see it. */
export function called({ kind, owner, name, at }) {
  const where = at.map((value) => `${+(1e3 * value).toPrecision(4)} mm`).join(", ");
  return kind === "point" ? `${owner}.${name}, ${where}` : kind === "body" ? `${owner}, ${where}` : where;
}

export const path = (list) => list.map(([u, v], k) => `${k ? "L" : "M"}${round(u)} ${round(v)}`).join("");

function paintGrid(svg) {
  const [w, h] = size(), step = gridStep(), [left, top] = metre([0, 0]), [right, bottom] = metre([w, h]);
  let fine = "", coarse = "";
  for (let k = Math.ceil(left / step); k * step <= right; k++) {
    const line = `M${round(pixel([k * step, 0])[0])} 0V${h}`;
    if (k % 5) fine += line;
    else coarse += line;
  }
  for (let k = Math.ceil(bottom / step); k * step <= top; k++) {
    const line = `M0 ${round(pixel([0, k * step])[1])}H${w}`;
    if (k % 5) fine += line;
    else coarse += line;
  }
  svgElement("path", { d: fine, class: "fine" }, svg);
  svgElement("path", { d: coarse, class: "coarse" }, svg);
  $("grid-step").textContent = `${+(1e3 * step).toPrecision(3)} mm`;
}

function paintBodies(svg) {
  const { bodies, wheels } = drawing.sketch.geometry;
  for (const { centre, radius } of wheels) {
    const [cx, cy] = pixel(world(centre));
    svgElement("circle", { cx, cy, r: Math.abs(radius) * view.scale, class: "wheel" }, svg);
  }
  bodies.forEach(({ name }, body) => {
    const corners = outline(body).map(pixel), colour = body % 8;
    const d = corners.length === 1 ? `${path(corners)}h.01` : path(corners) + (corners.length > 2 ? "Z" : ""),
      group = svgElement("g", { class: "bar", "data-body": name }, svg);
    svgElement("path", { d, style: `stroke:var(--e${colour});stroke-width:15;fill:none` }, group);
    svgElement("path", { d, style: `stroke:var(--f${colour});fill:var(--f${colour});stroke-width:12` }, group);
    const middle = corners.reduce(plus, [0, 0]).map((value) => value / corners.length);
    svgElement("text", { x: middle[0], y: middle[1] - 14, class: "name" }, group, name);
  });
}
function paintJoints(svg) {
  const { joints, springs, forces, turns } = drawing.sketch.geometry;
  for (const { ends, name } of springs) {
    const [a, b] = ends.map((end) => pixel(world(end))),
      way = minus(b, a),
      side = [-way[1], way[0]].map((value) => 6 * value / (Math.hypot(...way) || 1)),
      at = (t, s) => plus(plus(a, way.map((value) => t * value)), side.map((value) => s * value));
    svgElement("path", {
      d: path([a, at(.2, 0), ...Array.from({ length: 8 }, (_, k) => at(.24 + .065 * k, k % 2 ? -1 : 1)), at(.8, 0), b]),
      class: "spring",
      "data-load": name,
    }, svg);
  }
  for (const { name, hold, ends: [base, at], axis } of joints) {
    const where = pixel(world(at)), group = svgElement("g", { "data-joint": name }, svg);
    if (axis) {
      const [u, v] = turned(axis, base.body === null ? 0 : drawing.sketch.geometry.bodies[base.body].start[2]),
        from = pixel(world(base)),
        along = (t) => [from[0] + t * u, from[1] - t * v];
      svgElement("path", { d: path([along(-90), along(90)]), class: "rail" }, group);
      svgElement("rect", {
        x: -13,
        y: -8,
        width: 26,
        height: 16,
        rx: hold === "slot" ? 8 : 2,
        class: "block",
        transform: `translate(${where.map(round).join(" ")}) rotate(${-Math.atan2(v, u) * 180 / Math.PI})`,
      }, group);
    }
    if (hold !== "slider") svgElement("circle", { cx: where[0], cy: where[1], r: 5, class: hold === "fixed" ? "fixed" : "pin" }, group);
  }
  for (const { at, direction, name } of forces) {
    const tip = pixel(world(at)), [u, v] = direction ?? [1, 0], length = Math.hypot(u, v) || 1, tail = [tip[0] - 50 * u / length, tip[1] + 50 * v / length];
    svgElement("path", { d: path([tail, tip]), class: "load", "data-load": name, "marker-end": "url(#head)" }, svg);
  }
  for (const { at, name } of turns) {
    const [x, y] = pixel(world(at));
    svgElement("path", { d: `M${x - 16} ${y + 8}A18 18 0 1 1 ${x + 16} ${y + 8}`, class: "turning", "data-load": name, "marker-end": "url(#head)" }, svg);
  }
}
function paintPoints(svg) {
  const fixed = new Set((drawing.sketch.geometry?.joints ?? []).flatMap(({ ends }) => ends).filter((end) => end.body === null).map(({ at }) => at.join()));
  for (const { body, at, name } of points()) {
    const [x, y] = pixel(at);
    if (body === null) svgElement("path", { d: `M${x} ${y}l-9 14h18Z`, class: fixed.has(at.join()) ? "pivot" : "pivot loose" }, svg);
    svgElement("circle", { cx: x, cy: y, r: 3, class: "dot" }, svg);
    svgElement("title", {}, svg.lastChild, name);
  }
}
/** Everything, from back to front. */
export function paint() {
  const svg = $("picture");
  svg.replaceChildren(svgElement("defs", {}));
  svgElement(
    "path",
    { d: "M0 0L8 4L0 8L2 4Z", class: "tip" },
    svgElement("marker", { id: "head", viewBox: "0 0 8 8", refX: 7, refY: 4, markerWidth: 6, markerHeight: 6, orient: "auto-start-reverse" }, svg.firstChild),
  );
  paintGrid(svgElement("g", {}, svg));
  const { sketch, stale } = drawing, group = svgElement("g", { class: stale ? "stale" : "" }, svg);
  if (sketch?.geometry) {
    paintBodies(group);
    paintJoints(group);
  }
  if (sketch) paintPoints(group);
  paintTool(svgElement("g", { class: "tool" }, svg));
}
/** The view shows all of the drawing. */
export function fit() {
  const all = [...points().map(({ at }) => at), ...(drawing.sketch?.geometry?.bodies ?? []).flatMap((_, body) => outline(body)), ...wished()], [w, h] = size();
  if (all.length < 2) {
    Object.assign(view, { x: .2, y: .1, scale: Math.min(w, h) / .6 });
    paint();
    return;
  }
  const [low, high] = [Math.min, Math.max].map((of) => [0, 1].map((axis) => of(...all.map((at) => at[axis])))),
    wide = Math.max(high[0] - low[0], .02),
    tall = Math.max(high[1] - low[1], .02);
  Object.assign(view, { x: (low[0] + high[0]) / 2, y: (low[1] + high[1]) / 2, scale: .62 * Math.min(w / wide, h / tall) });
  paint();
}
export function zoom(by, about = size().map((length) => length / 2)) {
  const at = metre(about);
  view.scale = Math.min(1e6, Math.max(1, view.scale * by));
  const now = metre(about);
  view.x += at[0] - now[0];
  view.y += at[1] - now[1];
  paint();
}
