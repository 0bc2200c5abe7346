const models = await draw.front.json("front_gallery", ""), bad = [];
for (const { name, text } of models) { const look = await draw.front.json("front_look", text); if (!look.good) bad.push([name, look.faults]); }
// A coordinate that is an expression is not moved, and that is said; a plain number is, and nothing else of the text changes.
const wiper = models.find(({ name }) => name === "four_bar").text;
draw.edit(wiper, ""); await settled();
use("move");
const pin = draw.points().find(({ owner, name }) => owner === "crank" && name === "pin").at;
await drag(pin, [pin[0] + .05, pin[1]]);
const refused = $("said").textContent.includes("not written as a plain number") && drawing.text === wiper;
const plain = 'name = "swing" # kept\n[ground.points]\no = [0, 0]   # kept too\n[bodies.bob]\nmass = 1\ninertia = 0.1\npoints = { top = [0, "300 mm"], eye = [0.1, 0.1], low = [0, 0] }\n[joints.o]\ntype = "revolute"\nbetween = ["ground.o", "bob.top"]\n';
draw.edit(plain, ""); await settled();
const eye = draw.points().find(({ name }) => name === "eye").at, goal = [eye[0] + .04, eye[1] - .03];
$("snap").click();
await drag(eye, goal);
const now = draw.points().find(({ name }) => name === "eye").at, text = drawing.text;
return { count: models.length, bad, refused, near: Math.hypot(now[0] - goal[0], now[1] - goal[1]) < 2e-3, text, plain };
