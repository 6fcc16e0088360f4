"""The models of table II once more, as in the paper, with the sign of the slip, with memory and with past samples."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from typing import Any

from erclutch.fit.checks.data_check import steady_command
from erclutch.fit.choice.ladder import grown
from erclutch.fit.comparison import Settings, compare
from erclutch.fit.kinds.law_alone import structures_for
from erclutch.fit.solver.one_thread import one_thread
from erclutch.logs.dataset import Dataset, joined
from erclutch.models.laws import PAPER
from erclutch.models.networks import PAPER_NETWORKS
from erclutch.wings.paper.sweep_points import Points
from erclutch.wings.paper.tables import table
from erclutch.wings.rig.twin.parameters import RigParameters

#: How far back the past samples lie.
PAST = ("1ms", "2ms", "4ms")

#: Of a model: number of parameters, then for each run its mean squared error and the ends of the 95 % band.
Figures = Mapping[str, Any]


def memory_table(
    runs: Mapping[str, Dataset],
    points: Points,
    seed: int,
    polish: bool,
    report: Callable[[int, int, str], None],
) -> tuple[str, dict[str, dict[str, Figures]]]:
    """Fit the models of table II in each variant to the first run, and score them on both.

    Args:
        runs: the training run, then the test run.
        points: where finished variants are kept.
        seed: of the networks' starts and of the bootstrap.
        polish: whether networks get a last round over all rows.
        report: called after each variant.

    Returns:
        The stages of the memory, and variant -> model -> figures. Models are called as in `PAPER` without ``/forward``.
    """
    train, test = runs
    sources = [replace(rows, sources=(name,)) for name, rows in runs.items()]
    data = joined(sources)

    def stages_of_bingham() -> str:
        """The memory that the ladder gives to Bingham's law on the training rows."""
        lag = "none" if steady_command(runs[train]) else "lag"  # a steady command shows no lag
        settings = Settings(models=("bingham",), lag=lag)
        bingham, *_ = structures_for(runs[train], settings)
        with one_thread():
            rungs = grown(runs[train], bingham)
        highest = rungs[-1]
        return highest.structure.dynamics

    stages = str(points.get("stages", stages_of_bingham))

    # The slip of a single element turns, so there no law keeps the sign in which the device drives.
    laws_by_slip = tuple(name.removesuffix("/forward") for name in PAPER)
    is_pair = data.device != "single"
    laws = PAPER if is_pair else laws_by_slip

    plain = Settings(
        (*laws_by_slip, *PAPER_NETWORKS),
        lag="none",
        test=(test,),
        seed=seed,
        polish=polish,
    )
    networks = replace(plain, models=PAPER_NETWORKS)

    def as_in_the_paper() -> dict[str, Figures]:
        """Figures of table II: its networks have no law beside them, as those of a comparison have."""
        by_model: dict[str, Figures] = {}
        for row in table(runs, models=(*laws, *PAPER_NETWORKS), seed=seed, polish=polish):
            figures: dict[str, Any] = {"parameters": row.parameters}
            for run in runs:
                figures[run] = [row.errors[run], *row.bands[run]]
            name = row.name.removesuffix("/forward")
            by_model[name] = figures
        return by_model

    makers: dict[str, Callable[[], dict[str, Figures]]] = {}
    makers["as in the paper"] = as_in_the_paper
    if is_pair:
        makers["sign of the slip"] = partial(_scored, data, replace(plain, models=laws_by_slip))
    with_memory = replace(plain, lag=stages)
    makers["memory"] = partial(_scored, data, with_memory)
    with_past = replace(networks, past=PAST)
    makers["past samples"] = partial(_scored, data, with_past)
    both = replace(networks, lag=stages, past=PAST)
    makers["memory and past"] = partial(_scored, data, both)

    variants: dict[str, dict[str, Figures]] = {}
    for done, (variant, make) in enumerate(makers.items(), start=1):
        variants[variant] = points.get(variant, make)
        report(done, len(makers), variant)
    return stages, variants


def _scored(data: Dataset, settings: Settings) -> dict[str, Figures]:
    """Figures of all models that the settings ask for, of a comparison of both runs."""
    train, test = data.sources
    by_model: dict[str, Figures] = {}
    comparison = compare(data, settings)
    for entry in comparison.entries:
        specification = entry.outcome.model.structure.specification
        name = specification.removesuffix("/forward")
        by_model[name] = {
            "parameters": entry.outcome.parameters,
            train: entry.train.mse.to_list(),
            test: entry.test.mse.to_list(),
        }
    return by_model


def noise_floor(rig: RigParameters) -> float:
    """Variance of what the twin's torque meter adds by itself, noise and quantisation: no model can do better."""
    noise = rig.value("sensors.torque_noise")  # standard deviation [N m]
    step = rig.value("sensors.torque_step")  # [N m]; a rounding error is even over a step
    return noise**2 + step**2 / 12.0
