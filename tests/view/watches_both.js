const until = async done => { for (let k = 0; k < 1500 && !done(); k++) await wait(20); return Boolean(done()); };
const now = () => frame.contentWindow, its = id => now().document.getElementById(id), ready = () => now().document.documentElement?.dataset.ready === "yes" && now().cotree;
const says = text => ready() && now().document.querySelector("header").textContent.includes(text);
const set = value => { now().cotree.pause(); now().cotree.PATIENCE.ms = Infinity; now().cotree.adoptAddress(JSON.stringify([[["rod_length", value]]])); };
const length = () => now().cotree.knobs.find(({ name }) => name === "rod_length");
const seen = {};
// What is changed in the page goes into the file, and the page stays as it is.
page.stays = true;
set(1.25);
await until(() => length().value === 1.25);
await wait(600);
await fetch("/edit/1");
seen.stays = now().stays === true;
// Undone: the file is as it was.
its("undo").click();
await wait(600);
await fetch("/edit/2");
// An editor saves: the page follows.
await fetch("/edit/3");
seen.followed = await until(() => says("mended"));
// Both at once: the editor saves before the page can write.
const real = now().fetch.bind(now());
now().fetch = async (...all) => { await fetch("/edit/4"); return real(...all); };
set(1.5);
seen.told = await until(() => says("again") && its("conflict") && !its("conflict").hidden);
seen.kept = await until(() => length()?.value === 1.5);
await fetch("/edit/5");
its("conflict").querySelector("button").click();
await wait(600);
await fetch("/edit/6");
seen.quiet = its("conflict").hidden;
// Switched off, nothing is written.
its("writes").click();
set(1.75);
await wait(400);
await fetch("/edit/6");
return seen;
