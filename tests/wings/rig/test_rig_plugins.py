"""Rigs of other packages: found by name, named where they fail."""

from __future__ import annotations

import pytest

from erclutch.errors import PluginError, SettingError
from erclutch.wings.rig.rig_plugins import UdpRig, hardware
from tests.support.installed_plugin import Install


@pytest.mark.slow
@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("def rig():\n    raise OSError('not plugged\\n in')", "failed: OSError: not plugged in"),
        ("def rig():\n    return 5", "returns a int; it must return a UdpRig"),
        ("rig = 5", "is of type int, it must be Callable"),
        ("import nothing_of_this_name", "cannot be loaded: ModuleNotFoundError"),
        ("import sys\nsys.exit(3)", "cannot be loaded: SystemExit: 3"),
        ("", "cannot be loaded: AttributeError"),
    ],
)
def test_a_rig_that_fails_is_named(install: Install, text: str, said: str) -> None:
    install("my-bench", "[erclutch.rigs]\nmine = my_bench:rig\n", text)
    with pytest.raises(PluginError, match=r"the rig .mine. of my-bench 1\.5") as caught:
        hardware("mine")
    assert said in str(caught.value)
    assert "pip uninstall my-bench" in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.slow
def test_a_rig_comes_by_name(install: Install) -> None:
    text = (
        "from erclutch.wings.rig.rig_plugins import UdpRig\n"
        "def rig():\n    return UdpRig('mine', '10.0.0.1', 5005, 3)\n"
    )
    install("my-bench", "[erclutch.rigs]\nmine = my_bench:rig\n", text)
    assert hardware("mine") == UdpRig("mine", "10.0.0.1", 5005, 3)
    with pytest.raises(
        SettingError, match=r"unknown rig 'yours'.*Known are twin, twin-brake, replay, udp, mine"
    ):
        hardware("yours")


@pytest.mark.parametrize(
    "wrong",
    [
        {"channels": {"speed": "x"}},
        {"channels": {"position": "wheel"}},
        {"device": "single", "channels": {"field2": "x"}},
        {"device": "single", "channels": {"position": "wheel [deg]"}},
        {"device": "single", "channels": {"effort": "[N]"}},
        {"device": "triple"},
        {"field_limit": 0.0},
        {"field_limit": float("nan")},
    ],
)
def test_a_rig_that_cannot_be(wrong: dict[str, object]) -> None:
    with pytest.raises(SettingError):
        UdpRig("mine", "10.0.0.1", 5005, **wrong)  # pyright: ignore[reportArgumentType]
