// The rig from the side: a motor turns two housings against each other, the fluid of each drags the one shaft along, and
// the shaft turns a screw that moves the table. Turning is shown ten times slower, so that the eye can follow.

const SVG = "http://www.w3.org/2000/svg";
const MARKS = 5, SLOW = 10;
const AXIS = 84, RADIUS = 50, WIDTH = 74;
const HOUSINGS = [{ x: 64, name: "CH1", colour: "--one" }, { x: 156, name: "CH2", colour: "--two" }];
const SCREW = { from: 250, to: 428 }, THREADS = 24, PITCH = (SCREW.to - SCREW.from) / THREADS;

function make(parent, kind, attributes, text) {
  const node = document.createElementNS(SVG, kind);
  for (const name in attributes) node.setAttribute(name, attributes[name]);
  if (text !== undefined) node.textContent = text;
  parent.append(node);
  return node;
}

export class Picture {
  constructor(root) {
    const svg = make(root, "svg", { viewBox: "0 8 440 178", role: "img", "aria-label": "two clutches on one shaft, and the table that it moves" });
    this.angles = [0, 0, 0];
    this.time = null;
    make(svg, "rect", { x: 0, y: AXIS - 4, width: SCREW.to, height: 8, rx: 3, fill: "var(--line)" });
    make(svg, "rect", { x: 6, y: AXIS - 22, width: 36, height: 44, rx: 5, fill: "var(--motor)", opacity: .85 });
    make(svg, "text", { x: 24, y: AXIS + 4, "text-anchor": "middle", class: "on" }, "M");
    this.housings = HOUSINGS.map(({ x, name, colour }) => {
      const fluid = make(svg, "rect", { x, y: AXIS - RADIUS, width: WIDTH, height: 2 * RADIUS, rx: 7, fill: `var(${colour})`, "fill-opacity": .08 });
      make(svg, "rect", { x, y: AXIS - RADIUS, width: WIDTH, height: 2 * RADIUS, rx: 7, fill: "none", stroke: `var(${colour})`, "stroke-width": 1.6 });
      const marks = Array.from({ length: MARKS }, () => make(svg, "line", { x1: x + 3, x2: x + WIDTH - 3, stroke: `var(${colour})`, "stroke-width": 3, "stroke-linecap": "round" }));
      make(svg, "text", { x: x + WIDTH / 2, y: 24, "text-anchor": "middle" }, name);
      const value = make(svg, "text", { x: x + WIDTH / 2, y: AXIS + RADIUS + 20, "text-anchor": "middle", class: "value" }, "E 0.00");
      return { fluid, marks, value };
    });
    const clip = make(make(svg, "defs", {}), "clipPath", { id: "screw" });
    make(clip, "rect", { x: SCREW.from, y: AXIS - 8, width: SCREW.to - SCREW.from, height: 16 });
    const thread = Array.from({ length: THREADS + 2 }, (_, k) => `M${SCREW.from + (k - 1) * PITCH - 2} ${AXIS + 7}l4 -14`).join("");
    this.thread = make(make(svg, "g", { "clip-path": "url(#screw)" }), "path", { d: thread, stroke: "var(--soft)", "stroke-width": 1.4 });
    make(svg, "rect", { x: SCREW.from, y: AXIS + 24, width: SCREW.to - SCREW.from, height: 5, rx: 2.5, fill: "var(--line)" });
    make(svg, "line", { x1: (SCREW.from + SCREW.to) / 2, x2: (SCREW.from + SCREW.to) / 2, y1: AXIS + 22, y2: AXIS + 34, stroke: "var(--soft)" });
    this.table = make(svg, "g", { class: "table" });
    make(this.table, "rect", { x: -22, y: AXIS - 17, width: 44, height: 41, rx: 5, fill: "var(--output)", opacity: .92 });
    make(this.table, "circle", { cx: 0, cy: AXIS + 3, r: 4, fill: "var(--card)" });
    this.where = make(svg, "text", { x: (SCREW.from + SCREW.to) / 2, y: AXIS + 54, "text-anchor": "middle", class: "value" }, "");
    make(svg, "text", { x: (SCREW.from + SCREW.to) / 2, y: 24, "text-anchor": "middle" }, "table");
    make(svg, "text", { x: 24, y: AXIS + 42, "text-anchor": "middle" }, "motor");
    make(svg, "text", { x: 4, y: 178 }, "colour: field · turning shown 10 times slower");
    this.set({ stroke: 0, lead: 0, field_limit: 0.5 });
  }

  set({ stroke, lead, field_limit }) {
    this.known = stroke > 0; this.stroke = stroke || 1; this.lead = lead; this.limit = field_limit || 0.5;
  }

  // Numbers of the newest sample; a longer pause counts as no turn.
  draw(store) {
    const now = store.now, passed = this.time === null ? 0 : Math.min(0.1, Math.max(0, now - this.time));
    this.time = now;
    const motor = store.last("theta_dot") || 0, output = store.last("alpha_dot") || 0, alpha = store.last("alpha") || 0;
    this.angles[0] += motor * passed / SLOW; this.angles[1] -= motor * passed / SLOW; this.angles[2] += output * passed / SLOW;
    ["field1", "field2"].forEach((name, k) => this.#housing(this.housings[k], this.angles[k], store.last(name) || 0));
    const turn = ((this.angles[2] / (2 * Math.PI)) % 1 + 1) % 1;
    this.thread.setAttribute("transform", `translate(${(turn * PITCH).toFixed(1)} 0)`);
    if (!this.known && Math.abs(alpha) > this.stroke) this.stroke = Math.abs(alpha);
    const reach = (SCREW.to - SCREW.from) / 2 - 24;
    const x = (SCREW.from + SCREW.to) / 2 + reach * Math.max(-1, Math.min(1, alpha / this.stroke));
    this.table.setAttribute("transform", `translate(${x.toFixed(1)} 0)`);
    const text = this.lead ? `${signed(alpha * this.lead / (2 * Math.PI) * 1000)} mm` : `${signed(alpha)} rad`;
    if (this.where.textContent !== text) this.where.textContent = text;
  }

  #housing({ fluid, marks, value }, angle, field) {
    fluid.setAttribute("fill-opacity", (0.08 + 0.8 * Math.min(1, Math.abs(field) / this.limit)).toFixed(2));
    marks.forEach((line, k) => {
      const at = angle + k * 2 * Math.PI / MARKS, y = AXIS + (RADIUS - 4) * Math.sin(at), front = Math.cos(at);
      line.setAttribute("y1", y.toFixed(1)); line.setAttribute("y2", y.toFixed(1));
      line.setAttribute("opacity", front > 0 ? (0.15 + 0.65 * front).toFixed(2) : 0);
    });
    const text = `E ${field.toFixed(2)}`;
    if (value.textContent !== text) value.textContent = text;
  }
}

const signed = value => (value < 0 ? "−" : "+") + Math.abs(value).toFixed(1);
