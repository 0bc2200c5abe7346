// What has been changed: undone and done again, written into the scene's text, shared by an address; and what is seen, as files.
/** Each: the values that are not the scene's, by name, and the pose at the start if the scene's guesses do not lead to it. */
const history = { states: [{ values: [], pose: null }], now: 0 };
const changedKnobs = () => knobs.filter(knob => knob.value !== knob.start);
const present = () => ({ values: changedKnobs().map(knob => [knob.name, knob.value]), pose: state.pose ?? null });
const equal = (a, b) => JSON.stringify(a) === JSON.stringify(b);

/** A change is done: it can be undone. */
function commit(what) {
  const now = present();
  if (equal(now, history.states[history.now])) return;
  history.states.splice(history.now + 1, Infinity, now);
  history.now++;
  if (what) say(what);
  showHistory();
  dispatchEvent(new CustomEvent("cotree-changed"));
}
function showHistory() {
  $("undo").disabled = history.now === 0;
  $("redo").disabled = history.now === history.states.length - 1;
}
function goBack(by) {
  const next = history.states[history.now + by];
  if (!next) return;
  history.now += by;
  adopt(next);
  say(by < 0 ? "undone" : "redone");
  showHistory();
  dispatchEvent(new CustomEvent("cotree-changed"));
}
/** Takes over values by name; the others are the scene's. */
function adopt({ values, pose }) {
  const wanted = new Map(values);
  for (const knob of knobs) { knob.value = wanted.get(knob.name) ?? knob.start; knob.before = undefined; knob.moves = []; knob.show(); }
  state.pose = pose;
  solveAgain();
}

/** The law of a driver with something added, in SI units: a sum binds least, but a unit needs its brackets. */
function lawText(old, value) {
  const quote = old.match(/^["']/)?.[0] ?? '"', law = /^["']/.test(old) ? old.slice(1, -1) : old;
  const plain = law.replace(/^(\s*[-+]?[\d.]+(?:[eE][-+]?\d+)?)\s*([A-Za-z°][^*+-]*)$/, (_, number, unit) => `${number}[${unit.trim()}]`);
  return `${quote}${plain} ${value < 0 ? "-" : "+"} ${digits12(Math.abs(value))}${quote}`;
}
/** A value in a line of its own. */
const inLine = (name, value) => { const { unit } = VARIABLES[INDEX.get(name)]; return unit ? `"${digits12(value)} ${unit}"` : digits12(value); };

/** Places of the text with what stands there now, and lines for what the text does not have yet, by its table. */
function textChanges() {
  const bytes = bytesOf(TOUCH.text), at = ([from, to]) => textOf(bytes.subarray(from, to)), unitOf = ({ name, unit }) => unit ?? { name: VARIABLES[INDEX.get(name)].unit, factor: 1 };
  const places = [], lines = { parameters: [], inputs: [], initial: [] }, known = name => TOUCH.written.find(own => own.name === name), write = (own, value) => places.push([own.place, inText(value, { ...own, unit: unitOf(own) }, at(own.place))]);
  for (const { name, value } of changedKnobs()) {
    const own = TOUCH.numbers.find(own => own.variable.name === name)?.written ?? known(name), law = TOUCH.laws.find(own => own.parameter === name && own.output !== name);
    if (own) write(own, value);
    else if (law) places.push([law.place, lawText(at(law.place), value)]);
    else if (VARIABLES[INDEX.get(name)].kind === "input") lines.inputs.push(`${name} = { start = ${inLine(name, value)} }`);
    else lines.initial.push(`"${name}" = ${inLine(name, value)}`);
  }
  state.pose?.forEach((value, k) => {
    const name = TOUCH.coordinates[k], own = known(name);
    if (changedKnobs().some(knob => knob.name === name)) return;
    if (own && !knobs.some(knob => knob.name === name)) write(own, value);
    else if (!own) lines.initial.push(`"${name}" = { guess = ${inLine(name, value)} }`);
  });
  return { places, lines };
}
/** The scene's text with the values that were found; comments and all else stay. */
function sceneText() {
  const { places, lines } = textChanges();
  let text = spliced(TOUCH.text, places);
  for (const [table, added] of Object.entries(lines).filter(([, added]) => added.length)) {
    if (text.trimStart().startsWith("{")) throw new Error(`the scene is JSON: add these to its "${table}" yourself: ${added.join(", ")}`);
    const head = new RegExp(`^\\[${table}\\][^\\n]*\\n`, "m");
    if (!head.test(text)) text += `${text.endsWith("\n") ? "" : "\n"}\n[${table}]\n`;
    text = text.replace(head, found => `${found}${added.join("\n")}\n`);
  }
  return text;
}

/** Names that keep their meaning when the scene changes: those of numbers, and of what is added to the laws of a driver, are the scene's. */
const lastingNames = () => [
  ...(TOUCH?.numbers ?? []).map(({ name, variable }) => [variable.name, name]),
  ...(TOUCH?.laws ?? []).filter(law => law.output !== law.parameter).map((law, _, all) => [law.parameter, `${law.driver}+${all.filter(({ driver }) => driver === law.driver).indexOf(law)}`]),
];
/** Values under names that last, and back; a name that is not known here stays. */
function lasting(values) { const names = new Map(lastingNames()); return values.map(([name, value]) => [names.get(name) ?? name, value]); }
function ownNames(values) { const names = new Map(lastingNames().map(([own, name]) => [name, own])); return values.map(([name, value]) => [names.get(name) ?? name, value]); }

/** The address of this page with what has been changed. */
function shareAddress() {
  const { values, pose } = present(), named = lasting(values);
  return `${location.href.split("#")[0]}#set=${encodeURIComponent(JSON.stringify(pose ? [named, pose] : [named]))}`;
}
/** Takes over what an address says of what is still there. */
function adoptAddress(text) {
  let shared;
  try { shared = JSON.parse(text); } catch { tell("The address of this page is truncated: its values cannot be read."); return; }
  const [values, pose = null] = Array.isArray(shared) ? shared : [], known = [], lost = [];
  for (const [name, value] of ownNames((Array.isArray(values) ? values : []).filter(Array.isArray))) {
    if (Number.isFinite(value) && knobs.some(knob => knob.name === name)) known.push([name, value]); else lost.push(name);
  }
  const fits = Array.isArray(pose) && pose.length === TOUCH?.coordinates.length && pose.every(Number.isFinite);
  adopt({ values: known, pose: fits ? pose : null });
  commit();
  if (lost.length) tell(`The address has values of quantities that this page does not have: ${lost.join(", ")}`);
}

const title = () => document.querySelector("h1").textContent.replace(/[^\w.-]+/g, "_") || "mechanism";

/** What is seen, as a picture that stands alone: the style of the page goes along. */
function pictureSvg() {
  if (crowded) putOnPaper(true);
  const picture = $("scene").cloneNode(true), { width, height } = stageSize(), root = getComputedStyle(document.documentElement);
  if (crowded) { putOnPaper(false); paint(); }
  for (const name of ["id", "role", "aria-label"]) picture.removeAttribute(name);
  picture.querySelector("#grips")?.remove();
  for (const [name, value] of Object.entries({ xmlns: SVG, width, height })) picture.setAttribute(name, value);
  const sheet = document.querySelectorAll("style")[1].textContent, names = new Set(sheet.match(/--[\w]+/g)), colours = [...names].map(name => `${name}:${root.getPropertyValue(name)}`).join(";");
  const rules = sheet.split("\n").filter(rule => /^\.(grid|body|name|value|arrow|speed|turn|path|hide|far)/.test(rule)).join("\n");
  const style = element("style", {}, null, `svg{${colours};background:${css("--card")};font-family:system-ui,sans-serif}\n${rules}`);
  picture.prepend(style);
  return new XMLSerializer().serializeToString(picture);
}
async function picturePng() {
  const { width, height } = stageSize(), image = new Image(), canvas = Object.assign(document.createElement("canvas"), { width: 2 * width, height: 2 * height });
  image.src = `data:image/svg+xml;charset=utf-8,${encodeURIComponent(pictureSvg())}`;
  await image.decode();
  canvas.getContext("2d").drawImage(image, 0, 0, canvas.width, canvas.height);
  return new Promise(done => canvas.toBlob(done, "image/png"));
}
/** The curves that are seen, else what the scene reports, in SI units. */
function tableCsv() {
  const { run } = state, seen = [...new Set(plots.flatMap(plot => plot.names))], names = (seen.length ? seen : MODEL.outputs).filter(name => run.columns.has(name));
  const rows = Array.from({ length: run.last + 1 }, (_, k) => [run.times[k], ...names.map(name => run.columns.get(name)[k])].join(","));
  return [["time", ...names].join(","), ...rows, ""].join("\n");
}

const SAVES = {
  text: () => save(TOUCH.file.split(/[\\/]/).pop() || `${title()}.toml`, sceneText()),
  link: async () => { const address = shareAddress(); try { await navigator.clipboard.writeText(address); say("address copied"); $("status").textContent = "address copied"; } catch { tell(address, true); } },
  svg: () => save(`${title()}.svg`, pictureSvg()),
  png: async () => save(`${title()}.png`, await picturePng()),
  csv: () => save(`${title()}.csv`, tableCsv()),
};
function listenToEdits() {
  $("undo").addEventListener("click", () => goBack(-1));
  $("redo").addEventListener("click", () => goBack(1));
  for (const button of document.querySelectorAll("[data-save]")) button.addEventListener("click", async () => {
    try { await SAVES[button.dataset.save](); } catch (fault) { tell(fault.message); }
    $("save").open = false;
  });
  for (const button of document.querySelectorAll("[data-save=text]")) button.hidden = !TOUCH;
  for (const button of document.querySelectorAll("[data-save=link],#undo,#redo")) button.hidden = !state.solver;
  // A page inside a drawing page has no address of its own.
  if (location.protocol === "about:") document.querySelector("[data-save=link]").hidden = true;
  addEventListener("keydown", event => {
    if (!(event.ctrlKey || event.metaKey) || event.altKey || event.target.closest("select,.typed,dialog")) return;
    const key = event.key.toLowerCase(), by = key === "y" || key === "z" && event.shiftKey ? 1 : key === "z" ? -1 : 0;
    if (by) { event.preventDefault(); goBack(by); }
  });
  addEventListener("pointerdown", event => { if (!event.target.closest("#save")) $("save").open = false; });
  showHistory();
}
