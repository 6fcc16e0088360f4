"""Numbers behind reports against rows whose answer is known."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from pathlib import Path
from typing import Any, cast

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from erclutch.logs.dataset import Dataset
from erclutch.report.html.dynamics_section import stages_of
from erclutch.report.numbers.correlation import autocorrelation, held_out_spans, spectrum
from erclutch.report.numbers.error_map import error_maps
from erclutch.report.numbers.flow_curves import FlowCurves, grouped, rare_fields
from erclutch.report.numbers.model_stages import stage_gain
from erclutch.report.numbers.number_text import (
    chart_scale,
    constant_scale,
    number,
    percent_text,
    r2_text,
    scale_for,
    share_span,
    span,
)
from erclutch.report.numbers.parity import distributions, parity
from erclutch.report.numbers.run_material import shown_models
from erclutch.report.numbers.switching import (
    after_switch,
    step_response,
    step_responses,
    switches_of,
)
from erclutch.report.numbers.windows import windows
from erclutch.report.plots.lag_plot import step_panel
from erclutch.report.plots.plot_description import Axis, Line
from erclutch.runs.run_rows import RunRows
from erclutch.signals.array import noise_of
from erclutch.signals.clock import Clock, Span
from erclutch.signals.device import DeviceName, Element, Units

Array = NDArray[np.float64]
RATE = 1000.0


def rows_of(
    field: Array,
    slip: Array,
    effort: Array,
    predicted: dict[str, Array],
    *,
    cuts: Sequence[int] = (),
    held: float = 0.3,
) -> RunRows:
    """Rows at 1 kHz, cut into spans, the last 30 % held out."""
    n = effort.size
    edges = [0, *cuts, n]
    spans = tuple(Span(a, b, 1 / RATE) for a, b in itertools.pairwise(edges))
    data = Dataset(
        "single",
        (Element(field, slip),),
        effort,
        Clock(np.arange(n) / RATE, spans),
        Units("N", "V", "m/s"),
    )
    return RunRows(data, np.arange(n) >= round(0.7 * n), predicted)


def noise(n: int = 20_000, seed: int = 0) -> Array:
    return np.random.default_rng(seed).normal(size=n)


def test_error_maps_count_every_row_once_and_add_up_to_the_error() -> None:
    rng = np.random.default_rng(1)
    n = 8000
    field, slip, e = rng.uniform(0, 5, n), rng.normal(size=n), rng.normal(size=n)
    rows = rows_of(field, slip, e, {"m": np.zeros(n)})
    (found,) = error_maps(rows, "m")
    assert found.train.sum() == np.count_nonzero(~rows.test)
    assert found.test.sum() == np.count_nonzero(rows.test)
    total = np.nansum(found.rmse**2 * found.test)
    assert total == pytest.approx(float(np.sum(e[rows.test] ** 2)))
    i, j = np.searchsorted(found.field_edges, 2.5) - 1, np.searchsorted(found.slip_edges, 0.0) - 1
    inside = (field >= found.field_edges[i]) & (field < found.field_edges[i + 1])
    inside &= (slip >= found.slip_edges[j]) & (slip < found.slip_edges[j + 1])
    assert found.train[i, j] == np.count_nonzero(inside & ~rows.test)


def test_a_hole_in_the_training_rows_is_blind() -> None:
    n = 5000
    rng = np.random.default_rng(2)
    slip = rng.uniform(-1, 1, n)
    field = np.where(np.arange(n) < 3500, rng.uniform(0, 1, n), rng.uniform(1.5, 2, n))
    (found,) = error_maps(rows_of(field, slip, slip, {"m": slip * 0}), "m")
    assert found.blind_share == 1.0
    (whole,) = error_maps(rows_of(rng.uniform(0, 1, n), slip, slip, {"m": slip * 0}), "m")
    assert whole.blind_share < 0.2


def test_logged_levels_get_a_cell_each() -> None:
    levels = np.array([0.0, 0.25, 0.5, 0.75, 1.0])
    field = np.repeat(levels, 1000)[np.random.default_rng(0).permutation(5000)]
    (found,) = error_maps(rows_of(field, noise(5000), noise(5000), {"m": np.zeros(5000)}), "m")
    assert found.field_edges.size == 6
    counts = found.train.sum(axis=1) + found.test.sum(axis=1)
    assert counts.tolist() == [1000] * 5


def test_parity_and_distribution() -> None:
    y = noise()
    rows = rows_of(y, y, y, {"right": y, "off": y + 0.5})
    assert np.trace(parity(rows, "right").counts) == np.count_nonzero(rows.test)
    exact, off = distributions(
        rows_of(y, y, y, {"noisy": y - noise(seed=1), "off": y - noise(seed=2) - 0.5}),
        ["noisy", "off"],
    )
    assert exact.bias == pytest.approx(0.0, abs=0.05)
    assert off.bias == pytest.approx(0.5, abs=0.05)
    assert exact.spread == pytest.approx(1.0, rel=0.03)
    half, most, nearly, all_ = exact.quantiles
    assert half == pytest.approx(0.674, rel=0.05)
    assert most == pytest.approx(1.96, rel=0.05)
    assert nearly == pytest.approx(2.58, rel=0.07)
    assert all_ > 3.0
    width = exact.edges[1] - exact.edges[0]
    assert exact.density.sum() * width + exact.beyond == pytest.approx(1.0)


def test_the_spectrum_of_white_noise_is_flat_and_right() -> None:
    e = noise(60_000)
    rows = rows_of(e, e, e, {"m": np.zeros(e.size)}, cuts=(50_000,))
    found = spectrum(rows, ["m"])
    assert found is not None
    # One-sided: sigma^2 spread over half the sampling rate.
    expected = np.sqrt(2.0 / RATE)
    assert np.median(found.density["m"]) == pytest.approx(expected, rel=0.1)
    assert found.density["m"].tolist() == found.density["measured"].tolist()


def test_a_tone_shows_where_it_is() -> None:
    t = np.arange(60_000) / RATE
    e = np.sin(2 * np.pi * 40.0 * t) + 0.1 * noise(60_000)
    found = spectrum(rows_of(e, e, e, {"m": np.zeros(e.size)}), ["m"])
    assert found is not None
    assert found.frequency[int(np.argmax(found.density["m"]))] == pytest.approx(40.0, rel=0.03)


@pytest.mark.parametrize("rho", [0.0, 0.8, 0.95])
def test_autocorrelation_of_a_known_process(rho: float) -> None:
    from scipy.signal import lfilter

    e = lfilter([1.0], [1.0, -rho], noise(100_000))
    rows = rows_of(e, e, e, {"m": np.zeros(e.size)}, cuts=(90_000,))
    found = autocorrelation(rows, ["m"])
    assert found is not None
    for k in (1, 5, 10):
        assert found.values["m"][k] == pytest.approx(rho**k, abs=0.04)
    n = int(rows.test.sum())
    assert found.white == pytest.approx(1.96 / np.sqrt(n))
    assert found.independent["m"] == pytest.approx(n * (1 - rho**2) / (1 + rho**2), rel=0.35)


def test_nothing_crosses_a_gap() -> None:
    e = noise(1000)
    rows = rows_of(e, e, e, {"m": e * 0}, cuts=(800, 900))
    assert [(s.start, s.stop) for s in held_out_spans(rows)] == [
        (700, 800),
        (800, 900),
        (900, 1000),
    ]
    assert spectrum(rows_of(e, e, e, {"m": e * 0}, cuts=tuple(range(50, 1000, 50))), ["m"]) is None


@pytest.mark.slow
def test_windows_are_held_out_and_rank_as_they_say() -> None:
    e = noise(20_000)
    e[17_000:17_200] *= 20.0
    rows = rows_of(e, e, e, {"m": np.zeros(e.size)}, cuts=(18_000,))
    found = windows(rows, "m")
    assert found.worst[0] < 17_200
    assert found.worst[1] > 17_000
    for a, b in (found.typical, found.worst):
        assert rows.test[a:b].all()
        assert not (a < 18_000 < b)
    assert not found.typical[0] < 17_200 or found.typical[1] <= 17_000
    # As many windows are better than the typical window as are worse, and none is worse than the worst.
    width = found.worst[1] - found.worst[0]
    errors = {
        a: float(np.mean(e[a : a + width] ** 2))
        for a in range(0, e.size - width)
        if rows.test[a : a + width].all()
    }
    typical, worst = errors[found.typical[0]], errors[found.worst[0]]
    others = [v for a, v in errors.items() if not a < 18_000 < a + width]
    assert 0.3 < np.mean(np.array(others) < typical) < 0.7
    assert np.mean(np.array(others) <= worst) > 0.9


def test_the_lively_window_is_where_field_and_slip_change() -> None:
    n = 20_000
    field, slip = np.zeros(n), np.ones(n)
    field[15_000:15_400:2], slip[16_000:16_100:2] = (
        0.02,
        -1.0,
    )  # small, or faster than any picture shows
    field[17_200:17_500] = 1.0
    slip[17_300:17_600] = -1.0
    found = windows(rows_of(field, slip, noise(n), {"m": np.zeros(n)}), "m").lively
    assert found[0] <= 17_200
    assert found[1] >= 17_600


def test_the_error_after_a_switch() -> None:
    n = 40_000
    field = np.where(np.arange(n) // 200 % 2, 2.0, 0.0)
    since = np.arange(n) % 200
    e = np.where(since < 20, 5.0, 1.0)
    found = after_switch(rows_of(field, field, e, {"m": np.zeros(n)}), ["m"])
    assert found is not None
    assert found.switches == 60
    assert found.rmse["m"][found.since < 0.018].tolist() == [5.0] * int(np.sum(found.since < 0.018))
    assert found.rmse["m"][found.since > 0.025].tolist() == [1.0] * int(np.sum(found.since > 0.025))


def test_switches_are_counted_where_they_are_too_few_for_a_curve() -> None:
    """A log with nine steps held out was said to switch hardly ever."""
    n = 30_000
    field = np.where(np.arange(n) // 1000 % 2, 2.0, 0.0)
    rows = rows_of(field, field, field, {"m": np.zeros(n)})
    assert after_switch(rows, ["m"]) is None
    assert np.flatnonzero(switches_of(rows) & rows.test).tolist() == [*range(21_000, n, 1000)]


def test_the_field_of_another_log_is_no_switch() -> None:
    """A run of three logs, each at its own field, was said to switch where the second log was held out."""
    field = np.repeat([0.2, 0.6, 1.0], 2000)
    field[4500:] = 0.2  # the only step that somebody saw
    rows = rows_of(field, field, field, {"m": field * 0}, cuts=(2000, 4000))
    assert np.flatnonzero(switches_of(rows)).tolist() == [4500]


def test_a_smooth_command_has_no_switch() -> None:
    field = np.sin(np.arange(20_000) / 300)
    assert after_switch(rows_of(field, field, field, {"m": field * 0}), ["m"]) is None


def chain(name: str, **numbers: float) -> dict[str, Any]:
    return {"name": name, "dynamics": numbers}


@pytest.mark.slow
def test_step_responses() -> None:
    lagged = chain("b+rise-fall", delay=0.002, tau_rise=0.01, tau_fall=0.05)
    (step,) = step_responses({"ranking": [chain("a"), lagged]}, ["a", "b+rise-fall"])
    assert step.model == "b+rise-fall"
    assert step.up(np.array([0.0, 0.001, 0.012])) == pytest.approx(
        [0.0, 0.0, 1 - np.exp(-1)], abs=0.01
    )
    assert step.down(np.array([0.0, 0.052])) == pytest.approx([1.0, np.exp(-1)], abs=0.01)
    assert step.settled == pytest.approx(0.002 + 0.05 * np.log(100), rel=0.02)


def test_step_responses_come_from_the_stages_whatever_the_chain() -> None:
    slow = chain(
        "a+two-lags+dahl/field+effort-lag", tau_1=0.002, m_1=20.0, p_1=0.5, r_1=0.01, tau_e=0.5
    )
    (step,) = step_responses({"ranking": [slow]}, [slow["name"]])
    assert float(step.up(np.array([0.01]))[0]) == pytest.approx(
        1 - 0.5 * np.exp(-5) - 0.5 * np.exp(-0.25), abs=0.01
    )
    assert step.settled == pytest.approx(0.04 * np.log(50), rel=0.02)
    alone = chain("a+dahl/field", r_1=0.01)
    assert step_responses({"ranking": [alone]}, [alone["name"]]) == ()


@pytest.mark.slow
def test_a_step_that_comes_at_once_is_not_drawn() -> None:
    """Iron that keeps 0.1 % back drew a ramp of a nanosecond."""
    brake = chain("a+remanence", r_h=0.001, s_h=1.0)
    assert step_responses({"ranking": [brake]}, [brake["name"]]) == ()


def test_dots_beside_a_curve_wait_for_the_lag_of_the_effort() -> None:
    """The effort of a brake follows its coil by 60 ms: dots from before the end of a step lay far from the line."""
    entry = chain("a+effort-lag", tau_e=0.06)
    assert step_response(entry) is None
    lagged = step_response(entry, ("command", "effort"))
    assert lagged is not None
    assert lagged.settled == pytest.approx(0.06 * np.log(100), rel=0.02)


def test_a_time_constant_of_a_minute_is_in_seconds() -> None:
    """The time in which a brake warms stood there as 72330 ms."""
    assert constant_scale("s", 72.33).of(72.33, 4).replace("\xa0", " ") == "72.33 s"
    assert constant_scale("s", 0.06).of(0.06, 4).replace("\xa0", " ") == "60.00 ms"


def test_what_iron_keeps_back_does_not_stretch_the_time_of_a_step() -> None:
    brake = chain("a+remanence+lag", r_h=0.12, s_h=1.0, delay=0.0, tau=0.02)
    (step,) = step_responses({"ranking": [brake]}, [brake["name"]])
    assert step.kept_back == pytest.approx(
        0.09, abs=0.002
    )  # the mean of the edges at 0.06 and 0.12
    assert step.settled == pytest.approx(0.02 * np.log(91), rel=0.03)
    lagged = chain("a+lag", delay=0.0, tau=0.02)
    (step,) = step_responses({"ranking": [lagged]}, [lagged["name"]])
    assert step.kept_back == 0.0


def test_stages_that_change_nothing_do_not_stand_for_those_that_do() -> None:
    ranking = [
        entry("a+remanence+lag+effort-lag", 0.02092, 15),
        entry("a+remanence+lag", 0.02094, 14),
        entry("a+lag", 0.0565, 12),
    ]
    gain = stage_gain(ranking)
    assert gain is not None
    assert gain.added == ("remanence", "effort-lag")
    gain = stage_gain(ranking[:2])
    assert gain is not None
    assert gain.added == ("effort-lag",)


def entry(name: str, rmse: float | None, parameters: int) -> dict[str, Any]:
    return {"name": name, "test": {"rmse": [rmse, None, None]}, "parameters_count": parameters}


def test_which_models_are_shown() -> None:
    ranking = [
        entry("fnn-16", 1.0, 65),
        entry("hem+lag", 1.1, 8),
        entry("bingham", 2.0, 6),
        entry("quadratic", 3.0, 4),
    ]
    body = {"ranking": ranking, "recommended": "hem+lag", "best": "fnn-16"}
    assert list(shown_models(body).items()) == [
        ("hem+lag", "recommended"),
        ("fnn-16", "best"),
        ("bingham", "baseline"),
    ]
    only = {"ranking": ranking[2:3], "recommended": "bingham", "best": "bingham"}
    assert list(shown_models(only).items()) == [("bingham", "recommended")]


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.0, "0"),
        (1234.4, "1230"),
        (99.96, "100"),
        (9.996, "10.0"),
        (-0.00314159, "−0.00314"),
        (2.5e-7, "2.50·10⁻⁷"),
        (3.21e8, "3.21·10⁸"),
        (None, "–"),
        (float("inf"), "∞"),
    ],
)
def test_numbers(value: float | None, text: str) -> None:
    assert number(value) == text


def test_units() -> None:
    assert scale_for("N*m", 0.01).of(0.00404) == "4.04\u00a0mN·m"
    assert scale_for("N", 600.0).of(123.0) == "123\u00a0N"
    unknown = scale_for("?", 0.01)
    assert (unknown.unit, unknown.of(0.2)) == ("units as logged", "0.200\u00a0as logged")
    assert unknown.titled("field") == Axis("field", unknown.unit).title == "field [as logged]"
    for unit, size, said in (
        ("s", 2e-3, "ms"),
        ("N*m/(rad/s)", 3e-4, "10⁻⁶ N·m/(rad/s)"),
        ("1", 2.0, ""),
        ("N", 0.0, "N"),
    ):
        assert chart_scale(unit, size).unit == said
    assert chart_scale("N*m/(rad/s)", 3e-4).bare(3e-4) == "300"
    assert scale_for("", 0.01).of(0.25) == "0.250"
    assert percent_text(0.2154) == "21.5\u00a0%"
    assert span(-1.0, None) == "−1.00 to –"


@pytest.mark.slow
def test_flow_curves_go_through_their_own_rows(tmp_path: Path) -> None:
    """Rows made by a law lie on its curve."""
    from erclutch.fit.comparison import Settings, compare
    from erclutch.models.law_model import TorqueModel
    from erclutch.report.numbers.flow_curves import flow_curves

    n = 6000
    rng = np.random.default_rng(0)
    field = np.repeat(rng.choice([0.0, 1.0, 2.0], n // 300), 300)
    slip = 3.0 * np.sin(np.arange(n) / 70)
    effort = 2.0 * field**2 * np.tanh(slip / 0.1) + 0.3 * slip
    whole = rows_of(field, slip, effort, {"m": effort})
    found = compare(whole.data, Settings(models=("bingham/square",), lag="none"))
    model = found.entries[0].outcome.model
    assert isinstance(model, TorqueModel)
    (curves,) = flow_curves(whole, {model.name: model})
    assert curves.fields.tolist() == [0.0, 1.0, 2.0]
    assert curves.effort[2][-1] == pytest.approx(2.0 * 4.0 + 0.3 * curves.slip[-1], rel=1e-3)
    for level, dots in zip(curves.fields, curves.dots, strict=True):
        assert len(dots) > 50
        expected = 2.0 * level**2 * np.tanh(dots[:, 0] / 0.1) + 0.3 * dots[:, 0]
        assert dots[:, 1] == pytest.approx(expected, abs=1e-9)


def test_laws_with_the_same_curves_share_a_panel() -> None:
    """Near on both elements, and to the first of its group, not only to another one of it."""
    line = np.linspace(0.0, 1.0, 5)[None, :]
    near = {"a": (0.0, 0.0), "b": (0.9, 0.9), "c": (1.8, 0.9), "d": (0.0, 3.0)}
    curves = [
        [
            FlowCurves(name, k, np.zeros(1), line[0], line + shifts[k], ())
            for name, shifts in near.items()
        ]
        for k in range(2)
    ]
    found = grouped(curves, 1.0)
    assert [[(c.model, [o.model for o in c.alike]) for c in own] for own in found] == 2 * [
        [("a", ["b"]), ("c", []), ("d", [])]
    ]
    assert [len(own) for own in grouped(curves, 0.0)] == [4, 4]


def test_the_noise_of_a_signal_is_not_what_moves_slowly() -> None:
    rng, time = np.random.default_rng(3), np.arange(20_000) * 1e-3
    assert noise_of(5.0 * np.sin(6.0 * time) + rng.normal(0.0, 0.02, time.size)) == pytest.approx(
        0.02, rel=0.03
    )
    assert noise_of(np.repeat([0.0, 1.0], 500)) == noise_of(np.zeros(2)) == 0.0


def test_logs_of_different_rates_are_not_mixed() -> None:
    """Most rows held out are at 1 kHz; those at 200 Hz would put a tone where there is none."""
    from dataclasses import replace

    t = np.arange(30_000) / RATE
    e = np.sin(2 * np.pi * 40.0 * t) + 0.1 * noise(30_000)
    whole = rows_of(e, e, e, {"m": e * 0}, cuts=(25_000,))
    slow = Clock(
        np.concatenate([t[:25_000], np.arange(5000) / 200.0]),
        (Span(0, 25_000, 1e-3), Span(25_000, 30_000, 5e-3)),
    )
    test = np.zeros(30_000, np.bool_)
    test[15_000:] = True
    rows = replace(whole, data=replace(whole.data, clock=slow), test=test)
    found = spectrum(rows, ["m"])
    assert found is not None
    assert found.frequency[-1] == pytest.approx(500.0, rel=0.05)
    assert found.frequency[int(np.argmax(found.density["m"]))] == pytest.approx(40.0, rel=0.03)
    memory = autocorrelation(rows, ["m"])
    assert memory is not None
    assert memory.lag[1] == pytest.approx(1e-3)


@pytest.mark.slow
@given(
    st.lists(st.floats(-100, 100), min_size=1, max_size=60), st.integers(1, 20), st.floats(0, 200)
)
def test_a_field_is_still_where_its_last_rows_lie_close(
    values: list[float], width: int, reach: float
) -> None:
    from erclutch.report.numbers.flow_curves import rows_at_rest

    array = np.array(values)
    width = min(width, array.size)
    windows = [array[k - width + 1 : k + 1] for k in range(width - 1, array.size)]
    expected = [False] * (width - 1) + [bool(w.max() - w.min() <= reach) for w in windows]
    assert rows_at_rest(array, width, reach).tolist() == expected


def test_fields_without_rows_are_named() -> None:
    field = np.where(np.arange(6000) // 100 % 2, 2.0, 0.0)
    field[:10] = np.linspace(0.0, 2.0, 10)
    found = rare_fields(rows_of(field, np.sin(np.arange(6000.0)), field, {"m": field}), 0)
    assert found.tolist() == [0.5, 1.0, 1.5]


def test_rise_and_fall_have_labels_and_lines_of_their_own() -> None:
    from types import SimpleNamespace

    slow: dict[str, Any] = chain("a+rise-fall") | {
        "dynamics": {"delay": 0.0, "tau_rise": 0.002, "tau_fall": 0.05}
    }
    found = step_responses({"ranking": [slow]}, [slow["name"]])
    material: Any = SimpleNamespace(shown={slow["name"]: "best"}, titles={slow["name"]: "Slow"})
    panel, _ = step_panel(material, found)
    lines = [mark for mark in panel.marks if isinstance(mark, Line)]
    assert [(line.label, line.dashed) for line in lines] == [
        ("Slow, rise", False),
        ("Slow, fall", True),
    ]


def test_a_stage_without_numbers_has_no_heading() -> None:
    entry = {"name": "fnn-4+inertia", "title": "Network", "dynamics": {}, "fit": {"parameters": []}}
    assert stages_of(entry, "single", Units("N", "V", "m/s"))["stages"] == []


def test_the_constants_of_a_stage_are_its_own() -> None:
    """A flow index `m` stood among the constants of an inertia `m`, and one of both was lost."""
    flow_index = {"name": "m", "meaning": "flow index", "value": 0.5, "unit": "1"}
    inertia = {"name": "m_a", "meaning": "inertia", "value": 2.0, "unit": "N/(m/s^2)"}
    of_pair = {"name": "m_a_1", "meaning": "inertia, CH1", "value": 3.0, "unit": "N/(m/s^2)"}
    fit = {"parameters": [flow_index, inertia, of_pair]}
    entry = {"name": "herschel-bulkley+inertia", "title": "Law", "dynamics": {}, "fit": fit}
    units = Units("N", "V", "m/s")
    for device, meaning in (("single", "inertia"), ("coaxial", "inertia, CH1")):
        (stage,) = stages_of(entry, cast("DeviceName", device), units)["stages"]
        assert [row["meaning"] for row in stage["rows"]] == [meaning]


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.98765, "0.988"),
        (-0.00001, "0.000"),
        (-31.25, "-31.250"),
        (-6.57e200, "below -1000"),
        (float("nan"), "nan"),
    ],
)
def test_an_r2_far_below_zero_is_said_to_be_so_and_has_no_digits(value: float, text: str) -> None:
    assert r2_text(value) == text


def test_a_share_without_end_is_said_to_be_so_in_words() -> None:
    assert share_span(0.123, 0.456) == span(12.3, 45.6)
    assert share_span(0.123, 1e153).startswith("12.3 to more than 100")
    assert "e+" not in share_span(0.123, 1e153)
