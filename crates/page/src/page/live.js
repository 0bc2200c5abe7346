// While the scene is watched: a new page as soon as the file is saved, with the time, the view and the values of this one.
(() => {
  const KEY = "cotree-watch", page = window.cotree;
  let good = null;
  const keep = () => page && sessionStorage.setItem(KEY, JSON.stringify(page.keep()));
  const notice = document.getElementById("notice");
  const warnings = Object.assign(document.createElement("p"), { id: "warnings", className: "notice plain lines", title: "click: away with it", hidden: true });
  warnings.addEventListener("click", () => { warnings.hidden = true; });
  notice.after(warnings);
  new EventSource("/events").onmessage = ({ data }) => {
    const news = JSON.parse(data);
    if (good !== null && news.good !== good) { keep(); location.reload(); return; }
    if (good === null && !page && news.good > 0) { location.reload(); return; }
    good = news.good;
    // What the run has to say stays, unless there is a fault now, or was one.
    if (news.fault || notice.classList.contains("lines")) {
      notice.hidden = !news.fault;
      notice.textContent = news.fault ?? "";
      notice.classList.toggle("lines", Boolean(news.fault));
    }
    warnings.hidden = !news.warnings || Boolean(news.fault);
    warnings.textContent = news.warnings ?? "";
  };
  const kept = sessionStorage.getItem(KEY);
  sessionStorage.removeItem(KEY);
  if (!kept || !page) return;
  const wait = () => document.documentElement.dataset.ready ? page.restore(JSON.parse(kept)) : setTimeout(wait, 20);
  wait();
})();
