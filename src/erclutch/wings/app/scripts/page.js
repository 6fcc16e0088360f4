// What the scripts of all pages share.

/** The session's own path: what the app serves begins with it. */
export const base = document.body.dataset.base;

export const $ = id => document.getElementById(id);

/** The JSON value that the app answers. */
export async function ask(address) {
  const answer = await fetch(address);
  if (!answer.ok) throw new Error(answer.statusText);
  return answer.json();
}

/** The fields of a form, as they stand now. */
export const fieldsOf = form => new URLSearchParams(new FormData(form));

/** A value of the style sheet. */
export const css = name => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
