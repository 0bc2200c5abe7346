const { state } = cotree;
cotree.pause();
const at = time => {
  cotree.seek(time);
  const seen = selector => [...page.document.querySelectorAll(selector)].filter(node => !node.classList.contains("hide")).length;
  return { rings: seen("#held > g > g"), stars: seen("#held .star"), names: [...page.document.querySelectorAll("#held .name")].map(text => text.textContent).filter(Boolean), at: state.time };
};
return { looks: TIMES.map(at), legend: $("held-legend").hidden ? "" : $("held-legend").textContent };
