"""What sections and figures of a report are made from: a run, its rows, and how its numbers are shown."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from erclutch.diagnostics.correlation import period_of
from erclutch.diagnostics.shown import Shown, shown_models
from erclutch.diagnostics.text import Scale, effort_word, scale_for
from erclutch.diagnostics.windows import Windows, windows
from erclutch.run_rows import RunRows, read_rows
from erclutch.runs import Run
from erclutch.saved import Model


def badge_of(body: Mapping[str, Any]) -> str:
    """TWIN, SYNTHETIC, RECORDING, or MIXED where logs of several origins went in."""
    origins = {str(log["origin"]) for log in body["logs"]}
    if len(origins) > 1:
        return "MIXED"
    return origins.pop() or "RECORDING"


BADGE_MEANS = {
    "TWIN": "Data of a digital twin: made by a computer, not a measurement.",
    "SYNTHETIC": "Made-up data for trying things out: not a measurement.",
    "RECORDING": "Measured data, as far as the log tells.",
    "MIXED": "Logs of different origins: measured and made by a computer.",
}


@dataclass(frozen=True)
class Material:
    """A run that is being reported.

    Attributes:
        run: the run.
        rows: its rows.
    """

    run: Run
    rows: RunRows

    @property
    def body(self) -> Mapping[str, Any]:
        """run.json."""
        return self.run.body

    @property
    def recommended(self) -> str:
        """Name of the recommended model."""
        return str(self.body["recommended"])

    @cached_property
    def shown(self) -> tuple[Shown, ...]:
        """Models in the pictures."""
        return shown_models(self.body)

    @cached_property
    def shown_names(self) -> tuple[str, ...]:
        """Their names."""
        return tuple(s.name for s in self.shown)

    @cached_property
    def badge(self) -> str:
        """Where the data come from, in a word."""
        return badge_of(self.body)

    @property
    def word(self) -> str:
        """What the effort is: torque, force."""
        return effort_word(self.body["units"]["effort"])

    @cached_property
    def effort(self) -> Scale:
        """How efforts and their errors are shown."""
        return scale_for(self.body["units"]["effort"], float(np.std(self.rows.data.effort)))

    @cached_property
    def field(self) -> Scale:
        """How fields are shown."""
        return scale_for(
            self.body["units"]["field"], max(float(np.abs(e.field).max()) for e in self.rows.data.elements)
        )

    @cached_property
    def slip(self) -> Scale:
        """How slips are shown."""
        return scale_for(self.body["units"]["slip"], max(float(np.std(e.slip)) for e in self.rows.data.elements))

    @cached_property
    def period(self) -> float:
        """Sampling period in s."""
        return period_of(self.rows)

    @cached_property
    def windows(self) -> Windows:
        """Sections of the log worth a close look."""
        return windows(self.rows, self.recommended)

    @cached_property
    def models(self) -> Mapping[str, Model]:
        """All models of the run, read from their files."""
        return {name: self.run.model(name) for name in self.run.names}

    def element_name(self, element: int) -> str:
        """CH1 and CH2 for a pair; empty for a single device."""
        return f"CH{element + 1}" if len(self.rows.data.elements) > 1 else ""


def material_of(run: Run) -> Material:
    """All that is needed of a run.

    Raises:
        RunError: a file of the run is missing or was changed.
    """
    made = Material(run, read_rows(run))
    run.file("table.csv")
    _ = made.models
    return made
