"""What of tables II and III the TWIN can meet together: `python studies/table3_front.py --out FOLDER [RIG.toml ...]`.

Each rig is one dot. Across: how far the laws are from the paper in training and at zero field (levels and ratios, root
mean square of the logarithms). Up: the error of RBFM over Bingham's with the output held. Grey dots are rigs with all
open parameters drawn over their whole ranges, blue dots the default set with one parameter at an end of its range.
A second picture and two tables tell for each figure how far one parameter at a time moves it, and which parameters do.
Dots of a fourth kind are of a search (CMA-ES) that is asked for the ratios with the output held and for nothing else:
how low they come at any price. A last table has laws that were trained with the output held: the least that any
training could leave on these rigs.
Each rig is kept in FOLDER as soon as it is done; the same command goes on there. Draws docs/images/table3-front.svg
and table3-reach.svg.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path

import matplotlib
import numpy as np
from matplotlib.figure import Figure
from scipy.stats import qmc

from erclutch.fit.solver.one_thread import one_thread
from erclutch.models.networks import is_network
from erclutch.signals.array import Array
from erclutch.wings.paper.calibration.calibrate import coordinate_of, value_at
from erclutch.wings.paper.calibration.calibration_search import wide
from erclutch.wings.paper.calibration.paper_summary import summarise
from erclutch.wings.paper.commands.calibrate_twin import open_parameters
from erclutch.wings.paper.published import APPROACHES
from erclutch.wings.paper.sweep_points import Points
from erclutch.wings.paper.tables import BASE, law_fit, printed, rows_of
from erclutch.wings.rig.twin.parameters import RigParameters, default_rig, load_rig
from erclutch.wings.rig.twin.parameters_file import write_rig
from erclutch.wings.rig.twin.scenarios import prepare

IMAGES = Path(__file__).resolve().parents[1] / "docs" / "images"
HELD = "zero-motion rbfm-10/forward over Bingham"
SEEDS, SECONDS, THIN = (1,), 30.0, 4
OTHER_SEEDS = (2, 3, 4, 5, 6)
ANYWHERE, AT_THE_ENDS = "all parameters anywhere", "one parameter at an end"
FOR_HELD, FOR_ALL = "searched for the held ratios alone", "searched from there for all figures"
Figures = Mapping[str, tuple[float, float]]  # TWIN and paper, by figure
Asks = Callable[[Figures], Figures]


def figures(rig: RigParameters, seeds: tuple[int, ...] = SEEDS) -> Figures:
    """Figures of a rig beside the paper's, means over seeds."""
    found = summarise(rig, seeds, SECONDS, THIN).against_paper()
    return {name: (ours, theirs) for name, (ours, theirs, _) in found.items()}


def apart(found: Figures) -> float:
    """Root mean square of the logarithms of TWIN over paper, in training and at zero field."""
    logs = [
        np.log(ours / theirs)
        for name, (ours, theirs) in found.items()
        if name.startswith(("training", "zero-f"))
    ]
    return float(np.sqrt(np.mean(np.square(logs))))


def at_the_ends(rig: RigParameters, paths: tuple[str, ...]) -> dict[str, RigParameters]:
    """The rig with one parameter at an end of its range, by parameter and end."""
    entries = {path: rig.entry(path) for path in paths}
    ends = {
        f"{path} {end}": (path, end)
        for path, entry in entries.items()
        for end in (entry.low, entry.high)
    }
    return {name: rig.changed({path: end}) for name, (path, end) in ends.items()}


def anywhere(rig: RigParameters, paths: tuple[str, ...], count: int) -> dict[str, RigParameters]:
    """Rigs with all parameters drawn over their whole ranges (Sobol)."""
    points = qmc.Sobol(len(paths), seed=1).random(count)
    return {
        f"rig {k}": rig.changed(
            {p: value_at(rig.entry(p), float(u)) for p, u in zip(paths, point, strict=True)}
        )
        for k, point in enumerate(points)
    }


Point = Array  # coordinates of a rig's open parameters, each from 0 to 1 over its range


def searched(
    rig: RigParameters,
    paths: Sequence[str],
    known: Points,
    name: str,
    start: Point,
    asks: Asks,
    count: int,
) -> dict[str, tuple[Point, Figures]]:
    """Points and figures of a search (CMA-ES) for some of the paper's figures, and for nothing else.

    Args:
        rig: whose open parameters are searched.
        paths: these parameters.
        known: what is done already.
        name: of the search; its rigs are numbered.
        start: where it begins.
        asks: the figures that are asked for, all with the same weight.
        count: rigs.
    """
    found: dict[str, tuple[Point, Figures]] = {}

    def logarithms(points: Sequence[Array]) -> list[Array]:
        residuals: list[Array] = []
        for point in points:
            number = f"{name} {len(found)}"
            these = known.get(number, partial(figures, at(rig, paths, point)))
            found[number] = point, these
            residuals.append(
                np.array([np.log(ours / theirs) for ours, theirs in asks(these).values()])
            )
        return residuals

    wide(logarithms, start, 1, count, Points(None, {}), lambda done, cost: None)
    return found


def at(rig: RigParameters, paths: Sequence[str], point: Point) -> RigParameters:
    """The rig at a point."""
    return rig.changed(
        {p: value_at(rig.entry(p), float(u)) for p, u in zip(paths, point, strict=True)}
    )


def away(found: Figures) -> float:
    """Sum of the squared logarithms of TWIN over paper."""
    return float(sum(np.log(ours / theirs) ** 2 for ours, theirs in found.values()))


def both_tables(found: Figures) -> Figures:
    """All figures but the warming."""
    return {name: pair for name, pair in found.items() if name != "warming"}


def held_ratios(found: Figures) -> Figures:
    """The laws over Bingham with the output held."""
    return {
        name: pair
        for name, pair in found.items()
        if name.startswith("zero-motion") and "over" in name
    }


def paper() -> float:
    """RBFM over Bingham with the output held, as the paper prints it."""
    return (printed("rbfm-10/forward")["zero-motion"] or np.nan) / (
        printed(BASE)["zero-motion"] or np.nan
    )


def print_sensitivities(ends: Mapping[str, Figures], default: Figures) -> None:
    """How far one parameter at a time moves each figure, and the parameters that move it most."""
    print(
        "\n| figure | paper | default set | one parameter at a time | moved most by (low end - high end of its range) |"
    )
    print("| --- | --- | --- | --- | --- |")
    paths = dict.fromkeys(name.partition(" ")[0] for name in ends)
    for figure, (ours, theirs) in default.items():
        moved = {
            path: [found[figure][0] for name, found in ends.items() if name.startswith(f"{path} ")]
            for path in paths
        }
        strongest = sorted(
            paths, key=lambda path: -np.abs(np.log(np.array(moved[path]) / ours)).max()
        )[:3]
        words = ", ".join(
            f"`{path}` {moved[path][0]:.3g} - {moved[path][1]:.3g}" for path in strongest
        )
        values = np.array(list(moved.values()))
        reach = f"{values.min():.3g} - {values.max():.3g}"
        print(f"| {figure} | {theirs:.3g} | {ours:.3g} | {reach} | {words} |")


def print_nearest(rigs: Mapping[str, Figures], within: float) -> None:
    """How low the ratios with the output held come, over all rigs and over those near to the paper elsewhere."""
    near = {name: found for name, found in rigs.items() if apart(found) < within}
    print(
        f"\n| output held | paper | least of {len(rigs)} rigs | least of {len(near)} rigs within {within:g} |"
    )
    print("| --- | --- | --- | --- |")
    for figure, (_, theirs) in held_ratios(next(iter(rigs.values()))).items():
        least = min(found[figure][0] for found in rigs.values())
        least_near = min(found[figure][0] for found in near.values())
        print(f"| {figure} | {theirs:.2f} | {least:.2f} | {least_near:.2f} |")


def print_front(
    rigs: Mapping[str, RigParameters], found: Mapping[str, Figures], known: Points
) -> None:
    """How low the held ratios come together, by how far the rest may be from the paper; then on seeds of their own."""
    print(
        "\n| distance elsewhere | rigs | SS, HEM, RBFM over Bingham of the nearest, output held | on five other seeds |"
    )
    print("| --- | --- | --- | --- |")
    for within in (0.3, 0.5, 1.0, np.inf):
        near = [name for name, each in found.items() if apart(each) < within]
        nearest = min(near, key=lambda name: away(held_ratios(found[name])))
        again = known.get(f"{nearest} again", partial(figures, rigs[nearest], OTHER_SEEDS))
        first, second = (
            ", ".join(f"{r:.2f}" for r, _ in held_ratios(f).values())
            for f in (found[nearest], again)
        )
        level = again[f"zero-motion {BASE}"]
        print(
            f"| {'any' if within == np.inf else f'below {within:g}'} | {len(near)} | {first} | {second}; "
            f"distance {apart(again):.2f}, level of Bingham, output held, {level[0] / level[1]:.2f} of the paper's |"
        )


def print_beside(default: Figures, nearest: Figures) -> None:
    """What comes nearest to all figures of both tables, beside the default set."""
    print(
        "\n| figure | paper | default set | nearest to all figures | over the paper |\n| --- | --- | --- | --- | --- |"
    )
    for figure, (ours, theirs) in nearest.items():
        print(
            f"| {figure} | {theirs:.3g} | {default[figure][0]:.3g} | {ours:.3g} | {ours / theirs:.2f} |"
        )


def trained_held(rig: RigParameters) -> Figures:
    """Errors over Bingham's with the output held, of laws that were trained so on another seed."""
    train, other = (
        rows_of(prepare("zero-motion", rig=rig, seed=seed, seconds=SECONDS))
        for seed in (4101, 4102)
    )
    laws = [
        name for name, known in APPROACHES.items() if known.zero_motion and not is_network(name)
    ]
    errors = {
        name: np.mean((other.effort - law_fit(train, name).model.predict(other)) ** 2)
        for name in laws
    }
    theirs = {name: APPROACHES[name].zero_motion or np.nan for name in laws}
    return {
        name: (float(errors[name] / errors[BASE]), theirs[name] / theirs[BASE])
        for name in laws
        if name != BASE
    }


def print_trained_held(rigs: Mapping[str, Figures]) -> None:
    """What laws that were trained with the output held reach, over the rigs with one parameter at an end."""
    print(
        f"\n| trained with the output held | paper, trained free | default set | least of {len(rigs)} rigs |"
    )
    print("| --- | --- | --- | --- |")
    for law, (ours, theirs) in rigs["default"].items():
        lowest = min(rigs, key=lambda name: rigs[name][law][0])
        print(
            f"| {law} over Bingham | {theirs:.2f} | {ours:.2f} | {rigs[lowest][law][0]:.2f} ({lowest}) |"
        )


def draw_front(groups: Mapping[str, Mapping[str, Figures]]) -> None:
    """The held ratio over the distance from the paper, a dot a rig."""
    figure = Figure(figsize=(5.2, 3.4), layout="constrained")
    axes = figure.subplots()
    styles = (("0.7", 8), ("C0", 12), ("C4", 8), ("C5", 8), ("C3", 40), ("C2", 40), ("C1", 40))
    for (label, rigs), (colour, size) in zip(groups.items(), styles, strict=False):
        dots = [(apart(found), found[HELD][0]) for found in rigs.values()]
        axes.scatter(*np.array(dots).T, s=size, color=colour, label=f"TWIN, {label}")
    axes.scatter([0.0], [paper()], s=70, marker="*", color="k", label="paper")
    axes.set(xlim=(-0.05, 3.0), ylim=(0.3, 2.5))
    axes.set_xlabel("distance from the paper in training and at zero field (RMS of logarithms)")
    axes.set_ylabel("RBFM over Bingham, output held")
    axes.legend(frameon=False, loc="upper right")
    figure.savefig(IMAGES / "table3-front.svg", metadata={"Date": None})


def draw_reach(groups: Mapping[str, Mapping[str, Figures]]) -> None:
    """Each figure over the paper's: the span of one parameter at a time, and the sets."""
    figure = Figure(figsize=(5.6, 3.6), layout="constrained")
    axes = figure.subplots()
    sets = {label: next(iter(rigs.values())) for label, rigs in groups.items() if len(rigs) == 1}
    names = [name for name in next(iter(sets.values())) if name != "warming"]
    places = np.arange(len(names))[::-1]
    over = np.array(
        [[np.divide(*found[name]) for name in names] for found in groups[AT_THE_ENDS].values()]
    )
    axes.hlines(
        places,
        over.min(axis=0),
        over.max(axis=0),
        color="C0",
        alpha=0.5,
        linewidth=6,
        label=AT_THE_ENDS,
    )
    for (label, found), colour in zip(sets.items(), ("C3", "C2", "C1", "C4"), strict=False):
        axes.scatter(
            [np.divide(*found[name]) for name in names],
            places,
            s=20,
            color=colour,
            zorder=3,
            label=label,
        )
    axes.axvline(1.0, color="k", linewidth=0.8, label="paper")
    axes.set_xscale("log")
    axes.set(xlim=(0.03, 30.0), xlabel="TWIN over paper")
    axes.set_yticks(places, [name.replace("/forward", "") for name in names])
    figure.legend(frameon=False, loc="outside lower center", ncols=5, fontsize=7)
    figure.savefig(IMAGES / "table3-reach.svg", metadata={"Date": None})


def main() -> None:
    """Print the nearest rigs and draw all."""
    parser = argparse.ArgumentParser(
        description="What of tables II and III the TWIN can meet together."
    )
    parser.add_argument("rigs", nargs="*", type=Path, metavar="RIG.toml", help="further sets")
    parser.add_argument("--out", type=Path, required=True, help="folder that keeps what is done")
    parser.add_argument("--drawn", type=int, default=64, help="rigs drawn anywhere")
    parser.add_argument(
        "--searched", type=int, default=240, help="rigs of the search for the held ratios alone"
    )
    parser.add_argument(
        "--searched-for-all", type=int, default=160, help="rigs of the search for all figures"
    )
    parser.add_argument(
        "--nearest", type=Path, help="rig file for what comes nearest to all figures"
    )
    asked = parser.parse_args()
    asked.out.mkdir(exist_ok=True)
    rig = default_rig()
    paths = open_parameters(rig, with_log=False)
    known = Points(
        asked.out / "rigs.jsonl", {"rig": rig.to_dict(), "seeds": SEEDS, "seconds": SECONDS}
    )
    sets = {
        ANYWHERE: anywhere(rig, paths, asked.drawn),
        AT_THE_ENDS: at_the_ends(rig, paths),
        "default set": {"default": rig},
        **{f"set {path.stem}": {path.stem: load_rig(path)} for path in asked.rigs},
    }
    with one_thread():
        groups = {
            label: {name: known.get(name, partial(figures, each)) for name, each in rigs.items()}
            for label, rigs in sets.items()
        }
        start = np.array([coordinate_of(entry, entry.value) for entry in map(rig.entry, paths)])
        for_held = searched(rig, paths, known, "searched", start, held_ratios, asked.searched)
        start, _ = min(for_held.values(), key=lambda pair: away(both_tables(pair[1])))
        for_all = searched(
            rig, paths, known, "searched for all", start, both_tables, asked.searched_for_all
        )
        held = {
            name: known.get(f"held {name}", partial(trained_held, each))
            for label in (AT_THE_ENDS, "default set")
            for name, each in sets[label].items()
        }
    rigs = {name: found for group in groups.values() for name, found in group.items()}
    print(f"TWIN; {len(rigs)} rigs; paper: RBFM over Bingham {paper():.2f} with the output held\n")
    print(
        "| rig | RBFM over Bingham, output held | distance in training and at zero field |\n| --- | --- | --- |"
    )
    lowest = sorted(rigs, key=lambda name: rigs[name][HELD][0])[:8]
    single = [name for group in groups.values() if len(group) == 1 for name in group]
    for name in (*lowest, *single):
        print(f"| {name} | {rigs[name][HELD][0]:.2f} | {apart(rigs[name]):.2f} |")
    print_nearest(rigs, 0.5)
    searches = {
        label: {name: found for name, (_, found) in search.items()}
        for label, search in ((FOR_HELD, for_held), (FOR_ALL, for_all))
    }
    for label, search in searches.items():
        print(f"\n{label}, {len(search)} rigs:")
        print_nearest(search, 0.5)
    all_rigs = {name: each for some in sets.values() for name, each in some.items()}
    all_rigs |= {
        name: at(rig, paths, point) for name, (point, _) in {**for_held, **for_all}.items()
    }
    print_front(all_rigs, {**rigs, **searches[FOR_HELD], **searches[FOR_ALL]}, known)
    point, nearest = min(
        [*for_held.values(), *for_all.values()], key=lambda pair: away(both_tables(pair[1]))
    )
    print_beside(rigs["default"], nearest)
    if asked.nearest:
        write_rig(asked.nearest, at(rig, paths, point))
    print_sensitivities(groups[AT_THE_ENDS], rigs["default"])
    print_trained_held(held)
    matplotlib.rcParams.update({"svg.hashsalt": "erclutch", "svg.fonttype": "none", "font.size": 8})
    drawn_first = {label: groups[label] for label in (ANYWHERE, AT_THE_ENDS)}
    draw_front({**drawn_first, **searches, **groups})
    draw_reach(groups)


if __name__ == "__main__":
    main()
