// Reports within a page.

/** A report is as high as it is, so that there is one scroll bar; it tells its height, and where its links lead to. */
export function fillFrames() {
  const frames = [...document.querySelectorAll(".framed iframe")];
  for (const frame of frames) {
    const waiting = frame.previousElementSibling;
    frame.addEventListener("load", () => { waiting.textContent = ""; });
    frame.src = frame.dataset.src;
  }
  addEventListener("message", ({ source, data }) => {
    const frame = frames.find(({ contentWindow }) => contentWindow === source);
    if (!frame) return;
    const { height, top } = Object(data); // a report may send anything
    if (Number.isFinite(height)) frame.style.height = `${Math.min(height + 4, 60_000)}px`;
    if (Number.isFinite(top)) {
      const place = frame.getBoundingClientRect().top + scrollY + top - 10;
      scrollTo({ top: place, behavior: "smooth" });
    }
  });
}
