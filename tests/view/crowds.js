cotree.pause();
const { state, MODEL } = cotree, canvas = $("surface"), frames = count => new Promise(done => { const next = () => count-- > 0 ? page.requestAnimationFrame(next) : done(); next(); });
const ink = () => canvas.toDataURL();
// The page finds its size first.
await frames(5);
cotree.seek(0);
const start = ink();
cotree.seek(MODEL.experiment.stop / 2);
const moved = ink() !== start;
cotree.seek(0);
const back = ink() === start;
// While it plays, nothing of the drawing in the document changes: that is what frames are dear for.
let changes = 0, drawn = 0;
new page.MutationObserver(list => { changes += list.length; }).observe($("scene"), { subtree: true, childList: true, attributes: true, characterData: true });
const clear = page.CanvasRenderingContext2D.prototype.clearRect;
page.CanvasRenderingContext2D.prototype.clearRect = function (...box) { drawn++; return clear.apply(this, box); };
cotree.play();
await frames(30);
cotree.pause();
await wait(0);
const still = changes === 0, each = drawn >= 30;
cotree.seek(0);
// The pointer: a joint is clicked, a body is named.
const place = ([x, y]) => { const { x: clientX, y: clientY } = new page.DOMPoint(x, y).matrixTransform($("scene").getScreenCTM()); return { clientX, clientY, bubbles: true, pointerId: 3 }; };
const { scale } = MODEL.geometry, joint = MODEL.geometry.joints[0].ends.find(end => end.body === null).at, at = place([scale * joint[0], -scale * joint[1]]);
const backdrop = $("backdrop");
backdrop.dispatchEvent(new page.PointerEvent("pointermove", at));
const named = $("scene-title").textContent === MODEL.geometry.joints[0].name;
const paths = () => cotree.traced(), before = paths();
const click = () => { backdrop.dispatchEvent(new page.PointerEvent("pointerdown", at)); backdrop.dispatchEvent(new page.PointerEvent("pointerup", at)); backdrop.dispatchEvent(new page.MouseEvent("click", at)); };
$("stage").setPointerCapture = () => {};
click();
const traced = paths() === before + 1;
click();
const untraced = paths() === before;
const [x, y] = cotree.pose[49], body = place([scale * x, -scale * y]);
backdrop.dispatchEvent(new page.PointerEvent("pointermove", body));
const pointed = cotree.pointed() === 49;
backdrop.dispatchEvent(new page.PointerEvent("pointermove", place([1e5, 1e5])));
$("theme").click();
const recoloured = ink() !== start;
$("theme").click();
const asBefore = ink() === start;
// Paper gets the elements, the screen its canvas back.
page.dispatchEvent(new page.Event("beforeprint"));
const printed = canvas.hidden && $("scene").querySelectorAll("#bodies .body[transform]").length === MODEL.geometry.bodies.length;
page.dispatchEvent(new page.Event("afterprint"));
const paper = printed && !canvas.hidden && ink() === start;
return { paper, moved, back, still, each, named, traced, untraced, pointed, recoloured, asBefore };
