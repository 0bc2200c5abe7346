// The runtime of the FMU, compiled for the browser. Every call is an export of tools/web.
class Solver {
  static async load(code, program) {
    const { instance } = await WebAssembly.instantiate(code, {});
    return new Solver(instance.exports, program);
  }

  constructor(calls, program) {
    this.calls = calls;
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

  /** Times of the run: the start, every full step, the stop. */
  static times() {
    const steps = Math.max(0, Math.ceil((STOP - START) / STEP * (1 - 1e-12) - 1e-9));
    return Float64Array.from({ length: steps + 1 }, (_, k) => k === steps ? STOP : START + k * STEP);
  }

  /** The variables at the start alone, with these values: a run of one sample. */
  start(values, names) {
    return this.solve(values, [], names, Float64Array.of(START));
  }

  /** A run with these values (by index), inputs changed on the way as the list says, and these variables recorded. */
  solve(values, moves, names, times = Solver.times()) {
    const { calls, model } = this, began = performance.now();
    const run = { times, columns: new Map(names.map(name => [name, new Float64Array(times.length).fill(NaN)])), last: -1, error: null, warning: null };
    const failed = what => { run.error = what + this.message(); run.ms = performance.now() - began; return run; };
    calls.cotree_reset(model);
    if (calls.cotree_setup(model, START, STOP, TOLERANCE)) return failed("");
    for (const [index, value] of values) if (calls.cotree_set(model, index, value)) return failed("");
    if (calls.cotree_init(model)) return failed("The mechanism cannot be assembled with these values: ");
    const ids = calls.cotree_alloc(4 * names.length), out = calls.cotree_alloc(8 * names.length);
    new Uint32Array(calls.memory.buffer, ids, names.length).set(names.map(name => INDEX.get(name)));
    const columns = [...run.columns.values()];
    let next = 0;
    for (let k = 0; k < times.length; k++) {
      if (k && calls.cotree_step(model, times[k])) { failed(`The motion ends at ${three(times[k - 1])} s: `); break; }
      for (; next < moves.length && moves[next].at <= times[k]; next++) calls.cotree_set(model, moves[next].index, moves[next].value);
      if (calls.cotree_record(model, ids, names.length, out)) { failed(""); break; }
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
