// How late the loop woke up: a bar a class of lateness.

import { $, element } from "./elements.js";
import { shortTime } from "./number_texts.js";

const TALLEST = 56; // px
const SHORTEST = 3; // px, for a single wake-up
const LATE = 500; // µs

/** edges: upper ends of the classes [µs]; a further class is open above. */
export function buildHistogram(edges) {
  const bars = [...edges, Infinity].map((edge, k) => {
    const isOpen = edge === Infinity;
    const title = isOpen ? `above ${edges.at(-1) / 1000} ms` : `up to ${shortTime(edge)}`;
    const bar = element("div", { title, className: edge > LATE ? "late" : "" });
    bar.append(element("i"), element("span", {}, labelUnder(edge, k)));
    bar.dataset.meaning = title;
    return bar;
  });
  $("histogram").replaceChildren(...bars);
}

/** Each third bar has a label: there is no room for more. */
function labelUnder(edge, k) {
  if (edge === Infinity) return ">";
  return k % 3 === 0 ? shortTime(edge).replace(".0", "") : "\u00a0";
}

/** Heights by the logarithm of the counts: one late wake-up in an hour must be seen. */
export function drawHistogram(counts) {
  const highest = Math.log10(1 + Math.max(1, ...counts));
  const bars = $("histogram").children;
  counts.forEach((count, k) => {
    if (!bars[k]) return;
    const height = count ? Math.max(SHORTEST, (TALLEST * Math.log10(1 + count)) / highest) : 0;
    bars[k].firstChild.style.height = `${height}px`;
    bars[k].title = `${bars[k].dataset.meaning}: ${count}`;
  });
  $("histogram").setAttribute("aria-label", `histogram of lateness: ${$("lateness").textContent}`);
}
