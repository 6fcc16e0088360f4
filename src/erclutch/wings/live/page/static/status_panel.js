// What the session says of itself four times a second: its state, lateness, recording, events.

import { $, element, write } from "./elements.js";
import { drawHistogram } from "./histogram.js";
import { shortTime } from "./number_texts.js";

const STATES = {
  running: "running",
  tripped: "tripped",
  ready: "at rest",
  silent: "silent",
  stopped: "stopped",
  starting: "starting",
};
const MOST_LINES = 200; // of events

export function setState(state, text) {
  $("state").dataset.state = state;
  write("state", text);
  $("state").title = text;
}

/** The line across the page; no text takes it away. */
export function banner(text, { reset = false, calm = false } = {}) {
  $("banner").hidden = !text;
  $("banner").dataset.calm = calm;
  write("banner-text", text);
  $("reset").hidden = !reset;
}

/** State and banner. program: the name of what runs, if it has one; events: [name, sentence] of each that can trip the loop. */
export function showState(status, program, events) {
  const { state } = status;
  $("controls").disabled = state === "stopped";
  setState(state, state === "running" && program ? `running ${program}` : STATES[state] ?? state);
  if (state === "tripped") banner(tripText(status, events), { reset: true });
  else if (state === "ready") banner("Reset. Zero field, and nothing moves until a program is run.", { calm: true });
  else if (state === "silent") banner("No frame from the loop: it is not running any more, or held up.");
  else if (state === "stopped") banner("The session has ended at zero field.");
  else banner("");
}

/** Why the field is zero, and what a reset needs. */
function tripText({ trip, doubt, busy }, events) {
  if (trip === "order") return "Zero field, as ordered, until a reset.";
  if (doubt) return `${doubt}. Zero field until a reset. ${busy}`;
  const names = trip ? trip.split(": ") : [];
  const reasons = events.filter(([name]) => names.includes(name)).map(([name, sentence]) => ` ${name}: ${sentence}.`);
  return `Tripped${trip ? ` by ${trip}` : ""}: zero field until a reset.${reasons.join("")} ${busy}`;
}

export function showLateness({ lateness, missed, step, realtime }) {
  if (lateness.count) {
    const { p50, p99, p999, max } = lateness;
    const shares = [`p50 ${shortTime(p50)}`, `p99 ${shortTime(p99)}`, `p99.9 ${shortTime(p999)}`, `max ${shortTime(max)}`];
    write("lateness", shares.join(" · "));
    write("realtime", `${missed} missed · step p99 ${shortTime(step.p99)}${realtime ? ` · ${realtime}` : ""}`);
    $("realtime").title = realtime;
  }
  drawHistogram(lateness.bars);
}

/** Returns whether a recording runs. */
export function showRecording(recording) {
  const isOn = Boolean(recording?.on);
  $("record").setAttribute("aria-pressed", isOn);
  $("record").setAttribute("aria-label", isOn ? "Stop recording" : "Record");
  $("record").querySelector("span").textContent = isOn ? "Stop" : "Record";
  $("recording").hidden = !isOn;
  if (isOn) {
    write("recorded", recordedText(recording));
    $("recorded").title = recording.path ?? "";
  }
  return isOn;
}

function recordedText({ seconds, size, lost }) {
  if (seconds === undefined) return "recording";
  const text = `${seconds.toFixed(0)} s · ${(size / 1e6).toFixed(1)} MB`;
  return lost ? `${text} · ${lost} lost` : text;
}

/** The events of a session; one that comes again is counted, not repeated. */
export class EventList {
  constructor() { this.lines = new Map(); }

  clear() { this.lines.clear(); }

  add(lines) {
    if (!lines.length) return;
    for (const line of lines) this.lines.set(line.number, line);
    const newestFirst = [...this.lines.values()].sort((a, b) => b.last - a.last || b.number - a.number);
    $("events").replaceChildren(...newestFirst.slice(0, MOST_LINES).map(eventItem));
  }
}

function eventItem({ last, text, count, level, name }) {
  const time = element("time", {}, `${last.toFixed(2)} s`);
  const what = element("span", { className: "what", title: text }, text);
  const many = element("span", { className: "many" }, count > 1 ? `× ${count}` : "");
  const item = element("li", {}, time, what, many);
  Object.assign(item.dataset, { level, name });
  return item;
}
