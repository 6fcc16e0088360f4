"""Sections make a page: one HTML file that needs nothing else and asks nobody for anything."""

from __future__ import annotations

import base64
import hashlib
import json
from collections.abc import Mapping, Sequence
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import Any

from markupsafe import Markup

from erclutch.errors import RunError
from erclutch.fit.choice.standing import standing_of_run
from erclutch.report.html.band_section import BAND
from erclutch.report.html.dynamics_section import DYNAMICS
from erclutch.report.html.model_section import MODEL
from erclutch.report.html.parameters_section import PARAMETERS
from erclutch.report.html.picture_sections import ERROR_MAP, FLOW_CURVES, LOOPS, PARITY, RESIDUAL
from erclutch.report.html.provenance_section import PROVENANCE
from erclutch.report.html.section import Section
from erclutch.report.html.symbols import safe_json
from erclutch.report.html.traces_section import TRACES
from erclutch.report.html.verdict_section import RANKING, VERDICT
from erclutch.report.numbers.number_text import capital, count, number, percent_text, span
from erclutch.report.numbers.run_material import Material
from erclutch.report.plots.paper_style import placed
from erclutch.report.plots.svg_painter import svg

_STYLES = ("uplot/uPlot.min", "report", "print")
#: In this order: each uses what stands in those before it.
_SCRIPTS = (
    "page",
    "error_maps",
    "packed_rows",
    "log_clock",
    "traces_strip",
    "traces_readout",
    "traces",
)
#: Sections in the order of the page.
SECTIONS: tuple[Section, ...] = (
    *(VERDICT, MODEL, RANKING, TRACES, ERROR_MAP, PARITY, LOOPS, DYNAMICS, BAND),
    *(RESIDUAL, FLOW_CURVES, PARAMETERS, PROVENANCE),
)


def report_html(material: Material) -> str:
    """The report of a run as one HTML document."""
    heading, line = headings(material)
    heading = material.about.title or heading
    return page(material, SECTIONS, f"{material.title}: {heading}", heading, line)


def headings(material: Material) -> tuple[str, str]:
    """What was measured, and a line about it."""
    body = material.body
    first, *others = (str(log["name"]) for log in body["logs"])
    more = ""
    if others:
        more = f" and {len(others)} more log{'s' if len(others) > 1 else ''}"
    device = (
        "A coaxial pair of clutches"
        if body["device"] == "coaxial"
        else "A single clutch, brake or damper"
    )
    rows = sum(int(log["rows"]) for log in body["logs"])
    if material.rows.data.in_no_time:
        return f"{first}{more}", f"{device}, {count(rows)} points of a table"
    seconds = 0.0
    different: set[float] = set()  # rates in Hz
    for log in body["logs"]:
        period = float(log["period_s"])
        seconds += int(log["rows"]) * period
        different.add(float(f"{1.0 / period:.4g}"))
    rates = [f"{rate:g}" for rate in sorted(different)]
    at = " and ".join(rates) if len(rates) <= 2 else f"{rates[0]} to {rates[-1]}"
    return f"{first}{more}", f"{device}, {count(rows)} rows, {number(seconds)} s at {at} Hz"


def write_report(material: Material, path: Path) -> Path:
    """Write the report of a run as one HTML file, whole or not at all.

    Raises:
        RunError: the folder cannot be written.
    """
    text = report_html(material)
    with placed(path) as partial:
        # Names may be no text.
        partial.write_text(text, encoding="utf-8", errors="backslashreplace")
    return path


def page(
    material: Material,
    sections: Sequence[Section],
    title: str,
    heading: str,
    line: str,
) -> str:
    """Sections as one HTML document.

    Args:
        material: what they are filled from.
        sections: those that the material can fill are shown.
        title: of the window.
        heading: of the page; what was measured.
        line: under the heading.
    """
    filled: list[tuple[Section, dict[str, Any]]] = []
    for section in sections:
        values = section.fill(material)
        if values is not None:
            filled.append((section, values))
    environment = templates()
    data: dict[str, Any] = {}  # for the page's scripts
    grids: list[Any] = []
    for section, values in filled:
        if "data" in values:
            data[section.name] = values["data"]
        grids += values.get("grids", [])
    common = {
        "material": material,
        "body": material.body,
        "recommended": material.recommended,
        "titles": material.titles,
        "effort": material.effort,
        "legend": {material.titles[name]: role for name, role in material.shown.items()},
        "word": material.word,
        "standing": standing_of_run(material.body).word,
    }
    bodies = [_body(environment, section, common | values) for section, values in filled]
    shared = {"traces": data.get("traces"), "grids": grids}
    badge = (material.badge, material.badge_means)
    titles_of_page = (title, heading, line)
    return _document(titles_of_page, badge, bodies, shared, plots=bool(data))


def plain_page(
    titles: tuple[str, str, str],
    badge: tuple[str, str],
    section: Section,
    values: dict[str, Any],
    folder: Path | None = None,
) -> str:
    """A document of one section that is no run's.

    Args:
        titles: of the window, of the page, and a line below.
        badge: where the data come from, and what that means.
        section: its template has the section's name.
        values: of the template.
        folder: of the template; None: the folder of the report.
    """
    body = _body(templates(folder), section, values)
    return _document(titles, badge, [body], {"traces": None, "grids": []}, plots=False)


def _document(
    titles: tuple[str, str, str],
    badge: tuple[str, str],
    sections: list[dict[str, Any]],
    shared: Any,
    *,
    plots: bool,
) -> str:
    scripts: list[str] = []
    if plots:
        scripts.append(_asset("report/assets/uplot/uPlot.iife.min.js"))
    scripts.append("".join(_asset(f"report/assets/{name}.js") for name in _SCRIPTS))
    # The page allows these scripts by their digests, and no other.
    allowed: list[str] = []
    for script in scripts:
        digest = hashlib.sha256(script.encode()).digest()
        allowed.append(f"'sha256-{base64.b64encode(digest).decode()}'")
    title, heading, line = titles
    as_text = json.dumps(shared, separators=(",", ":"), allow_nan=False)
    values: dict[str, Any] = {
        "title": title,
        "heading": heading,
        "line": line,
        "badge": badge[0],
        "badge_means": badge[1],
        "sections": [section for section in sections if not section["folded"]],
        "details": [section for section in sections if section["folded"]],
        "style": Markup("".join(_asset(f"report/assets/{name}.css") for name in _STYLES)),
        "scripts": [Markup(script) for script in scripts],
        "allowed": " ".join(allowed),
        "data": safe_json(as_text),
    }
    return _rendered(templates(), "page", values)


def _body(environment: Any, section: Section, values: dict[str, Any]) -> dict[str, Any]:
    return {
        "name": section.name,
        "title": section.title,
        "short": section.short,
        "folded": section.folded,
        "printed": section.printed,
        "html": Markup(_rendered(environment, section.name, values)),
    }


def _rendered(environment: Any, name: str, values: Mapping[str, Any]) -> str:
    """A template with its values.

    Raises:
        RunError: it is not there or cannot be filled in, as where a template was changed.
    """
    import jinja2

    try:
        return environment.get_template(f"{name}.html.j2").render(**values)
    except jinja2.TemplateError as error:
        problem = (
            f"the part {name} of the page cannot be filled in ({type(error).__name__}: {error})"
        )
        remedy = (
            "Install erclutch anew, or fit again with this version if the run is of another one"
        )
        raise RunError(problem, remedy=remedy) from error


def _asset(path: str) -> str:
    text = files("erclutch").joinpath(path).read_text(encoding="utf-8")
    # A script element ends at the first of these, whatever it stands in.
    assert "</script" not in text.lower() or path.endswith(".css")
    return text


@cache
def templates(first: Path | None = None) -> Any:
    """Templates of the report as a Jinja environment, behind those of another folder."""
    import jinja2

    own = Path(str(files("erclutch").joinpath("report/templates")))
    made: Any = jinja2.Environment(
        loader=jinja2.FileSystemLoader([own] if first is None else [first, own]),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    made.filters["svg"] = svg
    made.filters["capital"] = capital
    made.globals.update(count=count, number=number, percent_text=percent_text, span=span)
    return made
