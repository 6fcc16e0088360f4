"""A table with a whole course in a cell gets a row for each number; other brackets stay. SYNTHETIC."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from time import process_time

import numpy as np
import pytest

from erclutch.logs import read
from erclutch.logs.readers.lists_in_cells import with_lists_in_cells
from tests.support.pace import within

pytestmark = pytest.mark.usefixtures("read_here")
TIME = np.arange(120) / 100
SPEED = np.round(3 + 2 * np.sin(9 * TIME), 3)
FIELDS = (0.0, 0.5, 1.0)
NAMES = ("test", "current_A", "time_s", "speed_rad_s", "torque_Nm")


def _as_json(numbers: Sequence[float]) -> str:
    return json.dumps([*numbers])


def _as_numpy(numbers: Sequence[float]) -> str:
    return np.array2string(np.array(numbers), threshold=1000, precision=4)


@pytest.mark.slow
@pytest.mark.parametrize("printed", [_as_json, _as_numpy])
@pytest.mark.parametrize("mark", [",", ";"])
def test_each_number_of_a_list_has_a_row(tmp_path: Path, printed: object, mark: str) -> None:
    # Such a table was refused.
    write = _as_json if printed is _as_json else _as_numpy
    lines = [mark.join(NAMES)]
    for number, field in enumerate(FIELDS):
        torque = np.round((1 + field) * SPEED, 4)
        cells = [f'"{write(each.tolist())}"' for each in (TIME, SPEED, torque)]
        lines.append(mark.join([str(number + 1), str(field), *cells]))
    path = tmp_path / "log.csv"
    path.write_text("\n".join([*lines, ""]), encoding="utf-8")
    log = read(path)
    np.testing.assert_allclose(log.signals["field"], np.repeat(FIELDS, TIME.size))
    np.testing.assert_allclose(log.signals["slip"], np.tile(SPEED, 3), atol=1e-4)
    assert log.units == {"field": "A", "slip": "rad/s", "effort": "N*m"}
    assert any("hold lists" in note for note in log.notes)


_COURSE = _as_json(range(20))
_JOINTS = _as_json(range(7))


@pytest.mark.parametrize(
    "text",
    [
        f'a,b\n"{_COURSE}","{_as_json(range(21))}"\n',  # of two lengths
        f'a,b\n1,"{_COURSE}"\n',  # one column
        f'a,b\n"{_JOINTS}","{_JOINTS}"\n',  # a number for each joint
        f'a,b\n"{_COURSE[:-1]}, x]","{_COURSE}"\n',
        f'"a {_COURSE}","b {_COURSE}"\n1,2\n',
    ],
)
def test_other_brackets_stay(text: str) -> None:
    assert with_lists_in_cells(text) == (text, "")


@pytest.mark.parametrize("sign", ['"[', '"[1', "[", " ", ",", '"[ '])
def test_long_cells_take_no_long_time(sign: str) -> None:
    begin = process_time()
    assert with_lists_in_cells("a,b\n" + sign * 20_000)[1] == ""
    assert within(process_time() - begin, 0.2)


def test_a_text_beside_a_vector_of_numpy_names_it(tmp_path: Path) -> None:
    # A column for the effort was asked for, though y_names told it.
    torque = 2 * SPEED
    np.savez(
        tmp_path / "log.npz",
        t=TIME,
        u=np.column_stack([TIME > 0.5, SPEED]).astype(float),
        y=torque,
        u_names=np.array(["current", "speed"]),
        y_names=np.array(["torque"]),
    )
    log = read(tmp_path / "log.npz")
    np.testing.assert_allclose(log.signals["effort"], torque)
    np.testing.assert_allclose(log.signals["slip"], SPEED)
