#!/usr/bin/env python3
"""Frames a second of a page of `cotree view` while it plays, and what a frame costs, in headless Chromium by its DevTools protocol.

    tools/frames.py page.html [--seconds 5] [--trace] [--size 1360x800] [--all] [--pull BODY | --change POINT]

Without other programs beside it: the numbers are those of this machine at this time.
"""

import argparse
import collections
import json
import os
import pathlib
import shutil
import subprocess
import tempfile

READY = """new Promise(done => {
  const { dataset } = document.documentElement, look = () => dataset.ready ? done(dataset.ready) : setTimeout(look, 50);
  look();
})"""
PLAYING = """new Promise(done => {
  const stamps = [], begin = performance.now();
  cotree.play();
  const look = now => { stamps.push(now); now - begin < %d ? requestAnimationFrame(look) : done(stamps); };
  requestAnimationFrame(look);
})"""

# A pointer goes round in circles, one step a picture: it pulls a body, or moves the handle of a point.
DRAGGING = """new Promise(done => {
  const body = %s, point = %s, stage = document.getElementById("stage"), { pose, touching, MODEL } = cotree, { scale, bodies } = MODEL.geometry;
  cotree.pause();
  cotree.seek(0);
  document.querySelector(`[data-mode-of=${point ? "change" : "pull"}]`).click();
  const index = bodies.findIndex(({ name }) => name === body), handle = touching.handles.find(({ name }) => name === point)?.button;
  if (!(point ? handle : bodies[index])) { done(`there is none; there are ${point ? touching.handles.map(({ name }) => name) : bodies.map(({ name }) => name)}`); return; }
  const target = point ? handle : stage, rectangle = handle?.getBoundingClientRect();
  const middle = rectangle ? [rectangle.x + rectangle.width / 2, rectangle.y + rectangle.height / 2] : (({ x, y }) => [x, y])(new DOMPoint(scale * pose[index][0], -scale * pose[index][1]).matrixTransform(document.getElementById("scene").getScreenCTM()));
  const send = (kind, [u, v]) => target.dispatchEvent(new PointerEvent(kind, { pointerId: 5, clientX: middle[0] + u, clientY: middle[1] + v, bubbles: true }));
  target.setPointerCapture = () => {};
  const stamps = [], begin = performance.now();
  send("pointerdown", [0, 0]);
  const look = now => {
    stamps.push(now);
    const angle = 3 * (now - begin) / 1000;
    if (now - begin < %d) { send("pointermove", [14 * Math.sin(angle), 14 * (1 - Math.cos(angle))]); requestAnimationFrame(look); }
    else { send("pointerup", [0, 0]); requestAnimationFrame(() => done(stamps)); }
  };
  requestAnimationFrame(look);
})"""


class Browser:
    """Chromium with the protocol on a pair of pipes: messages end with a zero byte."""

    def __init__(self, folder, width, height):
        to_read, self.to_write = os.pipe()
        self.to_hear, to_answer = os.pipe()
        program = next(filter(None, map(shutil.which, ["chromium", "chromium-browser", "google-chrome"])), None)
        if program is None:
            raise SystemExit("there is no Chromium (apt-get install chromium)")
        flags = ["--headless", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--no-first-run"]
        flags += ["--disable-background-networking", "--remote-debugging-pipe", f"--window-size={width},{height}"]
        script = 'exec 3<&"$0" 4>&"$1"; shift; exec "$@"'
        command = ["bash", "-c", script, str(to_read), str(to_answer), program, *flags, f"--user-data-dir={folder}"]
        quiet = subprocess.DEVNULL
        self.child = subprocess.Popen(command, pass_fds=[to_read, to_answer], stdin=quiet, stdout=quiet, stderr=quiet)
        os.close(to_read)
        os.close(to_answer)
        self.number, self.rest, self.session, self.events = 0, b"", None, []

    def hear(self):
        pieces = [self.rest]
        while b"\0" not in pieces[-1]:
            pieces.append(os.read(self.to_hear, 1 << 20))
            if not pieces[-1]:
                raise SystemExit("Chromium has gone")
        message, self.rest = b"".join(pieces).split(b"\0", 1)
        return json.loads(message)

    def ask(self, method, **arguments):
        self.number += 1
        question = {"id": self.number, "method": method, "params": arguments}
        if self.session:
            question["sessionId"] = self.session
        os.write(self.to_write, json.dumps(question).encode() + b"\0")
        while True:
            answer = self.hear()
            if answer.get("id") == self.number:
                if "error" in answer:
                    raise SystemExit(f"{method}: {answer['error']['message']}")
                return answer["result"]
            self.events.append(answer)

    def wait_for(self, method):
        while True:
            for event in self.events:
                if event["method"] == method:
                    return event["params"]
            self.events.append(self.hear())

    def open(self, page):
        target = self.ask("Target.createTarget", url="about:blank")["targetId"]
        self.session = self.ask("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        self.ask("Performance.enable", timeDomain="threadTicks")
        self.ask("Page.enable")
        self.ask("Page.navigate", url=page.resolve().as_uri())
        self.wait_for("Page.loadEventFired")
        if self.run(READY) != "yes":
            raise SystemExit(f"{page}: the page is not ready: {self.run('document.getElementById(`notice`).textContent')}")

    def run(self, script):
        answer = self.ask("Runtime.evaluate", expression=script, awaitPromise=True, returnByValue=True)
        if "exceptionDetails" in answer:
            raise SystemExit(answer["exceptionDetails"])
        return answer["result"].get("value")

    def costs(self):
        return {metric["name"]: metric["value"] for metric in self.ask("Performance.getMetrics")["metrics"]}

    def trace(self, run):
        """What the threads did while that ran: summed durations [ms] by thread and name."""
        session, self.session = self.session, None
        categories = ["devtools.timeline", "cc", "viz", "disabled-by-default-devtools.timeline", "toplevel", "gpu", "benchmark"]
        self.ask("Tracing.start", transferMode="ReportEvents", traceConfig={"includedCategories": categories})
        self.session = session
        run()
        self.session = None
        self.ask("Tracing.end")
        self.wait_for("Tracing.tracingComplete")
        self.session = session
        events = [e for message in self.events if message["method"] == "Tracing.dataCollected" for e in message["params"]["value"]]
        threads = {(e["pid"], e["tid"]): e["args"]["name"] for e in events if e["name"] == "thread_name"}
        spent = collections.Counter()
        for event in events:
            if event.get("ph") == "X":
                spent[threads.get((event["pid"], event["tid"]), "?"), event["name"]] += event.get("tdur", 0) / 1e3
        return spent

    def close(self):
        self.child.terminate()
        self.child.wait()


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("page", type=pathlib.Path)
    parser.add_argument("--seconds", type=float, default=5)
    parser.add_argument("--size", default="1360x800")
    parser.add_argument("--all", action="store_true", help="with velocities and ghost poses too")
    parser.add_argument("--pull", metavar="BODY", help="while this body is pulled")
    parser.add_argument("--change", metavar="POINT", help="while this point is moved, such as ground.hinge")
    parser.add_argument("--trace", action="store_true", help="what the threads did")
    options = parser.parse_args()
    if not options.page.is_file():
        raise SystemExit(f"there is no page {options.page}")
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        browser = Browser(folder, *options.size.split("x"))
        try:
            look_at(browser, options)
        finally:
            browser.close()


def look_at(browser, options):
    browser.open(options.page)
    if options.all:
        browser.run("for (const layer of ['velocities', 'ghosts']) document.querySelector(`[data-layer=${layer}]`).click()")
    is_drag = options.pull or options.change
    ways = (json.dumps(options.pull), json.dumps(options.change))
    script = (lambda length: DRAGGING % (*ways, length)) if is_drag else (lambda length: PLAYING % length)
    stamps = browser.run(script(1000))
    if isinstance(stamps, str):
        raise SystemExit(stamps)
    before = browser.costs()
    stamps = browser.run(script(1000 * options.seconds))
    after = browser.costs()
    frames = len(stamps) - 1
    gaps = sorted(b - a for a, b in zip(stamps, stamps[1:]))
    print(f"{browser.run('cotree.MODEL.geometry.bodies.length')} bodies, {browser.run('document.querySelectorAll(`#scene *`).length')} elements")
    print(f"frames a second   {1000 * frames / (stamps[-1] - stamps[0]):.1f}")
    print(f"between frames    median {gaps[frames // 2]:.1f} ms, 95 % below {gaps[int(.95 * frames)]:.1f} ms, longest {gaps[-1]:.1f} ms")
    for name, metric in [("script", "ScriptDuration"), ("style", "RecalcStyleDuration"), ("layout", "LayoutDuration"), ("main thread", "TaskDuration")]:
        print(f"{name:<17} {1000 * (after[metric] - before[metric]) / frames:.2f} ms a frame")
    if options.trace:
        spent = browser.trace(lambda: browser.run(script(1000 * options.seconds)))
        for (thread, name), time in spent.most_common(40):
            print(f"{time / frames:8.2f} ms a frame  {thread}: {name}")


if __name__ == "__main__":
    main()
