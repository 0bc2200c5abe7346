begin().then(open).catch(fault => { tell(fault.message); document.documentElement.dataset.ready = "no"; });
// For tests, and for whoever wants to look closer in the browser's console.
window.cotree = { MODEL, state, pose, knobs, transport, seek, play, pause, resetSliders, zoom, fit, keep, restore, foundLines, sceneText, shareAddress, adoptAddress, tableCsv, pictureSvg, picturePng, history, touching, inUnits, heads, PATIENCE, traced: () => paths.length, pointed: () => pointed };
