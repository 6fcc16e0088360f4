// The form that says how a log is read: the commands below it follow what is typed into it.

import { $, ask, fieldsOf } from "./page.js";

const TYPING = 150; // ms without a key, after which what was typed counts

export function followTheForm() {
  const device = $("device");
  device?.addEventListener("change", () => device.form.requestSubmit());

  const form = $("reading");
  let changes = 0;
  form?.addEventListener("input", () => {
    changes += 1;
    const change = changes;
    const isNewest = () => change === changes;
    setTimeout(async () => {
      if (!isNewest()) return;
      const commands = await ask(`${form.dataset.words}?${fieldsOf(form)}`);
      if (isNewest()) showCommands(commands);
    }, TYPING);
  });
}

function showCommands(commands) {
  for (const part of ["read", "fit", "script"]) {
    if ($(part)) $(part).textContent = commands[part] ?? commands.problem;
  }
}

/** Logs that cannot be fitted together, such as logs in other units, are told before the click. */
export function warnOfLogsApart() {
  const warning = $("together");
  if (!warning) return;
  const form = $("reading");
  const fit = form.querySelector("button.main[formaction*='/fit/']");
  let choices = 0;
  form.addEventListener("change", async event => {
    if (!event.target.name?.startsWith("log.")) return;
    choices += 1;
    const choice = choices;
    warning.hidden = false;
    warning.textContent = "Looking whether they go together …";
    const { problem } = await ask(`${warning.dataset.together}?${fieldsOf(form)}`);
    if (choice !== choices) return; // a later choice has an answer of its own
    warning.textContent = problem;
    warning.hidden = !problem;
    fit.disabled = Boolean(problem);
  });
}
