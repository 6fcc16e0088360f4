"""The default rig on seeds that its calibration never saw, beside the paper: `python studies/twin_validation.py`.

Laws are fitted to the training run of each seed; networks take no part in a calibration, so `erclutch reproduce table2`
shows how they come out.
"""

from __future__ import annotations

import argparse

import numpy as np

from erclutch.models.laws import PAPER
from erclutch.wings.paper.calibration.paper_summary import Summary, summarise
from erclutch.wings.paper.published import APPROACHES
from erclutch.wings.rig.twin.parameters import default_rig, load_rig

SEEDS = (101, 202, 303, 404, 505)
_LAWS = [name for name in PAPER if name != "rbfm-5/forward"]


def ordered(summary: Summary) -> bool:
    """Whether the training errors fall as in table II: Bingham, SS, HEM, RBFM-10."""
    train = [summary.errors["training"][name] for name in _LAWS]
    return train == sorted(train, reverse=True)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description="The twin on unused seeds, beside the paper.")
    parser.add_argument("--seconds", type=float, default=290.0)
    parser.add_argument("--rig", help="a rig file in place of the default rig")
    asked = parser.parse_args()
    rig = load_rig(asked.rig) if asked.rig else default_rig()
    summaries = [summarise(rig, seed, asked.seconds, thin=2) for seed in SEEDS]
    print(f"TWIN ({rig.name}), seeds {', '.join(map(str, SEEDS))}, training {asked.seconds:g} s each")
    print(f"{'figure':30}{'paper':>11}{'mean':>11}{'twin/paper':>11}   each seed")
    tables = [summary.against_paper() for summary in summaries]
    for key, (_, paper, _) in tables[0].items():
        values = [table[key][0] for table in tables]
        each = "  ".join(f"{v:.3g}" for v in values)
        print(f"{key:30}{paper:11.4g}{np.mean(values):11.4g}{np.mean(values) / paper:11.2f}   {each}")
    print("order Bingham > SS > HEM > RBFM-10 in training error:", [ordered(s) for s in summaries])
    for name in _LAWS:
        ratios = [s.errors["zero-motion"][name] / s.errors["training"][name] for s in summaries]
        known = APPROACHES[name]
        paper = (known.zero_motion or np.nan) / known.train
        print(
            f"zero-motion over training error, {name}: paper {paper:.0f}, twin {', '.join(f'{r:.0f}' for r in ratios)}"
        )


if __name__ == "__main__":
    main()
