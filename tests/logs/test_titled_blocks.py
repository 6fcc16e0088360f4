"""Tests under each other below one line of names are logs of their own, with what the title of each tells."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from erclutch.errors import MappingError
from erclutch.logs import read, read_all
from erclutch.logs.mapping import ColumnMap
from tests.support.command import good

pytestmark = pytest.mark.usefixtures("read_here")
TIME = np.arange(60) / 100
SLIP = 20 * np.sin(20 * TIME)
FIELDS = (0.0, 0.5, 1.0)
NAMES = "Time [s],Slip [rad/s],Torque [N m]"


def rows_at(field: float, mark: str = ",") -> str:
    efforts = (0.3 + 1.5 * field) * np.tanh(2 * SLIP)
    rows = zip(TIME, SLIP, efforts, strict=True)
    return "\n".join(f"{t:.2f}{mark}{slip:.4f}{mark}{effort:.4f}" for t, slip, effort in rows)


def fields_of(path: Path) -> list[float]:
    logs = read_all(path, ColumnMap())
    assert [log.signals["slip"].size for log in logs] == [TIME.size] * len(logs)
    for log in logs:
        largest = float(np.abs(log.signals["effort"]).max())
        assert largest == pytest.approx(0.3 + 1.5 * log.signals["field"][0], rel=1e-3)
    return [float(log.signals["field"][0]) for log in logs]


@pytest.mark.slow
@pytest.mark.parametrize(
    "title",
    [
        "Test {n}: current {field} A",
        "# Test {n}: current {field} A",  # as comments they were passed over in silence
        "\nRun {n} at {field} A,,",
        "I = {field} A,,",
        "=== {field} A ===",
        "Test {n}\nCoil current: {field} A",
    ],
)
def test_titles_below_one_line_of_names_part_the_tests(tmp_path: Path, title: str) -> None:
    text = NAMES + "\n"
    for n, field in enumerate(FIELDS, start=1):
        text += title.format(n=n, field=field) + "\n" + rows_at(field) + "\n"
    path = tmp_path / "tests.csv"
    path.write_text(text)
    assert fields_of(path) == [*FIELDS]


@pytest.mark.slow
def test_the_first_title_may_stand_above_the_names(tmp_path: Path) -> None:
    text = "Bench: 3\nTest 1: 0 A\n" + NAMES + "\n" + rows_at(0.0) + "\nTest 2: 0.5 A\n"
    path = tmp_path / "tests.csv"
    path.write_text(text + rows_at(0.5) + "\n")
    assert fields_of(path) == [0.0, 0.5]


@pytest.mark.slow
@pytest.mark.parametrize("has_names_each", [True, False])
def test_titles_may_have_a_decimal_comma(tmp_path: Path, has_names_each: bool) -> None:
    names = "Zeit [s]\tSchlupf [rad/s]\tDrehmoment [Nm]\n"
    text = "" if has_names_each else names
    for n, field in enumerate(FIELDS, start=1):
        current = str(field).replace(".", ",")
        text += f"Versuch {n}: Strom {current} A\n{names if has_names_each else ''}"
        text += rows_at(field, "\t").replace(".", ",") + "\n"
    path = tmp_path / "tests.txt"
    path.write_text(text)
    assert fields_of(path) == [*FIELDS]


@pytest.mark.slow
def test_titles_above_tables_tell_the_fields(tmp_path: Path) -> None:
    """The count of the tests stood in the way, and all three were read as logs at field 0."""
    blocks = [
        f"Test {n}: current {field} A\n{NAMES}\n{rows_at(field)}\n"
        for n, field in enumerate((0.0, 0.5, 0.5), start=1)
    ]
    path = tmp_path / "tests.csv"
    path.write_text("".join(blocks))
    assert fields_of(path) == [0.0, 0.5, 0.5]
    last = good("inspect", path.name, "--variable", "all", cwd=tmp_path).splitlines()[-1]
    assert last == "Understood. Fit it: erclutch fit tests.csv --variable all --out RUN"


@pytest.mark.slow
def test_what_stands_above_the_names_is_said_of_all_tests(tmp_path: Path) -> None:
    text = "Coil current: 2 A\nSampling rate: 100 Hz\nSlip [rad/s],Torque [N m]\n"
    for n in (1, 2):
        rows = [row.partition(",")[2] for row in rows_at(2.0).splitlines()]
        text += f"Test {n}\n" + "\n".join(rows) + "\n"
    path = tmp_path / "tests.csv"
    path.write_text(text)
    assert fields_of(path) == [2.0, 2.0]


@pytest.mark.parametrize("remark", ["# lost 3 packets", "# buffer 7 full", "# rest"])
def test_remarks_between_rows_part_nothing(tmp_path: Path, remark: str) -> None:
    rows = rows_at(0.0).splitlines()
    path = tmp_path / "log.csv"
    path.write_text("\n".join([NAMES, *rows[:20], remark, *rows[20:40], remark, *rows[40:]]))
    assert read(path).signals["slip"].size == TIME.size


@pytest.mark.slow
@pytest.mark.parametrize(
    "title",
    ["# I = {field} A", "{field} A", "% current {field} A, 10 mm", "# I = {field}", "#I\t{field}"],
)
@pytest.mark.parametrize("has_names_each", [True, False])
def test_titles_part_rows_between_blanks_too(
    tmp_path: Path, title: str, has_names_each: bool
) -> None:
    # As programs that draw curves want them. All rows were one log at the first field, without a word.
    names = "# t[s] slip[rad/s] torque[N*m]\n"
    text = "" if has_names_each else names
    for field in FIELDS:
        text += title.format(field=field) + "\n"
        text += (names if has_names_each else "") + rows_at(field, " ") + "\n\n\n"
    path = tmp_path / "curves.dat"
    path.write_text(text)
    assert fields_of(path) == [*FIELDS]


@pytest.mark.slow
def test_a_setting_without_a_unit_is_a_title_and_a_status_is_none(tmp_path: Path) -> None:
    path = tmp_path / "tests.csv"
    blocks = [f"# current = {field}\n{rows_at(field)}\n" for field in FIELDS]
    path.write_text(f"{NAMES}\n{''.join(blocks)}")
    assert fields_of(path) == [*FIELDS]
    said = good("inspect", "tests.csv", cwd=tmp_path)
    assert said.splitlines()[-1] == "Understood. Fit it: erclutch fit tests.csv --out RUN"
    # A logger that notes its temperature at times goes on with the same test.
    head, *rows = rows_at(0.5).splitlines()
    rows.insert(20, "# temperature: 31")
    rows.insert(40, "# temperature: 32")
    path.write_text("\n".join([NAMES, head, *rows]) + "\n")
    assert [log.rows for log in read_all(path, ColumnMap())] == [TIME.size]


@pytest.mark.slow
def test_a_remark_that_the_field_was_changed_is_asked_about(tmp_path: Path) -> None:
    path = tmp_path / "tests.csv"
    path.write_text(f"{NAMES}\n{rows_at(0.0)}\n# from here on 0.5 A\n{rows_at(0.5)}\n")
    with pytest.raises(MappingError, match=r"'from here on 0.5 A' says 0.5 A.*NUMBER, 0.5 A"):
        read_all(path, ColumnMap())
    logs = read_all(path, ColumnMap(constants={"field": "0, 0.5 A"}))
    assert [float(log.signals["field"][0]) for log in logs] == [0.0, 0.5]


@pytest.mark.slow
@pytest.mark.parametrize(
    "title",
    [
        "--- {field} A ---",
        "[I={field}A]",
        ">> I_set={field}",
        "Strom;{field};A",
    ],
)
def test_titles_in_marks_and_in_cells_part_the_tests(tmp_path: Path, title: str) -> None:
    path = tmp_path / "tests.csv"
    text = f"{NAMES}\n" + "".join(
        f"{title.format(field=field)}\n{rows_at(field)}\n" for field in FIELDS
    )
    path.write_text(text)
    assert fields_of(path) == [*FIELDS]
