// What the page that moves and the page that draws share: bytes that a page carries, values as they are written, texts changed at places.
/** Bytes of a script element: base64 of a zlib stream; null if it is empty. */
async function unpack(id) {
  const text = document.getElementById(id).textContent.trim();
  if (!text) return null;
  if (typeof DecompressionStream === "undefined") throw new Error("this browser cannot unpack the page; any browser since 2023 can");
  const packed = Uint8Array.from(atob(text), c => c.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/** All digits that matter, and no more. */
const digits12 = number => `${+number.toPrecision(12)}`;
/** A value in place of what stands in the text: in its quotes if it has some, with its unit if it has one. */
function inText(value, { unit, bare }, old) {
  const quote = old.match(/^["']/)?.[0] ?? "";
  if (quote && /[A-Za-z°%"″]/.test(old.slice(1, -1))) return `${quote}${digits12(value / unit.factor)} ${unit.name}${quote}`;
  return `${quote}${digits12(bare ? value / unit.factor : value)}${quote}`;
}
/** The bytes of a text; and what stands in some of them. */
const bytesOf = text => new TextEncoder().encode(text);
const textOf = bytes => new TextDecoder("utf-8", { ignoreBOM: true }).decode(bytes);
/** A text with other texts at these places, which count bytes. */
function spliced(text, places) {
  const bytes = bytesOf(text), pieces = [];
  let from = 0;
  for (const [[start, end], piece] of [...places].sort(([a], [b]) => a[0] - b[0])) { pieces.push(textOf(bytes.subarray(from, start)), piece); from = end; }
  return pieces.join("") + textOf(bytes.subarray(from));
}
/** A file for the reader. */
function save(name, content) {
  const blob = content instanceof Blob ? content : new Blob([content]), link = Object.assign(document.createElement("a"), { href: URL.createObjectURL(blob), download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}
