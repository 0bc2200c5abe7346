const empty = drawing.text, begun = { faults: $("faults").textContent, error: page.document.querySelector("#faults .error") !== null };
use("pin"); await press([0, 0]); await press([.24, 0]);
use("bar"); await drag([0, 0], [.04, .08]); await drag([.04, .08], [.28, .16]); await drag([.28, .16], [.24, 0]);
const four = drawing.sketch.mobility;
use("motor"); await press([0, 0]);
use("tracer"); await press([.16, .12]);
const drawn = drawing.text, moving = await until(() => page.document.documentElement.dataset.moving === drawn);
const inner = draw.motion.frame.contentWindow.cotree, columns = inner.state.run.columns;
const { name, bytes } = await draw.exportFmu(2), third = await draw.exportFmu(3);
const verdict = {
  begun, four, mobility: drawing.sketch.mobility, faults: drawing.faults.map(({ message }) => message), moving, name,
  bodies: drawing.sketch.geometry.bodies.length, text: drawn, fmu: base64(bytes), fmu3: base64(third.bytes),
  last: inner.state.run.last, traced: inner.traced(), column: [...columns.get("bar2.tracer.x")].slice(0, 40),
};
let back = 0;
while (drawing.now > 0) { draw.goBack(-1); back++; }
await settled();
verdict.empty = drawing.text === empty;
for (; back > 0; back--) draw.goBack(1);
await settled();
return { ...verdict, again: drawing.text === drawn };
