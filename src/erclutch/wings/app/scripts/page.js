// What the scripts of all pages share.

/** The session's own path: what the app serves begins with it. */
export const base = document.body.dataset.base;

export const $ = id => document.getElementById(id);

export const NO_ANSWER = "The server does not answer. Is erclutch app still running?";

/** The JSON value that the app answers: `{problem}`, with words for the user, where it refuses or does not answer. */
export async function ask(address) {
  try {
    const answer = await fetch(address, { headers: { Accept: "application/json" } });
    return await answer.json();
  } catch {
    return { problem: NO_ANSWER };
  }
}

/** The fields of a form, as they stand now. */
export const fieldsOf = form => new URLSearchParams(new FormData(form));

/** A value of the style sheet. */
export const css = name => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
