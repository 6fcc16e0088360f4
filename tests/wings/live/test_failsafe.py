"""The failsafe from the C itself: every pair of a state and an event, then random sequences (`failsafe.c`).

And every state of the doubt in a torque sensor with every reading and order that may come next (`doubts.c`).
And by how much a model's torque has moved of late, beside a search (`moved.c`).
"""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path

import pytest

from erclutch.wings.live.c_build import CORE, SOURCES

HERE = Path(__file__).parent


_FLAGS = ("-std=c11", "-D_GNU_SOURCE", "-O2", "-Wall", "-Wextra", "-Werror")


def compiled(source: Path, folder: Path, *options: str) -> Path:
    """The object of a source, with the headers of the loop."""
    made = folder / f"{source.stem}.o"
    words = ["gcc", *_FLAGS, *options, "-I", str(SOURCES), "-c", str(source), "-o", str(made)]
    subprocess.run(words, check=True)
    return made


@pytest.fixture(scope="module")
def core(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """The objects of the loop's core by the names of their sources; a changed core differs in one of them."""
    if shutil.which("gcc") is None:
        pytest.skip("apt install gcc libc6-dev")
    folder = tmp_path_factory.mktemp("core")
    return {name: compiled(SOURCES / name, folder) for name in CORE}


def went_through(
    core: dict[str, Path], folder: Path, harness: str = "failsafe", *options: str
) -> tuple[str, list[int]]:
    """What the harness prints, and its counts: pairs, steps, promises that were broken."""
    objects = [compiled(HERE / f"{harness}.c", folder, *options), *core.values()]
    program = folder / harness
    subprocess.run(["gcc", *map(str, objects), "-lm", "-o", str(program)], check=True)
    said = subprocess.run([str(program)], capture_output=True, text=True, check=False).stdout
    counts = re.search(r"pairs (\d+), steps (\d+), broken (\d+)", said)
    assert counts is not None, said
    return said, [int(count) for count in counts.groups()]


@pytest.mark.slow
def test_every_state_and_event_keeps_the_promises(core: dict[str, Path], tmp_path: Path) -> None:
    said, (pairs, steps, broken) = went_through(core, tmp_path)
    assert broken == 0, said
    assert pairs > 1_000_000
    assert steps > 50_000_000
    # A step leads from each state to these: 0 starting, 1 running, 2 tripped, 4 ready; orders lead from 2 to 4 to 1.
    rows = re.findall(r"from \d: (.*)", said)
    changes = [{to for to, n in enumerate(row.split()) if int(n)} for row in rows]
    assert changes == [{0, 1, 2}, {1, 2}, {2}, set(), {2, 4}]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "good", "bad"),
    [
        ("core", "late_ns > core->config.late_trip_ns", "late_ns > 2 * core->config.late_trip_ns"),
        (
            "core",
            "core->missing >= core->config.trip_samples) {",
            "core->missing > core->config.trip_samples) {",
        ),
        ("core", "core->state != ERC_TRIPPED || core->missing > 0u", "core->state != ERC_TRIPPED"),
        (
            "core",
            "core->state == ERC_RUNNING && core->stopping == 0u",
            "core->state == ERC_RUNNING",
        ),
        ("core", "core->state = ERC_READY;", "core->state = ERC_RUNNING;"),
        ("core", "(core->state == ERC_READY && core->missing > 0u)", "0"),
        ("interlock", "return value < low ? low : high;", "return value < low ? low : value;"),
    ],
)
def test_a_core_that_breaks_a_promise_is_seen(
    name: str, good: str, bad: str, core: dict[str, Path], tmp_path: Path
) -> None:
    other = changed(core, name, good, bad, tmp_path)
    _, (_, _, broken) = went_through(other, tmp_path, "failsafe", "-DONE_IS_ENOUGH")
    assert broken > 0


@pytest.mark.slow
def test_every_doubt_and_reading_keeps_the_promises(core: dict[str, Path], tmp_path: Path) -> None:
    """Held, reduced, zero, tripped with the reason; nothing learned; no reset while the sensor is wrong."""
    said, (pairs, steps, broken) = went_through(core, tmp_path, "doubts")
    assert broken == 0, said
    assert pairs > 60_000
    assert steps > 1_000_000


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "good", "bad"),
    [
        ("plausible", "torque < -limit || torque > limit", "torque < -limit"),
        (
            "core",
            "asked || core->config.meter_needed > 1.0 ?",
            "asked && core->config.meter_needed > 1.0 ?",
        ),
        ("core", "core->config.meter_needed > 0.0 &&", "core->config.meter_needed > 1.0 &&"),
        ("core", "ask[0] = share * core->asked1;", "ask[0] = core->asked1;"),
        ("core", "(doubted(core) > 0u && core->meter.wrong)", "0"),
    ],
)
def test_a_core_that_believes_too_much_is_seen(
    name: str, good: str, bad: str, core: dict[str, Path], tmp_path: Path
) -> None:
    other = changed(core, name, good, bad, tmp_path)
    _, (_, _, broken) = went_through(other, tmp_path, "doubts", "-DONE_IS_ENOUGH")
    assert broken > 0


def changed(core: dict[str, Path], name: str, good: str, bad: str, folder: Path) -> dict[str, Path]:
    """The core's objects, with another text in one of the sources."""
    source = SOURCES / f"erc_{name}.c"
    text = source.read_text(encoding="utf-8")
    assert good in text
    other = folder / source.name
    other.write_text(text.replace(good, bad), encoding="utf-8")
    return {**core, source.name: compiled(other, folder)}


@pytest.mark.slow
def test_how_far_a_torque_has_moved_of_late_is_what_a_search_finds(
    core: dict[str, Path], tmp_path: Path
) -> None:
    said, (_, steps, broken) = went_through(core, tmp_path, "moved")
    assert (steps, broken) == (120_000, 0), said
    other = changed(core, "turned", "if (next < ERC_EARLIER)", "if (next < 4u)", tmp_path)
    assert went_through(other, tmp_path, "moved")[1][2] > 0
