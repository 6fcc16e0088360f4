"""How quickly a log moves beside the logs of a fit: a model was never told of a motion that is much slower or quicker.

The pace of a log is the root mean square of the slip's rate over that of the slip. A sine has its angular frequency as
pace, so words give a pace in Hz.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from erclutch.fit.checks.finding import Finding
from erclutch.fit.log_groups import ALIKE, FEWEST_GROUPS, groups_of, motion_of
from erclutch.logs.dataset import Dataset
from erclutch.signals.array import Mask, rms

#: Of the slip of the training rows, root mean square: a log that moves less is at rest and has no pace.
_STILL = 0.01
#: Of the slip, by which the same number in all rows may differ.
_ROUNDING = 1e-9
#: Factor from which on a pace is another one where so few logs do not say how much that of one motion scatters.
_OF_FEW = 2.0
_REMEDY = "Add a log of such a motion to the fit"


def motion_held_out(data: Dataset, test: Mask) -> tuple[Finding, ...]:
    """What to know where logs that are held out whole move otherwise than those of the fit.

    Args:
        data: all rows.
        test: which are held out, shape (n,).
    """
    whole = np.zeros(data.rows, np.bool_)
    for start, stop in data.source_rows:
        whole[start:stop] = test[start:stop].all()
    if not whole.any():
        return ()
    seen = other_motion(data.take(~test), data.take(whole))
    return tuple(Finding("note", "motion", message, _REMEDY) for message in seen)


def two_motions(train: Dataset) -> tuple[Finding, ...]:
    """What to know of the band where the training logs have two motions: each is told by a fit to the other alone."""
    logs = sum(stop > start for start, stop in train.source_rows)
    if train.in_no_time or logs < 2 or len(set(groups_of(train).motion)) != 2:
        return ()
    seen = (
        f"by size and pace of the slip the {logs} training logs have two motions: of a third motion the prediction "
        "band holds less than it says"
    )
    return (Finding("note", "two motions", seen, "Log a motion of another size and pace"),)


def told(known: Dataset, data: Dataset) -> list[str]:
    """Whole sentences on logs that move otherwise than those of a fit; see `other_motion`."""
    return [f"{seen}. {_REMEDY}." for seen in other_motion(known, data)]


def other_motion(known: Dataset, data: Dataset) -> list[str]:
    """What to say of logs that move more slowly than each log of a fit, and of logs that move more quickly.

    Args:
        known: the training rows.
        data: logs of the same device.
    """
    if known.in_no_time or data.in_no_time:
        return []
    sizes = [rms(element.slip) for element in known.elements]
    groups = groups_of(known).rows
    of_fit = [_paces(known, start, stop, sizes) for start, stop in groups]
    another = ALIKE if len(of_fit) >= FEWEST_GROUPS else _OF_FEW
    # By log: its pace, and that of the slowest log of the fit.
    slower: dict[str, tuple[float, float]] = {}
    quicker: dict[str, tuple[float, float]] = {}
    for name, (start, stop) in zip(data.sources, data.source_rows, strict=True):
        own = _paces(data, start, stop, sizes)
        for element in own:
            paces = [of_log[element] for of_log in of_fit if element in of_log]
            if own[element] * another < min(paces, default=0.0):
                slower[name] = own[element], min(paces)
            if own[element] > another * max(paces, default=np.inf):
                quicker[name] = own[element], max(paces)
    seen: list[str] = []
    count = len(data.sources)
    if slower:
        seen.append(_seen(slower, "slowly", "slowest", of=count))
    if quicker:
        seen.append(_seen(quicker, "quickly", "quickest", of=count))
    return seen


def _paces(
    data: Dataset,
    start: int,
    stop: int,
    sizes: Sequence[float],
) -> dict[int, float]:
    """The pace of each element that moves over some rows, in rad/s; sizes are the slips of the fit."""
    paces: dict[int, float] = {}
    if stop - start < 2:
        return paces
    logarithms = motion_of(data, slice(start, stop))  # of slip and rate, by turns
    pairs = zip(sizes, logarithms[::2], logarithms[1::2], strict=True)
    for element, (size, of_slip, of_rate) in enumerate(pairs):
        slip = data.elements[element].slip[start:stop]
        changes = np.ptp(slip) > _ROUNDING * np.abs(slip).max()
        if changes and size > 0.0 and np.exp(of_slip) > _STILL * size:
            paces[element] = float(np.exp(of_rate - of_slip))
    return paces


def _seen(
    logs: dict[str, tuple[float, float]],
    way: str,
    end: str,
    of: int,
) -> str:
    """What is said of logs whose pace no log of the fit had."""

    def away(name: str) -> float:
        pace, limit = logs[name]
        return abs(np.log(pace / limit))

    furthest = max(logs, key=away)
    pace, limit = (value / (2.0 * np.pi) for value in logs[furthest])  # [Hz]
    those = (
        f"{furthest} moves"
        if len(logs) == 1
        else f"{len(logs)} of {of} logs, {furthest} the most, move"
    )
    return (
        f"{those} more {way} than every training log: the slip changes as a sine of {pace:.2g} Hz does, in the {end} "
        f"training log as a sine of {limit:.2g} Hz. No training row tells how far the models are off there"
    )
