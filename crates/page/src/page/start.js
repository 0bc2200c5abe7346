// @ts-check

import { inUnits, MODEL } from "./data.js";
import { PATIENCE } from "./worker.js";
import { pose } from "./figure.js";
import { heads, paths, pointed } from "./marks.js";
import { fit, foundLines, knobs, pause, play, resetSliders, seek, transport, zoom } from "./controls.js";
import { touching } from "./touch.js";
import { adoptAddress, history, picturePng, pictureSvg, sceneText, shareAddress, tableCsv } from "./edit.js";
import { begin, keep, open, restore, state, tell } from "./main.js";
begin().then(open).catch((fault) => {
  tell(fault.message);
  document.documentElement.dataset.ready = "no";
});
// For tests, and for whoever wants to look closer in the browser's console.
window.cotree = {
  MODEL,
  state,
  pose,
  knobs,
  transport,
  seek,
  play,
  pause,
  resetSliders,
  zoom,
  fit,
  keep,
  restore,
  foundLines,
  sceneText,
  shareAddress,
  adoptAddress,
  tableCsv,
  pictureSvg,
  picturePng,
  history,
  touching,
  inUnits,
  heads,
  PATIENCE,
  traced: () => paths.length,
  pointed: () => pointed,
};
