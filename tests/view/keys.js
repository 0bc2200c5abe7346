cotree.pause();
const { state, transport, MODEL } = cotree, press = (key, shiftKey) => page.document.body.dispatchEvent(new page.KeyboardEvent("keydown", { key, shiftKey, bubbles: true }));
const { start, stop, step } = MODEL.experiment, near = (a, b) => Math.abs(a - b) < 1e-9, said = {}, view = () => $("scene").getAttribute("viewBox");
press("Home"); said.home = near(state.time, start);
press("ArrowRight"); said.step = near(state.time, start + step);
press("ArrowRight", true); said.ten = near(state.time, start + 11 * step);
press("ArrowLeft"); said.back = near(state.time, start + 10 * step);
press("End"); said.end = near(state.time, stop);
press(" "); said.play = transport.playing;
press(" "); said.pause = !transport.playing;
const speed = transport.speed; press("["); said.slower = transport.speed < speed; press("]"); said.faster = transport.speed === speed;
const seen = view(); press("+"); said.zoom = view() !== seen; press("0"); said.fit = view() === seen;
for (const [key, layer] of [["t", "traces"], ["f", "forces"], ["v", "velocities"], ["g", "ghosts"], ["n", "names"]]) {
  const button = page.document.querySelector(`[data-layer=${layer}]`), before = button.getAttribute("aria-pressed");
  press(key); said[layer] = button.getAttribute("aria-pressed") !== before;
}
said.ghost = page.document.querySelectorAll("#ghosts path").length > 0;
said.speed = [...page.document.querySelectorAll("#velocities path")].some(path => path.getAttribute("d"));
press("?"); said.help = $("keys").open;
frame.width = 390;
await wait(300);
said.narrow = page.document.documentElement.scrollWidth <= 390;
return said;
