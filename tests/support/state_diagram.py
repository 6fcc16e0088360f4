"""The states of the live loop as a drawing, docs/images/states.svg, from what erclutch live --explain prints."""

from __future__ import annotations

from pathlib import Path

#: How far an arrow bows, as a share of its length, where it would meet another one.
_BOWS = {("starting", "tripped"): -0.4, ("tripped", "ready"): -0.42, ("ready", "tripped"): -0.42}


def draw_states(file: Path) -> None:
    """States as boxes, events as arrows between them. An event with no more effect than a good sample is not drawn."""
    import matplotlib as mpl
    from matplotlib.figure import Figure

    from erclutch.wings.live.explained_states import transitions

    places = {
        "starting": (0.7, 3.0),
        "running": (4.6, 3.0),
        "tripped": (9.2, 3.0),
        "ready": (6.9, 0.6),
    }
    arrows: dict[tuple[str, str], list[str]] = {}
    usual: dict[str, str] = {}
    for line in transitions():
        state, after = line.state.name.lower(), line.next.name.lower()
        plain = usual.setdefault(state, after)  # a good sample comes first
        moves = state != after and after in places
        first_of_arrow = not arrows.get((state, after))
        if moves and (after != plain or first_of_arrow):
            arrows.setdefault((state, after), []).append(line.event.removeprefix("order: "))
    with mpl.rc_context({"svg.fonttype": "none", "svg.hashsalt": "states", "font.size": 10}):
        figure = Figure((10, 4.9))
        axes = figure.add_axes((0, 0, 1, 1), xlim=(-0.2, 10.4), ylim=(0.1, 5.2))
        axes.axis("off")
        for (start, end), events in arrows.items():
            x0, y0 = places[start]
            x1, y1 = places[end]
            bow = _BOWS.get((start, end), -0.13)
            arrow = {
                "arrowstyle": "-|>",
                "color": "#667",
                "shrinkA": 50,
                "shrinkB": 60,
                "connectionstyle": f"arc3,rad={bow}",
            }
            axes.annotate("", (x1, y1), (x0, y0), arrowprops=arrow)
            # The words stand on the middle of the bow.
            x = (x0 + x1) / 2 + bow / 2 * (y1 - y0)
            y = (y0 + y1) / 2 - bow / 2 * (x1 - x0)
            white = {"facecolor": "white", "edgecolor": "none", "pad": 1.5}
            axes.text(x, y, "\n".join(events), ha="center", va="center", fontsize=8, bbox=white)
        for name, (x, y) in places.items():
            colour = {"running": "#d8ecd9", "tripped": "#f6d9d5"}.get(name, "#e6e9ef")
            box = {"boxstyle": "round,pad=0.6", "facecolor": colour, "edgecolor": "#667"}
            fields = "fields by the program" if name == "running" else "fields at zero"
            axes.text(x, y, f"{name}\n{fields}", ha="center", va="center", bbox=box)
        ending = (
            "Stop, a signal or a parent that is gone:\nfrom each state to the end, at zero field"
        )
        axes.text(0.1, 0.5, ending, fontsize=8)
        figure.savefig(file, metadata={"Date": None, "Title": "States of the live loop"})
