"""Rigs of ours: a file each in `wings/live/rigs`, found by name."""

from __future__ import annotations

import pytest

from erclutch import registry
from erclutch.errors import SettingError
from erclutch.wings.live.offered_rig import OfferedRig, offered_rig
from erclutch.wings.rig.rig_plugins import GROUP, hardware


def test_our_rigs_are_found_by_their_files() -> None:
    ours = [plugin for plugin in registry.plugins(GROUP) if plugin.own]
    by_place = sorted(ours, key=lambda plugin: plugin.value.place)
    assert [plugin.name for plugin in by_place] == ["twin", "twin-brake", "replay", "udp"]
    assert all(isinstance(plugin.value, OfferedRig) for plugin in ours)


def test_a_rig_that_is_not_ours_is_looked_for_among_the_plug_ins() -> None:
    assert offered_rig("mine") is None
    with pytest.raises(
        SettingError, match=r"unknown rig 'mine'.*Known are twin, twin-brake, replay, udp"
    ):
        hardware("mine")


def test_a_recording_can_neither_learn_nor_stand_for_the_twin() -> None:
    replay = offered_rig("replay")
    assert replay is not None
    assert not replay.learns
    assert not replay.is_twin
