"""What `erclutch live --explain` prints is what the core does, and the picture in the docs is drawn from the same."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from erclutch.wings.live.explained_states import transitions
from erclutch.wings.live.ring import State
from erclutch.wings.live.settings import REST, LoopProgram, LoopSettings, Mode

pytestmark = pytest.mark.slow

PICTURE = Path(__file__).parents[3] / "docs" / "images" / "states.svg"


def test_only_an_order_to_run_leads_out_of_ready_and_nothing_but_a_reset_out_of_a_trip() -> None:
    found = list(transitions())
    assert {line.state for line in found} == {
        State.STARTING,
        State.RUNNING,
        State.TRIPPED,
        State.READY,
    }
    for line in found:
        assert line.field == "zero" or line.next is State.RUNNING, line
        if line.state is State.READY and line.next is State.RUNNING:
            assert line.event == "order: run a program"
        if line.state is State.TRIPPED and line.next not in (State.TRIPPED, State.STOPPED):
            assert (line.event, line.next) == ("order: reset", State.READY)
    missed = next(
        line for line in found if line.state is State.RUNNING and "one period without" in line.event
    )
    assert (missed.next, missed.field) == (State.RUNNING, "held")


@pytest.mark.parametrize(
    ("mode", "amplitude"),
    [
        (Mode.TORQUE, 0.3),
        pytest.param(Mode.TRACK, 50.0, marks=pytest.mark.slow),
        pytest.param(Mode.IMPEDANCE, 50.0, marks=pytest.mark.slow),
        pytest.param(Mode.WALL, -50.0, marks=pytest.mark.slow),
    ],
)
def test_torque_and_motion_control_are_answered_as_tracking_is(
    mode: Mode, amplitude: float, bingham: Path, brake: Path
) -> None:
    """Each wants more than the field can do at once; only what is said of a torque out of reach differs."""
    wall, more = (
        mode is Mode.WALL,
        {"observer": "none", "track_bandwidth": 20.0, "output_inertia": 1e-3},
    )
    chosen = LoopSettings(
        "single" if wall else "coaxial",
        programs=(LoopProgram("push", mode, amplitude=amplitude), REST),
        **more,
    )
    for plain, other in zip(
        transitions(), transitions(chosen, brake if wall else bingham), strict=True
    ):
        said = tuple(name for name in other.said if name != "unreachable")
        assert (other.state, other.event, other.next, other.field, said) == (
            *vars(plain).values(),
        ), other


def test_the_picture_is_that_of_this_core(tmp_path: Path) -> None:
    from tests.support.state_diagram import draw_states

    draw_states(tmp_path / "states.svg")
    new, kept = (
        (folder / "states.svg").read_text("utf-8") for folder in (tmp_path, PICTURE.parent)
    )
    assert re.findall(r"<text[^>]*>(.*?)</text>", new) == re.findall(
        r"<text[^>]*>(.*?)</text>", kept
    )
