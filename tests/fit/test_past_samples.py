"""Past samples in rows and in seconds, of further inputs too; and models that keep to their rate."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_array_equal

from erclutch.errors import ErclutchError, SettingError
from erclutch.export.step_numbers import run
from erclutch.export.step_record import step_of
from erclutch.fit.fit_settings import Settings
from erclutch.fit.networks.fit_network import fit_network
from erclutch.fit.past_samples import past_finding, past_rows, without_network
from erclutch.logs.dataset import Dataset
from erclutch.models.load import load_model
from erclutch.models.networks import network_from_name
from erclutch.signals.clock import Clock, Span
from erclutch.signals.device import Element, Units
from tests.support.exported_models import law_model, network_model


def rows(period: float | None = 1e-3, n: int = 800) -> Dataset:
    rng = np.random.default_rng(0)
    t = np.arange(n, dtype=np.float64) * (period or 1e-3)
    field, slip = rng.uniform(0, 1, n), np.sin(40 * t) + 0.1 * rng.standard_normal(n)
    push = rng.standard_normal(n)
    effort = field * np.tanh(5 * slip) + 0.3 * np.roll(push, 2)
    clock = Clock(t, (Span(0, n, period),))
    return Dataset(
        "single",
        (Element(field, slip),),
        effort,
        clock,
        Units("N", "A", "m/s"),
        extras={"push": push},
    )


TEN_ROWS = rows(n=10)


@pytest.mark.parametrize(
    ("asked", "expected"),
    [
        ((1, 2, 4), (1, 2, 4)),
        (("3",), (3,)),
        (("1ms", "2 ms", "0.004 s"), (1, 2, 4)),
        (("2ms", 2, "2000 us"), (2,)),
        (("1.6ms",), (2,)),
        ((), ()),
    ],
)
def test_rows_and_times(asked: tuple[int | str, ...], expected: tuple[int, ...]) -> None:
    assert past_rows(asked, rows()) == expected


def test_a_time_is_the_same_time_at_another_rate() -> None:
    assert past_rows(("5ms", "20ms"), rows(2.5e-3)) == (2, 8)
    (finding,) = past_finding(("5ms", 8), rows(2.5e-3))
    assert "(--past 5ms, 8) lie 2, 8 rows back, 5, 20 ms, at the 400 Hz" in finding.message
    assert past_finding((), rows()) == ()


@pytest.mark.parametrize(
    "word", ["ms", "2 m", "-1ms", "1e-3", "0", "0ms", "0.3ms", "2s", "nan s", "", "1ms,2ms", "1Hz"]
)
def test_what_is_no_time_and_no_number_of_rows(word: str) -> None:
    with pytest.raises(SettingError, match="past samples"):
        past_rows((word,), rows())


@pytest.mark.slow
@settings(deadline=None)
@given(st.text(max_size=12) | st.integers())
def test_any_text_gives_rows_or_one_line(word: str | int) -> None:
    try:
        found = past_rows((word,), TEN_ROWS)
    except SettingError:
        return
    assert all(1 <= k <= 1000 for k in found)


@pytest.mark.slow
@settings(deadline=None)
@given(st.integers(1, 1000), st.sampled_from([1e-4, 3.328e-4, 1e-3, 1e-2]))
def test_a_number_of_periods_is_that_number_of_rows(k: int, period: float) -> None:
    assert past_rows((f"{1e3 * k * period:.9g}ms",), rows(period, n=10)) == (k,)


def test_unequal_steps_have_rows_but_no_times() -> None:
    assert past_rows((2,), rows(None)) == (2,)
    with pytest.raises(SettingError, match="unequal steps"):
        past_rows(("2ms",), rows(None))


@pytest.mark.slow
def test_past_samples_of_further_inputs_are_inputs(tmp_path: Path) -> None:
    data = rows(n=3000)
    structure = network_from_name("fnn-8", "single", past=(2,), extras=("push",))
    assert structure.inputs == ("field", "slip", "field[-2]", "slip[-2]", "push[-2]", "push")
    model = fit_network(data, structure, workers=1).model
    residual = data.effort - model.predict(data)
    assert float(np.std(residual[5:])) < 0.1  # 0.3 without push[-2]
    (tmp_path / "model.json").write_text(json.dumps(model.to_dict()))
    again = load_model(tmp_path / "model.json")
    assert_array_equal(again.predict(data), model.predict(data))
    given_rows = np.column_stack(
        [data.elements[0].field, data.elements[0].slip, data.extras["push"]]
    )
    assert_array_equal(run(step_of(again), given_rows)[0], model.predict(data))


@pytest.mark.slow
def test_a_model_without_past_samples_of_further_inputs_is_still_read(tmp_path: Path) -> None:
    structure = replace(
        network_from_name("fnn-4", "single", past=(1,), extras=("push",)), past_extras=False
    )
    assert structure.inputs == ("field", "slip", "field[-1]", "slip[-1]", "push")
    model = fit_network(rows(), structure, workers=1).model
    (tmp_path / "model.json").write_text(json.dumps(model.to_dict()))
    assert load_model(tmp_path / "model.json").structure == structure


def test_what_is_asked_of_networks_alone_is_told_where_there_is_none() -> None:
    """`--past` and `--polish` were taken without a word where only laws were fitted."""
    law = law_model("bingham", "single")
    asked = Settings(past=(5,), polish=True)
    (finding,) = without_network(asked, [law])
    assert "so --past and --polish changed nothing" in finding.message
    assert without_network(Settings(), [law]) == ()
    assert without_network(asked, [law, network_model("fnn-3", "single")]) == ()


@pytest.mark.slow
def test_past_samples_at_another_rate_are_refused() -> None:
    model = fit_network(rows(), network_from_name("fnn-4", "single", past=(1,)), workers=1).model
    with pytest.raises(
        ErclutchError, match="rows at 400 Hz for a network with past samples at 1000 Hz"
    ) as caught:
        model.predict(rows(2.5e-3))
    assert "--resample 1000" in str(caught.value)
