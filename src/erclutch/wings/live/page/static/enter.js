"use strict";
// The address holds the session's token behind its #, which a browser does not send. It is shown once, in a header.
const enter = async () => {
  const token = new URLSearchParams(location.hash.slice(1)).get("token");
  if (!token) return;
  history.replaceState(null, "", "/"); // so that no list of visited pages holds it
  const told = document.getElementById("told");
  try {
    const answer = await fetch("/enter", { method: "POST", headers: { "x-erclutch-token": token } });
    if (answer.ok) location.replace((await answer.json()).to);
    else told.textContent = "This is not the token of this server. Open the address that it printed last.";
  } catch {
    told.textContent = "The server does not answer. Is the command still running?";
  }
};
window.addEventListener("hashchange", enter);
enter();
