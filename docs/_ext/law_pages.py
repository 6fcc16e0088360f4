"""The directive ``laws``: a table of all laws, and of each its text, equation, parameters and curves.

All of it comes from the laws' own files, and the equations from the functions that are fitted.
"""

from __future__ import annotations

import io
from typing import Any

import numpy as np
from docutils import nodes
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

from erclutch.models.laws import Law, LawFamily, families, law_from_name, shown_of
from erclutch.models.laws.law import Dimension
from erclutch.models.laws.symbolic import equation_latex, symbol_latex
from erclutch.report.plots.paper_style import SERIES, new_figure, style

_INK = "#010203"  # stands for the page's own text colour
_FIELDS = (0.0, 0.25, 0.5, 0.75, 1.0)
_NAMES = ("effort", "field", "slip", "time")


def unit_text(dimension: Dimension) -> str:
    """A unit in words: ``effort / slip``; 1 for a number."""
    powers = [(name, getattr(dimension, name)) for name in _NAMES]
    above = " ".join(name for name, power in powers if power > 0) or "1"
    below = " ".join(name for name, power in powers if power < 0)
    return f"{above} / {below}" if below else above


def table_of(law: Law) -> str:
    """Its parameters as a Markdown table."""
    lines = ["| symbol | meaning | unit | bounds |", "| --- | --- | --- | --- |"]
    lines += [
        f"| ${symbol_latex(s.name)}$ | {s.meaning} | {unit_text(s.dimension)} | {s.lower:g} .. {s.upper:g} |"
        for s in (*law.stimulus_shape, *law.shape)
    ]
    lines += [
        f"| ${symbol_latex(g.name)}$ | {g.meaning} | {unit_text(g.dimension)} | {'>= 0' if g.nonnegative else 'any'} |"
        for g in law.gains
    ]
    return "\n".join(lines)


def curves_of(law: Law, shape: list[float], gains: list[float]) -> str:
    """Effort against slip at five fields, as SVG that takes the page's text colour."""
    w = np.linspace(0.0, 2.0, 401)
    field_shape = shape[: len(law.stimulus_shape)]
    own_shape = shape[len(law.stimulus_shape) :]
    with style():
        figure: Any = new_figure(2.3, 4.2)
        axes = figure.subplots()
        for field, colour in zip(_FIELDS, SERIES, strict=False):
            E = np.full_like(w, field)
            E = law.stimulus(E, *field_shape) if law.stimulus else E
            columns = law.columns(E, w, *own_shape)
            effort = sum(g * c * np.ones_like(w) for g, c in zip(gains, columns, strict=True))
            axes.plot(w, effort, color=colour, label=f"E = {field:g}")
        axes.set(xlabel="slip w (normalised)", ylabel="effort", xlim=(0, 2), ylim=(0, None))
        axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), labelcolor=_INK)
        figure.patch.set_alpha(0.0)
        axes.patch.set_alpha(0.0)
        axes.tick_params(colors=_INK)
        axes.xaxis.label.set_color(_INK)
        axes.yaxis.label.set_color(_INK)
        for spine in axes.spines.values():
            spine.set_color(_INK)
        axes.grid(color=_INK, alpha=0.15)
        out = io.StringIO()
        figure.savefig(out, format="svg", metadata={"Date": None, "Creator": None})
    svg = out.getvalue()
    return svg[svg.index("<svg") :].replace(_INK, "currentColor")


def overview() -> str:
    """The table of all laws as Markdown."""
    rows = [
        f"| `{name}{'' if family.count is None else '-N'}` | {family.formula.replace('|', chr(92) + '|')} | {source} |"
        for name, family in families().items()
        for source in [law_from_name(name).source]
    ]
    return "\n".join(["| model | effort of one element | source |", "| --- | --- | --- |", *rows])


def page_of(law: Law) -> str:
    """Its equation, parameters and source as Markdown."""
    return f"$$T = {equation_latex(law)}$$\n\n{table_of(law)}\n\nSource: {law.source}.\n"


class LawsDirective(SphinxDirective):
    """``{laws}``."""

    def run(self) -> list[nodes.Node]:
        """Called by Sphinx."""
        made = self.parse_text_to_nodes(overview())
        for stem, family in families().items():
            usual = shown_of(stem, family)
            for number, name in enumerate(usual):
                made += self._law(name, family if number == 0 else None)
        return made

    def _law(self, name: str, family: LawFamily | None) -> list[nodes.Node]:
        law = law_from_name(name)
        title = law.title if family else f"{law.title}, {name.partition('/')[2]} field"
        section = nodes.section(ids=[nodes.make_id(f"law-{name}")], names=[])
        section += nodes.title(text=title)
        body = self.parse_text_to_nodes((f"{family.about}\n\n" if family else "") + page_of(law))
        for table in (t for node in body for t in node.findall(nodes.table)):
            table["classes"].append("parameters")
        section += body
        if family and family.curves:
            section += self._curves(law, family.curves)
        return [section]

    def _curves(self, law: Law, numbers: str) -> list[nodes.Node]:
        given = {
            name: float(value) for name, value in (pair.split("=") for pair in numbers.split())
        }
        shape = [given.pop(s.name) for s in (*law.stimulus_shape, *law.shape)]
        gains = [given.pop(g.name) for g in law.gains]
        if given:
            raise self.error(f"{law.name} has no parameter {', '.join(given)}")
        svg = curves_of(law, shape, gains).replace(
            "<svg ",
            f'<svg role="img" aria-label="{law.title}: effort against slip at five fields" ',
            1,
        )
        caption = f"*Drawn by* `make docs` *from the law's function (no data), at {numbers}.*"
        figure = nodes.container("", nodes.raw("", svg, format="html"), classes=["curves"])
        return [figure, *self.parse_text_to_nodes(caption)]


def setup(app: Sphinx) -> dict[str, bool]:
    """Called by Sphinx."""
    app.add_directive("laws", LawsDirective)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
