// The page of a command that runs: what it does, how far it is, what it has fitted.

import { $, ask, base } from "./page.js";

const UNTIL_NEXT_TRY = 2000; // ms, where the app does not answer

export function followTheJob() {
  const job = $("job");
  if (job?.dataset.state === "running") look(job.dataset.number);
}

async function look(number) {
  const state = await ask(`${base}/job/${number}.json`);
  if (state.problem) {
    $("doing").textContent = state.problem;
    setTimeout(() => look(number), UNTIL_NEXT_TRY);
    return;
  }
  if (state.state !== "running") {
    location.reload(); // the page of what is done is another one
    return;
  }
  show(state);
  const pause = Math.min(2000, 400 + 50 * state.seconds); // the longer it runs, the less often
  setTimeout(() => look(number), pause);
}

function show({ seconds, doing, share, lines, fitted, address }) {
  $("seconds").textContent = seconds.toFixed(1);
  $("doing").textContent = doing;
  if (share === null) $("share").removeAttribute("value"); // how far it is cannot be told
  else $("share").value = share;

  $("lines").textContent = lines;
  $("printed").hidden = !lines;

  $("so-far").hidden = !fitted.length;
  $("fitted").replaceChildren(...fitted.map(rowOfModel));

  if (address) {
    $("address").hidden = false;
    $("address").querySelector("a").href = address;
  }
}

function rowOfModel([title, error]) {
  const row = document.createElement("tr");
  row.append(cell("th", { scope: "row", textContent: title }));
  row.append(cell("td", { className: "number", textContent: error }));
  return row;
}

const cell = (kind, properties) => Object.assign(document.createElement(kind), properties);
