"""This section lists parameters with units, intervals and bounds hit, in the paper's symbols where it has any."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from markupsafe import Markup

from erclutch.models.law_model import TorqueModel
from erclutch.models.stages import slip_stages, stages_at, temperature_stages
from erclutch.report.html.equations import memory_terms_of, terms_of
from erclutch.report.html.section import Section
from erclutch.report.html.symbols import equation_text, plain_symbol, symbol
from erclutch.report.numbers.number_text import constant_scale, interval, number
from erclutch.report.numbers.run_material import Material


def _fill(material: Material) -> dict[str, Any]:
    """One table a law, the recommended one first."""
    ranking = sorted(
        material.body["ranking"], key=lambda entry: entry["name"] != material.recommended
    )
    laws: list[dict[str, Any]] = []
    networks: list[dict[str, Any]] = []
    for entry in ranking:
        fit = entry["fit"]
        model = material.law_parts.get(entry["name"])
        if model is None:
            networks.append({"title": entry["title"], "weights": fit["weights"]})
            continue
        # The equation of the law with its constants, as it was fitted and as it was published.
        stages = [(stage.name, equation_text(stage.equation)) for stage in model.structure.stages]
        of_paper = fit["paper_form"].items()
        laws.append(
            {
                "name": entry["name"],
                "title": entry["title"],
                "equation": equation_of(model),
                "stages": stages,
                "reference": meaning_of_letters(material, model),
                "source": model.structure.law.source,
                "rows": [parameter_row(p) for p in fit["parameters"]],
                "published": [(symbol(name), number(value, 4)) for name, value in of_paper],
                "condition": number(fit["condition"], 2),
                "odd": negative_gains(model),
                "weights": fit["weights"],
            }
        )
    return {"laws": laws, "networks": networks}


PARAMETERS = Section(
    "parameters", "Equations and constants of all laws", "Parameters", _fill, folded=True
)


def negative_gains(model: TorqueModel) -> list[str]:
    """A sentence or two on each gain below zero that is usually above; the same gain of two elements is told once."""
    odd: dict[str, list[str]] = {}
    for gain in model.structure.gains():
        if gain.negative and model.gains[gain.name] < 0:
            odd.setdefault(gain.negative, []).append(f"{plain_symbol(gain.name)}, {gain.meaning},")
    sentences: list[str] = []
    for why, gains in odd.items():
        verb = "are" if len(gains) > 1 else "is"
        sentences.append(f"{' and '.join(gains)} {verb} negative. {why}")
    return sentences


def parameter_row(p: Mapping[str, Any]) -> dict[str, Any]:
    """A number of run.json as a row of a table."""
    scale = constant_scale(p["unit"], abs(p["value"]))
    band, identified = interval(p, scale.factor)
    return {
        "symbol": symbol(p["name"]),
        "plain": plain_symbol(p["name"]),
        "meaning": p["meaning"],
        "value": scale.bare(p["value"], 4),
        "band": band,
        "identified": identified,
        "unit": scale.unit,
    }


def meaning_of_letters(material: Material, model: TorqueModel) -> str:
    """What E and w are over in the equation, and what its other letters are."""
    pair = ""
    if len(material.rows.data.elements) > 1:
        pair = "of one clutch, numbered by the parameters' last index; "
    dynamics = model.structure.dynamics
    lagged = stages_at(dynamics, "command")
    fluid = " in the fluid, behind the stages on the command," if lagged else ""
    more = ""
    if slip_stages(dynamics):
        more += " y(E) is the strength of the field in the memory, 1 at that field;"
    if temperature_stages(dynamics):
        more += f" t is the temperature over {model.reference.temperature:.4g} K;"
    slip = material.slip.of(model.reference.slip, 4)
    letters = f"E is the field{fluid} over {material.field.of(model.reference.field, 4)}, w the slip over {slip}"
    if material.without_field:
        letters = f"w is the slip over {slip}"
    return f"{pair}{letters};{more} the table's numbers have their own units."


def equation_of(model: TorqueModel) -> Markup:
    """The effort for w > 0 as MathML, made from the function that is fitted, a term a formula so that lines may break.

    Friction, further inputs and offset, which are not the law's, stand at its end.
    """
    structure = model.structure
    law = structure.law
    terms = list(
        _KERNELS
        if law.name.startswith("rbfm")
        else terms_of(structure.specification, structure.device)
    )
    terms += memory_terms_of(structure.dynamics)
    for added in structure.added_terms():
        if added.kind == "input":
            factor = Markup('<mspace width="0.2em"/><mtext>{}</mtext>').format(added.factor)
        else:
            factor = _TURN if added.factor else Markup("")
        # The gain is a letter with an index, a number or a word.
        letter, _, index = added.gain.partition("_")
        kind = Markup("mn" if index.isdecimal() else "mi")
        gain = Markup("<msub><mi>{}</mi><{}>{}</{}></msub>").format(letter, kind, index, kind)
        terms.append(gain + factor)
    behind = stages_at(structure.dynamics, "effort")
    before = Markup(
        "<msub><mi>T</mi><mi>fluid</mi></msub><mo>=</mo>" if behind else "<mi>T</mi><mo>=</mo>"
    )
    pieces: list[Markup] = []
    for term in terms:
        pieces.append(Markup("<math><mrow>{}</mrow></math>").format(before + term))
        before = Markup('<mo form="infix" lspace="0.25em" rspace="0.25em">+</mo>')
    return Markup(" ").join(pieces)


#: By what a friction is multiplied that turns with the slip.
_TURN = Markup(
    "<mi>tanh</mi><mo>(</mo><mfrac><mi>w</mi><msub><mi>w</mi><mi>s</mi></msub></mfrac><mo>)</mo>"
)


#: The sum over kernels as the paper prints it; written out it would fill the page.
_KERNELS = (
    Markup(
        "<msub><mi>T</mi><mi>y</mi></msub><mi>y</mi><mo>(</mo><mi>E</mi><mo>)</mo><mi>sgn</mi><mo>(</mo><mi>w</mi><mo>)</mo>"
    ),
    Markup(
        "<mi>w</mi><munder><mo>∑</mo><mi>i</mi></munder><msub><mi>k</mi><mi>i</mi></msub><mi>exp</mi><mo>(</mo><mo>−</mo>"
        "<mfrac><msup><mrow><mo>(</mo><mi>E</mi><mo>−</mo><msub><mi>μ</mi><mi>i</mi></msub><mo>)</mo></mrow><mn>2</mn>"
        "</msup><mrow><mn>2</mn><msup><mi>σ</mi><mn>2</mn></msup></mrow></mfrac><mo>)</mo>"
    ),
)
