"""Columns without names are proposed by their numbers, so that the user has one command to check and not a riddle.

Nothing is taken here: who knows the device says yes, or puts other columns in.
"""

from __future__ import annotations

import re
import shlex
from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import permutations
from typing import NamedTuple

import numpy as np

from erclutch.errors import shell_word
from erclutch.logs.columns.names import words_of
from erclutch.logs.columns.shapes import known_rows, takes_both_signs
from erclutch.logs.columns.two_courses import over_rate
from erclutch.logs.planning.clock_by_motion import usual_rate
from erclutch.logs.planning.draft import Draft
from erclutch.logs.planning.strength_of_efforts import strengths_of_efforts
from erclutch.logs.planning.unit_of_stamps import likely_unit
from erclutch.logs.table import Table
from erclutch.signals.array import Array

_NUMBERED = re.compile(r"(.*?)_?(\d+)")
_NUMBER_BEHIND = re.compile(r"_?\d+$")
#: What programs of learning call what they learn from, and what they learn.
_INPUTS = frozenset({"x", "input", "inputs", "feature", "features"})
_OUTPUTS = frozenset({"y", "target", "targets", "output", "outputs", "label", "labels"})
_COMMANDS = frozenset({"u"})
#: Channels of a controller or a converter, as its program calls them: ``CH1in``, ``AI0_out``.
_CHANNEL = re.compile(
    r"(?:ch|chan|channel|kanal|ai|ao|adc|port)[ _]?\d{1,3}[ _]?(in|out|sig|signal|input|output)?",
    re.IGNORECASE,
)
_PUT_IN = frozenset({"in", "input"})
_FOLLOWS = 0.98  # correlation of what a loop is told, and of what comes of it
_CLEARLY = 1.5  # times the other power, where a channel may be a position or a speed
_MOST = 8  # columns: of more, numbers alone tell too little
_DISSIPATES = 0.1  # power of an effort over a motion, over the product of their root mean squares
_SURELY = 0.3  # the same, where the effort follows a field most of all
_ONE_COURSE = 0.999  # correlation of two columns that tell one thing
_UNEVEN = 0.2  # of the usual step, by which a busy logger is late
_MOST_STEPS = 0.8  # of all: the others lie at gaps
_OFF_A_CLOCK = 0.5  # of the usual step, by which rounded stamps are off a steady clock
_TOGETHER = 0.9  # of the rows, in which two columns have one sign
_FEWEST_OF_A_RUN = 30  # rows of a log before its time begins anew: a sweep of points has fewer
_UNIT_OF_TIME = re.compile(r" \[m?s\]$")
_FEWEST_POINTS = 6  # rows of a table of points on a grid
_MOST_POINTS = 1000
_AXES = frozenset("xyz")
_MOST_LEVELS = 20  # of a column that was set
_STEPS = 0.05  # of the variance, which a switched field makes in an effort and in no motion


class _Roles(NamedTuple):
    """Columns that may be a motion and its effort; "" where the numbers tell none."""

    position: str = ""
    slip: str = ""
    effort: str = ""
    field: str = ""


def propose_columns_without_names(draft: Draft) -> None:
    """Propose a column for each signal that is asked for, where no column of the table has a name."""
    table = draft.table
    asked = draft.questions
    clock = draft.clock.column if draft.clock is not None and draft.clock.kind == "column" else ""
    if not {"slip", "effort"} <= {*asked} or not _are_without_names(draft, clock):
        return
    taken = [*draft.taken, *_counting(draft)]
    free = [each.name for each in draft.seen.without(taken) if each.name not in table.made]
    put_in = [name for name in free if _is_put_in(name)]
    told = [name for name in put_in if _is_followed(table, name, free)]
    if told != put_in:
        return  # what a loop was told, or the field: a step that is followed slowly looks like both
    free = [name for name in free if name not in told]
    options: dict[str, str] = {}

    time = _rising_steadily(table, free) if "time" in asked and _may_be_a_log(table, free) else ""
    stamps: Array = np.arange(float(table.rows))
    if time:
        free.remove(time)
        options["time"] = f"--time {shell_word(f'{time} [{_unit_of_steps(table.columns[time])}]')}"
        stamps = table.columns[time]
    elif clock:
        stamps = table.columns[clock]

    begins_anew = bool(time) and bool(np.any(np.diff(table.columns[time]) <= 0.0))
    known = draft.signals.get("field")
    if begins_anew and _points_on_a_grid(table, [time, *free], known is not None) is not None:
        free.insert(0, time)  # a speed that is swept at each level
    grid = _points_on_a_grid(table, free, known is not None) if "time" in asked else None
    if grid is not None:
        options["time"] = "--time none"
        options["field"] = f"--field {shell_word(grid.field)}"
        options["slip"] = f"--slip {shell_word(grid.slip)}"
        options["effort"] = f"--effort {shell_word(grid.effort)}"
        _propose(draft, options)
        return

    levels = [name for name in free if draft.seen.columns[name].shape.keeps_levels]
    switched = [name for name in levels if not takes_both_signs(table.columns[name])]
    field = switched[0] if len(switched) == 1 else ""
    if known is not None and known.column:
        field = known.column
    options["field"] = f"--field {shell_word(field)}" if field else "--field none"

    moving = [name for name in free if name not in levels and np.ptp(table.columns[name]) > 0.0]
    # A long column that rises all through is a time by a busy clock, or what was swept: nobody knows.
    may_be_times = free[:1] if time or clock or len(free) > 2 else free
    if len(free) == 2 and _oppose(table, free):
        may_be_times = []
    moving = [
        name for name in moving if name not in may_be_times or not _is_long_and_rises(table, name)
    ]
    roles = _roles(table, moving, stamps, field)
    if told and not _is_clear(table, roles):
        roles = _Roles()
    learnt = _of_learning([name for name in table.columns if name not in table.made])
    if not roles.effort or (learnt and roles.effort != learnt):
        _propose(draft, {"time": options["time"]} if time and not begins_anew else {})
        return
    if "time" in asked and not time and roles.slip and roles.position:
        rate = over_rate(table.columns[roles.slip], table.columns[roles.position], stamps)
        if rate is not None and usual_rate(rate) is not None:
            options["time"] = f"--rate {shell_word(f'{usual_rate(rate):g} Hz')}"
    elif "time" in asked and not time and roles.slip and _is_of_points(table.columns[roles.slip]):
        options["time"] = "--time none"
    motion = "slip" if roles.slip else "position"
    if not field and roles.slip:
        others = [name for name in moving if name not in roles]
        columns = {name: table.columns[name] for name in others}
        stronger = strengths_of_efforts(
            columns, table.columns[roles.slip], table.columns[roles.effort]
        )
        options["field"] = f"--field {shell_word(stronger[0])}" if stronger else "--field none"
    options["slip"] = f"--{motion} {shell_word(roles.slip or roles.position)}"
    options["effort"] = f"--effort {shell_word(roles.effort)}"

    _propose(draft, options)


def _propose(draft: Draft, options: Mapping[str, str]) -> None:
    """Put options into what is asked, where no other rule has."""
    asked = draft.questions
    for about, option in options.items():
        question = asked.get(about)
        if question is None or question.option:
            continue
        more = ""
        column = draft.seen.columns.get(_UNIT_OF_TIME.sub("", shlex.split(option)[1]))
        if about in ("slip", "effort"):
            more = f"; by the numbers alone it may be {option}"
        if column is not None:
            # How its numbers run, by which a user knows the column again.
            values = column.values[np.isfinite(column.values)]
            levels = np.unique(values).size
            ends = f"{values.min():.4g} to {values.max():.4g}"
            if about == "time":
                steps = np.diff(values)
                unit = _unit_of_steps(values)
                course = (
                    f"rises by steps of {float(np.median(steps)):.4g}, as a time in {unit} does"
                )
                again = int(np.count_nonzero(steps <= 0.0))
                course += f", and begins anew {again} times" if again else ""
            elif levels <= _MOST_LEVELS and 2 * levels <= values.size:
                course = f"has {levels} levels from {ends}"
            else:
                turns = int(np.count_nonzero(np.diff(np.signbit(values))))
                sign = f"changes its sign {turns} times" if turns else "keeps its sign"
                course = f"{sign}, {ends}"
                if about == "effort":
                    course += "; give units in brackets where you know them"
            more += f" ({column.name} {course})"
        asked[about] = replace(question.adding(more), option=option)


def _points_on_a_grid(table: Table, free: Sequence[str], has_field: bool) -> _Roles | None:
    """A motion, an effort and a field among points that were set by levels; None where the rows are no such points.

    The effort takes a number of its own at each point. Of two columns of levels the field is the one that is zero
    somewhere: without a field a device is measured too, at rest it is not.

    Args:
        table: of the file.
        free: columns that are no signal yet.
        has_field: whether the field is known.
    """
    if not _FEWEST_POINTS <= table.rows <= _MOST_POINTS:
        return None
    columns = {name: table.columns[name] for name in free}
    if not all(np.isfinite(values).all() for values in columns.values()):
        return None
    set_by_levels = [
        name
        for name, values in columns.items()
        if np.ptp(values) > 0.0 and 2 * np.unique(values).size <= values.size
    ]
    measured = [name for name in free if name not in set_by_levels]
    at_zero = [name for name in set_by_levels if np.any(columns[name] == 0.0)]
    if len(measured) != 1 or len(set_by_levels) != 2 - has_field:
        return None
    if has_field:
        return _Roles(slip=set_by_levels[0], effort=measured[0])
    if len(at_zero) != 1:
        return None
    (slip,) = (name for name in set_by_levels if name not in at_zero)
    return _Roles(slip=slip, effort=measured[0], field=at_zero[0])


def _counting(draft: Draft) -> list[str]:
    """Columns called ``index`` that count rows, as pandas writes them beside columns without names."""
    columns = draft.seen.columns
    return [name for name in columns if name == "index" and columns[name].shape.counts_rows]


def _are_without_names(draft: Draft, clock: str) -> bool:
    """Whether a few columns beside the clock are numbered from 1, or from 0, on behind one word.

    So a reader calls columns without a name, those of one array, and NumPy its arrays (``arr_0``). What goes in and out
    at numbered channels has no better names (``CH1in``). Columns that are called after the axes of a drawing (x, y)
    beside those whose name says a signal are no better named; beside a time alone they are the places of a point.
    """
    table = draft.table
    counting = _counting(draft)
    names = [name for name in table.columns if name not in (clock, *counting, *table.made)]
    lettered = [name for name in names if name not in draft.taken]
    if len(lettered) >= 2 and {name.lower() for name in lettered} <= _AXES:
        are_places = bool(clock) and len(lettered) == len(names)
        return not are_places and not any(table.units.get(name) for name in lettered)
    if not 2 <= len(names) <= _MOST:
        return False
    matches = [_NUMBERED.fullmatch(name) for name in names]
    numbers = [int(match[2]) for match in matches if match is not None]
    stems = {match[1] for match in matches if match is not None}
    has_no_unit = not any(table.units.get(name) for name in names)
    if has_no_unit and all(_CHANNEL.fullmatch(name) for name in names):
        return True
    are_counted = numbers in ([*range(1, len(names) + 1)], [*range(len(names))])
    return has_no_unit and ((len(stems) == 1 and are_counted) or bool(_of_learning(names)))


def _is_put_in(name: str) -> bool:
    """Whether a name is that of a channel at which something is put in: what a loop is told, or a field."""
    channel = _CHANNEL.fullmatch(name)
    return channel is not None and (channel[1] or "").lower() in _PUT_IN


def _is_followed(table: Table, name: str, others: Sequence[str]) -> bool:
    """Whether another column runs along with one, so that it is what a loop was told, and no signal."""
    values = table.columns[name]
    return any(_power(values, table.columns[other]) > _FOLLOWS for other in others if other != name)


def _is_clear(table: Table, roles: _Roles) -> bool:
    """Whether the power of the effort tells a position from a speed: a step of a loop looks like both."""
    motion = roles.position or roles.slip
    if not motion or not roles.effort:
        return False
    effort = table.columns[roles.effort]
    along = abs(_power(effort, table.columns[motion]))
    over_its_rate = abs(_power(effort, np.gradient(table.columns[motion])))
    return max(along, over_its_rate) > _CLEARLY * min(along, over_its_rate)


def _of_learning(names: Sequence[str]) -> str:
    """What is learnt from the columns of one array, as programs call it (``X_train``, ``y_train``); "" else.

    Beside it a vector of what was commanded may stand, ``u``.
    """
    inputs: list[str] = []
    outputs: list[str] = []
    for name in names:
        first, *_ = words_of(name)
        if first in _INPUTS and _NUMBERED.fullmatch(name):
            inputs.append(name)
        elif first in _OUTPUTS:
            outputs.append(name)
        elif first not in _COMMANDS:
            return ""
    stems = {_NUMBER_BEHIND.sub("", name) for name in inputs}
    return outputs[0] if len(outputs) == len(stems) == 1 and len(inputs) > 1 else ""


def _rising_steadily(table: Table, names: Sequence[str]) -> str:
    """The first column, if it rises in each row, mostly by steps near the usual one, which is no whole number; else "".

    A busy logger's stamps are uneven, and a few lie behind a gap. Of logs one after another, such as one at each level
    of a field, it begins anew where it began; a long course that does so counts by whole numbers above 1 too.
    """
    if not names:
        return ""
    stamps = table.columns[names[0]]
    steps = np.diff(stamps)
    if not steps.size or not np.isfinite(steps).all():
        return ""
    step = float(np.median(steps))
    begins = 1 + np.flatnonzero(steps <= 0.0)
    runs = np.diff([0, *begins.tolist(), stamps.size])
    at_the_start = np.abs(stamps[begins] - stamps[0]) <= step
    begin_anew = bool(runs.min() >= _FEWEST_OF_A_RUN and at_the_start.all())
    if step <= 0.0 or (begins.size and not begin_anew):
        return ""
    steady = stamps[0] + (stamps[-1] - stamps[0]) * np.arange(stamps.size) / steps.size
    # Stamps of few digits go on by 0.0003 and 0.0004, and yet keep to a clock.
    is_a_clock = bool(np.abs(stamps - steady).max() <= _OFF_A_CLOCK * step)
    near = float(np.mean(np.abs(steps - step) <= _UNEVEN * step))
    counts = step.is_integer() and (not begins.size or step <= 1.0)
    return names[0] if (near >= _MOST_STEPS or is_a_clock) and not counts else ""


def _may_be_a_log(table: Table, names: Sequence[str]) -> bool:
    """Whether a first column that rises may be a time: two columns of few rows, or of one sign, are points as well."""
    if len(names) != 2:
        return len(names) > 2
    return table.rows >= _FEWEST_OF_A_RUN and not _oppose(table, names)


def _oppose(table: Table, names: Sequence[str]) -> bool:
    """Whether two columns change their sign together, as a speed that is swept through zero and what opposes it do."""
    first, second = (table.columns[name] for name in names)
    return takes_both_signs(first) and float(np.mean(first * second > 0.0)) > _TOGETHER


def _is_long_and_rises(table: Table, name: str) -> bool:
    """Whether a column never falls and goes on in most rows, over more rows than a sweep of points has."""
    if table.rows < _FEWEST_OF_A_RUN:
        return False
    steps = np.diff(table.columns[name])
    return bool(np.all(steps >= 0.0) and np.mean(steps > 0.0) >= _MOST_STEPS)


def _unit_of_steps(stamps: Array) -> str:
    """The unit that is offered for stamps nobody names: whole numbers are ms, dates days, and others s."""
    if likely_unit(stamps) == "d":
        return "d"
    return "ms" if float(np.median(np.diff(stamps))).is_integer() else "s"


def _roles(table: Table, moving: Sequence[str], stamps: Array, field: str) -> _Roles:
    """Which of the columns that move may be a motion and its effort."""
    rates: dict[str, str] = {}  # the column that is the rate of a position
    for place, speed in permutations(moving, 2):
        ratio = over_rate(table.columns[speed], table.columns[place], stamps)
        if ratio is not None and ratio > 0.0:
            rates.setdefault(place, speed)
    # Of a chain of rates its first column is the position.
    position = next((name for name in rates if name not in rates.values()), "")
    slip = rates.get(position, "")
    rest = [name for name in moving if name not in (position, slip)]
    if not slip:
        switching = table.columns[field] if field else None
        return (
            _motion_and_effort(table, (rest[0], rest[1]), switching) if len(rest) == 2 else _Roles()
        )
    if not rest:  # an effort of a viscous device goes along with the rate that nobody logged
        return _Roles(position, "", slip)
    efforts: dict[str, float] = {}  # how far each goes along with the slip
    for name in rest:
        is_acceleration = over_rate(table.columns[name], table.columns[slip], stamps) is not None
        if not is_acceleration:
            efforts[name] = abs(_power(table.columns[name], table.columns[slip]))
    effort = max(efforts, key=lambda name: efforts[name], default="")
    return _Roles(position, slip, effort)


def _motion_and_effort(table: Table, pair: tuple[str, str], switching: Array | None) -> _Roles:
    """A motion and its effort among two columns.

    A passive device takes power: an effort over the rate of a position makes more than nothing, a position over the
    rate of an effort less. A speed goes along with its effort; there a switched field makes steps in the effort alone.
    """
    first, second = (table.columns[name] for name in pair)
    along = abs(_power(first, second))
    if along > _ONE_COURSE:
        return _Roles()
    # Over the rate of a noisy effort nothing is seen; where both are smooth, the sign tells which is the position.
    first_takes = _power(first, np.gradient(second))
    second_takes = _power(second, np.gradient(first))
    beside = max(abs(first_takes), abs(second_takes))
    if switching is not None:
        shares = [_share_of_levels(values, switching) for values in (first, second)]
        if max(shares) > max(_STEPS, 2.0 * min(shares)):
            effort = int(shares[1] > shares[0])
            takes = abs(second_takes if effort else first_takes)
            moves = pair[1 - effort]
            is_rate = along >= takes or takes < _SURELY
            return (
                _Roles(slip=moves, effort=pair[effort])
                if is_rate
                else _Roles(position=moves, effort=pair[effort])
            )
    if along > max(beside, _DISSIPATES):
        effort = int(_roughness(second) > _roughness(first))
        return _Roles(slip=pair[1 - effort], effort=pair[effort])
    if beside < _DISSIPATES:
        return _Roles()
    if min(abs(first_takes), abs(second_takes)) < 0.5 * beside:
        effort = int(abs(second_takes) > abs(first_takes))
    else:
        effort = int(second_takes > first_takes)
    return _Roles(position=pair[1 - effort], effort=pair[effort])


def _power(effort: Array, motion: Array) -> float:
    """Mean of a product over the product of the root mean squares, each without its mean."""
    a, b = known_rows(effort, motion)
    if not a.size or np.ptp(a) == 0.0 or np.ptp(b) == 0.0:
        return 0.0
    return float(np.corrcoef(a, b)[0, 1])


def _roughness(values: Array) -> float:
    """Root mean square of second differences, over the range."""
    (known,) = known_rows(values)
    moved = float(np.ptp(known))
    return (
        float(np.sqrt(np.mean(np.diff(known, 2) ** 2))) / moved if known.size > 2 and moved else 0.0
    )


def _share_of_levels(values: Array, switching: Array) -> float:
    """Share of the variance of a size that lies between the levels of a field."""
    size, levels = known_rows(np.abs(values), switching)
    means = np.empty_like(size)
    for level in np.unique(levels):
        at_level = levels == level
        means[at_level] = size[at_level].mean()
    whole = float(np.var(size))
    return float(np.var(means)) / whole if whole else 0.0


def _is_of_points(speeds: Array) -> bool:
    """Whether speeds were set one after another, or several times each: a table of points, no course of a motion."""
    steps = np.diff(speeds)
    if not steps.size or not np.isfinite(steps).all():
        return False
    levels = np.unique(speeds).size
    return bool(np.all(steps > 0.0) or np.all(steps < 0.0)) or 2 * levels <= speeds.size
