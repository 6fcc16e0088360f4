"""A text that is read in blocks is read as the same text is read whole, or it is refused.

The data are SYNTHETIC.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from erclutch.errors import LogError
from erclutch.logs import read, read_batches
from tests.support.slow_params import slow_but

pytestmark = pytest.mark.slow

TIME = np.arange(12_000) / 1000
SPEED = 5 * np.sin(9 * TIME)
TORQUE = np.tanh(SPEED)


def tidy() -> str:
    rows = (
        f"{t},speed,{w:.5f}\n{t},torque,{f:.5f}\n"
        for t, w, f in zip(TIME, SPEED, TORQUE, strict=True)
    )
    return "time [s],signal,value\n" + "".join(rows)


def with_senses() -> str:
    rows = (
        f"{t},{abs(w):.5f},{f:.5f},{'forward' if w >= 0 else 'reverse'}\n"
        for t, w, f in zip(TIME, SPEED, TORQUE, strict=True)
    )
    return "time [s],speed [rad/s],torque [Nm],direction\n" + "".join(rows)


def woven() -> str:
    rows = (
        f"{t},{w:.5f},\n{t + 0.0005},,{f:.5f}\n"
        for t, w, f in zip(TIME, SPEED, TORQUE, strict=True)
    )
    return "time [s],speed [rad/s],torque [Nm]\n" + "".join(rows)


def with_units_in_cells() -> str:
    rows = (
        f"{t:.4f} s;{1000 * w:.3f} mrad/s;{f:.5f} Nm\n"
        for t, w, f in zip(TIME, SPEED, TORQUE, strict=True)
    )
    return "time;speed;torque\n" + "".join(rows)


def stamped() -> str:
    rows = (
        f"{int(t)},{round(t % 1 * 1e9)},{w:.5f},{f:.5f}\n"
        for t, w, f in zip(TIME, SPEED, TORQUE, strict=True)
    )
    return "stamp.sec,stamp.nanosec,speed [rad/s],torque [Nm]\n" + "".join(rows)


@pytest.mark.parametrize(
    "text",
    slow_but(
        (woven, stamped),
        (tidy, with_senses, woven, with_units_in_cells, stamped),
    ),
)
def test_what_is_put_right_in_a_text_that_is_read_whole_is_not_read_otherwise_in_blocks(
    tmp_path: Path, text
) -> None:  # type: ignore[no-untyped-def]
    path = tmp_path / "log.csv"
    path.write_text(text())
    whole = read(path)
    try:
        blocks = list(read_batches(path, rows=10_000))
    except LogError as error:
        assert "--memory" in error.remedy  # noqa: PT017
        return
    first = blocks[0].recording
    assert np.array_equal(first.signals["slip"], whole.signals["slip"][: first.rows])
    assert np.allclose(first.signals["effort"], whole.signals["effort"][: first.rows])


def test_a_plain_text_is_read_in_blocks_as_it_is_read_whole(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    rows = (f"{t},{w:.5f},{f:.5f}\n" for t, w, f in zip(TIME, SPEED, TORQUE, strict=True))
    path.write_text("time [s],speed [rad/s],torque [Nm]\n" + "".join(rows))
    blocks = list(read_batches(path, rows=10_000))
    assert blocks[-1].stop == 12_000
    assert np.array_equal(
        blocks[0].recording.signals["slip"], read(path).signals["slip"][: blocks[0].recording.rows]
    )
