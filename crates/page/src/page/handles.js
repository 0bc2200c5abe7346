// @ts-check
// Arrows whose force follows an input can be dragged by their tips, while the mechanism runs or stands.
import { round } from "./common.js";
import { $, MODEL, place, VARIABLES } from "./data.js";
import { add, element, minus, spot, takePose } from "./figure.js";
import { forces, layers, scales } from "./marks.js";
import { askAgain, inScene, knobs, turn } from "./controls.js";
import { state } from "./main.js";
/** Each: where the force acts, its columns, and what one unit of each input adds to it [N]. */
let handles = [];

/** Asks the solver how the forces at the start answer to the inputs. */
export function makeHandles() {
  const inputs = knobs.filter((knob) => knob.isInput);
  if (!inputs.length) return;
  const at = [0, 0],
    shown = state.run,
    forcesWith = (values) => {
      state.run = state.solver.start(values, MODEL.recorded);
      takePose(state.run, at);
      return state.run.last < 0 ? null : forces.map((source) => source.force(at));
    };
  const before = forcesWith([]),
    answers = inputs.map((knob) => {
      // Within its bounds, and large against the rounding of the force.
      const by = knob.high - knob.start > knob.start - knob.low ? knob.high - knob.start : knob.low - knob.start;
      const after = before && by !== 0 && forcesWith([[knob.name, knob.start + by]]);
      return { knob, gains: after ? forces.map((_, k) => minus(after[k], before[k]).map((value) => value / by)) : null };
    });
  state.run = shown;
  takePose(shown, at);
  handles = forces.flatMap((source, k) => {
    const known = answers.filter(({ gains }) => gains && Math.hypot(...gains[k]) * 1e9 > Math.hypot(...before[k]) && Math.hypot(...gains[k]) > 0);
    return source.load && known.length ? [handle(source, known.map(({ knob, gains }) => ({ knob, gain: gains[k] })))] : [];
  });
}

function handle(source, inputs) {
  const grip = element("circle", { class: "grip" }, $("grips")), made = { source, inputs, grip };
  element("title", {}, grip, `Drag: ${inputs.map(({ knob }) => VARIABLES[knob.index].name).join(", ")}, a force on ${source.on}`);
  for (const { knob } of inputs) if (!knob.label.textContent.includes(" on ")) knob.label.textContent += `, on ${source.on}`;
  let held = null;
  grip.addEventListener("pointerdown", (event) => {
    event.stopPropagation();
    held = event.pointerId;
    grip.setPointerCapture(held);
  });
  grip.addEventListener("pointermove", (event) => {
    if (event.pointerId === held) pull(made, inScene(event));
  });
  for (const name of ["pointerup", "pointercancel"]) {
    grip.addEventListener(name, () => {
      held = null;
    });
  }
  return made;
}

/** The inputs that bring the tip of the arrow next to that place. */
function pull({ source, inputs }, { x, y }) {
  const at = place(state.run, state.time);
  takePose(state.run, at);
  const [u, v] = spot(source.anchor), wanted = [(x - u) / scales.newton, (v - y) / scales.newton], missing = minus(wanted, source.force(at));
  for (const [knob, by] of least(inputs, missing)) {
    const { min, max } = VARIABLES[knob.index];
    turn(knob, Math.min(Math.max((knob.solved ?? knob.start) + by, min ?? -Infinity), max ?? Infinity));
    knob.show();
  }
  askAgain();
}

/** Changes of one input, or of two that push in different directions, that add this force as far as they can: least squares. */
/** @type {(inputs: any[], wanted: number[]) => any[]} */
function least(inputs, [fx, fy]) {
  const size = ({ gain }) => Math.hypot(...gain), [a, ...others] = [...inputs].sort((one, other) => size(other) - size(one));
  const across = ({ gain: [x, y] }) => a.gain[0] * y - a.gain[1] * x, b = others.sort((one, other) => Math.abs(across(other)) - Math.abs(across(one)))[0];
  const area = b ? across(b) : 0;
  if (Math.abs(area) > 1e-6 * size(a) * (b ? size(b) : 0)) {
    return [[a.knob, (fx * b.gain[1] - fy * b.gain[0]) / area], [b.knob, (a.gain[0] * fy - a.gain[1] * fx) / area]];
  }
  return [[a.knob, (fx * a.gain[0] + fy * a.gain[1]) / size(a) ** 2]];
}

/** What the inputs can do to the arrows: a scale where no force acts in the first run. */
export const reach = () =>
  Math.max(0, ...handles.flatMap(({ inputs }) => inputs.map(({ knob, gain }) => Math.hypot(...gain) * Math.max(Math.abs(knob.low), Math.abs(knob.high)))));

export function paintHandles(at) {
  for (const { source, grip } of handles) {
    const [fx, fy] = source.force(at), [x, y] = add(spot(source.anchor), scales.newton, [fx, -fy]);
    grip.classList.toggle("hide", !layers.forces || !Number.isFinite(x + y));
    if (Number.isFinite(x + y)) grip.setAttribute("transform", `translate(${round(x)} ${round(y)})`);
  }
}
