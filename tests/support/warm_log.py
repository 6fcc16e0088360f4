"""A run of a SYNTHETIC log whose oil warms up: it recommends a law with the temperature, and keeps one without."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from erclutch.logs.synthetic import synthetic_log
from tests.support.command import good


def warm_run(folder: Path) -> Path:
    """The run's folder, beside its log."""
    columns = {name: values for name, (_, values) in synthetic_log(4.0, 0).items()}
    warm = 20.0 + 10.0 * columns["time"]
    effort = columns["torque"] * (1.0 - 0.01 * (warm - 20.0))
    rows = np.column_stack([columns["time"], columns["field"], columns["slip"], effort, warm])
    head = "t [s],u [V],w [rad/s],M [N*m],oil [degC]"
    np.savetxt(folder / "log.csv", rows, delimiter=",", header=head, comments="")
    named = ("--field", "u", "--slip", "w", "--effort", "M", "--temperature", "oil")
    quick = ("--lag", "none", "--out", "run")  # no search for further stages
    good(
        "fit",
        "log.csv",
        *named,
        "--models",
        "bingham+lag+softening",
        "bingham+lag",
        *quick,
        cwd=folder,
    )
    return folder / "run"
