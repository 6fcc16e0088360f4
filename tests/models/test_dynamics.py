"""The command's lag and delay: against solutions in closed form, a fine-step integration, and themselves."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from erclutch.arithmetic.dual import Dual, partial_of, value_of
from erclutch.models.stages import command_lag
from erclutch.signals.clock import Clock, Span, cut_spans
from tests.support.examples import examples

PERIOD = 1e-3
free = settings(max_examples=examples(40), deadline=None)


def respond(
    command: Any,
    clock: Clock,
    *,
    delay: Any,
    rise: Any,
    fall: Any | None = None,
    rows: Any = slice(None),
) -> Any:
    """The field in the fluid that follows a command, by the stage with one time constant or with two."""
    times = (rise,) if fall is None else (rise, fall)
    return command_lag.CommandLag("", "", fall is not None).respond(
        command, clock, (delay, *times), rows
    )


def clock_of(*rows: int, period: float = PERIOD, uniform: bool = True, seed: int = 0) -> Clock:
    """Spans of so many rows each, a gap of a second between them."""
    rng = np.random.default_rng(seed)
    time, spans, start = [], [], 0.0
    for count in rows:
        at = len(time)
        steps = np.full(count, period) if uniform else period * rng.uniform(0.5, 1.6, count)
        stamps = start + (np.arange(count) * period if uniform else np.cumsum(steps))
        time.extend(stamps)
        spans.append(Span(at, at + count, period if uniform else None))
        start = stamps[-1] + 1.0
    return Clock(np.array(time), tuple(spans))


def steps_of(rows: int, seed: int = 0, shortest: int = 4) -> np.ndarray:
    rng = np.random.default_rng(seed)
    return np.repeat(rng.random(rows), rng.integers(shortest, 30, rows))[:rows]


@pytest.mark.slow
@free
@given(tau=st.floats(2e-4, 0.5), at=st.integers(1, 50))
def test_step_response(tau: float, at: int) -> None:
    clock = clock_of(200)
    command = np.where(np.arange(200) >= at, 1.0, 0.0)
    field = respond(command, clock, delay=0.0, rise=tau)
    # A row's command holds over the sample that ends there.
    since = np.maximum(np.arange(200) - at + 1, 0) * PERIOD
    np.testing.assert_allclose(field, 1 - np.exp(-since / tau), atol=1e-12)


@pytest.mark.slow
@free
@given(rise=st.floats(2e-4, 0.1), fall=st.floats(2e-4, 0.1), sign=st.sampled_from([1.0, -1.0]))
def test_rise_and_fall_have_their_own_time_constants(rise: float, fall: float, sign: float) -> None:
    up, down, rows = 20, 120, 300
    k = np.arange(rows)
    command = np.where((k >= up) & (k < down), sign, 0.0)
    field = respond(command, clock_of(rows), delay=0.0, rise=rise, fall=fall)
    rising = 1 - np.exp(-(k - up + 1) * PERIOD / rise)
    falling = (1 - np.exp(-(down - up) * PERIOD / rise)) * np.exp(-(k - down + 1) * PERIOD / fall)
    expected = np.where(k < up, 0.0, np.where(k < down, rising, falling))
    np.testing.assert_allclose(field, sign * expected, atol=1e-12)


@pytest.mark.slow
@free
@given(
    samples=st.integers(0, 45),
    period=st.sampled_from([1e-3, 3.328e-4, 1 / 300, 0.2]),
    tau=st.floats(0.3, 20.0),
)
def test_a_delay_of_whole_samples_is_a_shift(samples: int, period: float, tau: float) -> None:
    clock, command = clock_of(150, period=period), steps_of(150, 1)
    prompt = respond(command, clock, delay=0.0, rise=tau * period)
    late = respond(command, clock, delay=samples * period, rise=tau * period)
    np.testing.assert_allclose(late[samples:], prompt[: 150 - samples], atol=1e-9)
    np.testing.assert_array_equal(late[:samples], command[0])


@pytest.mark.parametrize("uniform", [True, False])
@pytest.mark.parametrize("delay", [0.3e-3, 2.5e-3, 7.77e-3])
def test_a_fractional_delay_of_a_sine(delay: float, uniform: bool) -> None:
    clock = clock_of(2000, uniform=uniform)
    t, omega, tau = clock.time, 2 * np.pi * 5.0, 8e-3
    prompt = respond(np.sin(omega * t), clock, delay=0.0, rise=tau)
    late = respond(np.sin(omega * t), clock, delay=delay, rise=tau)
    # The settled response is a sine, whose amplitude and phase follow from a fit.
    settled = t > 0.2

    def phasor(x: np.ndarray) -> complex:
        basis = np.column_stack([np.cos(omega * t), np.sin(omega * t)])[settled]
        c, s = np.linalg.lstsq(basis, x[settled], rcond=None)[0]
        return complex(s, c)

    ratio = phasor(late) / phasor(prompt)
    assert abs(ratio) == pytest.approx(1.0, abs=1e-3)
    assert -np.angle(ratio) / omega == pytest.approx(delay, abs=0.03e-3)
    if uniform:
        expected = np.abs(phasor(prompt)) * np.sin(omega * (t - delay) + np.angle(phasor(prompt)))
        np.testing.assert_allclose(late[settled], expected[settled], atol=1e-3)


def test_it_starts_settled_and_a_gap_starts_anew() -> None:
    one, two = clock_of(60), clock_of(60, 80)
    command = steps_of(140, 3)
    for fall in (None, 2e-3):
        got = respond(command, two, delay=2.4e-3, rise=7e-3, fall=fall)
        np.testing.assert_allclose(
            got[:60], respond(command[:60], one, delay=2.4e-3, rise=7e-3, fall=fall), atol=1e-15
        )
        second = Clock(two.time[60:], (Span(0, 80, PERIOD),))
        np.testing.assert_allclose(
            got[60:], respond(command[60:], second, delay=2.4e-3, rise=7e-3, fall=fall), atol=1e-15
        )
        assert got[60] == command[60]
        np.testing.assert_array_equal(
            respond(np.full(140, 0.4), two, delay=1e-3, rise=7e-3, fall=fall), 0.4
        )


@pytest.mark.slow
@free
@given(
    delay=st.floats(0.0, 0.02), rise=st.floats(2e-4, 0.05), fall=st.none() | st.floats(2e-4, 0.05)
)
def test_a_clock_of_stamps_equals_a_uniform_one(
    delay: float, rise: float, fall: float | None
) -> None:
    uniform = clock_of(90, 40)
    stamps = Clock(uniform.time, tuple(Span(s.start, s.stop, None) for s in uniform.spans))
    command = steps_of(130, 4)
    one, two = (
        respond(command, clock, delay=delay, rise=rise, fall=fall) for clock in (uniform, stamps)
    )
    np.testing.assert_allclose(two, one, atol=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("uniform", [True, False])
@pytest.mark.parametrize(("rise", "fall"), [(6e-3, 6e-3), (3e-3, 9e-3)])
def test_it_solves_the_differential_equation(rise: float, fall: float, uniform: bool) -> None:
    clock = clock_of(120, uniform=uniform, seed=5)
    t, command = clock.time, steps_of(120, 6) - 0.3
    delay, fine = 4.3e-3, 400
    x, grid, states = command[0], [t[0]], [command[0]]
    for k in range(
        1, t.size
    ):  # Heun's method, the command held over the sample that ends at its row
        h = (t[k] - t[k - 1]) / fine
        for i in range(fine):

            def rate(state: float, u: float = command[k]) -> float:
                return (u - state) / (rise if abs(u) > abs(state) else fall)

            guess = x + h * rate(x)
            x += 0.5 * h * (rate(x) + rate(guess))
            grid.append(t[k - 1] + (i + 1) * h)
            states.append(x)
    prompt = respond(command, clock, delay=0.0, rise=rise, fall=None if rise == fall else fall)
    crossing = (
        3e-3 if rise != fall else 1e-5
    )  # where the sign turns inside a sample, one constant holds for all of it
    np.testing.assert_allclose(prompt, np.array(states)[::fine], atol=crossing)
    late = respond(command, clock, delay=delay, rise=rise, fall=None if rise == fall else fall)
    exact = np.interp(t - delay, grid, states)
    # Between rows a cubic stands for what bends at each step of the command.
    assert np.abs(late - exact).max() < 0.05
    assert np.sqrt(np.mean((late - exact) ** 2)) < 0.01


# --- derivatives ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("uniform", [True, False])
@pytest.mark.parametrize("delay", [0.0004, 0.0026, 0.0113])
@pytest.mark.parametrize("modes", [1, 2])
def test_derivatives_by_everything(modes: int, delay: float, uniform: bool) -> None:
    clock = clock_of(90, 70, uniform=uniform, seed=2)
    base = steps_of(160, 8)
    q = [delay, 4e-3, 11e-3, 1.3]

    def field(delay: Any, rise: Any, fall: Any, scale: Any) -> Any:
        command = scale * base + 0.1 * scale * scale
        return respond(command, clock, delay=delay, rise=rise, fall=fall if modes == 2 else None)

    out = field(*(Dual(v, {i: 1.0}) for i, v in enumerate(q)))
    np.testing.assert_allclose(value_of(out), field(*q), atol=1e-14)
    for i in (0, 1, 2, 3):
        h = 1e-6 * q[i]
        ahead, behind = ([v + s * h if j == i else v for j, v in enumerate(q)] for s in (1, -1))
        difference = (field(*ahead) - field(*behind)) / (2 * h)
        if modes == 1 and i == 2:
            assert partial_of(out, i) is not None
            assert np.all(np.asarray(partial_of(out, i)) == 0.0)
            continue
        assert np.abs(difference).max() > 0
        np.testing.assert_allclose(
            np.broadcast_to(partial_of(out, i), 160),
            difference,
            rtol=1e-5,
            atol=1e-5 * np.abs(difference).max(),
        )


def test_the_slope_by_delay_is_continuous_across_whole_samples() -> None:
    clock, command = clock_of(120), steps_of(120, 9)

    def slope(delay: float) -> np.ndarray:
        return np.asarray(
            partial_of(respond(command, clock, delay=Dual(delay, {0: 1.0}), rise=4e-3), 0)
        )

    for samples in (1, 3, 8):
        ahead, behind = slope((samples + 1e-7) * PERIOD), slope((samples - 1e-7) * PERIOD)
        interior = slice(samples + 2, None)
        np.testing.assert_allclose(
            ahead[interior], behind[interior], atol=1e-4 * np.abs(ahead).max()
        )


@pytest.mark.parametrize(
    "rows",
    [
        *(
            slice(None),
            slice(10, 90),
            slice(None, None, 7),
            slice(3, 120, 5),
            slice(58, 63),
            slice(0, 1),
            slice(0, 0),
        ),
        *(
            np.array([0, 3, 59, 60, 61, 129]),
            np.arange(1, 130),
        ),  # few rows have slopes of their own
    ],
    ids=str,
)
@pytest.mark.parametrize("uniform", [True, False])
def test_some_rows_equal_a_slice_of_all(rows: Any, uniform: bool) -> None:
    clock = clock_of(60, 70, uniform=uniform)
    command = Dual(steps_of(130, 10), {0: np.ones(130)})
    delay, rise, fall = (Dual(v, {i + 1: 1.0}) for i, v in enumerate((2.3e-3, 4e-3, 9e-3)))
    whole = respond(command, clock, delay=delay, rise=rise, fall=fall)
    some = respond(command, clock, delay=delay, rise=rise, fall=fall, rows=rows)
    np.testing.assert_array_equal(some.value, whole.value[rows])
    for i in range(4):
        np.testing.assert_array_equal(partial_of(some, i), partial_of(whole, i)[rows])


# --- modes and causality ----------------------------------------------------------------------------------------------

# Signs turn without turning exactly: where |u| = |x|, rounding decides on the mode.
commands = st.integers(0, 2**32 - 1).map(
    lambda seed: (
        steps_of(150, seed, shortest=1)
        * np.where(np.random.default_rng(seed).random(150) < 0.2, -0.83, 1.0)
    )
)
taus = st.floats(-3.7, 0.0).map(lambda e: 10.0**e)


@pytest.mark.slow
@settings(max_examples=examples(20), deadline=None)
@given(delay=st.floats(0.0, 20e-3), switches=st.booleans())
def test_rows_that_are_moved_have_the_bits_of_rows_that_are_looked_up(
    delay: float, switches: bool
) -> None:
    clock = clock_of(2400, 7, 1200)  # long spans, and one that is shorter than many a delay
    command = steps_of(3607)
    seeded = Dual(delay, {0: 1.0})
    fall = Dual(4e-3, {2: 1.0}) if switches else None
    moved, looked_up = (
        respond(command, clock, delay=seeded, rise=Dual(9e-3, {1: 1.0}), fall=fall, rows=rows)
        for rows in (slice(None), np.arange(3607))
    )
    np.testing.assert_array_equal(moved.value, looked_up.value)
    assert moved.partials.keys() == looked_up.partials.keys()
    for seed, partial in moved.partials.items():
        np.testing.assert_array_equal(partial, looked_up.partials[seed])


def row_by_row(u: np.ndarray, clock: Clock, up: np.ndarray, down: np.ndarray) -> np.ndarray:
    """x_k = x_{k-1} + share_k (u_k - x_{k-1}), settled at first, with the share of a rising or of a falling field."""
    out = u.copy()
    for span in clock.spans:
        for k in range(span.start + 1, span.stop):
            x = out[k - 1]
            share = up[k] if (u[k] - x) * x >= 0.0 else down[k]
            out[k] = share * u[k] - (share - 1.0) * x
    return out


@pytest.mark.slow
@settings(max_examples=examples(200), deadline=None)
@given(command=commands, rise=taus, fall=taus, uniform=st.booleans())
def test_the_search_for_the_modes_equals_the_row_by_row_one(
    command: np.ndarray, rise: float, fall: float, uniform: bool
) -> None:
    clock = clock_of(70, 80, uniform=uniform)
    x, _ = command_lag.lagged(command, clock, rise, fall)
    up, down = (
        np.broadcast_to(command_lag._share(clock, tau), command.shape) for tau in (rise, fall)
    )
    expected = row_by_row(command, clock, up, down)
    np.testing.assert_allclose(x, expected, atol=1e-12)


@pytest.mark.slow
@free
@given(tau=taus, command=commands)
def test_equal_time_constants_are_one(tau: float, command: np.ndarray) -> None:
    clock = clock_of(150)
    one = respond(command, clock, delay=1.7e-3, rise=tau)
    two = respond(command, clock, delay=1.7e-3, rise=tau, fall=tau)
    np.testing.assert_allclose(two, one, atol=1e-12)
    np.testing.assert_allclose(respond(-command, clock, delay=1.7e-3, rise=tau), -one, atol=1e-15)


@pytest.mark.slow
@free
@given(
    command=commands,
    k=st.integers(0, 148),
    delay=st.sampled_from([0.0, 1e-9, 0.4e-3, 1e-3, 3e-3, 5.5e-3]),
    fall=st.none() | taus,
    uniform=st.booleans(),
)
def test_the_future_does_not_change_the_past(
    command: np.ndarray, k: int, delay: float, fall: float | None, uniform: bool
) -> None:
    clock = clock_of(150, uniform=uniform)
    other = command.copy()
    other[k + 1 :] = np.random.default_rng(k).normal(size=149 - k)
    one, two = (respond(u, clock, delay=delay, rise=5e-3, fall=fall) for u in (command, other))
    # Rows whose t - delay lies at or before row k, and those that need only it.
    past = clock.time - delay <= clock.time[k] + 1e-15
    np.testing.assert_allclose(two[past], one[past], atol=1e-13)


# --- spans ------------------------------------------------------------------------------------------------------------


def test_cut_spans() -> None:
    spans = (Span(0, 10, 1e-3), Span(10, 20, None), Span(20, 21, 1e-3))
    assert cut_spans(spans, 0, 21) == spans[:2]
    assert cut_spans(spans, 5, 12) == (Span(0, 5, 1e-3), Span(5, 7, None))
    assert cut_spans(spans, 9, 11) == ()
    assert cut_spans(spans, 12, 12) == ()
