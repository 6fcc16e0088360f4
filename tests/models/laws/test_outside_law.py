"""A law of another package is refused with its package's name where it is no law that can be fitted."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from erclutch.arithmetic.record import Record, recorded
from erclutch.errors import ExportError, PluginError
from erclutch.models.laws.law import VISCOSITY, YIELD, Gain, Law
from erclutch.models.laws.outside_law import checked
from erclutch.models.laws.smooth import TRANSITION_SLIP, direction
from erclutch.registry import Plugin

PLUGIN = Plugin("erclutch.laws", "drag", "erclutch_law_drag:LAW", "erclutch-law-drag", "2.0")
_COUNT = itertools.count()


def law_of(columns: Callable[..., Any], gains: tuple[Gain, ...] = (YIELD, VISCOSITY)) -> Law:
    return Law("drag", "Drag", "made up", columns, (TRANSITION_SLIP,), gains)


def good(field: Any, slip: Any, turn: Any) -> tuple[Any, ...]:
    return field * direction(slip, turn), slip


def test_a_good_law_passes() -> None:
    assert checked(law_of(good), PLUGIN).plugin is PLUGIN


@pytest.mark.parametrize(
    ("law", "said"),
    [
        (
            law_of(good, (YIELD, VISCOSITY, YIELD)),
            r"two parameters of one name: w_s, T_y, eta, T_y",
        ),
        (law_of(good, (YIELD,)), r"for each of its gains \(T_y\), it returns 2 columns"),
        (law_of(lambda *_: np.zeros(4), (YIELD,)), "it returns ndarray"),
        (
            replace(law_of(good), name="pull"),
            "calls itself 'pull'; its Law.name and its entry point must agree",
        ),
        (
            law_of(lambda field, slip, turn: (field, slip * np.nan)),
            "returns for the gain eta what is no finite array",
        ),
        (
            law_of(lambda field, slip, turn: (field, slip[:2])),
            "returns for the gain eta what is no finite array",
        ),
        (
            law_of(lambda field, slip, turn: (1j * field, slip)),
            "returns for the gain T_y what is no finite array",
        ),
        (
            law_of(lambda field, slip, turn: (field, np.multiply(slip, 2.0, out=slip))),
            "output array is read-only",
        ),
        (
            law_of(lambda field, slip, turn: (field, slip + next(_COUNT))),
            "other numbers for the same rows",
        ),
        (
            law_of(lambda field, slip, turn: (np.asarray(good(field, slip, turn)[0]), slip)),
            "loses the derivatives",
        ),
        (
            law_of(lambda *_: 1 / 0),
            r"ZeroDivisionError: division by zero \(test_outside_law\.py, line \d+\)",
        ),
    ],
)
def test_a_bad_law_is_named(law: Law, said: str) -> None:
    with pytest.raises(PluginError, match=said) as caught:
        checked(law, PLUGIN)
    assert "'drag' of erclutch-law-drag 2.0" in str(caught.value)


@pytest.mark.parametrize(
    ("columns", "said"),
    [
        (lambda field, slip, turn: (field, np.where(slip > 0, slip, 0.0)), "a comparison has no C"),
        (lambda field, slip, turn: (field, np.log(np.abs(slip) + 1.0)), "no C for NumPy's log"),
    ],
)
def test_what_has_no_c_names_the_law_and_the_rule(columns: Callable[..., Any], said: str) -> None:
    law = checked(law_of(columns), PLUGIN)
    with pytest.raises(ExportError, match=said) as caught:
        recorded(lambda *x: law.columns(*x)[1], ["field", "slip", "turn"])
    assert str(caught.value).startswith("drag of erclutch-law-drag 2.0: ")


def test_a_traced_number_has_no_truth() -> None:
    with pytest.raises(ExportError, match=r"a branch .* has no C"):
        bool(Record().input("x"))


def test_a_node_is_shown_on_one_short_line() -> None:
    record = recorded(lambda x, y: np.tanh(x * y) + 2.0 * x, ["x", "y"])
    shown = [repr(node) for node in record.nodes]
    assert shown[0] == "<node 0: input 'x' of []>"
    assert max(map(len, shown)) < 60
