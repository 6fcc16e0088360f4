"""`erclutch flowcurve` as a user meets it."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from tests.support.command import good, refused


@pytest.mark.slow
def test_flowcurve(tmp_path: Path) -> None:
    rates = np.logspace(-2, 2, 25)
    rows = "".join(f"{r:.6g},{5 + 2 * r**0.5:.6g}\n" for r in rates)
    (tmp_path / "curve.csv").write_text("sample A,\n" + rows)
    # A table of words needs no law of many parameters; the answer in JSON below has all of them.
    few = ("--laws", "bingham", "herschel-bulkley")
    said = good("flowcurve", "curve.csv", "--parameters", *few, cwd=tmp_path)
    assert "Chosen for: herschel-bulkley 1 of 1" in said
    assert "Pa*s^m" in said
    body = json.loads(good("flowcurve", "curve.csv", "--json", cwd=tmp_path))
    assert body[0]["curve"] == "sample A"
    assert body[0]["points"] == 25
    assert body[0]["fits"][0]["law"] == "herschel-bulkley"
    only = json.loads(good("flowcurve", "curve.csv", "--json", "--laws", "bingham", cwd=tmp_path))
    assert [fit["law"] for fit in only[0]["fits"]] == ["bingham"]


def test_a_file_that_is_not_there(tmp_path: Path) -> None:
    assert "gone.csv: there is no such file" in refused("flowcurve", "gone.csv", cwd=tmp_path)
