// The mechanism: built once from the geometry, moved by transforms in every frame. Lengths of symbols are multiples of a pin.
const SVG = "http://www.w3.org/2000/svg", DEGREES = 180 / Math.PI, S = G.scale, PIN = G.pin;
const round = value => Math.round(value * 100) / 100;
const pixel = ([x, y]) => [S * x, -S * y];
const add = ([a, b], s, [c, d]) => [a + s * c, b + s * d];
const minus = ([a, b], [c, d]) => [a - c, b - d];
const unit = ([a, b]) => { const l = Math.hypot(a, b); return l > 0 ? [a / l, b / l] : [1, 0]; };
const normal = ([a, b]) => [-b, a];
const line = points => "M" + points.map(([x, y]) => `${round(x)} ${round(y)}`).join("L");

function element(tag, attributes, parent, text) {
  const made = document.createElementNS(SVG, tag);
  for (const name in attributes) made.setAttribute(name, attributes[name]);
  if (text !== undefined) made.textContent = text;
  if (parent) parent.append(made);
  surface.stale = true;
  return made;
}

/** Where the bodies are at the present time: x, y, angle, and the angle's sine and cosine. */
const pose = G.bodies.map(({ start }) => [...start, Math.sin(start[2]), Math.cos(start[2])]);
/** Points of the bodies and of the ground: a parameter may move them, so every run gives its own. */
const forms = G.bodies.map(body => body.points.map(point => [...point]));
const turned = (body, [x, y]) => {
  if (body === null) return [x, y];
  const sine = pose[body][3], cosine = pose[body][4];
  return [cosine * x - sine * y, sine * x + cosine * y];
};
const local = anchor => anchor.moved ?? (anchor.point === null ? anchor.at : forms[anchor.body][anchor.point]);
const world = anchor => anchor.body === null ? local(anchor) : add(pose[anchor.body], 1, turned(anchor.body, local(anchor)));
const spot = anchor => pixel(world(anchor));

/** How much of the motion is drawn: masses on a line stand where there is room for them, so theirs may have to be made smaller. */
let gain = 1;
function chooseGain(run) {
  if (!MODEL.line) return;
  const places = G.bodies.map(body => body.start[0] + body.centre[0]), wide = Math.max(...places) - Math.min(...places);
  const far = Math.max(...G.bodies.map(body => Math.max(...run.columns.get(`${body.name}.x`).subarray(0, run.last + 1).map(x => Math.abs(x - body.start[0])))));
  const room = .4 * wide / Math.max(places.length - 1, 1);
  if (wide > 0 && far > room) gain = +(room / far).toPrecision(1);
}

/** The columns of the bodies in the run that was looked at last. */
const posed = { run: null, columns: [] };
function takePose(run, at) {
  if (posed.run !== run) {
    posed.run = run;
    posed.columns = G.bodies.map(({ name }) => ["x", "y", "angle"].map(word => run.columns.get(`${name}.${word}`)));
  }
  for (let index = 0; index < pose.length; index++) {
    const now = pose[index], { start } = G.bodies[index], columns = posed.columns[index];
    for (let axis = 0; axis < 3; axis++) now[axis] = columns[axis] ? start[axis] + gain * (smooth(run, columns[axis], at) - start[axis]) : start[axis];
    now[3] = Math.sin(now[2]); now[4] = Math.cos(now[2]);
  }
}

/** The convex hull, for outlines; of points in line, whatever their direction and their rounding errors, the two ends. */
function hull(points) {
  if (points.length < 2) return points;
  const sorted = points.slice().sort((a, b) => a[0] - b[0] || a[1] - b[1]);
  const cross = (a, b, p) => (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]), distance = (a, b) => Math.hypot(b[0] - a[0], b[1] - a[1]);
  const farthest = from => sorted.reduce((best, p) => distance(from, p) > distance(from, best) ? p : best);
  const end = farthest(sorted[0]), start = farthest(end), length = distance(start, end);
  if (length === 0) return [start];
  if (sorted.every(p => Math.abs(cross(start, end, p)) <= 1e-9 * length * length)) return [start, end];
  // Without a tolerance: along an upright side the order of the points is that of their rounding errors, and an end would be dropped.
  const half = list => {
    const out = [];
    for (const p of list) {
      while (out.length > 1 && cross(out.at(-2), out.at(-1), p) <= 0) out.pop();
      out.push(p);
    }
    return out;
  };
  return [...half(sorted).slice(0, -1), ...half(sorted.reverse()).slice(0, -1)];
}
const extent = points => Math.max(0, ...points.flatMap(a => points.map(b => Math.hypot(a[0] - b[0], a[1] - b[1]))));

/** What joins the points of a body, in its own pixels; its outline is that of its shape if it has one. */
const outline = index => G.bodies[index].rim.length ? G.bodies[index].rim.map(pixel) : bar(index);
function bar(index) {
  const corners = forms[index].map(pixel);
  if (G.bodies[index].cornered) corners.push(pixel(G.bodies[index].centre));
  return hull(corners);
}
const outlineData = points => points.length === 0 ? "" : points.length === 1 ? `${line(points)}l0 0` : points.length === 2 ? line(points) : `${line(points)}Z`;
/** The same with a margin: straight along the sides, round at the corners. */
function roundedData(points, r) {
  const corners = points.length === 1 ? [points[0], points[0]] : points, turn = corners.reduce((sum, [x, y], k) => { const [u, v] = corners[(k + 1) % corners.length]; return sum + x * v - u * y; }, 0) < 0 ? -1 : 1;
  const sides = corners.map((a, k) => { const b = corners[(k + 1) % corners.length], [x, y] = points.length === 1 ? [k ? -1 : 1, 0] : unit(minus(b, a)), off = [turn * r * y, -turn * r * x]; return [add(a, 1, off), add(b, 1, off)]; });
  const text = ([x, y]) => `${round(x)} ${round(y)}`;
  return sides.length ? `M${sides.map(([a, b], k) => `${k ? `A${round(r)} ${round(r)} 0 0 ${turn > 0 ? 1 : 0} ` : ""}${text(a)}L${text(b)}`).join("")}A${round(r)} ${round(r)} 0 0 ${turn > 0 ? 1 : 0} ${text(sides[0][0])}Z` : "";
}

const wheels = G.couplings.flatMap(c => [...(c.wheels ?? []), c.pinion, c.disc]).filter(Boolean);
const colours = body => body === null ? ["var(--ground)", "var(--ink)"] : [`var(--f${body % 8})`, `var(--e${body % 8})`];
/** What is done in every frame, and what after every run. */
const frames = [], renewals = [];
/** What lies outside of the document keeps its place as numbers. */
const move = (group, [x, y], angle) => group.isConnected ? group.setAttribute("transform", `translate(${round(x)} ${round(y)})${angle === undefined ? "" : ` rotate(${round(-angle * DEGREES)})`}`) : group.placed = [x, y, angle];
const carried = (group, body) => body !== null && frames.push(() => move(group, pixel(pose[body]), pose[body][2]));

/** A mass centre: a ring and two quarters of it. */
const markData = radius => {
  const r = radius * PIN, ring = (radius, way) => `M${radius} 0A${radius} ${radius} 0 0 ${way} ${-radius} 0A${radius} ${radius} 0 0 ${way} ${radius} 0Z`;
  return `${ring(r + .55, 1)}${ring(r - .55, 0)}M0 0V${-r}A${r} ${r} 0 0 1 ${r} 0ZM0 0V${r}A${r} ${r} 0 0 1 ${-r} 0Z`;
};

/** Few elements: each costs style, layout and painting in every frame. */
function drawBody(index) {
  const body = G.bodies[index], [fill, edge] = colours(index), group = element("g", { class: "body" }, $("bodies"));
  element("title", {}, group, body.name);
  if (body.barred) {
    const path = element("path", { style: `fill:${fill};stroke:${edge}`, "stroke-width": 1.3 }, group);
    renewals.push(() => {
      const points = bar(index), long = extent(points) > 2 * PIN, hidden = !long && body.block;
      path.setAttribute("d", hidden ? "" : roundedData(points, (long ? 1.45 : 2.5) * PIN + .65));
    });
  }
  if (body.rim.length) element("path", { d: outlineData(body.rim.map(pixel)), style: `fill:${fill};fill-opacity:.9;stroke:${edge}`, "stroke-width": 1.3 }, group);
  if (body.block) drawBlock(body.block, fill, edge);
  if (!body.covered) element("path", { class: "mark", d: markData(body.mark), style: `fill:${edge}`, transform: `translate(${pixel(body.centre).map(round)})` }, group);
  carried(group, index);
  group.addEventListener("pointerenter", () => pointAt(index));
  group.addEventListener("pointerleave", () => pointAt(null));
  return { group, index };
}

/** The mark of a mass centre that a joint covers: around it, over all bodies. */
function drawMark(index) {
  const { centre, mark } = G.bodies[index], path = element("path", { class: "around", d: markData(mark), style: `fill:${colours(index)[1]}` }, $("pins"));
  frames.push(() => move(path, spot({ body: index, at: centre, point: null }), pose[index][2]));
}

function drawBlock(block, fill, edge) {
  const group = element("g", {}, $("bodies")), long = 3.7 * PIN, high = 2.3 * PIN;
  element("rect", { x: -long, y: -high, width: 2 * long, height: 2 * high, rx: 1.5, style: `fill:${fill};stroke:${edge}`, "stroke-width": 1.4 }, group);
  frames.push(() => { const axis = turned(block.along, block.axis); move(group, spot(block.at), Math.atan2(axis[1], axis[0])); });
}

/** The ground: a line with hatching below it, from -half to half. */
function earth(parent, half) {
  let data = "";
  for (let x = -half + .9 * 1.15 * PIN; x < half; x += 1.15 * PIN) data += `M${round(x)} 0l${round(-1.2 * PIN)} ${round(1.2 * PIN)}`;
  element("path", { class: "hatch", d: data }, parent);
  element("path", { class: "earth", d: `M${round(-half)} 0H${round(half)}` }, parent);
}

function drawPedestal(anchor) {
  const group = element("g", {}, $("ground")), foot = 3.6 * PIN, r = 1.7 * PIN;
  element("path", { class: "pedestal", d: `M${-2.7 * PIN} ${foot}L${-r} 0A${r} ${r} 0 0 1 ${r} 0L${2.7 * PIN} ${foot}Z` }, group);
  earth(element("g", { transform: `translate(0 ${foot})` }, group), 4.2 * PIN);
  renewals.push(() => move(group, spot(anchor)));
}

/** A piece of ground whose free side looks along a direction of the world. */
function drawWall(anchor, outward) {
  const group = element("g", {}, $("ground"));
  earth(group, 2.6 * PIN);
  renewals.push(() => { const [x, y] = outward(); move(group, spot(anchor), Math.atan2(y, x) - Math.PI / 2); });
}

/** What a body slides on: the ground under it, or a bar of the first body; long enough for the whole run. */
function drawSlide(joint) {
  const [base, at] = joint.ends, moving = at.body === null ? base : at, slot = joint.hold === "slot";
  const [fill, edge] = colours(base.body), group = element("g", {}, $("slides"));
  const reach = () => {
    let [low, high] = [Infinity, -Infinity];
    eachPose(() => {
      const axis = turned(base.body, joint.axis), [x, y] = minus(world(moving), world(moving === at ? base : at));
      const s = (x * axis[0] + y * axis[1]) * S;
      [low, high] = [Math.min(low, s), Math.max(high, s)];
    });
    return [low, high];
  };
  renewals.push(() => {
    group.replaceChildren();
    const [low, high] = reach();
    if (!Number.isFinite(low)) return;
    if (slot || base.body !== null && at.body !== null) {
      const wide = slot ? 3.6 * PIN : 1.5 * PIN, ends = [Math.min(0, low) - (slot ? 3 * PIN : 0), Math.max(0, high) + (slot ? 3 : 7) * PIN];
      for (const [width, colour] of [[wide + 2.6, edge], [wide, fill]]) element("path", { d: `M${round(ends[0])} 0H${round(ends[1])}`, style: `stroke:${colour};stroke-linecap:round`, "stroke-width": round(width) }, group);
      if (slot) for (const [width, colour] of [[2 * PIN + 2.2, edge], [2 * PIN, "var(--card)"]]) element("path", { d: `M${round(low - 2 * PIN)} 0H${round(high + 2 * PIN)}`, style: `stroke:${colour};stroke-linecap:round`, "stroke-width": round(width) }, group);
    } else {
      const middle = (low + high) / 2, half = (high - low) / 2 + 6 * PIN, flip = joint.axis[0] < -1e-9 || (Math.abs(joint.axis[0]) <= 1e-9 && joint.axis[1] < 0);
      earth(element("g", { transform: `translate(${round(middle)} ${round((flip ? -1 : 1) * (2.3 * PIN + 1.5))})${flip ? " rotate(180)" : ""}` }, group), half);
    }
  });
  const carrier = base.body === null || at.body !== null ? base : at;
  frames.push(() => { const axis = turned(base.body, joint.axis); move(group, spot(carrier), Math.atan2(axis[1], axis[0])); });
}

function drawJoint(joint) {
  const moving = joint.ends[1].body === null ? joint.ends[0] : joint.ends[1], grounded = joint.ends.some(end => end.body === null);
  if (grounded && joint.hold === "pin") drawPedestal(moving);
  if (grounded && joint.hold === "fixed") drawWall(moving, () => [0, 1]);
  if (joint.axis) drawSlide(joint);
  if (joint.hold === "slider") return;
  joints.push({ name: joint.name, anchor: moving });
  if (joint.hold !== "fixed") { pins.push(moving); return; }
  const weld = element("rect", { class: "weld", x: -.8 * PIN, y: -.8 * PIN, width: 1.6 * PIN, height: 1.6 * PIN }, $("pins"));
  frames.push(() => move(weld, spot(moving)));
}

/** Joints that can be pointed at, and where pins are drawn: all of them with three paths, each pin a point with a round end. */
const joints = [], pins = [];
function drawPins() {
  if (!pins.length) return;
  const paths = [["pin-edge", 1.7 * PIN + 1.7], ["pin", 1.7 * PIN - 1.7], ["pin-edge", .4 * PIN]].map(([kind, width]) => element("path", { class: kind, "stroke-width": round(width) }, $("pins")));
  frames.push(() => {
    let data = "";
    // A canvas has them as pictures.
    for (const pin of crowded && !printing ? [] : pins) { const [x, y] = spot(pin); data += `M${round(x)} ${round(y)}h.01`; }
    for (const path of paths) draw(path, data);
  });
}
/** The joint next to a place in the drawing, if it is near enough to be meant. */
function jointAt(place) {
  let [nearest, least] = [null, Math.max(1.2 * PIN, 7 * size)];
  for (const joint of joints) { const far = Math.hypot(...minus(spot(joint.anchor), place)); if (far < least) [nearest, least] = [joint, far]; }
  return nearest;
}

function drawSpring(spring) {
  const group = element("g", {}, $("springs")), paths = [];
  element("title", {}, group, spring.name);
  for (const kind of ["halo", "spring"]) for (const stroke of spring.strokes) paths.push([element("path", { class: kind + (stroke.closed ? " closed" : "") }, group), stroke]);
  spring.ends.forEach((end, side) => end.body === null && drawWall(end, () => unit(minus(world(spring.ends[1 - side]), world(end)))));
  frames.push(() => {
    const [a, b] = spring.ends.map(spot), axis = unit(minus(b, a)), full = Math.hypot(...minus(b, a));
    const from = Math.min(S * spring.retreat[0], .3 * full), to = Math.min(S * spring.retreat[1], .3 * full), length = (full - from - to) / PIN;
    const begin = add(a, from, axis), side = normal(axis);
    for (const [path, stroke] of paths) {
      const points = stroke.points.map(([x, y, slope]) => {
        const along = Math.min(Math.max(x + slope * (length - spring.length), 0), length);
        return add(add(begin, along * PIN, axis), y * PIN, side);
      });
      path.setAttribute("d", line(points) + (stroke.closed ? "Z" : ""));
    }
  });
}

/** A wheel in its body's axes, with teeth if it has any. */
function drawWheel(wheel, spoke) {
  const { body } = wheel.centre, [fill, edge] = colours(body), r = S * wheel.radius, style = `fill:${fill};fill-opacity:.75;stroke:${edge};stroke-width:1.3`;
  const group = element("g", {}, $("couplings")), { teeth } = wheel;
  if (teeth) {
    const side = teeth.inside ? -1 : 1, height = 1.8 * r / teeth.count, tip = r + side * height, root = r - 1.1 * side * height, corners = [];
    for (let k = 0; k < teeth.count; k++) for (const [share, reach] of [[-.33, root], [-.15, tip], [.15, tip], [.33, root]]) {
      const angle = teeth.phase + 2 * Math.PI * (k + share) / teeth.count;
      corners.push([reach * Math.cos(angle), -reach * Math.sin(angle)]);
    }
    const rim = r + 2.2 * height, ring = teeth.inside ? `M${-rim} 0A${rim} ${rim} 0 1 0 ${rim} 0A${rim} ${rim} 0 1 0 ${-rim} 0Z` : "";
    element("path", { d: `${line(corners)}Z${ring}`, "fill-rule": "evenodd", "stroke-linejoin": "round", style }, group);
    element("circle", { class: "pitch", r, style: `stroke:${edge}` }, group);
  } else element("circle", { r, style }, group);
  if (spoke) element("path", { d: `M0 0H${r}`, style: `stroke:${edge}`, "stroke-width": 1.6 }, group);
  frames.push(() => move(group, spot(wheel.centre), body === null ? 0 : pose[body][2]));
}

function drawBand({ wheels, crossed }) {
  wheels.forEach(wheel => drawWheel(wheel, true));
  const lines = [1, -1].map(side => [side, element("path", { class: "band" }, $("couplings"))]);
  frames.push(() => {
    const [a, b] = wheels.map(wheel => spot(wheel.centre)), [first, second] = wheels.map(wheel => S * wheel.radius);
    const opposite = crossed ? -second : second, axis = unit(minus(b, a)), cosine = (first - opposite) / Math.hypot(...minus(b, a));
    const sine = Math.sqrt(Math.max(0, 1 - cosine * cosine));
    for (const [side, path] of lines) {
      const touch = (centre, radius) => add(add(centre, radius * cosine, axis), side * radius * sine, normal(axis));
      path.setAttribute("d", line([touch(a, first), touch(b, opposite)]));
    }
  });
}

/** A toothed bar in the axes of its body, long enough for the whole run. */
function drawRack({ pinion, bar, foot }) {
  const [fill, edge] = colours(bar.body), group = element("g", {}, $("couplings")), path = element("path", { style: `fill:${fill};stroke:${edge}`, "stroke-width": 1.3, "stroke-linejoin": "round" }, group);
  const height = 1.8 * S * Math.abs(pinion.radius) / pinion.teeth.count, pitch = 2 * Math.PI * S * Math.abs(pinion.radius) / pinion.teeth.count;
  const down = unit([foot[0], -foot[1]]), axis = normal(down);
  renewals.push(() => {
    let [low, high, first] = [0, 0, null], deep = 0;
    eachPose(() => {
      const contact = add(world(pinion.centre), 1, turned(bar.body, foot)), away = minus(contact, world(bar));
      const back = bar.body === null ? away : turnedBack(bar.body, away), [x, y] = pixel(back), s = x * axis[0] + y * axis[1];
      if (first === null) { first = s; deep = x * down[0] + y * down[1]; }
      [low, high] = [Math.min(low, s), Math.max(high, s)];
    });
    if (first === null) return;
    const reach = .15 * pinion.teeth.count * pitch, at = (along, below) => add(add(pixel(local(bar)), along, axis), deep + below, down);
    const from = Math.floor((low - reach - first) / pitch), to = Math.ceil((high + reach - first) / pitch), corners = [at(first + to * pitch, 4 * height), at(first + from * pitch, 4 * height)];
    for (let gap = from; gap < to; gap++) for (const [share, below] of [[.17, height], [.35, -height], [.65, -height], [.83, height]]) corners.push(at(first + (gap + share) * pitch, below));
    path.setAttribute("d", `${line(corners)}Z`);
  });
  carried(group, bar.body);
  drawWheel(pinion);
}
const turnedBack = (body, [x, y]) => { const s = pose[body][3], c = pose[body][4]; return [c * x + s * y, c * y - s * x]; };

function drawRolling({ disc, base, axis }) {
  const group = element("g", {}, $("couplings")), [fill, edge] = colours(base.body);
  renewals.push(() => {
    let [low, high] = [0, 0];
    eachPose(() => { const u = turned(base.body, axis), [x, y] = minus(world(disc.centre), world(base)), s = S * (x * u[0] + y * u[1]); [low, high] = [Math.min(low, s), Math.max(high, s)]; });
    group.replaceChildren();
    const beyond = Math.max(S * disc.radius, 6 * PIN), half = (high - low) / 2 + beyond, middle = (high + low) / 2;
    if (base.body === null) earth(element("g", { transform: `translate(${round(middle)} 0)` }, group), half);
    else for (const [width, colour] of [[1.5 * PIN + 2.6, edge], [1.5 * PIN, fill]]) element("path", { d: `M${round(middle - half)} ${.75 * PIN + 1.3}H${round(middle + half)}`, style: `stroke:${colour};stroke-linecap:round`, "stroke-width": round(width) }, group);
  });
  frames.push(() => { const u = turned(base.body, axis); move(group, spot(base), Math.atan2(u[1], u[0])); });
  drawWheel(disc, true);
}

/** A profile in the cam's axes, and the roller or the face of its follower. */
function drawCam({ wheels: [hub, roller], rim, face }) {
  const { body } = hub.centre, [fill, edge] = colours(body), group = element("g", {}, $("couplings"));
  element("path", { d: `${line(rim.map(pixel))}Z`, style: `fill:${fill};fill-opacity:.75;stroke:${edge}`, "stroke-width": 1.3, "stroke-linejoin": "round" }, group);
  carried(group, body);
  if (roller) drawWheel(roller, true);
  if (!face) return;
  const path = element("path", { style: `stroke:${colours(face[0].body)[1]};stroke-linecap:round`, "stroke-width": 3.2 }, $("couplings"));
  frames.push(() => path.setAttribute("d", line(face.map(spot))));
}

function drawLink({ ends }) {
  const bars = [["var(--ink)", .9 * PIN + 2], ["var(--card)", .9 * PIN]].map(([colour, width]) => element("path", { style: `stroke:${colour}`, "stroke-width": width }, $("pins")));
  for (const end of ends) { if (end.body === null) drawPedestal(end); pins.push(end); }
  frames.push(() => { const data = line(ends.map(spot)); bars.forEach(bar => bar.setAttribute("d", data)); });
}

/** Everything, from back to front. */
function drawMechanism() {
  for (const coupling of G.couplings) ({ gears: c => [...c.wheels].sort((a, b) => b.radius - a.radius).forEach(wheel => drawWheel(wheel)), band: drawBand, rack: drawRack, rolling: drawRolling, link: drawLink, cam: drawCam })[coupling.kind](coupling);
  const bodies = G.order.map(drawBody);
  G.springs.forEach(drawSpring);
  G.order.filter(index => G.bodies[index].covered).sort((a, b) => G.bodies[b].mark - G.bodies[a].mark).forEach(drawMark);
  G.joints.forEach(drawJoint);
  drawPins();
  return bodies;
}
