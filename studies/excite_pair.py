"""How many seconds of log make a model of the TWIN pair: `python studies/excite_pair.py --seeds 20`.

What `erclutch excite` chooses without a model stands beside the paper's draws, random steps and a chirp within the same
limits, and beside the paper's own scenario. The motor follows the speeds by a servo, the output moves as the clutches
drive it, and the log holds what the pair did. Each sequence is fitted on its own rows, and tested on 20 s of the
scenario and 20 s of random steps. --out FILE keeps each error, so a run that was ended goes on where it was.
"""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from erclutch.fit.solver.one_thread import one_thread
from erclutch.logs import recording_from_arrays
from erclutch.logs.dataset import Dataset, build_dataset, joined
from erclutch.wings.design.courses import Commands
from erclutch.wings.design.fill import chosen_sequence, papers_sequence
from erclutch.wings.design.limits import RigLimits, limits_of_log
from erclutch.wings.rig.interface import RigCommand
from erclutch.wings.rig.twin.scenarios import prepare
from erclutch.wings.rig.twin.twin import Twin
from studies.excite import (
    AS_GOOD,
    LAWS,
    RATE,
    Servo,
    chirp,
    error,
    fitted,
    print_rows,
    random_steps,
)

TEST_SECONDS = 20.0
Played = tuple[str, Callable[[float, int], Dataset]]


def scenario(seconds: float, seed: int) -> Dataset:
    """The paper's excitation of the pair."""
    return build_dataset(
        prepare("training", seconds=seconds, seed=seed).recording(), device="coaxial"
    )


def played(commands: Commands, seed: int) -> Dataset:
    """The log of a pair whose motor follows the speed by a servo; a positive field is the first clutch's."""
    twin = Twin(seed=seed)
    servo = Servo(commands.speed, twin.rig.value("drive.inertia"))
    rows = np.zeros((commands.speed.size, 5))
    measured = twin.sense()
    for row, field in enumerate(commands.field.tolist()):
        speed, torque = servo.asked(row, measured.theta)
        drag = np.copysign(abs(measured.torque), speed)  # both clutches brake the motor
        first, second = max(field, 0.0), max(-field, 0.0)
        rows[row] = first, second, measured.theta, measured.alpha_rotary, measured.torque
        twin.command(RigCommand(first, second, float(torque + drag)))
        twin.step()
        measured = twin.sense()
    units: dict[str, str] = {"E1": "", "E2": "", "theta": "rad", "alpha": "rad", "T": "N*m"}
    columns = dict(zip(units, rows.T, strict=True))
    log = recording_from_arrays(columns, rate=RATE, units=units, device="coaxial")
    return build_dataset(log, device="coaxial")


def signed(commands: Commands, seed: int) -> Commands:
    """The same fields for the pair: each stretch without a zero is the first clutch's or the second's, by chance."""
    on = commands.field > 0.0
    stretch = np.cumsum(np.diff(on.astype(int), prepend=0) > 0)
    sign = np.random.default_rng(seed).choice([-1.0, 1.0], int(stretch[-1]) + 1)
    return Commands(sign[stretch] * commands.field, commands.speed, commands.position)


def sequences(limits: RigLimits) -> list[Played]:
    """What each sequence makes of some seconds and a seed."""

    def filling(seconds: float, seed: int) -> Dataset:
        return played(
            chosen_sequence(limits, RATE, seconds, np.random.default_rng(seed), signed=True), seed
        )

    def papers(seconds: float, seed: int) -> Dataset:
        return played(
            papers_sequence(limits, RATE, seconds, np.random.default_rng(seed), signed=True), seed
        )

    return [
        ("excite, filling", filling),
        ("the paper's draws", papers),
        ("the paper's scenario", lambda seconds, seed: scenario(seconds, 10 + seed)),
        (
            "random steps",
            lambda seconds, seed: played(signed(random_steps(limits, seconds, seed), seed), seed),
        ),
        ("chirp", lambda seconds, seed: played(signed(chirp(limits, seconds, seed), seed), seed)),
    ]


def study(
    seeds: range, long: float, lengths: Sequence[float], laws: Sequence[str], out: Path | None
) -> None:
    """Print medians of errors over those of the fit to a long log of both kinds that are tested."""
    whole = scenario(long, 1)
    limits = RigLimits(**(limits_of_log(whole) | {"rest": 0.1}))
    # Each of these logs begins in the middle: in a longer one chance takes the output to its ends.
    logs = range(1000, 1000 + math.ceil(long / TEST_SECONDS))
    steps = [played(signed(random_steps(limits, TEST_SECONDS, seed), seed), seed) for seed in logs]
    test_steps = played(signed(random_steps(limits, TEST_SECONDS, 99), 99), 99)
    tests = (scenario(TEST_SECONDS, 2), test_steps)
    reference = fitted(joined([whole, *steps]), laws)
    best = [error(reference, test) for test in tests]
    print(
        f"TWIN pair; {' or '.join(laws)}+lag; seeds {seeds.start} to {seeds.stop - 1}; tests: scenario / random steps"
    )
    print(
        f"RMSE of {reference.name}, fitted to {long:g} s of each: {best[0]:.4g} / {best[1]:.4g} N m; "
        "below: medians over it"
    )
    print(
        "| sequence | "
        + " | ".join(f"{seconds:g} s" for seconds in lengths)
        + f" | within {AS_GOOD:g} of both after |"
    )
    print("|---|" + "---:|" * (len(lengths) + 1))

    makers = sequences(limits)
    print_rows(
        "pair", makers, tests, best, seeds=seeds, long=long, lengths=lengths, laws=laws, out=out
    )


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--seeds", type=int, default=2)
    parser.add_argument("--first", type=int, default=0, help="seed")
    parser.add_argument(
        "--lengths",
        type=float,
        nargs="+",
        default=[5.0, 10.0, 20.0],
        help="seconds of the short logs",
    )
    parser.add_argument("--long", type=float, default=60.0, help="seconds of the long log")
    parser.add_argument("--law", nargs="+", default=LAWS, help="among which each log chooses")
    parser.add_argument("--out", type=Path, help="keeps each error, to go on where a run was ended")
    asked = parser.parse_args()
    with one_thread():
        seeds = range(asked.first, asked.first + asked.seeds)
        study(seeds, asked.long, asked.lengths, tuple(asked.law), asked.out)


if __name__ == "__main__":
    main()
