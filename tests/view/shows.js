const { MODEL, state } = cotree;
cotree.pause();
for (const layer of ["velocities", "ghosts"]) page.document.querySelector(`[data-layer=${layer}]`).click();
const odd = [], covered = [], outside = [];
const stage = $("scene").getBoundingClientRect();
for (const part of [0, .3, .77, 1]) {
  cotree.seek(part * MODEL.experiment.stop);
  const texts = [...page.document.querySelectorAll("#scene .name:not(.hide), #scene .value")].filter(text => text.textContent).map(text => [text.textContent, text.getBoundingClientRect()]);
  texts.forEach(([one, a], k) => texts.slice(0, k).forEach(([other, b]) => { if (a.x < b.x + b.width && b.x < a.x + a.width && a.y + .2 * a.height < b.y + .8 * b.height && b.y + .2 * b.height < a.y + .8 * a.height) covered.push(`${one} and ${other} at ${state.time}`); }));
  for (const path of page.document.querySelectorAll(`:is(#bodies .body, #couplings, #ground) path:not([d=""])`)) for (let k = 0; k < 40; k++) {
    const { x, y } = path.getPointAtLength(k / 40 * path.getTotalLength()).matrixTransform(path.getScreenCTM());
    if (x < stage.left || y < stage.top || x > stage.right || y > stage.bottom) outside.push(`${x}, ${y} at ${state.time}`);
  }
  for (const element of page.document.querySelectorAll("#scene *")) for (const { name, value } of element.attributes) if (/NaN|undefined|Infinity/.test(value)) odd.push(`${element.tagName}.${name} at ${state.time}`);
}
return { outside: outside.slice(0, 5), odd: odd.slice(0, 5), covered: covered.slice(0, 5), bodies: page.document.querySelectorAll("#bodies .body").length === MODEL.geometry.bodies.length };
