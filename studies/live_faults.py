"""Faults, each injected into the live loop: how many, what is expected, what was observed.

    python studies/live_faults.py [--kills 100] [--only NAME] [--control NAME]

Every fault is injected under each control: equation 23, torque control, tracking by computed torque, impedance, wall.
The first part runs the loop's C core step by step on synthetic sensors, so counts are exact. The second part runs the
whole loop in its own process against a rig in another thread, kills and stops it, and times the rig's field. Nothing
here is a TWIN or a measurement: sensors are a motor at 40 rad/s and an output that swings.
"""

from __future__ import annotations

import argparse
import itertools
import sys
from collections.abc import Callable
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from tests.support.live_faults.core_faults import EXACT
from tests.support.live_faults.finding import CONTROLS, Finding, under
from tests.support.live_faults.loop_faults import (
    ALIKE,
    WHOLE,
    bad_configurations,
    killed,
    rig_killed,
)


def main() -> int:
    """Run all of them and print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--kills", type=int, default=100)
    parser.add_argument("--only", default="")
    parser.add_argument("--control", choices=CONTROLS)
    given = parser.parse_args()
    counted: dict[str, Callable[[], Finding]] = {
        "kill": lambda: killed(given.kills),
        "kill-rig": lambda: rig_killed(given.kills),
        "configurations": lambda: bad_configurations(10 * given.kills),
    }
    faults = {**EXACT, **WHOLE, **counted}
    failed = 0
    for control, (name, fault) in itertools.product(
        [given.control] if given.control else CONTROLS, faults.items()
    ):
        if given.only in ("", name) and (
            name not in ALIKE or control in ("equation 23", given.control)
        ):
            with under(control):
                found = fault()
            failed += not found.passed
            print(
                f"{'ok  ' if found.passed else 'FAIL'} {control:15} {found.fault:24} {found.injected:>7}  "
                f"expected: {found.expected:45} observed: {found.observed}",
                flush=True,
            )
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
