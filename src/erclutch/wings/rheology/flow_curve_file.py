"""Files of flow curves take the road of logs: a reader gives tables, a plan names the columns, and rows become curves.

One file may hold several curves: pairs of columns with a label over each pair, one column of rates beside several
columns of stresses, sheets of a workbook, or tests of a rheometer's export.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from erclutch.errors import (
    ErclutchError,
    LogError,
    MappingError,
    SettingError,
    UnitError,
    listed,
    placed,
    shell_word,
)
from erclutch.logs import read_table, recordings_in
from erclutch.logs.columns.rheometer_names import said_by_name
from erclutch.logs.columns.row_groups import rows_of
from erclutch.logs.log_file import EACH, group_of, tables_in, wants_each
from erclutch.logs.table import Table, WordColumn
from erclutch.wings.rheology.computed_tests import computed_tests, require_measured
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
from erclutch.wings.rheology.labelled_pairs import UNKNOWN_UNIT
from erclutch.wings.rheology.rotor_speeds import a_row_for_each_speed
from erclutch.wings.rheology.summary_rows import without_summary_rows

#: How many of rate, stress and viscosity a table names, and in how many columns.
_Speaking = tuple[int, int]
_NOTHING_SPEAKS: _Speaking = (0, 0)


@dataclass(frozen=True)
class FlowFile:
    """Flow curves of a file.

    Attributes:
        curves: with rates in 1/s and stresses in Pa, or all in a unit that nobody says, both above 0.
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
    # Of infinities in a cell nothing is made that a warning of NumPy would help with: see `erclutch.logs.plan_of`.
    with placed(str(path)), np.errstate(over="ignore", invalid="ignore"):
        recordings = recordings_in(path)
        chosen = _chosen(path, recordings, sheet)
        tables = tables_in(path, [name for name in chosen if name in recordings])
        read_tables = {name: read for name, read in tables.items() if isinstance(read, Table)}
        computed = {} if sheet else computed_tests(read_tables)
        parted: dict[str | None, Table] = {}  # read once for all words of a column
        each_named = bool(sheet) and not any(wants_each(test) for test in sheet)
        gathered = _Gathered()
        for name in chosen:
            speaking = _NOTHING_SPEAKS
            try:
                require_measured(name or "", computed)
                group = None if name in recordings else group_of(name)
                if group is None:
                    read = tables.get(name)  # nothing for a file that is one recording
                    if isinstance(read, LogError):
                        raise read
                    table = without_summary_rows(read_table(path) if read is None else read)
                else:
                    if group.recording not in parted:
                        parted[group.recording] = read_table(path, variable=group.recording)
                    table = rows_of(parted[group.recording], group.column, group.word)
                # Four viscosities beside the parameters of a law speak less than a rate beside a stress.
                named = [said_by_name(column) for column in table.columns]
                quantities = [role for role in named if role in ("rate", "stress", "viscosity")]
                speaking = len(set(quantities)), len(quantities)

                table, plan = _planned(table, shear_rate, stress, sheet)
                require_several_rates(plan, table)
                if not sheet:
                    require_no_hold(name)
                parting = _parting_words(plan, table)
                if parting is not None:
                    words, sweeps, are_mixed = parting
                    one = f"--sheet {shell_word(f'{words}={sweeps.words[0]}')}"
                    problem = f"column {words} parts the points into {len(sweeps.words)}: {listed(sweeps.words, 6)}"
                    if sheet or len(chosen) > 1 or are_mixed:
                        each = f"--sheet {shell_word(f'{words}={EACH}')}"
                        remedy = f"Take each as a curve: {each}; or one: {one}"
                        raise MappingError(
                            problem, where=table.name, remedy=remedy, answers=[each, one]
                        )
                    of_each_word = read_flow_curves(
                        path, shear_rate=shear_rate, stress=stress, sheet=[f"{words}={EACH}"]
                    )
                    note = f"{problem}: each is a curve ({one} takes one)"
                    return FlowFile(of_each_word.curves, (note, *of_each_word.notes))
                conditions = conditions_of(table, plan, parted=any(map(group_of, sheet)))
            except (LogError, MappingError) as error:
                # A sheet of remarks or an oscillation beside the flow curves ends nothing, a file of them alone does.
                if len(chosen) == 1 or each_named:
                    raise
                gathered.refuse(name, speaking, error, f"no flow curve ({error.problem})")
                continue

            notes = [*table.notes, *plan.notes]
            unused = [column for column in plan.unused if column not in conditions[0].columns]
            if unused:
                notes.append(f"not used: {', '.join(unused)}")
            if len(conditions) > 1:
                notes.append(conditions_note(conditions))
            for note in notes:
                if len(chosen) == 1 or not note.startswith("recording read from"):
                    gathered.notes.append((name, note))
            is_one_of_several = not each_named and len(chosen) * len(conditions) > 1
            for condition in conditions:
                test = "; ".join(word for word in (name, condition.label) if word)
                gathered.take(plan, condition, test, speaking, is_one_of_several=is_one_of_several)
        return gathered.as_file()


@dataclass
class _Gathered:
    """What the tests of a file gave, one after another.

    Attributes:
        curves: of all tests.
        fields: of each curve.
        notes: each behind the test that it is of.
        refused: errors of tests, each behind what speaks for a flow curve, see `_Speaking`.
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
            # The label of a test's only curve is the test.
            is_behind_its_test = note.startswith(f"{test}: ")
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
        if len({curve.stress_unit for curve in self.curves}) > 1:
            open_one = next(c.label for c in self.curves if c.stress_unit == UNKNOWN_UNIT)
            problem = f"the viscosities of {open_one} have no unit, and other curves are in Pa"
            raise UnitError(
                problem, remedy='Say it: --stress "NAME [mPa*s]", with --sheet for one test'
            )
        curves, of_fields = with_fields(self.curves, self.fields)
        # By the note: what is told of several tests is said once.
        tests_of: dict[str, list[str]] = {}
        for test, note in self.notes:
            tests_of.setdefault(note, []).append(test)
        sentences: list[str] = []
        for note, (first, *others) in tests_of.items():
            more = f" and {len(others)} more" if others else ""
            sentences.append(f"{first}{more}: {note}" if first else note)
        return FlowFile(tuple(curves), (*sentences, *of_fields))


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


def _planned(
    table: Table,
    shear_rate: str | None,
    stress: Sequence[str],
    tests: Sequence[str],
) -> tuple[Table, FlowPlan]:
    """A table and its plan; what the plan asks for is asked together with the rows that a column parts.

    Readings at the same speeds are turned, a row a speed, if the options give their two factors alone.

    Raises:
        MappingError: see `plan_of`.
    """
    factors = [shear_rate or "", *stress]
    are_factors = all(re.fullmatch(r"\[[^\[\]]+\]", factor) for factor in factors)
    turned = a_row_for_each_speed(table) if len(factors) == 2 and are_factors else None
    if turned is not None:
        table = turned
        speeds, *rows = turned.columns
        shear_rate = f"{speeds} {factors[0]}"
        stress = [f"{row} {factors[1]}" for row in rows]
    if table.torn_rows:
        raise LogError(table.torn_rows, where=table.name, remedy="Correct or delete that line")
    if table.unsure_names and not (shear_rate and stress):
        remedy = 'Give both columns: --shear-rate "NAME [1/s]" --stress "NAME [Pa]"'
        raise MappingError(table.unsure_names, where=table.name, remedy=remedy)
    try:
        return table, plan_of(table, shear_rate, stress)
    except MappingError as error:
        if tests or '"' not in error.remedy:
            raise
        parting = [name for name in table.words if name != table.clock_name]
        if not parting:
            # Columns of numbers that would part the points, whatever the unit of the viscosities is.
            nameless = [
                f"{name} [Pa*s]" for name in table.columns if said_by_name(name) == "viscosity"
            ]
            with suppress(MappingError):
                parting = asked_about(table, plan_of(table, shear_rate, nameless))
        if not parting:
            raise
        sheets = f"--sheet {shell_word(f'{parting[0]}={EACH}')}"
        # Where the remedy has two answers, the rows are the same by both.
        remedy = (
            f"{error.remedy}; with {sheets}"
            if ", or " in error.remedy
            else f"{error.remedy} {sheets}"
        )
        answers = [f"{answer} {sheets}" for answer in error.answers]
        raise type(error)(
            error.problem, where=error.where, remedy=remedy, answers=answers
        ) from None


def _parting_words(plan: FlowPlan, table: Table) -> tuple[str, WordColumn, bool] | None:
    """The column of words that parts the rows into several sweeps over the same rates, which are several curves.

    What an instrument notes beside single points, such as that a stress is below its range, parts no sweep.

    Returns:
        Its name, the column, and whether another column of words parts the rows of a word again, which are mixed then.
    """
    rate = table.columns[plan.curves[0].rate.name]
    for name, column in table.words.items():
        if name == table.clock_name:
            continue  # times, of which an instrument may count few, such as its intervals
        ends: list[tuple[float, float]] = []  # [1/s], of each sweep
        for number in range(len(column.words)):
            sweep = rate[(column.of_row == number) & np.isfinite(rate)]
            if np.unique(sweep).size >= RATES_OF_A_SWEEP:
                ends.append((float(sweep.min()), float(sweep.max())))
        if overlap(ends):
            are_mixed = False
            for other in table.words.values():
                pairs = {*zip(column.of_row.tolist(), other.of_row.tolist(), strict=True)}
                are_mixed = are_mixed or len(pairs) > len(column.words)
            return name, column, are_mixed
    return None


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
        rate, stress, left_out = points_of(curve, table, label)
        notes += [f"{label}: {note}" for note in left_out]

        # Half a last digit of the stress at the lowest rate, as the file writes it.
        lowest = int(np.argmin(rate))
        of_a_one = curve.stress.factor  # the stress that a 1 in the file stands for
        if curve.times_rate:
            of_a_one *= float(rate[lowest])
        written = float(stress[lowest]) / of_a_one
        rounding = of_a_one * half_last_digit(written, table.columns[curve.stress.name])
        of_curve = FlowCurve(label, rate, stress, rounding=rounding, stress_unit=curve.stress_unit)
        curves.append(of_curve)
    return curves, notes
