// @ts-check
// Many parts are painted on a canvas: the same elements as otherwise, but outside of the document, where moving them costs no style and no layout.
// How they look is what the style sheet says: it is read while they are in the document for a moment.
import { $, G, shelf } from "./data.js";
import { minus, move, owners } from "./figure.js";
import { printing, size, stageSize, view } from "./controls.js";
export const MANY = 60, crowded = G.bodies.length + G.joints.length + G.springs.length > MANY;
/** What does not move stays where it is, unless something that moves is behind it. */
const PAINTED = [
  ...(G.wheels.length ? ["couplings", "ground"] : ["couplings"]),
  "bodies",
  "springs",
  "traces",
  "pins",
  "held",
  "turns",
  "velocities",
  "forces",
  "names",
];
/** Stale: there are elements, or colours, whose looks nobody has read. */
export const surface = { canvas: null, context: null, layers: [], stale: true };

/** Takes the layers out of the document, for good. */
export function makeSurface() {
  if (!crowded) return;
  const canvas = surface.canvas = document.createElement("canvas");
  canvas.id = "surface";
  canvas.setAttribute("aria-hidden", "true");
  $("scene").after(canvas);
  surface.context = canvas.getContext("2d");
  shelf.append(...PAINTED.map($));
}

/** Paper gets the elements themselves: they are sharp at any size. */
export function putOnPaper(paper) {
  if (!crowded) return;
  const layers = PAINTED.map($), { canvas } = surface;
  canvas.hidden = paper;
  if (!paper) {
    shelf.append(...layers);
    return;
  }
  $("scene").append(...layers);
  for (const layer of layers) for (const node of layer.querySelectorAll("*")) if (node.placed) carryBack(node);
}
/** Puts an element where it was on the canvas. */
function carryBack(node) {
  const [at, angle] = placeOf(node);
  move(node, at, angle);
}
/** @type {(node: any) => [number[], number]} */
const placeOf = ({ placed: [x, y, angle] }) => [[x, y], angle];

/** Reads how each element looks. */
function readLooks() {
  const layers = PAINTED.map($);
  $("scene").append(...layers);
  surface.layers = layers.map(lookOf);
  shelf.append(...layers);
  surface.stale = false;
}
function lookOf(node) {
  const style = getComputedStyle(node), matrix = node.transform.baseVal.numberOfItems ? node.transform.baseVal.consolidate().matrix : null;
  const look = {
    node,
    kind: node.tagName,
    alpha: +style.opacity,
    children: [...node.children].filter((child) => child.transform && child.tagName !== "title").map(lookOf),
    data: null,
    paths: null,
  };
  look.still = matrix && [matrix.a, matrix.b, matrix.c, matrix.d, matrix.e, matrix.f];
  look.isMark = node.classList.contains("mark");
  look.isMany = node.classList.contains("many");
  if (look.kind === "g") return look;
  const colour = (value) => value === "none" ? null : value;
  return Object.assign(look, {
    fill: colour(style.fill),
    stroke: colour(style.stroke),
    fillAlpha: +style.fillOpacity,
    strokeAlpha: +style.strokeOpacity,
    width: parseFloat(style.strokeWidth),
    cap: style.strokeLinecap,
    join: style.strokeLinejoin,
    // A halo around each of many arrows would cost as much as all else.
    halo: style.paintOrder.startsWith("stroke"),
    dash: style.strokeDasharray === "none" ? [] : style.strokeDasharray.split(",").map(parseFloat),
    rule: style.fillRule,
    fixed: style.vectorEffect === "non-scaling-stroke",
    letters: look.kind === "text" ? `${style.fontWeight} 1px ${style.fontFamily}` : null,
  });
}

/** The paths of an element as it is now; they seldom change. Small ones are painted faster than a large one of many pieces. */
function pathsOf(look) {
  const { node, kind } = look, value = (name) => +node.getAttribute(name);
  const data = kind === "path" ? node.getAttribute("d") : kind === "circle" ? `${node.getAttribute("cx")} ${node.getAttribute("cy")}` : "";
  if (look.paths && data === look.data) return look.paths;
  look.data = data;
  if (kind === "path") return look.paths = (look.isMany ? (data ?? "").split(/(?=M)/) : [data ?? ""]).map((piece) => new Path2D(piece));
  const path = new Path2D();
  if (kind === "circle") path.arc(value("cx"), value("cy"), value("r"), 0, 2 * Math.PI);
  else {
    path.moveTo(value("x1"), value("y1"));
    path.lineTo(value("x2"), value("y2"));
  }
  return look.paths = [path];
}

function paintLook(look) {
  const { context } = surface, { node, still, children } = look, { placed } = node;
  if (look.isMark && surface.far || node.classList.contains("hide")) return;
  if (look.kind === "text" ? !node.textContent : look.kind === "g" && !children.length) return;
  context.save();
  if (placed) {
    context.translate(placed[0], placed[1]);
    if (placed[2]) context.rotate(-placed[2]);
  } else if (still) context.transform(...still);
  if (look.alpha < 1) context.globalAlpha *= look.alpha;
  if (look.kind === "g") children.forEach(paintLook);
  else if (look.kind === "text") paintText(look);
  else paintShape(look);
  context.restore();
}
function paintShape(look) {
  const { context } = surface, { node } = look, paths = pathsOf(look), alpha = context.globalAlpha;
  if (look.fill) context.fillStyle = look.fill;
  if (look.stroke) {
    context.strokeStyle = look.stroke;
    context.lineCap = look.cap;
    context.lineJoin = look.join;
    context.lineWidth = node.style.strokeWidth ? parseFloat(node.style.strokeWidth) : look.width * (look.fixed ? size : 1);
    if (look.dash.length) context.setLineDash(look.dash);
  }
  const fill = (path) => {
    if (look.fill) {
      context.globalAlpha = alpha * look.fillAlpha;
      context.fill(path, look.rule);
    }
  };
  const stroke = (path) => {
    if (look.stroke) {
      context.globalAlpha = alpha * look.strokeAlpha;
      context.stroke(path);
    }
  };
  for (const path of paths) {
    fill(path);
    if (!look.halo) stroke(path);
  }
}
function paintText({ node, fill, stroke, letters }) {
  const { context } = surface, text = node.textContent;
  context.font = letters.replace("1px", node.style.fontSize || "12px");
  context.textAlign = "center";
  context.textBaseline = "middle";
  context.lineJoin = "round";
  context.lineWidth = parseFloat(node.style.strokeWidth) || 1;
  context.strokeStyle = stroke;
  context.fillStyle = fill;
  context.strokeText(text, 0, 0);
  context.fillText(text, 0, 0);
}

/** The picture, after everything has been moved. */
export function paintSurface() {
  const { canvas, context } = surface;
  if (!context || printing) return;
  if (surface.stale) readLooks();
  const { width, height } = stageSize(), ratio = devicePixelRatio, wide = Math.round(width * ratio), high = Math.round(height * ratio);
  if (canvas.width !== wide || canvas.height !== high) {
    canvas.width = wide;
    canvas.height = high;
  }
  context.setTransform(1, 0, 0, 1, 0, 0);
  context.clearRect(0, 0, wide, high);
  context.setTransform(ratio / size, 0, 0, ratio / size, -view[0] * ratio / size, -view[1] * ratio / size);
  surface.layers.forEach(paintLook);
}

/** The body whose outline has a place in the drawing inside of it, the uppermost first. */
export function bodyAt([x, y]) {
  const { context, layers } = surface, groups = layers[PAINTED.indexOf("bodies")]?.children ?? [];
  context.setTransform(1, 0, 0, 1, 0, 0);
  const found = groups.findLast(({ node, children }) => {
    if (!owners.has(node)) return false;
    const [u, v, angle] = node.placed, s = Math.sin(angle), c = Math.cos(angle), [a, b] = minus([x, y], [u, v]), place = [c * a - s * b, s * a + c * b];
    return children.some((look) => {
      context.lineWidth = look.width || 1;
      return look.paths?.some((path) => context.isPointInPath(path, ...place) || context.isPointInStroke(path, ...place));
    });
  });
  return found ? owners.get(found.node) : null;
}
