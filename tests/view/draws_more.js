const seen = {};
// By keys alone: two bars, pinned to each other and to the ground.
board.focus();
key("p"); key("Enter"); await settled();
const [ground] = draw.points();
key("b"); key("n"); key("Enter"); for (let k = 0; k < 5; k++) key("ArrowRight"); key("Enter"); await settled();
seen.keys = drawing.sketch.geometry?.bodies.length === 1 && drawing.sketch.mobility === 1;
seen.said = $("said").textContent;
const tip = draw.points().find(({ name }) => name === "b").at;
seen.place = Math.hypot(tip[0] - ground.at[0], tip[1] - ground.at[1]) > .05;
// Taken up, moved and let go by keys; Escape puts back.
const before = drawing.text;
key("v"); key("n"); while (draw.tool.met.name !== "b") key("n");
key("Enter"); key("ArrowUp"); await settled(); key("Escape"); await settled();
seen.putBack = drawing.text === before;
key("Enter"); key("ArrowUp"); key("ArrowUp"); await settled(); key("Enter"); await settled();
seen.moved = drawing.text !== before && /"bar\.angle" = \{ guess = "\d/.test(drawing.text);
// Every other tool; what is drawn compiles each time.
const end = () => draw.points().find(({ name, owner }) => owner === "bar" && name === "b").at;
for (const [name, to] of [["spring", [.3, .3]], ["damper", [0, .3]], ["load", [.4, .1]]]) { use(name); await drag(end(), to); seen[name] = drawing.good; }
use("slot"); await drag(end(), [end()[0] + .1, end()[1]]); seen.slot = drawing.good && drawing.sketch.geometry.joints.some(({ hold }) => hold === "slot");
draw.goBack(-1); await settled();
use("slider"); await drag(end(), [end()[0] + .1, end()[1]]); seen.slider = drawing.good && drawing.sketch.geometry.bodies.some(({ name }) => name === "block");
const joints = drawing.sketch.geometry.joints.length;
use("remove"); await press(end()); seen.unpinned = drawing.sketch.geometry.joints.length === joints - 1;
const start = draw.points().find(({ name, owner }) => owner === "bar" && name === "a").at;
use("remove"); await press([.5 * (start[0] + end()[0]), .5 * (start[1] + end()[1])]); seen.removed = drawing.sketch.geometry === null || !drawing.sketch.geometry.bodies.some(({ name }) => name === "bar");
seen.faults = drawing.faults.filter(({ severity, code }) => severity === "error" && code !== "scene::no_bodies").map(({ message }) => message);
// A fault at its place: a click selects it in the text.
draw.edit(before.replace('density = "1 kg/m"', 'density = "1 kg/furlong"'), ""); await settled();
const fault = page.document.querySelector("#faults .error button");
seen.line = fault?.textContent.includes(`line ${before.slice(0, before.indexOf("density")).split("\n").length}`);
fault?.click();
seen.selected = $("text").value.slice($("text").selectionStart, $("text").selectionEnd);
seen.stale = drawing.stale && drawing.sketch.geometry.bodies.length === 1;
use("bar"); await press([0, 0]); seen.waits = $("said").textContent.includes("correct");
// What is typed is drawn.
$("text").value = before.replace("[initial]", "# by hand\n[initial]"); $("text").dispatchEvent(new page.Event("input", { bubbles: true })); $("text").dispatchEvent(new page.Event("change", { bubbles: true })); await settled();
seen.typed = drawing.good && drawing.text.includes("# by hand");
page.dispatchEvent(new page.KeyboardEvent("keydown", { key: "z", ctrlKey: true, bubbles: true })); await settled();
seen.undone = drawing.text.includes("furlong");
// A failure of the program itself is told, and it goes on.
const failure = await draw.front.ask("front_nothing", ""), after = await draw.front.json("front_look", before);
seen.failure = failure.failed && new page.TextDecoder().decode(failure.bytes).includes("report it") && after.good;
// The address holds the scene.
draw.edit(before, ""); await settled();
const address = await draw.shareAddress(), packed = new URLSearchParams(address.split("#")[1]).get("scene");
const bytes = page.Uint8Array.from(page.atob(packed.replaceAll("-", "+").replaceAll("_", "/")), letter => letter.charCodeAt(0));
seen.address = await new page.Response(new page.Blob([bytes]).stream().pipeThrough(new page.DecompressionStream("deflate"))).text() === before;
return seen;
