"""This section shows lags and memory: what the stages of a model gain, and their constants with intervals."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from erclutch.fit.choice.standing import standing_of_run
from erclutch.models.parameter_units import unit_text as unit_of
from erclutch.models.stages import slip_stages
from erclutch.report.html.section import Section
from erclutch.report.html.symbols import symbol
from erclutch.report.numbers.model_stages import stage_gain, stage_values, stages_in
from erclutch.report.numbers.number_text import (
    capital,
    constant_scale,
    count,
    interval,
    number,
    percent_text,
)
from erclutch.report.numbers.run_material import Material
from erclutch.report.numbers.switching import switches_of
from erclutch.report.plots.lag_plot import describe_lag
from erclutch.signals.device import DeviceName, Units, names_in_elements

_MOST = 6  # models whose constants are listed


def _fill(material: Material) -> dict[str, Any]:
    """Between command and effort."""
    after = material.after_switch
    staged = [e for e in material.body["ranking"] if stages_in(e)]
    staged.sort(key=lambda e: e["name"] != material.recommended)

    # Where after a switch the recommended model errs most, and what stages gain.
    of_switches = ""
    if after is None and not material.without_field:
        switches = int(np.count_nonzero(switches_of(material.rows) & material.rows.test))
        times = {0: "never switches", 1: "switches once"}.get(
            switches, f"switches {switches} times"
        )
        too_few = "too seldom to show the error after a switch"
        of_switches = f" The command {times} in the rows held out: {too_few}."
    if after is not None:
        standing = standing_of_run(material.body).word
        curve = after.rmse[material.recommended]
        worst = int(curve.argmax())
        since = float(after.since[worst])
        when = "in the very row of a switch"
        if since > 0.0:
            when = f"{number(1e3 * since, 2)} ms after a switch"
        of_switches = (
            f" Over {count(after.switches)} switches held out, the RMSE of the {standing} model is largest "
            f"{when}: {material.effort.of(float(curve[worst]))}."
        )
    if material.rows.data.in_no_time:
        of_switches = ""
    if staged:
        # Of two models that differ in nothing else.
        of_stages = (
            "No two models differ in their stages alone, so nothing tells what the stages gain."
        )
        pair = stage_gain(material.body["ranking"])
        with_stages = pair and pair.richer["test"]["rmse"][0]
        without = pair and pair.plainer["test"]["rmse"][0]
        if pair and with_stages and without:
            change = f"add {percent_text(with_stages / without - 1, 2)} to"
            if with_stages < without:
                change = f"take {percent_text(1 - with_stages / without, 2)} off"
            of_stages = (
                f"The stages alone ({', '.join(pair.added)}) {change} the error: "
                f"{pair.plainer['title']} errs by {material.effort.of(without)}, "
                f"{pair.richer['title']} by {material.effort.of(with_stages)}."
            )
    elif material.body["settings"]["lag"] == "none":
        of_stages = "No model has a lag or a memory: none was asked for (--lag none)."
    elif material.rows.data.in_no_time:
        of_stages = "No model has a lag or a memory: the rows are points of a table, none after another in time."
    elif material.without_field:
        of_switches = ""
        of_stages = "No model has a lag: the log has no field, so no command switches."
    else:
        of_stages = (
            "No model has a lag or a memory: the field never changes within a stretch of rows."
        )

    drawn = after is not None or material.step_responses
    return {
        "figures": describe_lag(material).panels if drawn else [],
        "models": [
            stages_of(e, material.rows.data.device, material.rows.data.units)
            for e in staged[:_MOST]
        ],
        "lead": of_stages + of_switches,
    }


DYNAMICS = Section("dynamics", "Lag and memory", "Lag and memory", _fill)


def stages_of(entry: Mapping[str, Any], device: DeviceName, units: Units) -> dict[str, Any]:
    """A model's stages with their constants; a stage without any is left out."""
    stages: list[dict[str, Any]] = []
    for stage in stages_in(entry):
        # The constants of the stage and its gains, in the units of the log, as run.json has them.
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
                names.update(names_in_elements(device, gain.name))

        rows: list[dict[str, Any]] = []
        for name, constant in known.items():
            if name not in names:
                continue
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
