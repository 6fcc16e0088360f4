"""The least error that any law of a form can have with the output held: `python studies/table3_bound.py --out FOLDER`.

A fit may miss by bad luck. This asks for no fit: of all laws of a form, whatever their numbers are and however they
were found, even with the held run at hand, which errs least with the output held, and is not worse in training than
the paper's table II allows? The forms, of each clutch:

- `HEM, RBFM`: a E**2 sgn(w) + eta(E) w with any a and any viscosity eta over the field. Bingham's law, HEM and RBFM
  of any number of kernels are such laws.
- `SS`: a E**2 y(w) sgn(w) + eta w with any a, any eta, and Seo and Seo's y of any two shape numbers.

Both errors are squares of the law's numbers, so the least is a convex problem, and by duality each weight of the
training error gives a number below which no such law can come. Each fit of the paper's laws is held to that. Rigs are
those of `studies/table3_front.py`, and some that have the ends of ranges together which lower the bound most. Each is
kept in FOLDER; the same command goes on there. Draws docs/images/table3-bound.svg.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import matplotlib
import numpy as np
from matplotlib.figure import Figure
from table3_front import IMAGES, anywhere, at_the_ends  # beside this file

from erclutch.fit.solver.one_thread import one_thread
from erclutch.logs.dataset import Dataset
from erclutch.signals.array import Array
from erclutch.wings.paper.commands.calibrate_twin import open_parameters
from erclutch.wings.paper.sweep_points import Points
from erclutch.wings.paper.tables import BASE, law_fit, printed, rows_of
from erclutch.wings.rig.twin.parameters import RigParameters, default_rig, load_rig
from erclutch.wings.rig.twin.scenarios import prepare

LAWS = ("seo-seo/forward", "hem/forward", "rbfm-10/forward")
AT_ENDS = "one parameter at an end of its range"
SHORT = {"seo-seo/forward": "SS", "hem/forward": "HEM", "rbfm-10/forward": "RBFM"}
VISCOSITY, BROKEN = "HEM, RBFM", "SS"
FORM = {"seo-seo/forward": BROKEN, "hem/forward": VISCOSITY, "rbfm-10/forward": VISCOSITY}
QUARTER = 1.25  # a ratio is met within a quarter
SECONDS, HELD_RUNS = 30.0, 3  # of training; runs of 20 s with the output held
RUNS = ("training", "held")
BOUND = "rbfm-10/forward least, table II"
MOST_ENDS = 10  # that are taken together
LEVEL = 1.5  # a level is met within this factor
NO_LAW = 2.0  # over Bingham's; beyond, the allowed training error is below that of each law
FIELDS = np.concatenate([np.linspace(0.0, 0.025, 6), np.linspace(0.05, 0.5, 19)])
SLIPS = np.concatenate([-np.geomspace(400.0, 0.05, 24), [0.0], np.geomspace(0.05, 400.0, 48)])
WEIGHTS = np.geomspace(1e-3, 1e4, 57)  # of the training error beside the held one
SIGNS = (1.0, -1.0)  # in which each clutch drives the output


def between(values: Array, knots: Array) -> Array:
    """Weights of the knots by which a line between them is read at some values, shape (n, knots)."""
    last = np.clip(np.searchsorted(knots, values, side="right") - 1, 0, knots.size - 2)
    share = np.clip((values - knots[last]) / (knots[last + 1] - knots[last]), 0.0, 1.0)
    weights = np.zeros((values.size, knots.size))
    rows = np.arange(values.size)
    weights[rows, last] = 1.0 - share
    weights[rows, last + 1] = share
    return weights


def any_viscosity(data: Dataset) -> Array:
    """Columns of laws whose viscosity is any function of the field, shape (n, 2 (1 + fields))."""
    columns: list[Array] = []
    for element, sign in zip(data.elements, SIGNS, strict=True):
        columns += [
            sign * element.field[:, None] ** 2,
            element.slip[:, None] * between(element.field, FIELDS),
        ]
    return np.hstack(columns)


def any_breaking(data: Dataset) -> Array:
    """Columns of laws whose yield effort is the square of the field times any function of slip."""
    columns: list[Array] = []
    for element, sign in zip(data.elements, SIGNS, strict=True):
        along = between(sign * element.slip, SLIPS)
        columns += [sign * element.field[:, None] ** 2 * along, element.slip[:, None]]
    return np.hstack(columns)


@dataclass(frozen=True)
class Errors:
    """The mean squared error of linear laws as a square of their numbers c: c' S c - 2 b' c + e.

    Attributes:
        squares: S, shape (p, p).
        by_effort: b, shape (p,).
        effort: e.
    """

    squares: Array
    by_effort: Array
    effort: float

    @classmethod
    def of(cls, columns: Callable[[Dataset], Array], runs: Sequence[Dataset]) -> Errors:
        """Over the rows of runs."""
        rows = sum(run.rows for run in runs)
        squares, by_effort, effort = 0.0, 0.0, 0.0
        for run in runs:
            these = columns(run)
            squares = squares + these.T @ these / rows
            by_effort = by_effort + these.T @ run.effort / rows
            effort += float(run.effort @ run.effort) / rows
        return cls(np.asarray(squares), np.asarray(by_effort), effort)

    def at(self, numbers: Array) -> float:
        """The error of a law."""
        return float(
            numbers @ self.squares @ numbers - 2.0 * self.by_effort @ numbers + self.effort
        )


def together(train: Errors, held: Errors, weight: float) -> tuple[Array, float]:
    """The numbers that make held + weight * training least, and that least value."""
    squares = held.squares + weight * train.squares
    wanted = held.by_effort + weight * train.by_effort
    scale = 1.0 / np.sqrt(np.maximum(np.diag(squares), 1e-300))
    numbers = (
        scale * np.linalg.lstsq(scale[:, None] * squares * scale, scale * wanted, rcond=1e-13)[0]
    )
    return numbers, held.effort + weight * train.effort - float(wanted @ numbers)


def least_held(train: Errors, held: Errors, allowed: float, weights: Array = WEIGHTS) -> float:
    """A number that the held error of no law can be below whose training error is at most what is allowed.

    For each weight of the training error, min (held + weight (training - allowed)) is such a number (weak duality).
    """
    return max(together(train, held, weight)[1] - weight * allowed for weight in weights.tolist())


def breaking_laws() -> Array:
    """Seo and Seo's laws in the columns of `any_breaking`, a mixture a law: shape (laws, p, 4)."""
    a, b = (
        grid.ravel()[:, None]
        for grid in np.meshgrid(np.geomspace(1e-3, 1e3, 73), np.geomspace(0.05, 6.0, 29))
    )
    size = a * np.abs(SLIPS)
    with np.errstate(over="ignore"):
        y = 1.0 + np.expm1(-size) / (1.0 + size**b)
    laws = np.zeros((len(y), 2, SLIPS.size + 1, 2, 2))
    for clutch in range(2):
        laws[:, clutch, :-1, clutch, 0] = y
        laws[:, clutch, -1, clutch, 1] = 1.0
    return laws.reshape(len(y), 2 * (SLIPS.size + 1), 4)


def least_held_of(laws: Array, train: Errors, held: Errors, allowed: float) -> float:
    """As `least_held`, of the best of some families of four numbers each; their shapes are a grid."""
    turned = laws.transpose(0, 2, 1)
    train_squares, held_squares = (turned @ each.squares @ laws for each in (train, held))
    train_effort, held_effort = (turned @ each.by_effort for each in (train, held))
    best = np.full(len(laws), -np.inf)
    for weight in WEIGHTS[::2].tolist():
        wanted = held_effort + weight * train_effort
        solved = np.linalg.pinv(held_squares + weight * train_squares, rcond=1e-12, hermitian=True)
        won = np.einsum("ki,kij,kj->k", wanted, solved, wanted)
        best = np.maximum(best, held.effort + weight * (train.effort - allowed) - won)
    return float(best.min())


@dataclass(frozen=True)
class Frontier:
    """Training and held errors of the laws of a form that a rig leaves."""

    train: Errors
    held: Errors
    laws: Array | None  # mixtures of the columns; None: any

    def least(self, allowed: float) -> float:
        """The held error that no law of the form is below, of those whose training error is at most what is allowed."""
        if self.laws is None:
            return least_held(self.train, self.held, allowed)
        return least_held_of(self.laws, self.train, self.held, allowed)


def frontiers(train: Dataset, held: Sequence[Dataset]) -> dict[str, Frontier]:
    """Of each form."""
    return {
        VISCOSITY: Frontier(
            Errors.of(any_viscosity, [train]), Errors.of(any_viscosity, held), None
        ),
        BROKEN: Frontier(
            Errors.of(any_breaking, [train]), Errors.of(any_breaking, held), breaking_laws()
        ),
    }


def rig_runs(rig: RigParameters, seed: int) -> tuple[Dataset, list[Dataset]]:
    """A training run, and runs with the output held."""
    train = rows_of(prepare("training", rig=rig, seed=seed, seconds=SECONDS))
    held = [
        rows_of(prepare("zero-motion", rig=rig, seed=3000 + 10 * seed + k))
        for k in range(HELD_RUNS)
    ]
    return train, held


def papers(name: str, run: str) -> float:
    """The paper's error of a law over Bingham's."""
    return (printed(name)[run] or np.nan) / (printed(BASE)[run] or np.nan)


def square(errors: Sequence[Array]) -> float:
    """Mean of the squares of all."""
    return float(np.mean(np.concatenate(errors) ** 2))


def judged(rig: RigParameters, seed: int = 1) -> dict[str, float]:
    """Errors of the fits over Bingham's, and what no law of each form is below, by name."""
    train, held = rig_runs(rig, seed)
    models = {name: law_fit(train, name).model for name in (BASE, *LAWS)}
    in_training = {
        name: square([train.effort - model.predict(train)]) for name, model in models.items()
    }
    off = {
        name: [run.effort - model.predict(run) for run in held] for name, model in models.items()
    }
    at_rest = {name: square(errors) for name, errors in off.items()}
    known = frontiers(train, held)
    found: dict[str, float] = {}
    for name in LAWS:
        form, of_base = known[FORM[name]], at_rest[BASE]
        found[f"{name} training"] = in_training[name] / in_training[BASE]
        found[f"{name} held"] = at_rest[name] / of_base
        as_papers = QUARTER * papers(name, "training") * in_training[BASE]
        found[f"{name} least"] = form.least(in_training[BASE]) / of_base
        found[f"{name} least, table II"] = form.least(as_papers) / of_base
        own = form.least(in_training[name] * (1.01 if form.laws is None else 1.03)) / of_base
        assert own <= found[f"{name} held"] * 1.01, (
            f"{name}: a fit of {found[f'{name} held']:.3f} is below {own:.3f}"
        )
    for run, data in zip(RUNS, ([train], held), strict=True):
        apart = [
            models["rbfm-10/forward"].predict(each) - models[BASE].predict(each) for each in data
        ]
        found[f"RBFM from Bingham, {run}"] = 1e3 * float(np.sqrt(square(apart)))
    found["level, training"], found["level, held"] = in_training[BASE], at_rest[BASE]
    return found


def reaches(found: Mapping[str, float], name: str, key: str) -> bool:
    """Whether a law of that form may come within a quarter of the paper's ratio."""
    return found[f"{name} {key}"] <= QUARTER * papers(name, "zero-motion")


def said(bound: float) -> str:
    """A bound, or that no law of the form trains so well."""
    return f"{bound:.2f}" if bound < NO_LAW else "no law"


def print_sets(sets: Mapping[str, Sequence[Mapping[str, float]]]) -> None:
    """Medians over seeds (least - most) of sets, and on how many seeds the paper's ratio is out of reach."""
    print(
        "| set | law | paper, held | fit | no law below | with table II's ratio | seeds out of reach |"
    )
    print("| --- | --- | --- | --- | --- | --- | --- |")
    for label, seeds in sets.items():
        for name in LAWS:
            cells = [f"{papers(name, 'zero-motion'):.2f}"]
            for key, form in (
                ("held", "{:.2f}".format),
                ("least", said),
                ("least, table II", said),
            ):
                values = np.array([found[f"{name} {key}"] for found in seeds])
                cells.append(
                    f"{form(np.median(values))} ({form(values.min())} - {form(values.max())})"
                )
            out = [
                sum(not reaches(found, name, key) for found in seeds)
                for key in ("least", "least, table II")
            ]
            print(
                f"| {label} | {SHORT[name]} | {' | '.join(cells)} | {out[0]}, {out[1]} of {len(seeds)} |"
            )
    print(
        "\n| set | RBFM differs from Bingham [mN m], training | output held |\n| --- | --- | --- |"
    )
    for label, seeds in sets.items():
        training, held = (
            float(np.median([found[f"RBFM from Bingham, {run}"] for found in seeds]))
            for run in RUNS
        )
        print(f"| {label} | {training:.1f} | {held:.1f} |")
    base, rbfm = printed(BASE), printed("rbfm-10/forward")
    differ = np.sqrt((base["training"] or 0.0) - (rbfm["training"] or 0.0))
    least = np.sqrt(base["zero-motion"] or 0.0) - np.sqrt(rbfm["zero-motion"] or 0.0)
    print(f"| paper | {1e3 * differ:.1f} | {1e3 * least:.1f} or more |")


def print_rigs(label: str, rigs: Mapping[str, Mapping[str, float]]) -> None:
    """Of many rigs: the least bound, and how many leave the paper's ratio in reach."""
    if not rigs:
        return
    print(f"\n{label}, {len(rigs)} rigs:")
    print(
        "| law | paper, held | no law below, least of the rigs | with table II's ratio | rigs in reach |"
    )
    print("| --- | --- | --- | --- | --- |")
    for name in LAWS:
        cells: list[str] = [f"{papers(name, 'zero-motion'):.2f}"]
        for key in ("least", "least, table II"):
            lowest = min(rigs, key=lambda rig: rigs[rig][f"{name} {key}"])
            cells.append(f"{said(rigs[lowest][f'{name} {key}'])} ({lowest})")
        inside = [
            sum(reaches(found, name, key) for found in rigs.values())
            for key in ("least", "least, table II")
        ]
        print(f"| {SHORT[name]} | {' | '.join(cells)} | {inside[0]}, {inside[1]} |")


def levels(found: Mapping[str, float]) -> tuple[float, float]:
    """Logarithms of Bingham's errors over the paper's, in training and with the output held."""
    theirs = {"training": printed(BASE)["training"], "held": printed(BASE)["zero-motion"]}
    training, held = (
        float(np.log(found[f"level, {run}"] / (theirs[run] or np.nan))) for run in RUNS
    )
    return training, held


def near_levels(rigs: Mapping[str, Mapping[str, float]]) -> dict[str, Mapping[str, float]]:
    """Rigs whose Bingham errs as the paper's does, within a factor of 1.5 in training and with the output held."""
    return {
        name: found for name, found in rigs.items() if max(map(abs, levels(found))) <= np.log(LEVEL)
    }


def ends_together(
    rig: RigParameters, paths: Sequence[str], ends: Mapping[str, Mapping[str, float]]
) -> dict[str, RigParameters]:
    """Rigs with the two, three, ... ends of ranges at once that lower the bound of RBFM most, one a parameter."""
    changes: dict[str, float] = {}
    rigs: dict[str, RigParameters] = {}
    for name in sorted(ends, key=lambda end: ends[end][BOUND]):
        path, _, value = name.rpartition(" ")
        if path in paths and path not in changes:
            changes[path] = float(value)
            rigs[f"{len(changes)} ends"] = rig.changed(changes)
    return dict(list(rigs.items())[1:MOST_ENDS])


def draw(rigs: Mapping[str, RigParameters]) -> None:
    """Training and held error that no law of the form of HEM and RBFM is below, the fits, and the paper."""
    matplotlib.rcParams.update({"svg.hashsalt": "erclutch", "svg.fonttype": "none", "font.size": 8})
    figure = Figure(figsize=(5.2, 3.4), layout="constrained")
    axes = figure.subplots()
    for (label, rig), colour in zip(rigs.items(), ("C3", "C2", "C1"), strict=False):
        train, held = rig_runs(rig, 1)
        base = law_fit(train, BASE).model
        scales = (
            square([train.effort - base.predict(train)]),
            square([r.effort - base.predict(r) for r in held]),
        )
        form = frontiers(train, held)[VISCOSITY]
        laws = [together(form.train, form.held, weight)[0] for weight in WEIGHTS]
        edge = np.array(
            [(form.train.at(law) / scales[0], form.held.at(law) / scales[1]) for law in laws]
        )
        axes.plot(*edge.T, colour, label=f"TWIN, {label}: no law below")
        for name, marker in (("hem/forward", "s"), ("rbfm-10/forward", "o")):
            model = law_fit(train, name).model
            x = square([train.effort - model.predict(train)]) / scales[0]
            y = square([r.effort - model.predict(r) for r in held]) / scales[1]
            axes.plot([x], [y], marker, color=colour, markersize=4)
    for name, marker in (("hem/forward", "s"), ("rbfm-10/forward", "o")):
        x, y = papers(name, "training"), papers(name, "zero-motion")
        axes.plot([x], [y], marker, color="k", markersize=6, label=f"paper, {SHORT[name]}")
    axes.plot([1.0], [1.0], "k+", markersize=8, label="Bingham")
    axes.set(xlim=(0.4, 1.6), ylim=(0.2, 1.1), xlabel="error in training, over Bingham's")
    axes.set_ylabel("error with the output held, over Bingham's")
    axes.legend(frameon=False, loc="lower right")
    figure.savefig(IMAGES / "table3-bound.svg", metadata={"Date": None})


def main() -> None:
    """Print the bounds and draw them."""
    parser = argparse.ArgumentParser(
        description="What no law can do with the output held, on the digital TWIN."
    )
    parser.add_argument("rigs", nargs="*", type=Path, metavar="RIG.toml", help="further sets")
    parser.add_argument("--out", type=Path, required=True, help="folder that keeps what is done")
    parser.add_argument("--seeds", type=int, default=10, help="of the sets")
    parser.add_argument("--drawn", type=int, default=64, help="rigs drawn anywhere")
    asked = parser.parse_args()
    asked.out.mkdir(exist_ok=True)
    rig = default_rig()
    paths = open_parameters(rig, with_log=False)
    known = Points(
        asked.out / "bounds.jsonl", {"rig": rig.to_dict(), "seconds": SECONDS, "held": HELD_RUNS}
    )
    sets = {"default": rig, **{path.stem: load_rig(path) for path in asked.rigs}}
    with one_thread():
        of_sets = {
            label: [
                known.get(f"{label} {seed}", partial(judged, each, seed))
                for seed in range(101, 101 + asked.seeds)
            ]
            for label, each in sets.items()
        }
        print(
            f"TWIN; {SECONDS:g} s of training, {HELD_RUNS} runs of 20 s with the output held, {asked.seeds} seeds\n"
        )
        print_sets(of_sets)
        draw({label: each for label, each in sets.items() if label != "held"})
        many = {
            AT_ENDS: at_the_ends(rig, paths),
            "all parameters anywhere": anywhere(rig, paths, asked.drawn),
        }
        groups = {
            label: {name: known.get(name, partial(judged, each)) for name, each in rigs.items()}
            for label, rigs in many.items()
        }
        together_at = ends_together(rig, paths, groups[AT_ENDS])
        groups["several parameters at the ends that lower the bound most"] = {
            name: known.get(name, partial(judged, each)) for name, each in together_at.items()
        }
    for label, rigs in groups.items():
        print_rigs(label, rigs)
    everything = {name: found for rigs in groups.values() for name, found in rigs.items()}
    print_rigs(
        f"all {len(everything)}, of which those with the paper's levels of Bingham",
        near_levels(everything),
    )


if __name__ == "__main__":
    main()
