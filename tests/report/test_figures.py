"""Figures: real files in the format asked for, the numbers beside them, the same bytes twice, and clear refusals."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest

from erclutch.errors import RunError
from erclutch.logs.dataset import build_dataset
from erclutch.report.plots.log_plots import describe_coverage, describe_section
from erclutch.report.plots.matplotlib_painter import save_plot
from erclutch.signals.device import EFFORT_OF, DeviceName
from tests.support.pair import pair_log, single_log
from tests.support.slow_params import slow_but

pytestmark = pytest.mark.slow

MAGIC = {".png": b"\x89PNG", ".pdf": b"%PDF", ".svg": b"<?xml"}


@pytest.mark.parametrize("suffix", slow_but((".svg",), sorted(MAGIC)))
@pytest.mark.parametrize("device", slow_but(("coaxial",), ("coaxial", "single")))
def test_section_and_coverage(tmp_path: Path, suffix: str, device: DeviceName) -> None:
    log = pair_log(2.0) if device == "coaxial" else single_log(2.0)
    section = save_plot(describe_section(log, start=0.5, seconds=0.25), tmp_path / f"s{suffix}")
    data = build_dataset(log, device=device)
    coverage = save_plot(describe_coverage(data, log.name), tmp_path / f"c{suffix}")
    for picture, numbers in (section, coverage):
        assert picture.read_bytes().startswith(MAGIC[suffix])
        assert numbers.suffix == ".csv"
    with section[1].open() as file:
        rows = list(csv.DictReader(file))
    effort = EFFORT_OF[device]
    assert len(rows) == 250
    np.testing.assert_allclose(
        [float(r[effort]) for r in rows], log.signals[effort][500:750], rtol=1e-8
    )
    with coverage[1].open() as file:
        counts = [int(r["rows"]) for r in csv.DictReader(file)]
    assert sum(counts) == log.rows * len(data.elements)
    assert sorted(p.name for p in tmp_path.iterdir()) == sorted(
        p.name for p in (*section, *coverage)
    )


def test_the_same_log_gives_the_same_bytes(tmp_path: Path) -> None:
    log = pair_log(1.0)
    for suffix in MAGIC:
        first, second = (
            save_plot(describe_section(log), tmp_path / f"{n}{suffix}")[0].read_bytes()
            for n in "ab"
        )
        assert first == second, suffix


def test_what_cannot_be_drawn(tmp_path: Path) -> None:
    log = pair_log(1.0)
    with pytest.raises(RunError, match=r"cannot end in '.gif'"):
        save_plot(describe_section(log), tmp_path / "a.gif")
    (tmp_path / "file").write_text("")
    with pytest.raises(RunError, match="cannot be written"):
        save_plot(describe_section(log), tmp_path / "file" / "a.png")
