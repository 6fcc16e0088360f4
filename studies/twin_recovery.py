"""A rig that is known, found again from its log by a calibration, on the TWIN: `python studies/twin_recovery.py`."""

from __future__ import annotations

import argparse

from erclutch.wings.paper.calibration.calibrate import calibrate
from erclutch.wings.paper.calibration.log_trace import LogTrace
from erclutch.wings.rig.twin.parameters import default_rig
from erclutch.wings.rig.twin.scenarios import prepare

FACTORS = {"fluid.viscosity": 1.3, "drive.inertia": 0.8, "screw.coulomb": 1.4, "fluid.building_time": 0.75}


def main() -> None:
    """Print estimates over true values, with their intervals."""
    argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter).parse_args()
    base = default_rig()
    known = base.changed({path: base.value(path) * factor for path, factor in FACTORS.items()})
    for seed in (3, 4):
        log = prepare("training", rig=known, seconds=8.0, seed=seed).recording()
        found = calibrate(base, tuple(FACTORS), LogTrace(log), evaluations=320, workers=2)
        print(f"TWIN, 8 s, seed {seed}: sum of squares {found.before:.0f} -> {found.after:.1f}; estimate over truth:")
        for one in found.parameters:
            truth = known.value(one.path)
            print(f"  {one.path:22}{one.value / truth:8.4f}  ({one.low / truth:.4f} .. {one.high / truth:.4f})")


if __name__ == "__main__":
    main()
