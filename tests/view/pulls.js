cotree.pause();
cotree.PATIENCE.ms = Infinity;
cotree.seek(0);
const { state, MODEL, pose, touching, knobs } = cotree, G = MODEL.geometry, S = G.scale, stage = $("stage"), next = () => new Promise(done => page.requestAnimationFrame(() => page.requestAnimationFrame(done)));
stage.setPointerCapture = () => {};
const world = ({ body, at }) => { if (body === null) return at; const [x, y, angle] = pose[body], s = Math.sin(angle), c = Math.cos(angle); return [x + c * at[0] - s * at[1], y + s * at[0] + c * at[1]]; };
const client = ([x, y]) => { const { x: u, y: v } = new page.DOMPoint(S * x, -S * y).matrixTransform($("scene").getScreenCTM()); return [u, v]; };
const send = (kind, place, pointerType = "mouse") => { const [clientX, clientY] = client(place); stage.dispatchEvent(new page.PointerEvent(kind, { pointerId: 5, clientX, clientY, pointerType, bubbles: true })); };
// The largest gap of a pin, by the places of the bodies alone.
const gap = () => Math.max(...G.joints.filter(({ hold }) => hold === "pin").map(({ ends: [a, b] }) => { const [p, q] = [world(a), world(b)]; return Math.hypot(p[0] - q[0], p[1] - q[1]); }));
const body = G.bodies.findIndex(({ name }) => name === BODY), from = [pose[body][0], pose[body][1]], other = G.bodies.findIndex(({ name }) => name === OTHER), others = other < 0 ? 0 : pose[other][2];
let open = 0, leap = 0, pictures = 0, before = pose.map(one => one[2]);
send("pointerdown", from);
for (const place of PATH(from)) {
  send("pointermove", place);
  await next();
  pictures++;
  open = Math.max(open, gap());
  const now = pose.map(one => one[2]);
  leap = Math.max(leap, ...now.map((angle, k) => Math.abs(angle - before[k])));
  before = now;
}
const steps = touching.hold?.steps ?? 0, told = $("notice").textContent, there = [...pose[body]], still = other < 0 ? 0 : Math.abs(pose[other][2] - others), held = pose.map(([x, y, angle]) => [x, y, angle]);
send("pointerup", [0, 0]);
await next();
const apart = Math.max(...held.map((one, k) => Math.max(...one.map((value, axis) => Math.abs(value - pose[k][axis])))));
const starts = Object.fromEntries(G.bodies.flatMap(({ name }, k) => ["x", "y", "angle"].map((word, axis) => [`${name}.${word}`, pose[k][axis]])));
const outputs = Object.fromEntries(MODEL.outputs.map(name => [name, [state.run.columns.get(name)[0], state.run.columns.get(name).at(-1)]]));
const text = cotree.sceneText(), renewed = state.run !== state.first && state.run.last === state.run.times.length - 1, end = pose.map(one => [...one]);
$("undo").click();
await next();
const undone = state.run === state.first && cotree.sceneText() === MODEL.touch.text;
$("redo").click();
await next();
const again = pose.every((one, k) => one.every((value, axis) => Math.abs(value - end[k][axis]) < 1e-9));
return { open, leap, steps, pictures, told, there, still, apart, starts, outputs, text, renewed, undone, again };
