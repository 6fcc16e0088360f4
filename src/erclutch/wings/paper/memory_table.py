"""The models of table II once more, as in the paper, with the sign of the slip, with memory and with past samples."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

from erclutch.fit.comparison import Settings, compare
from erclutch.fit.data_check import steady_command
from erclutch.fit.kinds.law_alone import structures_for
from erclutch.fit.ladder import grown
from erclutch.fit.one_thread import one_thread
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
    runs: Mapping[str, Dataset], points: Points, seed: int, polish: bool, report: Callable[[int, int, str], None]
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
    data = joined([replace(rows, sources=(name,)) for name, rows in runs.items()])
    alone = data.device == "single"
    stages = str(points.get("stages", partial(_stages, runs[train])))

    # The variants besides the paper's own.
    laws = tuple(name.removesuffix("/forward") for name in PAPER)
    plain = Settings((*laws, *PAPER_NETWORKS), lag="none", test=(test,), seed=seed, polish=polish)
    asked: dict[str, Settings] = {}
    if not alone:
        asked["sign of the slip"] = replace(plain, models=laws)
    asked["memory"] = replace(plain, lag=stages)
    asked["past samples"] = replace(plain, models=PAPER_NETWORKS, past=PAST)
    asked["memory and past"] = replace(plain, models=PAPER_NETWORKS, lag=stages, past=PAST)

    total = 1 + len(asked)
    own = "as in the paper"
    papers = (*laws, *PAPER_NETWORKS) if alone else (*PAPER, *PAPER_NETWORKS)
    variants = {own: points.get(own, partial(_as_in_the_paper, runs, papers, seed, polish))}
    report(1, total, own)
    for done, (variant, settings) in enumerate(asked.items(), start=2):
        variants[variant] = points.get(variant, partial(_scored, data, settings))
        report(done, total, variant)
    return stages, variants


def _stages(train: Dataset) -> str:
    """The memory that the ladder gives to Bingham's law on the training rows."""
    lag = "none" if steady_command(train) else "lag"
    bingham, *_ = structures_for(train, Settings(models=("bingham",), lag=lag))
    with one_thread():
        rungs = grown(train, bingham)
    return rungs[-1].structure.dynamics


def _as_in_the_paper(runs: Mapping[str, Dataset], models: Sequence[str], seed: int, polish: bool) -> dict[str, Figures]:
    """Figures of table II: its networks have no law beside them, as those of a comparison have."""
    by_model: dict[str, Figures] = {}
    for row in table(runs, models=models, seed=seed, polish=polish):
        figures: dict[str, Any] = {"parameters": row.parameters}
        for run in runs:
            figures[run] = [row.errors[run], *row.bands[run]]
        by_model[row.name.removesuffix("/forward")] = figures
    return by_model


def _scored(data: Dataset, settings: Settings) -> dict[str, Figures]:
    """Figures of all models that the settings ask for, of a comparison of both runs."""
    train, test = data.sources
    by_model: dict[str, Figures] = {}
    for entry in compare(data, settings).entries:
        specification = entry.outcome.model.structure.specification
        by_model[specification.removesuffix("/forward")] = {
            "parameters": entry.outcome.parameters,
            train: entry.train.mse.to_list(),
            test: entry.test.mse.to_list(),
        }
    return by_model


def noise_floor(rig: RigParameters) -> float:
    """Variance of what the twin's torque meter adds by itself, noise and quantisation: no model can do better."""
    return rig.value("sensors.torque_noise") ** 2 + rig.value("sensors.torque_step") ** 2 / 12.0
