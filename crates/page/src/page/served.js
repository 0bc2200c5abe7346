// A page that this machine serves has its front end and its solver there: each call is a request, through the few calls that the modules for browsers have.
(() => {
  const address = name => new URL(`call/${name}`, location.href.split("#")[0]).href, gone = () => new Error("the program that serves this page has ended: start it again, and open the address that it prints");
  const read = (status, text) => { if (status === 200) return JSON.parse(text); let why = ""; try { why = JSON.parse(text).faults[0].message; } catch { /* nothing is told */ } throw new Error(why || `the program that serves this page has answered ${status}`); };
  window.cotreeSolver = {
    served: true,
    /** The page waits for the answer: for what a picture needs. */
    now(name, question) {
      const request = new XMLHttpRequest();
      request.open("POST", address(name), false);
      try { request.send(JSON.stringify(question)); } catch { throw gone(); }
      return read(request.status, request.responseText);
    },
    /** The bytes of an answer, and whether they say what is wrong. */
    async bytes(name, body) {
      const answer = await fetch(address(name), { method: "POST", body }).catch(() => { throw gone(); });
      if (answer.status !== 200 && answer.status !== 422) throw new Error(`the program that serves this page has answered ${answer.status}`);
      return { failed: answer.status === 422, bytes: new Uint8Array(await answer.arrayBuffer()) };
    },
    async later(name, body) { const { failed, bytes } = await this.bytes(name, body); return read(failed ? 422 : 200, new TextDecoder().decode(bytes)); },
  };
})();
