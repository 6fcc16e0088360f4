// Whatever scrolls can be reached by keyboard, and the theme's captions say how deep they are.
document.addEventListener("DOMContentLoaded", () => {
  document.querySelectorAll("pre, .table-wrapper").forEach((block) => block.setAttribute("tabindex", "0"));
  document.querySelectorAll('.caption[role="heading"]').forEach((head) => head.setAttribute("aria-level", "2"));
});
