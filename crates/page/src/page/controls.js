// @ts-check
// Sliders, transport, zoom and keys.
import { all, changeTheme, digits12, round, targetOf } from "./common.js";
import { $, G, INDEX, MODEL, pretty, shown, START, STEP, STOP, three, UNITS, VARIABLES } from "./data.js";
import { bodyAt, crowded, putOnPaper, surface } from "./canvas.js";
import { add, forms, gain, jointAt, owners, PIN, pixel, pose, S, spot, trackEnds, turned } from "./figure.js";
import { arrows, forces, held, layers, names, pointAt, pointed, rates, renewGhosts, scales, togglePath } from "./marks.js";
import { addPlot, chooseAcross, fitPlot, paintLegends, plots, renewPlots } from "./plots.js";
import { bodyNear, hold, inWorld, letGo, pullTo, REACH, TOUCH, touching } from "./touch.js";
import { adopt, commit } from "./edit.js";
import { eachPose, paint, record, solveAgain, state, tell } from "./main.js";
const SPEEDS = [.1, .25, .5, 1, 2];
export const transport = { playing: false, speed: 1, before: 0, frame: 0 };

export function play() {
  if (transport.playing) return;
  if (state.time >= end()) state.time = START;
  transport.playing = true;
  transport.before = performance.now();
  transport.frame = requestAnimationFrame(tick);
  showTransport();
}
export function pause() {
  const played = transport.playing;
  transport.playing = false;
  cancelAnimationFrame(transport.frame);
  if (played) paint();
  showTransport();
}
function showTransport() {
  $("play-icon").setAttribute("d", transport.playing ? "M7 5h3.4v14H7zM13.6 5H17v14h-3.4z" : "M8 5v14l12-7Z");
  $("play").setAttribute("aria-label", transport.playing ? "Pause" : "Play");
}
const end = () => state.run.times[Math.max(state.run.last, 0)];
/** The stamp of the first frame may lie before play was called. */
function tick(now) {
  if (!transport.playing) return;
  state.time += Math.max(0, Math.min(now - transport.before, 100)) / 1000 * transport.speed;
  transport.before = now;
  if (state.time > end()) state.time = START;
  paint();
  transport.frame = requestAnimationFrame(tick);
}
export function seek(time) {
  state.time = Math.min(Math.max(time, START), end());
  paint();
}
export function setSpeed(speed) {
  transport.speed = speed;
  [...$("speeds").children].forEach((button, k) => {
    button.setAttribute("aria-checked", SPEEDS[k] === speed);
    button.tabIndex = SPEEDS[k] === speed ? 0 : -1;
  });
}
export function makeSpeeds() {
  for (const speed of SPEEDS) {
    const button = document.createElement("button");
    button.type = "button";
    button.setAttribute("role", "radio");
    button.textContent = `${speed}×`;
    button.addEventListener("click", () => setSpeed(speed === transport.speed ? SPEEDS[(SPEEDS.indexOf(speed) + 1) % SPEEDS.length] : speed));
    $("speeds").append(button);
  }
}

/** What can be set, and between which values the slider goes. */
function settable() {
  const inputs = VARIABLES.filter((v) => v.kind === "input"),
    parameters = VARIABLES.filter((v) => v.kind === "parameter" && !v.loose),
    initial = VARIABLES.filter((v) => v.initial);
  return [...inputs, ...parameters, ...initial].map((variable) => ({
    variable,
    index: INDEX.get(variable.name),
    start: variable.start,
    range: range(variable),
  }));
}
function range({ start, min, max, unit, initial }) {
  const size = unit === "rad" && initial
    ? Math.PI / 2
    : Math.abs(start) || ({ N: 10, "N.m": 1, "m/s": 1, "rad/s": 5, "m/s2": 10, rad: Math.PI / 2 }[unit] ?? 1);
  const around = start === 0 || initial ? [start - size, start + size] : [start - .75 * size, start + size];
  return [
    min ?? (max !== null && max < around[1] ? Math.min(around[0], max) : around[0]),
    max ?? (min !== null && min > around[0] ? Math.max(around[1], min + size) : around[1]),
  ].map((v, k) => k === 0 && min !== null ? Math.max(v, min) : v);
}
export const knobs = [];
export function makeSliders() {
  for (const knob of settable()) makeSlider(knob, $("sliders"));
  for (const { name, variable } of state.loose ? TOUCH.numbers : []) {
    const { start } = variable;
    makeSlider({ variable: { ...variable, name }, index: INDEX.get(variable.name), start, range: range(variable), loose: true }, $("loose-sliders"));
  }
  // What pulling adds to the laws of drivers has no slider: a pulled body has.
  for (const { parameter, output } of state.loose ? TOUCH.laws : []) {
    if (parameter !== output) {
      knobs.push({
        index: INDEX.get(parameter),
        name: parameter,
        title: parameter,
        start: 0,
        value: 0,
        isInput: false,
        loose: true,
        moves: [],
        show() {},
        told: () => "",
      });
    }
  }
}
function makeSlider({ variable, index, start, range, loose = false }, parent) {
  const box = document.createElement("div"),
    label = document.createElement("label"),
    typed = document.createElement("input"),
    output = document.createElement("output"),
    track = document.createElement("div"),
    input = document.createElement("input"),
    tick = document.createElement("i");
  const { name, factor } = shown(variable), id = `set-${index}`;
  box.className = "slider";
  track.className = "track";
  input.type = "range";
  input.id = label.htmlFor = id;
  input.step = "any";
  label.textContent = variable.kind === "output" || variable.initial
    ? `${variable.name} at the start`
    : loose
    ? variable.name
    : variable.name.replaceAll("_", " ");
  label.title = variable.text;
  typed.className = "typed";
  typed.inputMode = "decimal";
  typed.autocomplete = "off";
  typed.title = "Type a value, also beyond the slider";
  typed.setAttribute("aria-label", `${label.textContent}${name ? ` in ${pretty(name)}` : ""}`);
  output.textContent = pretty(name);
  track.append(input, tick);
  box.append(label, typed, output, track);
  parent.append(box);
  const knob = {
    index,
    name: VARIABLES[index].name,
    title: label.textContent,
    loose,
    start,
    low: range[0],
    high: range[1],
    value: start,
    isInput: variable.kind === "input",
    moves: [],
    label,
  };
  knob.show = () => {
    // An arrow that is dragged, or a value that is typed, may go further than the slider would.
    knob.low = Math.min(knob.low, knob.value);
    knob.high = Math.max(knob.high, knob.value);
    const part = (value) => (value - knob.low) / (knob.high - knob.low);
    input.min = knob.low;
    input.max = knob.high;
    tick.style.left = `calc(8px + (100% - 16px) * ${part(start)})`;
    typed.value = three(knob.value / factor);
    input.setAttribute("aria-valuetext", `${typed.value} ${pretty(name)}`.trim());
    input.value = knob.value;
    input.style.setProperty("--p", `${100 * part(knob.value)}%`);
    box.classList.toggle("changed", knob.value !== start || knob.moves.length > 0);
  };
  const set = (value) => {
    turn(knob, value);
    knob.show();
    askAgain();
  };
  knob.told = () => `${three(knob.value / factor)} ${pretty(name)}`.trim();
  knob.type = () => {
    if (loose) $("numbers").open = true;
    typed.focus();
  };
  input.addEventListener("input", () => set(+input.value));
  input.addEventListener("change", () => commit(`${knob.title} ${knob.told()}`));
  // All digits, to be changed.
  typed.addEventListener("focus", () => {
    typed.value = digits12(knob.value / factor);
    typed.select();
  });
  typed.addEventListener("blur", knob.show);
  typed.addEventListener("keydown", (event) => {
    if (event.key === "Escape") typed.value = digits12(knob.value / factor);
  });
  typed.addEventListener("change", () => {
    const { value, fault } = read(typed.value, variable);
    if (fault) {
      tell(`${label.textContent}: ${fault}`);
      knob.show();
      return;
    }
    if (value !== +(knob.value / factor).toPrecision(12) * factor) {
      set(value);
      commit(`${knob.title} ${knob.told()}`);
    }
  });
  knob.show();
  knobs.push(knob);
}
/** Units that may be typed instead of the one that is shown, by the SI unit. */
const TYPED_UNITS = {
  m: { m: 1, cm: .01, mm: .001, "µm": 1e-6, um: 1e-6, km: 1e3, in: .0254, ft: .3048 },
  rad: { rad: 1, deg: Math.PI / 180, "°": Math.PI / 180 },
  kg: { kg: 1, g: 1e-3, t: 1e3, lb: .45359237 },
  N: { N: 1, kN: 1e3 },
  "N.m": { "N.m": 1, "N·m": 1, "N.mm": 1e-3, "N·mm": 1e-3 },
  "m/s": { "m/s": 1, "mm/s": 1e-3, "km/h": 1 / 3.6 },
  "rad/s": { "rad/s": 1, "deg/s": Math.PI / 180, rpm: Math.PI / 30 },
  "N/m": { "N/m": 1, "N/mm": 1e3 },
};
/** The value in SI units of what was typed in the unit that is shown, or what is wrong with it. */
function read(text, variable) {
  const { name, factor: own } = shown(variable), { min, max } = variable, unit = pretty(name), plain = text.trim().replaceAll("−", "-").replace(",", ".");
  const others = TYPED_UNITS[variable.unit] ?? {}, [, written = plain, word = ""] = plain.match(/^(.*?[\d.])\s*([A-Za-z°µ"″].*)$/) ?? [];
  const factor = word === "" || word === unit || word === name ? own : others[word],
    number = (factor === undefined ? plain : written).trim(),
    value = +number * (factor ?? own),
    limit = (bound) => `${+(bound / own).toPrecision(6)} ${unit}`.trim();
  if (number === "" || !Number.isFinite(value)) return { fault: `"${text}" is no number` };
  if (min !== null && value < min) return { fault: `at least ${limit(min)}` };
  if (max !== null && value > max) return { fault: `at most ${limit(max)}` };
  return { value };
}
/** An input that is moved while the mechanism runs changes from then on; everything else holds from the start. */
export function turn(knob, value) {
  knob.value = value;
  if (!knob.isInput || !transport.playing) {
    knob.moves = [];
    return;
  }
  knob.moves = knob.moves.filter((move) => move.at < state.time);
  knob.moves.push({ at: state.time, name: knob.name, value });
}
let asked = false;
export function askAgain() {
  if (asked) return;
  asked = true;
  requestAnimationFrame(() => {
    asked = false;
    solveAgain();
  });
}
export const moves = () => knobs.flatMap((knob) => knob.moves).sort((a, b) => a.at - b.at);
export const settings = () =>
  knobs.flatMap((knob) => {
    const value = knob.moves.length ? knob.before ?? knob.start : knob.value;
    if (!knob.moves.length) knob.before = knob.value;
    return value === knob.start ? [] : [[knob.name, value]];
  });
export function resetSliders() {
  adopt({ values: [], pose: null });
  commit("as in the scene");
}

/** The values that were found, as lines for the scene, and as options of the commands. */
export function foundLines() {
  const found = knobs.filter((knob) => !knob.loose && knob.value !== knob.start).map((knob) => ({ ...VARIABLES[knob.index], value: knob.value }));
  const written = ({ value, ...variable }) => {
    const { name, factor } = shown(variable), number = +(value / factor).toPrecision(12);
    return name ? `"${number} ${name}"` : `${number}`;
  };
  const table = (name, own, line) => own.length ? [`[${name}]`, ...own.map(line)] : [];
  const [inputs, parameters, initial] = [(v) => v.kind === "input", (v) => v.kind === "parameter", (v) => v.initial].map((is) => found.filter(is));
  const options = [...parameters, ...inputs].map((own) => `--set ${own.name}=${written(own)}`).join(" ");
  return [
    ...table("parameters", parameters, (own) => `${own.name} = ${written(own)}`),
    ...table("inputs", inputs, (own) => `${own.name} = { start = ${written(own)} }`),
    ...table("initial", initial, (own) => `"${own.name}" = ${written(own)}`),
    ...(options ? [`# ${options}`] : []),
    ...(state.pose || knobs.some((knob) => knob.loose && knob.value !== knob.start) ? ["# other numbers have changed, too: Save, Scene text"] : []),
    "",
  ].join("\n");
}
/** Copies them; where the browser does not let a page do so, they are shown. */
async function copyFound() {
  const lines = foundLines();
  try {
    await navigator.clipboard.writeText(lines);
    $("status").textContent = "copied: lines for the scene";
  } catch {
    tell(lines, true);
  }
}

/** On paper the stage is as large as the style says: 18 by 12 centimetres. */
export let printing = false;
export const stageSize = () => printing ? { width: 680, height: 454 } : $("stage").getBoundingClientRect();
// The part of the world that is seen, in pixels of the drawing.
export let view = [0, 0, 1, 1], fitted = true, size = 1, whole = [0, 0, 1, 1];
/** Shows a part of the world, whatever the whole motion takes. */
export function showPart(part) {
  view = part;
  fitted = false;
  look();
}
/** The extent of the whole motion. */
export function measure() {
  let [x0, x1, y0, y1] = [Infinity, -Infinity, Infinity, -Infinity];
  /** @type {(at: number[]) => void} */
  const see = ([x, y]) => {
    if (Number.isFinite(x + y)) [x0, x1, y0, y1] = [Math.min(x0, x), Math.max(x1, x), Math.min(y0, y), Math.max(y1, y)];
  };
  const anchors = [...G.joints, ...G.springs].flatMap((part) => part.ends).concat((G.stops ?? []).map(({ at }) => at));
  eachPose(() => {
    G.bodies.forEach((body, index) => forms[index].concat([body.centre], body.rim).forEach((at) => see(pixel(add(pose[index], 1, turned(index, at))))));
    anchors.forEach((anchor) => see(spot(anchor)));
    trackEnds.forEach((ends) => ends().forEach(see));
    for (const wheel of G.wheels) {
      const [x, y] = spot(wheel.centre), r = S * wheel.radius;
      see([x - r, y - r]);
      see([x + r, y + r]);
    }
  });
  const room = 5 * PIN;
  if (x1 >= x0) whole = [x0 - room, y0 - room, x1 - x0 + 2 * room, y1 - y0 + 2 * room];
}
export function fit() {
  const { width, height } = stageSize(), top = 54, low = 40;
  if (!width) return;
  const k = Math.max(whole[2] / (width - 28), whole[3] / (height - top - low));
  view = [whole[0] + whole[2] / 2 - k * width / 2, whole[1] + whole[3] / 2 - k * (top + (height - top - low) / 2), k * width, k * height];
  fitted = true;
  look();
}
export function zoom(factor, x = view[0] + view[2] / 2, y = view[1] + view[3] / 2) {
  const wide = Math.min(Math.max(view[2] * factor, whole[2] / 50), whole[2] * 8), k = wide / view[2];
  view = [x - (x - view[0]) * k, y - (y - view[1]) * k, wide, view[3] * k];
  fitted = false;
  look();
}
const nice = (value) => {
  const e = 10 ** Math.floor(Math.log10(value)), m = value / e;
  return (m >= 5 ? 5 : m >= 2 ? 2 : 1) * e;
};
const metres = (value) =>
  UNITS.has("m")
    ? `${+(value / UNITS.get("m").factor).toPrecision(3)} ${UNITS.get("m").name}`
    : value >= 1
    ? `${+value.toPrecision(3)} m`
    : value >= 1e-3
    ? `${+(value * 1e3).toPrecision(3)} mm`
    : `${+(value * 1e6).toPrecision(3)} µm`;
function look() {
  const { width, height } = stageSize();
  if (!width || !Number.isFinite(view[2])) return;
  $("scene").setAttribute("viewBox", view.map(round).join(" "));
  size = Math.max(view[2] / width, view[3] / height);
  const metre = UNITS.get("m")?.factor ?? 1, long = nice(110 * size / S / metre) * metre, cell = nice(70 * size / S) * S, grid = $("grid");
  $("length-bar").style.width = `${long * S / size}px`;
  $("length-text").textContent = gain === 1 ? metres(long) : `${metres(long)}, motion × ${gain}`;
  $("force-scale").classList.toggle("hide", !(scales.newton > 0) || !layers.forces);
  if (scales.newton > 0) {
    const unit = UNITS.get("N"), force = unit ? nice(80 * size / scales.newton / unit.factor) * unit.factor : nice(80 * size / scales.newton);
    $("force-bar").style.width = `${force * scales.newton / size}px`;
    $("force-text").textContent = unit ? `${+(force / unit.factor).toPrecision(3)} ${pretty(unit.name)}` : `${+force.toPrecision(3)} N`;
  }
  grid.setAttribute("width", cell);
  grid.setAttribute("height", cell);
  grid.firstElementChild.setAttribute("d", `M0 0H${cell}M0 0V${cell}`);
  grid.firstElementChild.setAttribute("stroke-width", 2 * size);
  const back = $("backdrop");
  // Larger than what is seen: a resize shows its margins before it is told.
  ["x", "y", "width", "height"].forEach((name, k) => back.setAttribute(name, k < 2 ? view[k] - view[k + 2] : 3 * view[k]));
  for (const { text } of [...names, ...forces, ...held]) {
    text.style.fontSize = `${(text.classList.contains("name") ? 13 : 11.5) * size}px`;
    text.style.strokeWidth = `${3.5 * size}px`;
  }
  // A mass centre that is smaller than a point says nothing.
  surface.far = .72 * PIN < 2 * size;
  $("bodies").classList.toggle("far", surface.far);
  for (const path of [arrows, rates]) path.style.strokeWidth = `${1.6 * size}px`;
  for (const grip of all("circle.grip")) {
    grip.setAttribute("r", round(8 * size));
    grip.setAttribute("stroke-width", round(1.5 * size));
  }
  paint();
}
export function toggle(layer) {
  layers[layer] = !layers[layer];
  showLayers();
  if (layer === "ghosts") renewGhosts();
  look();
}
export function showLayers() {
  for (const button of all("[data-layer]")) button.setAttribute("aria-pressed", layers[button.dataset.layer]);
  $("traces").classList.toggle("hide", !layers.traces);
}

/** Where the pointer is, in the drawing. */
export const inScene = (event) => new DOMPoint(event.clientX, event.clientY).matrixTransform($("scene").getScreenCTM().inverse());
export function listenToStage() {
  const stage = $("stage"), touches = new Map();
  stage.addEventListener("wheel", (event) => {
    event.preventDefault();
    const { x, y } = inScene(event);
    zoom(Math.exp(event.deltaY * .0015), x, y);
  }, { passive: false });
  let pressed = null, named = null, meant = null;
  // One finger on a body pulls it; a second one moves the view.
  const pulled = (event) => {
    const { x, y } = inScene(event);
    return state.loose && touching.mode === "pull" && touches.size === 1
      ? owners.get(targetOf(event).closest("#bodies > g")) ?? bodyNear([x, y], REACH[event.pointerType] ?? REACH.mouse)
      : null;
  };
  const drop = (keep) => {
    meant = null;
    if (touching.hold) letGo(keep);
  };
  stage.addEventListener("pointerdown", (event) => {
    pressed = event;
    if (!targetOf(event).closest("button,.grip")) {
      touches.set(event.pointerId, event);
      stage.setPointerCapture(event.pointerId);
      stage.classList.add("dragging");
      const body = pulled(event);
      if (touches.size > 1) drop(true);
      else if (body !== null) meant = { body, from: event };
    }
  });
  stage.addEventListener("pointermove", (event) => {
    const old = touches.get(event.pointerId);
    if (!old) {
      const { x, y } = inScene(event), joint = targetOf(event).closest("button,.grip") ? null : jointAt([x, y]), body = crowded ? bodyAt([x, y]) : pointed;
      if (body !== pointed) pointAt(body);
      if (joint !== named) {
        named = joint;
        stage.classList.toggle("pointing", Boolean(joint));
        $("scene-title").textContent = joint?.name ?? "";
      }
      return;
    }
    touches.set(event.pointerId, event);
    if (meant && Math.hypot(event.clientX - meant.from.clientX, event.clientY - meant.from.clientY) >= 4) {
      if (!hold(meant.body, inWorld(meant.from))) touches.delete(event.pointerId);
      meant = null;
    }
    if (touching.hold) {
      pullTo(inWorld(event));
      return;
    }
    if (meant) return;
    if (touches.size === 2) {
      const other = [...touches.values()].find((touch) => touch.pointerId !== event.pointerId),
        away = (touch) => Math.hypot(touch.clientX - other.clientX, touch.clientY - other.clientY);
      const { x, y } = inScene({ clientX: (event.clientX + other.clientX) / 2, clientY: (event.clientY + other.clientY) / 2 });
      if (away(event) > 4) zoom(away(old) / away(event), x, y);
      return;
    }
    view[0] -= (event.clientX - old.clientX) * size;
    view[1] -= (event.clientY - old.clientY) * size;
    fitted = false;
    look();
  });
  for (const name of ["pointerup", "pointercancel"]) {
    stage.addEventListener(name, (event) => {
      touches.delete(event.pointerId);
      drop(name === "pointerup");
      if (!touches.size) stage.classList.remove("dragging");
    });
  }
  stage.addEventListener("click", (event) => {
    const { x, y } = inScene(event),
      still = pressed && Math.hypot(event.clientX - pressed.clientX, event.clientY - pressed.clientY) < 4,
      joint = still && !targetOf(event).closest("button,.grip") && jointAt([x, y]);
    if (joint) togglePath(joint.anchor);
  });
  new ResizeObserver(() => requestAnimationFrame(() => fitted ? fit() : look())).observe(stage);
}

export function listenToKeys() {
  const faster = (by) => setSpeed(SPEEDS[Math.min(Math.max(SPEEDS.indexOf(transport.speed) + by, 0), SPEEDS.length - 1)]);
  addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || $("keys").open || targetOf(event).closest("select,.typed")) return;
    const slider = targetOf(event).matches("input[type=range]") && targetOf(event).id !== "scrub",
      step = (event.shiftKey ? 10 : 1) * STEP,
      go = (by) => () => {
        pause();
        seek(by);
      };
    const action = {
      " ": targetOf(event).closest("button,summary") ? null : () => transport.playing ? pause() : play(),
      ArrowRight: slider ? null : go(state.time + step),
      ArrowLeft: slider ? null : go(state.time - step),
      Home: slider ? null : go(START),
      End: slider ? null : go(STOP),
      "[": () => faster(-1),
      "]": () => faster(1),
      "+": () => zoom(.8),
      "=": () => zoom(.8),
      "-": () => zoom(1.25),
      0: fit,
      t: () => toggle("traces"),
      f: () => toggle("forces"),
      v: () => toggle("velocities"),
      g: () => toggle("ghosts"),
      n: () => toggle("names"),
      "?": () => $("keys").showModal(),
    }[event.key];
    if (action) {
      event.preventDefault();
      action();
    }
  });
}

function recolour() {
  surface.stale = true;
  if (!transport.playing) paint();
  plots.forEach((plot) => plot.chart.redraw(false, true));
}
export function listenToButtons() {
  $("play").addEventListener("click", () => transport.playing ? pause() : play());
  $("scrub").min = START;
  $("scrub").max = STOP > START ? STOP : START + 1;
  $("scrub").addEventListener("input", (event) => {
    pause();
    seek(+targetOf(event).value);
  });
  $("end").textContent = ` / ${+STOP.toFixed(3)}\u202fs`;
  $("zoom-in").addEventListener("click", () => zoom(.8));
  $("zoom-out").addEventListener("click", () => zoom(1.25));
  $("zoom-fit").addEventListener("click", fit);
  $("reset").addEventListener("click", resetSliders);
  $("copy").addEventListener("click", copyFound);
  $("help").addEventListener("click", () => $("keys").showModal());
  for (const button of all("[data-layer]")) button.addEventListener("click", () => toggle(button.dataset.layer));
  $("theme").addEventListener("click", () => {
    changeTheme();
    recolour();
  });
  matchMedia("(prefers-color-scheme:dark)").addEventListener("change", recolour);
  // Paper is white, and shows the whole motion, however the screen was zoomed.
  let before = null, theme;
  addEventListener("beforeprint", () => {
    before = fitted ? null : view;
    printing = true;
    putOnPaper(true);
    theme = document.documentElement.dataset.theme;
    document.documentElement.dataset.theme = "light";
    recolour();
    fit();
    plots.forEach(({ chart }) => chart.setSize({ width: 660, height: 130 }));
  });
  addEventListener("afterprint", () => {
    printing = false;
    putOnPaper(false);
    if (theme) document.documentElement.dataset.theme = theme;
    else delete document.documentElement.dataset.theme;
    recolour();
    plots.forEach(fitPlot);
    if (before) {
      view = before;
      fitted = false;
      look();
    } else fit();
  });
  const known = state.solver ? VARIABLES.filter(({ kind }) => kind === "output" || kind === "local").map(({ name }) => name) : MODEL.recorded;
  for (const name of known) for (const list of ["add", "across"]) $(list).append(new Option(name, name));
  $("add").addEventListener("change", (event) => {
    if (targetOf(event).value) {
      record(targetOf(event).value);
      addPlot([targetOf(event).value]);
      renewPlots();
      paintLegends();
    }
    targetOf(event).value = "";
  });
  $("across").addEventListener("change", (event) => {
    if (targetOf(event).value) record(targetOf(event).value);
    chooseAcross(targetOf(event).value);
  });
}
