// @ts-check
// The runtime of the FMU, compiled for the browser. Every call is an export of tools/web.
import { G, START, STEP, STOP, three, TOLERANCE } from "./data.js";
export class Solver {
  /** From the bytes of the module, or what they were compiled to. The variables of a program have their names in its order. */
  static async load(code, program, names) {
    if (code.served) return new ServedSolver(code, (await code.later("load", program)).model, names);
    /** @type {any} */
    const made = await WebAssembly.instantiate(code, {});
    return new Solver((made.instance ?? made).exports, program, names);
  }

  constructor(calls, program, names) {
    this.calls = calls;
    this.program = program;
    this.names = names;
    this.index = new Map(names.map((name, index) => [name, index]));
    const at = calls.cotree_alloc(program.length);
    new Uint8Array(calls.memory.buffer, at, program.length).set(program);
    this.model = calls.cotree_load(at, program.length);
    if (!this.model) throw new Error(this.message());
  }

  /** Why the last call failed. The memory may have moved since: no view of it is kept. */
  message() {
    const { calls } = this;
    return new TextDecoder().decode(new Uint8Array(calls.memory.buffer, calls.cotree_error(), calls.cotree_error_length()));
  }

  /** Times of the run: the start, every full step or every n-th of them, the stop. */
  static times(nth = 1) {
    const steps = Math.max(0, Math.ceil((STOP - START) / STEP * (1 - 1e-12) - 1e-9)), count = Math.ceil(steps / nth);
    return Float64Array.from({ length: count + 1 }, (_, k) => k === count ? STOP : START + k * nth * STEP);
  }

  /** Lends numbers to a call, as an address in the module's memory. */
  lend(numbers, call) {
    const { calls } = this, at = calls.cotree_alloc(numbers.byteLength);
    new numbers.constructor(calls.memory.buffer, at, numbers.length).set(numbers);
    const answer = call(at);
    numbers.set(new numbers.constructor(calls.memory.buffer, at, numbers.length));
    calls.cotree_free(at, numbers.byteLength);
    return answer;
  }
  places(names) {
    return Uint32Array.from(names, (name) => this.index.get(name));
  }

  /** Prepares a run with these values, by name. Nonzero if it fails. */
  prepare(values, start = START) {
    const { calls, model } = this;
    calls.cotree_reset(model);
    return calls.cotree_setup(model, start, Math.max(start, STOP), TOLERANCE) ||
      values.some(([name, value]) => calls.cotree_set(model, this.index.get(name), value));
  }

  /** A body held in a pose; null, and there is a message, if it cannot be held. Released are parameters and inputs: each its name, and whether it is an angle. */
  grip(pose, released, body) {
    const { calls, model } = this, pairs = Uint32Array.from(released.flatMap(({ name, angle }) => [this.index.get(name), angle ? 1 : 0]));
    const at = this.lend(
      Float64Array.from(pose),
      (q) =>
        this.lend(pairs, (free) =>
          this.lend(
            this.places(["x", "y", "angle"].map((word) => `${body}.${word}`)),
            (own) => calls.cotree_grip(model, q, pose.length, free, released.length, own),
          )),
    );
    return at ? new Grip(this, at) : null;
  }

  /** The variables at the start alone, with these values: a run of one sample. */
  start(values, names, pose = null) {
    return this.solve(values, [], names, pose, Float64Array.of(START));
  }

  /** Starts from a pose, wherever the guesses of the scene would lead. Nonzero if it fails. */
  startFrom(pose) {
    const grip = this.grip(pose, [], G.bodies[0].name);
    return grip ? this.calls.cotree_start_from(this.model, grip.at) || grip.letGo() : 1;
  }

  /** A run with these values (by name), inputs changed on the way as the list says, and these variables recorded; from a pose, if there is one. */
  solve(values, moves, names, pose = null, times = Solver.times()) {
    const { calls, model } = this, began = performance.now();
    const run = { times, columns: new Map(names.map((name) => [name, new Float64Array(times.length).fill(NaN)])), last: -1, error: null, warning: null };
    const failed = (what) => {
      run.error = what + this.message();
      run.ms = performance.now() - began;
      return run;
    };
    if (this.prepare(values)) return failed("");
    if (pose && this.startFrom(pose) || calls.cotree_init(model)) return failed("The mechanism cannot be assembled with these values: ");
    const ids = calls.cotree_alloc(4 * names.length), out = calls.cotree_alloc(8 * names.length);
    new Uint32Array(calls.memory.buffer, ids, names.length).set(this.places(names));
    const columns = [...run.columns.values()];
    let next = 0;
    for (let k = 0; k < times.length; k++) {
      if (k && calls.cotree_step(model, times[k])) {
        failed(`The motion ends at ${three(times[k - 1])} s: `);
        break;
      }
      for (; next < moves.length && moves[next].at <= times[k]; next++) calls.cotree_set(model, this.index.get(moves[next].name), moves[next].value);
      if (calls.cotree_record(model, ids, names.length, out)) {
        failed("");
        break;
      }
      const values = new Float64Array(calls.memory.buffer, out, names.length);
      for (let i = 0; i < columns.length; i++) columns[i][k] = values[i];
      run.last = k;
    }
    calls.cotree_free(ids, 4 * names.length);
    calls.cotree_free(out, 8 * names.length);
    if (calls.cotree_inaccurate(model)) run.warning = "Warning: " + this.message();
    run.ms = performance.now() - began;
    return run;
  }
}

/** JSON has `null` for what is not a number. */
const fromJson = (values) => Float64Array.from(values, (value) => value ?? NaN);

/** The same at the program that serves the page: one request for a run, or for a pull with its values. */
class ServedSolver {
  constructor(server, model, names) {
    this.server = server;
    this.model = model;
    this.names = names;
    this.index = new Map(names.map((name, index) => [name, index]));
    this.told = "";
    this.beside = {
      solve: async (...question) => {
        const began = performance.now();
        return this.taken(question, began, await server.later("solve", JSON.stringify(this.question(...question))));
      },
    };
  }
  message() {
    return this.told;
  }
  places(names) {
    return names.map((name) => this.index.get(name));
  }
  body(name) {
    return this.places(["x", "y", "angle"].map((word) => `${name}.${word}`));
  }
  begun(values, start) {
    return {
      model: this.model,
      start,
      stop: Math.max(start, STOP),
      tolerance: TOLERANCE,
      values: values.map(([name, value]) => [this.index.get(name), value]),
    };
  }

  /** What the next grip begins with. */
  prepare(values, start = START) {
    this.prepared = this.begun(values, start);
    return 0;
  }
  grip(pose, released, body) {
    const held = { positions: [...pose], released: released.map(({ name, angle }) => [this.index.get(name), Boolean(angle)]), body: this.body(body) };
    try {
      return new ServedGrip(this, this.server.now("grip", { ...this.prepared, pose: held }).grip);
    } catch (fault) {
      this.told = fault.message;
      return null;
    }
  }
  start(values, names, pose = null) {
    return this.solve(values, [], names, pose, Float64Array.of(START));
  }

  question(values, moves, names, pose = null, times = Solver.times()) {
    const held = pose && { positions: [...pose], body: this.body(G.bodies[0].name) };
    return {
      ...this.begun(values, START),
      pose: held,
      moves: moves.map(({ at, name, value }) => [at, this.index.get(name), value]),
      times: [...times],
      variables: this.places(names),
    };
  }
  solve(...question) {
    const began = performance.now();
    return this.taken(question, began, this.server.now("solve", this.question(...question)));
  }
  /** @type {(question: any[], began: number, answer: any) => any} */
  taken([, , names, , times = Solver.times()], began, { columns, last, failed, message, warning }) {
    const what = { start: "The mechanism cannot be assembled with these values: ", step: `The motion ends at ${three(times[last] ?? times[0])} s: ` };
    return {
      times,
      columns: new Map(names.map((name, k) => [name, fromJson(columns[k])])),
      last,
      error: failed ? `${what[failed] ?? ""}${message}` : null,
      warning: warning ? `Warning: ${warning}` : null,
      ms: performance.now() - began,
    };
  }
}
class ServedGrip {
  constructor(solver, grip) {
    this.solver = solver;
    this.grip = grip;
    this.time = null;
    this.number = 0;
  }
  /** Requests are numbered: one that arrives after a later one pulls no more. */
  question(to, names, share = 0) {
    return { grip: this.grip, number: ++this.number, time: this.time, to, share, variables: this.solver.places(names) };
  }
  async follow(point, target, names, share) {
    const { end, values } = await this.solver.server.later("pull", JSON.stringify(this.question([[...point], [...target]], names, share)));
    return { end, values: fromJson(values) };
  }
  pull(point, target) {
    return this.solver.server.now("pull", this.question([[...point], [...target]], [])).end;
  }
  values(names) {
    return fromJson(this.solver.server.now("pull", this.question(null, names)).values);
  }
  setTime(time) {
    this.time = time;
  }
  letGo() {
    return 0;
  }
}

/** A body that is held. */
export class Grip {
  constructor(solver, at) {
    this.solver = solver;
    this.at = at;
  }

  /** Pulls a point of the body, in its axes, to a place: 0 there or as near as it comes, 1 on its way, 2 at a dead point, 3 where branches meet, 4 nothing moves it, 5 nothing moves at all. */
  pull([x, y], [u, v]) {
    return this.solver.calls.cotree_pull(this.at, x, y, u, v);
  }

  /** Pulls until the point is there or a share of a frame [ms] is over; how that ended, and values in the pose. */
  follow(point, target, names, share) {
    const began = performance.now();
    let end;
    do end = this.pull(point, target); while (end === 1 && performance.now() - began < share);
    return { end, values: this.values(names) };
  }

  /** Values in the pose; what only a motion has is not a number. */
  values(names) {
    const values = new Float64Array(names.length);
    this.solver.lend(
      this.solver.places(names),
      (own) => this.solver.lend(values, (at) => this.solver.calls.cotree_pull_record(this.at, own, names.length, at)),
    );
    return values;
  }

  setTime(time) {
    this.solver.calls.cotree_pull_time(this.at, time);
  }
  letGo() {
    this.solver.calls.cotree_let_go(this.at);
    return 0;
  }
}
