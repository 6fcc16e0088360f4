"use strict";
// What an error map says under the pointer.

for (const block of document.querySelectorAll("[data-map]")) {
  const map = DATA.grids[+block.dataset.map];
  for (const svg of block.querySelectorAll("svg.plot")) {
    svg.addEventListener("pointermove", (event) => {
      const cell = cellUnder(event, svg, map);
      if (cell) $("mapread").textContent = wordsOf(map, cell);
    });
  }
}

/** Which cell stands under the pointer: its places along field and slip; null beside the map. */
function cellUnder(event, svg, { inside, field, slip }) {
  const box = svg.getBoundingClientRect();
  const [left, top, right, bottom] = inside; // of the map, as shares of the picture
  const across = ((event.clientX - box.left) / box.width - left) / (right - left);
  const up = (bottom - (event.clientY - box.top) / box.height) / (bottom - top);
  if (across < 0 || across > 1 || up < 0 || up > 1) return null;
  return [placeAmong(field, across), placeAmong(slip, up)];
}

function placeAmong(edges, share) {
  const value = edges[0] + share * (edges[edges.length - 1] - edges[0]);
  return Math.max(0, edges.slice(0, -1).findLastIndex((edge) => edge <= value));
}

function wordsOf({ name, units, fieldless, field, slip, rmse, test, train }, [i, j]) {
  const [fieldUnit, slipUnit, effortUnit] = units.map((unit) => (unit ? ` ${unit}` : ""));
  const ends = (edges, k) => minus(`${edges[k]} to ${edges[k + 1]}`);
  const isJudged = rmse[i][j] >= 0;
  const error = isJudged
    ? `RMSE ${minus(String(rmse[i][j]))}${effortUnit} over ${test[i][j]} rows held out`
    : "no row held out";
  const ofField = fieldless ? "" : `field ${ends(field, i)}${fieldUnit}, `;
  const where = `${ofField}slip ${ends(slip, j)}${slipUnit}`;
  return `${name ? `${name}: ` : ""}${where}: ${error}, ${train[i][j]} training rows`;
}
