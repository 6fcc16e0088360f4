"""Models that were fitted to stretches of long logs are scored on every row, block by block.

The logs are read once more. A task reads the rows between two gaps that lie some millions of rows apart, in blocks; the
states of a model go from block to block. A task gives sums over short bins of rows back, and these make the figures and
their bands. Sums are joined in the order of the rows: the figures are the same wherever the tasks run, and whether they
were interrupted or not.

What tasks found is kept by `every_row_folder`, so that the scoring goes on after an interruption.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from erclutch.errors import RunError
from erclutch.files.given_files import file_digest
from erclutch.fit.choice.scoring import BinSums, Score, score_of_bins
from erclutch.logs.batches import RowRange, blocks_of, chained, neighbours, one_batch
from erclutch.logs.dataset import Dataset
from erclutch.logs.reading import Reading
from erclutch.models.model import Model
from erclutch.models.model_file import digest_of
from erclutch.models.stages import outside_stages
from erclutch.runs.scoring_plan import LogToScore, Part, ScoringPlan
from erclutch.runs.tasks import Tasks
from erclutch.runs.written_run import without_infinities
from erclutch.signals.array import Array, Mask
from erclutch.signals.clock import Carry

KIND, SCHEMA = "erclutch every row", 1
_AHEAD = 2048  # rows before a block that are computed once more, so that what a delay reaches back to is known

#: Called with the rows that were scored so far, and all rows.
ScoringProgress = Callable[[int, int], None]


@dataclass(frozen=True)
class EveryRow:
    """Figures of every row.

    Attributes:
        plan: what was scored.
        train, test: figures by model, on the rows of the part of the logs that was fitted and on those held out; empty
            where there are none.
        not_scored: models that could not be scored block by block, with the reason.
    """

    plan: ScoringPlan
    train: Mapping[str, Score]
    test: Mapping[str, Score]
    not_scored: Mapping[str, str]

    def to_dict(self) -> dict[str, Any]:
        """As JSON values, with a digest over all of them."""
        models: dict[str, dict[str, Any]] = {}
        for name in self.train or self.test:
            figures: dict[str, Any] = {}
            if name in self.train:
                figures["train"] = self.train[name].to_dict()
            if name in self.test:
                figures["test"] = self.test[name].to_dict()
            models[name] = figures
        logs: list[dict[str, Any]] = []
        for log in self.plan.logs:
            logs.append({"name": log.name, "sha256": log.digest, "rows": log.rows})
        body: dict[str, Any] = {
            "kind": KIND,
            "schema": SCHEMA,
            "run": self.plan.run,
            "rows": self.plan.rows,
            "kept_rows": self.plan.kept_rows,
            "bin_rows": self.plan.bin_rows,
            "logs": logs,
            "models": models,
            "not_scored": dict(self.not_scored),
        }
        body = without_infinities(body)
        return {**body, "digest": digest_of(body)}


class PartsKept(Protocol):
    """Keeps the sums of parts that are done."""

    def sums(self, parts: int, models: int) -> dict[int, PartSums]:
        """The sums that are kept, by the part's number below ``parts``."""
        ...

    def keep(self, number: int, sums: PartSums) -> None:
        """Keep the sums of a part."""
        ...


def scorable(models: Mapping[str, Model]) -> tuple[dict[str, Model], dict[str, str]]:
    """Models that can be scored block by block, and why the others cannot."""
    able: dict[str, Model] = {}
    unable: dict[str, str] = {}
    for name, model in models.items():
        stages = outside_stages(model.structure.dynamics)
        if stages:
            listed = ", ".join(stage.name for stage in stages)
            unable[name] = (
                f"stages of other packages ({listed}) do not hand their state from block to block"
            )
        else:
            able[name] = model
    return able, unable


def score_every_row(
    plan: ScoringPlan,
    models: Mapping[str, Model],
    how: Reading,
    tasks: Tasks,
    *,
    kept: PartsKept | None = None,
    progress: ScoringProgress = lambda done, total: None,
) -> EveryRow:
    """Score models on every row of the logs of a plan.

    Args:
        plan: what is scored.
        models: by name.
        how: how the logs are read.
        tasks: where.
        kept: where the sums of parts that are done are kept, and those of an earlier call are found; None keeps none.
        progress: called as rows are scored.

    Raises:
        LogError, MappingError: a log changed since it was fitted.
        RunError: what is done cannot be kept, or does not belong to the plan; what a worker gave does not fit its task.
    """
    able, unable = scorable(models)
    parts = plan.parts
    sums: dict[int, PartSums] = {}  # by the part's number
    if kept is not None:
        for number, of_part in kept.sums(len(parts), len(able)).items():
            if not of_part.fault(parts[number], len(able)):
                sums[number] = of_part
    missing = [number for number in range(len(parts)) if number not in sums]
    done = sum(int(each.rows.sum()) for each in sums.values())

    def report(rows: int) -> None:
        progress(done + rows, plan.rows)

    score = partial(score_part, plan, able, how, report if tasks.here else None)
    answers = tasks(score, [parts[number] for number in missing])
    for number, (asked, of_part) in zip(missing, answers, strict=True):
        part = parts[number]
        wrong = of_part.fault(part, len(able)) if asked == part else "they are of other rows"
        if wrong:
            problem = f"sums of its rows from {part.begin.file_row} do not fit what was asked for: {wrong}"
            raise RunError(
                problem,
                where=part.log.path,
                remedy="Check the machine that made them, then give --resume",
            )
        sums[number] = of_part
        if kept is not None:
            kept.keep(number, of_part)
        done += int(of_part.rows.sum())
        progress(done, plan.rows)
    for log in plan.logs:
        if log.number is None:  # its blocks were read one by one, perhaps for hours
            require_same_bytes(log)
    whole = joined_sums([sums[number] for number in range(len(parts))])  # in the order of the rows
    train = whole.scores(list(able), False, plan.seed)
    test = whole.scores(list(able), True, plan.seed)
    return EveryRow(plan, train, test, unable)


# --- a task -----------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class PartSums:
    """Sums over the bins of some rows; each bin holds rows that are held out, or none.

    Attributes:
        held: whether a bin is held out, shape (bins,).
        rows, effort, effort_square: see `BinSums`, each of shape (bins,).
        error, square, largest: see `BinSums`, of each model, shape (models, bins).
    """

    held: Mask
    rows: Array
    effort: Array
    effort_square: Array
    error: Array
    square: Array
    largest: Array

    def fault(self, part: Part, models: int) -> str:
        """Why these cannot be the sums of a part for so many models; "" where they can.

        A worker or a kept file may be damaged, and sums of other rows would pass into the figures. Errors may be
        infinite: a model may leave all bounds.
        """
        bins = self.held.size
        shapes = {name: np.shape(getattr(self, name)) for name in PartSums.__dataclass_fields__}
        of_models = {name: (models, bins) for name in ("error", "square", "largest")}
        if not bins or shapes != {**dict.fromkeys(shapes, (bins,)), **of_models}:
            return f"they have the shapes {shapes}"
        for sums in (self.rows, self.effort, self.effort_square):
            if not np.isfinite(sums).all():
                return "not all of them are finite"
        if not ((self.square >= 0.0).all() and (self.largest >= 0.0).all()):
            return "not all of them are numbers"
        held = part.log.held_out.of(part.begin.place, part.rows)
        counted = self.rows.sum(), self.rows[self.held].sum()
        expected = part.rows, np.count_nonzero(held)
        if counted != expected:
            return f"they count {counted} rows and rows held out, not {expected}"
        return ""

    def scores(
        self,
        names: Sequence[str],
        held: bool,
        seed: int,
    ) -> dict[str, Score]:
        """Figures by model on the bins that are held out, or on the others; none where there are no such bins."""
        bins = self.held == held
        if not bins.any():
            return {}
        scores: dict[str, Score] = {}
        for place, name in enumerate(names):
            sums = BinSums(
                rows=self.rows[bins],
                error=self.error[place, bins],
                square=self.square[place, bins],
                largest=self.largest[place, bins],
                effort=self.effort[bins],
                effort_square=self.effort_square[bins],
            )
            scores[name] = score_of_bins(sums, seed=seed)
        return scores


def joined_sums(parts: Sequence[PartSums]) -> PartSums:
    """The bins of several parts, one after another."""
    whole: dict[str, Any] = {}
    for name in PartSums.__dataclass_fields__:
        whole[name] = np.concatenate([getattr(part, name) for part in parts], axis=-1)
    return PartSums(**whole)


def score_part(
    plan: ScoringPlan,
    models: Mapping[str, Model],
    how: Reading,
    report: Callable[[int], None] | None,
    part: Part,
) -> tuple[Part, PartSums]:
    """The sums over the rows of one part, and of which."""
    log = part.log
    if log.number is None:
        rows_of_file = RowRange(part.begin.file_row, part.stop, log.period)
        batches = how.batches(log.path, plan.device, rows_of_file)
    else:
        recording = how.read(log.path, plan.device)[log.number]
        require_unchanged(recording.digest == log.digest, log)
        batches = iter([one_batch(recording)])
    blocks = (block.data for block in blocks_of(batches, plan.device, how.derivative))
    place = part.begin.place  # of a block's first row in the log
    sums: list[PartSums] = []
    for data, first, predicted in predictions(models, blocks):
        measured = data.effort[first:]
        held = log.held_out.of(place, measured.size)
        sums.append(_sums(measured, predicted, held, place, plan))
        place += measured.size
        if report is not None:
            report(place - part.begin.place)
    return part, joined_sums(sums)


def require_same_bytes(log: LogToScore) -> None:
    """RunError unless the file of a log has the bytes that it had at the fit."""
    try:
        digest = file_digest(Path(log.path), sys.maxsize)  # of any size
    except OSError as error:
        problem = f"cannot be read: {error.strerror or error}"
        raise RunError(
            problem, where=log.path, remedy="Put the log back, or fit again with --force"
        ) from error
    require_unchanged(digest == log.digest, log)


def require_unchanged(same: bool, log: LogToScore) -> None:
    """RunError unless a log is the same as at the fit."""
    if not same:
        raise RunError(
            "changed since it was fitted", where=log.path, remedy="Fit the logs again with --force"
        )


def predictions(
    models: Mapping[str, Model], blocks: Iterator[Dataset]
) -> Iterator[tuple[Dataset, int, dict[str, Array]]]:
    """What models make of blocks of rows that follow each other, as if all rows were there at once.

    Args:
        models: by name; without stages of other packages.
        blocks: of one log; ``clock.joins`` of a block says whether it goes on from the block before.

    Yields:
        A block with rows ahead of it, which are computed once more, how many these are, and the effort by model of the
        rows behind them.
    """
    before: Dataset | None = None  # the end of the last block
    states: dict[str, list[Array]] = {}
    for block in blocks:
        goes_on = before is not None and block.clock.joins
        data = chained([before, block]) if before is not None and goes_on else block
        first = data.rows - block.rows
        # Delays and past samples reach back; besides, a model needs some time to forget the edge of a block.
        reach = 0.0  # [rows]
        for model in models.values():
            delay = model.times.get("delay", 0.0) / block.period
            reach = max(reach, delay, *model.past)
        ahead = _AHEAD + 2 * int(reach)
        # From this row on the next block computes once more.
        following = max(data.clock.spans[-1].start, data.rows - ahead)
        predicted: dict[str, Array] = {}
        for name, model in models.items():
            carry = Carry(states[name] if goes_on else [], following)
            with_states = replace(data, clock=replace(data.clock, carry=carry))
            predicted[name] = model.predict(with_states)[first:]
            states[name] = carry.end
        yield data, first, predicted
        before = neighbours(data, following, data.rows)


def _sums(
    measured: Array,
    predicted: Mapping[str, Array],
    held: Mask,
    place: int,
    plan: ScoringPlan,
) -> PartSums:
    """Sums over the bins of some neighbouring rows; a bin ends where a row is held out and its neighbour is not."""
    bins = (place + np.arange(measured.size)) // plan.bin_rows  # number of each row's bin
    another_bin = bins[1:] != bins[:-1]
    another_part = held[1:] != held[:-1]
    begins = np.flatnonzero(np.concatenate([[True], another_bin | another_part]))
    effort = measured - plan.middle
    errors = [measured - estimated for estimated in predicted.values()]
    sizes = [np.abs(error) for error in errors]

    def added(values: Array) -> Array:
        return np.add.reduceat(values, begins)

    return PartSums(
        held=held[begins],
        rows=np.diff(begins, append=measured.size).astype(np.float64),
        effort=added(effort),
        effort_square=added(effort * effort),
        error=np.array([added(error) for error in errors]),
        square=np.array([added(error * error) for error in errors]),
        largest=np.array([np.maximum.reduceat(size, begins) for size in sizes]),
    )
