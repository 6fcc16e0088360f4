"""Rows of the digital twin, made once a run and read by every contender."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from erclutch.fit.networks.fit_network import scaling_of
from erclutch.logs.dataset import Dataset
from erclutch.models.networks import network_from_name
from erclutch.models.networks.network_inputs import inputs_of
from erclutch.models.networks.network_model import Scaling
from erclutch.signals.clock import Clock, Span
from erclutch.signals.device import Element, Units
from erclutch.wings.paper.tables import twin_runs

Array = NDArray[np.float64]

NETWORK = "fnn-16"
HIDDEN = 16
SPLITS = ("training", "test")


@dataclass(frozen=True)
class Split:
    """Training or test rows.

    Attributes:
        data: as erclutch takes them.
        x: inputs of the network within -1 and 1, one row a sample, shape (n, 3).
        y: effort of order one, shape (n,).
    """

    data: Dataset
    x: Array
    y: Array


def save(path: Path, seconds: float, seed: int) -> None:
    """Make training and test rows with the twin and write them."""
    runs = twin_runs(SPLITS, seed=seed, seconds=seconds)
    np.savez(
        path,
        **{f"{name}/{key}": value for name in SPLITS for key, value in _tables(runs[name]).items()},
    )


def load(path: Path) -> tuple[Split, Split, Scaling]:
    """Training rows, test rows, and the normalisation that both share."""
    with np.load(path) as stored:
        train, test = (
            _dataset({key: stored[f"{name}/{key}"] for key in _KEYS}, name) for name in SPLITS
        )
    scaling = scaling_of(_inputs(train), train.effort, "fnn")
    return _split(train, scaling), _split(test, scaling), scaling


_KEYS = ("field", "slip", "effort", "time", "spans", "units")


def _tables(data: Dataset) -> dict[str, Any]:
    spans = [(s.start, s.stop, np.nan if s.period is None else s.period) for s in data.clock.spans]
    return {
        "field": np.array([e.field for e in data.elements]),
        "slip": np.array([e.slip for e in data.elements]),
        "effort": data.effort,
        "time": data.clock.time,
        "spans": np.array(spans),
        "units": np.array([data.units.effort, data.units.field, data.units.slip]),
    }


def _dataset(tables: dict[str, Any], name: str) -> Dataset:
    elements = tuple(Element(f, s) for f, s in zip(tables["field"], tables["slip"], strict=True))
    spans = tuple(
        Span(int(a), int(b), None if np.isnan(p) else float(p)) for a, b, p in tables["spans"]
    )
    units = Units(*(str(unit) for unit in tables["units"]))
    return Dataset(
        "coaxial",
        elements,
        tables["effort"],
        Clock(tables["time"], spans),
        units,
        (f"twin {name}",),
    )


def _inputs(data: Dataset) -> Array:
    return inputs_of(network_from_name(NETWORK), data.elements, data.clock, {}, {})


def _split(data: Dataset, scaling: Scaling) -> Split:
    x = np.ascontiguousarray(scaling.inputs(_inputs(data)).T)
    return Split(data, x, (data.effort - scaling.effort_offset) / scaling.effort_scale)
