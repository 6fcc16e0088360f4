"""`erclutch live --program learn`: rounds on a rig, their tables, the motion that is foretold, and interruptions."""

from __future__ import annotations

import contextlib
import io
import json
import math
import multiprocessing
import os
import shutil
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rich.console import Console

import erclutch
from erclutch.errors import RunError, SettingError
from erclutch.fit.laws.fit_law import fit_structure
from erclutch.logs import read_table
from erclutch.logs.dataset import build_dataset
from erclutch.logs.log_reader import LEARN_REPORT
from erclutch.models.laws import law_from_name
from erclutch.models.structure import Structure
from erclutch.signals.channels import channels_of
from erclutch.wings.live.command_line import learn as learning
from erclutch.wings.live.command_line.learn import NO_LEARN, Rig, follow_round, share_of
from erclutch.wings.live.command_line.live_options import LoopOptions
from erclutch.wings.live.layout import EVENT_BITS
from erclutch.wings.live.learning.drawn_tables import TableLimits, drawn_table
from erclutch.wings.live.learning.foretold_motion import ForetoldMotion, LoggedRound
from erclutch.wings.live.learning.rounds import LearningRounds, RoundReport
from erclutch.wings.live.ring import State
from erclutch.wings.live.session import TWIN
from erclutch.wings.live.settings import LoopSettings
from erclutch.wings.rig.interface import Measurement, RigCommand
from erclutch.wings.rig.rig_server import RigServer
from erclutch.wings.rig.twin.parameters import default_rig
from erclutch.wings.rig.twin.twin import Twin
from tests.support.command import refused, run

BRAKE = TableLimits("single", 0.5, 0.95, 1000.0)
PAIR = TableLimits("coaxial", 0.5, 0.95, 1000.0)


def logged(table: Any, seed: int = 0) -> LoggedRound:
    """A round on the TWIN brake, without the loop."""
    twin = Twin(seed=seed, locked=True, single=True)
    rows = np.zeros((len(table), 3))
    for row, (field, _, drive) in enumerate(table.tolist()):
        measured = twin.sense()
        rows[row] = field, measured.theta, measured.torque
        twin.command(RigCommand(E1=field, motor_torque=drive))
        twin.step()
    field, position, effort = rows.T
    columns = {"field": field, "position": position, "effort": effort}
    log = erclutch.recording_from_arrays(
        columns, rate=1000.0, units={"field": "", "position": "rad", "effort": "N*m"}
    )
    return LoggedRound(build_dataset(log), table[:, 2])


@pytest.mark.parametrize("limits", [BRAKE, PAIR])
def test_a_table_stays_within_the_supply_and_ends_at_rest(limits: TableLimits) -> None:
    for seed in range(5):
        table = drawn_table(limits, 4.0, np.random.default_rng(seed))
        assert table.shape == (4000, 3)
        assert table[:, :2].min() >= 0.0
        assert table[:, :2].max() <= limits.field
        assert not np.any((table[:, 0] > 0.0) & (table[:, 1] > 0.0))
        assert np.abs(table[:, 2]).max() <= limits.drive
        assert not table[-200:].any()


@pytest.mark.slow
def test_the_motion_of_a_table_is_foretold_from_another_log() -> None:
    first, second = (
        logged(drawn_table(BRAKE, 3.0, np.random.default_rng(seed)), seed) for seed in (1, 2)
    )
    structure = Structure("single", "casson", law_from_name("casson", "single"), "lag", True, True)
    law = fit_structure(first.rows, structure, intervals=False).model
    assert second.drive is not None
    table = np.column_stack([second.rows.elements[0].field, np.zeros(3000), second.drive])
    foretold = ForetoldMotion(law, [first]).rows(table[None])[0]
    got = second.rows.elements[0].slip
    off = foretold.elements[0].slip - got
    assert np.sqrt(np.mean(off**2)) < 0.3 * np.sqrt(np.mean(got**2))


@pytest.mark.slow
def test_a_round_that_tripped_at_once_or_in_which_nothing_moved_teaches_nothing() -> None:
    table = drawn_table(BRAKE, 1.0, np.random.default_rng(1))
    assert logged(table).teaches
    assert not logged(table[:150]).teaches
    assert not logged(np.zeros((300, 3))).teaches


@pytest.mark.slow
def test_without_a_drive_the_motion_of_the_last_log_comes_again() -> None:
    first = logged(drawn_table(BRAKE, 2.0, np.random.default_rng(1)))
    structure = Structure(
        "single", "bingham", law_from_name("bingham", "single"), "lag", True, True
    )
    law = fit_structure(first.rows, structure, intervals=False).model
    held = LoggedRound(first.rows, None)
    foretold = ForetoldMotion(law, [held]).rows(np.zeros((1, 3000, 3)))[0]
    np.testing.assert_array_equal(
        foretold.elements[0].slip[2000:], first.rows.elements[0].slip[:1000]
    )


@pytest.mark.slow
def test_the_second_round_makes_the_intervals_narrower_as_foretold() -> None:
    """The motion is the TWIN's; the effort is that of a law with noise, so that the law is right."""
    structure = Structure(
        "single", "bingham", law_from_name("bingham", "single"), "lag", True, True
    )
    truth = fit_structure(
        logged(drawn_table(BRAKE, 3.0, np.random.default_rng(9))).rows, structure, intervals=False
    )
    rounds = LearningRounds(BRAKE, 0, 1000.0)
    rng = np.random.default_rng(0)
    for number in range(2):
        played = logged(rounds.next_table(4.0), number)
        effort = truth.model.predict(played.rows) + 0.01 * rng.standard_normal(played.rows.rows)
        rounds.take(replace(played, rows=replace(played.rows, effort=effort)), f"{number}.mcap")
    first, second = rounds.reports
    assert np.isnan(first.before)
    assert second.before > second.residual
    assert second.residual == pytest.approx(0.01, rel=0.1)
    assert second.noise == pytest.approx(0.01, rel=0.1)
    assert 0.5 < second.open_foretold / second.open < 1.5
    assert second.open < first.open
    _, got, foretold = second.half_widths["T_y"]
    assert got < first.half_widths["T_y"][1]
    assert 0.5 < foretold / got < 1.5
    assert not rounds.nothing_more  # the round that surprised the law is not the last
    assert json.loads(json.dumps(first.to_dict()))["before"] is None


@pytest.mark.parametrize(
    ("bands", "ends"),
    [
        ((25.6, 35.4), False),
        ((25.6, 35.4, 46.1), False),
        ((25.6, 35.4, 46.1, 45.1), True),  # as on the TWIN brake
        ((25.6, 35.4, 46.1, 30.0), False),
        ((25.6, 40.0, 30.0, 25.0, 25.1), False),
        ((25.6, 40.0, 30.0, 25.0, 25.1, 24.9), True),
    ],
)
def test_rounds_end_where_more_of_them_make_the_band_no_narrower(
    bands: tuple[float, ...], ends: bool
) -> None:
    rounds = LearningRounds(BRAKE, 0, 1000.0)
    for number, band in enumerate(bands, start=1):
        rounds.reports.append(a_round(number, band=band, largest=1000.0))
    assert ("no narrower" in rounds.enough(0.0001)) == ends


def test_the_first_round_drives_at_half_of_the_torque_and_its_band_ends_nothing() -> None:
    rounds = LearningRounds(BRAKE, 0, 1000.0)
    rounds.reports.append(a_round(1, band=20.0, largest=1e6))
    assert not rounds.enough(0.5)
    rounds.reports.append(a_round(2, band=20.0, largest=10.0))
    assert "within 50.00 %" in rounds.enough(0.5)
    assert not rounds.enough(0.05)


def test_until_asks_for_what_rounds_can_teach_and_tells_the_floor() -> None:
    """The band is twice the largest effort here, and no round makes it narrower: the law errs so."""
    rounds = LearningRounds(BRAKE, 0, 1000.0)
    rounds.reports += [a_round(1, band=20.0, largest=10.0), a_round(2, band=20.0, largest=10.0)]
    last = rounds.reports[-1]
    assert (last.share, last.open_share) == (2.0, 0.1)
    assert last.floor_share == pytest.approx(1.96 * last.residual / 10.0)
    ended = rounds.enough(0.1)
    assert "leave open is within 10.00 %" in ended
    assert "the band is 200.00 %, for bingham+lag errs by 1" in ended
    assert last.to_dict()["floor_share"] == last.floor_share


def a_round(number: int, *, band: float, largest: float) -> RoundReport:
    """A round whose law errs by 1 N m, of which the numbers leave as much open."""
    surprise = math.nan if number == 1 else 1.0
    return RoundReport(
        number, "", 10.0, "", "bingham+lag", surprise, 1.0, 0.5, 1.0, surprise, band, largest
    )


@pytest.mark.parametrize("text", ["3", "0", "-1%", "100%", "much", "nan"])
def test_a_band_that_cannot_be_is_refused(text: str) -> None:
    with pytest.raises(SettingError, match="--until"):
        share_of(text)
    assert share_of("3%") == pytest.approx(0.03)
    assert share_of(None) == 0.0


@pytest.mark.slow
def test_options_that_do_not_go_with_rounds_are_refused(tmp_path: Path) -> None:
    assert "--program learn too" in refused("live", "--until", "3%", cwd=tmp_path)
    assert "Leave out --rig replay" in refused(
        "live", "--program", "learn", "--rig", "replay", cwd=tmp_path
    )
    gone = ("live", "--program", "learn", "--headless", "--after", "none")
    assert "learn.json" in refused(*gone, cwd=tmp_path)


class FailingBrake(Twin):
    """The TWIN brake, whose encoder reads nothing for a while; keeps what it is commanded from then on."""

    def __init__(self, fails: bool) -> None:
        super().__init__(seed=1, locked=True, single=True)
        self.fails_after = 800  # samples with field
        self.fails_for = 500 if fails else 0
        self.after_fault: list[float] = []

    def sense(self) -> Measurement:
        measured = super().sense()
        if self.fails_after > 0 or self.fails_for == 0:
            return measured
        self.fails_for -= 1
        return replace(measured, theta=np.nan)

    def command(self, command: RigCommand) -> None:
        super().command(command)
        if self.fails_after > 0:
            self.fails_after -= command.E1 > 0.0
        elif self.fails_for > 0:
            self.after_fault.append(command.E1)


def _serve(fails: bool, parent: Any) -> None:
    with contextlib.suppress(PermissionError):
        os.sched_setscheduler(
            0, os.SCHED_FIFO, os.sched_param(70)
        )  # as a rig of erclutch, whatever else runs here
    brake = FailingBrake(fails)
    server = RigServer(brake, session=7, lead=default_rig().value("screw.lead"), device="single")
    for _ in range(3):
        brake.step()  # compiled before the loop waits for it
    parent.send(server.port)
    server.run(parent.poll)
    parent.send(brake.after_fault)
    os._exit(0)


@dataclass
class ServedBrake:
    """A brake behind UDP, in a process of its own: a thread beside the session waits for it, and the loop trips."""

    port: int
    after_fault: list[float]


@contextlib.contextmanager
def served_brake(*, fails: bool) -> Iterator[ServedBrake]:
    here, there = multiprocessing.Pipe()
    process = multiprocessing.get_context("fork").Process(target=_serve, args=(fails, there))
    process.start()
    brake = ServedBrake(here.recv(), [])
    try:
        yield brake
    finally:
        here.send("end")
        brake.after_fault += here.recv()
        process.join()


@pytest.mark.slow
@pytest.mark.timed
def test_a_fault_ends_at_zero_field_with_a_whole_log_and_the_next_round_goes_on(
    tmp_path: Path,
) -> None:
    """The encoder of the rig behind UDP fails in the middle of a round."""

    def asked(brake: ServedBrake) -> tuple[str, ...]:
        words = (
            "live",
            "--rig",
            "udp",
            "--address",
            f"127.0.0.1:{brake.port}",
            "--session",
            "7",
            "--device",
            "single",
        )
        return (
            *words,
            "--program",
            "learn",
            "--seconds",
            "4",
            "--round",
            "2",
            "--headless",
            "--folder",
            "logs",
        )

    for _ in range(10):
        shutil.rmtree(tmp_path / "logs", ignore_errors=True)
        with served_brake(fails=True) as brake:
            done = run(*asked(brake), cwd=tmp_path)
        if brake.after_fault:
            break
    else:
        pytest.skip("the machine is so busy that each loop trips, or ends, before the fault comes")
    assert done.code == 3
    assert "the fields are held at zero" in done.out
    assert "--after logs" in done.out

    assert brake.after_fault[-1] == 0.0
    (folder,) = (tmp_path / "logs").iterdir()
    (first,) = json.loads((folder / "learn.json").read_bytes())["rounds"]
    assert first["tripped"]
    log = folder / first["file"]
    field = np.asarray(erclutch.read(log).signals["field"])
    assert field.size > 700
    assert field.max() > 0.05
    kept = log.read_bytes()

    # Of the loop's own rows: commands that wait in the rig's socket are older than the sample that failed.
    rows = read_table(log).columns
    invalid = np.flatnonzero(rows["events"].astype(int) & EVENT_BITS["sample-invalid"])[0]
    assert rows["field"][invalid - 1] > 0.0
    assert not np.any(rows["field"][invalid + 20 :])

    body: dict[str, Any] = {"rounds": [first]}
    for _ in range(
        10
    ):  # a busy machine may trip the loop before a round is long enough to be fitted
        with served_brake(fails=False) as brake:
            again = run(*asked(brake), "--after", folder, cwd=tmp_path)
        body = json.loads((folder / "learn.json").read_bytes())
        if len(body["rounds"]) > 1:
            assert "round 2: " in again.out
            break
    else:
        pytest.skip("the machine is so busy that each second round trips before it can be fitted")
    assert body["rounds"][0]["file"] == first["file"]
    assert body["ended"]
    assert log.read_bytes() == kept


@pytest.mark.slow
def test_a_trip_after_a_few_samples_is_told_as_a_trip(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The log is too short to be read: the command ended with an error about the file."""
    log = tmp_path / "round.csv"
    log.write_text("time,field,position,effort\n0.000,0,0,0\n0.001,0,0,0\n", encoding="utf-8")
    monkeypatch.setattr(learning, "_played", lambda *_: (log, "loss", False))
    rig = Rig(
        TWIN,
        LoopSettings(device="single"),
        channels_of("single"),
        LoopOptions(folder=tmp_path),
        seed=0,
    )
    told = io.StringIO()
    assert (
        learning.learn(
            rig, NO_LEARN, [], lambda *_: contextlib.nullcontext(), Console(file=told, width=500)
        )
        == 3
    )
    assert "ended: loss: nothing can be learned of round.csv, which is kept: " in told.getvalue()


@pytest.mark.slow
def test_the_wait_behind_a_trip_takes_no_time_from_the_next_round(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of two rounds of 2 s in 4 s the second was left out, as the first log went on for 0.35 s behind its trip."""
    waited = drawn_table(BRAKE, 2.35, np.random.default_rng(1))
    monkeypatch.setattr(learning, "_played", lambda *_: (tmp_path / "round.mcap", "loss", True))
    monkeypatch.setattr(learning, "_logged", lambda *_: logged(waited))
    rig = Rig(
        TWIN,
        LoopSettings(device="single"),
        channels_of("single"),
        LoopOptions(folder=tmp_path, seconds=4.0),
        seed=0,
    )
    two_seconds = replace(NO_LEARN, round=2.0)
    told = io.StringIO()
    code = learning.learn(
        rig, two_seconds, [], lambda *_: contextlib.nullcontext(), Console(file=told, width=500)
    )
    assert code == 0
    assert "round 2: " in told.getvalue()
    assert "ended: 4 s are logged" in told.getvalue()


@pytest.mark.parametrize(
    "text",
    ["[" * 100_000, '{"rounds": [], "rounds": []}', '{"rounds": [5]}', '{"rounds": [{"file": 1}]}'],
)
def test_a_report_of_rounds_that_was_damaged_is_refused(tmp_path: Path, text: str) -> None:
    """One that is nested deep ended in a traceback, and of two lists of rounds the last was taken in silence."""
    (tmp_path / LEARN_REPORT).write_text(text, encoding="utf-8")
    limits = TableLimits("single", 1.0, 0.0, 1000.0)
    with pytest.raises(RunError, match="is no report of rounds"):
        learning._take_again(LearningRounds(limits, 0, 0.0), tmp_path, "single")


def test_after_a_trip_the_round_waits_until_somebody_runs_the_loop() -> None:
    console = Console(file=io.StringIO())
    asked = FakeSession(["running", "tripped", "tripped", "ready", "running"])
    assert follow_round(asked, 100, [], console, wait=True) == ("rig-fault", True)  # pyright: ignore[reportArgumentType]
    alone = FakeSession(["running", "tripped"])
    assert follow_round(alone, 100, [], console, wait=False) == ("rig-fault", False)  # pyright: ignore[reportArgumentType]
    whole = FakeSession(["running"] * 3)
    assert follow_round(whole, 2, [], console, wait=False) == ("", True)  # pyright: ignore[reportArgumentType]
    told = FakeSession(["running"] * 3)
    assert follow_round(told, 100, [2], console, wait=False) == ("", True)  # pyright: ignore[reportArgumentType]


class FakeSession:
    """States one after another, a frame each."""

    running = rig_running = True

    def __init__(self, states: list[str]) -> None:
        self._states = [State[name.upper()] for name in states]
        self.head = 0
        self.trip_reason = "rig-fault"

    def reader(self) -> FakeSession:
        return self

    def read(self) -> None:
        self.head += 1

    @property
    def state(self) -> State:
        return self._states[min(self.head, len(self._states)) - 1]

    def said(self) -> str:
        return ""
