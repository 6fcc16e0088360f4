"""The manifest of strangers' files names no repository that is kept for a judgement, nor one that is called like it."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
RESERVED = ROOT.parent / "shared" / "reserved.md"
_LONG = 8  # letters of a name that says more than a word of the field


def letters(name: str) -> str:
    return re.sub(r"[^a-z0-9]", "", name.lower())


def reserved_names(text: str) -> tuple[set[str], set[str]]:
    """Owners and names of the repositories in a text such as ``owner/name, Owner (a device)``, in small letters."""
    _, _, listed = text.partition("\n\n")[2].partition("\n\n")
    owners: set[str] = set()
    names: set[str] = set()
    for item in listed.split(","):
        first, *_ = item.split()
        owner, _, name = first.partition("/")
        owners.add(letters(owner))
        if name:
            names.add(letters(name))
    return owners, names


def like_reserved(repository: str, owners: set[str], names: set[str]) -> bool:
    owner, _, name = repository.partition("/")
    alike = any(len(each) >= _LONG and each in letters(name) for each in names)
    return letters(owner) in owners or alike


def test_names_and_owners_are_taken_from_the_text_and_found_again() -> None:
    text = "# Kept\n\nDo not open.\n\nme/Damper-Rig-Log, some-one\n(a brake), other/fr_id, last."
    owners, names = reserved_names(text)
    assert owners == {"me", "someone", "other", "last"}
    assert like_reserved("you/damper_rig_logs", owners, names)
    assert like_reserved("Some-One/anything", owners, names)
    assert not like_reserved("you/afridata", owners, names)


@pytest.mark.slow
@pytest.mark.skipif(
    not RESERVED.exists(), reason="needs ../shared/reserved.md, which is not part of the project"
)
def test_the_manifest_names_no_reserved_repository() -> None:
    owners, names = reserved_names(RESERVED.read_text(encoding="utf-8"))
    assert len(names) > 10
    manifest = tomllib.loads((ROOT / "studies" / "strangers.toml").read_text(encoding="utf-8"))
    listed = {entry["repository"] for entry in manifest["file"]}
    assert sorted(name for name in listed if like_reserved(name, owners, names)) == []
