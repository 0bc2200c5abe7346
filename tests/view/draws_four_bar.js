const empty = drawing.text, begun = { faults: $("faults").textContent, error: page.document.querySelector("#faults .error") !== null };
use("pin"); await press([0, 0]); await press([.25, 0]);
use("bar"); await drag([0, 0], [.05, .1]); await drag([.05, .1], [.3, .2]); await drag([.3, .2], [.25, 0]);
const four = drawing.sketch.mobility;
use("motor"); await press([0, 0]);
use("tracer"); await press([.176, .15]);
const drawn = drawing.text, moving = await until(() => page.document.documentElement.dataset.moving === drawn);
const inner = draw.motion.frame.contentWindow.cotree, columns = inner.state.run.columns;
const { name, bytes } = await draw.exportFmu(2), third = await draw.exportFmu(3);
const verdict = {
  begun, four, mobility: drawing.sketch.mobility, faults: drawing.faults.map(({ message }) => message), moving, name,
  bodies: drawing.sketch.geometry.bodies.length, text: drawn, fmu: base64(bytes), fmu3: base64(third.bytes),
  last: inner.state.run.last, traced: inner.traced(), column: [...columns.get("bar2.tracer.x")].slice(0, 40),
};
let back = 0;
while (!$("undo").disabled) { draw.goBack(-1); back++; }
await settled();
verdict.empty = drawing.text === empty;
for (; back > 0; back--) draw.goBack(1);
await settled();
return { ...verdict, again: drawing.text === drawn };
