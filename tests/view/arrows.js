cotree.pause();
const { run } = cotree.state, [x, y, wide, high] = $("scene").getAttribute("viewBox").split(" ").map(Number);
const arrows = () => page.document.querySelector("#forces .arrow").getBBox(), texts = () => [...page.document.querySelectorAll("#forces .value")].filter(text => text.textContent);
let left = 0, covered = 0, shown = 0;
for (let k = 0; k <= run.last; k++) {
  cotree.seek(run.times[k]);
  const box = arrows();
  if (box.x < x || box.y < y || box.x + box.width > x + wide || box.y + box.height > y + high) left++;
  for (const text of texts()) {
    shown++;
    const { width, height } = text.getBBox(), [u, v] = text.getAttribute("transform").match(/[-\d.]+/g).map(Number);
    // A third of a head's width may touch the margin of a text.
    if (cotree.heads.some(([a, b, w, h]) => Math.abs(a - u) < width / 2 + w / 3 && Math.abs(b - v) < height / 2 + h / 3)) covered++;
  }
}
const scale = $("force-text").textContent, values = texts().map(text => text.textContent), told = cotree.inUnits("at t = 0.5 s it is 3 N above 2 m, rod 2 stays");
const [knob] = cotree.knobs, found = knob ? null : (() => {
  const place = name => cotree.MODEL.variables.findIndex(variable => variable.name === name);
  cotree.knobs.push({ index: place("length"), start: .5, value: .75 }, { index: place("still"), start: 1, value: 1 });
  const lines = cotree.foundLines();
  cotree.knobs.length = 0;
  return lines;
})();
return { left, covered, shown, scale, values, told, found };
