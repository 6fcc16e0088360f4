// Runs of other logs cannot be compared, and runs of other stretches of a log hardly: that is told before the click.

import { $ } from "./page.js";

export function checkTheChoice() {
  const compare = $("compare");
  compare?.form.addEventListener("change", () => {
    const ticked = [...compare.form.querySelectorAll("input:checked")];
    const differIn = key => new Set(ticked.map(box => box.dataset[key])).size > 1;
    const areOfOtherLogs = differIn("rows");
    $("cannot-compare").hidden = !areOfOtherLogs;
    $("few-rows").hidden = areOfOtherLogs || !differIn("heldOut");
    compare.disabled = areOfOtherLogs;
  });
}
