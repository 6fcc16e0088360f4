"""The file of a model with plug-ins holds some of its efforts: another version of a plug-in may compute others."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from erclutch.errors import RunError
from erclutch.models.model import Model
from erclutch.signals.array import Array
from erclutch.signals.clock import Clock, Span
from erclutch.signals.device import WAYS_OF, Element

#: The file's entry.
ENTRY = "efforts"
_ROWS = 24
_KEPT = 3  # one row in so many
_PERIOD = 1e-3  # s, of a model without a memory
#: Of the largest effort; another machine rounds otherwise.
_SAME = 1e-9


def efforts_of(model: Model) -> list[float]:
    """Efforts of a short course through the training range: the field is switched, the slip goes there and back."""
    ranges = model.trained_on
    period = model.period or _PERIOD
    share = np.arange(_ROWS) / (_ROWS - 1)
    field = np.where(np.arange(_ROWS) % 8 < 5, ranges.field[1], ranges.field[0])
    slip = np.interp(np.sin(2.0 * np.pi * share), (-1.0, 1.0), ranges.slip)
    elements = [Element(field, slip), Element(field[::-1], -slip)]
    count = len(WAYS_OF[model.structure.device])
    extras: dict[str, Array] = {}
    for name, covered in model.extras.items():
        extras[name] = np.full(_ROWS, np.mean(covered), np.float64)
    time = np.asarray(period * np.arange(_ROWS), np.float64)
    clock = Clock(time, (Span(0, _ROWS, period),))
    effort = model.effort(elements[:count], clock, extras)
    return effort[::_KEPT].tolist()


def require_same_efforts(body: Mapping[str, Any], taken: Mapping[str, Any], where: str) -> None:
    """That the plug-ins of a model give the efforts that they gave when its file was written.

    Args:
        body: of the file.
        taken: what the model that was read writes of itself.
        where: the file.

    Raises:
        RunError: they give others.
    """
    if ENTRY not in body or ENTRY not in taken:
        return
    kept, now = np.asarray(body[ENTRY], np.float64), np.asarray(taken[ENTRY])
    least = _SAME * np.max(np.abs(kept), initial=0.0)
    if kept.shape == now.shape and np.all(np.abs(now - kept) <= least):
        return
    packages = {f"{plugin['package']} {plugin['version']}" for plugin in body["plugins"]}
    named = " and ".join(sorted(packages))
    problem = (
        f"the plug-ins of this model compute other efforts than when it was fitted, with {named}"
    )
    raise RunError(problem, where=where, remedy="Install these versions, or fit again")
