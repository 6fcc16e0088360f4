"""What an author of a paper types: `erclutch table`."""

from __future__ import annotations

from pathlib import Path

import pytest

from erclutch.cli.commands.table import table
from erclutch.errors import RunError, SettingError


def test_what_a_table_cannot_be(tmp_path: Path) -> None:
    with pytest.raises(RunError, match="not a run"):
        table(tmp_path)
    with pytest.raises(SettingError, match="--most 0"):
        table(tmp_path, most=0)
