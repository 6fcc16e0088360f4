"""The report of a comparison of runs is the same page, with runs in place of the models of one run."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from erclutch.fit.choice.scoring import BandedFigure
from erclutch.report.html.dynamics_section import DYNAMICS
from erclutch.report.html.picture_sections import PARITY, RESIDUAL
from erclutch.report.html.report_page import headings, page
from erclutch.report.html.section import Section
from erclutch.report.html.traces_section import TRACES
from erclutch.report.numbers.model_stages import APART, MODEL
from erclutch.report.numbers.number_text import Scale, count, number, percent_text, span
from erclutch.report.numbers.paired_runs import Contender, Pairing, apart, changes
from erclutch.report.numbers.run_material import Material, Role
from erclutch.report.plots.paper_style import placed
from erclutch.runs.run_folder import Run
from erclutch.runs.run_rows import RunRows
from erclutch.signals.array import Array

_LONG = 60  # characters of a setting in a sentence
_ROLES: tuple[Role, ...] = ("recommended", "best", "baseline")


def sentence(pairing: Pairing, scale: Scale) -> str:
    """What the comparison says, in a sentence or two."""
    first, *others = pairing.contenders
    words: list[str] = []
    for other in others:
        if other.more is None or other.share is None:
            continue
        more = other.more
        size = f"{scale.of(abs(more.value))} ({percent_text(abs(other.share.value), 2)})"
        if other.model == first.model:  # the table below names the model
            one = other.label
            base = first.label
        else:
            one = title_of(other)
            base = title_of(first)
        if more.low <= 0.0 <= more.high:
            words.append(
                f"{one} cannot be told from {base}: the difference of {size} may be chance"
            )
        else:
            way = "less" if more.value < 0.0 else "more"
            words.append(f"{one} errs by {size} {way} than {base}")
    return ". ".join(words) + "."


def what_changed(pairing: Pairing) -> str:
    """What the models of the runs differ in, so that a difference is credited to nothing else."""
    first, *others = pairing.contenders
    sentences: list[str] = []
    for other in others:
        differing = changes(first, other)
        if not differing:
            sentences.append(
                f"The model of {other.label} is made as that of {first.label}, from the same rows."
            )
            continue
        parts = [
            f"{change.what} ({_short(change.first)} there, {_short(change.other)} here)"
            for change in differing
        ]
        sentences.append(f"From {first.label} to {other.label} changed: {'; '.join(parts)}.")
        if len(differing) > 1:
            sentences.append("These runs do not tell what each of them does.")
    return " ".join(sentences)


def _short(text: str) -> str:
    return text if len(text) <= _LONG else f"{text[:_LONG]}…"


def title_of(contender: Contender) -> str:
    """Label of a run and the model that stands for it."""
    return f"{contender.label}: {contender.run.titles[contender.model]}"


def band(figure: BandedFigure | None, factor: float, unit: str = "") -> str:
    """A difference with its sign and band."""
    if figure is None:
        return ""
    sign = "+" if figure.value > 0 else ""
    unit = f" {unit}" if unit else ""
    return f"{sign}{number(figure.value * factor)}{unit} ({span(figure.low * factor, figure.high * factor)})"


@dataclass(frozen=True)
class _Joined(Material):
    """Runs with the same rows, as if each were a model of one run."""

    pairing: Pairing

    @cached_property
    def shown(self) -> dict[str, Role]:
        """The first three runs."""
        return {title_of(c): role for c, role in zip(self.pairing.contenders, _ROLES, strict=False)}


def joined(pairing: Pairing) -> _Joined:
    """The material of a comparison's pictures: the first run's rows, one model a run."""
    first = pairing.contenders[0]
    entries: list[dict[str, Any]] = []
    predicted: dict[str, Array] = {}
    for each in pairing.contenders:
        title = title_of(each)
        stands_for = {"name": title, "title": title, MODEL: each.model, APART: apart(each)}
        entries.append({**each.run.entry(each.model), **stands_for})
        predicted[title] = each.rows.predicted[each.model]
    title = title_of(first)
    body = {**first.run.body, "ranking": entries, "recommended": title, "best": title}
    return _Joined(
        run=Run(first.run.folder, body),
        rows=RunRows(first.rows.data, first.rows.test, predicted),
        pairing=pairing,
    )


def write_comparison(pairing: Pairing, path: Path) -> Path:
    """Write the report of a comparison as one HTML file, whole or not at all.

    Raises:
        RunError: the folder cannot be written.
    """
    material = joined(pairing)

    def verdict(material: Material) -> dict[str, Any]:
        """What differs, and whether that may be chance."""
        return {
            "pairing": pairing,
            "sentence": sentence(pairing, material.effort),
            "changed": what_changed(pairing),
            "most": max(c.figures.rmse.high for c in pairing.contenders) or 1.0,
            "title_of": title_of,
            "band": band,
        }

    sections = [Section("comparison", "Verdict", "Verdict", verdict)]
    if pairing.whole:
        sections += [TRACES, PARITY, RESIDUAL, DYNAMICS]
    heading = f"{len(pairing.contenders)} runs on {headings(material)[0]}"
    text = page(
        material,
        sections,
        heading,
        heading,
        f"{count(pairing.rows)} rows that all of them held out",
    )
    with placed(path) as unfinished:
        # Names may be no text.
        unfinished.write_text(text, encoding="utf-8", errors="backslashreplace")
    return path
