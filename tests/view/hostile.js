await wait(200);
return { ready: page.document.documentElement.dataset.ready, hacked: window.hacked !== undefined, text: page.document.querySelector("header p").textContent };
