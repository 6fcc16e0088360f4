"""`inspect FOLDER` says of which kinds the logs are, with a command for each. The data are SYNTHETIC."""

from __future__ import annotations

import shlex
from pathlib import Path

import numpy as np
import pytest

from tests.support.command import good, run

pytestmark = pytest.mark.slow

TIME = np.arange(400) / 200.0
SPEED = 5.0 * np.sin(6.0 * TIME)
BRAKE = "time [s],current [A],speed [rad/s],torque [Nm]"


def written(path: Path, head: str, current: float) -> None:
    torque = (0.3 + 1.7 * current) * np.tanh(4.0 * SPEED) + 0.02 * SPEED
    columns = [TIME, np.full(TIME.size, current), SPEED, torque]
    if head.count(",") == 2:
        del columns[1]
    path.parent.mkdir(exist_ok=True)
    rows = np.column_stack(columns)
    np.savetxt(path, rows, delimiter=",", header=head, comments="", fmt="%.6g")


def test_logs_of_two_headers_that_are_read_alike_are_told_and_fitted_together(
    tmp_path: Path,
) -> None:
    for place, current in enumerate((0.25, 0.5, 1.0)):
        written(tmp_path / f"logs/new_{place}.csv", BRAKE, current)
    for place, current in enumerate((0.3, 0.6)):
        written(tmp_path / f"logs/old_{place}.csv", "t [s],i [A],omega [rad/s],M [Nm]", current)
    said = good("inspect", "logs", cwd=tmp_path)
    assert (
        "2 kinds of logs, by their columns: 3 logs such as new_0.csv, with time [s], current [A], speed [rad/s], "
        "torque [Nm]; 2 logs such as old_0.csv, with t [s], i [A], omega [rad/s], M [Nm]"
    ) in said
    assert said.splitlines()[-1] == "Understood. Fit them: erclutch fit logs --out RUN"


def test_logs_of_two_kinds_have_a_command_each(tmp_path: Path) -> None:
    for place, current in enumerate((0.25, 0.5, 1.0)):
        written(tmp_path / f"my logs/trial_{place}.csv", BRAKE, current)
    for place, current in enumerate((0.3, 0.6)):
        written(
            tmp_path / f"my logs/cal_{place}.csv", "time [s],level,pointer [V],load [N]", current
        )
    *_, said, why, settles = good("inspect", "my logs", cwd=tmp_path, code=1).splitlines()
    assert said == (
        "Understood on their own, those as trial_0.csv: erclutch fit 'my logs/trial_'*.csv --out RUN"
    )
    assert why.startswith("Not understood yet: cal_0.csv: ")
    command = settles.removeprefix("What settles it: ")
    assert command.startswith("erclutch inspect 'my logs/cal_'*.csv --")
    assert len(shlex.split(command)) > 3


def test_logs_with_and_without_a_field_are_two_kinds(tmp_path: Path) -> None:
    for place, current in enumerate((0.25, 0.5, 1.0)):
        written(tmp_path / f"logs/trial_{place}.csv", BRAKE, current)
    for place, current in enumerate((0.3, 0.31)):
        written(
            tmp_path / f"logs/trial_free_{place}.csv", "time [s],speed [rad/s],torque [Nm]", current
        )
    lines = good("inspect", "logs", cwd=tmp_path, code=1).splitlines()
    fits = [line for line in lines if line.startswith("Understood on their own, ")]
    assert len(fits) == 2
    # What begins alike with another kind is named log by log.
    assert "erclutch fit logs/trial_0.csv logs/trial_1.csv logs/trial_2.csv --out RUN" in fits[0]
    assert "erclutch inspect logs/trial_free_*.csv" in fits[1]


def test_a_number_in_the_names_and_a_spare_column_make_no_kind(tmp_path: Path) -> None:
    written(tmp_path / "logs/a.csv", "time [s],current [A],speed_1 [rad/s],torque [Nm]", 0.25)
    written(tmp_path / "logs/b.csv", "time [s],current [A],speed_2 [rad/s],torque [Nm]", 0.5)
    lines = (tmp_path / "logs/b.csv").read_text().splitlines()
    more = [f"{line},{'oil [°C]' if place == 0 else place}" for place, line in enumerate(lines)]
    (tmp_path / "logs/c.csv").write_text("\n".join(more) + "\n", encoding="utf-8")
    assert "kinds of logs" not in run("inspect", "logs", cwd=tmp_path).out


def test_one_file_of_another_kind_is_told_on_its_own(tmp_path: Path) -> None:
    for place, current in enumerate((0.25, 0.5, 1.0)):
        written(tmp_path / f"logs/trial_{place}.csv", BRAKE, current)
    written(tmp_path / "logs/x.csv", "time [s],level,pointer [V],load [N]", 0.3)
    said = good("inspect", "logs", cwd=tmp_path, code=1)
    assert "kinds of logs" not in said
    assert "Not understood yet: x.csv: " in said
