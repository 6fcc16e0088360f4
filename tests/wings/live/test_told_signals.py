"""A signal before a session runs ends `erclutch live` at once, and nothing of the session stays."""

from __future__ import annotations

import signal
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from erclutch.wings.live import session
from erclutch.wings.live.command_line.told_signals import end_where_told, signals_told
from erclutch.wings.live.ring import ring_folder
from tests.support.command import run

_CODES = {signal.SIGINT: 130, signal.SIGTERM: 143, signal.SIGHUP: 129}


@pytest.fixture
def usual() -> Iterator[None]:
    """Each signal as a process has it that has just begun."""
    before = {number: signal.getsignal(number) for number in _CODES}
    for number in _CODES:
        signal.signal(
            number, signal.default_int_handler if number == signal.SIGINT else signal.SIG_DFL
        )
    yield
    for number, handler in before.items():
        signal.signal(number, handler)


def starting(number: int) -> Callable[..., Any]:
    """A rig that takes seconds to start, in which a signal comes."""

    def start_rig(_: object, while_waiting: Callable[[], None]) -> None:
        signal.raise_signal(number)
        for _ in range(200):
            while_waiting()
            time.sleep(0.01)
        raise AssertionError("it waited on")

    return start_rig


def ended_by(number: int, *words: str, cwd: Path) -> tuple[int, str]:
    """Exit code and output of `live`; a signal other than Ctrl-C leaves it as `SystemExit`."""
    try:
        done = run("live", *words, "--headless", "--no-model", cwd=cwd)
    except SystemExit as ended:
        return int(ended.code or 0), ""
    return done.code, done.out + done.error


@pytest.mark.slow
@pytest.mark.parametrize("number", _CODES)
def test_a_signal_before_the_session_runs_ends_the_command(
    usual: None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, number: int
) -> None:
    """Ctrl-C was heard when the loop ran: 2 to 4 s later on a busy machine, 11 s where it compiled, with code 0."""
    monkeypatch.setattr(session, "start_rig", starting(number))
    rings = set(ring_folder().glob("erclutch-live-*"))
    code, _ = ended_by(number, "--record", cwd=tmp_path)
    assert code == _CODES[signal.Signals(number)]
    assert set(ring_folder().glob("erclutch-live-*")) <= rings
    assert list(tmp_path.iterdir()) == []


@pytest.mark.slow
def test_an_interrupt_before_the_first_round_ends_the_rounds_in_order(
    usual: None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(session, "start_rig", starting(signal.SIGINT))
    code, said = ended_by(
        signal.SIGINT, "--rig", "twin-brake", "--program", "learn", "--seconds", "4", cwd=tmp_path
    )
    assert (code, "ended: it was interrupted" in said) == (0, True)


def test_signals_of_a_running_session_are_noted_and_those_ignored_stay_so(usual: None) -> None:
    signal.signal(signal.SIGHUP, signal.SIG_IGN)  # by nohup
    with signals_told() as told:
        for number in _CODES:
            signal.raise_signal(number)
    assert told == [signal.SIGINT, signal.SIGTERM]
    with pytest.raises(KeyboardInterrupt):
        end_where_told(told)
    with pytest.raises(SystemExit, match="143"):
        end_where_told(told[1:])
    end_where_told([])
