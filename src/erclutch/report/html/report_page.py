"""A page from sections: one HTML file that needs nothing else and asks nobody for anything."""

from __future__ import annotations

import base64
import hashlib
import json
from collections.abc import Sequence
from importlib import import_module
from importlib.resources import files
from pathlib import Path
from typing import Any

from markupsafe import Markup

from erclutch.diagnostics.material import BADGE_MEANS, Material
from erclutch.diagnostics.text import count, number
from erclutch.figures.style import write_whole
from erclutch.report.dynamics import DynamicsSection
from erclutch.report.error_map import ErrorMaps
from erclutch.report.flow_curves import FlowSection
from erclutch.report.parameters import ParametersSection
from erclutch.report.parity import ParitySection
from erclutch.report.provenance import Provenance
from erclutch.report.ranking import Ranking
from erclutch.report.residual import ResidualSection
from erclutch.report.section import Section
from erclutch.report.symbols import safe_json
from erclutch.report.traces import Traces
from erclutch.report.verdict import Verdict

#: Sections in the order of the page.
SECTIONS: tuple[type[Section], ...] = (
    Verdict,
    Ranking,
    Traces,
    ErrorMaps,
    ParitySection,
    ResidualSection,
    FlowSection,
    DynamicsSection,
    ParametersSection,
    Provenance,
)


def report_html(material: Material) -> str:
    """The report of a run as one HTML document."""
    filled = [(s, s.fill(material)) for s in (kind() for kind in SECTIONS)]
    heading, line = headings(material)
    return page(
        title=f"{material.recommended}: {heading}",
        heading=heading,
        line=line,
        badge=material.badge,
        badge_means=BADGE_MEANS.get(material.badge, "Made by a computer, not a measurement."),
        sections=[(s, values) for s, values in filled if values is not None],
        legend=[{"name": s.name, "role": s.role} for s in material.shown],
        word=material.word,
    )


def headings(material: Material) -> tuple[str, str]:
    """What was measured, and a line about it."""
    return _logs(material), _line(material)


def write_report(material: Material, path: Path) -> Path:
    """Write the report of a run as one HTML file, whole or not at all.

    Raises:
        RunError: the folder cannot be written.
    """
    text = report_html(material)
    return write_whole(path, lambda partial: partial.write_text(text, encoding="utf-8"))


def _logs(material: Material) -> str:
    names = [str(log["name"]) for log in material.body["logs"]]
    return names[0] if len(names) == 1 else f"{names[0]} and {len(names) - 1} more log{'s' if len(names) > 2 else ''}"


def _line(material: Material) -> str:
    body = material.body
    device = "a coaxial pair of clutches" if body["device"] == "coaxial" else "a single clutch, brake or damper"
    rows = sum(int(log["rows"]) for log in body["logs"])
    seconds = sum(int(log["rows"]) * float(log["period_s"]) for log in body["logs"])
    rates = sorted({float(f"{1.0 / log['period_s']:.4g}") for log in body["logs"]})
    names = [f"{rate:g}" for rate in rates]
    at = " and ".join(names) if len(names) <= 2 else f"{names[0]} to {names[-1]}"
    return f"{_capital(device)}, {count(rows)} rows, {number(seconds)} s at {at} Hz"


def _capital(text: str) -> str:
    return text[:1].upper() + text[1:]


def page(
    *,
    title: str,
    heading: str,
    line: str,
    badge: str,
    badge_means: str,
    sections: Sequence[tuple[Section, dict[str, Any]]],
    legend: Sequence[dict[str, str]],
    word: str,
) -> str:
    """Sections as one HTML document.

    Args:
        title: of the window.
        heading: of the page; what was measured.
        line: under the heading.
        badge: where the data come from, in a word, and what that means.
        badge_means: see badge.
        sections: with the values of their templates.
        legend: models in the pictures, with their roles.
        word: torque, force.
    """
    environment = _environment()
    data = {section.name: values["data"] for section, values in sections if "data" in values}
    grids: list[Any] = [grid for _, values in sections for grid in values.get("grids", [])]
    bodies = [_body(environment, section, {"legend": legend, "word": word, **values}) for section, values in sections]
    scripts = [_asset("vendor/uplot/uPlot.iife.min.js")] if data else []
    scripts.append(_asset("report/assets/report.js"))
    shared = {"traces": data.get("traces"), "grids": grids}
    return environment.get_template("page.html.j2").render(
        title=title,
        heading=heading,
        line=line,
        badge=badge,
        badge_means=badge_means,
        sections=bodies,
        style=Markup(_asset("vendor/uplot/uPlot.min.css") + _asset("report/assets/report.css")),
        scripts=[Markup(s) for s in scripts],
        allowed=" ".join(f"'sha256-{_digest(s)}'" for s in scripts),
        data=safe_json(json.dumps(shared, separators=(",", ":"), allow_nan=False)),
    )


def _body(environment: Any, section: Section, values: dict[str, Any]) -> dict[str, Any]:
    return {
        "name": section.name,
        "title": section.title,
        "short": section.short,
        "html": Markup(environment.get_template(section.template).render(**values)),
    }


def _digest(text: str) -> str:
    return base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()


def _asset(path: str) -> str:
    text = files("erclutch").joinpath(path).read_text(encoding="utf-8")
    # A script element ends at the first of these, whatever it stands in.
    assert "</script" not in text.lower() or path.endswith(".css")
    return text


def _environment() -> Any:
    jinja: Any = import_module("jinja2")
    folder = Path(str(files("erclutch").joinpath("report/templates")))
    return jinja.Environment(
        loader=jinja.FileSystemLoader(folder),
        autoescape=True,
        undefined=jinja.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
