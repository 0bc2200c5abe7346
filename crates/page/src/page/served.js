// A page that this machine serves has its front end and its solver there: each call is a request, through the few calls that the modules for browsers have.
(() => {
  const address = name => new URL(`call/${name}`, location.href.split("#")[0]).href, gone = () => new Error("the program that serves this page has ended: start it again, and open the address that it prints");
  const read = (failed, text) => { const answer = JSON.parse(text); if (failed) throw new Error(answer.faults[0].message); return answer; };
  const check = status => { if (status !== 200) throw new Error(`the program that serves this page has answered ${status}`); };
  window.cotreeSolver = {
    served: true,
    /** The page waits for the answer: for what a picture needs. */
    now(name, question) {
      const request = new XMLHttpRequest();
      request.open("POST", address(name), false);
      try { request.send(JSON.stringify(question)); } catch { throw gone(); }
      check(request.status);
      return read(request.getResponseHeader("Cotree-Failed") !== null, request.responseText);
    },
    /** The bytes of an answer, and whether they say what is wrong. */
    async bytes(name, body) {
      const answer = await fetch(address(name), { method: "POST", body }).catch(() => { throw gone(); });
      check(answer.status);
      return { failed: answer.headers.has("Cotree-Failed"), bytes: new Uint8Array(await answer.arrayBuffer()) };
    },
    async later(name, body) { const { failed, bytes } = await this.bytes(name, body); return read(failed, new TextDecoder().decode(bytes)); },
  };
})();
