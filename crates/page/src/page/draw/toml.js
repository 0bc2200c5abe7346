// Edits of a scene's text: tables and lines are added and removed; all else in it stays.
/** The order in which tables are added. */
const ORDER = ["parameters", "inputs", "states", "ground", "bodies", "joints", "drivers", "loads", "signals", "initial", "outputs", "experiment"];
/** A list over several lines has no header in it. */
const HEADER = /^[ \t]*\[([A-Za-z_][A-Za-z0-9_-]*(?:\.(?:[A-Za-z0-9_-]+|"[^"\n]*"))*)\][ \t]*(?:#.*)?$/gm;
/** The tables of a text: where each begins, where its lines begin, where they end; comments above the next header are the next table's. */
function tables(text) {
  const heads = [...text.matchAll(HEADER)];
  return heads.map((head, k) => {
    const body = head.index + head[0].length, next = heads[k + 1]?.index ?? text.length;
    const end = next === text.length ? text.trimEnd().length : body + text.slice(body, next).replace(/(?:\s*\n[ \t]*(?:#.*)?)+$/, "").length;
    return { name: head[1], start: head.index, body, end: Math.max(body, end) };
  });
}
const table = (text, name) => tables(text).find(own => own.name === name);
const inserted = (text, at, piece) => text.slice(0, at) + piece + text.slice(at);
const rankOf = name => { const rank = ORDER.indexOf(name.split(".")[0]); return rank < 0 ? ORDER.length : rank; };

function addTable(text, name, lines) {
  const own = rankOf(name), all = tables(text), before = all.findLast(other => rankOf(other.name) <= own), piece = `[${name}]\n${lines.join("\n")}`;
  if (before) return `${inserted(text, before.end, `\n\n${piece}`)}`.replace(/\n*$/, "\n");
  if (!all.length) return `${text.trimEnd()}\n\n${piece}\n`.trimStart();
  return inserted(text, all[0].start, `${piece}\n\n`);
}
function addLine(text, name, line) {
  const own = table(text, name);
  return own ? inserted(text, own.end, `\n${line}`).replace(/\n*$/, "\n") : addTable(text, name, [line]);
}
function removeTable(text, name) {
  const own = table(text, name);
  if (!own) return text;
  const from = text.slice(0, own.start).replace(/\n\s*$/, "\n").length;
  return text.slice(0, from) + text.slice(own.end).replace(/^\n/, "");
}
/** Removes the lines of a table whose key is meant. */
function removeLines(text, name, isMeant) {
  const own = table(text, name);
  if (!own) return text;
  const lines = text.slice(own.body, own.end).split("\n"), left = lines.filter(line => { const key = line.match(/^\s*(?:"([^"]*)"|([A-Za-z0-9_.-]+))\s*=/); return !key || !isMeant(key[1] ?? key[2], line); });
  const some = left.some(line => line.trim() && !line.trim().startsWith("#"));
  return some || left.length === lines.length ? text.slice(0, own.body) + left.join("\n") + text.slice(own.end) : removeTable(text, name);
}
/** The end of what a bracket opens; texts and comments are passed. */
function closing(text, open) {
  const passed = /"(?:[^"\\\n]|\\.)*"|'[^'\n]*'|#.*|[\[\]{}]/g;
  passed.lastIndex = open;
  let depth = 0;
  for (let found; (found = passed.exec(text));) {
    if ("[{".includes(found[0])) depth++;
    else if ("]}".includes(found[0]) && --depth === 0) return found.index;
  }
  return -1;
}
/** Where the value of a key of a table begins; -1 if it is not there. */
function valueAt(text, name, key) {
  const own = table(text, name), found = own && text.slice(own.body, own.end).match(new RegExp(`^[ \\t]*${key}[ \\t]*=[ \\t]*`, "m"));
  return found ? own.body + found.index + found[0].length : -1;
}
/** Adds to a list or an inline table that a key has, or writes it. */
function addItem(text, name, key, item, [open, close]) {
  const at = valueAt(text, name, key);
  if (at < 0) return addLine(text, name, `${key} = ${open} ${item} ${close}`);
  const end = text[at] === open ? closing(text, at) : -1;
  if (end < 0) throw new Error(`\`${key}\` of [${name}] is not written as ${open} ${close}: add ${item} to it in the text`);
  const before = text.slice(0, end).trimEnd();
  return `${before}${/[,[{]$/.test(before) ? "" : ","} ${item}${text.slice(before.length, end).includes("\n") ? text.slice(before.length, end) : " "}${text.slice(end)}`;
}
/** Removes a key of an inline table. */
function removeItem(text, name, key, item) {
  const at = valueAt(text, name, key), end = at >= 0 && text[at] === "{" ? closing(text, at) : -1;
  if (end < 0) return text;
  const found = new RegExp(`(?<=[{,]\\s*)"?${item}"?\\s*=\\s*`).exec(text.slice(at, end));
  if (!found) return text;
  const from = at + found.index, open = from + found[0].length, last = "[{".includes(text[open]) ? closing(text, open) + 1 : open + text.slice(open, end).match(/^[^,]*/)[0].length;
  const after = text.slice(last).match(/^\s*,\s*/)?.[0].length ?? 0;
  // Of the last one the comma before goes.
  return after ? text.slice(0, from) + text.slice(last + after) : text.slice(0, from).replace(/,\s*$/, "") + text.slice(last);
}
function addPoint(text, body, name, at) {
  const point = `${name} = [${at.map(metres).join(", ")}]`;
  if (table(text, `bodies.${body}.points`)) return addLine(text, `bodies.${body}.points`, point);
  if (!table(text, `bodies.${body}`)) throw new Error(`\`${body}\` has no table [bodies.${body}] in this text: add the point there yourself`);
  return addItem(text, `bodies.${body}`, "points", point, ["{", "}"]);
}
const addOutputs = (text, names) => names.reduce((text, name) => text.includes(`"${name}"`) && table(text, "outputs") && text.slice(table(text, "outputs").body).includes(`"${name}"`) ? text : addItem(text, "outputs", "variables", `"${name}"`, ["[", "]"]), text);
/** Digits of what is drawn: poses are known to some more. What is a short number but for rounding is that number. */
const drawn = value => { const short = +value.toPrecision(6); return `${Math.abs(short - value) <= 2e-9 * Math.abs(value) ? short : +value.toPrecision(10)}`; };
/** A length as it is drawn: in millimetres, and on the grid where rounding alone keeps it off that. */
function metres(value) {
  const step = gridStep(), near = Math.round(1e3 * value / step) * step / 1e3, length = Math.abs(value - near) < 1e-7 * step ? near : value;
  return Math.abs(length) < 5e-13 ? "0" : `"${drawn(1e3 * length)} mm"`;
}
const degrees = value => `"${drawn(180 / Math.PI * value)} deg"`;
/** A name that nothing has. */
function freshName(text, wanted) {
  for (let k = 1; ; k++) { const name = k === 1 ? wanted : `${wanted}${k}`; if (!new RegExp(`(?<![A-Za-z0-9_])${name}(?![A-Za-z0-9_])`).test(text)) return name; }
}
