"""Equations drawn while the site is built: an SVG to look at and MathML to listen to. No script, no font, no request.

ziamath sets LaTeX with the STIX Two Math outlines that it carries; latex2mathml says the same for screen readers.
"""

from __future__ import annotations

import re
import warnings
from typing import Any
from xml.etree import ElementTree

import ziamath
from docutils import nodes
from latex2mathml.converter import convert
from sphinx.application import Sphinx

_SIZE = 20.0  # px of an em in ziamath's drawing; the page scales it to its own em

ziamath.config.svg2 = False
ziamath.config.precision = 2


def drawn(latex: str, *, display: bool) -> str:
    """HTML of an equation."""
    # ziamath reads `\\left|` as text; the plain bar is drawn right.
    text = re.sub(r"\\(left|right)\|", "|", " ".join(latex.split()))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        made = ziamath.Latex(text, size=_SIZE, color="currentColor", inline=not display)
        tree = made.svgxml()
        drop = made.getyofst()
    box = [float(number) for number in str(tree.get("viewBox")).split()]
    for key in ("width", "height"):
        tree.attrib.pop(key, None)
    tree.set(
        "style",
        f"width:{box[2] / _SIZE:.3f}em;height:{box[3] / _SIZE:.3f}em;vertical-align:{drop / _SIZE:.3f}em",
    )
    tree.set("aria-hidden", "true")
    picture = ElementTree.tostring(tree, encoding="unicode")
    spoken = convert(latex, display="block" if display else "inline")
    return f'{picture}<span class="spoken">{spoken}</span>'


def _inline(writer: Any, node: nodes.math) -> None:
    writer.body.append(f'<span class="drawn">{drawn(node.astext(), display=False)}</span>')
    raise nodes.SkipNode


def _block(writer: Any, node: nodes.math_block) -> None:
    lines = [line for line in re.split(r"\\\\", node.astext()) if line.strip()]
    for line in lines:
        writer.body.append(f'<div class="drawn" tabindex="0">{drawn(line, display=True)}</div>')
    raise nodes.SkipNode


def setup(app: Sphinx) -> dict[str, bool]:
    """Called by Sphinx."""
    app.add_html_math_renderer("drawn", (_inline, None), (_block, None))
    return {"parallel_read_safe": True, "parallel_write_safe": True}
