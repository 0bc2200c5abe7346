// @ts-check
// From the data to the first picture, and from a slider to the next run.
import { unpack } from "./common.js";
import { $, G, inUnits, MODEL, place, START, STOP, storedRun, VARIABLES } from "./data.js";
import { Solver } from "./solver.js";
import { ask } from "./worker.js";
import { makeSurface, paintSurface } from "./canvas.js";
import { chooseGain, drawMechanism, extent, forms, frames, minus, outline, PIN, pose, renewals, S, takePose, turnedBack } from "./figure.js";
import {
  ageDigits,
  chooseScales,
  digits,
  explainHeld,
  heads,
  layers,
  paintForces,
  paintHeld,
  paintNames,
  paintPaths,
  paintVelocities,
  renewGhosts,
  renewPaths,
  reportedPaths,
  showStops,
  sizes,
  taken,
  write,
} from "./marks.js";
import { firstPlots, paintAcross, paintHeads, paintLegends, renewPlots } from "./plots.js";
import {
  fit,
  fitted,
  knobs,
  listenToButtons,
  listenToKeys,
  listenToStage,
  makeSliders,
  makeSpeeds,
  measure,
  moves,
  pause,
  play,
  seek,
  setSpeed,
  settings,
  showLayers,
  showPart,
  size,
  toggle,
  transport,
  view,
  whole,
} from "./controls.js";
import { makeHandles } from "./handles.js";
import { dragAnswered, listenToTouch, makeTouchable, paintTouch, SHARE_OF_FRAME, solverNow, TOUCH, touching } from "./touch.js";
import { adoptAddress, changedKnobs, commit, lasting, listenToEdits, ownNames, present } from "./edit.js";
/** Pace: what a time of the last run has taken, solved and drawn [ms]. */
export const state = { run: null, first: null, time: START, solver: null, pace: 0 };

/** Calls with every sample of the run, the pose taken. */
export function eachSample(call) {
  for (let k = 0; k <= state.run.last; k++) {
    takePose(state.run, [k, 0]);
    call([k, 0]);
  }
}
/** The same with some hundred samples: enough for extents. */
export function eachPose(call) {
  const { last } = state.run, count = Math.min(last, 300);
  for (let k = 0; k <= count; k++) {
    const at = [count ? Math.round(k * last / count) : 0, 0];
    takePose(state.run, at);
    call(at);
  }
}

export function paint() {
  const at = place(state.run, state.time);
  takePose(state.run, at);
  ageDigits();
  for (const frame of frames) frame();
  taken.length = heads.length = 0;
  // What the pointer asks for comes first, then values, then names.
  paintForces(at, size);
  paintVelocities(at, size);
  paintHeld(at, size);
  paintNames(size);
  if (layers.traces) paintPaths(at);
  paintSurface();
  paintTouch();
  paintHeads();
  if (digits.due) paintLegends();
  paintAcross(at);
  const scrub = $("scrub"), done = (state.time - START) / (STOP - START || 1);
  scrub.value = state.time;
  scrub.style.setProperty("--p", `${100 * done}%`);
  if (digits.due) scrub.setAttribute("aria-valuetext", `${state.time.toFixed(3)} seconds`);
  if (digits.due) write($("now"), state.time.toFixed(3));
}

/** Points that a parameter has moved: those of the bodies in their own axes, and those of the ground. */
function takePoints(run) {
  const { columns } = run, k = 0, at = (name) => columns.get(name)?.[k];
  takePose(run, [0, 0]);
  G.bodies.forEach((body, index) =>
    MODEL.points[index].forEach((point, place) => {
      const [x, y] = [at(`${body.name}.${point}.x`), at(`${body.name}.${point}.y`)];
      if (Number.isFinite(x) && Number.isFinite(y)) forms[index][place] = turnedBack(index, minus([x, y], pose[index]));
    })
  );
  for (const anchor of groundAnchors()) {
    const name = MODEL.ground.find((point) => anchor.at[0] === point.at[0] && anchor.at[1] === point.at[1])?.name;
    const [x, y] = [at(`ground.${name}.x`), at(`ground.${name}.y`)];
    if (Number.isFinite(x) && Number.isFinite(y)) anchor.moved = [x, y];
  }
}
const groundAnchors = () =>
  [...G.joints, ...G.springs, ...G.parts].flatMap(({ at, base, moving, ends = [] }) => [at, base, moving, ...ends]).filter((anchor) => anchor?.body === null);

/** What is as large as the run says. */
const reshape = () =>
  renewals.forEach((renew) => {
    takePose(state.run, [0, 0]);
    renew();
  });

function take(run) {
  state.run = run;
  if (state.solver && !MODEL.line) takePoints(run);
  takePose(run, [0, 0]);
  reshape();
  G.bodies.forEach((_, index) => {
    sizes[index] = extent(outline(index)) || 5 * PIN;
  });
  for (const { centre, radius } of G.wheels) if (centre.body !== null) sizes[centre.body] = Math.max(sizes[centre.body], 2 * S * Math.abs(radius));
  renewPaths();
  renewGhosts();
  renewPlots();
  showStops();
  seek(state.time);
}

export function tell(text, plain) {
  $("notice").hidden = !text;
  $("notice").textContent = inUnits(text ?? "");
  $("notice").classList.toggle("plain", Boolean(plain));
}

/** While a handle is dragged a run has as many of its times as a picture leaves time for, this many at least; it has all of them when the handle is let go. */
const FEWEST_POSES = 72;
function nthTime() {
  const all = state.first.times.length;
  return touching.drag ? Math.max(1, Math.floor(all / Math.max(FEWEST_POSES, SHARE_OF_FRAME / state.pace))) : 1;
}
export function solveAgain() {
  const set = settings(),
    list = moves(),
    values = knobs.map((knob) => knob.value),
    pose = state.pose ?? null,
    changed = set.length > 0 || list.length > 0 || pose !== null;
  $("reset").disabled = $("copy").disabled = !changed;
  const solver = solverNow(), times = Solver.times(nthTime());
  ask(
    solver,
    touching.drag ? state.pace * times.length : state.first.ms,
    [set, list, MODEL.recorded.filter((name) => solver.index.has(name)), pose, times],
    (run) => {
      const began = performance.now();
      tell(run.error ?? run.warning);
      $("status").textContent = `${changed ? "dashed: before · " : ""}solved in ${run.ms.toFixed(run.ms < 10 ? 1 : 0)}\u202fms`;
      if (run.last < 0) return;
      knobs.forEach((knob, k) => {
        knob.solved = values[k];
      });
      take(changed ? run : state.first);
      state.pace = (run.ms + performance.now() - began) / run.times.length;
      dragAnswered();
    },
  );
}

/** A variable that no run has recorded so far. */
export function record(name) {
  if (MODEL.recorded.includes(name)) return;
  MODEL.recorded.push(name);
  state.first = state.solver.solve([], [], MODEL.recorded);
  solveAgain();
}

/** The solver at the server of this page, or of the drawing page that this page is in; a frame of another site tells nothing. */
function lentSolver() {
  try {
    return window.cotreeSolver ?? window.parent.cotreeSolver;
  } catch {
    return undefined;
  }
}
export async function begin() {
  const [program, code, stored] = await Promise.all([unpack("program"), lentSolver() ?? unpack("solver"), unpack("run")]);
  // A page in a file outlasts the program that is its solver: then it plays the run that is stored in it.
  const load = () =>
    Solver.load(code, program, VARIABLES.map(({ name }) => name)).catch((fault) => {
      if (!stored) throw fault;
    });
  const solver = code && program ? await load() : null;
  if (solver) {
    Object.assign(state, { code, pose: null, solver });
    await makeTouchable();
    state.first = state.solver.solve([], [], MODEL.recorded);
    state.pace = state.first.ms / state.first.times.length;
    $("status").textContent = `solved in ${state.first.ms.toFixed(0)}\u202fms`;
  } else {
    state.first = storedRun(stored);
    const command = (text) => Object.assign(document.createElement("code"), { textContent: text });
    $("stored").append(
      `This page plays a stored run: ${code ? "the program that was its solver has ended" : "it has no solver"}. For one that has, run `,
      command("cotree view SCENE.toml --serve"),
      "; a file with the solver inside needs a release of cotree, or ",
      command("tools/build-runtimes.sh web"),
      " in its source.",
    );
    $("stored").hidden = false;
  }
  state.run = state.first;
  if (state.first.last < 0) throw new Error(state.first.error);
  tell(state.first.error ?? state.first.warning);
}

export function open() {
  chooseGain(state.first);
  makeSurface();
  drawMechanism();
  explainHeld();
  reportedPaths();
  makeSpeeds();
  listenToButtons();
  if (state.solver) makeSliders();
  listenToEdits();
  // Nothing to try: no panel for it.
  $("try").hidden = !knobs.length;
  document.querySelector("aside").classList.toggle("alone", !knobs.length);
  if (MODEL.recorded.length) firstPlots();
  const span = STOP - START;
  setSpeed(span <= 1 ? .25 : span <= 3 ? .5 : span >= 20 ? 2 : 1);
  reshape();
  measure();
  if (state.solver) makeHandles();
  chooseScales(whole);
  take(state.first);
  showLayers();
  fit();
  listenToStage();
  listenToKeys();
  if (state.loose) listenToTouch();
  const shared = new URLSearchParams(location.hash.slice(1)).get("set");
  if (shared && state.solver) adoptAddress(shared);
  document.documentElement.dataset.ready = "yes";
  const asked = Number(new URLSearchParams(location.hash.slice(1)).get("t") ?? NaN);
  if (Number.isFinite(asked)) seek(asked);
  else if (!matchMedia("(prefers-reduced-motion:reduce)").matches) play();
}

/** What a reader has chosen, for the next page of a scene that is watched. */
export function keep() {
  const values = lasting(present().values);
  return {
    time: state.time,
    playing: transport.playing,
    speed: transport.speed,
    view: fitted ? null : view,
    scale: S,
    layers,
    values,
    pose: state.pose ?? null,
  };
}
/** Values of what is still there; the view in metres, for the new drawing may have another scale. */
export function restore(kept) {
  for (const [name, value] of ownNames(kept.values)) {
    const knob = knobs.find((knob) => knob.name === name);
    if (knob) {
      knob.value = value;
      knob.show();
    }
  }
  state.pose = kept.pose?.length === TOUCH?.coordinates.length ? kept.pose : null;
  if (state.pose || changedKnobs().length) solveAgain();
  commit();
  for (const layer in layers) if (kept.layers[layer] !== layers[layer]) toggle(layer);
  if (kept.view) showPart(kept.view.map((length) => length * S / kept.scale));
  setSpeed(kept.speed);
  seek(kept.time);
  if (kept.playing) play();
  else pause();
}
