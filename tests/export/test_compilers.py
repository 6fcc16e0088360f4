"""Which compilers of this machine are taken, and in which order."""

from __future__ import annotations

import pytest

from erclutch.export.c import compilers


@pytest.mark.parametrize(
    ("there", "chosen", "zig", "expected"),
    [
        ({"gcc", "clang", "cc"}, "", False, ["gcc", "clang"]),
        ({"cc"}, "", False, ["cc"]),
        ({"clang", "cc"}, "", True, ["clang", "zig"]),
        ({"gcc", "clang"}, "clang -O1", False, ["clang", "gcc"]),
        ({"gcc", "own"}, "/opt/own", False, ["gcc"]),
        ({"gcc", "/opt/own"}, "/opt/own -m64", False, ["own", "gcc"]),
        (set(), "", True, ["zig"]),
        (set(), "", False, []),
    ],
)
def test_compilers_in_their_order(
    there: set[str], chosen: str, zig: bool, expected: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("CC", chosen)
    monkeypatch.setattr(compilers.shutil, "which", lambda name: name if name in there else None)
    monkeypatch.setattr(
        compilers.importlib.util, "find_spec", lambda name: object() if zig else None
    )
    found = compilers.natives.__wrapped__()
    assert [compiler.name for compiler in found] == expected
    if chosen and chosen.split()[0] in there:
        assert found[0].command == tuple(chosen.split())
    if zig:
        assert found[-1].flags == ("-mcpu=baseline",)
