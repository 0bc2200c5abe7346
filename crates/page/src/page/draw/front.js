// @ts-check
// The way from a scene to its FMU, compiled for the browser, on a thread of its own. Every call is an export of tools/front.
import { bytesOf, textOf, unpack } from "../common.js";
/** What the other thread runs: it answers each question with bytes, or says that the program has failed, and begins anew. */
function otherThread() {
  let module = null, calls = null;
  const kept = [];
  // A crate that packs archives could draw random numbers, for which it would ask the page. Nothing here does.
  const imports = () => {
    /** @type {any} */
    const made = {};
    for (const { module: from, name } of WebAssembly.Module.imports(module)) {
      (made[from] ??= {})[name] = () => {
        throw new Error(`there is no ${name}`);
      };
    }
    return made;
  };
  const start = async () => {
    /** @type {any} */
    const made = await WebAssembly.instantiate(module, imports());
    calls = made.exports;
    kept.forEach(([name, bytes]) => {
      put(bytes);
      calls[name]();
    });
  };
  const put = (bytes) => {
    const at = calls.front_room(bytes.length);
    new Uint8Array(calls.memory.buffer, at, bytes.length).set(bytes);
  };
  const answer = () => new Uint8Array(calls.memory.buffer, calls.front_answer(), calls.front_answer_length()).slice();
  onmessage = async ({ data: { number, code, keep, name, bytes, argument } }) => {
    try {
      if (code) {
        module = await WebAssembly.compile(code);
        await start();
        return;
      }
      if (keep) kept.push([name, bytes]);
      put(bytes);
      const failed = calls[name](argument), found = keep ? new Uint8Array() : answer();
      postMessage({ number, failed: Boolean(failed), bytes: found }, /** @type {any} */ ([found.buffer]));
    } catch (fault) {
      // A panic leaves the memory of the module as it was in the middle of things.
      const bytes = new TextEncoder().encode(
        JSON.stringify({
          faults: [{
            severity: "error",
            message: `cotree itself has failed at this text (${fault.message}): please report it with the text`,
            help: "the text stays as it is",
          }],
          omitted: 0,
        }),
      );
      postMessage({ number, failed: true, bytes });
      if (module) await start();
    }
  };
}

export const front = {
  number: 0,
  asked: new Map(),
  worker: null,
  async start() {
    if (window.cotreeSolver?.served) return;
    const code = await unpack("front");
    this.worker = new Worker(URL.createObjectURL(new Blob([`(${otherThread})()`], { type: "text/javascript" })));
    this.worker.onmessage = ({ data: { number, failed, bytes } }) => {
      const done = this.asked.get(number);
      this.asked.delete(number);
      done({ failed, bytes });
    };
    this.worker.postMessage({ code }, [code.buffer]);
  },
  /** Asks with a text or bytes; the answer's bytes, and whether they say what is wrong. */
  ask(name, content, { argument = 0, keep = false } = {}) {
    const bytes = typeof content === "string" ? bytesOf(content) : content, number = ++this.number;
    if (!this.worker) return window.cotreeSolver.bytes(argument ? `${name}?${argument}` : name, bytes);
    return new Promise((done) => {
      this.asked.set(number, done);
      this.worker.postMessage({ number, name, bytes, argument, keep });
    });
  },
  /** The text after edits: the front end knows how scenes are written. */
  async edited(text, edits) {
    const { failed, bytes } = await this.ask("front_edit", JSON.stringify({ text, edits }));
    if (failed) throw new Error(JSON.parse(textOf(bytes)).faults[0].message);
    return textOf(bytes);
  },
  async json(name, content) {
    return JSON.parse(textOf((await this.ask(name, content)).bytes));
  },
};
