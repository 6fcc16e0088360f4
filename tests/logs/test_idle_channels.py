"""Voltages of a bench that no supply gives: channels that nothing is plugged into, sensors, a controller's output."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest

from erclutch.logs import ColumnMap, Plan, Table, plan_of

SPAN = np.arange(400) * 0.01
STROKE = 0.3 * SPAN + 0.01 * np.sin(5.0 * SPAN)
PULL = 40.0 * STROKE + np.cos(3.0 * SPAN)


def _plan(more: Mapping[str, Any], units: Mapping[str, str], told: ColumnMap | None = None) -> Plan:
    columns = {"Zeit": SPAN, "Weg": STROKE, "Kraft": PULL, **more}
    written = {"Zeit": "s", "Weg": "mm", "Kraft": "N", **units}
    return plan_of(Table("a", columns, written, "0" * 64), told or ColumnMap())


def _field(plan: Plan) -> str:
    return next(each.column or "none" for each in plan.signals if each.signal == "field")


@pytest.mark.parametrize("level", [0.0, -1e6, 1e6])
@pytest.mark.parametrize("unit", ["V", "A"])
def test_a_channel_that_nothing_is_plugged_into_is_no_field(level: float, unit: str) -> None:
    idle = np.full(SPAN.size, level)
    plan = _plan({"MXB_0_CH 7": idle, "MXB_0_CH 8": idle}, {"MXB_0_CH 7": unit, "MXB_0_CH 8": unit})
    assert plan.questions == ()
    assert plan.doubts == ()
    assert _field(plan) == "none"
    assert any("nothing is plugged into" in note for note in plan.notes)


@pytest.mark.parametrize("level", [0.0, 12.0])
def test_a_steady_voltage_that_is_called_so_may_be_the_field(level: float) -> None:
    plan = _plan({"Voltage": np.full(SPAN.size, level)}, {"Voltage": "V"})
    assert _field(plan) == "Voltage"


def test_a_channel_at_0_alone_may_be_the_field_of_a_log_beside_others() -> None:
    plan = _plan({"MXB_0_CH 7": np.zeros(SPAN.size)}, {"MXB_0_CH 7": "V"})
    assert _field(plan) == "MXB_0_CH 7"


def test_a_spare_channel_that_holds_something_is_asked_about() -> None:
    plan = _plan({"MXB_0_CH 7": 2.0 + (SPAN > 2.0)}, {"MXB_0_CH 7": "V"})
    assert plan.questions or plan.doubts or _field(plan) == "MXB_0_CH 7"


def test_a_channel_that_the_user_names_is_taken() -> None:
    told = ColumnMap.from_options({"field": "MXB_0_CH 7"})
    plan = _plan({"MXB_0_CH 7": np.zeros(SPAN.size)}, {"MXB_0_CH 7": "V"}, told)
    assert _field(plan) == "MXB_0_CH 7"


def test_the_volts_of_a_sensor_stand_beside_what_it_measures() -> None:
    columns = {
        "Depth (nm)": 1e3 * STROKE,
        "Load (µN)": PULL,
        "Time": SPAN,
        "Depth (V)": 0.02 - 0.001 * STROKE,
        "Load (V)": 0.4 + 0.001 * PULL,
    }
    units = {"Depth (nm)": "nm", "Load (µN)": "µN", "Time": "s", "Depth (V)": "V", "Load (V)": "V"}
    plan = plan_of(Table("a", columns, units, "0" * 64), ColumnMap())
    assert plan.questions == ()
    assert {each.signal: each.column for each in plan.signals if each.column} == {
        "position": "Depth (nm)",
        "effort": "Load (µN)",
    }


@pytest.mark.parametrize("name", ["DMS 1", "Strain gauge 2", "DMS3"])
def test_a_strain_gauge_is_no_field(name: str) -> None:
    plan = _plan({name: 1e-3 * PULL + 1e-4 * np.sin(7.0 * SPAN)}, {name: "V"})
    assert plan.questions == ()
    assert _field(plan) == "none"


def test_the_output_of_a_controller_is_no_field_where_its_set_point_stands_beside_it() -> None:
    output = 0.1 * np.sin(4.0 * SPAN)
    units = {"Ch 1 Weg": "mm", "Ch 1 Kraft": "N", "Ch 1 Kraft Sollwert": "N", "Ch 1 Ausgang": "V"}
    columns = {
        "Zeit": SPAN,
        "Ch 1 Weg": STROKE,
        "Ch 1 Kraft": PULL,
        "Ch 1 Kraft Sollwert": PULL + 0.1,
        "Ch 1 Ausgang": output,
    }
    plan = plan_of(Table("a", columns, {"Zeit": "s", **units}, "0" * 64), ColumnMap())
    assert plan.questions == ()
    assert _field(plan) == "none"

    of_another = {"Ch 2 Ausgang": output}
    plan = _plan(of_another, {"Ch 2 Ausgang": "V"})
    assert plan.questions or plan.doubts or _field(plan) == "Ch 2 Ausgang"


@pytest.mark.parametrize("unit", ["segments", "unitless", "cycles"])
def test_what_counts_the_parts_of_a_test_is_no_field(unit: str) -> None:
    plan = _plan({"Ganzzahl": np.floor(SPAN)}, {"Ganzzahl": unit})
    assert plan.questions == ()
    assert _field(plan) == "none"


def test_the_i_of_a_controller_is_no_current() -> None:
    terms = {"P": 0.1 * PULL, "I": 0.01 * np.cumsum(PULL), "D": np.gradient(PULL)}
    plan = _plan({"Strom": 2.0 + (SPAN > 2.0), **terms}, {"Strom": "A"})
    assert plan.questions == ()
    assert _field(plan) == "Strom"
    alone = _plan({"I": 2.0 + (SPAN > 2.0)}, {})
    assert _field(alone) == "I"


@pytest.mark.parametrize("sign", ["\u00b5", "\u03bc", "u"])
def test_the_output_of_a_sensor_is_told_by_its_name_however_micro_is_written(sign: str) -> None:
    force = f"Load ({sign}N)"
    columns = {"Time": SPAN, "Depth": STROKE, force: PULL, "Load (V)": 0.5 + 0.01 * STROKE}
    units = {"Time": "s", "Depth": "nm", force: "uN", "Load (V)": "V"}
    plan = plan_of(Table("a", columns, units, "0" * 64), ColumnMap())
    assert plan.questions == ()
    assert plan.doubts == ()
    assert _field(plan) == "none"
