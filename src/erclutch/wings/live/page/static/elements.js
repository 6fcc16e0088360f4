// Elements of the page: found, made, written.

export const $ = id => document.getElementById(id);

/** An element with some properties and what stands in it. */
export function element(kind, properties, ...children) {
  const node = Object.assign(document.createElement(kind), properties);
  node.append(...children);
  return node;
}

/** Writes a text only where it is another one: a screen reader says each change, and the browser lays it out anew. */
export function write(id, text) {
  if ($(id).textContent !== text) $(id).textContent = text;
}

/** The value of a variable of the style sheet. */
export const colourOf = name => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

/** Calls a function each time that the system turns to light or dark colours. */
export function whenColoursTurn(redraw) {
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", redraw);
}
