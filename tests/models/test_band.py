from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from erclutch.arithmetic.evaluation import evaluate
from erclutch.arithmetic.precision import FLOAT32, FLOAT64, Precision
from erclutch.arithmetic.record import Record
from erclutch.arithmetic.row_arithmetic import Numbers
from erclutch.errors import RunError
from erclutch.models.band import Band
from erclutch.models.law_model import TorqueModel
from erclutch.models.laws import law_from_name
from erclutch.models.load import load_model
from erclutch.models.model import Range
from erclutch.models.model_file import digest_of
from erclutch.models.structure import Reference, Structure
from erclutch.signals.array import Array
from erclutch.signals.clock import Clock, Span
from erclutch.signals.device import Element, Units

WIDTHS = tuple(0.01 * k for k in range(12))
BAND = Band(
    0.95,
    0.01,
    5.0,
    (0.0, 100.0),
    (-1.0, 1.0),
    (10.0, 60.0),
    (0.3,),
    WIDTHS,
    tuple(2.0 * w for w in WIDTHS),
)
NUMBERS = st.floats(-1e4, 1e4)


def refused_as_unfit(body: dict[str, Any], path: Path) -> None:
    """A model file with this body, and a digest that fits it, is refused in one line."""
    body["digest"] = digest_of({key: v for key, v in body.items() if key != "digest"})
    path.write_text(json.dumps(body), encoding="utf-8")
    with pytest.raises(RunError, match="unfit entry") as error:
        load_model(path)
    assert "\n" not in str(error.value)


def some_model() -> TorqueModel:
    structure = Structure("single", "bingham", law_from_name("bingham", "single"))
    shape, gains = {"w_s": 0.01, "n": 1.3}, {"T_y": 0.2, "eta": 0.01}
    ranges = Range((0.0, 100.0), (-1.0, 1.0), (-1.0, 1.0))
    shape = {s.name: shape.get(s.name, s.lower) for s in structure.shapes(1e-3)}
    gains = {g.name: 0.2 for g in structure.gains()}
    return TorqueModel(
        structure, Reference(100.0, 1.0, 1e-3), shape, gains, Units("N*m", "V", "rad/s"), ranges
    )


def _cell_of(field: float, slip: float, followed: float) -> int:
    """The cell, counted as the docstring says: 32 cells of 3.125 V and of 1/16 rad/s, the classes of their centres."""
    centre = 3.125 * (min(max(int(field / 3.125), 0), 31) + 0.5)
    speed = 0.0625 * (min(max(int((slip + 1.0) / 0.0625), 0), 31) + 0.5) - 1.0
    fields, slips = (
        sum(centre > e for e in BAND.field_edges),
        sum(abs(speed) > e for e in BAND.slip_edges),
    )
    return (int(abs(field - followed) > BAND.threshold) * 3 + fields) * 2 + slips


def _alone(
    field: Array, slip: Array, spans: tuple[Span, ...] | None = None
) -> tuple[list[Element], Clock]:
    n = field.size
    return [Element(field, slip)], Clock(1e-3 * np.arange(float(n)), spans or (Span(0, n, 1e-3),))


def _found(fields: Any, slips: Any, followed: Any) -> list[Any]:
    field, slip, place = BAND.leading(fields, slips)
    return [field, slip, place, BAND.switching(field, followed)]


@pytest.mark.slow
@given(st.tuples(NUMBERS, NUMBERS), st.tuples(NUMBERS, NUMBERS), NUMBERS)
def test_cell_and_leading_element(
    fields: tuple[float, float], slips: tuple[float, float], followed: float
) -> None:
    found = _found(
        [np.array([f]) for f in fields], [np.array([w]) for w in slips], np.array([followed])
    )
    field, slip, place, switching = (x[0] for x in found)
    first = int(
        fields[1] ** 2 > fields[0] ** 2
    )  # as the C asks: below 1e-162 squares are zero, and the first one wins
    assert (field, slip) == (fields[first], slips[first])
    assert switching * 6 + place == _cell_of(fields[first], slips[first], followed)


@pytest.mark.parametrize("precision", [FLOAT32, FLOAT64])
def test_the_record_has_the_cells(precision: Precision) -> None:
    rng = np.random.default_rng(0)
    x = {
        name: rng.uniform(-100, 100, 5000).astype(precision.dtype)
        for name in ("E1", "E2", "w1", "w2", "lag")
    }
    for name in ("w1", "w2"):
        x[name] *= precision.dtype.type(0.01)
    record = Record()
    first, second, one, two, lag = map(record.input, x)
    for value in _found([first, second], [one, two], lag):
        record.give(value)
    found = evaluate(record, x, Numbers(precision))
    wanted = _found([x["E1"], x["E2"]], [x["w1"], x["w2"]], x["lag"])
    assert all(np.array_equal(a, b) for a, b in zip(found, wanted, strict=True))
    assert len(set((6 * found[3] + found[2]).tolist())) == 12


def test_the_ends_lie_in_the_direction_of_the_slip() -> None:
    slip = np.array([0.5, -0.5, 0.1, -0.1, 0.0])
    low, high = BAND.around(np.full(5, 7.0), *_alone(np.full(5, 30.0), slip))
    assert np.allclose(7.0 - low, [0.03, 0.06, 0.02, 0.04, 0.02])
    assert np.allclose(high - 7.0, [0.06, 0.03, 0.04, 0.02, 0.04])


def test_a_step_of_the_field_switches_for_a_while_and_a_gap_settles() -> None:
    field = np.repeat([0.0, 50.0], [100, 200])
    elements, clock = _alone(field, np.zeros(300))
    switching = BAND.cells(elements, clock) >= 6
    # 50 exp(-t / 10 ms) > 5 V: 23 ms, and the lag has the first of these rows already
    assert np.flatnonzero(switching).tolist() == list(range(100, 123))
    elements, clock = _alone(field, np.zeros(300), (Span(0, 100, 1e-3), Span(100, 300, 1e-3)))
    assert not (BAND.cells(elements, clock) >= 6).any()


def test_a_model_keeps_its_band(tmp_path: Path) -> None:
    model = replace(some_model(), band=BAND)
    path = tmp_path / "m.json"
    path.write_text(json.dumps(model.to_dict()), encoding="utf-8")
    assert load_model(path).to_dict() == model.to_dict()
    assert load_model(path).band == BAND
    assert "band" not in some_model().to_dict()


@pytest.mark.parametrize(
    ("entry", "value"),
    [
        ("level", 1.0),
        ("level", 0.0),
        ("settling_s", 0.0),
        ("threshold", -1.0),
        ("field", [100.0, 0.0]),
        ("slip", [-1.0]),
        ("field_edges", [60.0, 10.0]),
        ("field_edges", [10.0, 10.0]),
        ("field_edges", [10.0, 1e30]),
        ("slip_edges", [0.0]),
        ("slip_edges", [0.1, 0.2, 0.3, 0.4]),
        ("slip_edges", "0.3"),
        ("behind", list(WIDTHS[:-1])),
        ("ahead", [-1e-9, *WIDTHS[1:]]),
        ("ahead", None),
    ],
)
def test_a_band_that_makes_no_sense_is_refused_in_one_line(
    entry: str, value: Any, tmp_path: Path
) -> None:
    body = replace(some_model(), band=BAND).to_dict()
    body["band"][entry] = value
    refused_as_unfit(body, tmp_path / "m.json")
