// Numbers and units as the page writes them.

export const shownUnit = unit => ({ "": "1", "?": "as logged" })[unit] ?? unit.replace("*", " ");

export const effortCalled = unit => ({ "N*m": "Torque", N: "Force", Pa: "Stress" })[unit] ?? "Effort";

/** A number with its sign, for a place where signs must stand below each other; a dash where there is none. */
export function signed(value, digits) {
  if (!Number.isFinite(value)) return "–";
  return (value < 0 ? "−" : "+") + Math.abs(value).toFixed(digits);
}

/** Digits after the point that tell a five hundredth of a span. */
export const digitsFor = span => Math.min(5, Math.max(1, Math.ceil(2.7 - Math.log10(span))));

/** A time of the loop, given in microseconds. */
export const shortTime = us => (us >= 1000 ? `${(us / 1000).toFixed(1)} ms` : `${Math.round(us)} µs`);

/** A residual: a torque in thousandths, anything else with four figures. */
export function residualText(effort, unit) {
  if (!Number.isFinite(effort)) return "–";
  if (unit === "N*m") return `${(effort * 1000).toFixed(2)} mN m`;
  return `${effort.toPrecision(4)} ${shownUnit(unit)}`;
}
