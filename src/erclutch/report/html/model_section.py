"""This section shows the recommended model itself: its curves, where its effort turns, its constants, its network."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from erclutch.export.monotone import monotone_share, worst_turn
from erclutch.models.laws.yield_stress import YIELD_FORMS
from erclutch.models.stages import slip_stages
from erclutch.report.html.parameters_section import equation_of, meaning_of_letters, parameter_row
from erclutch.report.html.section import Section
from erclutch.report.html.symbols import plain_symbol
from erclutch.report.numbers.flow_curves import dwelled_fields
from erclutch.report.numbers.number_text import Scale, percent_text
from erclutch.report.numbers.run_material import Material
from erclutch.report.plots.model_plot import describe_model
from erclutch.signals.array import Array, largest_size, rms

#: Why a constant is zero: its part of the model is not there, so nothing was to be measured.
WITHOUT = "the fit is best without this part"
#: Numbers that say how the yield effort grows with the field: two fields give one number for any of them.
_FIELD_NUMBERS = {shape.name for form in YIELD_FORMS.values() for shape in form.shape} | {"n_m"}
_FIELDS_FOR_A_CURVE = 3
_LONG = 4  # constants that stand in one column
_FLAT = 0.01  # of the largest measured effort: a model whose effort changes by less does not follow the field
_FAR = 1.1  # of the largest measured effort, from which on a guess is told


def _fill(material: Material) -> dict[str, Any]:
    """Curves, and what to know of them; a law's constants."""
    name = material.recommended
    entry = material.run.entry(name)
    rows: list[dict[str, Any]] = []
    for number in entry["fit"]["parameters"]:
        row = parameter_row(number)
        why = why_not_measured(material, number)
        if why:
            row = {**row, "why": why, "mark": "not needed" if why == WITHOUT else "not measured"}
        rows.append(row)
    halves = [rows] if rows else []
    if len(rows) > _LONG:
        half = (len(rows) + 1) // 2
        halves = [rows[:half], rows[half:]]

    equation, letters = None, ""
    law = material.law_parts.get(name)
    if law is not None:
        equation = equation_of(law)
        letters = f"For w > 0; {meaning_of_letters(material, law)}"
        of_stages = [
            plain_symbol(output)
            for stage in slip_stages(law.structure.dynamics)
            for output in stage.outputs
        ]
        if of_stages:
            letters += (
                f" {', '.join(of_stages)} come from the stages on the slip, whose equations stand "
                "under “Details”."
            )
    wait = ""  # how long the field had stayed before a dot
    if not material.without_field and not material.rows.data.in_no_time:
        wait = Scale(1e3, "ms").of(material.dot_wait * material.period, 2)
    says = [*_curve_words(material)]
    # Curves leave out what is summed up from the slip, such as the travel of a spring.
    for stage in slip_stages(material.models[name].structure.dynamics):
        left_out = getattr(stage, "unsettled", "")
        if left_out:
            says.append(f"Curves are drawn without {left_out}, so they lie beside a curve.")
    says += _network_words(material)
    plot = describe_model(material)
    has_a_rival = any("rival" in panel.title for panel in plot.panels)
    return {
        "title": material.title,
        "rival": material.titles[material.rival] if material.rival and has_a_rival else "",
        "wait": wait,
        "figures": plot.panels,
        "says": says,
        "halves": halves,
        "lost": [row for row in rows if row.get("why", WITHOUT) != WITHOUT],
        "equation": equation,
        "letters": letters,
        "weights": entry["fit"]["weights"],
    }


MODEL = Section("model", "The model", "Model", _fill)


def why_not_measured(material: Material, number: Mapping[str, Any]) -> str:
    """Why the data do not tell a constant; empty where they do."""
    name, at_bound = number["name"], number["at_bound"]
    if not at_bound and number["low"] is not None and number["high"] is not None:
        return ""
    few = few_fields(material)
    if name in _FIELD_NUMBERS and 0 < few.size < _FIELDS_FOR_A_CURVE:
        at = " and ".join(material.field.of(float(field), 2) for field in few)
        plural = "s" if few.size > 1 else ""
        return f"the log dwells at {few.size} field{plural} ({at}); a curve over the field needs {_FIELDS_FOR_A_CURVE}"
    if at_bound and number["value"] == 0.0:
        return WITHOUT
    if at_bound:
        return f"the fit is best at the {at_bound} end of the range that is searched"
    return "other constants do the same on these rows"


def few_fields(material: Material) -> Array:
    """The few fields at which nearly all rows are, shape (k,); empty where a field takes many values.

    Elements of a pair have one law: the element with the most fields counts.
    """
    fields = [dwelled_fields(np.abs(element.field)) for element in material.rows.data.elements]
    return max(fields, key=lambda dwelled: dwelled.size or np.inf)


def _curve_words(material: Material) -> Iterator[str]:
    """Where the effort is monotone in the field, how far it reaches, and where curves are guesses."""
    model = material.models[material.recommended]
    word = material.word
    lowest, highest = model.trained_on.field
    if lowest == highest:
        field = "no field" if material.without_field else f"one field, {material.field.of(highest)}"
        yield f"The log has {field}: nothing tells how the {word} follows the field."
        return
    share = monotone_share(model)
    turn = worst_turn(model)
    measured = largest_size(material.rows.data.effort)
    follows = 0.0  # how far the effort goes over the field at one slip, at most
    for _, over_field in material.recommended_curves:
        moves = np.ptp(over_field.effort, axis=1)
        follows = max(follows, float(moves.max()))
    kept = 0.0  # the share of a field that stays in the iron, as the recommended model has it
    for response in material.step_responses:
        if response.model == material.recommended:
            kept = response.kept_back
            break
    if follows <= _FLAT * measured:
        yield f"Its {word} does not follow the field."
    elif share == 1.0 and kept:
        yield (
            f"Curves are drawn without what the iron keeps, up to {percent_text(kept, 2)} of the field: behind a field "
            f"that falls the {word} stays larger, behind a field that rises it stays smaller, so measured rows lie on "
            "both sides of a curve."
        )
    elif share == 1.0:
        yield f"In settled fields its {word} goes one way with the field at every slip, so each {word} has one field."
    else:
        at = " and ".join(material.slip.of(slip, 2) for slip in turn.slips)
        turned = percent_text(1.0 - share, 2)
        yield (
            f"Where the field grows, the {word} should grow too. Along {turned} of the curves over the field "
            f"it turns back: most at a slip of {at}, by {material.effort.of(turn.back, 2)} between "
            f"{material.field.bare(turn.fields[0], 3)} and {material.field.of(turn.fields[1], 3)}. Two fields give one "
            f"{word} there, and an exported inverse takes the field nearest to zero."
        )
    if abs(turn.farthest) > _FAR * measured:
        yield (
            f"Inside the ranges of field and slip the settled model reaches {material.effort.of(turn.farthest)}; the "
            f"largest {word} of the log is {material.effort.of(measured)}. Beyond what was measured the model guesses."
        )
    few = few_fields(material)
    if 1 < few.size < _FIELDS_FOR_A_CURVE:
        at = " and ".join(material.field.of(float(field), 2) for field in few)
        yield f"Nearly all rows have the field {at}: between these fields the curves are the model’s guess."


def _network_words(material: Material) -> Iterator[str]:
    """What the network of a law with one adds."""
    model = material.models[material.recommended]
    data = material.rows.data
    # Runs of earlier versions keep no further inputs.
    kept = model.extras.keys() <= data.extras.keys()
    if model.correction is None or not kept:
        return

    test = material.rows.test
    added = model.added(data.elements, data.clock, data.extras, exactly=False)[test]
    residual = material.rows.residual(material.recommended)[test]
    effort = rms(data.effort[test])
    share = rms(added) / effort if effort else 0.0
    yield (
        f"The network adds {material.effort.of(rms(added))} RMS, {percent_text(share, 2)} of the "
        f"{material.word}, and never more than {material.effort.of(model.correction.limit)}. Without the network the "
        f"law errs by {material.effort.of(rms(residual + added))} on the rows held out, with the network by "
        f"{material.effort.of(rms(residual))}."
    )
