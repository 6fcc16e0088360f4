// The rig from the side. Of the pair: a motor turns two housings against each other, the fluid of each drags the one shaft along, and
// the shaft turns a screw that moves the table. Turning is shown ten times slower, so that the eye can follow.

const SVG = "http://www.w3.org/2000/svg";
const MARKS = 5, SLOW = 10;
const VIEW = { top: 8, width: 440, height: 178 };
const AXIS = 84, RADIUS = 50, WIDTH = 74;
const HOUSINGS = [{ x: 64, name: "CH1", colour: "--one" }, { x: 156, name: "CH2", colour: "--two" }];
const SCREW = { from: 250, to: 428 }, THREADS = 24, PITCH = (SCREW.to - SCREW.from) / THREADS;
const MIDDLE = (SCREW.from + SCREW.to) / 2, REACH = (SCREW.to - SCREW.from) / 2 - 24;
const DRUM = { x: (VIEW.width - WIDTH) / 2, colour: "--one" }, BORE = { x: 70, width: 220 };
const COLOURS = ["--one", "--two", "--soft", "--output", "--card", "--text"];

function make(parent, kind, attributes, text) {
  const node = document.createElementNS(SVG, kind);
  for (const name in attributes) node.setAttribute(name, attributes[name]);
  if (text !== undefined) node.textContent = text;
  parent.append(node);
  return node;
}

export const pictureOf = (root, { channels }) => channels.filter(({ role }) => role === "field").length > 1 ? new PairPicture(root) : new SinglePicture(root, channels);

// What stands still is drawn once, in SVG; what moves is drawn on a canvas over it: a change in the SVG would have the
// browser lay out and paint the whole page anew.
class Picture {
  constructor(root, meaning) {
    this.root = root; this.time = null;
    this.svg = make(root, "svg", { viewBox: `0 ${VIEW.top} ${VIEW.width} ${VIEW.height}`, role: "img", "aria-label": meaning });
    this.canvas = document.createElement("canvas");
    this.canvas.setAttribute("aria-hidden", "true");
    root.append(this.canvas);
    this.context = this.canvas.getContext("2d");
    new ResizeObserver(() => this.#fit()).observe(root);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.#fit());
    this.set({ stroke: 0, lead: 0, field_limit: 0.5 });
    this.#fit();
  }

  set({ stroke, lead, field_limit }) {
    this.known = stroke > 0; this.stroke = stroke || 1; this.lead = lead; this.limit = field_limit || 0.5;
  }

  #fit() {
    const scale = this.root.clientWidth * devicePixelRatio / VIEW.width;
    this.canvas.width = Math.max(1, Math.round(VIEW.width * scale)); this.canvas.height = Math.max(1, Math.round(VIEW.height * scale));
    this.context.setTransform(scale, 0, 0, scale, 0, -VIEW.top * scale);
    const style = getComputedStyle(this.root);
    this.colours = Object.fromEntries(COLOURS.map(name => [name, style.getPropertyValue(name).trim()]));
    this.font = `600 11px ${style.fontFamily}`;
  }

  // Seconds since the last drawing; a longer pause counts as no turn. What moved is wiped out.
  begin(store) {
    const now = store.now, passed = this.time === null ? 0 : Math.min(0.1, Math.max(0, now - this.time));
    this.time = now;
    this.context.clearRect(0, VIEW.top, VIEW.width, VIEW.height);
    return passed;
  }

  write(text, x, y) {
    this.context.globalAlpha = 1; this.context.fillStyle = this.colours["--text"]; this.context.font = this.font; this.context.textAlign = "center";
    this.context.fillText(text, x, y);
  }

  // The colour of a field, from hardly any to full.
  fill(colour, field) {
    this.context.fillStyle = this.context.strokeStyle = this.colours[colour];
    this.context.globalAlpha = 0.08 + 0.8 * Math.min(1, Math.abs(field) / this.limit);
  }

  // A drum of fluid whose marks turn.
  housing({ x, colour }, angle, field) {
    const context = this.context;
    this.fill(colour, field);
    context.beginPath(); context.roundRect(x, AXIS - RADIUS, WIDTH, 2 * RADIUS, 7); context.fill();
    context.lineWidth = 3; context.lineCap = "round";
    for (let k = 0; k < MARKS; k++) {
      const at = angle + k * 2 * Math.PI / MARKS, y = AXIS + (RADIUS - 4) * Math.sin(at), front = Math.cos(at);
      if (front <= 0) continue;
      context.globalAlpha = 0.15 + 0.65 * front;
      context.beginPath(); context.moveTo(x + 4.5, y); context.lineTo(x + WIDTH - 4.5, y); context.stroke();
    }
  }
}

class PairPicture extends Picture {
  constructor(root) {
    super(root, "two clutches on one shaft, and the table that it moves");
    const svg = this.svg;
    this.angles = [0, 0, 0];
    make(svg, "rect", { x: 0, y: AXIS - 4, width: SCREW.to, height: 8, rx: 3, fill: "var(--line)" });
    make(svg, "rect", { x: 6, y: AXIS - 22, width: 36, height: 44, rx: 5, fill: "var(--motor)", opacity: .85 });
    make(svg, "text", { x: 24, y: AXIS + 4, "text-anchor": "middle", class: "on" }, "M");
    for (const { x, name, colour } of HOUSINGS) {
      make(svg, "rect", { x, y: AXIS - RADIUS, width: WIDTH, height: 2 * RADIUS, rx: 7, fill: "none", stroke: `var(${colour})`, "stroke-width": 1.6 });
      make(svg, "text", { x: x + WIDTH / 2, y: 24, "text-anchor": "middle" }, name);
    }
    make(svg, "rect", { x: SCREW.from, y: AXIS + 24, width: SCREW.to - SCREW.from, height: 5, rx: 2.5, fill: "var(--line)" });
    make(svg, "line", { x1: MIDDLE, x2: MIDDLE, y1: AXIS + 22, y2: AXIS + 34, stroke: "var(--soft)" });
    make(svg, "text", { x: MIDDLE, y: 24, "text-anchor": "middle" }, "table");
    make(svg, "text", { x: 24, y: AXIS + 42, "text-anchor": "middle" }, "motor");
    make(svg, "text", { x: 4, y: 178 }, "colour: field · turning shown 10 times slower");
    this.thread = new Path2D(Array.from({ length: THREADS + 2 }, (_, k) => `M${SCREW.from + (k - 1) * PITCH - 2} ${AXIS + 7}l4 -14`).join(""));
  }

  // Numbers of the newest sample. Returns what is written in it.
  draw(store) {
    const passed = this.begin(store);
    const motor = store.last("theta_dot") || 0, output = store.last("alpha_dot") || 0, alpha = store.last("alpha") || 0;
    const fields = [store.last("field1") || 0, store.last("field2") || 0];
    this.angles[0] += motor * passed / SLOW; this.angles[1] -= motor * passed / SLOW; this.angles[2] += output * passed / SLOW;
    if (!this.known && Math.abs(alpha) > this.stroke) this.stroke = Math.abs(alpha);
    const table = MIDDLE + REACH * Math.max(-1, Math.min(1, alpha / this.stroke));
    const where = this.lead ? `${signed(alpha * this.lead / (2 * Math.PI) * 1000)} mm` : `${signed(alpha)} rad`;
    const texts = [...fields.map(field => `E ${field.toFixed(2)}`), where];
    HOUSINGS.forEach((housing, k) => this.housing(housing, this.angles[k], fields[k]));
    this.#screw(table);
    HOUSINGS.forEach(({ x }, k) => this.write(texts[k], x + WIDTH / 2, AXIS + RADIUS + 20));
    this.write(where, MIDDLE, AXIS + 54);
    return { table, texts };
  }

  #screw(table) {
    const context = this.context, turn = ((this.angles[2] / (2 * Math.PI)) % 1 + 1) % 1;
    context.globalAlpha = 1; context.lineCap = "butt";
    context.save();
    context.beginPath(); context.rect(SCREW.from, AXIS - 8, SCREW.to - SCREW.from, 16); context.clip();
    context.translate(turn * PITCH, 0);
    context.strokeStyle = this.colours["--soft"]; context.lineWidth = 1.4; context.stroke(this.thread);
    context.restore();
    context.globalAlpha = 0.92; context.fillStyle = this.colours["--output"];
    context.beginPath(); context.roundRect(table - 22, AXIS - 17, 44, 41, 5); context.fill();
    context.globalAlpha = 1; context.fillStyle = this.colours["--card"];
    context.beginPath(); context.arc(table, AXIS + 3, 4, 0, 2 * Math.PI); context.fill();
  }
}

// One device: a drum that turns in its fluid, or a piston that moves through it.
class SinglePicture extends Picture {
  constructor(root, channels) {
    const of = role => channels.find(channel => channel.role === role), turns = ["rad", "?", ""].includes(of("position").unit);
    super(root, turns ? "a drum in its fluid" : "a piston in its fluid");
    Object.assign(this, { turns, field: of("field"), slip: of("speed"), position: of("position"), angle: 0, reach: 1e-9 });
    make(this.svg, "rect", { x: turns ? 60 : 220, y: AXIS - 4, width: turns ? 320 : 200, height: 8, rx: 3, fill: "var(--line)" });
    if (turns) make(this.svg, "rect", { x: DRUM.x, y: AXIS - RADIUS, width: WIDTH, height: 2 * RADIUS, rx: 7, fill: "none", stroke: "var(--one)", "stroke-width": 1.6 });
    else make(this.svg, "rect", { x: BORE.x, y: AXIS - 34, width: BORE.width, height: 68, rx: 5, fill: "none", stroke: "var(--one)", "stroke-width": 1.6 });
    make(this.svg, "text", { x: 4, y: 178 }, `colour: field${turns ? " · turning shown 10 times slower" : ""}`);
  }

  draw(store) {
    const passed = this.begin(store), field = store.last(this.field.name) || 0, slip = store.last(this.slip.name) || 0, at = store.last(this.position.name) || 0;
    this.angle += slip * passed / SLOW; this.reach = Math.max(this.reach, Math.abs(at));
    const table = BORE.x + BORE.width / 2 + at / this.reach * (BORE.width / 2 - 24), context = this.context;
    if (this.turns) this.housing(DRUM, this.angle, field);
    else {
      this.fill("--one", field);
      context.beginPath(); context.roundRect(BORE.x, AXIS - 34, BORE.width, 68, 5); context.fill();
      context.globalAlpha = 0.92; context.fillStyle = this.colours["--output"];
      context.fillRect(table - 8, AXIS - 31, 16, 62); context.fillRect(table, AXIS - 4, 400 - table, 8);
    }
    const texts = [`${this.field.label} ${field.toFixed(2)}${unitOf(this.field)}`, `${this.slip.label} ${signed(slip, 2)}${unitOf(this.slip)}`];
    this.write(texts[0], VIEW.width / 2, 24); this.write(texts[1], VIEW.width / 2, AXIS + RADIUS + 20);
    return { table, texts };
  }
}

const unitOf = ({ unit }) => ["", "?"].includes(unit) ? "" : ` ${unit.replace("*", " ")}`;
const signed = (value, digits = 1) => (value < 0 ? "−" : "+") + Math.abs(value).toFixed(digits);
