// @ts-check
// What the page carries: the model, a stored run or the solver with its program; and how values between samples are read.

/** Elements that are painted on a canvas lie here. */
export const shelf = document.createDocumentFragment();
/** @type {(id: string) => any} */
export const $ = (id) => document.getElementById(id) ?? shelf.getElementById(id);
export const MODEL = JSON.parse($("model").textContent);
export const G = MODEL.geometry;
export const VARIABLES = MODEL.variables;
export const INDEX = new Map(VARIABLES.map((variable, index) => [variable.name, index]));
export const { start: START, stop: STOP, step: STEP, tolerance: TOLERANCE } = MODEL.experiment;

/** The run that was stored when the page was made: times with 64 bits, lowest bytes first, then the columns with 32, by third differences as `pack.rs` writes them. */
export function storedRun(bytes) {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  const names = MODEL.stored, count = view.byteLength / (8 + 4 * names.length);
  const all = names.length * count;
  const byte = (which, of) => view.getUint8(8 * count + which * all + of);
  const column = (place) => {
    const bits = Int32Array.from({ length: count }, (_, k) => {
      const of = place * count + k, number = byte(0, of) | byte(1, of) << 8 | byte(2, of) << 16 | byte(3, of) << 24;
      return number >>> 1 ^ -(number & 1);
    });
    for (let order = 0; order < 3; order++) for (let k = 1; k < count; k++) bits[k] += bits[k - 1];
    return Float64Array.from(new Float32Array(bits.buffer));
  };
  const times = Float64Array.from({ length: count }, (_, k) => view.getFloat64(8 * k, true));
  return { times, columns: new Map(names.map((name, k) => [name, column(k)])), last: count - 1, error: MODEL.cut, warning: MODEL.warning };
}

/** Where a time lies between the samples of a run: index and part. */
export function place(run, time) {
  const { times, last } = run;
  if (last <= 0 || time >= times[last]) return [Math.max(last, 0), 0];
  let low = 0, high = last;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (times[middle] <= time) low = middle;
    else high = middle;
  }
  return [low, Math.max(0, (time - times[low]) / (times[low + 1] - times[low]))];
}

/** A smooth variable: a cubic whose slopes are those of its neighbours; between them it is known to third order. */
/** @type {(run: any, column: any, at: number[]) => number} */
export function smooth({ times, last }, column, [k, part]) {
  if (!(part > 0)) return column[k];
  const before = Math.max(k - 1, 0), after = Math.min(k + 2, last), step = times[k + 1] - times[k], value = column[k], rise = column[k + 1] - value;
  const first = step * (column[k + 1] - column[before]) / (times[k + 1] - times[before]), second = step * (column[after] - value) / (times[after] - times[k]);
  return value + part * (first + part * (3 * rise - 2 * first - second + part * (first + second - 2 * rise)));
}
/** A variable that may jump. */
/** @type {(column: any, at: number[]) => number} */
export function between(column, [k, part]) {
  return part > 0 ? column[k] + part * (column[k + 1] - column[k]) : column[k];
}

/** Three digits that matter, as a reader expects them. */
export function three(value) {
  if (!Number.isFinite(value)) return "–";
  value = Number(value.toPrecision(3));
  const size = Math.abs(value);
  if (size < 1e-12) return "0";
  if (size < 1e-3 || size >= 1e5) return value.toExponential(1).replace("-", "−").replace("e−", "e-").replace("e+", "e");
  return value.toFixed(size >= 100 ? 0 : size >= 10 ? 1 : size >= 1 ? 2 : 3).replace("-", "−");
}

/** A unit as it is read: N·m, m/s². */
export const pretty = (unit) => unit.replaceAll(".", "·").replace(/2(?![0-9])/g, "²").replace(/3(?![0-9])/g, "³");
/** The unit that a variable is shown in, and its SI value. */
export const shown = (variable) => variable.display ?? { name: variable.unit, factor: 1 };
/** The units of the scene's `[display]`, by the SI units in whose place they stand. */
export const UNITS = new Map(Object.entries(MODEL.units));
/** What the solver says, in the scene's units: its numbers are SI. */
export function inUnits(text) {
  return text.replace(/(-?\d+(?:\.\d+)?(?:e[-+]?\d+)?) (N\.m|[A-Za-z]+(?:\/s2?)?)(?![A-Za-z0-9])/g, (whole, number, si) => {
    const unit = UNITS.get(si);
    return unit ? `${+(number / unit.factor).toPrecision(6)} ${pretty(unit.name)}` : whole;
  });
}
/** A force with three digits. */
export function newtons(value) {
  const unit = UNITS.get("N") ?? (Math.abs(value) >= 1e3 ? { name: "kN", factor: 1e3 } : { name: "N", factor: 1 });
  return `${three(value / unit.factor)}\u202f${pretty(unit.name)}`;
}
export const css = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
