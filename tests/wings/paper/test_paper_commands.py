"""What an author of a paper types: `erclutch table`; and names of scenarios and experiments that are misspelt."""

from __future__ import annotations

from pathlib import Path

import pytest

from erclutch.cli.commands.table import table
from erclutch.errors import RunError, SettingError
from tests.support.command import refused


def test_what_a_table_cannot_be(tmp_path: Path) -> None:
    with pytest.raises(RunError, match="not a run"):
        table(tmp_path)
    with pytest.raises(SettingError, match="--most 0"):
        table(tmp_path, most=0)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("simulate", "sines"), "there is no scenario 'sines'. Did you mean sine?"),
        (("experiment", "trackin"), "there is no experiment 'trackin'. Did you mean tracking?"),
    ],
    ids=["simulate", "experiment"],
)
def test_a_misspelt_name_is_told_with_the_nearest(
    words: tuple[str, ...], said: str, tmp_path: Path
) -> None:
    assert said in refused(*words, cwd=tmp_path)
