// Rounds of frames in which nothing is done, in which a body is pulled, and in which a point is moved: the rate of pictures in the latter over that of the frames that the browser offers in the former.
cotree.pause();
cotree.PATIENCE.ms = Infinity;
cotree.seek(0);
const ROUNDS = 8, FRAMES = 24, { state, MODEL, pose, touching } = cotree, G = MODEL.geometry, S = G.scale, stage = $("stage"), frame = () => new Promise(done => page.requestAnimationFrame(done));
// What a reader sees of the bodies: a picture is a new one if something of it is elsewhere.
const picture = () => Array.from($("scene").querySelectorAll("[transform]"), own => own.getAttribute("transform")).join();
const body = G.bodies.findIndex(({ name }) => name === BODY), handle = touching.handles.find(({ name }) => name === POINT)?.button;
if (body < 0 || !handle) return { none: [G.bodies.map(({ name }) => name), touching.handles.map(({ name }) => name)] };
const mode = name => page.document.querySelector(`[data-mode-of=${name}]`).click();
/** The pointer's way, from where a press has become a drag. */
const at = k => [14 * Math.sin(.12 * k), 14 * (1 - Math.cos(.12 * k))];

/** Frames and new pictures in so many frames, and how long they took: `move` is called in each. */
async function round(move) {
  await frame();
  const began = page.performance.now();
  let before = picture(), run = state.run, drawn = 0, solved = 0, poses = Infinity;
  for (let k = 1; k <= FRAMES; k++) {
    move(k);
    await frame();
    const now = picture();
    drawn += now !== before;
    solved += state.run !== run;
    poses = Math.min(poses, state.run.times.length);
    [before, run] = [now, state.run];
  }
  return { drawn, solved, poses, took: page.performance.now() - began };
}
/** The same while a pointer goes round on a target. */
async function dragging(target, [x, y]) {
  target.setPointerCapture = () => {};
  const send = (kind, [u, v]) => target.dispatchEvent(new page.PointerEvent(kind, { pointerId: 5, clientX: x + u, clientY: y + v, bubbles: true }));
  send("pointerdown", [0, 0]);
  send("pointermove", at(6));
  await frame();
  const found = await round(k => send("pointermove", at(6 + k)));
  send("pointercancel", [0, 0]);
  await frame();
  return found;
}
const seen = { idle: 0, pull: [], change: [], whole: state.first.times.length, released: true };
for (let count = 0; count < ROUNDS; count++) {
  const idle = await round(() => {});
  seen.idle += idle.drawn;
  mode("pull");
  cotree.seek(0);
  const { x, y } = new page.DOMPoint(S * pose[body][0], -S * pose[body][1]).matrixTransform($("scene").getScreenCTM());
  const pulled = await dragging(stage, [x, y]);
  mode("change");
  const box = handle.getBoundingClientRect(), changed = await dragging(handle, [box.x + box.width / 2, box.y + box.height / 2]);
  await frame();
  seen.released &&= state.run.times.length === seen.whole;
  for (const [name, { drawn, solved, poses, took }] of [["pull", pulled], ["change", changed]]) seen[name].push({ drawn: drawn / FRAMES, solved: solved / FRAMES, poses, rate: drawn / FRAMES * idle.took / took });
}
return seen;
