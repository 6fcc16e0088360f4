"""Runs are compared on the rows that all of them held out: differences of errors, settings that differ."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from erclutch.errors import RunError, SettingError
from erclutch.fit.choice.scoring import BandedFigure, Score, block_rows, difference, excess, score
from erclutch.models.stages import stages_at
from erclutch.models.stages.stage import Place
from erclutch.runs.run_folder import Run
from erclutch.runs.run_rows import RunRows, read_rows
from erclutch.signals.array import Array, rms

Rows = NDArray[np.int64]

_FEWEST = 50  # shared rows
_PLACES: tuple[Place, ...] = ("command", "slip", "effort", "temperature", "position")
#: Settings that a model's own parts show, or that change no model.
_SEEN = ("models", "lag", "past", "blocks", "polish")


@dataclass(frozen=True)
class Contender:
    """One run in a comparison.

    Attributes:
        label: what it is called: the folder's name, or as much of its path as tells it from the others.
        run: the run.
        rows: its rows.
        model: name of the model that stands for it.
        shared: which of its rows all runs held out, in the same order for all, shape (n,).
        figures: of that model on those rows.
        more: RMSE over the first run's, in the effort's unit; None for the first.
        share: the same as a share of the first run's RMSE; None for the first.
    """

    label: str
    run: Run
    rows: RunRows
    model: str
    shared: Rows
    figures: Score
    more: BandedFigure | None
    share: BandedFigure | None

    @property
    def residual(self) -> Array:
        """Measured minus estimated on the shared rows."""
        return self.rows.residual(self.model)[self.shared]


@dataclass(frozen=True)
class SameModel:
    """A model that the first and another run have.

    Attributes:
        name: of the model.
        label: of the other run.
        first, other: RMSE on the shared rows.
        share: how much larger the other's is, as a share, paired.
    """

    name: str
    label: str
    first: float
    other: float
    share: BandedFigure


@dataclass(frozen=True)
class Change:
    """One thing in which the models of two runs differ.

    Attributes:
        what: the thing.
        first, other: as text, "none" where there is nothing.
    """

    what: str
    first: str
    other: str


@dataclass(frozen=True)
class Pairing:
    """Runs on the rows that all of them held out.

    Attributes:
        contenders: in the order given.
        rows: number of shared rows.
        block: rows of a bootstrap block.
        differing: settings that differ: name, then one value a run as text.
        same: models that several runs have.
        whole: whether all runs have the same rows and held out the same ones.
    """

    contenders: tuple[Contender, ...]
    rows: int
    block: int
    differing: tuple[tuple[str, tuple[str, ...]], ...]
    same: tuple[SameModel, ...]
    whole: bool


def pair(
    runs: Sequence[Run],
    models: Sequence[str] = (),
    seed: int = 0,
) -> Pairing:
    """Put runs side by side.

    Args:
        runs: two or more; differences are to the first.
        models: which model stands for each run; one name for all, or none: the recommended ones.
        seed: of the bootstrap.

    Raises:
        SettingError: fewer than two runs, the same one twice, or names that do not match them.
        RunError: a run without such a model, another effort or unit, or no row that all held out.
    """
    if len(runs) < 2:
        raise SettingError(
            "a comparison needs two runs or more", remedy="Write erclutch compare RUN RUN"
        )
    folders = [run.folder.resolve() for run in runs]
    if len(set(folders)) < len(folders):
        twice = next(f for f in folders if folders.count(f) > 1)
        raise SettingError("the same run twice", where=str(twice), remedy="Give each run once")
    if len(models) > 1 and len(models) != len(runs):
        raise SettingError(
            f"{len(models)} models for {len(runs)} runs",
            remedy="Give --model once, once a run, or not at all",
        )
    if not models:
        wanted = [str(run.body["recommended"]) for run in runs]
    else:
        wanted = list(models) * len(runs) if len(models) == 1 else list(models)
    entries = [run.entry(name) for run, name in zip(runs, wanted, strict=True)]
    names = [str(entry["name"]) for entry in entries]

    loaded = [read_rows(run) for run in runs]
    unit = runs[0].body["units"]["effort"]
    for run in runs[1:]:
        own_unit = run.body["units"]["effort"]
        if own_unit != unit:
            raise RunError(
                f"the effort is in {own_unit or '1'}, that of {runs[0].folder} in {unit or '1'}",
                where=str(run.folder),
                remedy="Compare runs of the same logs, read with the same units",
            )
    shared = _shared(runs, loaded)
    residuals: list[Array] = []  # of each run on the shared rows
    for run, rows, name, at in zip(runs, loaded, names, shared, strict=True):
        residual = rows.residual(name)[at]
        if not np.all(np.isfinite(residual)):
            problem = f"{name} gives no finite effort"
            raise RunError(problem, where=str(run.folder), remedy="Choose another with --model")
        residuals.append(residual)

    # The same blocks of rows for all runs, so that a difference is of models and not of rows.
    block = block_rows(residuals)
    labels = _labels(folders)
    contenders: list[Contender] = []
    whole = True
    for place, (run, rows, name, at) in enumerate(zip(runs, loaded, names, shared, strict=True)):
        measured = rows.data.effort[at]
        estimated = rows.predicted[name][at]
        more = share = None  # of the first run, with which the others are compared
        if place:
            more = difference(residuals[place], residuals[0], block=block, seed=seed)
            share = excess(residuals[place], residuals[0], block=block, seed=seed)
        contender = Contender(
            label=labels[place],
            run=run,
            rows=rows,
            model=name,
            shared=at,
            figures=score(measured, estimated, block=block, seed=seed),
            more=more,
            share=share,
        )
        contenders.append(contender)
        same_rows = np.array_equal(rows.test, loaded[0].test)
        whole = whole and same_rows and at.size == int(rows.test.sum())
    return Pairing(
        contenders=tuple(contenders),
        rows=shared[0].size,
        block=block,
        differing=differing_settings([run.body for run in runs]),
        same=_same(contenders, block, seed),
        whole=whole,
    )


def _shared(runs: Sequence[Run], loaded: Sequence[RunRows]) -> list[Rows]:
    """Rows of each run that all of them held out, matched by the log's digest and the time stamp."""
    # Times that increase and their rows, by a log's digest.
    tables: list[dict[str, tuple[Array, Rows]]] = []
    for run, rows in zip(runs, loaded, strict=True):
        of_logs: dict[str, tuple[Array, Rows]] = {}
        for log, (start, stop) in zip(run.body["logs"], rows.data.source_rows, strict=True):
            at = start + np.flatnonzero(rows.test[start:stop])
            time = rows.data.clock.time[at]
            order = np.argsort(time, kind="stable")
            of_logs[str(log["sha256"])] = (time[order], at[order])
        tables.append(of_logs)
    of_runs: list[list[Rows]] = [[] for _ in runs]  # rows of each log, of each run
    for digest in tables[0]:
        if not all(digest in table for table in tables):
            continue
        times, _ = tables[0][digest]
        for table in tables[1:]:
            times = np.intersect1d(times, table[digest][0])
        for of_run, table in zip(of_runs, tables, strict=True):
            own_times, own_rows = table[digest]
            of_run.append(own_rows[np.searchsorted(own_times, times)])
    nothing = np.zeros(0, np.int64)
    shared = [np.concatenate([nothing, *of_run]) for of_run in of_runs]
    if shared[0].size < _FEWEST:
        raise RunError(
            f"only {shared[0].size} rows were held out by all runs, at least {_FEWEST} are needed",
            where=" and ".join(str(run.folder) for run in runs),
            remedy="Compare runs of the same logs, with the same --test, --from and --until; runs of other logs are "
            "compared on a log of your choice: erclutch score LOG --run RUN RUN",
        )
    efforts = [rows.data.effort[at] for rows, at in zip(loaded, shared, strict=True)]
    for run, effort in zip(runs[1:], efforts[1:], strict=True):
        if not np.allclose(effort, efforts[0], rtol=1e-9, atol=0.0):
            raise RunError(
                f"the effort of these rows is not that of {runs[0].folder}",
                where=str(run.folder),
                remedy="Compare runs that read the same column as the effort",
            )
    return shared


def _labels(folders: Sequence[Path]) -> list[str]:
    """Names of the folders; with as many parents as are needed to tell them apart."""
    for depth in range(1, 12):
        labels = ["/".join(f.parts[-depth:]) for f in folders]
        if len(set(labels)) == len(labels):
            return labels
    return [str(f) for f in folders]


def _same(contenders: Sequence[Contender], block: int, seed: int) -> tuple[SameModel, ...]:
    """Models that the first run and another one have, as far as their efforts are finite."""
    first = contenders[0]
    same: list[SameModel] = []
    for other in contenders[1:]:
        for name in first.run.names:
            if name not in other.run.names:
                continue
            of_first = first.rows.residual(name)[first.shared]
            of_other = other.rows.residual(name)[other.shared]
            if not (np.all(np.isfinite(of_first)) and np.all(np.isfinite(of_other))):
                continue
            share = excess(of_other, of_first, block=block, seed=seed)
            rms_of_first = rms(of_first)
            rms_of_other = rms(of_other)
            same.append(SameModel(name, other.label, rms_of_first, rms_of_other, share))
    return tuple(same)


def changes(first: Contender, other: Contender) -> tuple[Change, ...]:
    """What differs between the models that stand for two runs, and between what they were fitted to."""
    of_first = _parts(first)
    of_other = _parts(other)
    changed: list[Change] = []
    for what in dict.fromkeys([*of_first, *of_other]):
        before = of_first.get(what, "none")
        behind = of_other.get(what, "none")
        change = Change(what, before, behind)
        if change.first != change.other:
            changed.append(change)
    return tuple(changed)


def _parts(contender: Contender) -> dict[str, str]:
    """What a model is made of and was fitted to: all that may move its error."""
    model = contender.run.model(contender.model)
    body = contender.run.body
    names: dict[str, list[str]] = {"law or network": [model.structure.specification]}
    for place in _PLACES:
        there = stages_at(model.structure.dynamics, place)
        names[f"stages on the {place}"] = [stage.name for stage in there]
    names["past samples"] = [*map(str, model.past)]
    names["further inputs"] = [*model.extras]
    parts = {what: " and ".join(of_model) or "none" for what, of_model in names.items()}
    for setting, value in _flat(body).items():
        seen = setting in _SEEN or setting.startswith("versions")
        if value and not seen:
            parts[setting] = value
    return parts


def apart(contender: Contender) -> str:
    """All that may move a model's error and is no stage, as text."""
    parts = _parts(contender)
    without_stages = {
        what: part for what, part in parts.items() if not what.startswith("stages on")
    }
    return repr(without_stages)


def differing_settings(
    bodies: Sequence[Mapping[str, Any]],
) -> tuple[tuple[str, tuple[str, ...]], ...]:
    """What was asked for, read or installed differently: name, then one value a run."""
    flat = [_flat(body) for body in bodies]
    names = dict.fromkeys(name for values in flat for name in values)
    differing: list[tuple[str, tuple[str, ...]]] = []
    for name in names:
        of_runs = tuple(values.get(name, "–") for values in flat)
        if len(set(of_runs)) > 1:
            differing.append((name, of_runs))
    return tuple(differing)


def _flat(body: Mapping[str, Any]) -> dict[str, str]:
    """Settings of a run as text, by name."""
    values: dict[str, str] = {"device": str(body["device"])}
    for group in ("settings", "reading", "units", "versions"):
        part: dict[str, Any] = body[group] or {}
        for key, value in part.items():
            title = str(key) if group == "settings" else f"{group}: {key}"
            # As the user would say them.
            words: list[str] = []
            for each in cast(list[Any], value) if isinstance(value, list) else [value]:
                if each is None:
                    words.append("by default")
                elif isinstance(each, bool):
                    words.append("yes" if each else "no")
                else:
                    words.append(f"{each:.9g}" if isinstance(each, float) else str(each))
            values[title] = ", ".join(words) or "none"
    values["logs"] = ", ".join(str(log["name"]) for log in body["logs"])
    values["rows to fit"] = str(body["train_rows"])
    values["rows held out"] = str(body["test_rows"])
    return values
