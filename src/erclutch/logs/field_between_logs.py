"""Several logs without a field may be told apart by one that no column holds: at the same slip, one has more effort.

Logs with a field that differ so are of two devices, or of one that changed.
A lab writes a file a current, and the current into a name or a test plan. Read as logs at one field, they would be
mixed in a fit.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from erclutch.errors import UnloggedFieldError, listed, shell_word
from erclutch.logs.clock.time_stamps import BEGINS_ANEW
from erclutch.logs.columns.levels_in_names import open_field_in, stated_in
from erclutch.logs.columns.name_pattern import constants_of, pattern_among
from erclutch.logs.fields_beside_logs import fields_beside
from erclutch.logs.mapping import TO_FILL_IN
from erclutch.signals.array import Array
from erclutch.signals.clock import Span
from erclutch.signals.recording import NO_FIELD

#: The mapping file of a folder.
MAPPING = "erclutch.toml"
_BINS = 8  # of the size of the slip
_LEVELS = 16  # of the size of the field
_RESTS = 0.1  # of the largest slip: slower rows may stick
_FEWEST_ROWS = 5  # of a bin
_MOST_STRETCHES = 20  # more are no logs that were put into one file
_APART = 1.5  # times the effort: more than a warm fluid or another day makes
_RISES = 1.02  # times the effort from one number in the names to the next: more than noise makes
_RISES_OF_TWO = 1.1  # times the effort: by chance that of the larger of two numbers is larger, too


class CourseOfLog(NamedTuple):
    """The slip and the effort of a log, each (n,), its name and notes; its field and its stretches if they count."""

    name: str
    notes: Sequence[str]
    slip: Array
    effort: Array
    field: Array | None = None
    spans: Sequence[Span] = ()


class EffortsApart(NamedTuple):
    """Of several logs the two whose efforts at the same slip and field are furthest apart.

    Attributes:
        more, less: their places.
        times: how many times the effort of the one is that of the other.
    """

    more: int
    less: int
    times: float


def require_one_field(logs: Sequence[CourseOfLog]) -> None:
    """Ask for the field where logs that have none have much more effort, one than another, at the same slip.

    A little more is enough where the names tell a number that is called like a field, or that the effort rises with.
    Logs of which the user said that they have no field are not asked about. Stretches of a log are held against each
    other where its time begins anew, as where logs were put into one file.

    Raises:
        UnloggedFieldError: two such logs, or stretches.
    """
    without = [log for log in logs if any(note.startswith(f"{NO_FIELD}:") for note in log.notes)]
    for log in without:
        begins_anew = any(BEGINS_ANEW in note for note in log.notes)
        if not begins_anew or not 1 < len(log.spans) <= _MOST_STRETCHES:
            continue
        stretches: list[CourseOfLog] = []
        for span in log.spans:
            rows = slice(span.start, span.stop)
            stretches.append(log._replace(slip=log.slip[rows], effort=log.effort[rows]))
        more, less, times = _furthest_apart(_courses(stretches))
        if times > _APART:
            problem = (
                f"no field is logged, and at the same slip stretch {more + 1} has {times:.2g} times the effort of "
                f"stretch {less + 1}: a field that no column holds may tell them apart"
            )
            numbers = ", ".join(["NUMBER"] * len(log.spans))
            option = f"--constant {shell_word(f'field={numbers} A')}"
            remedy = f"Give the field of each stretch: {option}; else --field none"
            raise UnloggedFieldError(problem, where=log.name, remedy=remedy, option=option)
    if len(without) < 2:
        return
    courses = _courses(without)
    more, less, times = _furthest_apart(courses)
    names = [log.name for log in without]
    pattern = pattern_among(names)
    if times > _APART:
        problem = (
            f"no field is logged, and at the same slip {names[more]} has {times:.2g} times the effort of "
            f"{names[less]}: a field that no column holds may tell them apart"
        )
        raise _settled(pattern, names[more], names).error(problem)
    if pattern_among(names, called_so=True):
        problem = f"no field is logged, and the names tell one: {listed(names)}"
    else:
        numbers = [constants_of(pattern, name)["field"][0] for name in names] if pattern else []
        if not pattern or not _rises_with(np.array(numbers), courses[:, 0]):
            return
        problem = f"no field is logged, and the effort rises with the number in the names: {listed(names)}"
    raise _settled(pattern, names[0], names).error(problem)


def efforts_of_two_devices(logs: Sequence[CourseOfLog]) -> EffortsApart | None:
    """Two logs of which one has much more effort at the same field and slip; None where all are as of one device.

    The zero of a sensor makes one difference at all fields and slips, in either sense: another device does not.
    """
    apart = _furthest_apart(_courses(logs))
    if apart.times <= _APART:
        return None

    # The mean efforts of both in the cells of field and signed slip where both have enough rows.
    pair = (logs[apart.more], logs[apart.less])
    slips = np.concatenate([log.slip for log in pair])
    fields = np.concatenate([log.slip if log.field is None else log.field for log in pair])
    efforts = np.concatenate([log.effort for log in pair])
    along_slip = _numbered(slips, 2 * _BINS)
    along_field = _numbered(np.abs(fields), _LEVELS)
    cell = along_field * 2 * _BINS + along_slip
    cells = _LEVELS * 2 * _BINS
    of_first = np.arange(slips.size) < pair[0].slip.size
    rows: list[NDArray[np.intp]] = []
    means: list[Array] = []
    for own in (of_first, ~of_first):
        count = np.bincount(cell[own], minlength=cells)
        rows.append(count)
        means.append(np.bincount(cell[own], efforts[own], minlength=cells) / np.maximum(count, 1))
    shared = np.minimum(*rows) >= _FEWEST_ROWS
    more, less = means[0][shared], means[1][shared]

    off_mean = less - less.mean() if less.size else less
    variation = float(off_mean @ off_mean)
    steepness = float(off_mean @ more) / variation if variation > 0.0 else 0.0
    return apart if steepness > _APART else None


def efforts_of_two_words(
    slip: Array, effort: Array, of_row: NDArray[np.int32], least: float = _APART
) -> EffortsApart | None:
    """The two words of a column whose rows have the efforts furthest apart at the same slip; None where none are.

    Args:
        slip: of all rows, (n,), as the effort.
        effort: of all rows.
        of_row: the number of each row's word, (n,); -1 where it has none.
        least: how many times the effort of the one is to be that of the other.
    """
    known = np.isfinite(slip) & np.isfinite(effort)
    parts: list[CourseOfLog] = []
    for number in range(int(of_row.max(initial=-1)) + 1):
        own = known & (of_row == number)
        parts.append(CourseOfLog("", (), slip[own], effort[own]))
    if len(parts) < 2 or any(part.slip.size == 0 for part in parts):
        return None
    apart = _furthest_apart(_courses(parts))
    return apart if apart.times > least else None


def _numbered(values: Array, cells: int) -> NDArray[np.intp]:
    """The number of the cell of each value, of so many of one width from the smallest to the largest, shape (n,)."""
    low = float(values.min())
    width = (float(values.max()) - low) / cells or 1.0
    return np.minimum((values - low) / width, cells - 1).astype(np.intp)


def _courses(logs: Sequence[CourseOfLog]) -> Array:
    """Mean effort along the slip of each log, and its scatter, by the size of field and slip: (logs, 2, bins).

    Where a log has few rows stands no number.
    """
    largest_slip = max(float(np.abs(log.slip).max()) for log in logs)
    edges = np.linspace(_RESTS, 1.0, _BINS + 1) * largest_slip
    sizes = [np.abs(log.slip if log.field is None else log.field) for log in logs]
    largest_field = max(float(size.max()) for size in sizes)
    levels = 1 if logs[0].field is None else _LEVELS
    courses = np.full((len(logs), 2, levels * _BINS), np.nan)
    for number, (log, size) in enumerate(zip(logs, sizes, strict=True)):
        along = log.effort * np.sign(log.slip)  # without a load that does not turn with the slip
        bins = np.digitize(np.abs(log.slip), edges) - 1
        if levels > 1 and largest_field > 0.0:
            level = np.minimum((size / largest_field * levels).astype(int), levels - 1)
            bins = np.where((bins >= 0) & (bins < _BINS), level * _BINS + bins, -1)
        for place in np.unique(bins):
            inside = bins == place
            is_bin = 0 <= place < levels * _BINS
            if is_bin and np.count_nonzero(inside) >= _FEWEST_ROWS:
                courses[number, :, place] = along[inside].mean(), along[inside].std()
    return courses


def _furthest_apart(courses: Array) -> EffortsApart:
    """The two logs that are furthest apart, by what `_courses` gives."""
    apart = np.zeros((len(courses), len(courses)))
    for place, own in enumerate(courses):
        shared = np.isfinite(own[0]) & np.isfinite(courses[:, 0])
        of_own = np.where(shared, np.abs(own[0]), 0.0).sum(axis=1)
        of_others, scatter = np.where(shared[:, None], np.abs(courses), 0.0).sum(axis=2).T
        # What scatters more than it differs is no other course: a spring, an inertia, a load.
        known = (of_others > 0.0) & (of_own - of_others > scatter)
        apart[place, known] = of_own[known] / of_others[known]
    more, less = np.unravel_index(int(apart.argmax()), apart.shape)
    return EffortsApart(int(more), int(less), float(apart[more, less]))


def _rises_with(numbers: Array, courses: Array) -> bool:
    """Whether the effort at the same slip rises from each number in the names of logs to the next.

    Args:
        numbers: one a log, (logs,).
        courses: effort along the slip in bins of its size, shape (logs, bins).
    """
    levels = np.unique(numbers)
    rise = _RISES if levels.size > 2 else _RISES_OF_TWO
    of_levels = np.array([np.mean(courses[numbers == level], axis=0) for level in levels])
    for lower, higher in pairwise(of_levels):
        shared = np.isfinite(lower) & np.isfinite(higher)
        if not higher[shared].sum() > rise * max(lower[shared].sum(), 0.0):
            return False
    return True


class _Settled(NamedTuple):
    """What settles the field of some logs: the log that is asked about, the remedy, and the option that it gives."""

    where: str
    remedy: str
    option: str = ""

    def error(self, problem: str) -> UnloggedFieldError:
        """The question."""
        return UnloggedFieldError(problem, where=self.where, remedy=self.remedy, option=self.option)


def _settled(pattern: str, where: str, names: Sequence[str] = ()) -> _Settled:
    """What settles it, with a pattern of the logs' names where they tell the field.

    Args:
        pattern: of the names; "" where they tell no field.
        where: the log that is asked about.
        names: of all logs. Those of one file begin with its name, and a constant gives each of them its field.
    """
    files = {name.partition(": ")[0] for name in names if ": " in name}
    if len(files) == 1 and all(": " in name for name in names) and len(names) <= _MOST_STRETCHES:
        numbers = [
            f"{constants_of(pattern, name)['field'][0]:g}" if pattern else "NUMBER"
            for name in names
        ]
        unit = "" if pattern else " A"
        given = f"field={', '.join(numbers)}{unit}"
        option = f"--constant {shell_word(given)}"
        asked = f"Give the field of each recording: {option}"
        if pattern:
            asked = f"If the numbers in the names are the field, give {option}"
        return _Settled(where, f"{asked}; else --field none", option)
    if pattern:
        option = f"--name-pattern {shell_word(pattern)}"
        remedy = f"If the number in the names is the field, give {option}; else --field none"
        return _Settled(where, remedy, option)
    return _Settled(
        where,
        "Give the field by names of files or folders with --name-pattern, or in a mapping file beside each log "
        f'({where}.toml: constants.field = "0.5 A"); else --field none',
    )


def with_paths(error: UnloggedFieldError, paths: Sequence[Path]) -> UnloggedFieldError:
    """The same error, with what files and folders say: a plan beside the logs, a pattern of their names or folders.

    Where nothing says it, a mapping file is offered that names the logs.
    """
    stems = [path.resolve().with_suffix("") for path in paths]
    names = [stem.name for stem in stems]
    # ``log_1A``, ``1A/log``, ``1A/2Hz/log``.
    ways = (["/".join(stem.parts[-parts:]) for stem in stems] for parts in (1, 2, 3))
    pattern = next((found for way in ways if (found := pattern_among(way))), "")
    beside = fields_beside(paths)
    if error.option.startswith("--write-mapping"):
        return error  # which names the plan
    if beside is not None and not pattern_among(names, called_so=True):
        return _settled_by_a_plan(paths, error.where).error(f"{error.problem}; {beside}")
    if pattern:
        return _settled(pattern, error.where).error(error.problem)
    if len({path.parent for path in paths}) > 1 or len(paths) < 2:
        return error
    option = _option_of_a_plan(paths)
    remedy = (
        f"Give the field of each log in a mapping file: {option} names the logs; or by names of "
        "files with --name-pattern; else --field none"
    )
    return UnloggedFieldError(error.problem, where=error.where, remedy=remedy, option=option)


def require_no_plan(notes: Sequence[str], paths: Sequence[Path]) -> None:
    """Ask about the field that a file beside logs gives them, where none is logged and nobody said that there is none.

    Args:
        notes: of the logs.
        paths: their files.

    Raises:
        UnloggedFieldError: a file says different fields.
    """
    if len(paths) < 2 or not any(note.startswith(f"{NO_FIELD}:") for note in notes):
        return
    beside = fields_beside(paths)
    if beside is None or len({*beside.texts.values()}) < 2:
        return
    problem = f"no field is logged; {beside}"
    raise _settled_by_a_plan(paths, paths[0].name).error(problem)


def fields_in_unlike_names(paths: Sequence[Path]) -> UnloggedFieldError:
    """The question about fields that names of logs tell, where no pattern fits all of the names."""
    fields = {path.name: stated_in(path.name) for path in paths}
    said = [f"{name} says {each.number:g} {each.unit}" for name, each in fields.items() if each]
    said += [f"{path.name} says {text}" for path in paths if (text := open_field_in(path.name))]
    problem = f"no field is logged; of the names, for which there is no one pattern, {listed(said)}"
    return _settled_by_a_plan(paths, paths[0].name).error(problem)


def _settled_by_a_plan(paths: Sequence[Path], where: str) -> _Settled:
    """What settles the field that names or a file beside the logs tell."""
    option = _option_of_a_plan(paths)
    remedy = f"If that is the field, write it into a mapping file: {option}; else --field none"
    return _Settled(where, remedy, option)


def _option_of_a_plan(paths: Sequence[Path]) -> str:
    return f"--write-mapping {shell_word(str(paths[0].with_name(MAPPING)))}"


def mapping_of_fields(paths: Sequence[Path]) -> tuple[str, int]:
    """A mapping file that gives each log its field, and how many fields are left to fill in."""
    beside = fields_beside(paths)
    texts = {path.name: TO_FILL_IN for path in paths}
    for path in paths:
        stated = stated_in(path.name)
        if stated is not None:
            texts[path.name] = f"{stated.number:g} {stated.unit}"
    by_names = len({*texts.values()}) > 1
    texts |= beside.texts if beside else {}
    source = 'by its name, or such as "0.5 A"' if by_names else 'such as "0.5 A"'
    source = f"by {beside.file}" if beside else source
    lines = [f"# The field of each log, {source}.", "[fields]"]
    lines += [f"{json.dumps(name)} = {json.dumps(text)}" for name, text in texts.items()]
    return "\n".join([*lines, ""]), [*texts.values()].count(TO_FILL_IN)
