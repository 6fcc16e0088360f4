"""This section shows lags and memory: what the stages of a model gain, and their constants with intervals."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from erclutch.models.parameter_units import unit_text as unit_of
from erclutch.models.stages import slip_stages
from erclutch.models.stages.stage import Stage
from erclutch.report.html.section import Section
from erclutch.report.html.symbols import symbol
from erclutch.report.numbers.model_stages import stage_gain, stage_values, stages_in
from erclutch.report.numbers.number_text import Scale, capital, count, interval, number, percent, scale_for
from erclutch.report.numbers.run_material import Material
from erclutch.report.numbers.switching import AfterSwitch
from erclutch.report.plots.lag_plot import describe_lag
from erclutch.signals.device import Units

_MOST = 6  # models whose constants are listed


def _fill(material: Material) -> dict[str, Any]:
    """Between command and effort."""
    after = material.after_switch
    staged = [e for e in material.body["ranking"] if stages_in(e)]
    staged.sort(key=lambda e: e["name"] != material.recommended)
    drawn = after is not None or material.step_responses
    return {
        "figures": describe_lag(material).panels if drawn else [],
        "models": [_model(e, material.rows.data.units) for e in staged[:_MOST]],
        "lead": _lead(material, after, staged=bool(staged)),
    }


DYNAMICS = Section("dynamics", "Lag and memory", "Lag and memory", _fill)


def _model(entry: Mapping[str, Any], units: Units) -> dict[str, Any]:
    found = [(capital(s.title), list(_constants(entry, s, units))) for s in stages_in(entry)]
    return {"title": entry["title"], "stages": [{"title": title, "rows": rows} for title, rows in found if rows]}


def _constants(entry: Mapping[str, Any], stage: Stage, units: Units) -> Iterator[dict[str, Any]]:
    """The constants of a stage and its gains, in the units of the log."""
    known = {p["name"]: p for p in entry["fit"]["parameters"]}
    for p in stage.parameters(1.0):
        if p.name not in known:  # of a network
            value = stage_values(entry, stage)[p.name]
            known[p.name] = {"name": p.name, "value": value, "unit": unit_of(p.dimension, units), "meaning": p.meaning}
    names = [p.name for p in stage.parameters(1.0)]
    gains = [g.name for s in slip_stages(stage.name) for g in s.gains]
    for name, p in known.items():
        if name in names or any(name in (g, *(f"{g}_{k}" for k in (1, 2))) for g in gains):
            yield _constant(p)


def _constant(p: Mapping[str, Any]) -> dict[str, Any]:
    unit = "" if p["unit"] == "1" else p["unit"]
    scale = scale_for(unit, abs(p["value"])) if unit != "s" else Scale(1e3, "ms")
    band, identified = interval(p, scale.factor) if "low" in p else ("from the best law", True)
    return {
        "symbol": symbol(p["name"]),
        "meaning": p["meaning"],
        "value": scale.bare(p["value"], 3),
        "unit": scale.unit,
        "band": band,
        "identified": identified,
    }


def _lead(material: Material, after: AfterSwitch | None, *, staged: bool) -> str:
    parts = [_none(material)] if not staged else [_gain(material)]
    if after is not None:
        curve = after.rmse[material.recommended]
        parts.append(
            f"Over {count(after.switches)} switches held out, the RMSE of the recommended model is largest "
            f"{_worst_time(float(after.since[int(curve.argmax())]))}: {material.effort.of(float(curve.max()))}."
        )
    else:
        parts.append("The command hardly ever switches in the rows held out, so these rows tell little of a lag.")
    return " ".join(part for part in parts if part)


def _none(material: Material) -> str:
    asked = material.body["settings"]["lag"]
    why = "none was asked for (--lag none)" if asked == "none" else "the field never changes within a stretch of rows"
    return f"No model has a lag or a memory: {why}."


def _gain(material: Material) -> str:
    """What stages alone take off the error: of two models that differ in nothing else."""
    found = stage_gain(material.body["ranking"])
    a, b = (None, None) if found is None else (e["test"]["rmse"][0] for e in (found.richer, found.plainer))
    if found is None or not a or not b:
        return "No two models differ in their stages alone, so nothing tells what the stages gain."
    change = f"take {percent(1 - a / b, 2)} off" if a < b else f"add {percent(a / b - 1, 2)} to"
    return (
        f"The stages alone ({', '.join(found.added)}) {change} the error: "
        f"{found.plainer['title']} errs by {material.effort.of(b)}, "
        f"{found.richer['title']} by {material.effort.of(a)}."
    )


def _worst_time(since: float) -> str:
    return "in the very row of a switch" if since == 0.0 else f"{number(1e3 * since, 2)} ms after a switch"
