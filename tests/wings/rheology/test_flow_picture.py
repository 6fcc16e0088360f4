"""The picture of flow curves: room for the names of many curves, and intervals at the fields that were measured."""

from __future__ import annotations

import numpy as np
import pytest

from erclutch.report.plots.plot_description import Line, Shade
from erclutch.wings.rheology.field_series import series_of
from erclutch.wings.rheology.flow_curve import FlowCurve, FlowFit, fit_flow_curve, ranked
from erclutch.wings.rheology.flow_picture import picture_of

pytestmark = pytest.mark.slow

RATES = np.logspace(-1.0, 3.0, 12)


def curve(number: int, field: float = np.nan, unit: str = "") -> FlowCurve:
    noise = np.exp(np.random.default_rng(number).normal(0.0, 0.01, RATES.size))
    return FlowCurve(
        f"curve {number}", RATES, (10.0 + 5.0 * number + 0.2 * RATES) * noise, field, unit
    )


def fitted(count: int) -> list[tuple[FlowCurve, FlowFit]]:
    return [(each, fit_flow_curve(each, "bingham")) for each in map(curve, range(count))]


def test_names_above_the_curves_take_no_room_from_them() -> None:
    few, many = picture_of(fitted(3), None), picture_of(fitted(12), None)
    assert few.legend == "inside"
    assert many.legend == "above"
    assert many.height > few.height + 12 * 0.15


def test_curves_that_share_a_colour_differ_in_their_lines() -> None:
    (panel,) = picture_of(fitted(12), None).panels
    lines = [mark for mark in panel.marks if isinstance(mark, Line)]
    assert len({(line.style, line.dashed) for line in lines}) == 12


def test_intervals_of_yield_stresses_stand_at_their_fields_alone() -> None:
    curves = [curve(number, 0.5 * number, "A") for number in range(4)]
    series = series_of([(each, ranked(each, ["bingham"])) for each in curves])
    _, yields = picture_of([(each, ranked(each, ["bingham"])[0]) for each in curves], series).panels
    assert not any(isinstance(mark, Shade) for mark in yields.marks)
    intervals = [
        mark for mark in yields.marks if isinstance(mark, Line) and mark.style == "measured"
    ]
    assert [line.x.tolist() for line in intervals] == [[0.5 * number] * 2 for number in range(4)]
