// @ts-check
// Curves over time with one cursor, and one over another.
import { round } from "./common.js";
import { $, between, css, INDEX, MODEL, place, pretty, shown, START, STOP, three, VARIABLES } from "./data.js";
import { element, line } from "./figure.js";
import { pause, seek } from "./controls.js";
import { state } from "./main.js";
/** Told apart also by those who see two colours: the first four best. */
const COLOURS = ["--e0", "--e1", "--e2", "--e3", "--e4", "--e5"];
export const plots = [], FONT = getComputedStyle(document.body).fontFamily;
let hovered = null;

/** What is measured in a unit. */
const MEASURED = {
  rad: "Angle",
  "rad/s": "Angular velocity",
  "rad/s2": "Angular acceleration",
  m: "Position",
  "m/s": "Velocity",
  "m/s2": "Acceleration",
  N: "Force",
  "N.m": "Torque",
  J: "Energy",
  W: "Power",
};
/** An angle that goes round and round hides the others beside it. */
const spins = (name) => {
  const { columns, last } = state.first, column = columns.get(name)?.subarray(0, last + 1);
  return VARIABLES[INDEX.get(name)].unit === "rad" && column !== undefined &&
    column.reduce((a, b) => Math.max(a, b), -Infinity) - column.reduce((a, b) => Math.min(a, b), Infinity) > 4 * Math.PI;
};

/** Reported variables by their unit, at most three plots of four curves; those that say least come last. */
export function firstPlots() {
  const groups = new Map();
  for (const name of MODEL.outputs) {
    const variable = VARIABLES[INDEX.get(name)], key = shown(variable).name;
    if (name.startsWith("constraint.")) continue;
    groups.set(key, [...(groups.get(key) ?? []), name]);
  }
  const lists = [...groups.values()].map((list) => [...list.filter((name) => !spins(name)), ...list.filter(spins)]).sort((a, b) =>
    Number(spins(a.at(-1))) - Number(spins(b.at(-1)))
  );
  for (const list of lists.slice(0, 3)) addPlot(list.slice(0, 4));
}

export function addPlot(list) {
  const plot = { names: list, across: null }, unit = shown(VARIABLES[INDEX.get(list[0])]);
  plot.box = document.createElement("div");
  plot.box.className = "plot";
  const head = document.createElement("div"), legend = document.createElement("div");
  head.className = list.length > 2 ? "plot-head many" : "plot-head";
  legend.className = "legend";
  const title = document.createElement("span");
  title.append(MEASURED[VARIABLES[INDEX.get(list[0])].unit] ?? "", " ", document.createElement("em"));
  title.lastChild.textContent = pretty(unit.name);
  plot.values = list.map((name, k) => {
    const item = document.createElement("span"), mark = document.createElement("i"), value = document.createElement("b");
    item.style.setProperty("--c", `var(${COLOURS[k % COLOURS.length]})`);
    item.append(mark, name, value);
    item.title = VARIABLES[INDEX.get(name)].text;
    legend.append(item);
    return value;
  });
  const close = document.createElement("button");
  close.type = "button";
  close.className = "link";
  close.textContent = "×";
  close.setAttribute("aria-label", `Close the plot of ${list.join(", ")}`);
  close.addEventListener("click", () => {
    plots.splice(plots.indexOf(plot), 1);
    plot.box.remove();
  });
  head.append(title, legend, close);
  plot.host = document.createElement("div");
  plot.host.className = "canvas";
  plot.box.append(head, plot.host);
  $("plots").append(plot.box);
  plot.factor = unit.factor;
  plot.chart = chart(plot);
  new ResizeObserver(() => requestAnimationFrame(() => fitPlot(plot))).observe(plot.host);
  plots.push(plot);
  return plot;
}

/** @type {(plot: any) => void} */
export function fitPlot({ host, chart }) {
  const { width, height } = host.getBoundingClientRect();
  if (width > 40 && height > 40) chart.setSize({ width: Math.floor(width), height: Math.floor(height) });
  paintHeads();
}

function chart(plot) {
  const axis = { stroke: () => css("--muted"), font: `11px ${FONT}`, ticks: { show: false }, grid: { stroke: () => css("--grid"), width: 1 } };
  const series = (dashed) =>
    plot.names.map((_, k) => ({
      stroke: () => css(COLOURS[k % COLOURS.length]) + (dashed ? "77" : ""),
      width: dashed ? 1.25 : 1.75,
      dash: dashed ? [4, 4] : [],
      show: !dashed,
      pxAlign: 0,
      points: { show: false },
    }));
  const made = new uPlot(
    {
      width: 300,
      height: 120,
      legend: { show: false },
      padding: [6, 12, 0, 0],
      cursor: { sync: { key: "time" }, drag: { x: false, y: false }, y: false, points: { size: 6 } },
      scales: { x: { time: false, range: [START, STOP > START ? STOP : START + 1] }, y: { range: (_, low, high) => margin(low, high) } },
      axes: [{ ...axis, size: 24, gap: 4, values: (_, ticks) => ticks.map((v) => `${+v.toFixed(6)}`) }, {
        ...axis,
        size: 52,
        gap: 6,
        space: 26,
        values: (_, ticks) => ticks.map((v) => `${+v.toPrecision(6)}`.replace("-", "−")),
      }],
      series: [{}, ...series(false), ...series(true)],
      hooks: {
        drawAxes: [zeroLine],
        setCursor: [(u) => {
          hovered = u.cursor.left >= 0 && u.cursor.idx != null ? u.cursor.idx : null;
          paintLegends();
        }],
      },
    },
    [[START], ...plot.names.flatMap(() => [[null], [null]])],
    plot.host,
  );
  plot.head = document.createElement("div");
  plot.head.className = "playhead";
  made.over.append(plot.head);
  const seekTo = (event) => {
    pause();
    seek(made.posToVal(event.clientX - made.over.getBoundingClientRect().left, "x"));
  };
  made.over.addEventListener("pointerdown", (event) => {
    if (event.button === 0) {
      made.over.setPointerCapture(event.pointerId);
      seekTo(event);
    }
  });
  made.over.addEventListener("pointermove", (event) => {
    if (made.over.hasPointerCapture(event.pointerId)) seekTo(event);
  });
  return made;
}

/** Room above and below; a constant gets room as well. */
function margin(low, high) {
  if (low === null || !Number.isFinite(low)) return [-1, 1];
  const size = high - low > 1e-9 * Math.max(Math.abs(low), Math.abs(high)) ? high - low : Math.abs(high) || 1;
  return [low - .06 * size, high + .06 * size];
}

function zeroLine(u) {
  const y = u.valToPos(0, "y", true), { left, top, width, height } = u.bbox;
  if (!(y > top && y < top + height)) return;
  u.ctx.save();
  u.ctx.strokeStyle = css("--zero");
  u.ctx.lineWidth = devicePixelRatio;
  u.ctx.beginPath();
  u.ctx.moveTo(left, y);
  u.ctx.lineTo(left + width, y);
  u.ctx.stroke();
  u.ctx.restore();
}

/** Values of a run at times in the unit of the plot; what was not reached is no value. A run that follows a drag has fewer times than the others. */
function values(run, name, factor, times) {
  const column = run.columns.get(name), end = run.times[Math.max(run.last, 0)];
  const value = times.length === run.times.length ? (k) => column[k] : (k) => between(column, place(run, times[k]));
  return Array.from(times, (time, k) => {
    const own = column && time <= end ? value(k) : NaN;
    return Number.isFinite(own) ? own / factor : null;
  });
}

export function renewPlots() {
  const { run, first } = state, changed = run !== first;
  for (const plot of plots) {
    const count = plot.names.length;
    plot.chart.batch(() => {
      plot.chart.setData([
        Array.from(run.times),
        ...plot.names.map((name) => values(run, name, plot.factor, run.times)),
        ...plot.names.map((name) => values(first, name, plot.factor, run.times)),
      ]);
      for (let k = 0; k < count; k++) plot.chart.setSeries(count + 1 + k, { show: changed });
    });
  }
  renewAcross();
  paintHeads();
}

export function paintHeads() {
  for (const { chart, head } of plots) head.style.transform = `translateX(${round(chart.valToPos(state.time, "x"))}px)`;
}

/** At the pointer, else at the playhead, read as the arrows are. */
export function paintLegends() {
  const at = hovered === null ? place(state.run, state.time) : [Math.min(hovered, state.run.last), 0];
  for (const { names, values, factor } of plots) {
    names.forEach((name, k) => {
      const column = state.run.columns.get(name), told = column ? three(between(column, at) / factor) : "–";
      if (values[k].textContent !== told) values[k].textContent = told;
    });
  }
}

/** The last plot's first variable over another than time. */
const across = { box: null, path: null, dot: null, x: null, y: null, view: null };
export function chooseAcross(x) {
  across.box?.remove();
  across.box = null;
  if (!x || !plots.length) return;
  across.x = x;
  across.y = plots.at(-1).names[0];
  across.box = document.createElement("div");
  across.box.className = "plot";
  across.box.innerHTML = '<div class="plot-head"><span></span></div><div class="canvas"><svg preserveAspectRatio="none" viewBox="0 0 1000 1000"></svg></div>';
  across.box.querySelector("span").textContent = `${across.y} over ${across.x}`;
  const svg = across.box.querySelector("svg");
  across.path = element("path", { class: "path tail" }, svg);
  across.dot = element("path", { class: "path tail", "stroke-width": 9, "stroke-linecap": "round", style: "stroke:var(--text)" }, svg);
  $("plots").append(across.box);
  renewAcross();
}
function renewAcross() {
  if (!across.box) return;
  const { run } = state, [xs, ys] = [across.x, across.y].map((name) => run.columns.get(name).subarray(0, run.last + 1));
  const range = (list) => margin(list.reduce((a, b) => Math.min(a, b), Infinity), list.reduce((a, b) => Math.max(a, b), -Infinity));
  const [[x0, x1], [y0, y1]] = [range(xs), range(ys)];
  across.view = (x, y) => [1000 * (x - x0) / (x1 - x0), 1000 * (y1 - y) / (y1 - y0)];
  across.path.setAttribute("d", line(Array.from(xs, (x, k) => across.view(x, ys[k]))));
  paintAcross(place(run, state.time));
}
export function paintAcross(at) {
  if (!across.box) return;
  const here = across.view(...[across.x, across.y].map((name) => between(state.run.columns.get(name), at)));
  across.dot.setAttribute("d", `${line([here])}l0 0`);
}
