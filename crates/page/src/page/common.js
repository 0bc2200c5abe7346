// @ts-check
// What the page that moves and the page that draws share: bytes that a page carries, values as they are written, texts changed at places.

/** Bytes of a script element: base64 of a zlib stream; null if it is empty. */
export async function unpack(id) {
  const text = document.getElementById(id).textContent.trim();
  if (!text) return null;
  if (typeof DecompressionStream === "undefined") throw new Error("this browser cannot unpack the page; any browser since 2023 can");
  const packed = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/** All digits that matter, and no more. */
export const digits12 = (number) => `${+number.toPrecision(12)}`;
/** A number as the text writes it in its place: between what stands around it, in the unit that it has there. */
export const written = (value, { before, after, factor }) => `${before}${digits12(value / factor)}${after}`;
/** The bytes of a text; and what stands in some of them. */
export const bytesOf = (text) => new TextEncoder().encode(text);
export const textOf = (bytes) => new TextDecoder("utf-8", { ignoreBOM: true }).decode(bytes);
/** A text with other texts at these places, which count bytes. */
export function spliced(text, places) {
  const bytes = bytesOf(text), pieces = [];
  let from = 0;
  for (const [[start, end], piece] of [...places].sort(([a], [b]) => a[0] - b[0])) {
    pieces.push(textOf(bytes.subarray(from, start)), piece);
    from = end;
  }
  return pieces.join("") + textOf(bytes.subarray(from));
}
/** A file for the reader. */
export function save(name, content) {
  const blob = content instanceof Blob ? content : new Blob([content]),
    link = Object.assign(document.createElement("a"), { href: URL.createObjectURL(blob), download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}

export const SVG = "http://www.w3.org/2000/svg";
/** An element of a drawing. */
export function svgElement(tag, attributes, parent, text) {
  const made = document.createElementNS(SVG, tag);
  for (const name in attributes) made.setAttribute(name, attributes[name]);
  if (text !== undefined) made.textContent = text;
  parent?.append(made);
  return made;
}
/** Two digits behind the point are enough for pixels. */
export const round = (value) => Math.round(value * 100) / 100;
/** A drawing in pixels, two for each of the screen. */
/** @type {(svg: string, size: number[]) => Promise<Blob>} */
export async function pngOf(svg, [width, height]) {
  const image = new Image(), canvas = Object.assign(document.createElement("canvas"), { width: 2 * width, height: 2 * height });
  image.src = `data:image/svg+xml;charset=utf-8,${encodeURIComponent(svg)}`;
  await image.decode();
  canvas.getContext("2d").drawImage(image, 0, 0, canvas.width, canvas.height);
  return new Promise((done) => canvas.toBlob(done, "image/png"));
}
/** What can be undone and done again: a list of states, and which of them is now. */
export class Undo {
  /** @param {any[]} states */
  constructor(states) {
    this.states = states;
    this.now = states.length - 1;
  }
  present() {
    return this.states[this.now];
  }
  /** A new state: those that were undone are forgotten. */
  take(state) {
    this.states.splice(this.now + 1, Infinity, state);
    this.now++;
  }
  /** Goes back or forward; undefined where there is no such state. */
  go(by) {
    const next = this.states[this.now + by];
    if (next !== undefined) this.now += by;
    return next;
  }
  show() {
    for (const [id, can] of Object.entries({ undo: this.now > 0, redo: this.now < this.states.length - 1 })) {
      /** @type {any} */ (document.getElementById(id)).disabled = !can;
    }
  }
}
/** Dark instead of light, or light instead of dark. */
export function changeTheme() {
  const root = document.documentElement, dark = root.dataset.theme ? root.dataset.theme === "dark" : matchMedia("(prefers-color-scheme:dark)").matches;
  return root.dataset.theme = dark ? "light" : "dark";
}
/** Elements by a selector, as what they are.
 * @type {(selector: string, within?: any) => any[]} */
export const all = (selector, within = document) => [...within.querySelectorAll(selector)];
/** What an event is about.
 * @type {(event: Event) => any} */
export const targetOf = (event) => event.target;
