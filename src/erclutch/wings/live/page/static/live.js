// The page of a live session: one socket, charts, a picture, buttons.

import { Charts } from "./charts.js";
import { Connection } from "./connection.js";
import { $, write } from "./elements.js";
import { buildHistogram } from "./histogram.js";
import { digitsFor, effortCalled, residualText, shownUnit, signed } from "./number_texts.js";
import { pictureOf } from "./picture.js";
import { ScreenClock } from "./screen_clock.js";
import { EventList, banner, setState, showLateness, showRecording, showState } from "./status_panel.js";
import { Store, named } from "./store.js";

// Flags of the model's step.
const WIDE_BAND = 32;
const DRIFT = 64;
const ADAPTED = 128;

const PICTURE_EACH = 30; // ms
const NUMBERS_EACH = 100; // ms

const store = new Store();
const charts = new Charts($("charts"), store);
const clock = new ScreenClock();
const events = new EventList();
// Read by the tests of this page.
const tally = { painted: 0, messages: 0, samples: 0, connections: 0, bytes: 0, drawing: 0, picture: null };
window.erclutch = tally;

let hello = null; // what the server said once of its session
let status = null; // what it said last
let picture = null;
let isRecording = false;
let tracked = ""; // by the program that runs: "position", "effort" or nothing
let unit = "N*m"; // of the effort
let motorUnit = "N m";
let secondsShown = 5; // s on screen
let frozen = null; // the newest time on screen, while frozen

// --- what the session says -------------------------------------------------------------------------------------------

const connection = new Connection({
  opened: () => { tally.connections += 1; },
  frames: takeFrames,
  said: takeMessage,
  lost: showLoss,
});

function takeFrames(buffer) {
  if (!hello) return;
  const before = store.taken;
  store.push(buffer, hello.period);
  clock.heard(store.now);
  tally.messages += 1;
  tally.samples += store.taken - before;
  tally.bytes += buffer.byteLength;
}

function takeMessage(message) {
  if (message.kind === "hello") greet(message);
  else if (message.kind === "status") showStatus(message);
  else if (message.kind === "refused") say(message.why, "bad");
}

function showLoss(text, isOver) {
  status = null;
  $("controls").disabled = isOver;
  setState(isOver ? "stopped" : "lost", isOver ? "ended" : "no connection");
  $("recording").hidden = true;
  banner(text);
}

function greet(message) {
  const isAnotherSession = hello && hello.session !== message.session;
  if (isAnotherSession) {
    store.clear();
    clock.lead = null;
    freeze(false);
  }
  hello = message;
  store.set(hello.wire, hello.channels);
  events.clear();
  charts.limit = hello.field_limit || 0.5;
  charts.channels = hello.channels;
  picture ??= pictureOf($("picture"), hello);
  picture.set(hello);
  buildHistogram(hello.edges);
  nameTheSession();
  nameTheDevice();
  offerPrograms();
}

function nameTheSession() {
  const { origin, rig, model, digest } = hello;
  $("origin").textContent = origin;
  $("origin").dataset.origin = origin;
  $("rig").textContent = `rig ${rig}`;
  $("model").textContent = model ? `model ${model} · ${digest.slice(0, 8)}` : "no model";
  $("model").title = digest;
  document.title = `${origin} · erclutch live`;
}

function nameTheDevice() {
  const { channels } = hello;
  const channelOf = wanted => channels.find(({ role }) => role === wanted);
  const isPair = named(channels, "field").length > 1;
  unit = channelOf("estimate").unit;
  write("picture-title", isPair ? "Clutches and table" : "Device");
  $("zero").firstChild.nodeValue = isPair ? "Zero fields " : "Zero field ";
  write("measured-title", `${effortCalled(unit)} measured`);
  write("estimated-title", `${effortCalled(unit)} estimated`);

  const motor = channelOf("motor");
  $("motor-form").hidden = !motor;
  if (motor) {
    motorUnit = shownUnit(motor.unit);
    write("motor-title", `Motor ${effortCalled(motor.unit).toLowerCase()}`);
    write("motor-unit", motorUnit);
    $("motor").min = -hello.motor_limit;
    $("motor").max = hello.motor_limit;
  }
}

function offerPrograms() {
  const chosen = $("program").value;
  const options = hello.programs.map(({ name, text }) => {
    const option = new Option(name, name);
    option.title = text;
    return option;
  });
  $("program").replaceChildren(...options);
  if (hello.programs.some(({ name }) => name === chosen)) $("program").value = chosen;
  $("step").disabled = !stepTest();
}

const stepTest = () => hello?.programs.find(({ name }) => name.startsWith("step"))?.name;

function showStatus(message) {
  status = message;
  const program = hello?.programs[status.program];
  tracked = (status.state === "running" && program?.reference) || "";
  store.reference = tracked;
  charts.reference = tracked;
  showState(status, program?.name, hello?.events ?? []);
  showLateness(status);
  isRecording = showRecording(status.recording);
  events.add(status.lines);
}

function say(text, level = "") {
  $("said").textContent = text;
  $("said").dataset.level = level;
}

// --- drawing ---------------------------------------------------------------------------------------------------------

let shown = null; // the newest time that was drawn
let pictureDrawn = 0; // when [ms]
let numbersWritten = 0;
let counted = { at: performance.now(), painted: 0, samples: 0 };

function paint(now) {
  requestAnimationFrame(paint);
  if (now - counted.at >= 1000) showRates(now);
  const newest = clock.shown(now, store.now);
  if (newest === shown) return;
  shown = newest;

  const began = performance.now();
  if (frozen === null) charts.draw([newest - secondsShown, newest], now);
  if (now - pictureDrawn > PICTURE_EACH) {
    pictureDrawn = now;
    tally.picture = picture?.draw(store) ?? null;
  }
  if (now - numbersWritten > NUMBERS_EACH && hello) {
    numbersWritten = now;
    writeNumbers();
  }
  tally.painted += 1;
  tally.drawing += performance.now() - began;
}

function showRates(now) {
  const aSecond = (count, before) => Math.round(((count - before) * 1000) / (now - counted.at));
  const rates = [
    `${aSecond(tally.painted, counted.painted)} frames/s`,
    `${aSecond(tally.samples, counted.samples)} samples/s`,
  ];
  if (store.skipped) rates.push(`${store.skipped} skipped`);
  $("rates").textContent = rates.join(" · ");
  counted = { at: now, painted: tally.painted, samples: tally.samples };
}

function writeNumbers() {
  const { outside, flags } = store.lastSecond();
  const effort = store.last(store.effort);
  const estimate = store.last("estimate");
  const valueText = value => `${signed(value, digitsFor(charts.effortSpan))} ${shownUnit(unit)}`;
  const adapted = flags & ADAPTED ? ", adapted" : "";

  charts.label();
  write("clock", `${store.now.toFixed(1)} s`);
  write("torque", Number.isFinite(effort) ? valueText(effort) : "no meter");
  write("estimate", Number.isFinite(estimate) ? valueText(estimate) + adapted : "no model");
  write("rms", residualText(store.rms("residual"), unit));
  $("tracking").hidden = !tracked;
  if (tracked) write("error", trackingText(store.rms("error")));

  if (Number.isFinite(estimate)) {
    const alarms = alarmsOf(outside, flags);
    write("coverage", alarms.join("; ") || "inside");
    $("coverage").dataset.level = alarms.length ? "bad" : "good";
  } else {
    write("coverage", "–");
    $("coverage").dataset.level = "none";
  }
}

function trackingText(error) {
  if (tracked === "effort") return residualText(error, unit);
  const angle = `${error.toFixed(3)} rad`;
  if (!hello.lead) return angle;
  const millimetres = ((error * hello.lead) / (2 * Math.PI)) * 1000;
  return `${angle} · ${millimetres.toFixed(2)} mm`;
}

/** What the model's step warns of, a sentence each. */
function alarmsOf(outside, flags) {
  const alarms = [];
  if (flags & DRIFT) alarms.push("drift: the torque left the band, or stays to one side of the estimate");
  if (outside) {
    const share = Math.max(1, Math.round(outside * 100));
    alarms.push(`outside ${share} % of 1 s: beyond its log the model guesses`);
  }
  if (flags & WIDE_BAND) alarms.push("wide band: the estimate is uncertain here");
  return alarms;
}

// --- controls --------------------------------------------------------------------------------------------------------

function send(command, text) {
  if (connection.send(command)) say(text);
  else say("No connection: the command was not sent", "bad");
}

function freeze(on) {
  frozen = on ? clock.shown(performance.now(), store.now) : null;
  charts.frozen = on;
  if (!on) charts.zoom(null);
  $("freeze").setAttribute("aria-pressed", on);
  $("frozen-hint").hidden = !on;
  shown = null;
}

function run(program) {
  if (status?.state === "tripped") {
    const reason = status.trip ? ` by ${status.trip}` : "";
    say(`Not run: the loop is tripped${reason}. Reset it first.`, "bad");
    return;
  }
  send({ command: "program", name: program }, `${program} asked for`);
}

function runStepTest() {
  const program = stepTest();
  if (!program) return;
  $("program").value = program;
  run(program);
}

function setMotor() {
  const torque = $("motor").valueAsNumber;
  if (Number.isFinite(torque)) send({ command: "motor", torque }, `${torque} ${motorUnit} asked for`);
  else say(`Give a number of ${motorUnit}`, "bad");
}

function showWindow(seconds) {
  secondsShown = seconds;
  shown = null;
  for (const button of document.querySelectorAll("[data-window]")) {
    button.setAttribute("aria-pressed", Number(button.dataset.window) === seconds);
  }
  if (frozen !== null) {
    charts.zoom(null);
    charts.draw([frozen - secondsShown, frozen], performance.now());
  }
}

const actions = {
  zero: () => send({ command: "zero" }, "Zero field asked for"),
  reset: () => send({ command: "reset" }, "Reset asked for"),
  record: () => send({ command: "record", on: !isRecording }, isRecording ? "The recording ends" : "A recording starts"),
  step: runStepTest,
  freeze: () => freeze(frozen === null),
};
for (const [name, act] of Object.entries(actions)) $(name).addEventListener("click", act);

$("program-form").addEventListener("submit", event => {
  event.preventDefault();
  if ($("program").value) run($("program").value);
});
$("motor-form").addEventListener("submit", event => {
  event.preventDefault();
  setMotor();
});
for (const button of document.querySelectorAll("[data-window]")) {
  button.addEventListener("click", () => showWindow(Number(button.dataset.window)));
}

const KEYS = { z: "zero", escape: "zero", r: "record", s: "step", f: "freeze" };
document.addEventListener("keydown", event => {
  if (event.ctrlKey || event.metaKey || event.altKey || event.repeat) return;
  const name = KEYS[event.key.toLowerCase()];
  if (!name) return;
  // Escape ends at zero field from anywhere; letters belong to a field that is being filled in.
  const isFillingIn = /^(INPUT|SELECT|TEXTAREA)$/.test(event.target.tagName);
  if (isFillingIn && event.key !== "Escape") return;
  if ($(name).matches(":disabled")) return;
  event.preventDefault();
  actions[name]();
});

connection.open();
requestAnimationFrame(paint);
