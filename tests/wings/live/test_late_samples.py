"""Samples that come late are no fault of a sensor, and a fault is seen in time although samples come late. TWIN.

The clock is counted, so no machine has to be quick.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from erclutch.signals.device import DeviceName
from erclutch.wings.live.layout import EVENT_BITS
from erclutch.wings.live.session import LiveModel
from erclutch.wings.rig.twin.parameters import default_rig
from tests.support.healthy_sessions import sessions
from tests.support.late_samples import LATE, frames_of_late
from tests.support.sensor_faults import ZERO_WITHIN, model_of, settings_of

pytestmark = pytest.mark.slow

RIG = default_rig()
ROWS = 1500
BEGINS = 700  # the row of a fault


def pauses(seed: int, first: int = 200, each: int = 60) -> list[tuple[int, int]]:
    """Pauses of 5 to 19 rows: a twentieth row would trip the loop."""
    rng = np.random.default_rng(seed)
    return [
        (row + int(rng.integers(30)), int(rng.integers(5, 20)))
        for row in range(first, ROWS - each, each)
    ]


def trips(frames: Any) -> list[str]:
    """Events of the frames before a trip; none without a trip."""
    rows = np.flatnonzero(frames["events"] & EVENT_BITS["trip"])
    if not rows.size:
        return []
    said = int(np.bitwise_or.reduce(frames["events"][max(rows[0] - 20, 0) : rows[0] + 1]))
    return [name for name, bit in EVENT_BITS.items() if said & bit]


@pytest.fixture(scope="module")
def pair() -> LiveModel:
    """Bingham's law, fitted to the TWIN's pair."""
    return model_of(RIG, "bingham", "coaxial")


@pytest.mark.parametrize("late", LATE)
def test_late_samples_trip_no_healthy_pair(late: str, pair: LiveModel) -> None:
    """The torque of one sample was compared with the motion of several, as if they were of one period."""
    settings = next(
        settings
        for settings, name in sessions("coaxial", pair, observer="sensor")
        if name == "torque-step"
    )
    frames = frames_of_late(settings, pair.library, RIG, late, pauses(1), rows=ROWS)
    assert np.any(frames["events"] & EVENT_BITS["overrun" if late == "loop" else "sample-lost"])
    assert not trips(frames)


@pytest.mark.parametrize("late", LATE)
@pytest.mark.parametrize("device", ["coaxial", "single"])
def test_late_samples_trip_no_program_of_a_healthy_device(device: DeviceName, late: str) -> None:
    model = model_of(RIG, "bingham", device)
    for observer in ("off", "sensor"):
        for settings, program in sessions(device, model, observer=observer):
            frames = frames_of_late(settings, model.library, RIG, late, pauses(2), rows=ROWS)
            assert not trips(frames), (program, observer)


@pytest.mark.parametrize("late", ["packets", "loop"])
@pytest.mark.parametrize(
    ("sensor", "kind"),
    [("torque", "1e30"), ("torque", "-5"), ("torque", "reversed"), ("theta", "0"), ("alpha", "5")],
)
def test_late_samples_hide_no_fault_of_a_sensor(
    sensor: str, kind: str, late: str, pair: LiveModel
) -> None:
    """Zero field within 20 ms of the fault, though samples come late before it and in the middle of its doubt."""
    settings = settings_of("torque", pair, RIG)
    for after, lasts in ((1, 15), (4, 10), (9, 9)):
        paused = [(BEGINS - 40, 12), (BEGINS + after, lasts)]
        fault = sensor, kind, BEGINS
        frames = frames_of_late(
            settings, pair.library, RIG, late, paused, rows=BEGINS + 150, fault=fault
        )
        on = np.flatnonzero(frames["field1"] + frames["field2"])
        zero = int(frames["seq"][on[-1] + 1]) - BEGINS  # for good
        assert 0 < zero <= ZERO_WITHIN, (after, lasts)
        assert trips(frames)


@pytest.mark.parametrize(("after", "lasts"), [(1, 5), (1, 15), (4, 10)])
def test_a_meter_that_was_turned_while_samples_were_lost_has_been_wrong_since(
    after: int, lasts: int, pair: LiveModel
) -> None:
    """Torque and motion are compared anew when the filters have settled. Only from then on the doubt was counted."""
    settings = settings_of("torque", pair, RIG)
    fault, paused = ("torque", "reversed", BEGINS), [(BEGINS - 40, 12), (BEGINS + after, lasts)]
    frames = frames_of_late(
        settings, pair.library, RIG, "lost", paused, rows=BEGINS + 100, fault=fault
    )
    on = np.flatnonzero(frames["field1"] + frames["field2"])
    zero = int(frames["seq"][on[-1] + 1]) - BEGINS
    assert zero - (after + lasts) <= 20, "of the first sample that came again"  # it was 26


@pytest.mark.parametrize("late", ["lost", "rig"])
def test_a_doubt_goes_on_while_no_sample_comes(late: str, pair: LiveModel) -> None:
    """It began anew after each pause: the field came back between, and was zero only 28 ms after the fault."""
    settings = settings_of("torque", pair, RIG)
    frames = frames_of_late(
        settings,
        pair.library,
        RIG,
        late,
        [(BEGINS + 3, 10)],
        rows=BEGINS + 100,
        fault=("torque", "100", BEGINS),
    )
    on = np.flatnonzero(frames["field1"] + frames["field2"])
    assert frames["seq"][on[-1] + 1] - BEGINS == 13
