"use strict";
// What an error map says under the pointer.
{
  const mapRead = $("mapread");
  const cell = (edges, share) => {
    const value = edges[0] + share * (edges[edges.length - 1] - edges[0]);
    return Math.max(0, edges.slice(0, -1).findLastIndex((edge) => edge <= value));
  };
  for (const block of document.querySelectorAll("[data-map]")) {
    const g = DATA.grids[+block.dataset.map];
    const unit = (k) => (g.units[k] ? ` ${g.units[k]}` : "");
    for (const svg of block.querySelectorAll("svg.plot"))
      svg.addEventListener("pointermove", (event) => {
        const box = svg.getBoundingClientRect();
        const [left, top, right, bottom] = g.inside;
        const across = ((event.clientX - box.left) / box.width - left) / (right - left);
        const up = (bottom - (event.clientY - box.top) / box.height) / (bottom - top);
        if (across < 0 || across > 1 || up < 0 || up > 1) return;
        const [i, j] = [cell(g.field, across), cell(g.slip, up)];
        const rmse = g.rmse[i][j] < 0 ? "no row held out" : `RMSE ${minus(String(g.rmse[i][j]))}${unit(2)} over ${g.test[i][j]} rows held out`;
        const where = (edges, k) => minus(`${edges[k]} to ${edges[k + 1]}`);
        mapRead.textContent = `${g.name ? `${g.name}: ` : ""}field ${where(g.field, i)}${unit(0)}, slip ${where(g.slip, j)}${unit(1)}: ${rmse}, ${g.train[i][j]} training rows`;
      });
  }
}
