cotree.pause();
const { run } = cotree.state, bits = value => { const view = new DataView(new ArrayBuffer(8)); view.setFloat64(0, value); return view.getBigUint64(0).toString(16); };
const columns = { time: Array.from(run.times, bits) };
for (const name of cotree.MODEL.outputs) columns[name] = Array.from(run.columns.get(name), bits);
return { columns };
