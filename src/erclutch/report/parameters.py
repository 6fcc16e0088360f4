"""Parameters with units, intervals and bounds hit, in the paper's symbols where it has any."""

from __future__ import annotations

from collections.abc import Mapping
from importlib import import_module
from typing import Any, ClassVar

from markupsafe import Markup

from erclutch.diagnostics.material import Material
from erclutch.diagnostics.text import Scale, number, span, unit_text
from erclutch.model import TorqueModel
from erclutch.report.section import Section
from erclutch.report.symbols import plain_symbol, symbol


class ParametersSection(Section):
    """One table a law; the recommended one open."""

    name: ClassVar[str] = "parameters"
    title: ClassVar[str] = "Parameters"
    short: ClassVar[str] = "Parameters"

    def fill(self, material: Material) -> dict[str, Any]:
        """See `Section.fill`."""
        ranking = sorted(material.body["ranking"], key=lambda e: e["name"] != material.recommended)
        laws = [_law(material, e) for e in ranking if not e["fit"]["weights"]]
        networks = [e for e in ranking if e["fit"]["weights"]]
        return {
            "laws": laws,
            "networks": [{"name": e["name"], "title": e["title"], "weights": e["fit"]["weights"]} for e in networks],
            "recommended": material.recommended,
        }


def _law(material: Material, entry: Mapping[str, Any]) -> dict[str, Any]:
    model = material.models[entry["name"]]
    fit = entry["fit"]
    # SymPy takes its time: the others are a command away (erclutch laws).
    chosen = entry["name"] == material.recommended
    return {
        "name": entry["name"],
        "title": entry["title"],
        "equation": equation_of(model) if chosen and isinstance(model, TorqueModel) else "",
        "reference": _reference(material, model) if chosen and isinstance(model, TorqueModel) else "",
        "source": model.structure.law.source if isinstance(model, TorqueModel) else "",
        "rows": [_parameter(p) for p in fit["parameters"]],
        "published": [(symbol(name), number(value, 4)) for name, value in fit["paper_form"].items()],
        "condition": number(fit["condition"], 2),
        "open": chosen,
    }


def _parameter(p: Mapping[str, Any]) -> dict[str, Any]:
    scale = Scale(1e3, "ms") if p["unit"] == "s" else Scale(1.0, "" if p["unit"] == "1" else unit_text(p["unit"]))
    low, high = (None if v is None else v * scale.factor for v in (p["low"], p["high"]))
    if p["at_bound"]:
        band, state = f"at its {p['at_bound']} bound", "bound"
    elif low is None or high is None:
        band, state = "not identified", "bound"
    else:
        band, state = span(low, high), ""
    return {
        "symbol": symbol(p["name"]),
        "plain": plain_symbol(p["name"]),
        "meaning": p["meaning"],
        "value": scale.bare(p["value"], 4),
        "band": band,
        "state": state,
        "unit": scale.unit,
    }


def _reference(material: Material, model: TorqueModel) -> str:
    """What E and w are over in the equation."""
    return (
        f"E is the field over {material.field.of(model.reference.field, 4)}, w the slip over "
        f"{material.slip.of(model.reference.slip, 4)}; the table's numbers are in the log's own units."
    )


def equation_of(model: TorqueModel) -> Markup:
    """The law's effort for w > 0 as MathML, made from the function that is fitted."""
    law = model.structure.law
    if law.name.startswith("rbfm"):
        return _RBFM
    symbolic: Any = import_module("erclutch.laws.symbolic")
    printing: Any = import_module("sympy.printing.mathml")
    body = printing.mathml(symbolic.short_equation(law), printer="presentation")
    return Markup('<math display="block"><mrow><mi>T</mi><mo>=</mo>') + Markup(body) + Markup("</mrow></math>")


#: The sum over kernels as the paper prints it; written out it would fill the page.
_RBFM = Markup(
    '<math display="block"><mrow><mi>T</mi><mo>=</mo><msub><mi>T</mi><mi>y</mi></msub><mi>y</mi><mo>(</mo><mi>E</mi>'
    "<mo>)</mo><mi>sgn</mi><mi>w</mi><mo>+</mo><mi>w</mi><munder><mo>∑</mo><mi>i</mi></munder><msub><mi>k</mi><mi>i</mi></msub>"
    "<mi>exp</mi><mo>(</mo><mo>−</mo><mfrac><msup><mrow><mo>(</mo><mi>E</mi><mo>−</mo><msub><mi>μ</mi><mi>i</mi></msub>"
    "<mo>)</mo></mrow><mn>2</mn></msup><mrow><mn>2</mn><msup><mi>σ</mi><mn>2</mn></msup></mrow></mfrac><mo>)</mo></mrow></math>"
)
