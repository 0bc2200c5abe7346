// @ts-check
// While the scene is watched: a new page as soon as the file is saved, with the time and the view of this one; and what is changed here goes into the file.
(() => {
  const KEY = "cotree-watch", page = window.cotree, touch = page?.MODEL.touch;
  /** The version of this page; the text that the file had when it was read or written here; the texts of which the server has not said yet that they are there. */
  const file = { good: null, text: touch?.text ?? null, own: [], writing: false, waiting: false, apart: false, news: false };
  const notice = document.getElementById("notice");
  const lines = (id) => {
    const made = Object.assign(document.createElement("p"), { id, className: "notice plain lines", hidden: true });
    notice.after(made);
    return made;
  };
  const warnings = lines("warnings"), conflict = lines("conflict");
  warnings.title = "click: away with it";
  warnings.addEventListener("click", () => {
    warnings.hidden = true;
  });
  const keep = () => {
    if (!page) return;
    const kept = page.keep();
    // What is in the file already need not be kept beside it.
    if (writes.checked && !file.apart && touch) Object.assign(kept, { values: [], pose: null });
    sessionStorage.setItem(KEY, JSON.stringify({ ...kept, apart: file.apart, writes: writes.checked }));
  };

  const writes = Object.assign(document.createElement("input"), { type: "checkbox", id: "writes", checked: true });
  if (touch) {
    const label = Object.assign(document.createElement("label"), {
      className: "link",
      title: "What is pulled and changed here is written into the scene's file",
    });
    label.append(writes, " into the file");
    document.getElementById("save").before(label);
    writes.addEventListener("change", write);
    addEventListener("cotree-changed", write);
  }
  const button = (text, call) => {
    const made = Object.assign(document.createElement("button"), { type: "button", className: "link", textContent: text });
    made.addEventListener("click", call);
    return made;
  };
  /** Says that the file and the page have gone apart, and what can be done. */
  function tellApart(why) {
    file.apart = true;
    conflict.replaceChildren(
      `${why}: what you changed here is shown, but is not in the file.\n`,
      button("Write it into the file", () => {
        file.apart = false;
        conflict.hidden = true;
        write();
      }),
      "   ",
      button("Take what the file has", () => {
        sessionStorage.setItem(KEY, JSON.stringify({ ...page.keep(), values: [], pose: null, writes: writes.checked }));
        location.reload();
      }),
    );
    conflict.hidden = false;
  }
  /** Writes the text as it is now; of several changes meanwhile the last. */
  async function write() {
    if (!writes.checked || file.apart || !page) return;
    if (file.writing) {
      file.waiting = true;
      return;
    }
    let text;
    try {
      text = page.sceneText();
    } catch (fault) {
      tellApart(fault.message);
      return;
    }
    if (text === file.text) return;
    const before = file.text;
    Object.assign(file, { writing: true, waiting: false, text });
    file.own.push(text);
    const answer = await fetch("scene", { method: "POST", body: JSON.stringify({ before, after: text }) }).catch((fault) => ({
      ok: false,
      status: 0,
      text: () => Promise.resolve(fault.message),
    }));
    file.writing = false;
    if (!answer.ok) {
      Object.assign(file, { text: before, own: file.own.filter((own) => own !== text) });
      tellApart(answer.status === 409 ? "Another program has saved the file meanwhile" : `The file cannot be written (${await answer.text()})`);
      // The next page has the text of the file, and the values of this one over it.
      if (answer.status === 409 && file.news) {
        keep();
        location.reload();
      }
    } else if (file.waiting) write();
  }

  new EventSource("events").onmessage = ({ data }) => {
    const news = JSON.parse(data);
    const own = file.own.lastIndexOf(news.text), isOther = touch && news.text !== file.text && news.good > 0;
    if (own >= 0) file.own.splice(0, own + 1);
    else if (file.good === null ? isOther : news.good !== file.good) file.news = true;
    if (file.news && !file.writing) {
      keep();
      location.reload();
      return;
    }
    if (file.good === null && !page && news.good > 0) {
      location.reload();
      return;
    }
    file.good = news.good;
    // What the run has to say stays, unless there is a fault now, or was one.
    if (news.fault || notice.classList.contains("lines")) {
      notice.hidden = !news.fault;
      notice.textContent = news.fault ?? "";
      notice.classList.toggle("lines", Boolean(news.fault));
    }
    warnings.hidden = !news.warnings || Boolean(news.fault);
    warnings.textContent = news.warnings ?? "";
  };
  const kept = JSON.parse(sessionStorage.getItem(KEY));
  sessionStorage.removeItem(KEY);
  if (!kept || !page) return;
  writes.checked = kept.writes ?? true;
  if (kept.apart) tellApart("Another program has saved the file meanwhile");
  const wait = () => document.documentElement.dataset.ready ? page.restore(kept) : setTimeout(wait, 20);
  wait();
})();
