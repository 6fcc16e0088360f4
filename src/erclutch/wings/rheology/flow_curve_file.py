"""Files of flow curves take the road of logs: a reader gives tables, a plan names the columns, and rows become curves.

One file may hold several curves: pairs of columns with a label over each pair, one column of rates beside several
columns of stresses, sheets of a workbook, or tests of a rheometer's export.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np

from erclutch.errors import ErclutchError, LogError, MappingError, SettingError, placed, shell_word
from erclutch.logs import read_table, recordings_in
from erclutch.logs.columns.rheometer_names import said_by_name
from erclutch.logs.columns.row_groups import EACH, group_of, rows_of, wants_each
from erclutch.logs.log_file import tables_in
from erclutch.logs.table import Table, WordColumn, listed
from erclutch.signals.array import Array
from erclutch.signals.percent import percent
from erclutch.wings.rheology.conditions import Condition, asked_about, conditions_note, conditions_of
from erclutch.wings.rheology.field_series import Level, levels_in, with_fields
from erclutch.wings.rheology.flow_curve import FEWEST_POINTS, FlowCurve
from erclutch.wings.rheology.flow_plan import CurvePlan, FlowPlan, oscillation, plan_of
from erclutch.wings.rheology.flow_plateau import half_last_digit
from erclutch.wings.rheology.held_rates import require_several_rates
from erclutch.wings.rheology.rotor_speeds import a_row_for_each_speed
from erclutch.wings.rheology.summary_rows import without_summary_rows

#: What instruments write for a point that they could not measure.
_SENTINELS = (-9999.0, -999.0, -99.0, 9999.0, 99999.0, 999999.0)
_FEWEST_RATES = 3  # of a sweep
_FEW_POINTS = 5  # of which one with a wrong sign is an oversight
_FAINT = 0.02  # of the largest stress: a stress of the wrong sign below it is noise
_RESTING = 1e-3  # of the largest rate: a rate of the wrong sign below it is noise about a rest


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
        curves: list[FlowCurve] = []
        fields: list[dict[str, Level]] = []  # of each curve
        notes: list[tuple[str, str]] = []  # each with the test that it is of
        refused: list[tuple[int, ErclutchError]] = []  # with the number of columns that speak for a flow curve
        for name in chosen:
            speaking = 0
            try:
                group = None if name in recordings else group_of(name)
                if group is None:
                    table = _table(tables.get(name), path)
                else:
                    if group.recording not in parted:
                        parted[group.recording] = read_table(path, variable=group.recording)
                    table = rows_of(parted[group.recording], group)
                speaking = sum(said_by_name(column) in ("rate", "stress", "viscosity") for column in table.columns)
                table, rate_label, stress_labels = _with_a_row_a_speed(table, shear_rate, stress)
                plan = _plan_of(table, rate_label, stress_labels, sheet)
                require_several_rates(plan, table)
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
                refused.append((speaking, error))
                notes.append((name, f"no flow curve ({error.problem})"))
                continue
            told = _told(table, plan, conditions)
            notes += [(name, note) for note in told if len(chosen) == 1 or not note.startswith("recording read from")]
            for condition in conditions:
                test = "; ".join(word for word in (name, condition.label) if word)
                try:
                    curves_of_condition, left_out = curves_of(plan, condition.table, test)
                except LogError as error:
                    if each_named or len(chosen) * len(conditions) == 1:
                        raise
                    refused.append((speaking, error))
                    notes.append((test, f"no flow curve ({error.problem})"))
                    continue
                short = [curve for curve in curves_of_condition if curve.rate.size < FEWEST_POINTS]
                if short and not each_named and len(chosen) * len(conditions) > 1:  # a few points beside curves
                    problem = f"{short[0].rate.size} points, at least {FEWEST_POINTS} are needed"
                    refused.append((speaking, LogError(f"{test}: {problem}", remedy="Give more points of each curve")))
                    notes.append((test, f"{problem}: left out"))
                    continue
                curves += curves_of_condition
                fields += [levels_in(condition.table)] * len(curves_of_condition)
                # The label of a test's only curve is the test.
                notes += [("" if note.startswith(f"{test}: ") else test, note) for note in left_out]
        if not curves:
            if refused:
                _, likeliest = max(refused, key=lambda pair: pair[0])
                raise likeliest
            raise LogError("the file holds no flow curve", remedy="Give shear rates and shear stresses")
        curves, of_fields = with_fields(curves, fields)
        return FlowFile(tuple(curves), (*_said_once(notes), *of_fields))


def _told(table: Table, plan: FlowPlan, conditions: Sequence[Condition]) -> list[str]:
    """What is said of a table: how it was read, what its columns were taken for, and what parts its points."""
    told = [*table.notes, *plan.notes]
    unused = [column for column in plan.unused if column not in conditions[0].columns]
    if unused:
        told.append(f"not used: {', '.join(unused)}")
    if len(conditions) > 1:
        told.append(conditions_note(conditions))
    return told


def _said_once(notes: Sequence[tuple[str, str]]) -> list[str]:
    """Notes behind the names of their tests; what is told of several tests is said once."""
    tests: dict[str, list[str]] = {}
    for test, note in notes:
        tests.setdefault(note, []).append(test)
    said: list[str] = []
    for note, (first, *others) in tests.items():
        more = f" and {len(others)} more" if others else ""
        said.append(f"{first}{more}: {note}" if first else note)
    return said


def _table(found: Table | LogError | None, path: str | Path) -> Table:
    """The table of a recording that was read with the others, or of a file that is one recording."""
    if isinstance(found, LogError):
        raise found
    return without_summary_rows(read_table(path) if found is None else found)


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
            raise SettingError(f"there is no test {test!r}", where="--sheet", remedy=f"Choose from {there}")
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
        remedy = f"{error.remedy}; with {sheets}" if ", or " in error.remedy else f"{error.remedy} {sheets}"
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
            if np.unique(sweep).size >= _FEWEST_RATES:
                ends.append((float(sweep.min()), float(sweep.max())))
        ends.sort()
        if any(low < before for (_, before), (low, _) in pairwise(ends)):
            return name, column
    return None


def _several_samples(table: Table, name: str, column: WordColumn) -> MappingError:
    """What is said of rows of several samples where one curve is wanted."""
    one = f"--sheet {shell_word(f'{name}={column.words[0]}')}"
    each = f"--sheet {shell_word(f'{name}={EACH}')}"
    return MappingError(
        f"column {name} parts the points into {len(column.words)}: {listed(column.words, 6)}",
        where=table.name,
        remedy=f"Take each as a curve: {each}; or one: {one}",
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
    found = read_flow_curves(path, shear_rate=shear_rate, stress=stress, sheet=[f"{name}={EACH}"])
    one = f"--sheet {shell_word(f'{name}={column.words[0]}')}"
    parted = f"column {name} parts the points into {len(column.words)}: {listed(column.words, 6)}"
    return FlowFile(found.curves, (f"{parted}: each is a curve ({one} takes one)", *found.notes))


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
        label = _label(curve, plan, table, test)
        rate, stress, told = _points(curve, table, label)
        lowest = int(np.argmin(rate))
        of_one = curve.stress.factor * (
            float(rate[lowest]) if curve.times_rate else 1.0
        )  # [Pa], that a cell's 1 stands for
        half_digit = half_last_digit(float(stress[lowest]) / of_one, table.columns[curve.stress.name])
        curves.append(FlowCurve(label, rate, stress, rounding=half_digit * of_one))
        notes += [f"{label}: {note}" for note in told]
    return curves, notes


def _label(curve: CurvePlan, plan: FlowPlan, table: Table, test: str) -> str:
    """A test's only curve is named after the test, other curves after their column."""
    alone = len(plan.curves) == 1 and curve.label == curve.stress.name
    if test:
        return test if alone else f"{test}: {curve.label}"
    return Path(table.name).stem if alone else curve.label


def _points(
    curve: CurvePlan,
    table: Table,
    label: str,
) -> tuple[Array, Array, list[str]]:
    """Shear rates in 1/s and stresses in Pa of the points that can be used, each shape (n,), and what was left out."""
    rate = table.columns[curve.rate.name]
    stress = table.columns[curve.stress.name]
    notes: list[str] = []
    # The labels of pairs that are numbers stand in the first row, without a stress.
    empty = np.isnan(rate) & np.isnan(stress)
    half = np.isnan(rate) ^ np.isnan(stress)
    if half.any() and curve.rate.reason.startswith("a label") and curve.label == f"{rate[0]:g}":
        half[0] = False
        empty[0] = True
    never = np.isin(rate, _SENTINELS) | np.isin(stress, _SENTINELS)
    at_rest = (rate == 0) & ~never
    swings, marks = oscillation(table)
    if swings.all():  # then the marks tell nothing apart
        swings = np.zeros_like(swings)
    swings = swings & ~empty & ~half & ~never & ~at_rest
    for rows, why in (
        (swings, f"in oscillation ({', '.join(marks[:3])})"),
        (half, "without a rate or without a stress"),
        (never, "of a value that instruments write for no measurement"),
        (at_rest & ~half, "at rest, which a logarithm has no place for"),
    ):
        if rows.any():
            notes.append(f"{int(rows.sum())} of {int((~empty).sum())} points left out: {why}")
    kept = ~(empty | half | never | at_rest | swings)
    if not kept.any():
        problem = "no point has a shear rate and a shear stress"
        raise LogError(problem, where=f"{table.name}, {label}", remedy="Check the columns")
    places = np.flatnonzero(kept)  # of the points in the table
    rate = rate[kept] * curve.rate.factor  # [1/s]
    stress = stress[kept] * curve.stress.factor  # [Pa], or a viscosity in Pa s
    if curve.times_rate:
        # Viscosities that are all positive are magnitudes, so their stresses are magnitudes too.
        are_magnitudes = (stress > 0).all()
        stress = stress * (np.abs(rate) if are_magnitudes else rate)  # [Pa]
    turned = (rate < 0) & (stress < 0)
    if turned.any():
        notes.append(f"{int(turned.sum())} points turn the other way: magnitudes are taken")
        rate = np.where(turned, -rate, rate)
        stress = np.where(turned, -stress, stress)
    if curve.times_rate:
        rate = np.abs(rate)

    against = np.sign(rate) != np.sign(stress)
    size = np.abs(stress)
    largest = float(size.max(initial=0.0))
    turned_back = np.sign(rate) != np.sign(np.sign(rate).sum())
    resting = against & turned_back & (np.abs(rate) < _RESTING * np.abs(rate).max(initial=0.0))
    faint = against & (size < _FAINT * largest)
    clear = np.ones(rate.size, np.bool_)  # points that are kept
    if resting.any() and not faint[resting].all() and 2 * int(against.sum()) <= rate.size:
        # Noise about a rest has both signs, so what has the sign of its stress by chance is noise as well.
        noise = float(np.abs(rate[resting]).max())  # [1/s]
        at_rest = np.abs(rate) <= noise
        left_out = f"{int(at_rest.sum())} points left out: a rate of {noise:.3g} 1/s or less"
        notes.append(
            f"{left_out}, where {int(resting.sum())} have the other sign than their stress, as noise about a rest has"
        )
        clear &= ~at_rest
    faint &= clear
    if faint.any() and 2 * int((against & clear).sum()) <= int(clear.sum()):
        # At the lowest rates a fluid of low viscosity is below what an instrument resolves: the sign is noise.
        left_out = f"{int(faint.sum())} points left out: a stress of the other sign than its rate"
        notes.append(f"{left_out}, below {percent(_FAINT)} of the largest stress, as noise is")
        clear &= ~faint
    rate = rate[clear]
    stress = stress[clear]
    places = places[clear]
    against = against[clear]
    if rate.size > _FEW_POINTS and 2 * int(against.sum()) > rate.size:
        raise LogError(
            f"{int(against.sum())} of {rate.size} points have no stress along their rate, as no fluid that flows has",
            where=f"{table.name}, {label}",
            remedy="Give a test in steady rotation",
        )
    if against.any():
        first = int(np.argmax(against))
        raise LogError(
            f"row {int(places[first]) + 1} of the table has the shear rate {rate[first]:g} 1/s and the stress "
            f"{stress[first]:g} Pa",
            where=f"{table.name}, {label}",
            remedy="Remove the point, or give magnitudes",
        )
    rates = np.unique(np.round(np.log10(rate), 2))
    if rates.size < _FEWEST_RATES:
        notes.append(f"the points have {rates.size} shear rates, which tell no more parameters of a law")
    steps = np.diff(rate)
    if np.any(steps > 0) and np.any(steps < 0):
        notes.append("the rate rises and falls: both sweeps are fitted as one curve")
    return rate, stress, notes
