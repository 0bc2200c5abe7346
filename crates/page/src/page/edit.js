// @ts-check
// What has been changed: undone and done again, written into the scene's text, shared by an address; and what is seen, as files.
import { all, digits12, pngOf, save, spliced, SVG, targetOf, Undo, written } from "./common.js";
import { $, css, MODEL } from "./data.js";
import { crowded, putOnPaper } from "./canvas.js";
import { element } from "./figure.js";
import { plots } from "./plots.js";
import { knobs, stageSize } from "./controls.js";
import { say, TOUCH } from "./touch.js";
import { paint, solveAgain, state, tell } from "./main.js";
/** Each: the values that are not the scene's, by name, and the pose at the start if the scene's guesses do not lead to it. */
export const history = new Undo([{ values: [], pose: null }]);
export const changedKnobs = () => knobs.filter((knob) => knob.value !== knob.start);
export const present = () => ({ values: changedKnobs().map((knob) => [knob.name, knob.value]), pose: state.pose ?? null });
const equal = (a, b) => JSON.stringify(a) === JSON.stringify(b);

/** A change is done: it can be undone. */
export function commit(what) {
  const now = present();
  if (equal(now, history.present())) return;
  history.take(now);
  if (what) say(what);
  history.show();
  dispatchEvent(new CustomEvent("cotree-changed"));
}
function goBack(by) {
  const next = history.go(by);
  if (!next) return;
  adopt(next);
  say(by < 0 ? "undone" : "done again");
  history.show();
  dispatchEvent(new CustomEvent("cotree-changed"));
}
/** Takes over values by name; the others are the scene's. */
export function adopt({ values, pose }) {
  const wanted = new Map(values);
  for (const knob of knobs) {
    knob.value = wanted.get(knob.name) ?? knob.start;
    knob.before = undefined;
    knob.moves = [];
    knob.show();
  }
  state.pose = pose;
  solveAgain();
}

/** Places of the text with what stands there now; and entries for what the text does not have yet, by their tables. */
function textChanges() {
  const places = [], entries = { inputs: [], initial: [] }, known = (name) => TOUCH.written.find((own) => own.name === name);
  const enter = (name, value, form) => {
    const own = TOUCH.absent.find((own) => own.name === name);
    if (!own) throw new Error(`the scene's own file does not write \`${name}\`: give it its value yourself`);
    entries[own.table].push(written(value, { ...own[form], factor: 1 }));
  };
  const write = (own, value) => places.push([own.place, written(value, own)]);
  for (const { name, value } of changedKnobs()) {
    const own = TOUCH.numbers.find((own) => own.variable.name === name)?.written ?? known(name),
      law = TOUCH.laws.find((own) => own.parameter === name && own.output !== name);
    if (own) write(own, value);
    else if (law) places.push([law.place, `${law.before}${value < 0 ? "-" : "+"} ${digits12(Math.abs(value))}${law.after}`]);
    else enter(name, value, "known");
  }
  state.pose?.forEach((value, k) => {
    const name = TOUCH.coordinates[k], own = known(name);
    if (changedKnobs().some((knob) => knob.name === name)) return;
    if (own && !knobs.some((knob) => knob.name === name)) write(own, value);
    else if (!own) enter(name, value, "guess");
  });
  return { places, entries };
}
/** The scene's text with the values that were found; comments and all else stay. */
export function sceneText() {
  const { places, entries } = textChanges();
  for (const [table, added] of Object.entries(entries).filter(([, added]) => added.length)) {
    const gap = TOUCH.gaps[table];
    places.push([[gap.at, gap.at], `${gap.head}${added.join(gap.separator)}${gap.tail}`]);
  }
  return spliced(TOUCH.text, places);
}

/** Names that keep their meaning when the scene changes: those of numbers, and of what is added to the laws of a driver, are the scene's. */
const lastingNames = () => [
  ...(TOUCH?.numbers ?? []).map(({ name, variable }) => [variable.name, name]),
  ...(TOUCH?.laws ?? []).filter((law) => law.output !== law.parameter).map((
    law,
    _,
    all,
  ) => [law.parameter, `${law.driver}+${all.filter(({ driver }) => driver === law.driver).indexOf(law)}`]),
];
/** Values under names that last, and back; a name that is not known here stays. */
export function lasting(values) {
  const names = new Map(lastingNames());
  return values.map(([name, value]) => [names.get(name) ?? name, value]);
}
export function ownNames(values) {
  const names = new Map(lastingNames().map(([own, name]) => [name, own]));
  return values.map(([name, value]) => [names.get(name) ?? name, value]);
}

/** The address of this page with what has been changed. */
export function shareAddress() {
  const { values, pose } = present(), named = lasting(values);
  return `${location.href.split("#")[0]}#set=${encodeURIComponent(JSON.stringify(pose ? [named, pose] : [named]))}`;
}
/** Takes over what an address says of what is still there. */
export function adoptAddress(text) {
  let shared;
  try {
    shared = JSON.parse(text);
  } catch {
    tell("The address of this page is cut short: what it shares cannot be read.");
    return;
  }
  const [values, pose = null] = Array.isArray(shared) ? shared : [], known = [], lost = [];
  for (const [name, value] of ownNames((Array.isArray(values) ? values : []).filter(Array.isArray))) {
    if (Number.isFinite(value) && knobs.some((knob) => knob.name === name)) known.push([name, value]);
    else lost.push(name);
  }
  const fits = Array.isArray(pose) && pose.length === TOUCH?.coordinates.length && pose.every(Number.isFinite);
  adopt({ values: known, pose: fits ? pose : null });
  commit();
  if (lost.length) tell(`The address has values of what this page does not have: ${lost.join(", ")}`);
}

const title = () => document.querySelector("h1").textContent.replace(/[^\w.-]+/g, "_") || "mechanism";

/** What is seen, as a picture that stands alone: the style of the page goes along. */
export function pictureSvg() {
  if (crowded) putOnPaper(true);
  const picture = $("scene").cloneNode(true), { width, height } = stageSize(), root = getComputedStyle(document.documentElement);
  if (crowded) {
    putOnPaper(false);
    paint();
  }
  for (const name of ["id", "role", "aria-label"]) picture.removeAttribute(name);
  picture.querySelector("#grips")?.remove();
  for (const [name, value] of Object.entries({ xmlns: SVG, width, height })) picture.setAttribute(name, value);
  const sheet = all("style")[1].textContent,
    names = new Set(sheet.match(/--[\w]+/g)),
    colours = [...names].map((name) => `${name}:${root.getPropertyValue(name)}`).join(";");
  const rules = sheet.split("\n").filter((rule) => /^\.(grid|body|name|value|arrow|speed|turn|path|hide|far)/.test(rule)).join("\n");
  const style = element("style", {}, null, `svg{${colours};background:${css("--card")};font-family:system-ui,sans-serif}\n${rules}`);
  picture.prepend(style);
  return new XMLSerializer().serializeToString(picture);
}
export const picturePng = () => {
  const { width, height } = stageSize();
  return pngOf(pictureSvg(), [width, height]);
};
/** The curves that are seen, else what the scene reports, in SI units. */
export function tableCsv() {
  const { run } = state,
    seen = [...new Set(plots.flatMap((plot) => plot.names))],
    names = (seen.length ? seen : MODEL.outputs).filter((name) => run.columns.has(name));
  const rows = Array.from({ length: run.last + 1 }, (_, k) => [run.times[k], ...names.map((name) => run.columns.get(name)[k])].join(","));
  return [["time", ...names].join(","), ...rows, ""].join("\n");
}

const SAVES = {
  text: () => save(TOUCH.file.split(/[\\/]/).pop() || `${title()}.toml`, sceneText()),
  link: async () => {
    const address = shareAddress();
    try {
      await navigator.clipboard.writeText(address);
      say("address copied");
      $("status").textContent = "address copied";
    } catch {
      tell(address, true);
    }
  },
  svg: () => save(`${title()}.svg`, pictureSvg()),
  png: async () => save(`${title()}.png`, await picturePng()),
  csv: () => save(`${title()}.csv`, tableCsv()),
};
export function listenToEdits() {
  $("undo").addEventListener("click", () => goBack(-1));
  $("redo").addEventListener("click", () => goBack(1));
  for (const button of all("[data-save]")) {
    button.addEventListener("click", async () => {
      try {
        await SAVES[button.dataset.save]();
      } catch (fault) {
        tell(fault.message);
      }
      $("save").open = false;
    });
  }
  for (const button of all("[data-save=text]")) button.hidden = !TOUCH;
  for (const button of all("[data-save=link],#undo,#redo")) button.hidden = !state.solver;
  // A page inside a drawing page has no address of its own.
  if (location.protocol === "about:") {
    all("[data-save=link]").forEach((button) => {
      button.hidden = true;
    });
  }
  addEventListener("keydown", (event) => {
    if (!(event.ctrlKey || event.metaKey) || event.altKey || targetOf(event).closest("select,.typed,dialog")) return;
    const key = event.key.toLowerCase(), by = key === "y" || key === "z" && event.shiftKey ? 1 : key === "z" ? -1 : 0;
    if (by) {
      event.preventDefault();
      goBack(by);
    }
  });
  addEventListener("pointerdown", (event) => {
    if (!targetOf(event).closest("#save")) $("save").open = false;
  });
  history.show();
}
