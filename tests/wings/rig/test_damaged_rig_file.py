"""A file of a rig that is damaged is read, or refused in one line that names it."""

from __future__ import annotations

from importlib import resources
from pathlib import Path

import numpy as np
import pytest

from erclutch.errors import ErclutchError
from erclutch.wings.rig.twin.parameters import load_rig
from tests.support.damaged_text import damaged


@pytest.mark.slow
def test_thousands_of_damaged_rig_files(tmp_path: Path) -> None:
    rng = np.random.default_rng(5)
    path = tmp_path / "rig.toml"
    whole = (resources.files("erclutch.wings.rig.twin") / "default.toml").read_bytes()
    read_well, refused = 0, list[str]()
    for _ in range(2_500):
        path.unlink(
            missing_ok=True
        )  # a disk waits for what it still writes before it empties a file
        path.write_bytes(damaged(whole, rng))
        try:
            load_rig(path)
            read_well += 1
        except ErclutchError as error:
            refused.append(str(error))
    # Both happen often: damage in a comment or a digit is read, damage in a name is refused.
    assert min(read_well, len(refused)) > 200
    assert not [said for said in refused if "\n" in said or path.name not in said]
