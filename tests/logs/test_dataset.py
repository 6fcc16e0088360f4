from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from erclutch.errors import MappingError, SettingError
from erclutch.logs import recording_from_arrays
from erclutch.logs.dataset import Dataset, build_dataset
from erclutch.logs.held_out import hold_out, time_folds
from erclutch.logs.synthetic import synthetic_log
from erclutch.signals.clock import Clock, Span, stretches
from erclutch.signals.device import Element, Units
from erclutch.signals.recording import Recording
from erclutch.signals.speed import Derivative
from tests.support.examples import examples

UNITS = {"field": "V", "slip": "rad/s", "effort": "N*m"}


def recording(
    rows: int,
    name: str = "log.csv",
    *,
    segments: Sequence[tuple[int, int]] = (),
    units: dict[str, str] | None = None,
    signals: dict[str, np.ndarray] | None = None,
    uniform: bool = True,
) -> Recording:
    k = np.arange(rows, dtype=float)
    return Recording(
        name=name,
        signals=signals or {"field": k, "slip": -k, "effort": 2 * k},
        units=units or UNITS,
        time=k * 1e-3,
        period=1e-3,
        segments=tuple(segments) or ((0, rows),),
        uniform=uniform,
        digest=hashlib.sha256(name.encode()).hexdigest(),
        notes=(f"note of {name}",),
    )


# --- building ---------------------------------------------------------------------------------------------------------


def test_logs_are_joined_in_order() -> None:
    data = build_dataset([recording(30, "a", segments=[(0, 12), (12, 30)]), recording(25, "b")])
    assert data.rows == 55
    assert data.sources == ("a", "b")
    assert data.source_rows == ((0, 30), (30, 55))
    assert data.clock.spans == (Span(0, 12, 1e-3), Span(12, 30, 1e-3), Span(30, 55, 1e-3))
    assert data.notes == ("note of a", "note of b")
    assert data.units == Units("N*m", "V", "rad/s")
    k = np.r_[0:30, 0:25]
    np.testing.assert_array_equal(data.elements[0].field, k)
    np.testing.assert_array_equal(data.elements[0].slip, -k)
    np.testing.assert_array_equal(data.effort, 2 * k)
    np.testing.assert_array_equal(data.clock.time, k * 1e-3)
    assert data.duration == pytest.approx(0.011 + 0.017 + 0.024)


def test_one_log_needs_no_list() -> None:
    one, listed = build_dataset(recording(20)), build_dataset([recording(20)])
    assert one.source_rows == listed.source_rows == ((0, 20),)
    np.testing.assert_array_equal(one.effort, listed.effort)


def test_stamps_without_a_period_keep_theirs() -> None:
    assert build_dataset(recording(20, uniform=False)).clock.spans == (Span(0, 20, None),)


def test_logs_in_different_units() -> None:
    other = recording(20, "b.csv", units={**UNITS, "effort": "N"})
    with pytest.raises(MappingError, match=r"units differ: .* here, .* in a\.csv") as caught:
        build_dataset([recording(20, "a.csv"), other])
    assert str(caught.value).startswith("b.csv: ")
    assert "a.csv" in str(caught.value)


@pytest.mark.parametrize("missing", ["field", "slip", "effort"])
def test_a_signal_is_missing(missing: str) -> None:
    signals = {name: np.zeros(20) for name in UNITS if name != missing}
    with pytest.raises(MappingError, match=f"no signal {missing} for device single"):
        build_dataset(recording(20, signals=signals))


def test_no_log_and_no_such_device() -> None:
    with pytest.raises(SettingError, match="no log"):
        build_dataset([])
    device: Any = "triple"
    with pytest.raises(SettingError, match="unknown device 'triple'"):
        build_dataset(recording(20), device=device)


def test_positions_are_differentiated_segment_by_segment() -> None:
    position = np.r_[np.arange(20) * 2e-3, 5 + np.arange(20) * 3e-3]
    log = recording(
        40,
        segments=[(0, 20), (20, 40)],
        signals={"field": np.zeros(40), "position": position, "effort": np.zeros(40)},
        units={"field": "V", "position": "rad", "effort": "N*m"},
    )
    data = build_dataset(log)
    np.testing.assert_allclose(data.elements[0].slip, np.repeat([2.0, 3.0], 20), rtol=1e-9)
    assert data.units.slip == "rad/s"
    assert "slip <- position by the savgol derivative" in data.notes
    assert not any("plays no part" in note for note in data.notes)
    late = build_dataset(log, derivative=Derivative("difference"))
    assert late.elements[0].slip[20] == 0.0


def test_a_filter_of_speeds_is_said_to_play_no_part_where_the_slip_is_logged() -> None:
    said = "the filter of speeds that was asked for plays no part: each speed is logged"
    assert said in build_dataset(recording(20), derivative=Derivative("central")).notes
    assert said not in build_dataset(recording(20)).notes


def test_the_usual_filter_gives_way_to_central_differences_where_a_log_has_no_rows_for_it() -> None:
    place = np.sin(np.arange(43) / 5)
    units = {"field": "V", "position": "rad", "effort": "N*m"}

    def swing(
        rows: slice, segments: Sequence[tuple[int, int]], *, uniform: bool = True
    ) -> Recording:
        part = place[rows]
        signals = {"field": 0.0 * part, "position": part, "effort": 0.0 * part}
        return recording(
            part.size, segments=segments, signals=signals, units=units, uniform=uniform
        )

    def slip(log: Recording, derivative: Derivative | None = None) -> np.ndarray:
        return build_dataset(log, derivative=derivative).elements[0].slip

    log = swing(slice(None), ((0, 20), (20, 23), (23, 43)))
    for rows in (slice(0, 20), slice(23, 43)):
        np.testing.assert_array_equal(slip(log)[rows], slip(swing(rows, ((0, 20),))))
    np.testing.assert_allclose(slip(log)[20:23], np.gradient(place[20:23], 1e-3))
    assert any(
        "in 1 of 3 segments by the central one: few rows stand there" in note
        for note in build_dataset(log).notes
    )

    uneven = swing(slice(None), ((0, 43),), uniform=False)
    np.testing.assert_allclose(slip(uneven), np.gradient(place, 1e-3))
    assert any(
        "central derivative, since the steps are unequal" in note
        for note in build_dataset(uneven).notes
    )
    with pytest.raises(SettingError, match="needs equal time steps"):  # chosen by the user
        slip(uneven, Derivative(window=7))


def test_a_segment_of_a_single_row_has_no_speed() -> None:
    """A lone row between two gaps is what `erclutch.read` makes of lost samples."""
    zero = np.zeros(40)
    log = recording(
        40,
        segments=[(0, 20), (20, 21), (21, 40)],
        signals={"field": zero, "position": zero, "effort": zero},
    )
    assert np.isfinite(build_dataset(log).elements[0].slip).all()


def test_a_logged_speed_comes_before_a_position() -> None:
    zero = np.zeros(20)
    log = recording(20, signals={"field": zero, "slip": zero + 4, "position": zero, "effort": zero})
    np.testing.assert_array_equal(build_dataset(log).elements[0].slip, 4.0)


def test_the_coaxial_pair() -> None:
    t = np.arange(50) * 1e-3
    log = recording(
        50,
        signals={"E": np.sign(np.sin(300 * t)) * 0.5, "theta": 8 * t, "alpha": 3 * t, "T": t},
        units={"E": "", "theta": "rad", "alpha": "rad", "T": "N*m"},
    )
    data = build_dataset(log, device="coaxial")
    first, second = data.elements
    np.testing.assert_allclose(first.slip, 5.0)
    np.testing.assert_allclose(second.slip, -11.0)
    assert np.all((first.field == 0) | (second.field == 0))
    assert data.units == Units("N*m", "", "rad/s")
    with pytest.raises(MappingError, match="no signal T for device coaxial"):
        build_dataset(
            recording(20, signals={n: np.zeros(20) for n in ("E", "theta", "alpha")}),
            device="coaxial",
        )


# --- rows of a mask ---------------------------------------------------------------------------------------------------


@st.composite
def datasets(draw: st.DrawFn) -> Dataset:
    """Up to three logs of up to three spans; the row's number is its effort."""
    lengths = draw(
        st.lists(st.lists(st.integers(2, 12), min_size=1, max_size=3), min_size=1, max_size=3)
    )
    spans, sources, at = [], [], 0
    for log in lengths:
        start = at
        for count in log:
            spans.append(Span(at, at + count, draw(st.sampled_from([1e-3, None]))))
            at += count
        sources.append((start, at))
    row = np.arange(at, dtype=float)
    return Dataset(
        "single",
        (Element(row * 2, row * 3),),
        row,
        Clock(row * 1e-3, tuple(spans)),
        Units("N", "V", "m/s"),
        tuple(f"log{i}" for i in range(len(sources))),
        tuple(sources),
    )


@pytest.mark.slow
@settings(max_examples=examples(200), deadline=None)
@given(data=datasets(), seed=st.integers(0, 2**32 - 1), share=st.floats(0, 1))
def test_take_keeps_rows_spans_and_sources(data: Dataset, seed: int, share: float) -> None:
    mask = np.random.default_rng(seed).random(data.rows) < share
    taken = data.take(mask)
    # Rows: those of the mask that have a neighbour in it, in the same span.
    home = np.empty(data.rows, int)
    for i, span in enumerate(data.clock.spans):
        home[span.start : span.stop] = i

    def beside(k: int, other: int) -> bool:
        return 0 <= other < data.rows and bool(mask[other]) and home[other] == home[k]

    expected = [k for k in range(data.rows) if mask[k] and (beside(k, k - 1) or beside(k, k + 1))]
    rows = taken.effort.astype(int)
    assert rows.tolist() == expected
    np.testing.assert_array_equal(taken.elements[0].field, rows * 2)
    np.testing.assert_array_equal(taken.elements[0].slip, rows * 3)
    np.testing.assert_array_equal(taken.clock.time, rows * 1e-3)
    # Spans: cover all rows in order, two rows at least, none across a removed row or an old gap.
    assert [k for s in taken.clock.spans for k in range(s.start, s.stop)] == list(range(taken.rows))
    for span in taken.clock.spans:
        here = rows[span.start : span.stop]
        assert here.size >= 2
        assert np.all(np.diff(here) == 1)
        old = data.clock.spans[home[here[0]]]
        assert old.start <= here[0] <= here[-1] < old.stop
        assert span.period == old.period
    # No cut that is not needed.
    for one, two in zip(taken.clock.spans[:-1], taken.clock.spans[1:], strict=True):
        a, b = rows[one.stop - 1], rows[two.start]
        assert b != a + 1 or home[a] != home[b]
    # Sources: each row stays with its log.
    assert taken.sources == data.sources
    for (a, b), (start, stop) in zip(taken.source_rows, data.source_rows, strict=True):
        assert rows[a:b].tolist() == [k for k in expected if start <= k < stop]


def test_take_all_and_nothing() -> None:
    data = build_dataset([recording(20, "a"), recording(10, "b")])
    whole = data.take(np.ones(30, np.bool_))
    assert whole.clock.spans == data.clock.spans
    assert whole.source_rows == data.source_rows
    np.testing.assert_array_equal(whole.effort, data.effort)
    empty = data.take(np.zeros(30, np.bool_))
    assert (empty.rows, empty.clock.spans, empty.source_rows) == (0, (), ((0, 0), (0, 0)))


# --- splits -----------------------------------------------------------------------------------------------------------


def test_a_share_is_the_end_of_each_log() -> None:
    data = build_dataset([recording(100, "a"), recording(40, "b")])
    mask = hold_out(data, 0.3)
    np.testing.assert_array_equal(np.flatnonzero(mask), [*range(70, 100), *range(128, 140)])


@pytest.mark.parametrize("share", [0.0, -0.1, 0.9, 1.0, 5, float("nan")])
def test_shares_that_are_none(share: float) -> None:
    with pytest.raises(SettingError, match="a test share of"):
        hold_out(build_dataset(recording(100)), share)


def test_patterns_take_whole_logs_by_the_file_s_name() -> None:
    data = build_dataset(
        [recording(20, n) for n in ("runs/a_1.txt", "runs/a_2.txt", "runs/b_1.txt")]
    )
    np.testing.assert_array_equal(np.flatnonzero(hold_out(data, ["a_2.txt"])), range(20, 40))
    np.testing.assert_array_equal(
        np.flatnonzero(hold_out(data, ["*_1.txt"])), [*range(20), *range(40, 60)]
    )
    np.testing.assert_array_equal(np.flatnonzero(hold_out(data, ["a_2*", "b*"])), range(20, 60))


def test_patterns_that_leave_nothing_or_match_nothing() -> None:
    data = build_dataset([recording(20, "a.txt"), recording(20, "b.txt")])
    with pytest.raises(SettingError, match="'c\\*' matches none of 2 logs"):
        hold_out(data, ["a.txt", "c*"])
    with pytest.raises(SettingError, match="all logs are held out"):
        hold_out(data, ["*"])


@pytest.mark.slow
@given(rows=st.integers(40, 400), count=st.integers(2, 8))
def test_blocks_put_each_row_into_one(rows: int, count: int) -> None:
    data = build_dataset(recording(rows))
    if rows // count < 20:
        with pytest.raises(SettingError, match=f"{count} blocks of {rows} rows"):
            time_folds(data, count)
        return
    masks = time_folds(data, count)
    assert len(masks) == count
    np.testing.assert_array_equal(np.sum(masks, axis=0), 1)
    for mask in masks:
        rows_of = np.flatnonzero(mask)
        assert np.all(np.diff(rows_of) == 1)
        assert abs(rows_of.size - rows / count) <= 1


@pytest.mark.parametrize("count", [-1, 0, 1])
def test_fewer_than_two_blocks(count: int) -> None:
    with pytest.raises(SettingError):
        time_folds(build_dataset(recording(100)), count)


def _steps(fields: Sequence[float], each: int = 100) -> Recording:
    """One constant field after another, with a gap between."""
    n = each * len(fields)
    signals = {
        "field": np.repeat(np.array(fields), each),
        "slip": np.sin(np.arange(n) / 7),
        "effort": np.ones(n),
    }
    return recording(
        n, segments=[(k * each, (k + 1) * each) for k in range(len(fields))], signals=signals
    )


def test_a_share_of_each_stretch_where_each_has_its_own_field() -> None:
    """The end of the log alone would be a field that training never sees."""
    mask = hold_out(build_dataset(_steps([0.0, 0.5, 1.0])), 0.3)
    np.testing.assert_array_equal(
        np.flatnonzero(mask), [*range(70, 100), *range(170, 200), *range(270, 300)]
    )


def test_gaps_at_one_field_are_no_stretches_of_their_own() -> None:
    mask = hold_out(build_dataset(_steps([0.5, 0.5])), 0.3)
    np.testing.assert_array_equal(np.flatnonzero(mask), range(140, 200))


def test_rows_at_rest() -> None:
    slip = np.r_[np.zeros(30), np.full(60, 2.0), np.full(10, 0.01)]
    signals = {"field": np.ones(100), "slip": slip, "effort": slip}
    still = build_dataset(recording(100, signals=signals)).at_rest
    np.testing.assert_array_equal(np.flatnonzero(still), [*range(30), *range(90, 100)])


# --- limits from both sides -------------------------------------------------------------------------------------------


def test_the_same_file_twice_is_refused() -> None:
    with pytest.raises(SettingError, match="the same file as a"):
        build_dataset([recording(20, "a"), replace(recording(20, "a"), name="b")])
    build_dataset([replace(recording(20, name), digest="") for name in ("a", "b")])


def test_speeds_and_fields_of_a_pair_have_one_unit() -> None:
    k = np.arange(20.0)
    signals = {"E1": k, "E2": k, "theta_dot": k, "alpha_dot": k, "T": k}
    units = {"E1": "V", "E2": "V", "theta_dot": "rad/s", "alpha_dot": "rad/s", "T": "N*m"}
    made = build_dataset(recording(20, signals=signals, units=units), device="coaxial")
    assert made.units == Units("N*m", "V", "rad/s")
    for name in ("E2", "alpha_dot"):
        with pytest.raises(MappingError, match=rf"(E1|theta_dot) is in .* and {name} in 1"):
            build_dataset(
                recording(20, signals=signals, units={**units, name: ""}), device="coaxial"
            )


def test_the_unit_of_a_speed_is_that_of_its_position() -> None:
    k = np.arange(20.0)
    for unit, speed in (("rad", "rad/s"), ("m", "m/s"), ("?", "?"), ("", "?")):
        signals = {"field": k, "position": 3 * k, "effort": k}
        made = build_dataset(recording(20, signals=signals, units={**UNITS, "position": unit}))
        assert made.units.slip == speed
        np.testing.assert_allclose(made.elements[0].slip, 3000.0)
        assert any(note.startswith("slip <- position by the ") for note in made.notes)


@pytest.mark.parametrize(
    ("rows", "most", "step"),
    [(100, 100, 1), (100, 99, 2), (100, 50, 2), (100, 49, 3), (100, 1000, 1)],
)
def test_thinned_rows_are_at_most_so_many(rows: int, most: int, step: int) -> None:
    found = build_dataset(recording(rows)).thinned(most)
    np.testing.assert_array_equal(found.effort, 2 * np.arange(rows)[::step])
    assert found.source_rows == ((0, found.rows),)
    assert found.clock.spans == ()


@pytest.mark.parametrize(
    ("second", "rates"), [(1.009e-3, None), (1.011e-3, (1 / 1.011e-3, 1000.0))]
)
def test_rates_within_a_percent_are_one(second: float, rates: tuple[float, float] | None) -> None:
    data = build_dataset([recording(20, "a"), recording(20, "b")])
    clock = replace(data.clock, spans=(Span(0, 20, 1e-3), Span(20, 40, second)))
    made = replace(data, clock=clock)
    assert made.period == 1e-3  # no period that no log has
    assert (
        replace(made, clock=replace(clock, spans=(Span(0, 15, 1e-3), Span(15, 40, second)))).period
        == second
    )
    assert made.rates == pytest.approx(rates or (1 / made.period, 1 / made.period))


def test_one_field_is_one_within_a_millionth() -> None:
    data = build_dataset(recording(40))
    for share, one in ((0.9e-6, True), (1.1e-6, False)):
        field = np.full(40, 5.0)
        field[3] *= 1.0 + share
        assert replace(data, elements=(Element(field, data.elements[0].slip),)).one_field == one


def test_rest_is_two_percent_of_the_usual_slip() -> None:
    data = build_dataset(recording(40))
    slip = np.where(np.arange(40) % 2, 1.0, -1.0)
    slip[:3] = 0.0185, 0.0205, -0.0185
    usual = float(np.sqrt(np.mean(slip**2)))
    made = replace(data, elements=(Element(data.elements[0].field, slip),))
    np.testing.assert_array_equal(made.at_rest, np.abs(slip) < 0.02 * usual)
    assert made.at_rest.tolist()[:4] == [True, False, True, False]


def test_inputs_of_all_logs_are_kept_in_their_order() -> None:
    k = np.arange(20.0)
    one = replace(recording(20, "a"), extras={"D": k, "only": k}, spare={"s": k}, origin="TWIN")
    other = replace(recording(20, "b"), extras={"D": -k}, spare={"s": -k, "t": k})
    made = build_dataset([one, other])
    assert (list(made.extras), list(made.spare)) == (["D"], ["s"])
    np.testing.assert_array_equal(made.extras["D"], np.concatenate([k, -k]))
    assert made.origins == ("TWIN", "")
    assert made.where == "2 logs"
    assert build_dataset(one).where == "a"


def test_a_further_input_in_two_units_is_refused() -> None:
    """Logs of one column in mm and in m were joined in silence."""
    k = np.arange(20.0)
    one = replace(recording(20, "a"), extras={"D": k}, extra_units={"D": "mm"})
    build_dataset([one, replace(one, name="b", digest="of b")])
    for unit, words in (("m", "in m here, in mm in a"), ("?", "as logged here, in mm in a")):
        other = replace(recording(20, "b"), extras={"D": k}, extra_units={"D": unit})
        with pytest.raises(MappingError, match=f"units of the further input D differ: {words}"):
            build_dataset([one, other])


@pytest.mark.parametrize(("share", "first"), [(0.3, 14), (0.5, 10), (0.89, 2)])
def test_a_share_is_rounded_to_rows(share: float, first: int) -> None:
    data = build_dataset([recording(20, "a"), recording(20, "b")])
    expected = np.r_[first:20, 20 + first : 40]
    np.testing.assert_array_equal(np.flatnonzero(hold_out(data, share)), expected)


def test_blocks_of_twenty_rows() -> None:
    data = build_dataset(recording(41))
    folds = time_folds(data, 2)
    assert [np.flatnonzero(f)[[0, -1]].tolist() for f in folds] == [[0, 19], [20, 40]]
    with pytest.raises(SettingError, match="3 blocks of 41 rows"):
        time_folds(data, 3)
    with pytest.raises(SettingError, match="2 blocks of 39 rows"):
        time_folds(build_dataset(recording(39)), 2)


@pytest.mark.parametrize("first", [0.0, -180.0])
def test_an_angle_that_starts_again_is_drawn_out(first: float) -> None:
    t = np.arange(4000) / 1000
    turned = np.degrees(25.0 * np.sin(2.0 * t) + 40.0 * t)
    units = {"field": "A", "position": "rad", "effort": "N*m"}
    signals = {"field": np.ones(t.size), "position": np.radians(turned), "effort": t}
    plain = build_dataset(recording_from_arrays(signals, units, rate=1000.0))
    signals["position"] = np.radians((turned - first) % 360.0 + first)
    wrapped = build_dataset(recording_from_arrays(signals, units, rate=1000.0))
    np.testing.assert_allclose(wrapped.elements[0].slip, plain.elements[0].slip, atol=1e-9)
    assert any("position starts again after a full turn" in note for note in wrapped.notes)
    assert not any("full turn" in note for note in plain.notes)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(3))
def test_stretches_held_out_are_like_the_log_and_lie_between_rows_that_are_fitted(
    seed: int,
) -> None:
    columns = synthetic_log(10.0, seed)
    signals = {
        name: columns[column][1]
        for name, column in (("field", "field"), ("slip", "slip"), ("effort", "torque"))
    }
    data = build_dataset(
        recording_from_arrays(
            signals, {"field": "V", "slip": "rad/s", "effort": "N*m"}, rate=1000.0
        )
    )
    mask = hold_out(data, ("stretches",))
    assert mask.mean() == pytest.approx(0.3, abs=0.01)
    assert not mask[: data.rows // 20].any()
    held = stretches(mask)
    assert len(held) == 6
    assert all(start - stop >= data.rows // 20 for (_, stop), (start, _) in pairwise(held))
    for values in (data.elements[0].field, data.elements[0].slip):
        assert np.std(values[mask]) == pytest.approx(np.std(values), rel=0.15)
    assert np.array_equal(mask, hold_out(replace(data, effort=-data.effort), ("stretches",)))


def test_the_end_of_a_log_too_short_for_stretches_is_held_out() -> None:
    data = build_dataset(recording(300))
    assert np.array_equal(hold_out(data, ("stretches",)), hold_out(data, 0.3))
