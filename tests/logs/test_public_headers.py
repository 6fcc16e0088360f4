"""Headers as they stand in public repositories are understood; what is none of ours is left alone."""

from __future__ import annotations

import tomllib
from pathlib import Path

import numpy as np
import pytest

from erclutch.errors import MappingError
from erclutch.logs.columns.candidates import candidates
from erclutch.logs.columns.labels import name_columns
from erclutch.logs.columns.seen_columns import seen_columns
from erclutch.logs.planning.one_of_several import guess
from erclutch.logs.table import Table

pytestmark = pytest.mark.slow

FILES = tomllib.loads(Path(__file__).with_name("public_headers.toml").read_text(encoding="utf-8"))[
    "file"
]


def table_of(labels: list[str]) -> Table:
    names, units, _ = name_columns(labels)
    columns = {name: np.arange(3.0) for name in names}
    return Table("log", columns, dict(zip(names, units, strict=True)), "")


def meanings(label: str) -> set[str]:
    """The signals that one column alone is taken for."""
    seen = seen_columns(table_of([label]))
    if seen.time_column():
        return {"time"}
    return {s for s in ("field", "slip", "position", "effort") if candidates(seen, s, ())[0]}


@pytest.mark.parametrize(("held_out", "least"), [(False, 0.92), (True, 0.9)])
def test_headers_of_public_data_are_understood(held_out: bool, least: float) -> None:
    cells = {
        label: want
        for file in FILES
        if file["held_out"] == held_out
        for label, want in file["headers"].items()
    }
    known = {label: want for label, want in cells.items() if want}
    understood = [label for label, want in known.items() if meanings(label) == {want}]
    wrong = {label: want for label, want in known.items() if meanings(label) - {want}}
    other = [label for label, want in cells.items() if not want and meanings(label)]
    print(
        f"\n{len(understood)} of {len(known)} understood; of {len(cells) - len(known)} others taken: {other}"
    )
    assert not wrong
    assert len(understood) >= least * len(known)
    assert len(other) <= 0.2 * (len(cells) - len(known))


def test_no_column_is_guessed_for_another_signal() -> None:
    """Whole rows of headers: a guess is right, or there is a question."""
    asked = right = 0
    for file in FILES:
        table = table_of(list(file["headers"]))
        wanted = dict(zip(table.columns, file["headers"].values(), strict=True))
        for signal in ("field", "slip", "position", "effort"):
            try:
                found = guess(seen_columns(table), signal, ())
            except MappingError:
                asked += 1
                continue
            if found is not None:
                assert wanted[str(found.column)] in (signal, ""), (
                    f"{file['path']}: {found.column} as {signal}"
                )
                right += wanted[str(found.column)] == signal
    print(f"\n{right} guessed, {asked} asked")
    assert right > 60
