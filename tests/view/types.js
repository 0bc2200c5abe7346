cotree.pause();
cotree.PATIENCE.ms = Infinity;
const { state, knobs, MODEL } = cotree, frame = () => new Promise(done => page.requestAnimationFrame(() => page.requestAnimationFrame(done)));
const place = name => MODEL.variables.findIndex(variable => variable.name === name), slider = $(`set-${place("pole_length")}`), knob = knobs.find(({ index }) => index === place("pole_length"));
const box = slider.closest(".slider"), typed = box.querySelector(".typed"), spoken = slider.getAttribute("aria-valuetext"), unit = box.querySelector("output").textContent;
const type = async text => { typed.focus(); typed.value = text; typed.dispatchEvent(new page.Event("change")); typed.blur(); await frame(); };
const first = Array.from(state.run.columns.get("pole.angle")).join(), same = () => Array.from(state.run.columns.get("pole.angle")).join() === first;
const end = +slider.max;
await type("2500 mm");
const beyond = end < 2.5 && knob.value === 2.5 && +slider.max === 2.5 && slider.getAttribute("aria-valuetext"), answered = !same();
await type("1,5e3");
const comma = knob.value;
const faults = [];
for (const text of ["-3", "long", ""]) { await type(text); faults.push($("notice").textContent); }
const kept = knob.value === comma && typed.value === "1500";
const speed = cotree.transport.speed;
typed.dispatchEvent(new page.KeyboardEvent("keydown", { key: "]", bubbles: true }));
const quiet = cotree.transport.speed === speed;
return { force: MODEL.variables[place("rail.fn")].display?.name, spoken, unit, beyond, answered, comma, faults, kept, quiet, push: box.parentElement.querySelector(`[for=set-${place("push")}]`).textContent };
