// A log that is dropped on the page, or chosen, is copied into the folder.

import { $, NO_ANSWER, base } from "./page.js";

export function takeDroppedFiles() {
  const drop = $("drop");
  if (!drop) return;
  const takeFirst = files => { if (files.length) send(files[0]); };

  $("file").addEventListener("change", event => takeFirst(event.target.files));
  for (const kind of ["dragenter", "dragover", "dragleave", "drop"]) {
    const isOver = kind === "dragenter" || kind === "dragover";
    drop.addEventListener(kind, event => {
      event.preventDefault();
      drop.classList.toggle("over", isOver);
    });
  }
  drop.addEventListener("drop", event => takeFirst(event.dataTransfer.files));
}

/** XMLHttpRequest, since `fetch` does not tell how far an upload is. */
function send(file) {
  const request = new XMLHttpRequest();
  request.open("PUT", `${base}/upload/${encodeURIComponent(file.name)}`);
  request.upload.onprogress = ({ loaded, total }) => {
    const percent = Math.floor((100 * loaded) / Math.max(total, 1));
    say(`Copying ${file.name}: ${percent} %`);
  };
  request.onerror = () => say(NO_ANSWER, "problem");
  request.onload = () => {
    const { log, problem } = answerOf(request);
    if (request.status === 200 && log) location.href = base + log;
    else say(problem || "The file was not taken.", "problem");
  };
  request.send(file);
}

function answerOf(request) {
  try {
    return JSON.parse(request.responseText);
  } catch {
    return {}; // the caller says that the file was not taken
  }
}

function say(text, className = "") {
  $("upload").textContent = text;
  $("upload").className = className;
}
