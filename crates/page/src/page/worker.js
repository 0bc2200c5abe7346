// @ts-check
// Runs that take longer than a blink are solved beside the page, so that it stays alive.
import { $, G, START, STEP, STOP, three, TOLERANCE } from "./data.js";
import { Grip, Solver } from "./solver.js";
import { state } from "./main.js";
/** The longest run on the page's own thread [ms]. */
export const PATIENCE = { ms: 50 };

/** What the other thread runs: the solver, with the times of the experiment. It answers each question with a run. */
const besides = (names) =>
  `const START = ${START}, STOP = ${STOP}, STEP = ${STEP}, TOLERANCE = ${TOLERANCE}, NAMES = ${JSON.stringify(names)}, G = { bodies: [{ name: ${
    JSON.stringify(G.bodies[0]?.name)
  } }] };
${three}
${Solver}
${Grip}
let solver = null;
onmessage = async ({ data: { code, program, number, question } }) => {
  if (code) { solver = Solver.load(code, program, NAMES); return; }
  const run = (await solver).solve(...question);
  postMessage({ number, run }, [run.times.buffer, ...[...run.columns.values()].map(column => column.buffer)]);
};`;

class Beside {
  /** Null where there are no workers, as in some sandboxed frames. */
  static start(code, { program, names }) {
    try {
      const address = URL.createObjectURL(new Blob([besides(names)], { type: "text/javascript" }));
      const worker = new Worker(address);
      worker.postMessage({ code, program });
      return new Beside(worker);
    } catch {
      return null;
    }
  }

  constructor(worker) {
    this.worker = worker;
    this.number = 0;
    this.asked = new Map();
    this.waiting = null;
    worker.onmessage = ({ data: { number, run } }) => {
      const answer = this.asked.get(number);
      this.asked.delete(number);
      answer(run);
    };
  }

  solve(...question) {
    return new Promise((answer) => {
      this.number++;
      this.asked.set(this.number, answer);
      this.worker.postMessage({ number: this.number, question });
    });
  }
}

/** Solves here what is expected to be quick [ms], and beside the page what is not; calls with the run. Of several questions only the last is answered. */
const questions = { busy: false, next: null, last: 0 };
export function ask(solver, expected, question, answer) {
  const slow = expected > PATIENCE.ms, number = ++questions.last;
  if (slow && solver.beside === undefined) solver.beside = Beside.start(state.code, solver);
  if (!slow || !solver.beside) {
    questions.next = null;
    answer(solver.solve(...question));
    return;
  }
  if (questions.busy) {
    questions.next = [solver, expected, question, answer];
    return;
  }
  questions.busy = true;
  $("status").textContent = "solving\u2026";
  solver.beside.solve(...question).then((run) => {
    questions.busy = false;
    const { next } = questions;
    questions.next = null;
    if (next) ask(...next);
    else if (number === questions.last) answer(run);
  });
}
