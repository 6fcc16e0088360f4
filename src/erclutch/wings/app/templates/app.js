"use strict";
// What a page cannot do alone: send a dropped file, follow a form while it is filled in and a command while it runs.

const base = document.body.dataset.base; // the session's own path
const drop = document.getElementById("drop");
if (drop) {
  const said = document.getElementById("upload");
  const send = file => {
    const request = new XMLHttpRequest();
    const failed = text => { said.textContent = text; said.className = "problem"; };
    request.open("PUT", `${base}/upload/${encodeURIComponent(file.name)}`);
    request.upload.onprogress = event => {
      said.className = "";
      said.textContent = `Copying ${file.name}: ${Math.floor(100 * event.loaded / Math.max(event.total, 1))} %`;
    };
    request.onerror = () => failed("The server does not answer. Is erclutch app still running?");
    request.onload = () => {
      let answer = {};
      try { answer = JSON.parse(request.responseText); } catch { /* told below */ }
      if (request.status === 200 && answer.log) location.href = base + answer.log;
      else failed(answer.problem || "The file was not taken.");
    };
    request.send(file);
  };
  document.getElementById("file").addEventListener("change", event => {
    if (event.target.files.length) send(event.target.files[0]);
  });
  for (const kind of ["dragenter", "dragover"]) drop.addEventListener(kind, event => { event.preventDefault(); drop.classList.add("over"); });
  for (const kind of ["dragleave", "drop"]) drop.addEventListener(kind, event => { event.preventDefault(); drop.classList.remove("over"); });
  drop.addEventListener("drop", event => {
    if (event.dataTransfer.files.length) send(event.dataTransfer.files[0]);
  });
}

const device = document.getElementById("device");
if (device) device.addEventListener("change", () => device.form.requestSubmit());

// The commands below a form follow what is typed into it.
const reading = document.getElementById("reading");
let typed = 0;
if (reading) reading.addEventListener("input", () => {
  const mine = ++typed;
  setTimeout(async () => {
    if (mine !== typed) return;
    const answer = await fetch(`${reading.dataset.words}?${new URLSearchParams(new FormData(reading))}`);
    const told = await answer.json();
    for (const part of ["read", "fit", "script"]) {
      const shown = document.getElementById(part);
      if (shown && mine === typed) shown.textContent = told[part] ?? told.problem;
    }
  }, 150);
});

for (const frame of document.querySelectorAll(".framed iframe")) {
  const said = frame.previousElementSibling;
  frame.addEventListener("load", () => { said.textContent = ""; });
  frame.src = frame.dataset.src;
}

const job = document.getElementById("job");
if (job && job.dataset.state === "running") {
  const part = name => document.getElementById(name);
  const look = async () => {
    let told;
    try {
      const answer = await fetch(`${base}/job/${job.dataset.number}.json`);
      if (!answer.ok) throw new Error(answer.statusText);
      told = await answer.json();
    } catch {
      part("doing").textContent = "The server does not answer. Is erclutch app still running?";
      setTimeout(look, 2000);
      return;
    }
    if (told.state !== "running") { location.reload(); return; }
    part("seconds").textContent = told.seconds.toFixed(1);
    part("doing").textContent = told.doing;
    if (told.share === null) part("share").removeAttribute("value");
    else part("share").value = told.share;
    part("lines").textContent = told.lines;
    if (told.address) { part("address").hidden = false; part("address").querySelector("a").href = told.address; }
    setTimeout(look, Math.min(2000, 400 + 50 * told.seconds)); // the longer it runs, the less often
  };
  look();
}
