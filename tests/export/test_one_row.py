"""A model that is asked for one row again and again answers by machine code, with the bits of the long road."""

from __future__ import annotations

import pickle
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import pytest

from erclutch.models import shared_answers
from erclutch.models.model import Model
from erclutch.signals.array import Array
from erclutch.signals.clock import Clock, Span
from erclutch.signals.device import DeviceName, Element, Units


@dataclass
class Row:
    """One row as a data set."""

    device: DeviceName
    units: Units
    elements: list[Element]
    extras: dict[str, Array]
    clock: Clock = field(default_factory=lambda: Clock(np.zeros(1), (Span(0, 1, None),)))


def drawn(model: Model, rng: np.random.Generator) -> Row:
    """A row inside and around the training range, with exact zeros."""
    count = 2 if model.structure.device == "coaxial" else 1
    signals = (np.array([0.0, -0.0, *rng.uniform(-high, high, 4)]) for high in (700.0, 33.0))
    fields, slips = ([rng.choice(values, 1) for _ in range(count)] for values in signals)
    extras = {name: rng.uniform(-3.0, 3.0, 1) for name in model.extras}
    return Row(
        model.structure.device,
        model.units,
        [Element(np.abs(f), w) for f, w in zip(fields, slips, strict=True)],
        extras,
    )


@pytest.fixture
def fresh(model: Any) -> Any:
    """The model without what earlier tests left in it."""
    return pickle.loads(pickle.dumps(model))


@pytest.mark.slow
def test_a_lone_row_has_the_bits_of_the_long_road(
    fresh: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    rng = np.random.default_rng(1)
    rows = [drawn(fresh, rng) for _ in range(60)]
    expected = [fresh.predict(row) for row in rows]
    monkeypatch.setattr(shared_answers, "WORTH_LOADING", 0)
    found = [fresh.predict(row) for row in rows]
    assert vars(fresh)["_lone_rows"].machine is not None
    assert np.array(found).tobytes() == np.array(expected).tobytes()


def test_a_row_that_is_not_finite_takes_the_long_road(
    fresh: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    row = drawn(fresh, np.random.default_rng(2))
    row.elements[0] = Element(row.elements[0].field, np.array([np.nan]))
    expected = fresh.predict(row)
    monkeypatch.setattr(shared_answers, "WORTH_LOADING", 0)
    assert np.array_equal(fresh.predict(row), expected, equal_nan=True)


def test_a_law_of_functions_that_are_not_exported_keeps_the_long_road(
    law: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    model = law("bingham", "single", extra=False)
    own = replace(model.structure.law, columns=lambda E, w, *shape: [np.sin(E) * w, w])
    model = replace(model, structure=replace(model.structure, law=own))
    row = drawn(model, np.random.default_rng(3))
    expected = model.predict(row)
    monkeypatch.setattr(shared_answers, "WORTH_LOADING", 0)
    assert [model.predict(row), model.predict(row)] == [expected, expected]
    assert vars(model)["_lone_rows"].machine is None
