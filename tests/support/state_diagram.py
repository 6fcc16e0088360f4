"""The states of the live loop as a drawing, docs/images/states.svg, from what erclutch live --explain prints."""

from __future__ import annotations

from pathlib import Path


def draw_states(file: Path) -> None:
    """States as boxes, events as arrows between them. An event with no more effect than a good sample is not drawn."""
    import matplotlib as mpl
    from matplotlib.figure import Figure

    from erclutch.wings.live.explained_states import transitions

    places = {"starting": (0.7, 3.0), "running": (4.6, 3.0), "tripped": (9.2, 3.0), "ready": (6.9, 0.6)}
    arrows: dict[tuple[str, str], list[str]] = {}
    usual: dict[str, str] = {}
    for line in transitions():
        state, after = line.state.name.lower(), line.next.name.lower()
        plain = usual.setdefault(state, after)  # a good sample comes first
        if state != after and after in places and (after != plain or not arrows.get((state, after))):
            arrows.setdefault((state, after), []).append(line.event.removeprefix("order: "))
    with mpl.rc_context({"svg.fonttype": "none", "svg.hashsalt": "states", "font.size": 10}):
        figure = Figure((10, 4.9))
        axes = figure.add_axes((0, 0, 1, 1), xlim=(-0.2, 10.4), ylim=(0.1, 5.2))
        axes.axis("off")
        for (start, end), events in arrows.items():
            (x0, y0), (x1, y1) = places[start], places[end]
            bow = {"startingtripped": -0.4, "trippedready": -0.42, "readytripped": -0.42}.get(start + end, -0.13)
            style = {"arrowstyle": "-|>", "color": "#667", "shrinkA": 50, "shrinkB": 60}
            axes.annotate("", (x1, y1), (x0, y0), arrowprops={**style, "connectionstyle": f"arc3,rad={bow}"})
            at = (x0 + x1) / 2 + bow / 2 * (y1 - y0), (y0 + y1) / 2 - bow / 2 * (x1 - x0)
            axes.text(*at, "\n".join(events), ha="center", va="center", fontsize=8,
                      bbox={"facecolor": "white", "edgecolor": "none", "pad": 1.5})  # fmt: skip
        for name, (x, y) in places.items():
            colour = {"running": "#d8ecd9", "tripped": "#f6d9d5"}.get(name, "#e6e9ef")
            box = {"boxstyle": "round,pad=0.6", "facecolor": colour, "edgecolor": "#667"}
            fields = "fields by the program" if name == "running" else "fields at zero"
            axes.text(x, y, f"{name}\n{fields}", ha="center", va="center", bbox=box)
        ending = "Stop, a signal or a parent that is gone:\nfrom each state to the end, at zero field"
        axes.text(0.1, 0.5, ending, fontsize=8)
        figure.savefig(file, metadata={"Date": None, "Title": "States of the live loop"})
