"""Each log says where its rows come from: measured, or made by a computer, as TWIN and SYNTHETIC data are."""

from __future__ import annotations

from collections.abc import Iterable

#: Origins of a log that was measured; all others were made by a computer.
MEASURED = frozenset({"", "RECORDING", "HARDWARE"})
RECORDING = "RECORDING"
MIXED = "MIXED"


def badge_of(origins: Iterable[str]) -> str:
    """The word for the data of some logs: RECORDING, TWIN, ...; MIXED where they come from several."""
    different = {RECORDING if origin in MEASURED else origin for origin in origins}
    if len(different) > 1:
        return MIXED
    return next(iter(different), RECORDING)
