"""What an author of a paper types: `erclutch table` and `erclutch cite`."""

from __future__ import annotations

from pathlib import Path

import pytest

from erclutch.cli.commands.cite import AUTHORS, PAPER, PAPER_AUTHORS, cite
from erclutch.cli.commands.table import table
from erclutch.errors import RunError, SettingError

ROOT = Path(__file__).resolve().parents[3]


def test_a_citation_says_what_the_file_says(capsys: pytest.CaptureFixture[str]) -> None:
    text = " ".join((ROOT / "CITATION.cff").read_text(encoding="utf-8").split())
    assert f"title: {PAPER}" in text
    assert f"- name: {AUTHORS} " in text
    assert all(f"family-names: {name}" in text for name in PAPER_AUTHORS)
    cite(to="bibtex")
    printed = capsys.readouterr().out
    assert printed.count("@") == 2
    assert printed.count("{") == printed.count("}")
    version = text.partition(" version: ")[2].partition(" ")[0]
    assert f"version = {{{version}}}" in printed


def test_what_a_table_cannot_be(tmp_path: Path) -> None:
    with pytest.raises(RunError, match="not a run"):
        table(tmp_path)
    with pytest.raises(SettingError, match="--most 0"):
        table(tmp_path, most=0)
