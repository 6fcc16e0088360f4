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
from erclutch.report.numbers.number_text import (
    capital,
    constant_scale,
    count,
    interval,
    number,
    percent,
)
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
    """A model's stages with their constants; a stage without any is left out."""
    stages: list[dict[str, Any]] = []
    for stage in stages_in(entry):
        rows: list[dict[str, Any]] = []
        for constant in _constants(entry, stage, units):
            scale = constant_scale(constant["unit"], abs(constant["value"]))
            band = "from the best law"
            identified = True
            if "low" in constant:
                band, identified = interval(constant, scale.factor)
            rows.append(
                {
                    "symbol": symbol(constant["name"]),
                    "meaning": constant["meaning"],
                    "value": scale.bare(constant["value"], 3),
                    "unit": scale.unit,
                    "band": band,
                    "identified": identified,
                }
            )
        if rows:
            stages.append({"title": capital(stage.title), "rows": rows})
    return {"title": entry["title"], "stages": stages}


def _constants(
    entry: Mapping[str, Any],
    stage: Stage,
    units: Units,
) -> Iterator[Mapping[str, Any]]:
    """The constants of a stage and its gains, in the units of the log, as run.json has them."""
    constants = stage.parameters(1.0)
    known = {p["name"]: p for p in entry["fit"]["parameters"]}
    for constant in constants:
        if constant.name not in known:  # of a network, which has its stages from the best law
            known[constant.name] = {
                "name": constant.name,
                "value": stage_values(entry, stage)[constant.name],
                "unit": unit_of(constant.dimension, units),
                "meaning": constant.meaning,
            }

    names = {constant.name for constant in constants}
    for part in slip_stages(stage.name):
        for gain in part.gains:
            names |= {
                gain.name,
                f"{gain.name}_1",
                f"{gain.name}_2",
            }  # of the device, or of each clutch
    for name, parameter in known.items():
        if name in names:
            yield parameter


def _lead(material: Material, after: AfterSwitch | None, *, staged: bool) -> str:
    """What stages gain, and where after a switch the recommended model errs most."""
    if staged:
        of_stages = _gain(material)
    elif material.body["settings"]["lag"] == "none":
        of_stages = "No model has a lag or a memory: none was asked for (--lag none)."
    elif material.rows.data.in_no_time:
        return "No model has a lag or a memory: the rows are points of a table, none after another in time."
    elif material.without_field:
        return "No model has a lag: the log has no field, so no command switches."
    else:
        of_stages = (
            "No model has a lag or a memory: the field never changes within a stretch of rows."
        )

    if after is None:
        of_switches = "The command hardly ever switches in the rows held out, so these rows tell little of a lag."
        return f"{of_stages} {of_switches}"
    curve = after.rmse[material.recommended]
    worst = int(curve.argmax())
    since = float(after.since[worst])
    when = (
        "in the very row of a switch"
        if since == 0.0
        else f"{number(1e3 * since, 2)} ms after a switch"
    )
    return (
        f"{of_stages} Over {count(after.switches)} switches held out, the RMSE of the recommended model is largest "
        f"{when}: {material.effort.of(float(curve[worst]))}."
    )


def _gain(material: Material) -> str:
    """What stages alone take off the error: of two models that differ in nothing else."""
    nothing = "No two models differ in their stages alone, so nothing tells what the stages gain."
    pair = stage_gain(material.body["ranking"])
    if pair is None:
        return nothing
    with_stages = pair.richer["test"]["rmse"][0]
    without = pair.plainer["test"]["rmse"][0]
    if not with_stages or not without:
        return nothing
    if with_stages < without:
        change = f"take {percent(1 - with_stages / without, 2)} off"
    else:
        change = f"add {percent(with_stages / without - 1, 2)} to"
    return (
        f"The stages alone ({', '.join(pair.added)}) {change} the error: "
        f"{pair.plainer['title']} errs by {material.effort.of(without)}, "
        f"{pair.richer['title']} by {material.effort.of(with_stages)}."
    )
