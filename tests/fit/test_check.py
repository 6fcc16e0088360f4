"""Each finding provoked, and each error; and a good log, of which nothing is said."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from erclutch.errors import CheckError
from erclutch.fit.checks.data_check import ONE_FIELD, STEADY_FIELD, check, steady_command
from erclutch.fit.checks.finding import Finding
from erclutch.fit.checks.sensor_check import sensor_findings
from erclutch.fit.comparison import Settings, compare
from erclutch.logs.clock.resample import RESAMPLED
from erclutch.logs.dataset import Dataset, joined
from erclutch.logs.held_out import hold_out
from erclutch.signals.clock import Clock, Span
from erclutch.signals.device import Element, Units
from erclutch.signals.recording import NO_FIELD

Array = NDArray[np.float64]
N = 4000


def good(n: int = N, seed: int = 0) -> Dataset:
    """Field and slip all over the place, passive effort."""
    rng = np.random.default_rng(seed)
    field = np.repeat(rng.uniform(0, 1000, -(-n // 20)), 20)[:n]
    field[rng.random(n) < 0.1] = 0.0
    slip = rng.uniform(-20, 20, n)
    effort = 1e-6 * field**2 * np.tanh(slip) + 0.01 * slip + 0.01 * rng.normal(size=n)
    clock = Clock(np.arange(n) / 1000, (Span(0, n, 1e-3),))
    return Dataset("single", (Element(field, slip),), effort, clock, Units("N*m", "V", "rad/s"))


def changed(
    data: Dataset,
    field: Array | None = None,
    slip: Array | None = None,
    effort: Array | None = None,
) -> Dataset:
    old = data.elements[0]
    element = Element(old.field if field is None else field, old.slip if slip is None else slip)
    return replace(data, elements=(element,), effort=data.effort if effort is None else effort)


def findings(data: Dataset, test: float = 0.3) -> tuple[Finding, ...]:
    return check(data, hold_out(data, test))


def only(found: tuple[Finding, ...]) -> Finding:
    assert len(found) == 1, [str(f) for f in found]
    return found[0]


def test_a_good_log_has_no_finding() -> None:
    assert findings(good()) == ()


@pytest.mark.parametrize(
    ("factor", "said"), [(1e3, "above the 2000"), (1e-7, "below the 0.0001"), (1.0, "")]
)
def test_a_magnitude_of_no_device(factor: float, said: str) -> None:
    data = good()
    found = [
        f
        for f in sensor_findings(changed(data, slip=data.elements[0].slip * factor))
        if f.subject == "slip"
    ]
    assert [said in f.message for f in found] == [True] * bool(said)


@pytest.mark.parametrize(
    ("note", "label"),
    [
        (
            "effort <- column M (2) [kN*m], converted to N*m (guessed from its name)",
            "-M (2) [kN*m]",
        ),
        ("effort <- column F, no unit: taken as logged (given)", "-F"),
        ("effort <- column F [N], sign turned (given)", "F [N]"),
        ("slip <- column F [N] (given)", "-NAME [unit]"),
    ],
)
def test_effort_against_slip_is_a_turned_sign(note: str, label: str) -> None:
    data = replace(good(), notes=(note,))
    finding = only(findings(changed(data, effort=-data.effort)))
    assert (finding.level, finding.subject) == ("warning", "sign")
    assert "opposes slip" in finding.message
    assert str(finding).endswith(f'Turn a sign, for example --effort "{label}".')


def _logs(*efforts: Array, names: tuple[str, ...] = ("a.csv", "b.csv", "c.csv")) -> Dataset:
    """Logs of one motion and field with these efforts, joined."""
    notes = ("effort <- column F [N] (guessed from its name)",)
    logs = [
        replace(changed(good(), effort=effort), sources=(name,), notes=notes)
        for name, effort in zip(names, efforts, strict=False)
    ]
    return joined(logs)


def test_a_log_whose_effort_opposes_its_slip_beside_others_is_named() -> None:
    effort = good().effort
    data = _logs(effort, -0.5 * effort, effort)
    finding = only(tuple(each for each in findings(data) if each.subject == "signs of logs"))
    assert finding.level == "warning"
    assert "effort opposes slip in b.csv and goes with it in a.csv, c.csv" in finding.message
    assert finding.remedy.endswith(
        'erclutch inspect "b.csv" --effort "-F [N]" --write-mapping "b.csv.toml"'
    )


def test_a_recording_of_a_file_is_turned_in_the_file() -> None:
    effort = good().effort
    data = _logs(effort, -effort, names=("a.xlsx: one", "a.xlsx: two"))
    finding = only(tuple(each for each in findings(data) if each.subject == "signs of logs"))
    assert "opposes slip in a.xlsx: two" in finding.message
    assert finding.remedy.endswith("turn the sign of that recording in the file")


def test_a_spring_and_a_zero_turn_no_log_round() -> None:
    data = good()
    spring = 5.0 * np.sin(np.arange(N) / 7.0)  # of no phase with the slip: no power to and fro
    offset = data.effort - 3.0 * float(np.max(np.abs(data.effort)))
    assert [f for f in findings(_logs(data.effort, spring, offset)) if "signs" in f.subject] == []
    turned_all = findings(_logs(-data.effort, -data.effort))
    assert [f.subject for f in turned_all if "sign" in f.subject] == ["sign"]


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_an_effort_that_falls_with_the_speed_of_a_motion_one_way_is_no_turned_sign(
    sense: float,
) -> None:
    data = good()
    slip = np.abs(data.elements[0].slip)  # starts from rest, and never turns
    falling = changed(data, slip=slip, effort=sense * (3.0 + 2.0 * np.exp(-slip / 2.0)))
    told = [finding for finding in findings(falling) if finding.subject == "sign"]
    assert len(told) == (sense < 0.0)


def test_an_offset_is_no_turned_sign() -> None:
    data = good()
    assert findings(changed(data, effort=data.effort - 50.0)) == ()


@pytest.mark.parametrize(("end", "word"), [(0.5, "largest"), (-0.5, "smallest")])
def test_a_saturated_sensor(end: float, word: str) -> None:
    data = good()
    clipped = np.minimum(data.effort, end) if end > 0 else np.maximum(data.effort, end)
    finding = only(findings(changed(data, effort=clipped)))
    assert (finding.level, finding.subject) == ("warning", "effort")
    assert f"{word} effort, {end:g}" in finding.message


def test_a_single_peak_is_no_saturation() -> None:
    data = good()
    effort = data.effort.copy()
    effort[7] = 5.0
    assert (
        "stands out from the rows beside, the first at 0.007 s with 5"
        in only(findings(changed(data, effort=effort))).message
    )


def smooth(seed: int = 0) -> Dataset:
    """A slip to and fro under steps of the field, with noise and quantised as by a converter."""
    data, t = good(seed=seed), np.arange(N) / 1000
    rng = np.random.default_rng(seed)
    slip = 20 * np.sin(9 * t) + 0.01 * rng.normal(size=N)
    field = np.repeat(rng.uniform(0, 1000, N // 200), 200)
    effort = 1e-6 * field**2 * np.tanh(slip) + 0.01 * slip + 0.01 * rng.normal(size=N)
    return changed(data, field=field, slip=np.round(slip, 2), effort=np.round(effort, 3))


def test_spikes_are_found_where_they_are_few_and_alone() -> None:
    data = smooth()
    assert sensor_findings(data) == ()
    effort = data.effort.copy()
    effort[[500, 900, 901]] += 1.5
    finding = only(sensor_findings(changed(data, effort=effort)))
    assert finding.message.startswith(
        "3 rows of the effort stand out from the rows beside, the first at 0.5 s with"
    )
    effort[1000:1200] += np.where(np.arange(200) % 2, 1.5, -1.5)  # ringing
    assert only(sensor_findings(changed(data, effort=effort))).message.startswith("3 rows")


@pytest.mark.parametrize("name", ["effort", "slip"])
def test_a_sensor_that_was_stuck(name: str) -> None:
    data = smooth()
    values = (data.effort if name == "effort" else data.elements[0].slip).copy()
    values[700:1200] = values[700] + 0.0123
    stuck = changed(data, effort=values) if name == "effort" else changed(data, slip=values)
    finding = next(f for f in sensor_findings(stuck) if f.subject == name)
    assert (
        f"for 500 rows from 0.7 s on while the {'slip' if name == 'effort' else 'effort'} moves"
        in finding.message
    )
    rest = changed(data, slip=np.where(np.arange(N) < 800, 0.0, data.elements[0].slip))
    assert not [f for f in sensor_findings(rest) if "stuck" in f.message]


@pytest.mark.parametrize("name", ["effort", "slip"])
@pytest.mark.parametrize("rows", [3, 10, 25])
def test_a_signal_that_was_sampled_slowly_and_held(name: str, rows: int) -> None:
    """A held signal is late by half its period in the mean; nobody was told."""
    data = smooth()
    values = data.effort if name == "effort" else data.elements[0].slip
    held = values[np.arange(N) // rows * rows]
    other = "slip" if name == "effort" else "effort"
    slow = changed(data, effort=held) if name == "effort" else changed(data, slip=held)
    (finding,) = [f for f in sensor_findings(slow) if "held in between" in f.message]
    assert f"the {name} changes once in {rows} rows, and the {other} in" in finding.message
    assert finding.remedy.endswith(f"--resample {1000 / rows:.3g}")


def test_counts_of_an_encoder_and_every_second_row_are_not_held() -> None:
    data = smooth()
    slip = data.elements[0].slip
    for values in (np.round(slip), slip[np.arange(N) // 2 * 2], slip):
        found = sensor_findings(changed(data, slip=values))
        assert not [f for f in found if "held in between" in f.message]
    ramp = np.floor(np.arange(N) / 10.0)  # a slow course in counts
    assert not [f for f in sensor_findings(changed(data, slip=ramp)) if "held" in f.message]


def test_a_differenced_encoder() -> None:
    data = good()
    finding = only(findings(changed(data, slip=np.round(data.elements[0].slip))))
    assert (finding.level, finding.subject) == ("warning", "slip")
    assert "41 values, 1 apart" in finding.message


def test_test_rows_where_nothing_was_trained() -> None:
    data = good()
    slip = data.elements[0].slip.copy()
    slip[3600:] += 40.0
    finding = only(findings(changed(data, slip=slip)))
    assert (finding.level, finding.subject) == ("warning", "coverage")
    share = float(finding.message.split("%")[0])
    assert 20.0 < share <= 34.0  # 400 of 1200 rows, those that overlap less


def test_a_field_that_never_falls_to_zero() -> None:
    data = good()
    finding = only(findings(changed(data, field=data.elements[0].field + 200.0)))
    assert (finding.level, finding.subject) == ("note", "coverage")
    assert "never falls below 200 V, so" in finding.message


def coaxial(both: int) -> Dataset:
    data, rng = good(), np.random.default_rng(1)
    first = data.elements[0]
    second = np.repeat(rng.uniform(0, 1000, N // 20), 20)
    on = np.repeat(rng.random(N // 20) < 0.5, 20)
    other = np.where(on, 0.0, second)
    other[np.flatnonzero(on & (first.field > 0))[:both]] = 500.0
    elements = (
        Element(np.where(on, first.field, 0.0), first.slip),
        Element(other, rng.uniform(-20, 20, N)),
    )
    effort = sum(1e-6 * e.field**2 * np.tanh(e.slip) + 0.01 * e.slip for e in elements)
    return replace(data, device="coaxial", elements=elements, effort=np.asarray(effort))


def test_both_clutches_under_field() -> None:
    finding = only(findings(coaxial(40)))
    assert (finding.level, finding.subject) == ("warning", "fields")
    assert "in 40 rows (1.0 %)" in finding.message
    assert findings(coaxial(0)) == ()


def test_several_findings_at_once() -> None:
    data = good()
    field = data.elements[0].field + 200.0
    found = findings(changed(data, field=field, effort=-data.effort))
    assert [f.subject for f in found] == ["sign", "coverage"]


# --- errors -----------------------------------------------------------------------------------------------------------


def error_of(data: Dataset, test: float = 0.3) -> str:
    with pytest.raises(CheckError) as caught:
        findings(data, test)
    return str(caught.value)


def test_too_few_rows() -> None:
    assert error_of(good(60)) == (
        "log: 42 rows to train on, at least 50 are needed. Log for longer, or hold out less with --test."
    )


@pytest.mark.parametrize("test", [1e-9, ()])
def test_a_comparison_holds_at_least_a_row_out(test: float | tuple[str, ...]) -> None:
    with pytest.raises(CheckError) as caught:
        compare(good(60), Settings(test=test))
    assert str(caught.value) == (
        "log: none of 60 rows is held out. Hold out some with --test, such as --test 0.3."
    )


@pytest.mark.parametrize("value", [2.5, 0.0, -1.0])
def test_a_constant_field(value: float) -> None:
    finding = only(findings(changed(good(), field=np.full(N, value))))
    assert (finding.level, finding.subject) == ("warning", STEADY_FIELD)
    assert (
        f"the field is {value:g} V in all 4000 rows: models are fitted without field terms"
        in finding.message
    )
    assert "cannot know the effort at any other field" in finding.message


def test_no_field_at_all() -> None:
    data = replace(
        changed(good(), field=np.zeros(N)), notes=(f"{NO_FIELD}: taken as one constant field",)
    )
    finding = only(findings(data))
    assert "the log has no field" in finding.message
    assert "nor which field this was" in finding.message


@pytest.mark.slow
def test_a_log_of_which_no_row_is_left_is_no_odd_log() -> None:
    """Of a part of some logs, as one field of them, the check ended in a traceback: no row has no largest slip."""
    logs = joined([replace(good(seed=seed), sources=(f"log {seed}",)) for seed in range(3)])
    without = logs.take(np.arange(logs.rows) >= N)
    assert {finding.subject for finding in findings(without)} <= {"coverage"}


def test_a_field_that_changes_only_in_the_test_rows() -> None:
    """The field moves at the end; one that stands at another level there is held out at both levels."""
    field = np.full(N, 2.5)
    field[3500:] = 1.0 + np.sin(np.arange(500) / 20.0)
    message = error_of(changed(good(), field=field))
    assert (
        "the field is constant at 2.5 V over 2800 training rows, and only the rows held out have others"
        in message
    )
    assert "--test" in message


@pytest.mark.parametrize("name", ["slip", "effort"])
def test_a_constant_signal(name: str) -> None:
    data = good()
    flat = (
        changed(data, slip=np.full(N, 3.0), field=np.full(N, 500.0))
        if name == "slip"
        else changed(data, effort=np.full(N, 3.0))
    )
    message = error_of(flat)
    assert f"the {name} is constant at 3 over 2800 training rows" in message
    assert f"mapped to {name}" in message


def test_one_slip_under_a_changing_field_is_fitted_with_a_warning() -> None:
    data = good()
    field = data.elements[0].field
    noise = 0.01 * np.random.default_rng(1).normal(size=N)
    torque = 0.2 + 1e-6 * field**2 + noise
    at_one_speed = changed(data, slip=np.full(N, 3.0), effort=torque)
    finding = only(findings(at_one_speed))
    assert (finding.level, finding.subject) == ("warning", "slip")
    assert "3 rad/s in all rows" in finding.message


def test_a_slip_that_rests_or_keeps_one_speed_is_told() -> None:
    data = good()
    slip = 3.0 * (np.arange(N) // 50 % 2) + 1e-3 * np.random.default_rng(2).normal(size=N)
    slip[::50] = 1.5  # starts and stops
    found = findings(changed(data, slip=slip, effort=np.tanh(slip) + 0.1 * data.effort))
    (finding,) = (each for each in found if "no model knows" in each.message)
    assert (finding.level, finding.subject) == ("warning", "slip")
    assert "the slip is 0 or 3 rad/s in nearly all rows" in finding.message


def test_two_speeds_beside_rest_are_two_slips() -> None:
    data = good()
    slip = np.array([0.0, 3.0, 1.0])[np.arange(N) // 50 % 3]
    found = findings(changed(data, slip=slip, effort=np.tanh(slip) + 0.1 * data.effort))
    assert not any("no model knows" in each.message for each in found)


def test_several_logs_are_counted() -> None:
    data = replace(good(60), sources=("a.csv", "b.csv"), source_rows=((0, 30), (30, 60)))
    assert error_of(data).startswith("2 logs: ")


@pytest.mark.slow
def test_logs_of_another_order() -> None:
    """One of three logs in mN m instead of N m."""
    data = good()
    thirds = ((0, 1300), (1300, 2600), (2600, N))
    logs = replace(data, sources=("a", "b", "c"), source_rows=thirds)
    test = np.zeros(N, np.bool_)
    test[3000:] = True
    assert check(logs, test) == ()
    effort = data.effort.copy()
    effort[1300:2600] *= 1000.0
    finding = only(check(replace(logs, effort=effort), test))
    assert (finding.level, finding.subject) == ("warning", "effort")
    assert "the effort of b is" in finding.message


def test_whether_the_command_ever_moves() -> None:
    data = good()
    assert not steady_command(data)
    steps = changed(data, field=np.repeat([1.0, 2.0], N // 2))
    assert not steady_command(steps)
    clock = Clock(data.clock.time, (Span(0, N // 2, 1e-3), Span(N // 2, N, 1e-3)))
    assert steady_command(replace(steps, clock=clock))  # each log at its own field


def test_a_measured_current_that_keeps_its_level_does_not_move() -> None:
    """The noise of four currents, a log each, got lags, and iron that kept all of that noise back."""
    noise = 0.003 * np.random.default_rng(0).standard_normal(N)
    data = good()
    halves = (Span(0, N // 2, 1e-3), Span(N // 2, N, 1e-3))
    logs = replace(
        changed(data, field=np.repeat([0.0, 1.5], N // 2) + noise),
        clock=Clock(data.clock.time, halves),
    )
    assert steady_command(logs)
    ramp = np.linspace(0.0, 0.06, N)  # as wide as the noise may be, and no noise
    (element,) = logs.elements
    assert not steady_command(
        replace(logs, elements=(replace(element, field=element.field + ramp),))
    )
    random = np.random.default_rng(1).uniform(0.0, 2.0, N)  # anew in each row, and no noise
    assert not steady_command(changed(data, field=random))


def test_one_field_held_out_tests_no_field() -> None:
    data = good()
    field = data.elements[0].field.copy()
    field[-(N * 3 // 10) - 1 :] = 500.0
    finding = only(tuple(f for f in findings(changed(data, field=field)) if f.subject == ONE_FIELD))
    assert "the same field, 500 V" in finding.message


def test_a_pair_s_sign_is_turned_by_its_own_option() -> None:
    one = good()
    pair = replace(
        one, device="coaxial", elements=(one.elements[0], one.elements[0]), effort=-one.effort
    )
    (sign,) = (f for f in findings(pair) if f.subject == "sign")
    assert '--T "-' in sign.remedy


def swinging(rate: float) -> Dataset:
    """A swing of 0.8 rad, and a position that runs away at a rate in rad/s."""
    data = good()
    swing = (
        20.0 * np.cos(2.0 * np.pi * 10.0 * data.clock.time) * (1.0 + 0.2 * np.sin(data.clock.time))
    )
    return changed(
        data, slip=swing + rate, effort=1e-6 * data.elements[0].field ** 2 * np.sign(swing)
    )


def test_a_position_that_drifts_is_said() -> None:
    found = [f for f in findings(swinging(1.0)) if f.subject == "drift"]
    assert only(tuple(found)).message.startswith(
        "the position drifts by 3.98 rad in 4 s while it swings by 0.764 rad"
    )
    assert "Check the sensor's zero" in str(found[0])


@pytest.mark.parametrize("rate", [0.0, 0.3, 30.0])
def test_a_swing_or_a_turning_device_does_not_drift(rate: float) -> None:
    assert not [f for f in findings(swinging(rate)) if f.subject == "drift"]


@pytest.mark.slow
def test_rows_between_two_gaps_do_not_drift() -> None:
    """A log with many gaps has stretches of a few rows: a straight line, about which nothing swings."""
    data = swinging(1.0)
    spans = tuple(Span(start, start + 2, 1e-3) for start in range(0, N, 2))
    assert not [
        f
        for f in findings(replace(data, clock=replace(data.clock, spans=spans)))
        if f.subject == "drift"
    ]


# --- each limit from both sides ---------------------------------------------------------------------------------------


def subjects(data: Dataset, test: float = 0.3) -> list[str]:
    return [f.subject for f in findings(data, test)]


def test_fifty_rows_are_enough() -> None:
    data = good(72)
    test = np.arange(72) >= 50
    assert check(data, test) is not None
    test[49] = True
    with pytest.raises(CheckError, match="49 rows to train on, at least 50"):
        check(data, test)


@pytest.mark.parametrize(("rows", "said"), [(20, False), (21, True)])
@pytest.mark.parametrize("end", [5.0, -5.0])
def test_half_a_percent_of_the_rows_at_an_end_are_no_saturation(
    rows: int, said: bool, end: float
) -> None:
    data = good()
    effort = data.effort.copy()
    effort[100 : 100 + 8 * rows : 8] = end
    assert (
        any("may be saturated" in f.message for f in sensor_findings(changed(data, effort=effort)))
        == said
    )


@pytest.mark.parametrize(
    ("effort", "slip", "said"),
    [
        ("N", "rad/s", True),
        ("N*m", "m/s", True),
        ("N", "m/s", False),
        ("N*m", "rad/s", False),
        ("V", "m/s", False),
    ],
)
def test_a_force_beside_a_turning_speed_is_told(effort: str, slip: str, said: bool) -> None:
    found = sensor_findings(replace(good(), units=Units(effort, "V", slip)))
    assert [f.message for f in found if f.subject == "units"] == [
        f"an effort in {effort} beside a slip in {slip} makes no power"
    ] * said


@pytest.mark.parametrize(
    ("name", "unit", "least", "most"),
    [
        ("slip", "m/s", 1e-5, 20.0),
        ("slip", "rad/s", 1e-4, 2e3),
        ("effort", "N", 1e-3, 1e6),
        ("effort", "N*m", 1e-6, 1e5),
    ],
)
def test_magnitudes_of_devices(name: str, unit: str, least: float, most: float) -> None:
    data = good()
    for size, said in (
        (0.99 * least, "below"),
        (1.01 * least, ""),
        (0.99 * most, ""),
        (1.01 * most, "above"),
    ):
        wave = size * np.where(np.arange(N) % 2, 1.0, -1.0)
        wave[::50] *= 0.5  # 2 % of smaller ones: the largest 1 % are at the size
        wave[7] *= 100.0  # one that does not count
        units = Units("N*m", "V", unit) if name == "slip" else Units(unit, "V", "rad/s")
        new = replace(changed(data, **{name: wave}), units=units)
        found = [
            f
            for f in sensor_findings(new)
            if f.subject == name and "such devices have" in f.message
        ]
        assert [said in f.message for f in found] == [True] * bool(said)
    zero = changed(data, **{name: np.zeros(N)})
    assert not [f for f in sensor_findings(zero) if "such devices have" in f.message]


@pytest.mark.parametrize(("rate", "said"), [(0.55, False), (0.59, True)])
def test_a_drift_is_three_swings(rate: float, said: bool) -> None:
    assert ("drift" in subjects(swinging(rate))) == said
    assert ("drift" in subjects(swinging(-rate))) == said


@pytest.mark.parametrize(("share", "said"), [(0.19, False), (0.22, True)])
def test_a_fifth_of_the_rows_the_other_way_are_to_and_fro(share: float, said: bool) -> None:
    data = good()
    for turn in (1.0, -1.0):
        slip = turn * np.where(np.arange(N) % 100 < 100 * share, -1.0, 2.0)
        assert ("drift" in subjects(changed(data, slip=slip, effort=slip))) == said


@pytest.mark.parametrize(("levels", "said"), [(2, False), (3, True), (64, True), (65, False)])
def test_an_encoder_has_few_levels(levels: int, said: bool) -> None:
    data = good()
    slip = np.floor((data.elements[0].slip + 20.0) / 40.0 * levels) - levels / 2 + 0.25
    assert np.unique(slip).size == levels
    found = [f for f in findings(changed(data, slip=slip)) if "differenced encoder" in f.message]
    assert [f"{levels} values, 1 apart" in f.message for f in found] == [True] * said


@pytest.mark.parametrize(("low", "said"), [(49.0, False), (54.0, True)])
def test_a_field_near_zero_is_within_a_twentieth(low: float, said: bool) -> None:
    data = good()
    field = np.clip(data.elements[0].field, low, 1000.0)
    field[0] = 1000.0
    for turn in (1.0, -1.0):
        assert ("coverage" in subjects(changed(data, field=turn * field))) == said


@pytest.mark.parametrize(
    ("factor", "said"), [(29.0, False), (31.0, True), (1 / 290.0, False), (1 / 310.0, True)]
)
@pytest.mark.parametrize("name", ["effort", "slip"])
def test_logs_of_one_order(factor: float, said: bool, name: str) -> None:
    data = good()
    thirds = ((0, 1300), (1300, 2600), (2600, N))
    values = np.where(np.arange(N) % 2, 1.0, -1.0)
    values[1300:2600] *= factor
    data = replace(changed(data, **{name: values}), sources=("a", "b", "c"), source_rows=thirds)
    found = [f for f in findings(data) if "that of the usual log 1" in f.message]
    assert [f"the {name} of b is {factor:.3g}," in f.message for f in found] == [True] * said


@pytest.mark.parametrize(("factor", "said"), [(290.0, False), (310.0, True), (0.0, False)])
def test_a_log_at_no_field_says_nothing_of_its_unit(factor: float, said: bool) -> None:
    data = good()
    thirds = ((0, 1300), (1300, 2600), (2600, N))
    field = np.ones(N)
    field[2600:] *= factor
    data = replace(changed(data, field=field), sources=("a", "b", "c"), source_rows=thirds)
    found = [f for f in findings(data, 0.4) if f.message.startswith("the field of c is")]
    assert [f.remedy for f in found] == ["Check the unit of the field"] * said


@pytest.mark.parametrize(("rows", "said"), [(11, False), (13, True)])
def test_one_percent_of_the_test_rows_may_be_outside(rows: int, said: bool) -> None:
    data = good()
    slip = data.elements[0].slip.copy()
    slip[-rows:] = 60.0
    assert ("coverage" in subjects(changed(data, slip=slip))) == said


def test_logs_at_other_rates_and_resampled_logs_are_noted() -> None:
    data = good()
    clock = Clock(data.clock.time, (Span(0, N // 2, 1e-3), Span(N // 2, N, 2e-3)))
    (note,) = (f for f in findings(replace(data, clock=clock)) if f.subject == "rate")
    assert note.message == (
        "the logs were sampled at 500 to 1000 Hz: a second of the fastest weighs more in the fit, and an export is "
        "called every 0.001 s unless --period says otherwise"
    )
    assert note.remedy.endswith("--resample 500")
    one, two = (f"{RESAMPLED} to {rate} Hz" for rate in (100, 200))
    for notes, said in (
        ((one,), f"logs were {one}"),
        (("x", one, two), f"logs were {one} (and 1 other ways)"),
    ):
        (note,) = (f for f in findings(replace(data, notes=notes)) if f.subject == "rate")
        assert (note.level, note.message) == ("note", said)


def test_both_fields_count_from_a_millionth() -> None:
    data = coaxial(0)
    first, second = data.elements
    for share, rows in ((0.5e-6, 0), (2e-6, 30)):
        little = second.field.copy()
        off = np.flatnonzero((first.field > 100.0) & (second.field == 0.0))[:30]
        little[off] = share * second.field.max()
        found = [
            f
            for f in findings(replace(data, elements=(first, Element(little, second.slip))))
            if f.subject == "fields"
        ]
        assert [f"in {rows} rows" in f.message for f in found] == [True] * bool(rows)


@pytest.mark.parametrize(("rows", "said"), [(20, True), (21, False)])
def test_spikes_are_few(rows: int, said: bool) -> None:
    data = smooth()
    effort = data.effort.copy()
    effort[50 : 50 + 100 * rows : 100] += 1.5
    assert (
        any(
            "rows of the effort stand out" in f.message
            for f in sensor_findings(changed(data, effort=effort))
        )
        == said
    )


@pytest.mark.parametrize(("row", "said"), [(3, False), (4, True), (N - 5, True), (N - 4, False)])
def test_a_spike_needs_rows_beside_it(row: int, said: bool) -> None:
    data = smooth()
    effort = data.effort.copy()
    effort[row] += 1.5
    found = [
        f
        for f in sensor_findings(changed(data, effort=effort))
        if "1 row of the effort stands out" in f.message
    ]
    assert bool(found) == said


@pytest.mark.parametrize(("size", "said"), [(0.2, False), (0.3, True)])
def test_a_spike_is_a_quarter_of_the_range(size: float, said: bool) -> None:
    t = np.arange(N) / 1000
    slip = np.sin(9 * t)
    effort = slip.copy()
    effort[1000] += 2 * size  # the range is 2
    assert (
        any(
            "stands out" in f.message
            for f in sensor_findings(changed(good(), slip=slip, effort=effort))
        )
        == said
    )


@pytest.mark.parametrize(("rows", "said"), [(49, False), (52, True)])
def test_a_stuck_sensor_stays_for_fifty_rows(rows: int, said: bool) -> None:
    data, t = good(), np.arange(N) / 1000
    slip, effort = 20.0 * np.sin(40 * t), np.sin(40 * t + 0.3)
    effort[700 : 700 + rows] = 2.0
    found = [
        f
        for f in sensor_findings(changed(data, slip=slip, effort=effort))
        if "may have been stuck" in f.message
    ]
    assert [f"stays at 2 for {rows} rows from 0.7 s on" in f.message for f in found] == [
        True
    ] * said
