const outlines = [...page.document.querySelectorAll("#bodies .body")].map(body => body.querySelector("path:not(.mark)").getTotalLength());
const longest = Math.max(...outlines);
return { looked: outlines.length, short: outlines.map((length, bar) => `${bar}: ${length} of ${longest}`).filter((_, bar) => outlines[bar] < .99 * longest) };
