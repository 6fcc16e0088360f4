"""The process of a rig ends with who started it, also where that ends as the process begins."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from typing import Any

import pytest

from erclutch.wings.rig import rig_process
from erclutch.wings.rig.rig_process import start_rig

SPEC = {"kind": "twin", "session": 5, "device": "coaxial"}


@pytest.mark.parametrize("ending", [KeyboardInterrupt, SystemExit])
def test_who_is_ended_while_a_rig_starts_leaves_no_process(
    ending: type[BaseException], monkeypatch: pytest.MonkeyPatch
) -> None:
    """In a notebook the rig's process stayed as long as the notebook did."""
    started: list[subprocess.Popen[str]] = []
    begin = subprocess.Popen[str]

    def noted(*words: Any, **named: Any) -> subprocess.Popen[str]:
        started.append(begin(*words, **named))
        return started[-1]

    def interrupted(*_: object) -> None:
        raise ending

    monkeypatch.setattr(rig_process.subprocess, "Popen", noted)
    with pytest.raises(ending):
        start_rig(SPEC, interrupted)
    monkeypatch.setattr(rig_process.select, "select", interrupted)
    with pytest.raises(ending):
        start_rig(SPEC)
    assert [process.poll() for process in started] == [-signal.SIGKILL] * 2


@pytest.mark.slow
def test_a_rig_whose_session_is_gone_says_nothing() -> None:
    """A closed terminal had a traceback of the rig behind the end of `live`."""
    reading, writing = os.pipe()
    os.close(reading)
    done = subprocess.run(
        [sys.executable, "-m", "erclutch.wings.rig.rig_process", json.dumps(SPEC)],
        stdout=writing,
        stderr=subprocess.PIPE,
        text=True,
        timeout=100,
        check=False,
    )
    os.close(writing)
    assert (done.returncode, done.stderr) == (0, "")
