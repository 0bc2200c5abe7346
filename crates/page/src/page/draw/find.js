// @ts-check
// Linkages for a task: poses of a body, or a path drawn by hand; the answers as a list.
import { all, svgElement } from "../common.js";
import { front } from "./front.js";
import { $, far, met, metre, minus, paint, path, pixel, plus, size, turned, view } from "./stage.js";
import { degrees, metres } from "./tools.js";
import { choose, drawing, edit, say } from "./main.js";
export const wish = { kind: null, poses: [], path: [], answers: [], trade: [], shown: null, held: null };
/** Length of the arm by which a pose is turned [px]. */
const ARM = 46;
/** A path by hand has so many points for the search: more are noise of the hand. */
const PATH_POINTS = 30;
export const wished = () => [...wish.poses.map(({ at }) => at), ...wish.path, ...(wish.answers[wish.shown]?.curve ?? [])];
const armOf = ({ at, angle }) => {
  const [u, v] = pixel(at);
  return [u + ARM * Math.cos(angle), v - ARM * Math.sin(angle)];
};

export function chooseWish(kind) {
  wish.kind = wish.kind === kind ? null : kind;
  for (const button of all("[data-wish]")) button.setAttribute("aria-pressed", button.dataset.wish === wish.kind);
  $("wish-help").textContent = wish.kind === "poses"
    ? "Press at a position of the body and drag in its direction, three to five times. Drag a pose to move it, or its tip to turn it."
    : wish.kind === "path"
    ? "Draw the path of the coupler point. It is closed if it ends next to its start."
    : "";
  $("clear-wish").hidden = $("find").hidden = !wish.kind;
  if (wish.kind) choose("move");
  paint();
}
const isClosed = () => wish.path.length > 8 && far(wish.path[0], wish.path.at(-1)) < .12 * Math.max(...wish.path.map((at) => far(at, wish.path[0])));
/** The path with points at equal distances. */
function evenPath() {
  const list = isClosed() ? [...wish.path, wish.path[0]] : wish.path, lengths = [0];
  for (let k = 1; k < list.length; k++) lengths.push(lengths[k - 1] + far(list[k], list[k - 1]));
  const count = isClosed() ? PATH_POINTS : PATH_POINTS - 1;
  return Array.from({ length: PATH_POINTS }, (_, n) => {
    const along = lengths.at(-1) * n / count,
      k = Math.max(1, lengths.findIndex((length) => length >= along - 1e-15)),
      part = (along - lengths[k - 1]) / (lengths[k] - lengths[k - 1] || 1);
    return plus(list[k - 1], minus(list[k], list[k - 1]).map((value) => value * part));
  });
}
/** The part of the sheet that is seen: its corners [m]. */
const sheet = () => {
  const [w, h] = size();
  return [metre([0, h]), metre([w, 0])];
};
/** Pivots are on the sheet, and no bar is longer than the sheet. */
function sheetLimits() {
  const [low, high] = sheet(), ends = (k) => `[${metres(+low[k].toPrecision(4))}, ${metres(+high[k].toPrecision(4))}]`;
  const diagonal = far(low, high);
  return `[limits]\nground = { x = ${ends(0)}, y = ${ends(1)} }\nlength = [${metres(+(.01 * diagonal).toPrecision(3))}, ${metres(+diagonal.toPrecision(3))}]\n`;
}
/** What is wished, as a task of `cotree synthesize`. */
export function taskText() {
  const list = (items) => `[\n${items.map((item) => `  [${item.join(", ")}],`).join("\n")}\n]`,
    name = `name = "${document.title.match(/^\w+/)?.[0] ?? "task"}"\n`;
  if (wish.kind === "poses") return `${name}[poses]\nat = ${list(wish.poses.map(({ at, angle }) => [...at.map(metres), degrees(angle)]))}\n${sheetLimits()}`;
  return `${name}[path]\npoints = ${list(evenPath().map((at) => at.map((value) => metres(+value.toPrecision(6)))))}\nclosed = ${isClosed()}\n${sheetLimits()}`;
}
export async function find() {
  const few = wish.kind === "poses" ? wish.poses.length < 2 && "at least two poses are needed" : wish.path.length < 5 && "draw a path first";
  if (few) {
    say(few);
    return;
  }
  $("answers").replaceChildren();
  $("trade").hidden = true;
  say("searching\u2026");
  $("find").disabled = true;
  const { solutions, shorter, left_out: left, last, costs, faults } = await front.json("front_answers", taskText());
  $("find").disabled = false;
  wish.answers = [...solutions, ...shorter];
  wish.shown = null;
  const out = Object.values(left).reduce((sum, count) => sum + count, 0),
    told = faults.faults.map(({ message, help }) => `${message}${help ? `; ${help}` : ""}`).join("\n");
  say(
    told ||
      `${solutions.length} ${solutions.length === 1 ? "linkage" : "linkages"}${
        out ? `, ${out} left out: ${Object.entries(left).map(([reason, count]) => `${count} ${reason}`).join("; ")}` : ""
      }${last && !solutions.length ? `; ${last}` : ""}${costs.map((cost) => `; ${cost}`).join("")}`,
  );
  $("answers").append(...solutions.map((solution, k) => answerButton(solution, k)));
  offerTrade(solutions, shorter);
}
function answerButton(solution, k) {
  const { lengths, size, transmission, error } = solution, button = Object.assign(document.createElement("button"), { type: "button" });
  const bars = lengths.map((length) => length === null ? "–" : `${+(1e3 * length).toPrecision(4)}`).join(" · ");
  button.append(
    Object.assign(document.createElement("b"), { textContent: solution.class }),
    Object.assign(document.createElement("span"), {
      textContent: `ground, bars: ${bars} mm; size ${+(1e3 * size).toPrecision(4)} mm; transmission angle at least ${+(180 / Math.PI * transmission)
        .toPrecision(3)}°${error > 1e-9 ? `; off by ${+(1e3 * error).toPrecision(2)} mm` : ""}`,
    }),
  );
  button.addEventListener("click", () => {
    takeAnswer(k);
    for (const other of $("answers").children) other.setAttribute("aria-pressed", other === button);
  });
  for (const kind of ["pointerenter", "focus"]) {
    button.addEventListener(kind, () => {
      wish.shown = k;
      paint();
    });
  }
  return button;
}
function takeAnswer(k) {
  wish.shown = k;
  choose("move");
  drawing.fits = true;
  edit(wish.answers[k].scene, `${wish.answers[k].class} taken`);
}
/** A slider from the most accurate linkage to the smallest one. */
function offerTrade(solutions, shorter) {
  $("trade").hidden = !solutions.length || !shorter.length;
  if ($("trade").hidden) return;
  wish.trade = [solutions[0], ...shorter].map((own) => wish.answers.indexOf(own));
  Object.assign($("size"), { min: 0, max: wish.trade.length - 1, step: 1, value: 0 });
  tellTrade();
}
function tellTrade() {
  const own = wish.answers[wish.trade[+$("size").value]],
    text = `size ${+(1e3 * own.size).toPrecision(3)} mm, off by ${+(1e3 * own.error).toPrecision(2)} mm`;
  $("size").setAttribute("aria-valuetext", text);
  $("size-text").textContent = text;
}
/** While the slider moves the curve is seen; where it is let go the linkage is taken. */
export function showTrade() {
  tellTrade();
  wish.shown = wish.trade[+$("size").value];
  paint();
}
export const takeTrade = () => takeAnswer(wish.trade[+$("size").value]);
export function clearWish() {
  Object.assign(wish, { poses: [], path: [], answers: [], trade: [], shown: null });
  $("answers").replaceChildren();
  $("trade").hidden = true;
  paint();
}
/** Another scene is begun: what was wished belongs to the last one. */
export function forgetWish() {
  if (wish.kind) chooseWish(wish.kind);
  clearWish();
}
/** Takes a press where something is wished. True: it was taken. */
export function pressWish(at, where) {
  if (wish.kind === "path") {
    Object.assign(wish, { path: [at], held: ["path"] });
    return true;
  }
  if (wish.kind !== "poses") return false;
  const tip = wish.poses.findIndex((own) => far(armOf(own), where) < 16), middle = wish.poses.findIndex((own) => far(pixel(own.at), where) < 16);
  if (tip >= 0) wish.held = ["turn", tip];
  else if (middle >= 0) wish.held = ["shift", middle];
  else if (wish.poses.length < 5) {
    wish.poses.push({ at: met(at).at, angle: 0 });
    wish.held = ["turn", wish.poses.length - 1];
  } else {
    say("a four-bar linkage can meet at most five poses exactly");
    wish.held = ["none"];
  }
  return true;
}
export function dragWish(at) {
  const [what, k] = wish.held, own = wish.poses[k];
  if (what === "path" && far(at, wish.path.at(-1)) * view.scale > 4) wish.path.push(at);
  if (what === "shift") own.at = met(at).at;
  if (what === "turn" && far(at, own.at) * view.scale > 8) {
    own.angle = Math.round(180 / Math.PI * Math.atan2(at[1] - own.at[1], at[0] - own.at[0])) * Math.PI / 180;
  }
  paint();
}
export function paintWish(group) {
  if (wish.path.length && wish.kind === "path") {
    svgElement("path", { d: path(wish.path.map(pixel)) + (isClosed() && !wish.held ? "Z" : ""), class: "wished" }, group);
  }
  if (wish.kind === "poses") {
    wish.poses.forEach((own, k) => {
      const at = pixel(own.at), tip = armOf(own), side = turned([-.35 * ARM, 0], own.angle);
      svgElement("path", {
        d: path([plus(at, [-side[1], -side[0]].map((v) => .5 * v)), tip, plus(at, [side[1], side[0]].map((v) => .5 * v))]) + "Z",
        class: "wished-body",
      }, group);
      svgElement("circle", { cx: tip[0], cy: tip[1], r: 6, class: "grab" }, group);
      svgElement("circle", { cx: at[0], cy: at[1], r: 6, class: "grab" }, group);
      svgElement("text", { x: at[0], y: at[1] + 22, class: "name" }, group, `pose ${k + 1}`);
    });
  }
  const curve = wish.answers[wish.shown]?.curve;
  if (curve?.length && wish.kind) svgElement("path", { d: path(curve.map(pixel)), class: "answer" }, group);
}
