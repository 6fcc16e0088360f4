"""Logs on the terminal: columns, signals, segments between gaps, what they cover, of which kinds they are."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from erclutch.cli import terminal
from erclutch.errors import UnloggedFieldError, plural

if TYPE_CHECKING:
    from rich.table import Table as RichTable

    from erclutch.cli.log_look import LogLook
    from erclutch.cli.options import LogOptions
    from erclutch.logs import Plan, Table
    from erclutch.logs.dataset import Dataset
    from erclutch.logs.plan import Joint
    from erclutch.signals.array import Array
    from erclutch.signals.recording import Recording

_MOST_SEGMENTS = 12  # rows of the table
_LEAST_MEAN = 1e-12  # of the largest value: below it a mean is what is left of a sum
_PAUSE = 1.5  # medians of a clock's steps
_FEW_PAUSES = 0.1  # of all steps; more is no pause but the way in which the column counts


class Figures(NamedTuple):
    """Smallest, largest and mean of a column's finite values, NaN where it has none, and how many are missing."""

    min: float
    max: float
    mean: float
    missing: float


def figures(values: Array) -> Figures:
    """Figures of a column or a signal."""
    import numpy as np

    finite = values[np.isfinite(values)]
    missing = values.size - finite.size
    if not finite.size:
        finite = np.array([np.nan])
    low = float(finite.min())
    high = float(finite.max())
    with np.errstate(over="ignore"):
        mean = float(finite.mean())
    if np.isinf(mean):  # their sum is beyond what a float holds
        mean = float((finite / finite.size).sum())
    if abs(mean) < _LEAST_MEAN * max(abs(low), abs(high)):
        mean = 0.0
    return Figures(low, high, mean, float(missing))


def tell_columns(log: Path, raw: Table) -> None:
    """Columns of a file as they are, and what is known of the whole file."""
    import numpy as np

    terminal.tell(f"{log.name}: {raw.rows:,} {plural(raw.rows, 'row')}, {len(raw.columns)} columns")
    rows: list[list[str]] = []
    for name, values in raw.columns.items():
        numbers = [terminal.number(figure) for figure in figures(values)]
        rows.append([name, raw.units.get(name) or "-", *numbers])
    headings = ["name", "unit", "smallest", "largest", "mean", "missing"]
    terminal.tell(terminal.table("Columns", headings, rows, left=2))
    terminal.tell(f"  damage to the file is {raw.damage}")
    if raw.clock is not None:
        # Pauses say how many stretches the log has.
        steps = np.diff(raw.clock)  # [s]
        pauses = 0
        if steps.size:
            usual = np.median(steps)
            pauses = int(np.count_nonzero(steps > _PAUSE * usual))
        many = ""
        if 0 < pauses <= _FEW_PAUSES * steps.size:
            many = f", {pauses} pause{'s' if pauses > 1 else ''}"
        seconds = raw.clock[-1] - raw.clock[0]
        terminal.tell(f"  column {raw.clock_name} holds dates and times over {seconds:.4g} s{many}")


def several(recordings: Sequence[Recording]) -> RichTable:
    """Several logs, a row each; the signals that follow are those of the first.

    A heading has the unit of the first log. Where another log has another unit, its cell says so.
    """
    first = recordings[0]
    names = [name for name in first.signals if not name.startswith(("input:", "spare column"))]
    headings = [terminal.with_unit(name, first.units[name]) for name in names]
    endings = {Path(recording.name).suffix for recording in recordings}
    # What all names end in tells none apart.
    shared_ending = endings.pop() if len(endings) == 1 else ""
    rows: list[list[str]] = []
    for recording in recordings:
        ranges: list[str] = []
        for name in names:
            values = recording.signals.get(name)
            if values is None:
                ranges.append("")
                continue
            unit = recording.units[name]
            own_unit = "" if unit == first.units[name] else terminal.with_unit("", unit or "1")
            ranges.append(f"{_range(values)}{own_unit}")
        rows.append([recording.name.removesuffix(shared_ending), f"{recording.rows:,}", *ranges])
    title = f"{len(recordings)} logs; columns and signals are shown of the first"
    return terminal.table(title, ["", "rows", *headings], rows, left=1)


def tell_signals(recording: Recording, data: Dataset) -> None:
    """What was decided while a log was read, its signals, and its segments where it has gaps."""
    terminal.tell("\n".join(terminal.recording_lines([recording], 50, data.notes)))
    signals = [(name, recording.units[name], values) for name, values in recording.signals.items()]
    if "position" in recording.signals and "slip" not in recording.signals:
        signals.append(("slip (derived)", data.units.slip, data.elements[0].slip))
    rows: list[list[str]] = []
    for name, unit, values in signals:
        low, high, mean, _ = figures(values)
        numbers = [terminal.number(figure) for figure in (low, high, mean)]
        rows.append([name, unit or "1", *numbers])
    headings = ["name", "unit", "smallest", "largest", "mean"]
    terminal.tell(terminal.table("Signals", headings, rows, left=2))
    if len(recording.segments) > 1:
        import numpy as np

        spans = data.clock.spans
        rows: list[list[str]] = []
        for number, span in enumerate(spans[:_MOST_SEGMENTS], start=1):
            count = span.stop - span.start
            begin = terminal.number(float(data.clock.time[span.start]), 5)
            end = terminal.number(float(data.clock.time[span.stop - 1]), 5)
            of_elements = [element.field[span.start : span.stop] for element in data.elements]
            fields = np.concatenate(of_elements)
            rows.append([str(number), f"{count:,}", begin, end, _range(fields)])
        title = "Segments between gaps"
        if len(spans) > _MOST_SEGMENTS:
            title += f", the first {_MOST_SEGMENTS} of {len(spans)}"
        field = terminal.with_unit("field", data.units.field)
        segments = terminal.table(title, ["", "rows", "from [s]", "to [s]", field], rows)
        terminal.tell(segments)


def tell_joints(joints: Mapping[Joint, Plan], raw: Table) -> None:
    """The columns of each joint of a log, and how far its speed and effort reach."""
    rows: list[list[str]] = []
    for joint, plan in joints.items():
        cells = [joint.name]
        for signal in ("slip", "effort"):
            chosen = plan.signal(signal)
            assert chosen is not None  # the mapping of a joint names both
            reach = _range(chosen.factor * raw.columns[chosen.column])
            unit = "" if chosen.si == "?" else f" {chosen.si}"
            cells += [chosen.column, f"{reach}{unit}"]
        position = plan.signal("position")
        rows.append([*cells, "" if position is None else position.column])
    headings = ["joint", "slip", "", "effort", "", "position"]
    title = f"{len(joints)} joints, each a device of its own"
    terminal.tell(terminal.table(title, headings, rows, left=6))


def _range(values: Array) -> str:
    """Smallest and largest value; of a constant that value alone."""
    low, high, _, _ = figures(values)
    smallest = terminal.number(low)
    largest = terminal.number(high)
    return smallest if smallest == largest else f"{smallest} .. {largest}"


def tell_coverage(data: Dataset) -> None:
    """Where all logs have rows, and what is odd in them."""
    units = (data.units.field, data.units.slip)
    for number, element in enumerate(data.elements, start=1):
        of_element = f" of CH{number}" if len(data.elements) > 1 else ""
        terminal.tell(terminal.coverage(element.field, element.slip, of_element, units))
    terminal.tell(*findings(data), style="yellow")


def findings(data: Dataset) -> list[str]:
    """What is odd in a log, each with its level."""
    from erclutch.fit.checks.sensor_check import sensor_findings
    from erclutch.fit.checks.unlike_logs import unlike_logs
    from erclutch.fit.history import effort_finding

    odd = list(sensor_findings(data))
    of_effort = effort_finding(data)
    odd += [of_effort] if of_effort is not None else []
    odd += unlike_logs(data)
    return [f"{finding.level}: {finding}" for finding in odd]


def tell_kinds(look: LogLook, reading: LogOptions) -> bool:
    """Say of which kinds the logs are; where they make no one fit, a command for each, and then all was said.

    Args:
        look: what was found.
        reading: how the user said that they are read.
    """
    from erclutch.logs.columns.rheometer_names import tells_a_flow_curve

    kinds = look.kinds
    terminal.say(f"{len(kinds)} kinds of logs, by their columns: {'; '.join(map(str, kinds))}")
    is_of_a_rheometer = any(tells_a_flow_curve(kind.plan.labels) for kind in kinds)
    if not look.doubtful or is_of_a_rheometer or isinstance(look.problem, UnloggedFieldError):
        return False
    # Something else may stand against one of them, such as a damaged file.
    of_kinds = {path for kind in kinds for path in kind.paths}
    for name, refusal in look.refused.items():
        if look.paths.get(name) not in of_kinds:
            terminal.say(f"Not understood yet: {refusal.told_of(name)}")
    for kind in sorted(kinds, key=lambda kind: not kind.is_sure):
        log = kind.paths[0].name
        if kind.is_sure:
            terminal.say(f"Understood on their own, those as {log}: {kind.command(reading)}")
            continue
        asked = [question.short for question in kind.plan.questions]
        terminal.say(f"Not understood yet: {log}: {'; '.join([*asked, *kind.plan.doubts])}")
        terminal.say(f"What settles it: {kind.command(reading)}")
    return True
