// @ts-check
// The text is the source of truth: every action is an edit of it, what it says is drawn, and the page in the frame shows how it moves.
import { all, bytesOf, changeTheme, pngOf, save, SVG, svgElement, targetOf, textOf, Undo, unpack } from "../common.js";
import { front } from "./front.js";
import { $, called, far, fit, gridStep, met, metre, minus, onGrid, paint, path, pixel, plus, points, size, view, zoom } from "./stage.js";
import { moved, Plan, tool, TOOLS } from "./tools.js";
import { chooseWish, clearWish, dragWish, find, forgetWish, paintWish, pressWish, showTrade, takeTrade, taskText, wish } from "./find.js";
export const drawing = { text: "", shown: null, sketch: null, stale: false, fits: true, asking: null, waits: false, editing: 0, faults: [], saved: null };
const undo = new Undo([]);
/** How long the text must rest before what is typed is one step of the undo list [ms]. */
const REST = 500;
const EMPTY = `format  = 1\nname    = "drawing"\ngravity = [0, -9.81]\n`;

export const say = (text) => {
  $("said").textContent = text;
};

/** Takes a text: draws it, lets it move, and makes it a step that can be undone. */
export function edit(text, what) {
  put(text);
  commit();
  if (what) say(what);
}
/** The text as it is now, drawn; no step of its own. */
function put(text) {
  drawing.text = text;
  if ($("text").value !== text) $("text").value = text;
  return look();
}
function commit() {
  if (undo.present() === drawing.text) return;
  undo.take(drawing.text);
  keepDraft();
  undo.show();
  renewMotion();
  dispatchEvent(new CustomEvent("cotree-text"));
}
function goBack(by) {
  if (undo.present() !== drawing.text) commit();
  const text = undo.go(by);
  if (text === undefined) return;
  put(text);
  keepDraft();
  undo.show();
  renewMotion();
  say(by < 0 ? "undone" : "redone");
  dispatchEvent(new CustomEvent("cotree-text"));
}
/** The draft outlives the page: it is kept in the browser, for this very page and what it begins with. */
const DRAFT = `cotree-draft:${location.pathname}`;
function keepDraft() {
  try {
    localStorage.setItem(DRAFT, JSON.stringify({ begin: $("begin").textContent, text: drawing.text }));
  } catch { /* a frame of another site keeps nothing */ }
}
function keptDraft() {
  try {
    const kept = JSON.parse(localStorage.getItem(DRAFT));
    return kept?.begin === $("begin").textContent ? kept.text : null;
  } catch {
    return null;
  }
}
/** Leaving asks if something is in no file. */
addEventListener("beforeunload", (event) => {
  if (drawing.saved !== null && drawing.text !== drawing.saved) event.preventDefault();
});

/** Asks what the text says; while one question is open only the last of the others waits. */
function look() {
  if (drawing.asking) {
    drawing.waits = true;
    return drawing.asking;
  }
  const ask = async () => {
    do {
      drawing.waits = false;
      const { text } = drawing;
      show(text, await front.json("front_look", text));
    } while (drawing.waits);
    drawing.asking = null;
  };
  drawing.asking = ask();
  return drawing.asking;
}
function show(text, answer) {
  drawing.shown = text;
  drawing.stale = !answer.good && !answer.sketch;
  if (answer.sketch) drawing.sketch = answer.sketch;
  drawing.good = answer.good ?? false;
  showFaults(answer.faults ?? answer);
  const name = answer.name || "drawing";
  document.title = `${name} - cotree`;
  $("name").textContent = name;
  const { sketch } = drawing, bodies = sketch?.geometry?.bodies.length ?? 0;
  $("count").textContent = sketch ? `${bodies} ${bodies === 1 ? "body" : "bodies"}, mobility ${sketch.mobility}` : "";
  // Whoever draws keeps his place; what is opened is seen whole.
  if (drawing.fits && answer.good) {
    drawing.fits = false;
    fit();
  } else paint();
}
/** Errors and warnings, each with its line in the text. */
function showFaults({ faults, omitted = 0 }) {
  drawing.faults = faults;
  $("faults").replaceChildren(
    ...faults.map(({ severity, message, help, label, place: at }) => {
      const item = document.createElement("li"), button = Object.assign(document.createElement("button"), { type: "button", disabled: !at });
      // A drawing without bodies is no mistake: it has just begun.
      const isStart = faults.some(({ code }) => code === "scene::no_bodies");
      item.className = severity === "error" && !isStart ? "error" : "warning";
      button.append(
        Object.assign(document.createElement("b"), { textContent: at ? `line ${at.line}` : severity }),
        ` ${isStart && severity === "error" ? "nothing is drawn yet: choose Bar, and draw from one end to the other" : message}`,
      );
      if (label && at) button.append(Object.assign(document.createElement("i"), { textContent: ` (${label})` }));
      if (help && !isStart) button.append(Object.assign(document.createElement("span"), { textContent: help }));
      button.addEventListener("click", () => choosePlace(at));
      item.append(button);
      return item;
    }),
    ...(omitted ? [Object.assign(document.createElement("li"), { textContent: `and ${omitted} more` })] : []),
  );
}
/** Selects bytes of the text. */
function choosePlace({ start, end, line }) {
  const bytes = bytesOf(drawing.text), [from, to] = [start, end].map((byte) => textOf(bytes.subarray(0, byte)).length), area = $("text");
  area.focus();
  area.setSelectionRange(from, to);
  area.scrollTop = Math.max(0, (line - 4) * parseFloat(getComputedStyle(area).lineHeight));
}

/** The page in which the mechanism moves: the next one is made behind the present one, and takes over where that stands. */
const motion = { turn: 0, frame: null };
async function renewMotion() {
  const turn = ++motion.turn, { text } = drawing;
  await new Promise((done) => setTimeout(done, 60));
  if (turn !== motion.turn) return;
  const { failed, bytes } = await front.ask("front_page", text);
  if (turn !== motion.turn) return;
  $("motion").classList.toggle("old", failed);
  $("motion-told").textContent = failed ? motion.frame ? "The motion of the last text without errors." : "The motion appears when the text has no errors." : "";
  if (failed) return;
  const frame = Object.assign(document.createElement("iframe"), { title: "The mechanism in motion", srcdoc: textOf(bytes), className: "next" });
  $("motion").append(frame);
  await new Promise((done) => {
    const wait = () => !frame.isConnected || frame.contentDocument?.documentElement?.dataset.ready ? done() : setTimeout(wait, 20);
    frame.addEventListener("load", wait);
  });
  if (turn !== motion.turn) {
    frame.remove();
    return;
  }
  takeMotion(frame);
}
function takeMotion(frame) {
  const { contentWindow: page, contentDocument: inner } = frame, before = motion.frame?.contentWindow?.cotree;
  if (before && page.cotree && inner.documentElement.dataset.ready === "yes") page.cotree.restore({ ...before.keep(), values: [], pose: null });
  const { theme } = document.documentElement.dataset;
  if (theme) inner.documentElement.dataset.theme = theme;
  motion.frame?.remove();
  frame.className = "";
  motion.frame = frame;
  page.addEventListener("cotree-changed", () => {
    $("adopt").hidden = page.cotree.sceneText() === drawing.text;
  });
  $("adopt").hidden = true;
  document.documentElement.dataset.moving = undo.present() ?? "";
}
/** What was pulled and changed in the moving page becomes the text. */
function adoptMotion() {
  try {
    edit(motion.frame.contentWindow.cotree.sceneText(), "taken into the text");
  } catch (fault) {
    say(fault.message);
  }
}

export function choose(name) {
  Object.assign(tool, { name, first: null, typed: "", grabbed: null });
  for (const button of all("[data-tool]")) button.setAttribute("aria-checked", `${button.dataset.tool === name}`);
  say(TOOLS[name].hint);
  if (name !== "move" && wish.kind) chooseWish(wish.kind);
  $("board").dataset.tool = name;
  paint();
}
/** Does what the tool does with one place, or with a second one. */
async function act(at, target) {
  const own = TOOLS[tool.name];
  if (drawing.editing || drawing.shown !== drawing.text || drawing.stale) {
    say("the text has errors: correct them before you draw");
    return;
  }
  if (drawing.sketch?.line) {
    say("this is a mechanism on a line: change it in the text");
    return;
  }
  if (own.count === 2 && !tool.first) {
    tool.first = at;
    say(`from ${called(at)}: where to?`);
    paint();
    return;
  }
  const plan = new Plan(drawing.text), first = tool.first ?? at;
  Object.assign(tool, { first: null, typed: "" });
  drawing.editing++;
  try {
    own.act(plan, first, at, target);
    const text = await front.edited(plan.text, plan.edits);
    drawing.fits = false;
    edit(text, `${own.say} done`);
  } catch (fault) {
    say(fault.message);
    paint();
  }
  drawing.editing--;
}
/** What is typed while a second place is asked for: a length [mm], and after `<` an angle [deg]; without one the way to the pointer is kept. */
function typedPlace() {
  const found = tool.typed.match(/^(\d+(?:\.\d*)?|\.\d+)(?:<(-?\d+(?:\.\d*)?))?$/);
  if (!found) return null;
  const way = minus(tool.met?.at ?? tool.first.at, tool.first.at), angle = found[2] === undefined ? Math.atan2(way[1], way[0]) : +found[2] * Math.PI / 180;
  return plus(tool.first.at, [Math.cos(angle), Math.sin(angle)].map((part) => part * +found[1] / 1e3));
}
/** Takes a key as a part of that; false if it is none. */
function typeKey(key) {
  if (!tool.first || TOOLS[tool.name].count !== 2) return false;
  if (/^[\d.<]$/.test(key) || key === "-" && tool.typed.endsWith("<")) tool.typed += key;
  else if (key === "Backspace" && tool.typed) tool.typed = tool.typed.slice(0, -1);
  else if (key === "Enter" && tool.typed) {
    const at = typedPlace();
    if (!at) {
      say(`${tool.typed} is not a length in mm, such as 120, or 120<45 with an angle in degrees`);
      tool.typed = "";
      paint();
      return true;
    }
    act({ ...met(at, 1), at }, null);
    return true;
  } else return false;
  say(`${tool.typed} mm: Enter draws it`);
  paint();
  return true;
}
/** A point is taken up, moved and let go. */
function grab(at) {
  if (at.kind !== "point") return false;
  if (drawing.stale || drawing.shown !== drawing.text) {
    say("the text has errors: correct them first");
    return false;
  }
  tool.grabbed = { point: at, text: drawing.text, sketch: drawing.sketch };
  say(`${called(at)} taken`);
  return true;
}
/** Carries it to a place; of the places that come while the text is being changed only the last counts. */
function carry(to) {
  const own = tool.grabbed;
  own.to = to;
  own.carried ??= (async () => {
    drawing.editing++;
    while (own.to) {
      const now = drawing.sketch, place = own.to;
      own.to = null;
      drawing.sketch = own.sketch;
      try {
        let edits;
        try {
          edits = moved(own.point, place);
        } finally {
          drawing.sketch = now;
        }
        const text = await front.edited(own.text, edits);
        own.failed = null;
        if (!own.isBack) put(text);
      } catch (fault) {
        own.failed = fault.message;
        say(fault.message);
      }
    }
    own.carried = null;
    drawing.editing--;
  })();
}
function letGo(isKept) {
  const own = tool.grabbed, { text, point } = own;
  tool.grabbed = null;
  own.isBack = !isKept;
  const end = () => {
    if (isKept && !own.failed) {
      commit();
      say(`${point.owner}.${point.name} moved`);
      return;
    }
    put(text);
    tool.met = point;
    if (!own.failed) say("put back");
  };
  if (own.carried) own.carried.then(end);
  else end();
}

export function paintTool(group) {
  paintWish(group);
  const { first, met: at } = tool;
  if (first && at) svgElement("path", { d: path([pixel(first.at), pixel(at.at)]), class: "going" }, group);
  for (const own of [first, tool.name !== "move" || tool.keys ? at : at?.kind === "point" ? at : null]) {
    if (!own) continue;
    const [cx, cy] = pixel(own.at);
    svgElement("circle", { cx, cy, r: own.kind === "point" ? 11 : 5, class: `snap ${own.kind}` }, group);
  }
  if (first && at) {
    const way = minus(at.at, first.at),
      measured = `${+(1e3 * Math.hypot(...way)).toPrecision(4)} mm, ${+(Math.atan2(way[1], way[0]) * 180 / Math.PI).toFixed(1)}\u00b0`;
    svgElement(
      "text",
      { x: pixel(at.at)[0] + 14, y: pixel(at.at)[1] - 14, class: "size" },
      group,
      tool.typed ? `${tool.typed.replace("<", " mm, ")}${tool.typed.includes("<") ? "\u00b0" : " mm"}` : measured,
    );
  }
}

const touches = new Map();
function listenToBoard() {
  const board = $("board"),
    where = (event) => {
      const { left, top } = board.getBoundingClientRect();
      return [event.clientX - left, event.clientY - top];
    };
  const reach = (event) => event.pointerType === "touch" ? 22 : 14;
  let down = null;
  board.addEventListener("pointerdown", (event) => {
    // Buttons lie over the sheet: what is pressed there is no place of it.
    if (event.button || targetOf(event).closest("button")) return;
    try {
      board.setPointerCapture(event.pointerId);
    } catch { /* a pointer of a test */ }
    touches.set(event.pointerId, where(event));
    tool.keys = false;
    if (touches.size === 2) {
      if (tool.grabbed) letGo(false);
      tool.first = down = null;
      return;
    }
    const at = metre(where(event)), found = met(at, reach(event));
    down = {
      at: where(event),
      found,
      target: document.elementFromPoint(event.clientX, event.clientY),
      view: { ...view },
      moved: false,
      pans: false,
      began: false,
    };
    if (wish.kind && pressWish(at, where(event))) return;
    if (tool.name === "move") {
      if (!grab(found)) down.pans = true;
      return;
    }
    if (TOOLS[tool.name].count === 2 && !tool.first) {
      act(found, down.target);
      down.began = true;
    }
  });
  board.addEventListener("pointermove", (event) => {
    const now = where(event), before = touches.get(event.pointerId);
    if (touches.size === 2 && before) {
      const [a, b] = [...touches.values()], other = before === a ? b : a, by = far(now, other) / (far(before, other) || 1);
      touches.set(event.pointerId, now);
      view.x -= (now[0] - before[0]) / 2 / view.scale;
      view.y += (now[1] - before[1]) / 2 / view.scale;
      zoom(by, other);
      return;
    }
    if (before) touches.set(event.pointerId, now);
    if (down && far(now, down.at) > 6) down.moved = true;
    if (wish.held) {
      dragWish(metre(now));
      return;
    }
    tool.met = met(metre(now), reach(event));
    if (tool.grabbed && down?.moved) carry(free(metre(now)));
    else if (down?.pans && down.moved) {
      Object.assign(view, { x: down.view.x - (now[0] - down.at[0]) / down.view.scale, y: down.view.y + (now[1] - down.at[1]) / down.view.scale });
      paint();
    } else paint();
  });
  const up = (event) => {
    const now = where(event), was = down;
    touches.delete(event.pointerId);
    down = null;
    if (wish.held) {
      wish.held = null;
      paint();
      return;
    }
    if (!was) return;
    if (tool.grabbed) {
      letGo(was.moved && event.type === "pointerup");
      return;
    }
    if (tool.name === "move" || event.type !== "pointerup") return;
    if (was.began) { if (was.moved) act(met(metre(now), reach(event)), was.target); }
    else act(met(metre(now), reach(event)), was.target);
  };
  board.addEventListener("pointerup", up);
  board.addEventListener("pointercancel", up);
  board.addEventListener("wheel", (event) => {
    event.preventDefault();
    zoom(Math.exp(-event.deltaY / 400), where(event));
  }, { passive: false });
}
/** A free place, on the grid if that is wanted; or the point that is there, so that the two lie together. */
function free(at) {
  const { point } = tool.grabbed,
    other = points().find((own) => far(own.at, at) * view.scale < 10 && far(own.at, point.at) * view.scale > 12 && own.owner !== point.owner);
  return other ? other.at : $("snap").getAttribute("aria-pressed") === "true" ? onGrid(at) : at.map((value) => +value.toPrecision(6));
}

/** The drawing by keys: a cross that the arrows move. */
function listenToKeys() {
  const ways = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
  $("board").addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const { key } = event, way = ways[key];
    if (typeKey(key)) { /* a length is typed */ }
    else if (way) {
      const step = gridStep() * (event.shiftKey ? 5 : 1), from = tool.met?.at ?? onGrid([view.x, view.y]);
      showCursor(onGrid(plus(from, way.map((value) => value * step))));
    } else if (key === "n" || key === "N") {
      const all = points(),
        k = all.findIndex((own) => own.owner === tool.met?.owner && own.name === tool.met?.name),
        next = all[(k + (key === "n" ? 1 : all.length - 1)) % all.length];
      if (next) {
        tool.keys = true;
        tool.met = { kind: "point", ...next };
        say(called(tool.met));
        paint();
      }
    } else if (key === "Enter" || key === " ") {
      const at = tool.met ?? met(onGrid([view.x, view.y]));
      if (tool.grabbed) letGo(true);
      else if (tool.name === "move") grab(at);
      else act(at, null);
    } else if (key === "Escape") {
      if (tool.grabbed) letGo(false);
      tool.first = null;
      if (wish.kind) chooseWish(wish.kind);
      paint();
    } else if (key === "+" || key === "-") zoom(key === "+" ? 1.25 : .8);
    else if (key === "0") fit();
    else {
      const found = Object.entries(TOOLS).find(([, own]) => own.key === key);
      if (!found) return;
      choose(found[0]);
    }
    event.preventDefault();
  });
  addEventListener("keydown", (event) => {
    const key = event.key.toLowerCase();
    if (!(event.ctrlKey || event.metaKey) || event.altKey || !"zy".includes(key)) return;
    event.preventDefault();
    goBack(key === "y" || event.shiftKey ? 1 : -1);
  });
}
function showCursor(at) {
  tool.keys = true;
  tool.met = met(at, 6);
  if (tool.grabbed) carry(at);
  else paint();
  say(called(tool.met));
}

/** The FMU, in the versions and for the platforms that the command would write. */
async function exportFmu(version) {
  say("making the FMU\u2026");
  const { failed, bytes } = await front.ask("front_fmu", drawing.text, { argument: version });
  if (failed) {
    const { faults } = JSON.parse(textOf(bytes));
    showFaults({ faults });
    say("no FMU: the text has errors");
    return null;
  }
  const name = `${$("name").textContent.replace(/[^A-Za-z0-9_]/g, "_").replace(/^(?=\d)/, "_")}.fmu`;
  say(`${name}: ${Math.round(bytes.length / 1e3)} kB`);
  return { name, bytes };
}
/** The text in the address, packed. */
async function shareAddress() {
  const stream = new Blob([drawing.text]).stream().pipeThrough(new CompressionStream("deflate")),
    bytes = new Uint8Array(await new Response(stream).arrayBuffer());
  return `${location.href.split("#")[0]}#scene=${btoa(String.fromCharCode(...bytes)).replaceAll("+", "-").replaceAll("/", "_").replace(/=+$/, "")}`;
}
async function sharedText() {
  const packed = new URLSearchParams(location.hash.slice(1)).get("scene");
  if (!packed) return null;
  try {
    const bytes = Uint8Array.from(atob(packed.replaceAll("-", "+").replaceAll("_", "/")), (letter) => letter.charCodeAt(0));
    return await new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"))).text();
  } catch {
    say("the address of this page is truncated: its scene cannot be read");
    return null;
  }
}

const fileName = () => $("name").textContent.replace(/[^\w.-]+/g, "_");
/** The sheet as it is seen, without the grid and the tool, each part with its own style. */
function sheetSvg() {
  const [width, height] = size(),
    shown = $("picture"),
    copy = shown.cloneNode(true),
    parts = copy.querySelectorAll("*"),
    KEPT = ["fill", "stroke", "stroke-width", "stroke-linecap", "stroke-linejoin", "stroke-dasharray", "opacity", "font", "text-anchor", "paint-order"];
  shown.querySelectorAll("*").forEach((own, k) => {
    const style = getComputedStyle(own);
    parts[k].removeAttribute("class");
    parts[k].setAttribute("style", KEPT.map((name) => `${name}:${style.getPropertyValue(name)}`).join(";"));
  });
  [...copy.children].filter((_, k, all) => k === 1 || k === all.length - 1).forEach((part) => part.remove());
  for (const [name, value] of Object.entries({ xmlns: SVG, width, height, viewBox: `0 0 ${width} ${height}` })) copy.setAttribute(name, value);
  copy.insertBefore(svgElement("rect", { width, height, fill: getComputedStyle($("board")).backgroundColor }), copy.firstChild);
  return new XMLSerializer().serializeToString(copy);
}
const sheetPng = () => pngOf(sheetSvg(), size());

const SAVES = {
  fmu2: async () => {
    const fmu = await exportFmu(2);
    if (fmu) save(fmu.name, new Blob([fmu.bytes]));
  },
  fmu3: async () => {
    const fmu = await exportFmu(3);
    if (fmu) save(fmu.name, new Blob([fmu.bytes]));
  },
  text: () => {
    save(`${fileName()}.toml`, drawing.text);
    drawing.saved = drawing.text;
  },
  svg: () => save(`${fileName()}.svg`, sheetSvg()),
  png: async () => save(`${fileName()}.png`, await sheetPng()),
  link: async () => {
    const address = await shareAddress();
    history.replaceState(null, "", address);
    try {
      await navigator.clipboard.writeText(address);
      say("address copied");
    } catch {
      say("the address of this page now contains the scene");
    }
  },
};
function listenToButtons() {
  for (const [name, { say: text, hint, key }] of Object.entries(TOOLS)) {
    const button = Object.assign(document.createElement("button"), { type: "button", textContent: text, title: `${hint} (${key.toUpperCase()})` });
    button.setAttribute("role", "radio");
    button.dataset.tool = name;
    button.addEventListener("click", () => choose(name));
    $("tools").append(button);
  }
  for (
    const [id, call] of Object.entries({
      undo: () => goBack(-1),
      redo: () => goBack(1),
      adopt: adoptMotion,
      find,
      "clear-wish": clearWish,
      "zoom-in": () => zoom(1.25),
      "zoom-out": () => zoom(.8),
      "zoom-fit": fit,
    })
  ) $(id).addEventListener("click", () => call());
  $("snap").addEventListener("click", () => $("snap").setAttribute("aria-pressed", `${$("snap").getAttribute("aria-pressed") !== "true"}`));
  $("size").addEventListener("input", showTrade);
  $("size").addEventListener("change", takeTrade);
  for (const button of all("[data-wish]")) button.addEventListener("click", () => chooseWish(button.dataset.wish));
  for (const button of all("[data-save]")) {
    button.addEventListener("click", async () => {
      $("save").open = false;
      await SAVES[button.dataset.save]();
    });
  }
  $("theme").addEventListener("click", () => {
    const theme = changeTheme();
    motion.frame?.contentDocument.documentElement.setAttribute("data-theme", theme);
  });
  let rest = 0;
  $("text").addEventListener("input", () => {
    put($("text").value);
    clearTimeout(rest);
    rest = setTimeout(commit, REST);
  });
  $("text").addEventListener("change", () => {
    clearTimeout(rest);
    commit();
  });
  $("open").addEventListener("change", async () => {
    await openFiles([...$("open").files]);
    $("open").value = "";
  });
  const carries = (event) => event.dataTransfer?.types.includes("Files");
  addEventListener("dragover", (event) => {
    if (carries(event)) {
      event.preventDefault();
      document.body.classList.add("dropping");
    }
  });
  for (const name of ["dragleave", "drop"]) {
    addEventListener(name, (event) => {
      if (name === "drop" || !(/** @type {any} */ (event).relatedTarget)) document.body.classList.remove("dropping");
    });
  }
  addEventListener("drop", (event) => {
    if (carries(event)) {
      event.preventDefault();
      openFiles([...event.dataTransfer.files]);
    }
  });
  addEventListener("resize", paint);
}
/** The largest file of another program that is read [bytes]. */
const LARGEST_FILE = 50 * 2 ** 20;
/** Opens a scene, or imports a file of another program: of several files the one that no other names is imported, and the others are what it includes. */
async function openFiles(files) {
  if (!files.length) return;
  if (files.reduce((sum, { size: own }) => sum + own, 0) > LARGEST_FILE) {
    say("the files are larger than 50 MB");
    return;
  }
  if (files.length === 1 && /\.toml$/i.test(files[0].name)) {
    drawing.fits = true;
    forgetWish();
    edit(await files[0].text(), `${files[0].name} opened`);
    return;
  }
  const texts = await Promise.all(files.map((file) => file.text()));
  const first = Math.max(0, files.findIndex(({ name }, k) => !texts.some((text, other) => other !== k && text.includes(name))));
  const parts = await Promise.all(
    [files[first], ...files.filter((_, k) => k !== first)].map(
      async (file) => [bytesOf(`${file.name}\0${file.size}\0`), new Uint8Array(await file.arrayBuffer())],
    ),
  );
  const { failed, bytes } = await front.ask("front_import", new Uint8Array(await new Blob(parts.flat()).arrayBuffer()));
  const answer = JSON.parse(textOf(bytes)), { name } = files[first];
  if (failed) {
    showFaults(answer);
    say(`${name} cannot be imported: the text stays as it is. Files that it includes are opened together with it`);
    return;
  }
  drawing.fits = true;
  forgetWish();
  edit(answer.scene, `${name} imported: ${answer.notes[0] ?? ""}. The head of the text says what is exact, approximated and left out`);
}

async function fillGallery() {
  const models = await front.json("front_gallery", ""), list = $("gallery");
  for (const { name } of models) list.append(new Option(name.replaceAll("_", " "), name));
  list.addEventListener("change", () => {
    const model = models.find(({ name }) => name === list.value);
    drawing.fits = true;
    forgetWish();
    edit(list.value === "new" ? EMPTY : model.text, `${list.selectedOptions[0].text} opened`);
    list.value = "";
  });
}

/** The solver for the frame of the moving page, which takes it from here, and what FMUs carry. A page that is served has both at its server. */
async function takeSolver() {
  const solver = await unpack("solver");
  window.cotreeSolver = await WebAssembly.compile(solver);
  await front.ask("front_take_module", solver, { keep: true });
  for (const script of all("[data-platform]")) {
    const library = await unpack(script.id), name = bytesOf(`${script.dataset.platform}\0`), bytes = new Uint8Array(name.length + library.length);
    bytes.set(name);
    bytes.set(library, name.length);
    await front.ask("front_take_runtime", bytes, { keep: true });
  }
}

async function open() {
  await front.start();
  if (!window.cotreeSolver?.served) await takeSolver();
  listenToButtons();
  listenToBoard();
  listenToKeys();
  await fillGallery();
  const begin = JSON.parse($("begin").textContent) ?? EMPTY, shared = await sharedText(), draft = shared === null ? keptDraft() : null;
  drawing.saved = shared ?? begin;
  await put(draft ?? drawing.saved);
  commit();
  choose("move");
  if (draft !== null && draft !== begin) say("this is your last drawing: an empty one is under “Begin with”");
  document.documentElement.dataset.ready = "yes";
}
open().catch((fault) => {
  say(fault.message);
  document.documentElement.dataset.ready = "no";
});
// For tests, and for whoever wants to look closer in the browser's console.
window.cotreeDraw = {
  sheetSvg,
  sheetPng,
  drawing,
  tool,
  view,
  wish,
  motion,
  front,
  TOOLS,
  pixel,
  metre,
  points,
  edit,
  put,
  commit,
  goBack,
  choose,
  chooseWish,
  taskText,
  find,
  exportFmu,
  shareAddress,
  openFiles,
};
