// @ts-check
// A page that this machine serves has its front end and its solver there: each call is a request, through the few calls that the modules for browsers have. A page in a file or in a
// frame names the server.
(() => {
  const server = window.cotreeServer ?? location.href.split("#")[0],
    address = (name) => new URL(`call/${name}`, server).href,
    gone = () => new Error("the program that serves this page has ended: start it again, and open the address that it prints");
  const read = (failed, text) => {
    const answer = JSON.parse(text);
    if (failed) throw new Error(answer.faults[0].message);
    return answer;
  };
  const check = (status) => {
    if (status !== 200) throw new Error(`the program that serves this page has answered ${status}`);
  };
  /** The page waits for the answer: for what a picture needs, and while it opens. */
  const atOnce = (name, body) => {
    const request = new XMLHttpRequest();
    request.open("POST", address(name), false);
    request.overrideMimeType("text/plain; charset=x-user-defined");
    try {
      request.send(body);
    } catch {
      throw gone();
    }
    check(request.status);
    return {
      failed: request.getResponseHeader("Cotree-Failed") !== null,
      bytes: Uint8Array.from(request.responseText, (letter) => letter.charCodeAt(0) & 255),
    };
  };
  const told = ({ failed, bytes }) => read(failed, new TextDecoder().decode(bytes));
  window.cotreeSolver = {
    served: true,
    now(name, question) {
      return told(atOnce(name, JSON.stringify(question)));
    },
    /** The bytes of an answer, and whether they say what is wrong. */
    async bytes(name, body) {
      if (document.readyState === "loading") return atOnce(name, body);
      const answer = await fetch(address(name), { method: "POST", body }).catch(() => {
        throw gone();
      });
      check(answer.status);
      return { failed: answer.headers.has("Cotree-Failed"), bytes: new Uint8Array(await answer.arrayBuffer()) };
    },
    async later(name, body) {
      return told(await this.bytes(name, body));
    },
  };
})();
