"""Columns of the log that would take error off the best law, if they were inputs of it: the user is told which."""

from __future__ import annotations

from collections.abc import Mapping

from erclutch.fit.checks.finding import Finding
from erclutch.logs.dataset import Dataset
from erclutch.logs.planning.further_columns import option_for_input
from erclutch.signals.percent import percent
from erclutch.signals.recording import TEMPERATURE

#: Share of the error from which a column gets a note of its own; those that take less off share a note.
_MUCH = 0.1


def spare_columns(train: Dataset, gains: Mapping[str, float]) -> list[Finding]:
    """A note on each column that would take much off the error, and a note on the others together.

    Args:
        train: the training rows.
        gains: share of the error that each column would take off, by its name, the largest first.
    """
    findings: list[Finding] = []
    much = [name for name, gain in gains.items() if gain >= _MUCH]
    little = [name for name in gains if name not in much]
    # A single column reads better with its figure than as a list.
    if len(little) == 1:
        much, little = [*much, *little], []
    for name in much:
        seen = (
            f"the column {name!r}, which no model has as an input, would take {percent(gains[name])} off the error of "
            "the best law"
        )
        remedy = f"Fit with {_option(train, name)}, unless it measures the effort once more"
        findings.append(Finding("note", "spare column", seen, remedy))
    if little:
        each = ", ".join(f"{name!r} {percent(gains[name])}" for name in little)
        seen = f"columns that no model has as an input would each take a little off the error of the best law: {each}"
        remedy = f"If that is worth an input, fit with {_option(train, little[0])}, say"
        findings.append(Finding("note", "spare column", seen, remedy))
    return findings


def _option(train: Dataset, name: str) -> str:
    """The option that makes a column an input."""
    # A log has one temperature.
    unit = None if TEMPERATURE in train.extras else train.extra_units.get(name)
    return option_for_input(name, unit)
