"""What a device's torque moves has an inertia and a dry friction: from options, from a run, or from a rig file."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from erclutch.errors import require

if TYPE_CHECKING:
    from erclutch.models.model import Model
    from erclutch.runs.run_folder import Run
    from erclutch.wings.rig.twin.parameters import RigParameters

_WINDOW = 5  # rows over which a speed changes


class MovedSide(NamedTuple):
    """What the torque moves: inertia in kg m2, dry friction in N m, and where both come from."""

    inertia: float
    friction: float
    source: str


def moved_side(
    run: Run,
    model: Model,
    rig: RigParameters,
    source: str,
    inertia: float | None,
    friction: float | None,
) -> MovedSide:
    """Inertia and friction of what is moved: as the options say, as the run shows, or as the rig file has them.

    A pair moves its output, a single device its drive, which no log of a run shows. ``source`` says whose rig it is.
    """
    if run.body["device"] == "single":
        known = rig.value("drive.inertia"), rig.value("drive.coulomb")
    else:
        shown = output_numbers(run, model.name)
        if shown is not None:
            source = "run"
            known = shown
        else:
            whole = rig.value("screw.rotor_inertia") + rig.value("screw.load_inertia")
            known = whole, rig.value("screw.coulomb")
    known_inertia, known_friction = known
    if inertia is not None and friction is not None:
        source = "options"
    elif inertia is not None or friction is not None:
        source = f"options; {source}"
    moved = MovedSide(
        known_inertia if inertia is None else inertia,
        known_friction if friction is None else friction,
        source,
    )
    require(1e-9, unit=" kg m2", output_inertia=moved.inertia)
    require(0.0, unit=" N m", output_friction=moved.friction)
    return moved


def output_numbers(run: Run, model: str) -> tuple[float, float] | None:
    """Inertia and dry friction of an output that moves, by least squares; None if it rests.

    They are those that the model's torque moves. On a log whose output was free a model knows the torque behind the
    sensor alone, and that moves less inertia than the whole output has.
    """
    import numpy as np

    from erclutch.runs.run_rows import read_rows

    rows = read_rows(run)
    data = rows.data
    speed = -0.5 * (data.elements[0].slip + data.elements[1].slip)
    windows = [np.arange(span.start, span.stop - _WINDOW, _WINDOW) for span in data.clock.spans]
    at = np.concatenate(windows)  # first row of each window
    moving = np.abs(speed[at]) > 0.2 * np.std(speed)
    if np.std(speed) < 1.0 or np.count_nonzero(moving) < 100:
        return None
    sums = np.concatenate([[0.0], np.cumsum(rows.predicted[model])])
    torque = (sums[at + _WINDOW] - sums[at]) / _WINDOW  # mean of each window
    time = data.clock.time[at + _WINDOW] - data.clock.time[at]
    acceleration = (speed[at + _WINDOW] - speed[at]) / time
    known = np.column_stack([acceleration, np.sign(speed[at])])
    solution = np.linalg.lstsq(known[moving], torque[moving], rcond=None)[0]
    inertia, friction = solution.tolist()
    if inertia <= 0.0:
        return None
    return inertia, max(0.0, friction)
