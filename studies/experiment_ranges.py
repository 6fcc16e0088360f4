"""Why figures 11 and 12 differ on the TWIN: what the network was trained on beside what the experiments ask of it.

python studies/experiment_ranges.py
"""

from __future__ import annotations

import argparse
from typing import Any

import numpy as np
from rich.console import Console

from erclutch.models.load import load_model
from erclutch.wings.live.live_model import live_model
from erclutch.wings.paper.online import run
from erclutch.wings.rig.twin.parameters import default_rig
from erclutch.wings.rig.twin.scenarios import prepare
from erclutch.wings.rig.twin_model import twin_model

HIGH = 0.3  # field


def row(name: str, field1: Any, slip: Any, torque: Any) -> str:
    """Slip under a high field, largest slip, spread of the torque."""
    high = np.abs(slip[field1 > HIGH])
    under = f"{np.quantile(high, 0.9):.1f} rad/s" if high.size else "-"
    largest, spread = f"{np.abs(slip).max():.0f} rad/s", f"{torque.std():.4f} N m"
    return f"{name:12} 9 of 10 slips with E1 > {HIGH}: below {under}; largest slip {largest}; torque's std {spread}"


def main() -> None:
    """A line each for the training run and both experiments."""
    argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter).parse_args()
    rig = default_rig()
    path = twin_model(rig, Console(stderr=True))
    model = load_model(path)
    data = {name: values for name, (_, values) in prepare("training", seconds=60.0, seed=0).columns().items()}
    print(f"TWIN; {model.name} was trained on slips of {model.trained_on.slip} rad/s")
    print(row("training", data["E1"], data["true_theta_dot"] - data["true_alpha_dot"], data["T"]))
    for name in ("zero-field", "zero-motion"):
        frames = run(name, live_model(path, "coaxial"), [model], rig)[0].frames
        print(row(name, frames["field1"], frames["theta_dot"] - frames["alpha_dot"], frames["torque"]))
        squares, outside = (frames["estimate"] - frames["torque"]) ** 2, frames["flags"] & 1 != 0
        print(f"{'':12} outside the training range: {outside.mean():.1%}; MSE inside {squares[~outside].mean():.3e}")


if __name__ == "__main__":
    main()
