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
    part("printed").hidden = !told.lines;
    part("so-far").hidden = !told.fitted.length;
    part("fitted").replaceChildren(...told.fitted.map(([title, error]) => {
      const row = document.createElement("tr");
      const model = Object.assign(document.createElement("th"), { scope: "row", textContent: title });
      row.append(model, Object.assign(document.createElement("td"), { className: "number", textContent: error }));
      return row;
    }));
    if (told.address) { part("address").hidden = false; part("address").querySelector("a").href = told.address; }
    setTimeout(look, Math.min(2000, 400 + 50 * told.seconds)); // the longer it runs, the less often
  };
  look();
}

// Runs of other logs cannot be compared, and runs of other stretches of a log hardly: that is told before the click.
const compare = document.getElementById("compare");
if (compare) compare.form.addEventListener("change", () => {
  const ticked = [...compare.form.querySelectorAll("input:checked")];
  const differ = key => new Set(ticked.map(box => box.dataset[key])).size > 1;
  const other = differ("rows");
  document.getElementById("cannot-compare").hidden = !other;
  document.getElementById("few-rows").hidden = other || !differ("heldOut");
  compare.disabled = other;
});

// Logs that cannot be fitted together, such as logs in other units, are told before the click.
const together = document.getElementById("together");
if (together) reading.addEventListener("change", async event => {
  if (!event.target.name?.startsWith("log.")) return;
  const fit = reading.querySelector("button.main[formaction*='/fit/']");
  together.hidden = false;
  together.textContent = "Looking whether they go together …";
  const told = await (await fetch(`${together.dataset.together}?${new URLSearchParams(new FormData(reading))}`)).json();
  together.textContent = told.problem;
  together.hidden = !told.problem;
  fit.disabled = Boolean(told.problem);
});

// The signals of a log over time: looked at closer, and trimmed.
const courses = document.getElementById("courses");
if (courses) {
  const whole = JSON.parse(document.getElementById("over-time").textContent);
  const css = name => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
  const place = document.getElementById("plots"), seen = document.getElementById("seen");
  const ends = [whole.time[0], whole.until];
  const back = [];
  let view = [...ends], plots = [], dragged = null, finer = 0, drawn = whole;
  const digits = value => +value.toPrecision(6);
  const cuts = () => ["from", "until", "skip"].map(name => reading.elements[name]);
  const trimmed = () => cuts().some(field => field.defaultValue);
  const rows = name => { const s = drawn.signals[name]; return s ? [drawn.time, s.low, s.high] : [[0], [null], [null]]; };
  const show = () => {
    for (const [name, plot] of plots) plot.batch(() => {
      plot.setData(rows(name), false);
      plot.setScale("x", { min: view[0], max: view[1] });
    });
    courses.dataset.view = view.map(digits).join(",");
    const unzoomed = view[0] === ends[0] && view[1] === ends[1];
    const shown = `${digits(view[0])} s to ${digits(view[1])} s`;
    const all = trimmed() ? "all that the trimming leaves" : "the whole log";
    seen.textContent = unzoomed ? `${shown}, ${all}` : `${shown} of ${digits(ends[0])} s to ${digits(ends[1])} s`;
  };
  const go = async (a, b, keep = true) => {
    if (keep) back.push([...view]);
    const width = Math.max(b - a, (ends[1] - ends[0]) / 1e4);
    const start = Math.max(ends[0], Math.min(ends[1] - width, a));
    view = [Math.max(start, ends[0]), Math.min(start + width, ends[1])];
    drawn = whole;
    show();
    const mine = ++finer;
    if (whole.time.filter(t => t >= view[0] && t <= view[1]).length > 200) return;
    await new Promise(done => setTimeout(done, 300));
    if (mine !== finer) return;
    const form = new URLSearchParams(new FormData(reading));
    const slack = 0.02 * (view[1] - view[0]);
    form.set("from", `${Math.max(ends[0], view[0] - slack)}s`);
    form.set("until", `${Math.min(ends[1], view[1] + slack)}s`);
    form.delete("skip");
    const told = await (await fetch(`${courses.dataset.course}?${form}`)).json();
    if (mine !== finer || told.problem) return;
    drawn = told;
    show();
  };
  const colour = () => css("--ink");
  const names = Object.keys(whole.signals);
  const options = name => ({
    width: place.clientWidth, height: 104, padding: [6, 8, 0, 0],
    scales: { x: { time: false } }, legend: { show: false },
    cursor: { sync: { key: "courses", setSeries: false }, drag: { x: true, y: false, setScale: false }, points: { show: false } },
    axes: [
      { size: 22, stroke: () => css("--soft"), grid: { show: false }, ticks: { size: 4, stroke: () => css("--line") } },
      { size: 62, stroke: () => css("--soft"), space: 22, label: name + (/[^?]/.test(whole.signals[name].unit) ? ` [${whole.signals[name].unit.replace("*", "·")}]` : ""), labelSize: 16, labelFont: "11px system-ui", font: "11px system-ui", grid: { stroke: () => css("--line"), width: 0.6 }, ticks: { show: false } },
    ],
    series: [{}, { stroke: colour, width: 1, points: { show: false } }, { stroke: colour, width: 1, points: { show: false } }],
    bands: [{ series: [2, 1], fill: () => css("--ink") }],
    hooks: { setSelect: [u => {
      // The others follow this one's drag: they only let go of it.
      const [left, width] = [u.select.left, u.select.width];
      u.setSelect({ left: 0, width: 0, top: 0, height: 0 }, false);
      if (u === dragged && width > 3) go(u.posToVal(left, "x"), u.posToVal(left + width, "x"));
    }] },
  });
  const build = () => {
    plots.forEach(([, plot]) => plot.destroy());
    plots = names.map(name => {
      const plot = new uPlot(options(name), rows(name), place);
      plot.over.addEventListener("mousedown", () => { dragged = plot; }, true);
      plot.over.addEventListener("dblclick", () => { const to = back.pop(); to ? go(...to, false) : go(...ends, false); });
      return [name, plot];
    });
    show();
  };
  const zoom = factor => { const middle = (view[0] + view[1]) / 2, half = factor * (view[1] - view[0]) / 2; go(middle - half, middle + half); };
  const pan = share => { const by = share * (view[1] - view[0]); go(view[0] + by, view[1] + by); };
  const trim = () => {
    const field = name => reading.elements[name];
    if (view[0] > ends[0]) { field("from").value = `${digits(view[0])}s`; field("skip").value = ""; }
    if (view[1] < ends[1]) field("until").value = `${digits(view[1])}s`;
    reading.requestSubmit();
  };
  const untrim = () => { cuts().forEach(field => { field.value = ""; }); reading.requestSubmit(); };
  const acts = { out: () => zoom(2), whole: () => go(...ends), trim, untrim };
  for (const button of courses.querySelectorAll("[data-do]")) button.addEventListener("click", () => acts[button.dataset.do]());
  courses.addEventListener("keydown", event => {
    if (event.target !== courses) return;
    const keys = { ArrowLeft: () => pan(-0.25), ArrowRight: () => pan(0.25), "+": () => zoom(0.5), "=": () => zoom(0.5), "-": () => zoom(2), Home: acts.whole, Enter: trim };
    if (!keys[event.key]) return;
    event.preventDefault();
    keys[event.key]();
  });
  build();
  addEventListener("resize", build);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", build);
}

// A report in the page is as high as it is, so that there is one scroll bar.
addEventListener("message", event => {
  const frame = [...document.querySelectorAll(".framed iframe")].find(each => each.contentWindow === event.source);
  if (!frame || typeof event.data !== "object") return;
  const { height, top } = event.data;
  if (Number.isFinite(height)) frame.style.height = `${Math.min(height + 4, 60_000)}px`;
  if (Number.isFinite(top)) scrollTo({ top: frame.getBoundingClientRect().top + scrollY + top - 10, behavior: "smooth" });
});
