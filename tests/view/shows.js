const { MODEL, state } = cotree;
cotree.pause();
for (const layer of ["velocities", "ghosts"]) page.document.querySelector(`[data-layer=${layer}]`).click();
const odd = [];
for (const part of [0, .3, .77, 1]) {
  cotree.seek(part * MODEL.experiment.stop);
  for (const element of page.document.querySelectorAll("#scene *")) for (const { name, value } of element.attributes) if (/NaN|undefined|Infinity/.test(value)) odd.push(`${element.tagName}.${name} at ${state.time}`);
}
return { odd: odd.slice(0, 5), bodies: page.document.querySelectorAll("#bodies .body").length === MODEL.geometry.bodies.length };
