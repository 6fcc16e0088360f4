"""A recording of the live loop says which device it is of, and offers nothing that the loop made up as an input."""

from __future__ import annotations

import json

import numpy as np
import pytest

from erclutch.errors import MappingError
from erclutch.logs import ColumnMap, Table, apply, plan_of
from erclutch.logs.dataset import build_dataset
from erclutch.signals.channels import channels_of
from erclutch.signals.device import DeviceName

ROWS = np.arange(200.0)
STATES = ("flags", "events", "lateness_ns", "step_ns")


def recording(device: DeviceName, *, about: bool = True) -> Table:
    names = [channel.name for channel in channels_of(device)]
    columns = {name: np.sin(ROWS / (3 + place)) for place, name in enumerate(names)}
    columns |= {name: ROWS % (2 + place) for place, name in enumerate(STATES)}
    units = {each.name: each.unit for each in channels_of(device) if each.unit not in ("?", "")}
    metadata = {
        "erclutch": json.dumps({"label": "TWIN", **{f"channel.{name}": name for name in names}})
    }
    return Table(
        "run.mcap", columns, units, "0" * 64, clock=ROWS / 1000, metadata=metadata if about else {}
    )


@pytest.mark.parametrize(
    ("device", "signals"), [("single", {"field", "effort"}), ("coaxial", {"E1", "E2", "T"})]
)
def test_the_device_stands_in_the_recording(device: DeviceName, signals: set[str]) -> None:
    table = recording(device)
    assert table.device == device
    plan = plan_of(table, ColumnMap())
    assert plan.questions == ()
    log = apply(plan, table)
    assert signals <= set(log.signals)
    assert f"a recording of the live loop: its channels are those of a {device} device" in log.notes
    assert build_dataset(log).device == device


def test_what_the_loop_made_up_is_no_spare_column() -> None:
    table = recording("single")
    assert not {*plan_of(table, ColumnMap()).spare} & {*STATES, "estimate", "reference"}


def test_a_device_that_is_named_goes_first_and_other_logs_are_of_a_single_device() -> None:
    with pytest.raises(
        MappingError, match=r"field may be any of the columns field1, field2.*--device coaxial"
    ):
        apply(plan_of(recording("coaxial"), ColumnMap(), device="single"), recording("coaxial"))
    assert recording("coaxial", about=False).device is None
    assert plan_of(recording("coaxial", about=False), ColumnMap()).device == "single"


@pytest.mark.parametrize(
    ("device", "of_the_log"),
    [
        ("single", {"field": "Current", "slip": "-Velocity [cm/s]", "effort": "Force"}),
        ("coaxial", {"E1": "U1 [V]", "E2": "U2 [V]", "T": "Torque", "theta": "Motor angle"}),
    ],
)
def test_columns_of_the_log_that_a_run_was_fitted_to_give_way_to_its_channels(
    device: DeviceName, of_the_log: dict[str, str]
) -> None:
    """`score RECORDING --run RUN` asked for columns that only the log of the run has."""
    table = recording(device)
    plan = plan_of(table, ColumnMap.from_labels(of_the_log))
    assert plan.questions == ()
    own = plan_of(table, ColumnMap())
    assert [(each.signal, each.column) for each in plan.signals] == [
        (each.signal, each.column) for each in own.signals
    ]
    assert any("the recording's own channel; it has no column" in note for note in plan.notes)
    # A temperature that is not is asked for.
    assert plan_of(table, ColumnMap.from_labels({"temperature": "Oil"})).questions
