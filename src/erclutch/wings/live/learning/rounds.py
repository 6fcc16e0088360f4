"""After each round a law is fitted to all rounds, and the next table is the one that takes most off what is not known.

The law has the memory that the ladder of `fit` asks for, of the few stages that seconds of a log can show. Of some
tables that are drawn, each with the motion that it would bring, the table is taken that makes the variance of the
effort smallest where the rig can go (I-optimal, see `design.information`). What a round taught is what the law says of
its numbers before and after, and how well the law before foretold the rows that came.

A band of the effort has two parts. What the numbers leave open gets smaller with each round, and `--until` asks for it.
The floor stays: it is what the law's form does not say, and the noise of the sensor.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field, replace
from typing import Any

import numpy as np

from erclutch.fit.choice.ladder import grown
from erclutch.fit.laws.fit_law import fit_structure
from erclutch.fit.solver.intervals import as_json
from erclutch.fit.solver.one_thread import one_thread
from erclutch.fit.solver.outcome import FitOutcome
from erclutch.logs.dataset import Dataset, joined
from erclutch.models.law_model import TorqueModel
from erclutch.models.laws import law_from_name, quick_laws
from erclutch.models.structure import Structure
from erclutch.signals.array import Array, largest_size
from erclutch.signals.percent import percent
from erclutch.wings.design.information import Knowledge
from erclutch.wings.live.learning.drawn_tables import TableLimits, drawn_table
from erclutch.wings.live.learning.foretold_motion import ForetoldMotion, LoggedRound

#: A richer law is taken where it lowers the error to this share.
_BETTER = 0.98
#: Stages that the ladder tries: all of them would take minutes between two rounds.
_MEMORY = ("dahl/field", "lugre/field", "inertia", "effort-lag")
_QUANTILE = 1.96
_TABLES = 12  # that are compared
_FIRST_LEVEL = 0.5  # of the drive, before anything is known
_FASTEST = 0.8  # of the speed at which the loop trips
#: Nothing more is to be learned below this share of the residual that the numbers leave open, ...
_LITTLE_OPEN = 0.2
#: ... if the law foretold the last round no worse than this many times its residual.
_FORETOLD = 1.1
#: The law is the limit where so many rounds, one after another, leave the band above this share of what it was before.
_ROUNDS_WITHOUT = 2
_NARROWER = 0.97


@dataclass(frozen=True)
class RoundReport:
    """What a round taught.

    Attributes:
        number: from 1.
        file: name of its log.
        seconds: of the log.
        tripped: why the loop held the fields at zero; empty for a whole round.
        law: that was fitted to all rounds.
        before: RMSE on this round's rows of the law of the rounds before; nan in the first round.
        residual: RMSE of the law on all rows.
        noise: the part of it that changes from row to row, as a sensor's noise does.
        open: half width of the effort's 95 % interval over all rows, without noise: what further rounds can teach.
        open_foretold: what was expected of it before the round; nan in the first round.
        band: half width of the effort's 95 % band: the numbers' and the residual's.
        largest: effort, by size.
        half_widths: of each number's 95 % interval: name -> (value, now, expected before the round).
    """

    number: int
    file: str
    seconds: float
    tripped: str
    law: str
    before: float
    residual: float
    noise: float
    open: float
    open_foretold: float
    band: float
    largest: float
    half_widths: dict[str, tuple[float, float, float]] = field(
        default_factory=dict[str, tuple[float, float, float]]
    )

    @property
    def share(self) -> float:
        """The band as a share of the largest effort."""
        return self.band / self.largest

    @property
    def open_share(self) -> float:
        """What the numbers leave open as a share of the largest effort."""
        return self.open / self.largest

    @property
    def floor_share(self) -> float:
        """The band that stays when the numbers are sure, as a share of the largest effort."""
        return _QUANTILE * self.residual / self.largest

    @property
    def noise_share(self) -> float:
        """The sensor's part of the floor, as a share of the largest effort."""
        return _QUANTILE * self.noise / self.largest

    def to_dict(self) -> dict[str, Any]:
        """As JSON values; what is not known is null."""
        numbers = {
            name: {"value": value, "now": as_json(now), "foretold": as_json(foretold)}
            for name, (value, now, foretold) in self.half_widths.items()
        }
        plain: dict[str, Any] = {}
        for name, value in asdict(self).items():
            plain[name] = as_json(value) if isinstance(value, float) else value
        shares = {
            "share": self.share,
            "open_share": self.open_share,
            "floor_share": self.floor_share,
        }
        return plain | shares | {"half_widths": numbers}


@dataclass(frozen=True)
class _Expected:
    """What was expected of a round.

    Attributes:
        model: the law before it.
        open: half width of what the numbers leave open after the round.
        shrink: by what each error shrinks, by name.
    """

    model: TorqueModel
    open: float
    shrink: dict[str, float]


class LearningRounds:
    """The rounds so far, and the next table.

    Attributes:
        limits: what a table may ask for.
        reports: what each round taught.
        nothing_more: whether another round would teach nothing.
    """

    def __init__(self, limits: TableLimits, seed: int, fastest: float) -> None:
        """Begin without rounds.

        Args:
            limits: what a table may ask for.
            seed: of the tables.
            fastest: speed at which the loop trips; 0: none.
        """
        self.limits = limits
        self.reports: list[RoundReport] = []
        self.nothing_more = False
        self._seed = seed
        self._fastest = fastest
        self._rounds: list[LoggedRound] = []
        self._outcome: FitOutcome[TorqueModel] | None = None
        self._expected: _Expected | None = None

    def next_table(self, seconds: float) -> Array:
        """The table of the next round, shape (rows, 3)."""
        rng = np.random.default_rng([self._seed, len(self._rounds)])
        if self._outcome is None:
            return drawn_table(self.limits, seconds, rng, _FIRST_LEVEL)
        tables = np.array([drawn_table(self.limits, seconds, rng) for _ in range(_TABLES)])
        with one_thread():
            return self._best(tables, self._outcome)

    def _best(self, tables: Array, outcome: FitOutcome[TorqueModel]) -> Array:
        """The table that takes most off what is not known; its expectation is kept."""
        foretold = ForetoldMotion(outcome.model, self._rounds).rows(tables)
        if self._fastest > 0.0:
            speeds: list[float] = []  # the largest of each table
            for rows in foretold:
                fastest = max(largest_size(element.slip) for element in rows.elements)
                speeds.append(fastest)
            slow = [
                number for number, speed in enumerate(speeds) if speed < _FASTEST * self._fastest
            ]
            kept = slow or [int(np.argmin(speeds))]
            tables = tables[kept]
            foretold = [foretold[number] for number in kept]
        known = _all_rows(self._rounds)
        use = joined(foretold)
        knowledge = Knowledge(outcome.model, known, self.limits.rate, "I", use)
        gains = [knowledge.worth(rows) for rows in foretold]
        best = int(np.argmax(gains))

        # What the round will have left open is asked over the rows that will be there then, as `take` asks it.
        rows_then = joined([known, foretold[best]])
        then = Knowledge(outcome.model, known, self.limits.rate, "I", rows_then)
        before = then.errors()
        then.learn_rows(foretold[best])
        shrinks = (then.errors() / before).tolist()
        names = [estimate.name for estimate in outcome.estimates]
        shrink_of = dict(zip(names, shrinks, strict=True))
        self._expected = _Expected(outcome.model, then.band(), shrink_of)
        return tables[best]

    def take(self, logged: LoggedRound, file: str, tripped: str = "") -> RoundReport:
        """A round was logged: fit all rounds, and tell what it taught.

        Raises:
            CheckError: rows that no law can be fitted to.
        """
        expected = self._expected
        before = math.nan
        if expected is not None:
            error = logged.rows.effort - expected.model.predict(logged.rows)
            before = float(np.sqrt(np.mean(error**2)))
        self._rounds.append(logged)
        known = _all_rows(self._rounds)
        with one_thread():
            earlier = self._outcome
            # The simplest law, unless the next lowers the error, with the memory that the ladder asks for.
            one_way = all(bool(np.all(element.slip >= 0.0)) for element in known.elements)
            single = known.device == "single" and not one_way
            chosen: FitOutcome[TorqueModel] | None = None
            for name in quick_laws():
                law = law_from_name(name, known.device)
                structure = Structure(known.device, name, law, "lag", single, single)
                tried = fit_structure(known, structure, intervals=False)
                if chosen is None or tried.train_cost < _BETTER**2 * chosen.train_cost:
                    chosen = tried
            assert chosen is not None
            richest = grown(known, chosen.model.structure, among=_MEMORY)[-1]
            self._outcome = outcome = fit_structure(known, richest.structure)
            knowledge = Knowledge(outcome.model, known, self.limits.rate, "I")
        open_now = knowledge.band()
        band = math.hypot(open_now, _QUANTILE * knowledge.noise)
        half_widths: dict[str, tuple[float, float, float]] = {}
        of_earlier = {}
        # Another law's numbers are others.
        if earlier is not None and earlier.model.name == outcome.model.name:
            of_earlier = {each.name: each for each in earlier.estimates}
        for estimate in outcome.estimates:
            foretold = math.nan
            if (
                expected is not None
                and estimate.name in of_earlier
                and estimate.name in expected.shrink
            ):
                old = of_earlier[estimate.name]
                foretold = 0.5 * (old.high - old.low) * expected.shrink[estimate.name]
            half_width = 0.5 * (estimate.high - estimate.low)
            half_widths[estimate.name] = (estimate.value, half_width, foretold)
        # The noise is what a residual's neighbours do not share: its deviation is that of their differences over the
        # root of two.
        residual = known.effort - outcome.model.predict(known)
        changes_of_spans = [np.diff(residual[span.start : span.stop]) for span in known.clock.spans]
        changes = np.concatenate(changes_of_spans)
        noise = float(np.sqrt(0.5 * np.mean(np.square(changes))))
        report = RoundReport(
            number=len(self._rounds),
            file=file,
            seconds=logged.rows.duration,
            tripped=tripped,
            law=outcome.model.name,
            before=before,
            residual=knowledge.noise,
            noise=noise,
            open=open_now,
            open_foretold=math.nan if expected is None else expected.open,
            band=band,
            largest=largest_size(known.effort) or 1.0,
            half_widths=half_widths,
        )
        self.reports.append(report)
        little_open = open_now < _LITTLE_OPEN * _QUANTILE * knowledge.noise
        self.nothing_more = not tripped and little_open and before <= _FORETOLD * knowledge.noise
        return report

    def enough(self, until: float) -> str:
        """Why no further round is played; empty where one is.

        Args:
            until: share of the largest effort that the numbers may leave open; 0: none.
        """
        last = self.reports[-1]
        # The first round drives at half of the torque: it says nothing of the rest.
        if until and last.number > 1 and last.open_share <= until:
            return (
                f"what the numbers leave open is within {percent(until, 2)} of the largest effort; the band is "
                f"{percent(last.share, 2)}, for {last.law} errs by {last.residual:.3g} whatever its numbers are"
            )
        if self.nothing_more:
            return (
                "nothing more is to be learned: the numbers leave little open, and the last round "
                "brought no surprise"
            )
        bands = [report.band for report in self.reports[1:]]
        before = bands[:-_ROUNDS_WITHOUT]
        if before and min(bands[-_ROUNDS_WITHOUT:]) > _NARROWER * min(before):
            return (
                f"more rounds make the band no narrower: {last.law} errs by {last.residual:.3g}, and its numbers leave "
                f"{last.open:.3g} open; try what errs less, such as a network"
            )
        return ""

    @property
    def model(self) -> TorqueModel | None:
        """The law after the last round."""
        return None if self._outcome is None else self._outcome.model


def _all_rows(rounds: Sequence[LoggedRound]) -> Dataset:
    """Rows of all rounds; the commands of the drive are no input of a law."""
    return joined([replace(each.rows, spare={}) for each in rounds])
