"use strict";
// Cursor and legend of the traces in one line.

class Readout {
  constructor(traces) {
    this.traces = traces;
    this.line = $("readout");
  }

  /** The legend, with the values at a row of the view; null or another row: without values. */
  show(row) {
    const { drawn, box } = this.traces;
    if (!drawn) return;
    const { first, stop, edges } = drawn;
    const isInView = row !== null && row >= first && row < stop;
    const step = isInView ? edges.slice(0, -1).findLastIndex((edge) => edge <= row) : -1;
    const isPointed = step >= 0;

    this.line.replaceChildren();
    if (isPointed) this.line.append(element("span", "item", this.whereIs(row)));
    for (const entry of this.entries(step)) this.line.append(this.legendItem(entry));
    // Lines of the readout may come with the pointer, but the plots must not move under it each time.
    if (isPointed) this.line.style.minHeight = `${this.line.offsetHeight}px`;
    box.dataset.cursor = isPointed ? String(row) : "";
  }

  /** A screen reader says what the cursor reads. */
  sayAloud() { $("said").textContent = this.line.innerText.replace(/\s+/g, " "); }

  whereIs(row) {
    const { T, clock } = this.traces;
    const isWithin = ([first, stop]) => row >= first && row < stop;
    const log = T.logs.find(([, first, stop]) => isWithin([first, stop]));
    const parts = [`${digits(clock.timeOf(row), 1e-4)} s`, T.test.some(isWithin) ? "held out" : "training"];
    if (T.logs.length > 1 && log) parts.push(log[0]);
    return parts.join(", ");
  }

  /** What the legend names: measured, the chosen models, inputs. At a step (not -1) each has its value. */
  entries(step) {
    const { T, chosen, models } = this.traces;
    const { effort } = T;
    const measured = { name: "measured", colour: "--measured", line: "solid", value: this.valueAt(step, "measured", effort) };
    const ofModels = chosen.map((model) => {
      const [colour, dashes] = this.traces.style(model);
      const residual = this.valueAt(step, `residual:${model}`, { factor: effort.factor });
      const value = this.valueAt(step, `estimate:${model}`, effort) + (residual ? `, off by ${residual}` : "");
      const canGo = step < 0 && chosen.length > 1;
      return { name: models.get(model).title, colour, line: lineStyle(dashes), value, leaveOut: canGo ? model : null };
    });
    return [measured, ...ofModels, ...this.entriesOfInputs(step)];
  }

  /** An input alone in its plot has its name there. */
  entriesOfInputs(step) {
    const entries = [];
    for (const input of this.traces.T.inputs) {
      const ofKind = this.traces.inputs(input.kind);
      if (step < 0 && ofKind.length < 2) continue;
      const place = ofKind.indexOf(input);
      const value = this.valueAt(step, input.channel, input);
      entries.push({ name: input.label, colour: INPUT_COLOURS[place], line: place ? "dashed" : "solid", value });
    }
    return entries;
  }

  /** The value of a step, or its range, as text; empty without a step. */
  valueAt(step, name, { factor, unit }) {
    if (step < 0) return "";
    const resolution = this.traces.channels[name].step * factor;
    const [low, high] = this.traces.drawn.values[name][step].map((value) => digits(value * factor, resolution));
    const text = low === high ? low : `${low} … ${high}`;
    return unit ? `${text} ${unit}` : text;
  }

  legendItem({ name, colour, line, value, leaveOut = null }) {
    const item = element("span", "item");
    const mark = element("i");
    mark.style.borderTopColor = css(colour);
    mark.style.borderTopStyle = line;
    item.append(mark, element("span", "", name));
    if (value) item.append(element("span", "value", value));
    if (leaveOut) item.append(this.buttonThatLeavesOut(leaveOut));
    return item;
  }

  buttonThatLeavesOut(model) {
    const { traces } = this;
    const button = element("button", "", "×");
    button.type = "button";
    button.setAttribute("aria-label", `Leave out ${traces.models.get(model).title}`);
    button.addEventListener("click", () => traces.choose(traces.chosen.filter((other) => other !== model)));
    return button;
  }
}

/** The style of a border that looks like a line with these dashes. */
function lineStyle(dashes) {
  if (!dashes.length) return "solid";
  return dashes[0] < 4 ? "dotted" : "dashed";
}
