"""What of tables II and III the TWIN can meet together: `python studies/table3_front.py --out FOLDER [RIG.toml ...]`.

Each rig is one dot. Across: how far the laws are from the paper in training and at zero field (levels and ratios, root
mean square of the logarithms). Up: the error of RBFM over Bingham's with the output held. Grey dots are rigs with all
open parameters drawn over their whole ranges, blue dots the default set with one parameter at an end of its range.
Each rig is kept in FOLDER as soon as it is done; the same command goes on there. Draws docs/images/table3-front.svg.
"""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from functools import partial
from pathlib import Path

import matplotlib
import numpy as np
from matplotlib.figure import Figure
from scipy.stats import qmc

from erclutch.fit.one_thread import one_thread
from erclutch.wings.paper.calibration.calibrate import value_at
from erclutch.wings.paper.calibration.paper_summary import summarise
from erclutch.wings.paper.commands.calibrate_twin import open_parameters
from erclutch.wings.paper.sweep_points import Points
from erclutch.wings.paper.tables import BASE, printed
from erclutch.wings.rig.twin.parameters import RigParameters, default_rig, load_rig

PICTURE = Path(__file__).resolve().parents[1] / "docs" / "images" / "table3-front.svg"
HELD = "zero-motion rbfm-10/forward over Bingham"
SEEDS, SECONDS, THIN = (1,), 30.0, 4


def figures(rig: RigParameters) -> dict[str, tuple[float, float]]:
    """Figures of a rig beside the paper's."""
    found = summarise(rig, SEEDS, SECONDS, THIN).against_paper()
    return {name: (ours, theirs) for name, (ours, theirs, _) in found.items()}


def apart(found: Mapping[str, tuple[float, float]]) -> float:
    """Root mean square of the logarithms of TWIN over paper, in training and at zero field."""
    logs = [np.log(ours / theirs) for name, (ours, theirs) in found.items() if name.startswith(("training", "zero-f"))]
    return float(np.sqrt(np.mean(np.square(logs))))


def at_the_ends(rig: RigParameters, paths: tuple[str, ...]) -> dict[str, RigParameters]:
    """The rig with one parameter at an end of its range, by parameter and end."""
    entries = {path: rig.entry(path) for path in paths}
    ends = {f"{path} {end}": (path, end) for path, entry in entries.items() for end in (entry.low, entry.high)}
    return {name: rig.changed({path: end}) for name, (path, end) in ends.items()}


def anywhere(rig: RigParameters, paths: tuple[str, ...], count: int) -> dict[str, RigParameters]:
    """Rigs with all parameters drawn over their whole ranges (Sobol)."""
    points = qmc.Sobol(len(paths), seed=1).random(count)
    return {
        f"rig {k}": rig.changed({p: value_at(rig.entry(p), float(u)) for p, u in zip(paths, point, strict=True)})
        for k, point in enumerate(points)
    }


def paper() -> float:
    """RBFM over Bingham with the output held, as the paper prints it."""
    return (printed("rbfm-10/forward")["zero-motion"] or np.nan) / (printed(BASE)["zero-motion"] or np.nan)


def drawn(groups: Mapping[str, list[tuple[float, float]]]) -> None:
    """The picture."""
    matplotlib.rcParams.update({"svg.hashsalt": "erclutch", "svg.fonttype": "none", "font.size": 8})
    figure = Figure(figsize=(5.2, 3.4), layout="constrained")
    axes = figure.subplots()
    styles = (("0.7", 8), ("C0", 12), ("C3", 40), ("C2", 40), ("C1", 40))
    for (label, dots), (colour, size) in zip(groups.items(), styles, strict=False):
        axes.scatter(*np.array(dots).T, s=size, color=colour, label=f"TWIN, {label}")
    axes.scatter([0.0], [paper()], s=70, marker="*", color="k", label="paper")
    axes.set(xlim=(-0.05, 3.0), ylim=(0.3, 2.5))
    axes.set_xlabel("distance from the paper in training and at zero field (RMS of logarithms)")
    axes.set_ylabel("RBFM over Bingham, output held")
    axes.legend(frameon=False, loc="upper right")
    figure.savefig(PICTURE, metadata={"Date": None})


def main() -> None:
    """Print the nearest rigs and draw all."""
    parser = argparse.ArgumentParser(description="What of tables II and III the TWIN can meet together.")
    parser.add_argument("rigs", nargs="*", type=Path, metavar="RIG.toml", help="further sets")
    parser.add_argument("--out", type=Path, required=True, help="folder that keeps what is done")
    parser.add_argument("--drawn", type=int, default=64, help="rigs drawn anywhere")
    asked = parser.parse_args()
    asked.out.mkdir(exist_ok=True)
    rig = default_rig()
    paths = open_parameters(rig, with_log=False)
    known = Points(asked.out / "rigs.jsonl", {"rig": rig.to_dict(), "seeds": SEEDS, "seconds": SECONDS})
    further = {path.stem: load_rig(path) for path in asked.rigs}
    sets = {
        "all parameters anywhere": anywhere(rig, paths, asked.drawn),
        "one parameter at an end": at_the_ends(rig, paths),
        "default set": {"default": rig},
        **{f"set {name}": {name: each} for name, each in further.items()},
    }
    groups: dict[str, list[tuple[float, float]]] = {}
    listed: list[tuple[float, float, str]] = []
    with one_thread():
        for label, rigs in sets.items():
            for name, each in rigs.items():
                found = known.get(name, partial(figures, each))
                groups.setdefault(label, []).append((apart(found), found[HELD][0]))
                listed.append((found[HELD][0], apart(found), name))
    print(f"TWIN; {len(listed)} rigs; paper: RBFM over Bingham {paper():.2f} with the output held\n")
    print("| rig | RBFM over Bingham, output held | distance in training and at zero field |\n| --- | --- | --- |")
    for held, distance, name in sorted(listed)[:8] + [each for each in listed if each[2] in ("default", *further)]:
        print(f"| {name} | {held:.2f} | {distance:.2f} |")
    drawn(groups)


if __name__ == "__main__":
    main()
