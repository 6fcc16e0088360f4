"""What the columns of a table are called, what their units are and how their numbers run is gathered once, for a plan.

Here too stands which column is the time, by its name, its unit and its numbers: rates are told by it. Nothing is
decided for the plan: the steps of `erclutch.logs.planning.whole_plan` read these facts in place of the table's columns.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

import numpy as np

from erclutch.errors import UnitError
from erclutch.logs.columns.labels import own_unit, says_a_unit, without_unit
from erclutch.logs.columns.machines_in_names import is_of_a_drive
from erclutch.logs.columns.name_ends import KEPT_NAMES, split_end
from erclutch.logs.columns.names import SpokenName, spoken, spoken_name
from erclutch.logs.columns.names_in_company import told_by_company
from erclutch.logs.columns.shapes import Shape, shape_of, spread_of
from erclutch.logs.columns.vocabulary import MEASURED, NAMES, OTHER, SINGLE, STEPS_OF_TIME
from erclutch.logs.table import MINUS, Table
from erclutch.signals import units
from erclutch.signals.array import Array

#: Units of plain numbers.
NO_UNITS = ("", "-", "1", "%")
_OF_HALL = frozenset({"hall", "hallsensor"})
_SAMPLE_NUMBER = "samplenumber"
_RATE = re.compile(r"(?:dq|qd|dtheta|dx)\d*")
_FEWEST_SHARING = 3
#: Share of a step by which equal steps may differ.
EVEN = 1e-3
#: Words for the sides of a gear or a spring, each of which has a motion and a torque of its own.
_SIDES = frozenset(("motor", "rotor", "joint", "link", "load", "output", "input", "spring", "arm"))
#: Words for the signals of a device: what is left of a name may be that of a limb.
_SIGNALS = frozenset(word for signal in SINGLE for word in NAMES[signal].split())
#: Words for the hours that a machine has run, or a fluid was in use.
_AGES = frozenset("operating operational operation service usage tool machine engine age".split())
_STEADY = 0.05  # share of its level by which a supply varies at most
_VARIES = 0.5  # and by which a field varies at least

#: Kinds of motion by the SI unit of their effort, in words.
KINDS = {"Pa": "shear rate", "N*m": "turning motion", "N": "motion along a line"}
UNITS_OF_KIND = {"Pa": ("Pa", "1/s"), "N*m": ("N*m", "rad/s", "rad"), "N": ("N", "m/s", "m")}
_WORDS_OF_KIND = {
    "Pa": ("shearrate", "shearstress", "gammadot"),
    "N*m": (
        "torque",
        "rpm",
        "omega",
        "angle",
        "angular",
        "theta",
        "yaw",
        "drehzahl",
        "drehmoment",
        "扭矩",
        "转速",
        "角",
    ),
    "N": ("force", "loadcell", "lvdt", "displacement", "stroke", "kraft", "weg", "位移"),
}


@dataclass(frozen=True)
class SeenColumn:
    """What is seen of one column before it is called a signal.

    Attributes:
        name: in the table.
        spoken: what the name says.
        unit: as written in the file; None where the file has none.
        values: as logged, shape (n,).
        shape: how the numbers run.
    """

    name: str
    spoken: SpokenName
    unit: str | None
    values: Array
    shape: Shape

    @property
    def is_steady(self) -> bool:
        """Whether the column keeps near one level that is not zero, as the voltage of a supply does."""
        return self._spread <= _STEADY

    @property
    def varies(self) -> bool:
        """Whether the column takes quite different values, as a field that is switched or turned up does."""
        return self._spread >= _VARIES

    @cached_property
    def _spread(self) -> float:
        return spread_of(self.values)

    @property
    def moved(self) -> float:
        """By how much the numbers differ; 0 where there are none."""
        known = self.values[np.isfinite(self.values)]
        return float(np.ptp(known)) if known.size else 0.0

    @property
    def steps(self) -> Array:
        """From number to number, shape (n - 1,); what is not finite is passed over."""
        return np.diff(self.values[np.isfinite(self.values)])

    @property
    def has_equal_steps(self) -> bool:
        """Whether the numbers grow by one and the same step, as a time does."""
        steps = self.steps
        return steps.size > 0 and bool(np.ptp(steps) <= EVEN * np.median(steps))

    @property
    def is_called_time(self) -> bool:
        """Whether it is called like the time, also where a unit tells it from another: ``Time (m)`` are minutes."""
        return self.spoken.is_time or spoken_name(self.name.removesuffix(f"({self.unit})")).is_time

    @property
    def written_unit(self) -> str | None:
        """The file's unit, or the unit that ends the name, whatever it is of."""
        return self.unit or self.spoken.end

    def unit_for(self, si_units: tuple[str, ...]) -> str | None:
        """The unit of the column where it is to be one of some SI units; None where nobody says it."""
        return own_unit(self.name, self.unit, si_units)

    def fits(self, si_units: tuple[str, ...]) -> bool | None:
        """Whether the column's unit is one for some SI units; None where it has no unit."""
        return unit_fits(self.name, self.unit, si_units)

    @property
    def side(self) -> str:
        """The word in the name for a side of a gear; "" for none and several, and for what two shafts differ by."""
        if MINUS in self.name:
            return ""
        words = {*self.spoken.stem_words}
        sides = words & _SIDES
        if "cell" in words:
            sides -= {"load"}  # a load cell is a sensor
        return sides.pop() if len(sides) == 1 else ""

    @property
    def limb(self) -> tuple[str, ...]:
        """The words of the name for no signal and no measuring, such as ``left elbow``; () for a name without any."""
        words = self.spoken.stem_words
        return tuple(word for word in words if word not in _SIGNALS and word not in MEASURED)

    @property
    def kind(self) -> str:
        """Whether a motion or an effort is that of turning, of a line or of shear, see `KINDS`; "" for untold."""
        for kind in KINDS:
            if self.fits(UNITS_OF_KIND[kind]):
                return kind
        return "" if self.written_unit else self.kind_by_name

    @property
    def kind_by_name(self) -> str:
        """The kind that a word of the name tells, see `KINDS`; "" for untold."""
        letters = "".join(self.spoken.words)
        for kind, words in _WORDS_OF_KIND.items():
            if any(word in letters for word in words):
                return kind
        return ""


@dataclass(frozen=True)
class SeenColumns:
    """A table, and what is seen of its columns.

    Attributes:
        table: as a reader gave it.
        columns: in the table's order, by name.
        shared_words: words in the names of at least half of the columns, and of three: the name of a joint or a topic.
        counters: names of the columns that count samples.
        empty: names of the columns that hold no number in any row: they are no signal, whatever they are called.
    """

    table: Table
    columns: Mapping[str, SeenColumn]
    shared_words: frozenset[str]
    counters: tuple[str, ...]
    empty: tuple[str, ...]

    @cached_property
    def of_models(self) -> list[SeenColumn]:
        """The columns that are called like a model; rules ask for them beside each column."""
        return [column for column in self.columns.values() if column.spoken.is_of_a_model]

    @cached_property
    def measured(self) -> list[SeenColumn]:
        """The columns of the file that have a unit and change; rules ask for them beside each column."""
        return [
            column
            for column in self.without(())
            if column.written_unit and not column.shape.constant
        ]

    @cached_property
    def _saying(self) -> dict[frozenset[str], list[SeenColumn]]:
        return {}

    def saying(self, words: frozenset[str]) -> list[SeenColumn]:
        """The columns whose names hold one of some words: they are looked up once, whoever asks beside each column."""
        if words not in self._saying:
            columns = self.columns.values()
            self._saying[words] = [column for column in columns if column.spoken.says(words)]
        return self._saying[words]

    @cached_property
    def of_drives(self) -> list[SeenColumn]:
        """The columns that are called like a drive's own quantity, looked up once, whoever asks beside each column."""
        return [column for column in self.columns.values() if is_of_a_drive(column.spoken)]

    def without(self, taken: Iterable[str]) -> list[SeenColumn]:
        """All columns of the file that hold a number, but some."""
        left_out = {*taken, *self.empty, *self.table.made}
        return [column for column in self.columns.values() if column.name not in left_out]

    def time_column(self, taken: Iterable[str] = ()) -> str | None:
        """The column that is the time by its name, with a unit of time or none; or the only one with a unit of time.

        Where no whole name is, the only column whose name ends in a time and whose numbers rise (``Machine_Time``).

        Args:
            taken: columns that are something else.
        """
        open_ones = [
            column
            for column in self.without(taken)
            if column.fits(("s",)) is not False and not is_of_steps(column)
        ]
        for column in open_ones:
            if column.spoken.is_time:
                return column.name

        in_seconds: list[SeenColumn] = []
        for column in open_ones:
            is_another = not OTHER.isdisjoint(column.spoken.words)
            # How long machines have run falls where another machine begins: Operating Hours.
            is_an_age = column.spoken.says(_AGES) and bool(np.any(column.steps < 0.0))
            if column.fits(("s",)) and not is_another and not is_an_age:
                in_seconds.append(column)
        # A time that the file states says more.
        stated = self.table.clock is not None or self.table.sample_period is not None
        if self.table.clock is not None and len(in_seconds) > 1:
            # Dates to the second, and beside them the same time in finer steps.
            in_seconds = [column for column in in_seconds if _is_finer(column, self.table.clock)]
        if len(in_seconds) > 1 and not stated:
            # A delay and a state of the bench do not rise in each row, or not by equal steps.
            in_seconds = [column for column in in_seconds if np.all(column.steps > 0.0)]
        if len(in_seconds) > 1 and not stated:
            in_seconds = [column for column in in_seconds if column.has_equal_steps]
        if len(in_seconds) == 1:
            return in_seconds[0].name
        rising = [
            column for column in open_ones if column.spoken.ends_in_time and column.shape.rises
        ]
        if not rising:
            return None
        # Several may be one time, as that of a loop and that of its computer: then none drifts by a step.
        first = rising[0]
        step = float(np.max(np.diff(first.values), initial=0.0))
        for column in rising[1:]:
            drift = np.ptp(column.values - first.values)
            if column.written_unit != first.written_unit or drift > step:
                return None
        return first.name

    def of_one_side(self, names: Sequence[str], partners: Iterable[str]) -> list[str]:
        """The one column on the side of the gear where all of its partners are, or of their limb; else all columns."""
        partners = [*partners]
        sides = {self.columns[name].side for name in partners if name in self.columns}
        if len(sides) != 1 or "" in sides:
            return self._of_one_limb(names, partners)
        beside_partners: list[str] = []
        for name in names:
            if name in self.columns and self.columns[name].side in sides:
                beside_partners.append(name)
        return beside_partners if len(beside_partners) == 1 else [*names]

    def _of_one_limb(self, names: Sequence[str], partners: Iterable[str]) -> list[str]:
        """The one column called like the limb of all partners, where each column is called like a limb; else all."""
        limbs = {self.columns[name].limb for name in partners if name in self.columns}
        own_limbs = [self.columns[name].limb if name in self.columns else () for name in names]
        if len(limbs) != 1 or () in limbs or () in own_limbs:
            return [*names]
        limb = limbs.pop()
        if own_limbs.count(limb) != 1:
            return [*names]
        return [names[own_limbs.index(limb)]]

    @cached_property
    def stamps(self) -> Array | None:
        """The time in s, or in what the file has, shape (n,); None for a table without a clock."""
        table = self.table
        if table.clock is not None:
            return table.clock
        if table.sample_period is not None:
            return np.arange(table.rows, dtype=np.float64) * table.sample_period
        name = self.time_column()
        return None if name is None else table.columns[name]


def seen_columns(table: Table, *, whole: bool = True) -> SeenColumns:
    """What is seen of each column of a table, which may be some rows of a log."""
    columns: dict[str, SeenColumn] = {}
    for name, values in table.columns.items():
        unit = table.units.get(name)
        bare = without_unit(name, unit)
        stem, end = split_end(bare)
        columns[name] = SeenColumn(name, spoken(bare, stem, end), unit, values, shape_of(values))

    # The volts of a Hall sensor are no field; where they were turned into mT they are the field.
    for name, column in columns.items():
        if column.spoken.says(_OF_HALL) and column.fits(("T",)):
            said = spoken("flux density", "flux density", column.spoken.end)
            columns[name] = replace(column, spoken=said)

    for name, stem in told_by_company(
        {name: column.spoken for name, column in columns.items()}
    ).items():
        said = columns[name].spoken
        if not columns[name].fits(("A",)):  # a unit tells a current from what is now
            columns[name] = replace(columns[name], spoken=spoken(stem, stem, said.end))

    for name in _desired(columns):
        said = columns[name].spoken
        stem = f"{said.stem} desired"
        columns[name] = replace(columns[name], spoken=spoken(stem, stem, said.end))

    sharing: Counter[str] = Counter()  # how many columns have a word in their name
    counters: list[str] = []
    empty: list[str] = []
    for name, column in columns.items():
        sharing.update({*column.spoken.stem_words})
        if name.replace(" ", "").lower() == _SAMPLE_NUMBER:
            counters.append(name)
        if whole and column.values.size and not np.isfinite(column.values).any():
            empty.append(name)
    if whole:
        empty += table.hollow
    fewest = max(_FEWEST_SHARING, len(columns) / 2)
    return SeenColumns(
        table,
        columns,
        shared_words=frozenset(word for word, count in sharing.items() if count >= fewest),
        counters=tuple(counters),
        empty=tuple(empty),
    )


def _desired(columns: Mapping[str, SeenColumn]) -> list[str]:
    """Names that end in a d for desired, each beside the same without it: ``q_d`` and ``tau_J_d`` of a Franka.

    A ``q_d`` beside ``q`` alone is the rate of it; beside a ``dq`` or another effort of two kinds it is not.
    """
    by_words = {column.spoken.stem_words: name for name, column in columns.items()}
    desired: list[str] = []
    told_so = False
    for words, name in by_words.items():
        place = next(
            (place for place in range(len(words) - 1, 0, -1) if not words[place].isdecimal()), 0
        )
        base = (
            by_words.get((*words[:place], *words[place + 1 :]))
            if place and words[place] == "d"
            else None
        )
        if base is None:
            continue
        desired.append(name)
        said = columns[base].spoken
        is_a_rate = "slip" in said.may_be or bool(_RATE.fullmatch(said.plain_stem))
        told_so = told_so or is_a_rate or "effort" in said.may_be or said.stem_words[:1] == ("tau",)
    return desired if told_so else []


def is_of_steps(column: SeenColumn) -> bool:
    """Whether a column is called like the time from row to row, and does not rise as a time does."""
    return column.spoken.plain_stem in STEPS_OF_TIME and not column.shape.rises


def _is_finer(column: SeenColumn, dates: Array) -> bool:
    """Whether a column in a unit of time grows in each row, and goes with dates that repeat as far as these tell."""
    factor = units.parse(column.written_unit or "s").factor
    ticks = np.diff(dates)
    tick = float(np.min(ticks[ticks > 0.0], initial=np.inf))  # s
    if not np.any(ticks == 0.0) or not np.isfinite(tick):
        return False
    apart = dates - column.values * factor
    return bool(np.all(column.steps > 0.0) and np.ptp(apart) <= tick)


@lru_cache(maxsize=4 * KEPT_NAMES)  # for four signals
def unit_fits(
    name: str,
    unit: str | None,
    si_units: tuple[str, ...],
) -> bool | None:
    """Whether the unit of a column, or the unit that ends its name, is one for some SI units; None without a unit."""
    known = own_unit(name, unit, si_units)
    if not known:
        return False if says_a_unit(name) else None
    try:
        return units.fits(known, si_units) is not None
    except UnitError:
        return False
