"""A log of the TWIN says which device it is of, so nobody has to: in a text and in Parquet."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.support.command import good


@pytest.mark.slow
@pytest.mark.parametrize(("scenario", "device"), [("training", "coaxial"), ("brake", "single")])
@pytest.mark.parametrize("ending", ["csv", "parquet"])
def test_a_log_of_the_twin_is_understood_at_once(
    tmp_path: Path, scenario: str, device: str, ending: str
) -> None:
    log = tmp_path / f"log.{ending}"
    good("simulate", scenario, "--seconds", "1", "--out", log)
    said = " ".join(good("inspect", log).split())
    assert f"a log of the TWIN, which says that it is of a {device} device" in said
    assert "Understood. Fit it: erclutch fit" in said
