"""A valve's flow rate is proposed as its slip, its pressure drop as its effort, and a fit finds the true numbers."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from erclutch.fit.comparison import Settings, compare
from erclutch.logs import read
from erclutch.logs.dataset import build_dataset
from tests.support.plans_of_columns import planned

ROWS = np.arange(1600.0)
FLOW = 6 * np.sin(2 * np.pi * ROWS / 97)  # L/min
VOLTAGE = np.repeat([0.0, 1.0, 2.0, 3.0], 400)  # kV
DROP = 0.8 * FLOW + (0.5 + 2.0 * VOLTAGE) * np.sign(FLOW)  # bar
TANK = 10.0 + 0.0 * ROWS
STAMPS = {"t [s]": ROWS / 200, "HV [kV]": VOLTAGE}


@pytest.mark.parametrize(
    ("flow", "before", "behind"),
    [
        ("Flow rate [l/min]", "Pressure in [bar]", "Pressure out [bar]"),
        ("Q [L/min]", "p1 [bar]", "p2 [bar]"),
        ("Volumenstrom [l/min]", "Druck vor Ventil [bar]", "Druck nach Ventil [bar]"),
    ],
)
def test_two_pressures_and_a_flow_rate_are_proposed(flow: str, before: str, behind: str) -> None:
    plan = planned({**STAMPS, flow: FLOW, before: TANK + DROP / 2, behind: TANK - DROP / 2})
    assert {question.signal for question in plan.questions} == {"slip", "effort"}
    command = plan.command().replace('"', "").replace("'", "")
    assert f"--slip {flow}" in command
    names = [label.partition(" [")[0] for label in (before, behind)]
    assert f"--effort {' - '.join(names)}" in command


@pytest.mark.parametrize("drop", ["Differential pressure [bar]", "dp [bar]", "Druckabfall [bar]"])
def test_one_pressure_drop_is_proposed_or_was_guessed(drop: str) -> None:
    plan = planned({**STAMPS, "flow [L/min]": FLOW, drop: DROP, "Tank [bar]": TANK})
    assert "--slip flow [L/min]" in plan.command().replace('"', "").replace("'", "")
    answered = planned(
        {**STAMPS, "flow [L/min]": FLOW, drop: DROP, "Tank [bar]": TANK},
        slip="flow [L/min]",
        effort=drop,
    )
    assert not answered.questions
    units = {each.signal: each.si for each in answered.signals}
    assert (units["slip"], units["effort"]) == ("m^3/s", "Pa")


def test_where_a_speed_is_logged_a_flow_rate_is_no_slip() -> None:
    speed = {"piston speed [mm/s]": 10 * FLOW, "flow [L/min]": FLOW, "force [N]": DROP}
    plan = planned({**STAMPS, **speed})
    assert not plan.questions
    assert {each.column for each in plan.signals if each.signal == "slip"} == {"piston speed"}


def test_two_flow_rates_are_proposed_as_nothing() -> None:
    plan = planned({**STAMPS, "flow [L/min]": FLOW, "leak flow [L/min]": FLOW, "dp [bar]": DROP})
    assert "L/min" not in plan.command()


@pytest.mark.slow
def test_a_valve_has_the_numbers_that_it_was_made_with(tmp_path: Path) -> None:
    path = tmp_path / "valve.csv"
    lines = ["t [s],HV [kV],Flow rate [l/min],p in [bar],p out [bar]"]
    for row in zip(STAMPS["t [s]"], VOLTAGE, FLOW, TANK + DROP / 2, TANK - DROP / 2, strict=True):
        lines.append(",".join(f"{number:.6g}" for number in row))
    path.write_text("\n".join(lines), encoding="utf-8")
    log = read(path, slip="Flow rate", effort="p in - p out")
    compared = compare(build_dataset(log), Settings(("bingham",), lag="none"))
    model = compared.entry("bingham").outcome
    numbers = {estimate.name: estimate.value for estimate in model.estimates}
    assert numbers["T_y"] == pytest.approx(6.0e5, rel=0.01)  # Pa at 3 kV
    assert numbers["eta"] == pytest.approx(0.8e5 / (1e-3 / 60), rel=0.01)  # Pa/(m^3/s)
    assert numbers["T_f"] == pytest.approx(0.5e5, rel=0.05)  # Pa
