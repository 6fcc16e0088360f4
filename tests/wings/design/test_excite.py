"""`erclutch excite`: sequences within a rig's limits, in every row that is written."""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import erclutch
from erclutch.errors import ErclutchError, RunError, SettingError, for_a_shell
from erclutch.wings.design.commands import excite as command
from erclutch.wings.design.courses import Bounds, Commands, GrowingSequence, course
from erclutch.wings.design.fill import (
    Stretch,
    Worth,
    chosen_sequence,
    coverage_share,
    papers_sequence,
)
from erclutch.wings.design.limit_options import LimitOptions
from erclutch.wings.design.limits import RigLimits, limits_of_file, limits_of_log, trailing_largest
from tests.support.command import good, run
from tests.support.examples import examples
from tests.support.pace import within
from tests.support.pair import pair_rows
from tests.support.rig_limits import (
    EXPONENT,
    HEAT,
    IDLE,
    NEEDED,
    OFTEN,
    RESTS,
    broken,
    random_limits,
)

BRAKE = RigLimits(field=2.0, speed=20.0, acceleration=500.0)
DAMPER = RigLimits(
    field=2.0, speed=0.5, acceleration=10.0, stroke=0.06, field_rate=100.0, heat=20.0, effort=1000.0
)


def excite(**options: Any) -> None:
    """The command, with the options of the limits beside the others, as on the command line."""
    of_limits = {each.name for each in fields(LimitOptions)}
    limits = LimitOptions(**{name: option for name, option in options.items() if name in of_limits})
    command.excite(
        limits=limits, **{name: option for name, option in options.items() if name not in of_limits}
    )


def some(low: float, high: float) -> st.SearchStrategy[float]:
    """Numbers whose size is drawn evenly."""
    return st.floats(math.log(low), math.log(high)).map(math.exp)


@st.composite
def drawn_limits(draw: st.DrawFn) -> RigLimits:
    """Limits of a small or a large rig; those that may be left out are, half of the time."""
    ranges = dict(NEEDED)
    for some_of in (*({name: ends} for name, ends in OFTEN.items()), HEAT):
        ranges |= some_of if draw(st.booleans()) else {}
    drawn = {name: draw(some(*ends)) for name, ends in ranges.items()}
    if "effort" in drawn and draw(st.booleans()):
        drawn["idle_effort"] = drawn["effort"] * draw(st.floats(*IDLE))
        drawn["slow_effort"] = drawn["idle_effort"] * draw(st.floats(*IDLE))
        drawn["exponent"] = draw(st.floats(*EXPONENT))
    return RigLimits(**drawn, rest=draw(st.sampled_from(RESTS)))


class Uncounted:
    """All stretches are worth the same, and no row is counted: a fifth of the time of a sequence."""

    def gains(self, sequence: GrowingSequence, offers: Sequence[Stretch]) -> list[float]:
        return [0.0] * len(offers)

    def take(self, sequence: GrowingSequence, stretch: Stretch) -> None:
        pass


def hold(
    limits: RigLimits,
    seed: int,
    rate: float,
    signed: bool,
    one_way: bool,
    candidates: int = 4,
    worth: Worth | None = None,
) -> None:
    """A sequence keeps its limits, or the limits are refused with the option that forbids."""
    if one_way and limits.stroke < math.inf:
        one_way = False
    refusal, commands = "", None
    try:
        rng = np.random.default_rng(seed)
        commands = chosen_sequence(
            limits, rate, 3.0, rng, worth, signed=signed, one_way=one_way, candidates=candidates
        )
    except SettingError as error:
        refusal = error.problem
    if commands is None:
        assert "--" in refusal
        return
    assert commands.speed.size == round(3.0 * rate)
    assert broken(commands, limits, rate, signed=signed) == [], (limits, seed, rate)
    assert not one_way or commands.speed.min() >= 0.0


@pytest.mark.slow
@given(
    drawn_limits(),
    st.integers(0, 1000),
    st.sampled_from([100.0, 333.3, 1000.0]),
    st.booleans(),
    st.booleans(),
)
@settings(max_examples=examples(60), deadline=None)
def test_no_sequence_breaks_a_limit(
    limits: RigLimits, seed: int, rate: float, signed: bool, one_way: bool
) -> None:
    hold(limits, seed, rate, signed, one_way)


@pytest.mark.slow
def test_of_ten_thousand_sequences_none_breaks_a_limit() -> None:
    """Drawn as above, by NumPy: Hypothesis took as long to draw limits as the sequences take."""
    for seed in range(10_000):
        rng = np.random.default_rng(seed)
        limits, rate = random_limits(rng), float(rng.choice([100.0, 333.3, 1000.0]))
        signed, one_way = (bool(rng.random() < 0.5) for _ in range(2))
        # A stretch that is not taken is looked at by nobody, and of one nothing is counted.
        hold(limits, seed, rate, signed, one_way, candidates=1, worth=Uncounted())


@pytest.mark.slow
def test_a_limit_that_is_broken_is_seen() -> None:
    commands = chosen_sequence(BRAKE, 1000.0, 5.0, np.random.default_rng(0))
    assert broken(commands, BRAKE, 1000.0) == []
    tighter = RigLimits(
        field=1.9, speed=19.0, acceleration=490.0, rest=0.6, stroke=0.1, field_rate=1.0
    )
    assert broken(commands, tighter, 1000.0) == [
        "field",
        "field_rate",
        "speed",
        "acceleration",
        "stroke",
        "rest",
    ]


@pytest.mark.slow
@pytest.mark.parametrize("limits", [BRAKE, DAMPER])
def test_the_sequence_covers_more_than_the_papers_draws(limits: RigLimits) -> None:
    shares = [
        coverage_share(
            sequence(limits, 1000.0, 20.0, np.random.default_rng(1)),
            limits,
            1000.0,
            20.0,
            signed=False,
            one_way=False,
        )
        for sequence in (chosen_sequence, papers_sequence)
    ]
    assert shares[0] > 1.1 * shares[1]


@pytest.mark.slow
def test_the_papers_draws_keep_the_limits_too() -> None:
    commands = papers_sequence(DAMPER, 1000.0, 20.0, np.random.default_rng(1))
    assert broken(commands, DAMPER, 1000.0) == []


@pytest.mark.slow
def test_a_small_effort_without_field_lets_a_rig_of_limited_power_turn_faster() -> None:
    limited = replace(BRAKE, heat=10.0, effort=5.0)
    idle = replace(limited, idle_effort=0.5)
    slow, fast = (
        chosen_sequence(each, 500.0, 6.0, np.random.default_rng(0)) for each in (limited, idle)
    )
    assert not broken(fast, idle, 500.0)
    assert np.mean(np.abs(fast.speed)) > 1.5 * np.mean(np.abs(slow.speed))


def test_the_effort_without_field_comes_from_a_log() -> None:
    """A SYNTHETIC log of 1 N m without field and 9 N m under the largest, felt for 20 ms after it is gone."""
    time = np.arange(4000) / 1000.0
    field = np.where(np.sin(2.0 * np.pi * 2.0 * time) > 0.0, 2.0, 0.0)
    felt = np.maximum(field, np.roll(field, 20))
    columns = {
        "field": field,
        "slip": 10.0 * np.sin(time),
        "effort": (1.0 + 4.0 * felt) * np.sign(np.sin(time)),
    }
    units = {"field": "A", "slip": "rad/s", "effort": "N*m"}
    log = erclutch.recording_from_arrays(columns, rate=1000.0, units=units)
    known = limits_of_log(erclutch.build_dataset(log))
    assert known["effort"] == 9.0
    assert known["idle_effort"] == pytest.approx(
        1.0, rel=0.02
    )  # lifted, so that no mean of a cell is above
    assert known["slow_effort"] == pytest.approx(1.0, rel=0.02)


def test_the_effort_that_the_heat_counts_follows_the_speed_and_the_field_of_a_log() -> None:
    """A SYNTHETIC log of 1 N m at rest, 4 N m more at the largest speed, and 6 N m by the square of the field."""
    rows = np.arange(60_000)
    field = np.repeat(2.0 * np.linspace(0.0, 1.0, 60), 1000)
    slip = 10.0 * np.sin(rows / 300.0)
    effort = np.sign(slip) * (1.0 + 0.4 * np.abs(slip) + 1.5 * field**2)
    units = {"field": "A", "slip": "rad/s", "effort": "N*m"}
    log = erclutch.recording_from_arrays(
        {"field": field, "slip": slip, "effort": effort}, rate=1000.0, units=units
    )
    known = limits_of_log(erclutch.build_dataset(log))
    assert known["slow_effort"] == pytest.approx(1.0, abs=0.6)  # the mean of the slowest quarter
    assert known["idle_effort"] == pytest.approx(5.0, abs=0.5)
    assert 1.4 < known["exponent"] < 2.2
    limits = RigLimits(**(known | {"rest": 0.0}))
    counted = limits.effort_at(field / limits.field, np.abs(slip) / limits.speed)
    power = np.mean(np.abs(slip * effort))
    assert power <= np.mean(np.abs(slip) * counted) < 1.25 * power


@pytest.mark.slow
def test_of_a_pair_the_heat_counts_the_field_alone() -> None:
    """Nobody commands its output, which more power would drive into its ends."""
    known = limits_of_log(pair_rows(4.0))
    assert "idle_effort" in known
    assert not {"slow_effort", "exponent"} & set(known)


def test_a_log_without_a_weak_field_counts_the_largest_effort() -> None:
    rows = np.arange(4000)
    columns = {
        "field": np.full(4000, 2.0),
        "slip": np.sin(rows / 50.0),
        "effort": 3.0 * np.sign(np.sin(rows / 50.0)),
    }
    units = {"field": "A", "slip": "rad/s", "effort": "N*m"}
    log = erclutch.recording_from_arrays(columns, rate=1000.0, units=units)
    known = limits_of_log(erclutch.build_dataset(log))
    assert known["idle_effort"] == known["effort"] == 3.0


@pytest.mark.slow
def test_the_heat_that_a_rig_may_take_is_used() -> None:
    """A stretch is paid by what it takes of the heat that is left: so little is left at the end."""
    limited = RigLimits(
        field=1.0, speed=20.0, acceleration=400.0, rest=0.1, heat=8.0, effort=2.0, idle_effort=0.5
    )
    commands = chosen_sequence(limited, 500.0, 8.0, np.random.default_rng(0))
    assert not broken(commands, limited, 500.0)
    felt = np.abs(commands.field)
    for before in range(1, 26):
        felt = np.maximum(
            felt, np.concatenate([np.zeros(before), np.abs(commands.field[:-before])])
        )
    counted = limited.effort_at(felt / limited.field, np.abs(commands.speed) / limited.speed)
    assert np.mean(counted * np.abs(commands.speed)) > 0.8 * limited.heat


@pytest.mark.slow
def test_a_sequence_has_rests_zero_fields_switches_and_slow_turns() -> None:
    commands = chosen_sequence(BRAKE, 1000.0, 20.0, np.random.default_rng(2))
    moving = np.abs(commands.speed) > 0.0
    assert np.mean((commands.field == 0.0) & moving) > 0.05
    assert np.count_nonzero(np.abs(np.diff(commands.field)) > 0.2) > 20
    slow = (
        (np.abs(commands.speed[1:]) < 1.0)
        & (np.abs(np.diff(commands.speed)) * 1000.0 < 100.0)
        & moving[1:]
    )
    assert np.mean(slow & (commands.field[1:] > 0.0)) > 0.02


@pytest.mark.slow
@pytest.mark.usefixtures("read_here")
@pytest.mark.parametrize("suffix", [".csv", ".parquet", ".mat"])
@pytest.mark.parametrize("device", ["brake", "clutch", "damper", "pair"])
def test_what_is_written_keeps_the_limits(tmp_path: Path, device: Any, suffix: str) -> None:
    path = tmp_path / f"commands{suffix}"
    stroke = None if device == "pair" else 7.0
    excite(
        out=path,
        device=device,
        seconds=4,
        largest=1.3,
        speed=17.0,
        acceleration=900.0,
        stroke=stroke,
        seed=3,
    )
    columns = erclutch.read_table(path).columns
    if device == "pair":
        assert not np.any((columns["E1"] > 0) & (columns["E2"] > 0))
        assert columns["theta_dot"].min() >= 0.0
        read = Commands(columns["E1"] - columns["E2"], columns["theta_dot"], 0.0 * columns["theta"])
    else:
        read = Commands(columns["field"], columns["slip"], columns["position"])
        ways = np.cumsum(read.speed + np.concatenate([[0.0], read.speed[:-1]])) / 2000.0
        np.testing.assert_allclose(read.position, ways, atol=1e-7)
    limits = RigLimits(field=1.3, speed=17.0, acceleration=900.0, stroke=stroke or math.inf)
    assert broken(read, limits, 1000.0, signed=device == "pair") == []


@pytest.mark.slow
def test_a_table_of_c_has_the_numbers(tmp_path: Path) -> None:
    path = tmp_path / "commands.h"
    excite(out=path, seconds=2, largest=1, speed=5, acceleration=100, field_unit="A")
    text = path.read_text()
    assert "#define ERCLUTCH_COMMANDS_ROWS 2000" in text
    assert "time [s], field [A], slip [rad/s], position [rad]" in text
    excite(
        out=tmp_path / "commands.csv",
        seconds=2,
        largest=1,
        speed=5,
        acceleration=100,
        field_unit="A",
    )
    rows = [
        [float(x) for x in line.strip(" {},").split(",")]
        for line in text.splitlines()
        if line.startswith("  {")
    ]
    log = erclutch.read_table(tmp_path / "commands.csv").columns
    np.testing.assert_array_equal(np.array(rows)[:, 1], log["field"])


@pytest.mark.slow
def test_limits_come_from_a_file_or_a_log_and_options_go_first(tmp_path: Path) -> None:
    file = tmp_path / "rig.toml"
    file.write_text("[limits]\nfield = 2\nspeed = 9.5\nacceleration = 300\nrest = 0.1\n")
    assert limits_of_file(file) == {"field": 2.0, "speed": 9.5, "acceleration": 300.0, "rest": 0.1}
    excite(out=tmp_path / "first.csv", seconds=3, rig_limits=file, speed=4.0)
    slip = erclutch.read_table(tmp_path / "first.csv").columns["slip"]
    assert 3.0 < np.abs(slip).max() <= 4.0
    from erclutch.logs.synthetic import write_synthetic_log

    write_synthetic_log(tmp_path / "log.csv", 4.0)
    log = erclutch.read_table(tmp_path / "log.csv").columns
    excite(out=tmp_path / "second.csv", seconds=10, rig_limits=tmp_path / "log.csv")
    again = erclutch.read_table(tmp_path / "second.csv").columns
    largest = max(
        float(column.max())
        for name, column in log.items()
        if name.startswith(("field", "E", "current"))
    )
    assert 0.99 * largest < again["field"].max() <= largest


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "no table"),
        ("[limits]\nsped = 1", "'sped'"),
        ("[limits]\nspeed = true", "True"),
        ("[limits", "TOML"),
        ("limits = 3", "no table"),
    ],
)
def test_a_limits_file_that_cannot_be(tmp_path: Path, text: str, said: str) -> None:
    file = tmp_path / "rig.toml"
    file.write_text(text)
    with pytest.raises(SettingError, match=said):
        limits_of_file(file)


FINE: dict[str, Any] = {"largest": 1.0, "speed": 5.0, "acceleration": 100.0, "seconds": 5.0}


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"speed": None}, "--speed NUMBER"),
        ({"rest": 3.0}, "--rest 3"),
        ({"acceleration": 0.1}, "--acceleration lets the speed reach"),
        ({"stroke": 1e-5}, "--stroke"),
        ({"heat": 1e-6, "largest_effort": 10.0}, "--heat lets the speed reach"),
        ({"heat": 1.0}, "--largest-effort"),
        ({"field_rate": 0.01}, "--field-rate lets the field reach"),
        ({"largest": -1.0}, "--largest -1"),
        ({"largest": math.nan}, "--largest nan"),
        ({"stroke": 1.0, "one_way": True}, "--one-way"),
        ({"sequence": "paper"}, "--sequence paper"),
        ({"where": "field 0..2"}, "Give --run"),
        ({"seconds": 0.0}, "--seconds 0"),
        ({"rate": 0.0}, "--rate 0"),
    ],
)
def test_limits_that_leave_no_sequence_are_refused_with_the_limit(
    tmp_path: Path, options: dict[str, Any], said: str
) -> None:
    with for_a_shell(), pytest.raises(ErclutchError, match=said):
        excite(out=tmp_path / "c.csv", **{**FINE, **options})
    assert not list(tmp_path.iterdir())


@pytest.mark.slow
def test_a_file_is_not_replaced_unasked(tmp_path: Path) -> None:
    mine = tmp_path / "mine.csv"
    mine.write_text("mine")
    paper: dict[str, Any] = {"sequence": "paper", "seconds": 1}
    for sequence in (paper, FINE):
        with pytest.raises(RunError, match="there is a file already"):
            excite(out=mine, **sequence)
    assert mine.read_text() == "mine"
    excite(out=mine, **FINE, force=True)


@pytest.mark.slow
def test_a_minute_at_1_khz_takes_less_than_five_seconds() -> None:
    for limits in (BRAKE, DAMPER):
        start = time.process_time()
        chosen_sequence(limits, 1000.0, 60.0, np.random.default_rng(0))
        assert within(time.process_time() - start, 5.0)


@pytest.mark.slow
def test_the_command_says_what_it_covers(tmp_path: Path) -> None:
    words = (
        "--seconds",
        "8",
        "--largest",
        "2",
        "--speed",
        "10",
        "--acceleration",
        "200",
        "--field-unit",
        "A",
    )
    said = " ".join(good("excite", *words, cwd=tmp_path).split())
    assert "Coverage of the commands" in said
    assert "by the paper's draws" in said
    assert run("excite", "--largest", "2", cwd=tmp_path).code == 2


# --- the paper's sequence ---------------------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.usefixtures("read_here")
@pytest.mark.parametrize("suffix", [".csv", ".parquet", ".mat"])
def test_a_command_sequence_is_what_section_3b_asks_for(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"commands{suffix}"
    excite(out=path, sequence="paper", seconds=20.0, seed=4)
    columns = erclutch.read_table(path).columns
    first, second, motor = (columns[name] for name in ("E1", "E2", "motor_torque"))
    assert first.size == 20_000
    assert not np.any((first > 0) & (second > 0))
    assert min(first.min(), second.min()) >= 0.0
    assert max(first.max(), second.max()) <= 0.5
    assert 0.04 <= motor.min() < motor.max() <= 0.15
    # Half a period of the torque lasts 5 to 250 ms: 100 to 2 Hz.
    held = np.diff(np.flatnonzero(np.diff(motor, prepend=np.nan, append=np.nan)))
    assert held[:-1].min() >= 5
    assert held.max() <= 250
    again = tmp_path / f"again{suffix}"
    excite(out=again, sequence="paper", seconds=20.0, seed=4)
    np.testing.assert_array_equal(erclutch.read_table(again).columns["E1"], first)


@pytest.mark.parametrize(
    "options",
    [
        {"seconds": 0.0},
        {"seed": -1},
        {"rate": 0.0},
        {"torque": (0.2, 0.1)},
        {"highest": 400.0},
        {"lowest": 200.0},
    ],
)
def test_a_sequence_that_cannot_be(tmp_path: Path, options: dict[str, Any]) -> None:
    with pytest.raises(SettingError):
        excite(out=tmp_path / "c.csv", sequence="paper", **options)
    assert not list(tmp_path.iterdir())


@pytest.mark.slow
@given(st.lists(st.integers(0, 9), max_size=40), st.integers(0, 50))
def test_the_largest_of_the_values_before_is_that_of_each_window(
    values: list[int], rows: int
) -> None:
    wanted = [max(values[max(0, row - rows) : row + 1]) for row in range(len(values))]
    assert trailing_largest(np.array(values, np.int64), rows).tolist() == wanted


PIECES = st.lists(st.tuples(st.integers(-50, 50), st.integers(1, 9), st.integers(0, 6)), max_size=6)


@pytest.mark.slow
@given(st.integers(-50, 50), PIECES, st.integers(0, 60))
def test_a_course_of_which_some_rows_are_enough_begins_like_the_whole(
    now: int, pieces: list[tuple[int, int, int]], enough: int
) -> None:
    whole = course(now, pieces)
    cut = course(now, pieces, enough)
    assert cut.size >= min(enough, whole.size)
    assert cut.tolist() == whole[: cut.size].tolist()
    assert pieces == [] or whole[-1:].tolist() in ([], [pieces[-1][0]])


def test_a_rig_at_rest_stops_by_resting() -> None:
    at_rest = GrowingSequence(Bounds.of(BRAKE, 1000.0, 5.0))
    for hold, rows in ((0, 1), (7, 7)):
        fields, speeds = at_rest.stop(hold)
        assert fields.tolist() == speeds.tolist() == [0] * rows
