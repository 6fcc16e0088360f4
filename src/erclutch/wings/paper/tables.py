"""Tables II and III fit the paper's models to a training log and score them on it and on other runs."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from time import process_time

import numpy as np

from erclutch.fit.choice.scoring import block_rows, score
from erclutch.fit.laws.fit_law import fit_structure
from erclutch.fit.networks.fit_network import fit_network
from erclutch.fit.solver.one_thread import one_thread
from erclutch.fit.solver.outcome import FitOutcome
from erclutch.logs.dataset import Dataset, build_dataset
from erclutch.models.law_model import TorqueModel
from erclutch.models.laws import law_from_name
from erclutch.models.model import Model
from erclutch.models.networks import is_network, network_from_name
from erclutch.models.structure import Structure
from erclutch.signals.speed import Derivative
from erclutch.wings.paper.published import APPROACHES
from erclutch.wings.rig.twin.parameters import RigParameters
from erclutch.wings.rig.twin.scenarios import TwinRun, prepare

BASE = "bingham/forward"
#: Speeds as a controller at 1 kHz has them.
DERIVATIVE = Derivative("difference")
_SKIPPED = 50  # rows at the start of a run, while the housings settle


@dataclass(frozen=True)
class Row:
    """One model of a table.

    Attributes:
        name, title: ours.
        errors: run -> mean squared error; the first run is the training one.
        bands: run -> 95 % band of that error (block bootstrap).
        seconds: CPU time of the fit.
        parameters: number of parameters or weights.
        model: the fitted model.
    """

    name: str
    title: str
    errors: Mapping[str, float]
    bands: Mapping[str, tuple[float, float]]
    seconds: float
    parameters: int
    model: Model


def twin_runs(
    names: Sequence[str],
    *,
    rig: RigParameters | None = None,
    seed: int = 0,
    seconds: float | None = None,
) -> dict[str, Dataset]:
    """Runs of the twin as rows, by scenario; each has a seed of its own.

    Args:
        names: scenarios.
        rig: parameters; None is the default rig.
        seed: of the first run; the others follow.
        seconds: of the training run; the others keep their own length, at most this.
    """
    rows: dict[str, Dataset] = {}
    for number, name in enumerate(names):
        own_seed = seed + 1000 * number
        run = prepare(name, rig=rig, seed=own_seed)
        if seconds is not None and (name == "training" or run.scenario.seconds > seconds):
            run = prepare(name, rig=rig, seed=own_seed, seconds=seconds)
        rows[name] = rows_of(run)
    return rows


def rows_of(run: TwinRun) -> Dataset:
    """A run of the twin as rows with differenced speeds, without its first moments."""
    data = build_dataset(run.recording(), device="coaxial", derivative=DERIVATIVE)
    return data.take(np.arange(data.rows) >= _SKIPPED)


def table(
    runs: Mapping[str, Dataset],
    *,
    models: Sequence[str] = tuple(APPROACHES),
    seed: int = 0,
    polish: bool = False,
    progress: Callable[[int, int, str], None] | None = None,
) -> list[Row]:
    """Fit models to the first run and score them on all.

    Args:
        runs: run -> rows; the first is the training run.
        models: names of laws and networks.
        seed: of the networks' starts and of the bootstrap.
        polish: whether networks get a last round over all rows.
        progress: called after each fit.
    """
    train = next(iter(runs.values()))

    rows: list[Row] = []
    with one_thread():
        for done, name in enumerate(models, start=1):
            began = process_time()
            if is_network(name):
                network = network_from_name(name, train.device)
                fitted = fit_network(train, network, seed=seed, polish=polish)
            else:
                fitted = law_fit(train, name)
            seconds = process_time() - began
            model = fitted.model
            errors: dict[str, float] = {}
            bands: dict[str, tuple[float, float]] = {}
            for run, data in runs.items():
                predicted = model.predict(data)
                block = block_rows([data.effort - predicted])
                mse = score(data.effort, predicted, block=block, seed=seed).mse
                errors[run] = mse.value
                bands[run] = (mse.low, mse.high)
            parameters = fitted.parameters
            rows.append(Row(name, model.title, errors, bands, seconds, parameters, model))
            if progress is not None:
                progress(done, len(models), name)
    return rows


def law_fit(train: Dataset, name: str) -> FitOutcome[TorqueModel]:
    """A law without dynamics, fitted to rows; no intervals."""
    law = law_from_name(name, train.device)
    structure = Structure(train.device, name, law)
    return fit_structure(train, structure, intervals=False)


def printed(name: str) -> dict[str, float | None]:
    """What the paper prints for a model: run -> mean squared error."""
    known = APPROACHES.get(name)
    if known is None:
        return {}
    return {
        "training": known.train,
        "test": known.test,
        "zero-field": known.zero_field,
        "zero-motion": known.zero_motion,
    }
