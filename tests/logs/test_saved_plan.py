"""A mapping that is written down reads the log as the guesses did, and names what is missing."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from erclutch.errors import ErclutchError, MappingError
from erclutch.logs import ColumnMap, apply, read, read_table
from erclutch.logs.planning.whole_plan import plan_of
from erclutch.logs.saved_plan import mapping_text, save_plan
from tests.support.damaged_text import damaged

HEADER = "t [ms],Y [V],V [cm/s],F [kN],D [cm]"


@pytest.fixture
def log(tmp_path: Path) -> Path:
    t = np.arange(50.0)
    rows = np.column_stack([t, t % 3.0, np.cos(t), 0.1 * np.sin(t), t])
    path = tmp_path / "l3g.csv"
    np.savetxt(path, rows, delimiter=",", header=HEADER, comments="")
    return path


CHOSEN = (
    {
        "columns": {"slip": "-V [cm/s]", "effort": {"column": 4, "unit": "N", "scale": 2.5}},
        "inputs": ["D [cm]"],
    },
    {
        "columns": {"slip": "V"},
        "rate": 500.0,
        "invalid": "drop",
        "constants": {"mass": "2 kg"},
        "lead": "10 mm",
    },
    {
        "scales": {"effort": "2.5 N/kN"},
        "columns": {"slip": "V", "effort": "F [kN]"},
        "name_pattern": "l{kind}g",
    },
)


@pytest.mark.parametrize("chosen", CHOSEN)
def test_a_written_mapping_reads_the_same_log(
    log: Path, tmp_path: Path, chosen: dict[str, object]
) -> None:
    own = ColumnMap.from_dict(chosen)
    table = read_table(log)
    plan = plan_of(table, own)
    assert plan.questions == ()
    assert {"slip", "effort", "field"} <= set(plan.choices)
    save_plan(plan, tmp_path / "own.toml")
    again = ColumnMap.from_toml(tmp_path / "own.toml")
    assert (again.rate, again.lead, again.name_pattern, again.variable, again.invalid) == (
        own.rate, own.lead, own.name_pattern, own.variable, own.invalid,
    )  # fmt: skip
    assert (again.constants, again.scales) == (own.constants, own.scales)
    assert [c.column for c in again.inputs] == [c.column for c in own.inputs]
    assert plan_of(table, again) == plan
    one, other = apply(plan, table), read(log, mapping_file=tmp_path / "own.toml")
    for name, values in one.signals.items():
        np.testing.assert_array_equal(values, other.signals[name])
    assert (one.period, one.units, one.constants) == (other.period, other.units, other.constants)
    assert list(one.extras) == list(other.extras)


def test_the_text_itself(log: Path) -> None:
    text = mapping_text(plan_of(read_table(log), ColumnMap.from_dict(CHOSEN[0])))
    assert text.splitlines() == [
        "# How l3g.csv is read (single device). All keys: documentation of erclutch.logs.mapping.",
        'time = {column = "t", unit = "ms"}  # guessed from its name or unit',
        'inputs = ["D [cm]"]',
        "",
        "[columns]",
        'field = {column = "Y", unit = "V"}  # guessed from its unit',
        'slip = {column = "V", unit = "cm/s", scale = -1.0}  # given',
        '# position = {column = "D", unit = "cm"}  # guessed from its name',
        'effort = {column = "F", unit = "N", scale = 2.5}  # given',
    ]


def test_what_is_missing_is_named_and_commented_out(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text(
        "q,\x07r [V]\n" + "\n".join(f"{k},{k % 7}" for k in range(50)), encoding="utf-8"
    )
    plan = plan_of(read_table(path), ColumnMap())
    text = mapping_text(plan)
    assert len(plan.questions) >= 2
    assert "time" not in plan.choices
    for key in ("time", "effort"):
        assert f"# {key} = " in text
    assert all(line.startswith(("#", "[", "field")) or not line for line in text.splitlines())
    assert all(letter.isprintable() or letter == "\n" for letter in text)


def test_a_mapping_of_the_user_is_never_written_over(log: Path, tmp_path: Path) -> None:
    own = tmp_path / "own.toml"
    own.write_text("mine", encoding="utf-8")
    plan = plan_of(read_table(log), ColumnMap())
    with pytest.raises(MappingError, match="there is such a file"):
        save_plan(plan, own)
    assert own.read_text(encoding="utf-8") == "mine"
    with pytest.raises(MappingError, match="cannot be written"):
        save_plan(plan, tmp_path / "nowhere" / "own.toml")


@pytest.mark.slow
def test_thousands_of_damaged_mapping_files(log: Path, tmp_path: Path) -> None:
    """Each is read, or refused in one line that names the file; every tenth that is read also reads the log."""
    rng = np.random.default_rng(5)
    own = tmp_path / "own.toml"
    texts = [
        mapping_text(plan_of(read_table(log), ColumnMap.from_dict(chosen))).encode()
        for chosen in CHOSEN
    ]
    read_well, refused = 0, list[str]()
    for k in range(7_500):
        own.write_bytes(damaged(texts[k % 3], rng))
        try:
            found = ColumnMap.from_toml(own)
            if read_well % 10 == 0:
                read(log, found)
            read_well += 1
        except ErclutchError as error:
            refused.append(str(error))
    assert min(read_well, len(refused)) > 500
    assert not [
        said for said in refused if "\n" in said or not (own.name in said or log.name in said)
    ]
