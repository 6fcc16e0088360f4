"""The report's advice about an empty range is a command, and the command fills the range."""

from __future__ import annotations

import re
import shlex
from html import unescape
from pathlib import Path

import numpy as np
import pytest

import erclutch
from erclutch.signals.array import Array, Mask
from erclutch.wings.design.limits import limits_of_log
from tests.support.command import good


def write_empty_log(path: Path) -> None:
    """A SYNTHETIC log whose field is large only while the slip is: most of the range is empty."""
    time = np.arange(4000) / 200.0
    slip = 5.0 * np.sin(2.0 * np.pi * 0.7 * time)
    field = 2.0 * (slip / 5.0) ** 2
    effort = (
        3.0 * field * np.tanh(slip)
        + 0.1 * slip
        + 0.01 * np.random.default_rng(0).standard_normal(time.size)
    )
    header = "time [s],field [A],slip [rad/s],effort [N*m]"
    np.savetxt(
        path,
        np.column_stack([time, field, slip, effort]),
        delimiter=",",
        comments="",
        header=header,
    )


@pytest.mark.slow
def test_more_than_half_of_the_range_empty_is_followed_by_the_command_that_fills_it(
    tmp_path: Path,
) -> None:
    write_empty_log(tmp_path / "empty.csv")
    good("fit", "empty.csv", "--models", "bingham", "--lag", "none", "--out", "a run", cwd=tmp_path)
    good("report", "a run", cwd=tmp_path)
    text = unescape((tmp_path / "a run" / "report.html").read_text(encoding="utf-8"))
    assert "At the fields of the log more than half of the slip's range holds no row" in text
    command = re.search(r"erclutch (excite --run [^<\n]*)", text)
    assert command is not None
    good(*shlex.split(command[1]), "--seconds", "20", cwd=tmp_path)

    log = erclutch.build_dataset(erclutch.read(tmp_path / "empty.csv"))
    rows: Array = np.genfromtxt(tmp_path / "next.csv", delimiter=",", skip_header=1)
    known = limits_of_log(log)
    edges = np.linspace(0.0, known["field"], 9), np.linspace(-known["speed"], known["speed"], 9)

    def cells(field: Array, slip: Array) -> Mask:
        return np.histogram2d(field, slip, edges)[0] > 0.0

    before = cells(log.elements[0].field, log.elements[0].slip)
    after = before | cells(rows[:, 1], rows[:, 2])
    assert before.mean() < 0.5
    assert after.mean() > before.mean() + 0.3
