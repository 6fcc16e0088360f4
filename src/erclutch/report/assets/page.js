"use strict";
// What every script of the page uses; then its theme, copying, a frame around it, and the order of the ranking.
// Nothing here fetches anything.
const $ = (id) => document.getElementById(id);
const DATA = JSON.parse($("data").textContent);
const css = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
const element = (tag, className = "", textContent = "") => Object.assign(document.createElement(tag), { className, textContent });
const redrawn = [];

const between = (low, value, high) => Math.max(low, Math.min(high, value));

const minus = (text) => text.replace(/-/g, "−");
// As many places as the step has: with one, steps of 0.25 would read 0.3, 0.5, 0.8.
const digits = (value, step) => {
  let places = Math.max(0, Math.min(7, Math.ceil(-Math.log10(step) - 0.01)));
  if (Math.abs(step * 10 ** places % 1 - 0.5) < 1e-6 && places < 7) places += 1;
  return minus(value.toFixed(places)).replace(/^−(0(\.0*)?)$/, "$1");
};

// --- theme and copying ---------------------------------------------------------------------------------------------

const THEMES = ["", "dark", "light"];
let theme = 0;
$("theme").addEventListener("click", () => {
  theme = (theme + 1) % THEMES.length;
  const name = THEMES[theme];
  const label = `Colours: ${name || "as the system has them"}`;
  if (name) document.documentElement.dataset.theme = name;
  else delete document.documentElement.dataset.theme;
  $("theme").setAttribute("aria-label", label);
  $("theme").title = label;
  redrawn.forEach((draw) => draw());
});
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => redrawn.forEach((draw) => draw()));

for (const button of document.querySelectorAll("[data-copy]"))
  button.addEventListener("click", async () => {
    const source = $(button.dataset.copy);
    try {
      await navigator.clipboard.writeText(source.textContent);
      button.textContent = "Copied";
    } catch {
      getSelection().selectAllChildren(source);
      button.textContent = "Press Ctrl-C";
    }
    setTimeout(() => (button.textContent = "Copy"), 2000);
  });

// --- inside another page: it learns how high this page is, and where a link leads to ---------------------------------

if (parent !== window) {
  const tell = () => parent.postMessage({ height: document.body.scrollHeight }, "*");
  new ResizeObserver(tell).observe(document.body);
  addEventListener("load", tell); // an observer waits until the frame is seen
  for (const link of document.querySelectorAll("nav a, a.skip"))
    link.addEventListener("click", (event) => {
      event.preventDefault();
      parent.postMessage({ top: $(link.hash.slice(1)).getBoundingClientRect().top + scrollY }, "*");
    });
}

// --- ranking -------------------------------------------------------------------------------------------------------

/** The number of a cell, by which its row is sorted; cells without a number come last. */
function numberIn(cell) {
  const text = (cell.querySelector(".rank, b") ?? cell.firstChild)?.textContent ?? "";
  const number = parseFloat(text.replace(/^m/, "").replace("−", "-").replace(/\s/g, ""));
  return Number.isNaN(number) ? Infinity : number;
}

function sort(table, column, way) {
  const rows = [...table.tBodies[0].rows].map((row) => ({ row, number: numberIn(row.cells[column]) }));
  rows.sort((a, b) => {
    if (a.number === b.number) return 0;
    if (a.number === Infinity) return 1;
    if (b.number === Infinity) return -1;
    return way * (a.number - b.number);
  });
  table.tBodies[0].append(...rows.map(({ row }) => row));
}

// A click on a heading sorts by its column, a second click turns the order; print and PDF keep that of the report.
for (const table of document.querySelectorAll("table.ranking")) {
  const heads = [...table.querySelectorAll("thead th:first-child, thead th.n")];
  for (const head of heads) {
    const button = element("button", "sort", head.textContent);
    button.type = "button";
    head.replaceChildren(button);
    button.addEventListener("click", () => {
      const isAscending = head.ariaSort !== "ascending";
      for (const other of heads) other.ariaSort = null;
      head.ariaSort = isAscending ? "ascending" : "descending";
      sort(table, head.cellIndex, isAscending ? 1 : -1);
    });
  }
}
