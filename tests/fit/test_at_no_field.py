"""Where no log is at no field, the law is taken that estimates there as most do of those that are as good."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from erclutch.fit.choice import validation
from erclutch.fit.choice.at_no_field import NOT_IN_THE_MIDDLE, in_the_middle
from erclutch.fit.fit_settings import Settings
from erclutch.fit.kinds.law_alone import KIND, with_memory
from erclutch.fit.laws.fit_law import fit_structure
from erclutch.logs import recording_from_arrays
from erclutch.logs.dataset import Dataset, build_dataset, joined
from erclutch.models.laws import law_from_name
from erclutch.models.stages import slip_stages
from erclutch.models.structure import Structure
from erclutch.signals.array import Array
from tests.fit.test_validation import FIELDS, bench

CURRENTS = (0.25, 0.5, 0.75, 1.0)


def logs_at(currents: tuple[float, ...]) -> Dataset:
    """SYNTHETIC: a log at each current, without noise."""
    slip = np.sin(0.3 * np.arange(60.0))
    logs: list[Dataset] = []
    for current in currents:
        field = np.full(slip.size, current)
        signals = {"field": field, "slip": slip, "effort": (0.2 + current) * np.sign(slip)}
        units = {"field": "A", "slip": "rad/s", "effort": "N*m"}
        log = build_dataset(recording_from_arrays(signals, units, rate=100.0))
        logs.append(replace(log, sources=(f"{current} A",)))
    return joined(logs)


def law_with(friction: float) -> Any:
    """The outcome of a fit that is right at all currents of the logs but for a hundredth, and guesses at none."""

    def predict(data: Dataset) -> Array:
        field, slip = data.elements[0].field, data.elements[0].slip
        level = np.where(field > 0.0, 0.21 + field, friction)
        return level * np.sign(slip)

    return SimpleNamespace(model=SimpleNamespace(predict=predict))


@pytest.mark.parametrize(
    ("frictions", "taken"),
    [
        ({"a": 0.5, "b": 0.2, "c": 0.0}, ["b"]),
        ({"a": 0.5, "b": 0.2, "c": 0.20005}, ["b", "c"]),  # next to as near
        ({"a": 0.5, "b": 0.2}, ["a", "b"]),  # of two none is in the middle
        ({"a": 0.5, "b": 0.2, "c": float("nan")}, ["a", "b", "c"]),
    ],
)
def test_of_laws_that_are_as_good_the_one_in_the_middle_at_no_field_is_taken(
    frictions: dict[str, float], taken: list[str]
) -> None:
    laws = {name: law_with(friction) for name, friction in frictions.items()}
    assert in_the_middle(logs_at(CURRENTS), laws) == taken


@pytest.mark.slow
@pytest.mark.parametrize(("fields", "asked"), [(CURRENTS, True), (FIELDS, False)])
def test_what_most_laws_say_at_no_field_decides_only_where_no_log_is_there(
    fields: tuple[float, ...], asked: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    data = bench(fields, rows=150, saturates_at=0.5)
    names = ("bingham/tanh+dahl", "herschel-bulkley/tanh+dahl", "seo-seo/tanh+dahl")
    fitted = [
        validation.Fitted(each, fit_structure(data, each.structure, intervals=False))
        for each in KIND.candidates(Settings(names, lag="none"), data)
    ]
    middle: list[str] = []
    for place in (0, -1):

        def one_of(train: Dataset, laws: dict[str, Any], place: int = place) -> list[str]:
            assert len(laws) > 1
            middle.append(list(laws)[place])
            return middle[-1:]

        monkeypatch.setattr(validation, "in_the_middle", one_of)
        choice = validation.chosen(data, fitted, names, seed=0)
        assert choice is not None
        if asked:
            assert choice.recommended == middle[-1]
            assert NOT_IN_THE_MIDDLE in choice.against.values()
            assert choice.against.get(middle[-1]) != NOT_IN_THE_MIDDLE
        else:
            assert NOT_IN_THE_MIDDLE not in choice.against.values()
    assert bool(middle) == asked


@pytest.mark.slow
@pytest.mark.parametrize(("fields", "laws"), [(CURRENTS, 3), (FIELDS, 2)])
def test_without_a_log_at_no_field_more_laws_get_the_memory(
    fields: tuple[float, ...], laws: int
) -> None:
    data = bench(fields, rows=300)
    names = ("bingham/square", "casson/square", "herschel-bulkley/square")
    fits = [
        fit_structure(data, Structure("single", name, law_from_name(name, "single")))
        for name in names
    ]
    candidates, _ = with_memory(data, fits)
    remembering = {
        each.structure.law.name for each in candidates if slip_stages(each.structure.dynamics)
    }
    assert len(remembering) == laws
