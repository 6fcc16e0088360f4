"""Logs of a coaxial pair and of a single clutch, SYNTHETIC, as recordings and as rows to fit."""

from __future__ import annotations

from functools import cache

from erclutch.logs import recording_from_arrays
from erclutch.logs.dataset import Dataset, build_dataset
from erclutch.logs.synthetic import LABEL, synthetic_log, synthetic_pair
from erclutch.signals.recording import Recording


def pair_log(seconds: float, seed: int = 0) -> Recording:
    """Signals of two clutches on one output at 1 kHz: E1, E2, theta_dot, alpha_dot, T."""
    columns = synthetic_pair(seconds, seed)
    signals = {name: values for name, (_, values) in columns.items() if name != "time"}
    units = {name: unit for name, (unit, _) in columns.items() if name != "time"}
    return recording_from_arrays(
        signals, units, time=columns["time"][1], name=LABEL, device="coaxial"
    )


def single_log(seconds: float, seed: int = 0) -> Recording:
    """Signals of one clutch at 1 kHz: field, slip, effort."""
    columns = synthetic_log(seconds, seed)
    signals = {name: columns[column][1] for name, column in SINGLE.items()}
    units = {name: columns[column][0] for name, column in SINGLE.items()}
    return recording_from_arrays(signals, units, time=columns["time"][1], name=LABEL)


SINGLE = {"field": "field", "slip": "slip", "effort": "torque"}


@cache
def pair_rows(seconds: float, seed: int = 0) -> Dataset:
    """The pair's log as rows of a fit; no test changes it."""
    return build_dataset(pair_log(seconds, seed), device="coaxial")
