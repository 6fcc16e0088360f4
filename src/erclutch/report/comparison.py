"""The report of a comparison of runs: the same page, with the runs in place of the models of one."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, ClassVar

from erclutch.diagnostics.material import BADGE_MEANS, Material
from erclutch.diagnostics.paired import Contender, Pairing
from erclutch.diagnostics.shown import Role, Shown
from erclutch.diagnostics.text import Scale, count, number, percent, span
from erclutch.evaluate import Figure
from erclutch.figures.style import write_whole
from erclutch.report.dynamics import DynamicsSection
from erclutch.report.page import headings, page
from erclutch.report.parity import ParitySection
from erclutch.report.residual import ResidualSection
from erclutch.report.section import Section
from erclutch.report.traces import Traces
from erclutch.run_rows import RunRows
from erclutch.runs import Run

_ROLES: tuple[Role, ...] = ("recommended", "best", "baseline")


def sentence(found: Pairing, scale: Scale) -> str:
    """What the comparison says, in a sentence or two."""
    first, others = found.contenders[0], found.contenders[1:]
    words: list[str] = []
    for other in others:
        more, share = other.more, other.share
        if more is None or share is None:
            continue
        size = f"{scale.of(abs(more.value))} ({percent(abs(share.value), 2)})"
        if more.low <= 0.0 <= more.high:
            words.append(
                f"{title_of(other)} cannot be told from {title_of(first)}: the difference of {size} may be chance"
            )
        elif more.value < 0.0:
            words.append(f"{title_of(other)} errs by {size} less than {title_of(first)}")
        else:
            words.append(f"{title_of(other)} errs by {size} more than {title_of(first)}")
    return ". ".join(words) + "."


def title_of(contender: Contender) -> str:
    """Label of a run and the model that stands for it."""
    return f"{contender.label}: {contender.model}"


def band(figure: Figure | None, factor: float, unit: str = "") -> str:
    """A difference with its sign and band."""
    if figure is None:
        return ""
    sign = "+" if figure.value > 0 else ""
    unit = f" {unit}" if unit else ""
    return f"{sign}{number(figure.value * factor)}{unit} ({span(figure.low * factor, figure.high * factor)})"


@dataclass(frozen=True)
class _Joined(Material):
    """Runs with the same rows, as if each were a model of one run."""

    found: Pairing

    @cached_property
    def shown(self) -> tuple[Shown, ...]:
        """The first three runs."""
        return tuple(Shown(title_of(c), r) for c, r in zip(self.found.contenders, _ROLES, strict=False))


def joined(found: Pairing) -> _Joined:
    """The material of a comparison's pictures: the first run's rows, one model a run."""
    first = found.contenders[0]
    entries = [{**c.run.entry(c.model), "name": title_of(c)} for c in found.contenders]
    body = {**first.run.body, "ranking": entries, "recommended": entries[0]["name"], "best": entries[0]["name"]}
    predicted = {title_of(c): c.rows.predicted[c.model] for c in found.contenders}
    return _Joined(Run(first.run.folder, body), RunRows(first.rows.data, first.rows.test, predicted), found)


class ComparisonVerdict(Section):
    """What differs, and whether that may be chance."""

    name: ClassVar[str] = "comparison"
    title: ClassVar[str] = "Verdict"
    short: ClassVar[str] = "Verdict"

    def __init__(self, found: Pairing) -> None:
        self.found = found

    def fill(self, material: Material) -> dict[str, Any]:
        """See `Section.fill`."""
        found, scale = self.found, material.effort
        most = max(c.figures.rmse.high for c in found.contenders) or 1.0
        roles = {s.name: s.role for s in material.shown}
        return {
            "sentence": sentence(found, scale),
            "rows": count(found.rows),
            "block": count(found.block),
            "unit": scale.unit,
            "first": found.contenders[0].label,
            "runs": [
                {
                    "label": c.label,
                    "model": c.model,
                    "role": roles.get(title_of(c), ""),
                    "bar": {
                        k: min(100.0 * v / most, 100.0)
                        for k, v in zip(("value", "low", "high"), c.figures.rmse.to_list(), strict=True)
                    },
                    "rmse": scale.bare(c.figures.rmse.value),
                    "band": scale.band(c.figures.rmse.to_list()),
                    "share": percent(c.figures.share.value),
                    "more": band(c.more, scale.factor),
                    "relative": band(c.share, 100.0, "%"),
                    "parameters": c.run.entry(c.model)["parameters_count"],
                }
                for c in found.contenders
            ],
            "differing": found.differing,
            "labels": [c.label for c in found.contenders],
            "same": [
                {
                    "name": s.name,
                    "label": s.label,
                    "first": scale.bare(s.first),
                    "other": scale.bare(s.other),
                    "share": band(s.share, 100.0, "%"),
                }
                for s in found.same
            ],
            "whole": found.whole,
        }


def write_comparison(found: Pairing, path: Path) -> Path:
    """Write the report of a comparison as one HTML file, whole or not at all.

    Raises:
        RunError: the folder cannot be written.
    """
    material = joined(found)
    sections: list[Section] = [ComparisonVerdict(found)]
    if found.whole:
        sections += [Traces(), ParitySection(), ResidualSection(), DynamicsSection()]
    filled = [(s, s.fill(material)) for s in sections]
    heading = f"{len(found.contenders)} runs on {headings(material)[0]}"
    text = page(
        title=heading,
        heading=heading,
        line=f"{count(found.rows)} rows that all of them held out",
        badge=material.badge,
        badge_means=BADGE_MEANS.get(material.badge, "Made by a computer, not a measurement."),
        sections=[(s, values) for s, values in filled if values is not None],
        legend=[{"name": s.name, "role": s.role} for s in material.shown],
        word=material.word,
    )
    return write_whole(path, lambda partial: partial.write_text(text, encoding="utf-8"))
