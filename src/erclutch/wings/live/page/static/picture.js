// The rig from the side. Of the pair: a motor turns two housings against each other, the fluid of each drags the one shaft along, and
// the shaft turns a screw that moves the table. Turning is shown ten times slower, so that the eye can follow.

import { whenColoursTurn } from "./elements.js";
import { signed } from "./number_texts.js";

const SVG = "http://www.w3.org/2000/svg";
const VIEW = { top: 8, width: 440, height: 178 };
const AXIS = 84; // height of the shaft in the picture
const SLOW = 10;
const MARKS = 5; // on a housing
const RADIUS = 50; // of a housing
const WIDTH = 74;
const HOUSINGS = [
  { x: 64, name: "CH1", colour: "--one" },
  { x: 156, name: "CH2", colour: "--two" },
];
const SCREW = { from: 250, to: 428 };
const THREADS = 24;
const PITCH = (SCREW.to - SCREW.from) / THREADS;
const MIDDLE = (SCREW.from + SCREW.to) / 2;
const REACH = (SCREW.to - SCREW.from) / 2 - 24; // of the table from the middle
const DRUM = { x: (VIEW.width - WIDTH) / 2, colour: "--one" };
const BORE = { x: 70, width: 220, radius: 34 };
const COLOURS = ["--one", "--two", "--soft", "--output", "--card", "--text"];
const TURN = 2 * Math.PI;

/** The picture of a session: of the pair, or of a single device. */
export function pictureOf(root, { channels }) {
  const fields = channels.filter(({ role }) => role === "field");
  return fields.length > 1 ? new PairPicture(root) : new SinglePicture(root, channels);
}

/** Adds an element to the drawing. */
function add(parent, kind, attributes, text) {
  const node = document.createElementNS(SVG, kind);
  for (const name in attributes) node.setAttribute(name, attributes[name]);
  if (text !== undefined) node.textContent = text;
  parent.append(node);
  return node;
}

// What stands still is drawn once, in SVG; what moves is drawn on a canvas over it: a change in the SVG would have the
// browser lay out and paint the whole page anew.
class Picture {
  constructor(root, meaning) {
    this.root = root;
    this.time = null; // of the last drawing [s]
    const viewBox = `0 ${VIEW.top} ${VIEW.width} ${VIEW.height}`;
    this.svg = add(root, "svg", { viewBox, role: "img", "aria-label": meaning });
    this.canvas = document.createElement("canvas");
    this.canvas.setAttribute("aria-hidden", "true");
    root.append(this.canvas);
    this.context = this.canvas.getContext("2d");
    this.set({ stroke: 0, lead: 0, field_limit: 0.5 });
    this.#fit();
    new ResizeObserver(() => this.#fit()).observe(root);
    whenColoursTurn(() => this.#fit());
  }

  /** What the session says of its rig: stroke [rad], lead of the screw [m], and the field's limit; 0 where it does not know. */
  set({ stroke, lead, field_limit }) {
    this.strokeIsKnown = stroke > 0;
    this.stroke = stroke || 1;
    this.lead = lead;
    this.limit = field_limit || 0.5;
  }

  /** The canvas follows the size and the colours of the page. */
  #fit() {
    const scale = (this.root.clientWidth * devicePixelRatio) / VIEW.width;
    this.canvas.width = Math.max(1, Math.round(VIEW.width * scale));
    this.canvas.height = Math.max(1, Math.round(VIEW.height * scale));
    this.context.setTransform(scale, 0, 0, scale, 0, -VIEW.top * scale);
    const style = getComputedStyle(this.root);
    this.colours = Object.fromEntries(COLOURS.map(name => [name, style.getPropertyValue(name).trim()]));
    this.font = `600 11px ${style.fontFamily}`;
  }

  /** Wipes out what moved. Returns seconds since the last drawing; a longer pause counts as no turn. */
  begin(store) {
    const passed = this.time === null ? 0 : store.now - this.time;
    this.time = store.now;
    this.context.clearRect(0, VIEW.top, VIEW.width, VIEW.height);
    return Math.min(0.1, Math.max(0, passed));
  }

  write(text, x, y) {
    const { context } = this;
    context.globalAlpha = 1;
    context.fillStyle = this.colours["--text"];
    context.font = this.font;
    context.textAlign = "center";
    context.fillText(text, x, y);
  }

  /** The colour of a field, from hardly any to full. */
  useColourOf(field, colour) {
    const { context } = this;
    context.fillStyle = this.colours[colour];
    context.strokeStyle = this.colours[colour];
    context.globalAlpha = 0.08 + 0.8 * Math.min(1, Math.abs(field) / this.limit);
  }

  roundedBox(x, y, width, height, radius) {
    this.context.beginPath();
    this.context.roundRect(x, y, width, height, radius);
    this.context.fill();
  }

  /** A drum of fluid whose marks turn. */
  housing({ x, colour }, angle, field) {
    const { context } = this;
    this.useColourOf(field, colour);
    this.roundedBox(x, AXIS - RADIUS, WIDTH, 2 * RADIUS, 7);
    context.lineWidth = 3;
    context.lineCap = "round";
    for (let k = 0; k < MARKS; k++) {
      const at = angle + (k * TURN) / MARKS;
      const towardsTheEye = Math.cos(at);
      if (towardsTheEye <= 0) continue;
      const y = AXIS + (RADIUS - 4) * Math.sin(at);
      context.globalAlpha = 0.15 + 0.65 * towardsTheEye;
      context.beginPath();
      context.moveTo(x + 4.5, y);
      context.lineTo(x + WIDTH - 4.5, y);
      context.stroke();
    }
  }
}

class PairPicture extends Picture {
  constructor(root) {
    super(root, "two clutches on one shaft, and the table that it moves");
    this.motorAngle = 0;
    this.screwAngle = 0;
    const threads = Array.from({ length: THREADS + 2 }, (_, k) => `M${SCREW.from + (k - 1) * PITCH - 2} ${AXIS + 7}l4 -14`);
    this.thread = new Path2D(threads.join(""));
    this.#drawWhatStandsStill();
  }

  #drawWhatStandsStill() {
    const { svg } = this;
    const middle = "middle";
    const shaft = { x: 0, y: AXIS - 4, width: SCREW.to, height: 8, rx: 3, fill: "var(--line)" };
    const motor = { x: 6, y: AXIS - 22, width: 36, height: 44, rx: 5, fill: "var(--motor)", opacity: 0.85 };
    const rail = { x: SCREW.from, y: AXIS + 24, width: SCREW.to - SCREW.from, height: 5, rx: 2.5, fill: "var(--line)" };
    add(svg, "rect", shaft);
    add(svg, "rect", motor);
    add(svg, "text", { x: 24, y: AXIS + 4, "text-anchor": middle, class: "on" }, "M");
    for (const { x, name, colour } of HOUSINGS) {
      add(svg, "rect", outline(x, RADIUS, WIDTH, 7, colour));
      add(svg, "text", { x: x + WIDTH / 2, y: 24, "text-anchor": middle }, name);
    }
    add(svg, "rect", rail);
    add(svg, "line", { x1: MIDDLE, x2: MIDDLE, y1: AXIS + 22, y2: AXIS + 34, stroke: "var(--soft)" });
    add(svg, "text", { x: MIDDLE, y: 24, "text-anchor": middle }, "table");
    add(svg, "text", { x: 24, y: AXIS + 42, "text-anchor": middle }, "motor");
    add(svg, "text", { x: 4, y: 178 }, "colour: field · turning shown 10 times slower");
  }

  /** Draws the newest sample. Returns the table's place in the picture and the texts that are written in it. */
  draw(store) {
    const newest = name => store.last(name) || 0;
    const passed = this.begin(store);
    const alpha = newest("alpha");
    const fields = [newest("field1"), newest("field2")];
    this.motorAngle += (newest("theta_dot") * passed) / SLOW;
    this.screwAngle += (newest("alpha_dot") * passed) / SLOW;
    if (!this.strokeIsKnown) this.stroke = Math.max(this.stroke, Math.abs(alpha));
    const table = MIDDLE + REACH * Math.max(-1, Math.min(1, alpha / this.stroke));

    this.housing(HOUSINGS[0], this.motorAngle, fields[0]);
    this.housing(HOUSINGS[1], -this.motorAngle, fields[1]);
    this.#screwAndTable(table);

    const where = this.lead ? `${signed(((alpha * this.lead) / TURN) * 1000, 1)} mm` : `${signed(alpha, 1)} rad`;
    const texts = [...fields.map(field => `E ${field.toFixed(2)}`), where];
    HOUSINGS.forEach(({ x }, k) => this.write(texts[k], x + WIDTH / 2, AXIS + RADIUS + 20));
    this.write(where, MIDDLE, AXIS + 54);
    return { table, texts };
  }

  #screwAndTable(table) {
    const { context } = this;
    const turns = this.screwAngle / TURN;
    context.globalAlpha = 1;
    context.lineCap = "butt";

    context.save();
    context.beginPath();
    context.rect(SCREW.from, AXIS - 8, SCREW.to - SCREW.from, 16);
    context.clip();
    context.translate((turns - Math.floor(turns)) * PITCH, 0);
    context.strokeStyle = this.colours["--soft"];
    context.lineWidth = 1.4;
    context.stroke(this.thread);
    context.restore();

    context.globalAlpha = 0.92;
    context.fillStyle = this.colours["--output"];
    this.roundedBox(table - 22, AXIS - 17, 44, 41, 5);
    context.globalAlpha = 1;
    context.fillStyle = this.colours["--card"];
    context.beginPath();
    context.arc(table, AXIS + 3, 4, 0, TURN);
    context.fill();
  }
}

/** One device: a drum that turns in its fluid, or a piston that moves through it. */
class SinglePicture extends Picture {
  constructor(root, channels) {
    const of = role => channels.find(channel => channel.role === role);
    const turns = ["rad", "?", ""].includes(of("position").unit);
    super(root, turns ? "a drum in its fluid" : "a piston in its fluid");
    this.turns = turns;
    this.field = of("field");
    this.slip = of("speed");
    this.position = of("position");
    this.angle = 0;
    this.reach = 1e-9; // largest distance so far

    const rod = { x: turns ? 60 : 220, y: AXIS - 4, width: turns ? 320 : 200, height: 8, rx: 3, fill: "var(--line)" };
    const body = turns ? outline(DRUM.x, RADIUS, WIDTH, 7, "--one") : outline(BORE.x, BORE.radius, BORE.width, 5, "--one");
    add(this.svg, "rect", rod);
    add(this.svg, "rect", body);
    add(this.svg, "text", { x: 4, y: 178 }, `colour: field${turns ? " · turning shown 10 times slower" : ""}`);
  }

  draw(store) {
    const newest = ({ name }) => store.last(name) || 0;
    const passed = this.begin(store);
    const field = newest(this.field);
    const slip = newest(this.slip);
    const position = newest(this.position);
    this.angle += (slip * passed) / SLOW;
    this.reach = Math.max(this.reach, Math.abs(position));
    const piston = BORE.x + BORE.width / 2 + (position / this.reach) * (BORE.width / 2 - 24);

    if (this.turns) this.housing(DRUM, this.angle, field);
    else this.#piston(piston, field);

    const texts = [
      `${this.field.label} ${field.toFixed(2)}${unitOf(this.field)}`,
      `${this.slip.label} ${signed(slip, 2)}${unitOf(this.slip)}`,
    ];
    this.write(texts[0], VIEW.width / 2, 24);
    this.write(texts[1], VIEW.width / 2, AXIS + RADIUS + 20);
    return { table: piston, texts };
  }

  #piston(x, field) {
    const { context } = this;
    this.useColourOf(field, "--one");
    this.roundedBox(BORE.x, AXIS - BORE.radius, BORE.width, 2 * BORE.radius, 5);
    context.globalAlpha = 0.92;
    context.fillStyle = this.colours["--output"];
    context.fillRect(x - 8, AXIS - 31, 16, 62);
    context.fillRect(x, AXIS - 4, 400 - x, 8); // its rod
  }
}

/** The wall of a housing or of a bore. */
function outline(x, radius, width, corner, colour) {
  return {
    x,
    y: AXIS - radius,
    width,
    height: 2 * radius,
    rx: corner,
    fill: "none",
    stroke: `var(${colour})`,
    "stroke-width": 1.6,
  };
}

const unitOf = ({ unit }) => (["", "?"].includes(unit) ? "" : ` ${unit.replace("*", " ")}`);
