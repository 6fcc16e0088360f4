"""Logs that are unlike the others they are fitted with: by a unit, a sign, or the device that they are of."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from erclutch.fit.checks.effort_and_slip import logs_against_others
from erclutch.fit.checks.finding import Finding
from erclutch.logs.dataset import Dataset
from erclutch.logs.field_between_logs import CourseOfLog, efforts_of_two_devices
from erclutch.signals.array import Array, rms
from erclutch.signals.recording import NO_FIELD


class _Ordinary(NamedTuple):
    """How many times larger or smaller than the usual log's a signal of a log may be in one unit."""

    larger: float
    smaller: float


#: A weak motion makes a small effort and slip; currents of one device span more than its efforts do.
_ORDINARY = {
    "effort": _Ordinary(30.0, 300.0),
    "slip": _Ordinary(30.0, 300.0),
    "field": _Ordinary(300.0, 300.0),
}


def unlike_logs(data: Dataset) -> tuple[Finding, ...]:
    """What of several logs tells one from the others, for which nobody fits logs together."""
    if len(data.sources) < 2:
        return ()
    findings = (_another_unit(data) or _another_device(data), logs_against_others(data))
    return tuple(finding for finding in findings if finding is not None)


def _another_unit(data: Dataset) -> Finding | None:
    """Logs of which a signal is of another order: a unit taken for another."""
    first = data.elements[0]
    signals: dict[str, Array] = {"effort": data.effort, "slip": first.slip, "field": first.field}
    for name, values in signals.items():
        sizes = np.array([rms(values[a:b]) if b > a else np.nan for a, b in data.source_rows])
        # A log without rows has no size, and a log at no field says nothing of the field's unit.
        if name == "field":
            sizes[sizes == 0.0] = np.nan
        if not np.any(sizes > 0.0):
            continue
        usual = float(np.nanmedian(sizes))
        larger, smaller = _ORDINARY[name]
        odd = np.flatnonzero((sizes > larger * usual) | (sizes < usual / smaller))
        if odd.size and usual > 0.0:
            log = odd[0]
            message = f"the {name} of {data.sources[log]} is {sizes[log]:.3g}, that of the usual log {usual:.3g}"
            return Finding("warning", name, message, f"Check the unit of the {name}")
    return None


def _another_device(data: Dataset) -> Finding | None:
    """Logs of which one has much more effort at the same field and slip: they are of two devices, or one changed."""
    if data.device != "single":
        return None
    element = data.elements[0]
    logs: list[CourseOfLog] = []
    for name, (start, stop) in zip(data.sources, data.source_rows, strict=True):
        own = slice(start, stop)
        field = element.field[own]
        if field.size:
            logs.append(CourseOfLog(name, (), element.slip[own], data.effort[own], field))
    apart = efforts_of_two_devices(logs)
    if apart is None:
        return None
    more, less = logs[apart.more].name, logs[apart.less].name
    if any(
        note.startswith(NO_FIELD) for note in data.notes
    ):  # as was said, or it would be asked about
        message = (
            f"no field was given, and at the same slip {more} has {apart.times:.2g} times the effort of {less}: "
            "a field may tell them apart"
        )
        remedy = "Give the field of each log, such as by --name-pattern, or fit logs of one field together"
        return Finding("warning", "logs", message, remedy)
    message = (
        f"at the same field and slip {more} has {apart.times:.2g} times the effort of {less}: they are of two devices, "
        "or of one that changed"
    )
    return Finding("warning", "logs", message, "Fit the logs of each device on their own")
