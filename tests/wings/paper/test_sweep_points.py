"""Points of a sweep that are kept come back as they were, or not at all."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from erclutch.errors import RunError
from erclutch.logs import recording_from_arrays
from erclutch.logs.dataset import build_dataset
from erclutch.wings.paper.commands.reproduce import _points
from erclutch.wings.paper.sweep_points import Points

VALUES: list[Any] = [
    1.5,
    [1, None, float("inf")],
    {"b": 2, "a": {"10": 1, "9": 2}},
    {10: 1, 9: 2},
    "x",
]


def file_of(folder: Path) -> Path:
    path = folder / "points.jsonl"
    points = Points(path, {"rows": 1})
    for number, value in enumerate(VALUES):
        points.get(f"p{number}", lambda value=value: value)
    return path


def test_points_come_back(tmp_path: Path) -> None:
    again = Points(file_of(tmp_path), {"rows": 1})
    for number, value in enumerate(VALUES):
        kept = again.get(f"p{number}", lambda: pytest.fail("it is made anew"))
        assert kept == json.loads(json.dumps(value))


@pytest.mark.parametrize(
    "change", [('"value": 1.5', '"value": 2.5'), ('"key": "p0"', '"key": "p1"')]
)
def test_a_point_that_was_changed_is_refused(tmp_path: Path, change: tuple[str, str]) -> None:
    """It went into the table in silence, and one of another kind ended in a traceback."""
    path = file_of(tmp_path)
    path.write_text(path.read_text().replace(*change, 1))
    with pytest.raises(RunError, match=r"what it keeps of 'p[01]' was changed"):
        Points(path, {"rows": 1})


def test_points_without_a_digest_are_made_anew(tmp_path: Path) -> None:
    path = file_of(tmp_path)
    lines = [json.loads(line) for line in path.read_text().splitlines()]
    kept = [json.dumps({name: of[name] for name in of if name != "digest"}) for of in lines]
    path.write_text("\n".join(kept) + "\n")
    points = Points(path, {"rows": 1})
    assert (points.others, points.get("p0", lambda: 7)) == (len(VALUES), 7)


@pytest.mark.parametrize("changed", ["field", "slip", "effort"])
def test_points_of_other_rows_are_not_used(tmp_path: Path, changed: str) -> None:
    """Of rows with another field, or with a sign turned, the points were taken for those of these rows, in silence."""
    rng = np.random.default_rng(1)
    signals = {name: rng.standard_normal(40) for name in ("field", "slip", "effort")}
    units = {"field": "A", "slip": "rad/s", "effort": "N*m"}

    def points_of(signals: dict[str, np.ndarray]) -> Points:
        log = recording_from_arrays(signals, units, rate=100.0)
        return _points("kernels", {"training": build_dataset(log)}, tmp_path, {"seed": 0})

    assert points_of(signals).get("p", lambda: 1.0) == 1.0
    assert points_of(signals).get("p", lambda: 2.0) == 1.0
    turned = {**signals, changed: -signals[changed]}
    assert points_of(turned).get("p", lambda: 3.0) == 3.0
