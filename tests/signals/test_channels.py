"""Channels: a device names the numbers of a session once; what a rig calls them is read, or refused in one line."""

from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from erclutch.errors import ErclutchError
from erclutch.signals.channels import ROLES, channels_of, named, wired
from erclutch.signals.device import DEVICES, DeviceName, Units
from erclutch.signals.units import is_written_well


def test_a_damper_has_one_field_one_slip_and_one_effort() -> None:
    found = {c.name: c.unit for c in channels_of("single", Units("N", "V", "m/s"), motor=False)}
    assert found == {
        "position": "m",
        "slip": "m/s",
        "field": "V",
        "effort": "N",
        "estimate": "N",
        "reference": "",
    }
    assert channels_of("single", Units("N", "V", "m/s"))[3].unit == "N"  # what drives it pulls


def test_the_words_of_a_rig() -> None:
    words = {"position": "flywheel angle [rad]", "field": "coil current [A]", "drive": "motor"}
    found = named("single", words)
    assert found.units == Units("?", "A", "rad/s")
    assert (found.motor, found.sensor) == (True, False)
    texts = [
        str(channel) for channel in found.of(channels_of("single", found.units, motor=found.motor))
    ]
    assert texts[0] == "position = flywheel angle [rad]"
    assert texts[2:4] == ["field = coil current [A]", "drive = motor [N*m]"]
    assert texts[4] == "estimate [?]"  # no sensor: no effort


def test_a_drive_keeps_its_unit_where_the_effort_has_another() -> None:
    found = named(
        "single", {"effort": "force [N]", "drive": "motor torque [N*m]", "field": "coil [A]"}
    )
    units = {c.name: c.unit for c in found.of(channels_of("single", found.units))}
    assert (units["effort"], units["drive"]) == ("N", "N*m")


def test_channels_of_one_kind_have_one_unit() -> None:
    assert named("coaxial", {"field1": "coil [V]", "field2": "other coil [V]"}).units.field == "V"
    with pytest.raises(ErclutchError, match="is in V, and another field in A"):
        named("coaxial", {"field1": "coil [A]", "field2": "volts [V]"})
    with pytest.raises(ErclutchError, match="'alpha' is in m"):  # the pair turns
        named("coaxial", {"alpha": "table [m]"})


@pytest.mark.slow
@settings(deadline=None)  # the first unit that is no common one loads pint
@given(
    st.sampled_from(DEVICES),
    st.dictionaries(st.sampled_from([*wired("single"), *wired("coaxial"), "x"]), st.text(max_size=12) | st.sampled_from(
        ["a [rad]", "b [N m]", "c [N]", "d [A]", "e [mm]", "f [°C]", "g []", "[h]", "i [2 rad]", "j [rad] k"]
    ), max_size=4),
)  # fmt: skip
def test_any_words_are_read_or_refused(device: DeviceName, words: dict[str, str]) -> None:
    try:
        found = named(device, words)
    except ErclutchError:
        return
    channels = found.of(channels_of(device, found.units, motor=found.motor))
    assert set(words) - {"effort", "torque"} <= {c.name for c in channels}
    assert len({c.name for c in channels}) == len({c.slot for c in channels}) == len(channels)
    assert all(c.role in ROLES and is_written_well(c.unit) and c.label for c in channels)
