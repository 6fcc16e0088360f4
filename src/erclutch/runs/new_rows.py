"""Kept models say what they make of rows that they have not seen: estimates, bands, scores, and where they guess."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from numpy.typing import NDArray

from erclutch.errors import SettingError
from erclutch.fit.bands.prediction_bands import Coverage, coverage
from erclutch.fit.choice.ranking import unknown_start
from erclutch.fit.choice.scoring import Score
from erclutch.fit.choice.scoring import score as scored
from erclutch.fit.pace import told as motion_told
from erclutch.logs import map_over, read_all, read_table
from erclutch.logs.applied import apply_rows
from erclutch.logs.dataset import Dataset, dataset_of, joined
from erclutch.logs.keywords import options_of, window_and_rate
from erclutch.logs.log_file import wants_each
from erclutch.logs.mapping import ColumnMap, file_mapping
from erclutch.logs.planning.whole_plan import plan_of
from erclutch.logs.reading import Reading
from erclutch.models.adaptive_band import adapted
from erclutch.models.band import leading
from erclutch.models.load import load_model
from erclutch.models.model import Model, Pair, held_window, margins
from erclutch.runs.run_folder import FINAL, Run, read_run
from erclutch.runs.run_rows import read_rows
from erclutch.signals.array import Array, Mask, rms
from erclutch.signals.percent import percent
from erclutch.signals.recording import TEMPERATURE
from erclutch.signals.units import amount

if TYPE_CHECKING:
    from pandas import DataFrame

_Log = Any  # a path or a DataFrame
_OF_A_LOG = ("begin", "end", "skip")  # a window belongs to the log that it was given for


def predict(
    model: Model | Run | str | Path,
    log: str | Path | DataFrame,
    mapping: ColumnMap | Mapping[str, Any] | None = None,
    *,
    name: str | None = None,
    band: bool = False,
    sensor: bool = False,
    **options: Any,
) -> DataFrame:
    """The effort that a kept model estimates for each row of a log.

    Args:
        model: a model, a model's file, a run or its folder.
        log: a file, or a DataFrame with units in its column names (``V [cm/s]``) or in the mapping.
        mapping: as for `erclutch.read`, over how the run read its own logs, whose window in time belongs to them
            alone. A log needs no effort.
        name: which model of a run; None is the recommended one.
        band: whether to give the band too, which holds 95 % of rows like those of the run.
        sensor: the band learns from the log's measured effort, row by row, from past rows alone.
        **options: as for `erclutch.read`, such as ``field="Y [V]"``; they win over the mapping.

    Returns:
        Columns effort, with a band low and high, in the model's unit, and outside, which is true where the model
        guesses; one row for each row of the log, with its index. Rows that cannot be read have NaN and are outside.
        Where the run resampled its logs or took all recordings of a file: rows as there, with times in s as index.

    Raises:
        LogError, MappingError: the log cannot be read; RunError: the model cannot; SettingError: it has no band.
    """
    from pandas import DataFrame

    run, chosen = opened(model, name)
    data, rows, index = _read(log, mapping, options_of(options), run, chosen, needs_effort=sensor)
    effort = chosen.predict(data)
    columns = {"effort": effort}
    if band or sensor:
        columns["low"], columns["high"] = band_ends(data, chosen, effort, sensor)
    whole = {key: np.full(len(index), np.nan) for key in columns}
    for key, values in columns.items():
        whole[key][rows] = values
    outside = np.ones(len(index), np.bool_)
    outside[rows] = chosen.outside(data)
    return DataFrame({**whole, "outside": outside}, index=index)


def score(
    models: Model | Run | str | Path | Sequence[Model | Run | str | Path],
    log: str | Path | DataFrame | Sequence[str | Path | DataFrame],
    mapping: ColumnMap | Mapping[str, Any] | None = None,
    *,
    name: str | None = None,
    **options: Any,
) -> DataFrame:
    """How good kept models are on logs that were not there when they were fitted, best first.

    Args:
        models: one or several: models, models' files, runs or their folders; a run stands for all of its models.
        log: one file or DataFrame or several, of one device; see `predict`.
        mapping: see `predict`.
        name: of runs, this model alone.
        **options: see `predict`.

    Returns:
        A row for each model: model, run, rmse with low and high end of its 95 % band, share of the standard deviation,
        guessed (share of rows outside), where (in words), and of the prediction band the share of rows inside and
        worst, the share in the worst second or log (NaN without a band).

    Raises:
        LogError, MappingError: a log cannot be read; RunError: a model cannot.
    """
    from pandas import DataFrame

    several = cast(
        "list[Model | Run | str | Path]", models if isinstance(models, list | tuple) else [models]
    )
    logs = cast("list[_Log]", log if isinstance(log, list | tuple) else [log])
    reading = options_of(options)
    rows: list[dict[str, Any]] = []
    for each in several:
        run, chosen = opened(each, name)
        folder = "" if run is None else str(run.folder)
        parts: list[Dataset] = []
        for one in logs:
            data, *_ = _read(one, mapping, reading, run, chosen, needs_effort=True)
            parts.append(data)
        unseen = joined(parts)
        for called, model in models_of(run, chosen, name):
            of_model = score_model(model, unseen, called)
            rows.append(of_model.row(folder))
    return DataFrame(rows).sort_values("rmse", ignore_index=True)


@dataclass(frozen=True)
class LogScore:
    """How good a model is on the rows of one of several logs.

    Attributes:
        log: its name.
        rmse: in the unit of the effort.
        gain: measured over estimated effort, by least squares; NaN where the model says nothing but zero.
        inside: share of the rows in the prediction band; None without a band.
    """

    log: str
    rmse: float
    gain: float
    inside: float | None


@dataclass(frozen=True)
class ModelScore:
    """How good a model is on some rows.

    Attributes:
        model: its name.
        figures: RMSE and the like, with bands.
        guessed: share of rows outside what it was trained on.
        where: where these rows lie, in words; empty where there are none.
        held: what its prediction band holds; None without a band.
        gain: measured over estimated effort, by least squares; NaN where the model says nothing but zero.
        left_by_gain: share of the RMSE that is left where the estimate is multiplied by the gain.
        by_log: the same of each log, where there are several.
    """

    model: str
    figures: Score
    guessed: float
    where: str
    held: Coverage | None
    gain: float = np.nan
    left_by_gain: float = 1.0
    by_log: tuple[LogScore, ...] = ()

    def row(self, run: str) -> dict[str, Any]:
        """As columns of a table."""
        rmse = self.figures.rmse
        held = self.held
        return {
            "model": self.model,
            "run": run,
            "rmse": rmse.value,
            "low": rmse.low,
            "high": rmse.high,
            "share": self.figures.share.value,
            "guessed": self.guessed,
            "where": self.where,
            "inside": np.nan if held is None else held.share,
            "worst": np.nan if held is None else held.worst,
        }


def models_of(
    run: Run | None,
    chosen: Model,
    name: str | None,
) -> list[tuple[str, Model]]:
    """Names and models to score: those of a run as the run calls them, or the one that was chosen."""
    if run is None:
        return [(chosen.name, chosen)]
    if name == FINAL:
        return [(called_final(chosen), chosen)]
    if name is not None:
        return [(str(run.entry(name)["name"]), chosen)]
    models = [(known, run.model(known)) for known in run.names]
    if FINAL in run.body:
        final = run.model(FINAL)
        models.append((called_final(final), final))
    return models


def called_final(model: Model) -> str:
    """What the model of all rows is called beside those that were judged."""
    return f"{FINAL}: {model.name}, of all rows"


def score_model(model: Model, data: Dataset, name: str) -> ModelScore:
    """Score a model on rows that have a measured effort, under a name."""
    effort = model.predict(data)
    outside = model.outside(data)
    held = None
    inside: Mask | None = None
    if model.band is not None:
        ends = model.band.around(effort, data.elements, data.clock)
        held = coverage(data, ends, np.ones(data.rows, np.bool_))
        low, high = ends
        inside = (data.effort >= low) & (data.effort <= high)
    by_log: list[LogScore] = []  # of several logs
    if len(data.sources) > 1:
        for log, (start, stop) in zip(data.sources, data.source_rows, strict=True):
            rows = slice(start, stop)
            gain = _gain(data.effort[rows], effort[rows])
            share = None if inside is None else float(inside[rows].mean())
            by_log.append(LogScore(log, rms(data.effort[rows] - effort[rows]), gain, share))
    figures = scored(data.effort, effort)
    gain = _gain(data.effort, effort)
    left = rms(data.effort - gain * effort) / figures.rmse.value if figures.rmse.value else 1.0
    return ModelScore(
        model=name,
        figures=figures,
        guessed=float(outside.mean()),
        where=where_outside(model, data, outside),
        held=held,
        gain=gain,
        left_by_gain=left,
        by_log=tuple(by_log),
    )


def _gain(measured: Array, estimated: Array) -> float:
    """Measured over estimated effort, by least squares; NaN where the estimate is zero all over."""
    size = float(estimated @ estimated)
    return float(measured @ estimated) / size if size > 0.0 else np.nan


def where_outside(model: Model, data: Dataset, outside: NDArray[np.bool_]) -> str:
    """Which ranges the rows outside exceed, and in what share of all rows."""
    # Signal, its values, what was trained on, its unit.
    ranges: list[tuple[str, Array, Pair, str]] = []
    for key, covered in model.extras.items():
        called = "temperature" if key == TEMPERATURE else f"further input {key}"
        unit = model.extra_units.get(key, "").replace("?", "")
        ranges.append((called, data.extras[key], covered, unit))
    for number, element in enumerate(data.elements, start=1):
        tail = f" {number}" if len(data.elements) > 1 else ""
        ranges.append((f"field{tail}", element.field, model.trained_on.field, data.units.field))
        ranges.append((f"slip{tail}", element.slip, model.trained_on.slip, data.units.slip))

    shares: list[tuple[float, str]] = []
    inside_all = outside.copy()  # rows that are outside, and within each range by itself
    for signal, values, covered, unit in ranges:
        low, high = margins(covered)
        lowest, highest = covered
        sides = (("below", values < low, lowest), ("above", values > high, highest))
        for side, beyond, limit in sides:
            guessed = beyond & outside
            if guessed.any():
                text = f"{signal} {side} {amount(f'{limit:.4g}', unit)}"
                shares.append((float(guessed.mean()), text))
                inside_all &= ~beyond
    if inside_all.any():
        shares.append((float(inside_all.mean()), "between training rows, far from all of them"))
    quick = quicker_than_known(model, data)
    if quick.any():
        shares.append(
            (float(quick.mean()), "the slip changes more quickly than in any training log")
        )
    largest_first = sorted(shares, reverse=True)
    return "; ".join(f"{text} ({percent(share, 1)} of rows)" for share, text in largest_first)


def quicker_than_known(model: Model, data: Dataset) -> Mask:
    """Rows in which the slip changes more quickly than in any training log, shape (n,): the band grows there."""
    haste = None if model.band is None else model.band.haste
    if haste is None:
        return np.zeros(data.rows, np.bool_)
    fields = [element.field for element in data.elements]
    slips = [element.slip for element in data.elements]
    _, slip = leading(fields, slips)
    return haste.beyond(slip, data.clock)


def band_ends(
    data: Dataset,
    model: Model,
    effort: Array,
    sensor: bool,
) -> tuple[Array, Array]:
    """Low and high end of the band of 95 %, each of shape (n,); with a sensor adapted to past rows.

    Without a sensor both are NaN where nothing like a row was ever logged: more than a tenth beyond the range of the
    slip, or of the fields that the band knows.

    Raises:
        SettingError: the model has no band.
    """
    band = model.band
    if band is None:
        raise SettingError(
            "the model has no band", where=model.name, remedy="Fit its log again with this version"
        )
    low, high = band.around(effort, data.elements, data.clock)
    if sensor:
        return adapted(band, (low, high), effort, data.effort, data.clock)
    lowest_slip, highest_slip = held_window(model.trained_on.slip)
    lowest_field, highest_field = held_window(model.trained_on.field)
    lowest_field = min(lowest_field, band.field[0])
    highest_field = max(highest_field, band.field[1])
    for element in data.elements:
        unlike = (element.field < lowest_field) | (element.field > highest_field)
        unlike |= (element.slip < lowest_slip) | (element.slip > highest_slip)
        low = np.where(unlike, np.nan, low)
        high = np.where(unlike, np.nan, high)
    return low, high


def unlike_training(run: Run | None, model: Model, data: Dataset) -> list[str]:
    """Sentences on logs that start or move otherwise than those that a model of a run was fitted to."""
    sentences: list[str] = []
    start = unknown_start(model, data)
    if start:
        sentences.append(f"{model.name}: {start}.")
    if run is not None:
        rows = read_rows(run)
        sentences += motion_told(rows.data.take(~rows.test), data)
    return sentences


def opened(what: Model | Run | str | Path, name: str | None) -> tuple[Run | None, Model]:
    """The model of a file, or one of a run with the run: that with the name, or the recommended one.

    Raises:
        RunError: no run, no model, or a model's file that is not as it was written.
        SettingError: a name beside a model.
    """
    if isinstance(what, str | Path) and Path(what).is_dir():
        what = read_run(Path(what))
    if isinstance(what, Run):
        return what, what.model(name)
    if name is not None:
        where = str(what) if isinstance(what, str | Path) else what.name
        problem = f"{name!r} names a model of a run, and this is no run"
        raise SettingError(problem, where=where, remedy="Give the run's folder, or no name")
    if not isinstance(what, str | Path) and not hasattr(what, "trained_on"):
        raise SettingError(
            f"a {type(what).__name__} is no model",
            remedy="Give a model, a run, or the path of either",
        )
    model = load_model(what) if isinstance(what, str | Path) else what
    return None, model


def _read(
    log: _Log,
    mapping: ColumnMap | Mapping[str, Any] | None,
    said: Mapping[str, Any],
    run: Run | None,
    model: Model,
    *,
    needs_effort: bool,
) -> tuple[Dataset, NDArray[np.int64], Any]:
    """The rows of a log, their places in it, and the index of all of it."""
    # What was said now goes first, then how the run read its own logs, then the mapping file of the run or of the log.
    as_before: Mapping[str, Any] = {} if run is None else run.reading
    kept = {key: option for key, option in as_before.items() if key not in _OF_A_LOG}
    how = Reading.from_options(kept, "as the run")
    if said:
        mapping = ColumnMap.from_options(said).over(map_over(mapping, None))
        window, rate = window_and_rate(said)
        how = replace(how, window=window, rate=rate or how.rate)
    of_file = file_mapping(log, how.mapping_file)
    chosen = map_over(mapping, map_over(how.mapping, of_file))

    device = model.structure.device
    if not needs_effort:  # a constant stands for it, so that its column may be absent
        signal = "T" if device == "coaxial" else "effort"
        zero = f"0 {model.units.effort.replace('?', '')}".strip()
        columns = {key: choice for key, choice in chosen.columns.items() if key != signal}
        chosen = replace(chosen, columns=columns, constants={**chosen.constants, signal: zero})
    if wants_each(chosen.variable) and isinstance(log, str | Path):
        logs = [how.finished(each) for each in read_all(log, chosen, device=device)]
        data = joined([dataset_of(each, device, how.derivative) for each in logs])
        return data, np.arange(data.rows), data.clock.time
    table = read_table(log, variable=chosen.variable)
    plan = plan_of(table, chosen, device=device, invalid=None if needs_effort else "drop")
    recording, kept = apply_rows(plan, table)
    data = dataset_of(how.finished(recording), device, how.derivative)
    if how.rate is not None:  # other rows than those of the log
        return data, np.arange(data.rows), data.clock.time
    if data.rows < recording.rows:  # lone rows between gaps
        stretches = [kept[start:stop] for start, stop in recording.segments if stop - start >= 2]
        kept = np.concatenate(stretches)
    index = range(table.rows) if isinstance(log, str | Path) else log.index
    return data, kept, index
