"""Files of flow curves take the road of logs: a reader gives tables, a plan names the columns, and rows become curves.

One file may hold several curves: pairs of columns with a label over each pair, one column of rates beside several
columns of stresses, sheets of a workbook, or tests of a rheometer's export.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from erclutch.errors import (
    ErclutchError,
    LogError,
    MappingError,
    SettingError,
    listed,
    placed,
    shell_word,
)
from erclutch.logs import read_table, recordings_in
from erclutch.logs.columns.rheometer_names import said_by_name
from erclutch.logs.columns.row_groups import EACH, group_of, rows_of, wants_each
from erclutch.logs.log_file import tables_in
from erclutch.logs.table import Table, WordColumn
from erclutch.wings.rheology.conditions import (
    RATES_OF_A_SWEEP,
    Condition,
    asked_about,
    conditions_note,
    conditions_of,
    overlap,
)
from erclutch.wings.rheology.field_series import Level, levels_in, with_fields
from erclutch.wings.rheology.flow_curve import FEWEST_POINTS, FlowCurve
from erclutch.wings.rheology.flow_plan import FlowPlan, plan_of
from erclutch.wings.rheology.flow_plateau import half_last_digit
from erclutch.wings.rheology.flow_points import points_of
from erclutch.wings.rheology.held_rates import require_no_hold, require_several_rates
from erclutch.wings.rheology.rotor_speeds import a_row_for_each_speed
from erclutch.wings.rheology.summary_rows import without_summary_rows

_Speaking = tuple[int, int]
_NOTHING_SPEAKS: _Speaking = (0, 0)


@dataclass(frozen=True)
class FlowFile:
    """Flow curves of a file.

    Attributes:
        curves: with rates in 1/s and stresses in Pa, both above 0.
        notes: what each column was taken for, and which rows were left out, one sentence each.
    """

    curves: tuple[FlowCurve, ...]
    notes: tuple[str, ...]


def read_flow_curves(
    path: str | Path,
    *,
    shear_rate: str | None = None,
    stress: Sequence[str] = (),
    sheet: Sequence[str] = (),
) -> FlowFile:
    """Read all flow curves of a file.

    Args:
        path: a log file of any format that `erclutch.read` knows.
        shear_rate: the column of shear rates, with its unit; None: by name and unit.
        stress: the columns of shear stresses or viscosities; none: by name and unit.
        sheet: which sheets or tests of the file, by name or by number from 1, or ``COLUMN=WORD`` for the rows in which
            a column has a word (``COLUMN=all``: of each word); none: all that hold a flow curve.

    Raises:
        LogError: the file cannot be read, or holds no flow curve.
        MappingError: a column cannot be told (UnitError: or its unit).
        SettingError: no such test.
    """
    with placed(str(path)):
        recordings = recordings_in(path)
        chosen = _chosen(path, recordings, sheet)
        tables = tables_in(path, [name for name in chosen if name in recordings])
        parted: dict[str | None, Table] = {}  # read once for all words of a column
        each_named = bool(sheet) and not any(wants_each(test) for test in sheet)
        gathered = _Gathered()
        for name in chosen:
            speaking = _NOTHING_SPEAKS
            try:
                group = None if name in recordings else group_of(name)
                if group is None:
                    table = _table(tables.get(name), path)
                else:
                    if group.recording not in parted:
                        parted[group.recording] = read_table(path, variable=group.recording)
                    table = rows_of(parted[group.recording], group)
                speaking = _speaking_for_a_flow_curve(table)
                table, rate_label, stress_labels = _with_a_row_a_speed(table, shear_rate, stress)
                plan = _plan_of(table, rate_label, stress_labels, sheet)
                require_several_rates(plan, table)
                if not sheet:
                    require_no_hold(name)
                parting = _parting_words(plan, table)
                if parting and not sheet and len(chosen) == 1 and _parts_whole(table, parting[1]):
                    return _of_each_word(path, shear_rate, stress, *parting)
                if parting:
                    raise _several_samples(table, *parting)
                conditions = conditions_of(table, plan, parted=any(map(group_of, sheet)))
            except (LogError, MappingError) as error:
                # A sheet of remarks or an oscillation beside the flow curves ends nothing, a file of them alone does.
                if len(chosen) == 1 or each_named:
                    raise
                gathered.refuse(name, speaking, error, f"no flow curve ({error.problem})")
                continue

            for note in _told(table, plan, conditions):
                if len(chosen) == 1 or not note.startswith("recording read from"):
                    gathered.notes.append((name, note))
            is_one_of_several = not each_named and len(chosen) * len(conditions) > 1
            for condition in conditions:
                test = "; ".join(word for word in (name, condition.label) if word)
                gathered.take(plan, condition, test, speaking, is_one_of_several=is_one_of_several)
        return gathered.as_file()


def _speaking_for_a_flow_curve(table: Table) -> _Speaking:
    """How many of rate, stress and viscosity a table names, and in how many columns.

    Four viscosities beside the parameters of a law speak less than a rate beside a stress.
    """
    said = [said_by_name(name) for name in table.columns]
    quantities = [role for role in said if role in ("rate", "stress", "viscosity")]
    return len(set(quantities)), len(quantities)


@dataclass
class _Gathered:
    """What the tests of a file gave, one after another.

    Attributes:
        curves: of all tests.
        fields: of each curve.
        notes: each behind the test that it is of.
        refused: errors of tests, each behind what speaks for a flow curve, see `_speaking_for_a_flow_curve`.
    """

    curves: list[FlowCurve] = field(default_factory=list[FlowCurve])
    fields: list[dict[str, Level]] = field(default_factory=list[dict[str, Level]])
    notes: list[tuple[str, str]] = field(default_factory=list[tuple[str, str]])
    refused: list[tuple[_Speaking, ErclutchError]] = field(
        default_factory=list[tuple[_Speaking, ErclutchError]]
    )

    def refuse(self, test: str, speaking: _Speaking, error: ErclutchError, note: str) -> None:
        """Go on without a test, with a note."""
        self.refused.append((speaking, error))
        self.notes.append((test, note))

    def take(
        self,
        plan: FlowPlan,
        condition: Condition,
        test: str,
        speaking: _Speaking,
        *,
        is_one_of_several: bool,
    ) -> None:
        """Take the curves of a condition; of several conditions or tests one without a curve is left out.

        Raises:
            LogError: the only one has no curve.
        """
        try:
            curves, left_out = curves_of(plan, condition.table, test)
        except LogError as error:
            if not is_one_of_several:
                raise
            self.refuse(test, speaking, error, f"no flow curve ({error.problem})")
            return
        short = [curve for curve in curves if curve.rate.size < FEWEST_POINTS]
        if short and is_one_of_several:  # a few points beside curves
            problem = f"{short[0].rate.size} points, at least {FEWEST_POINTS} are needed"
            error = LogError(f"{test}: {problem}", remedy="Give more points of each curve")
            self.refuse(test, speaking, error, f"{problem}: left out")
            return
        self.curves += curves
        self.fields += [levels_in(condition.table)] * len(curves)
        for note in left_out:
            is_behind_its_test = note.startswith(
                f"{test}: "
            )  # the label of a test's only curve is the test
            self.notes.append(("" if is_behind_its_test else test, note))

    def as_file(self) -> FlowFile:
        """The curves with their fields.

        Raises:
            ErclutchError: no test has a curve; that of the test for which most speaks.
        """
        if not self.curves:
            if self.refused:
                _, likeliest = max(self.refused, key=lambda pair: pair[0])
                raise likeliest
            raise LogError(
                "the file holds no flow curve", remedy="Give shear rates and shear stresses"
            )
        curves, of_fields = with_fields(self.curves, self.fields)
        tests_of: dict[
            str, list[str]
        ] = {}  # by the note: what is told of several tests is said once
        for test, note in self.notes:
            tests_of.setdefault(note, []).append(test)
        said: list[str] = []
        for note, (first, *others) in tests_of.items():
            more = f" and {len(others)} more" if others else ""
            said.append(f"{first}{more}: {note}" if first else note)
        return FlowFile(tuple(curves), (*said, *of_fields))


def _told(table: Table, plan: FlowPlan, conditions: Sequence[Condition]) -> list[str]:
    """What is said of a table: how it was read, what its columns were taken for, and what parts its points."""
    told = [*table.notes, *plan.notes]
    unused = [column for column in plan.unused if column not in conditions[0].columns]
    if unused:
        told.append(f"not used: {', '.join(unused)}")
    if len(conditions) > 1:
        told.append(conditions_note(conditions))
    return told


def _table(read: Table | LogError | None, path: str | Path) -> Table:
    """The table of a recording that was read with the others, or of a file that is one recording."""
    if isinstance(read, LogError):
        raise read
    return without_summary_rows(read_table(path) if read is None else read)


def _chosen(
    path: str | Path,
    names: Sequence[str],
    tests: Sequence[str],
) -> list[str]:
    """Names of the recordings to read; "" for a file that is one recording."""
    if not tests:
        return list(names) or [""]
    chosen: list[str] = []
    for test in tests:
        if test not in names and group_of(test):  # rows that a column parts
            chosen += recordings_in(path, test) if wants_each(test) else [test]
            continue
        name = test
        if test not in names and test.isdecimal() and 1 <= int(test) <= len(names):
            name = names[int(test) - 1]
        if name not in names:
            numbered = [f"{number} {known}" for number, known in enumerate(names, start=1)]
            there = ", ".join(numbered) or "none: leave --sheet out"
            raise SettingError(
                f"there is no test {test!r}", where="--sheet", remedy=f"Choose from {there}"
            )
        chosen.append(name)
    return chosen


def _with_a_row_a_speed(
    table: Table,
    shear_rate: str | None,
    stress: Sequence[str],
) -> tuple[Table, str | None, Sequence[str]]:
    """A table of readings at the same speeds turned, if the options give its two factors alone; with their labels."""
    factors = [shear_rate or "", *stress]
    if len(factors) != 2 or not all(re.fullmatch(r"\[[^\[\]]+\]", factor) for factor in factors):
        return table, shear_rate, stress
    turned = a_row_for_each_speed(table)
    if turned is None:
        return table, shear_rate, stress
    speeds, *rows = turned.columns
    return turned, f"{speeds} {factors[0]}", [f"{row} {factors[1]}" for row in rows]


def _plan_of(
    table: Table,
    shear_rate: str | None,
    stress: Sequence[str],
    tests: Sequence[str],
) -> FlowPlan:
    """The plan of a table; what it asks for is asked together with the rows that a column parts.

    Raises:
        MappingError: see `plan_of`.
    """
    try:
        return plan_of(table, shear_rate, stress)
    except MappingError as error:
        if tests or '"' not in error.remedy:
            raise
        parting = list(table.words) or _asked_about(table, shear_rate)
        if not parting:
            raise
        sheets = f"--sheet {shell_word(f'{parting[0]}={EACH}')}"
        # Where the remedy has two answers, the rows are the same by both.
        remedy = (
            f"{error.remedy}; with {sheets}"
            if ", or " in error.remedy
            else f"{error.remedy} {sheets}"
        )
        raise type(error)(error.problem, where=error.where, remedy=remedy) from None


def _asked_about(table: Table, shear_rate: str | None) -> list[str]:
    """Columns of numbers that would part the points, whatever the unit of the viscosities is."""
    nameless = [f"{name} [Pa*s]" for name in table.columns if said_by_name(name) == "viscosity"]
    try:
        return asked_about(table, plan_of(table, shear_rate, nameless))
    except MappingError:
        return []


def _parting_words(plan: FlowPlan, table: Table) -> tuple[str, WordColumn] | None:
    """The column of words that parts the rows into several sweeps over the same rates, which are several curves.

    What an instrument notes beside single points, such as that a stress is below its range, parts no sweep.
    """
    rate = table.columns[plan.curves[0].rate.name]
    for name, column in table.words.items():
        ends: list[tuple[float, float]] = []  # [1/s], of each sweep
        for number in range(len(column.words)):
            sweep = rate[(column.of_row == number) & np.isfinite(rate)]
            if np.unique(sweep).size >= RATES_OF_A_SWEEP:
                ends.append((float(sweep.min()), float(sweep.max())))
        if overlap(ends):
            return name, column
    return None


def _several_samples(table: Table, name: str, column: WordColumn) -> MappingError:
    """What is said of rows of several samples where one curve is wanted."""
    one = f"--sheet {shell_word(f'{name}={column.words[0]}')}"
    each = f"--sheet {shell_word(f'{name}={EACH}')}"
    problem = f"column {name} parts the points into {len(column.words)}: {listed(column.words, 6)}"
    return MappingError(
        problem, where=table.name, remedy=f"Take each as a curve: {each}; or one: {one}"
    )


def _parts_whole(table: Table, column: WordColumn) -> bool:
    """Whether no other column of words parts the rows of a word again, for these would be mixed."""
    for other in table.words.values():
        pairs = {*zip(column.of_row.tolist(), other.of_row.tolist(), strict=True)}
        if len(pairs) > len(column.words):
            return False
    return True


def _of_each_word(
    path: str | Path,
    shear_rate: str | None,
    stress: Sequence[str],
    name: str,
    column: WordColumn,
) -> FlowFile:
    """The curves of a file in which a column of words parts the rows: each word has its own, so none is mixed."""
    of_words = read_flow_curves(
        path, shear_rate=shear_rate, stress=stress, sheet=[f"{name}={EACH}"]
    )
    one = f"--sheet {shell_word(f'{name}={column.words[0]}')}"
    parted = f"column {name} parts the points into {len(column.words)}: {listed(column.words, 6)}"
    return FlowFile(
        of_words.curves, (f"{parted}: each is a curve ({one} takes one)", *of_words.notes)
    )


def curves_of(
    plan: FlowPlan,
    table: Table,
    test: str = "",
) -> tuple[list[FlowCurve], list[str]]:
    """The curves that a plan names, in SI units, and what was left out.

    Args:
        plan: made for this table.
        table: its columns.
        test: the sheet or test, for the labels.

    Raises:
        LogError: a curve has no points, or rates and stresses of opposite signs.
    """
    curves: list[FlowCurve] = []
    notes: list[str] = []
    for curve in plan.curves:
        # A test's only curve is named after the test, other curves after their column.
        label = curve.label
        is_alone = len(plan.curves) == 1 and label == curve.stress.name
        if is_alone:
            label = test or Path(table.name).stem
        elif test:
            label = f"{test}: {label}"
        rate, stress, told = points_of(curve, table, label)
        notes += [f"{label}: {note}" for note in told]

        # Half a last digit of the stress at the lowest rate, as the file writes it.
        lowest = int(np.argmin(rate))
        pascals = curve.stress.factor  # that a 1 in the file stands for
        if curve.times_rate:
            pascals *= float(rate[lowest])
        written = float(stress[lowest]) / pascals
        rounding = pascals * half_last_digit(written, table.columns[curve.stress.name])  # [Pa]
        curves.append(FlowCurve(label, rate, stress, rounding=rounding))
    return curves, notes
