// The page of a live session: one socket, charts, a picture, buttons.

import { Charts, digitsFor, effortCalled, element, shownUnit, signed } from "./charts.js";
import { pictureOf } from "./picture.js";
import { Store, named } from "./store.js";

const WIDE_BAND = 32, DRIFT = 64, ADAPTED = 128; // of the flags of the model's step

const $ = id => document.getElementById(id);
const write = (id, text) => { if ($(id).textContent !== text) $(id).textContent = text; };
const store = new Store();
const charts = new Charts($("charts"), store);
let picture = null;
// Read by the tests of this page.
const tally = window.erclutch = { painted: 0, messages: 0, samples: 0, connections: 0, bytes: 0, drawing: 0, picture: null };

let hello = null, status = null, shown = 5, frozen = null, socket = null, pause = 250, failures = 0;
let recording = false, over = false, tracked = "", unit = "N*m", motorUnit = "N m";
const lines = new Map();

// --- time ------------------------------------------------------------------------------------------------------------

// Messages do not come in step with the screen. So what is shown runs by the page's own clock, a little behind the
// newest sample: each redraw moves by the same time, and by none when nothing comes any more.
const BEHIND = 0.035; // s

const clock = {
  lead: null, // of the loop's time over the page's, by the messages that were least on their way
  heard(newest) {
    const lead = newest - performance.now() / 1000;
    this.lead = this.lead === null || lead > this.lead || lead < this.lead - 1 ? lead : this.lead - 0.002 * (this.lead - lead);
  },
  shown: now => clock.lead === null ? 0 : Math.min(store.now, now / 1000 + clock.lead - BEHIND),
};

// --- connection ------------------------------------------------------------------------------------------------------

function connect() {
  socket = new WebSocket(`ws://${location.host}${location.pathname}frames`);
  socket.binaryType = "arraybuffer";
  socket.onopen = () => { pause = 250; failures = 0; over = false; tally.connections += 1; };
  socket.onmessage = event => typeof event.data === "string" ? heard(JSON.parse(event.data)) : frames(event.data);
  socket.onclose = event => { lost(event.code === 1012); setTimeout(connect, pause); pause = Math.min(2000, pause * 1.6); };
}

// ended: the server said goodbye, which it does when its session is over.
async function lost(ended) {
  status = null; failures += 1;
  over = ended || (over && failures > 1);
  $("controls").disabled = over;
  setState(over ? "stopped" : "lost", over ? "ended" : "no connection");
  $("recording").hidden = true;
  banner(over ? "The session has ended." : "The connection to the session is lost. Trying again …");
  if (failures < 3) return;
  try {
    const answer = await fetch("live.css", { cache: "no-store" });
    if (answer.status === 403) banner("This is another session. Open the address that erclutch live printed.");
  } catch { /* nobody answers: the session is over, or its server starts again */ }
}

function frames(buffer) {
  if (!hello) return;
  const before = store.taken;
  store.push(buffer, hello.period);
  tally.messages += 1; tally.samples += store.taken - before; tally.bytes += buffer.byteLength;
  clock.heard(store.now);
}

function heard(body) {
  if (body.kind === "hello") greet(body);
  else if (body.kind === "status") { status = body; report(); }
  else if (body.kind === "refused") say(body.why, "bad");
}

function send(body, text) {
  if (socket?.readyState !== WebSocket.OPEN) return say("No connection: the command was not sent", "bad");
  socket.send(JSON.stringify(body));
  say(text);
}

function say(text, level = "") { $("said").textContent = text; $("said").dataset.level = level; }

function banner(text, reset = false, calm = false) {
  $("banner").hidden = !text;
  $("banner").dataset.calm = calm;
  write("banner-text", text);
  $("reset").hidden = !reset;
}

function setState(state, text) { $("state").dataset.state = state; write("state", text); }

// --- what the session says -------------------------------------------------------------------------------------------

function greet(body) {
  if (hello && hello.session !== body.session) { store.clear(); clock.lead = null; freeze(false); }
  hello = body;
  store.set(body.wire, body.channels);
  lines.clear();
  $("origin").textContent = body.origin; $("origin").dataset.origin = body.origin;
  $("rig").textContent = `rig ${body.rig}`;
  $("model").textContent = body.model ? `model ${body.model} · ${body.digest.slice(0, 8)}` : "no model";
  $("model").title = body.digest;
  document.title = `${body.origin} · erclutch live`;
  charts.limit = body.field_limit || 0.5;
  charts.channels = body.channels;
  picture ??= pictureOf($("picture"), body);
  picture.set(body);
  const pair = named(body.channels, "field").length > 1, motor = body.channels.find(({ role }) => role === "motor");
  unit = body.channels.find(({ role }) => role === "estimate").unit;
  write("picture-title", pair ? "Clutches and table" : "Device");
  $("zero").firstChild.nodeValue = pair ? "Zero fields " : "Zero field ";
  write("measured-title", `${effortCalled(unit)} measured`); write("estimated-title", `${effortCalled(unit)} estimated`);
  $("motor-form").hidden = !motor;
  if (motor) { write("motor-title", `Motor ${effortCalled(motor.unit).toLowerCase()}`); write("motor-unit", motorUnit = shownUnit(motor.unit)); }
  const chosen = $("program").value;
  $("program").replaceChildren(...body.programs.map(({ name, text }) => { const option = new Option(name, name); option.title = text; return option; }));
  if (body.programs.some(({ name }) => name === chosen)) $("program").value = chosen;
  $("step").disabled = !stepTest();
  $("motor").min = -body.motor_limit; $("motor").max = body.motor_limit;
  buildHistogram(body.edges);
}

const stepTest = () => hello?.programs.find(({ name }) => name.startsWith("step"))?.name;

function report() {
  const { state, trip, doubt, busy, lateness, step, realtime, program } = status;
  const names = { running: "running", tripped: "tripped", ready: "at rest", silent: "silent", stopped: "stopped", starting: "starting" };
  const chosen = hello?.programs[program], name = chosen?.name;
  store.reference = charts.reference = tracked = (state === "running" && chosen?.reference) || "";
  $("controls").disabled = state === "stopped";
  setState(state, state === "running" && name ? `running ${name}` : names[state] ?? state);
  if (state === "tripped") banner(trip === "order" ? "Zero field, as ordered, until a reset." : `${doubt ? `${doubt}. Zero field until a reset.` : `Tripped${trip ? ` by ${trip}` : ""}: zero field until a reset.${why(trip)}`} ${busy}`, true);
  else if (state === "ready") banner("Reset. Zero field, and nothing moves until a program is run.", false, true);
  else if (state === "silent") banner("No frame from the loop: it is not running any more, or held up.");
  else if (state === "stopped") banner("The session has ended at zero field.");
  else banner("");
  if (lateness.count) {
    write("lateness", `p50 ${us(lateness.p50)} · p99 ${us(lateness.p99)} · p99.9 ${us(lateness.p999)} · max ${us(lateness.max)}`);
    write("realtime", `${status.missed} missed · step p99 ${us(step.p99)}${realtime ? ` · ${realtime}` : ""}`);
    $("realtime").title = realtime;
  }
  drawHistogram(lateness.bars);
  reportRecording(status.recording);
  for (const line of status.lines) lines.set(line.number, line);
  if (status.lines.length) drawLines();
}

const us = value => value >= 1000 ? `${(value / 1000).toFixed(1)} ms` : `${Math.round(value)} µs`;

function reportRecording(body) {
  recording = Boolean(body?.on);
  $("record").setAttribute("aria-pressed", recording); $("record").setAttribute("aria-label", recording ? "Stop recording" : "Record");
  $("record").querySelector("span").textContent = recording ? "Stop" : "Record";
  $("recording").hidden = !recording;
  if (recording) {
    const lost = body.lost ? ` · ${body.lost} lost` : "";
    write("recorded", body.seconds === undefined ? "recording" : `${body.seconds.toFixed(0)} s · ${(body.size / 1e6).toFixed(1)} MB${lost}`);
    $("recorded").title = body.path ?? "";
  }
}

function buildHistogram(edges) {
  $("histogram").replaceChildren(...[...edges, Infinity].map((edge, k) => {
    const text = edge === Infinity ? ">" : k % 3 === 0 ? us(edge).replace(".0", "") : "\u00a0";
    const title = edge === Infinity ? `above ${edges.at(-1) / 1000} ms` : `up to ${us(edge)}`;
    return element("div", { title, className: edge > 500 ? "late" : "" }, element("i"), element("span", {}, text));
  }));
}

// Heights by the logarithm of the counts: one late wake-up in an hour must be seen.
function drawHistogram(bars) {
  const most = Math.log10(1 + Math.max(1, ...bars)), boxes = $("histogram").children;
  bars.forEach((count, k) => {
    if (!boxes[k]) return;
    boxes[k].firstChild.style.height = `${count ? Math.max(3, 56 * Math.log10(1 + count) / most) : 0}px`;
    boxes[k].title = `${boxes[k].title.split(":")[0]}: ${count}`;
  });
  $("histogram").setAttribute("aria-label", `histogram of lateness: ${$("lateness").textContent}`);
}

function drawLines() {
  const newest = [...lines.values()].sort((a, b) => b.last - a.last || b.number - a.number).slice(0, 200);
  $("events").replaceChildren(...newest.map(line => {
    const many = line.count > 1 ? `× ${line.count}` : "";
    const item = element("li", {}, element("time", {}, `${line.last.toFixed(2)} s`),
      element("span", { className: "what", title: line.text }, line.text), element("span", { className: "many" }, many));
    Object.assign(item.dataset, { level: line.level, name: line.name });
    return item;
  }));
}

// --- drawing ---------------------------------------------------------------------------------------------------------

let measured = performance.now(), painted = 0, samples = 0, spoken = 0, drawn = 0, at = null;

function paint(now) {
  requestAnimationFrame(paint);
  if (now - measured >= 1000) {
    const seconds = (now - measured) / 1000;
    $("rates").textContent = `${Math.round((tally.painted - painted) / seconds)} frames/s · ${Math.round((tally.samples - samples) / seconds)} samples/s${store.skipped ? ` · ${store.skipped} skipped` : ""}`;
    measured = now; painted = tally.painted; samples = tally.samples;
  }
  const newest = clock.shown(now);
  if (newest === at) return;
  at = newest;
  const began = performance.now();
  if (frozen === null) charts.draw([newest - shown, newest], now);
  if (now - drawn > 30) { drawn = now; tally.picture = picture?.draw(store) ?? null; }
  if (now - spoken > 100) { spoken = now; numbers(); }
  tally.painted += 1; tally.drawing += performance.now() - began;
}

// A residual: a torque in thousandths, anything else with four figures.
const small = effort => !Number.isFinite(effort) ? "–" : unit === "N*m" ? `${(effort * 1000).toFixed(2)} mN m` : `${effort.toPrecision(4)} ${shownUnit(unit)}`;

// What an event means, in a sentence; empty for what has no name.
const why = trip => (hello?.events ?? []).filter(([name]) => (trip ?? "").split(": ").includes(name)).map(([name, text]) => ` ${name}: ${text}.`).join("");

function numbers() {
  if (!hello) return;
  charts.label();
  const digits = digitsFor(charts.charts[0].range.high - charts.charts[0].range.low);
  const { outside, flags } = store.lastSecond(), rms = store.rms("residual"), effort = store.last(store.effort), estimate = store.last("estimate");
  write("clock", `${store.now.toFixed(1)} s`);
  write("torque", Number.isFinite(effort) ? `${signed(effort, digits)} ${shownUnit(unit)}` : "no meter");
  write("estimate", Number.isFinite(estimate) ? `${signed(estimate, digits)} ${shownUnit(unit)}${(flags & ADAPTED) !== 0 ? ", adapted" : ""}` : "no model");
  write("rms", small(rms));
  const error = store.rms("error");
  $("tracking").hidden = !tracked;
  if (tracked) write("error", tracked === "effort" ? small(error) : `${error.toFixed(3)} rad${hello.lead ? ` · ${(error * hello.lead * 500 / Math.PI).toFixed(2)} mm` : ""}`);
  const modelled = Number.isFinite(estimate);
  const drift = (flags & DRIFT) !== 0, wide = (flags & WIDE_BAND) !== 0;
  const alarms = [
    drift && "drift: the torque left the band, or stays to one side of the estimate",
    outside && `outside ${Math.max(1, Math.round(outside * 100))} % of 1 s: beyond its log the model guesses`,
    wide && "wide band: the estimate is uncertain here",
  ].filter(Boolean);
  write("coverage", !modelled ? "–" : alarms.join("; ") || "inside");
  $("coverage").dataset.level = !modelled ? "none" : alarms.length ? "bad" : "good";
}

// --- controls --------------------------------------------------------------------------------------------------------

function freeze(on) {
  frozen = on ? clock.shown(performance.now()) : null;
  charts.frozen = on;
  if (!on) charts.zoom(null);
  $("freeze").setAttribute("aria-pressed", on);
  $("frozen-hint").hidden = !on;
  at = null;
}

function run(name) {
  if (status?.state === "tripped") return say(`Not run: the loop is tripped${status.trip ? ` by ${status.trip}` : ""}. Reset it first.`, "bad");
  send({ command: "program", name }, `${name} asked for`);
}

const actions = {
  zero: () => send({ command: "zero" }, "Zero field asked for"),
  reset: () => send({ command: "reset" }, "Reset asked for"),
  record: () => send({ command: "record", on: !recording }, recording ? "The recording ends" : "A recording starts"),
  step: () => { const name = stepTest(); if (name) { $("program").value = name; run(name); } },
  freeze: () => freeze(frozen === null),
};
for (const name of Object.keys(actions)) $(name).addEventListener("click", actions[name]);

$("program-form").addEventListener("submit", event => {
  event.preventDefault();
  const name = $("program").value;
  if (name) run(name);
});
$("motor-form").addEventListener("submit", event => {
  event.preventDefault();
  const torque = $("motor").valueAsNumber;
  if (Number.isFinite(torque)) send({ command: "motor", torque }, `${torque} ${motorUnit} asked for`);
  else say(`Give a number of ${motorUnit}`, "bad");
});
for (const button of document.querySelectorAll("[data-window]")) button.addEventListener("click", () => {
  shown = Number(button.dataset.window); at = null;
  for (const other of document.querySelectorAll("[data-window]")) other.setAttribute("aria-pressed", other === button);
  if (frozen !== null) { charts.zoom(null); charts.draw([frozen - shown, frozen], performance.now()); }
});

const keys = { z: "zero", escape: "zero", r: "record", s: "step", f: "freeze" };
document.addEventListener("keydown", event => {
  if (event.ctrlKey || event.metaKey || event.altKey || event.repeat) return;
  const name = keys[event.key.toLowerCase()];
  // Escape ends at zero field from anywhere; letters belong to a field that is being filled in.
  if (!name || (event.key !== "Escape" && /^(INPUT|SELECT|TEXTAREA)$/.test(event.target.tagName))) return;
  if ($(name).matches(":disabled")) return;
  event.preventDefault();
  actions[name]();
});

connect();
requestAnimationFrame(paint);
