"""A run says what to log next: the sequence takes more off its intervals than others do, as much as it foretells."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from erclutch.errors import SettingError
from erclutch.fit.laws.fit_law import fit_structure
from erclutch.fit.solver.outcome import Estimate
from erclutch.logs.dataset import Dataset
from erclutch.logs.synthetic import write_synthetic_log
from erclutch.models.law_model import TorqueModel
from erclutch.models.model_file import digest_of
from erclutch.runs.run_folder import read_run
from erclutch.signals.array import Array
from erclutch.wings.design.courses import Bounds, Commands
from erclutch.wings.design.fill import CellCounts, chosen_sequence, papers_sequence
from erclutch.wings.design.information import Criterion, Knowledge, Region, Sensitivity, region_of
from erclutch.wings.design.limits import RigLimits
from erclutch.wings.design.run_design import (
    Expectation,
    LawOfRun,
    cells_of_run,
    designed_for,
    law_of_run,
)
from tests.support.command import good, refused
from tests.support.warm_log import warm_run

LIMITS = RigLimits(field=1800.0, speed=60.0, acceleration=1900.0)


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run of a SYNTHETIC log, with a law that has a lag and one that has none."""
    folder = tmp_path_factory.mktemp("run")
    write_synthetic_log(folder / "log.csv", 6.0)
    words = ("fit", "log.csv", "--models", "bingham", "--lag", "lag", "--out", "run")
    good(*words, cwd=folder)
    return folder / "run"


def measured(model: TorqueModel, logs: list[Commands], noise: float) -> Dataset:
    """Rows of commands, whose effort is the model's and noise."""
    data = Sensitivity(model).of_commands([(each.field, each.speed) for each in logs], model.period)
    effort: Array = model.predict(data) + noise * np.random.default_rng(1).standard_normal(
        data.rows
    )
    return Dataset(data.device, data.elements, effort, data.clock, data.units)


def known_after(run: Path, commands: Commands, criterion: Criterion = "D") -> Knowledge:
    law = law_of_run(run, None)
    knowledge = Knowledge(law.model, law.rows, law.rate, criterion)
    knowledge.learn(commands)
    return knowledge


@pytest.mark.slow
def test_derivatives_are_those_of_the_effort(run: Path) -> None:
    law = law_of_run(run, None)
    commands = chosen_sequence(LIMITS, law.rate, 3.0, np.random.default_rng(0))
    sensitivity = Sensitivity(law.model)
    data = sensitivity.of_commands([(commands.field, commands.speed)], law.rows.period)
    derivatives = sensitivity.rows(data)
    for place, name in enumerate([*law.model.shape, *law.model.gains]):
        ends: list[Array] = []
        step = 1e-5
        for sign in (1.0, -1.0):
            shape, gains = dict(law.model.shape), dict(law.model.gains)
            (scale,) = [
                s.scale for s in law.model.structure.shapes(law.model.period) if s.name == name
            ] or ["gain"]
            if scale == "gain":
                gains[name] += sign * step
            else:
                shape[name] = (
                    shape[name] * math.exp(sign * step)
                    if scale == "log"
                    else shape[name] + sign * step
                )
            moved = TorqueModel(
                law.model.structure,
                law.model.reference,
                shape,
                gains,
                law.model.units,
                law.model.trained_on,
            )
            ends.append(moved.predict(data))
        slope = (ends[0] - ends[1]) / (2.0 * step)
        np.testing.assert_allclose(
            derivatives[:, place], slope, atol=1e-4 * max(1.0, float(np.abs(slope).max()))
        )


@pytest.mark.slow
def test_of_equal_length_the_designed_sequence_teaches_most(run: Path) -> None:
    law = law_of_run(run, None)
    designed, expected = designed_for(law, LIMITS, law.rate, 3.0, 1, criterion="D")
    others = (chosen_sequence, papers_sequence)
    drawn = [
        other(LIMITS, law.rate, 3.0, np.random.default_rng(seed))
        for other in others
        for seed in range(2)
    ]
    left = [known_after(run, commands) for commands in (designed, *drawn)]
    worth = [each.criterion(each.information) for each in left]
    assert worth[0] < min(worth[1:])
    assert np.all(expected.after < expected.before)
    np.testing.assert_allclose(left[0].errors(), expected.after, rtol=1e-6)


@pytest.mark.slow
def test_intervals_come_out_as_foretold(run: Path) -> None:
    """White noise, so that the intervals of the fit and the matrix are about the same errors."""
    law = law_of_run(run, None)
    first = chosen_sequence(LIMITS, law.rate, 2.5, np.random.default_rng(3))
    before = fit_structure(measured(law.model, [first], 0.05), law.model.structure)
    knowledge = Knowledge(before.model, measured(law.model, [first], 0.05), law.rate)
    errors = knowledge.errors()
    second = chosen_sequence(
        LIMITS, law.rate, 2.5, np.random.default_rng(4), knowledge, candidates=8
    )
    after = fit_structure(measured(law.model, [first, second], 0.05), law.model.structure)
    shares = knowledge.errors() / errors
    ratios = [
        share * (old.high - old.low) / (new.high - new.low)
        for share, old, new in zip(shares, before.estimates, after.estimates, strict=True)
        if math.isfinite(old.high - old.low) and math.isfinite(new.high - new.low)
    ]
    assert len(ratios) >= 4, [before.estimates, after.estimates]
    assert np.median(ratios) == pytest.approx(1.0, abs=0.2)


@pytest.mark.slow
def test_where_the_device_is_used_the_effort_becomes_surer(run: Path) -> None:
    law = law_of_run(run, None)
    region = Region((1500.0, 1800.0), (-5.0, 5.0))
    bands = [
        designed_for(law, LIMITS, law.rate, 4.0, 2, criterion=criterion, where=region)[1].band_after
        for criterion in ("I", "A")
    ]
    assert bands[0] < bands[1]


@pytest.mark.slow
def test_what_a_run_left_empty_is_filled(run: Path) -> None:
    law = law_of_run(run, None)
    few = law.rows.elements[0].field < 0.3 * LIMITS.field
    narrow = LawOfRun(law.name, law.model, law.estimates, law.rows.take(few))
    empty = cells_of_run(narrow, LIMITS, law.rate, 3.0, one_way=False).counts == 0
    filled = designed_for(narrow, LIMITS, law.rate, 3.0, 2, criterion="fill")[0]
    by_chance = chosen_sequence(LIMITS, law.rate, 3.0, np.random.default_rng(2))
    rows: list[float] = []  # share of the rows that lie in cells that were empty
    visited: list[int] = []
    for commands in (filled, by_chance):
        cells = CellCounts(Bounds.of(LIMITS, law.rate, 3.0), law.rate, signed=False, one_way=False)
        cells.known(commands.field, commands.speed)
        rows.append(float(cells.counts[empty].sum() / cells.counts.sum()))
        visited.append(int(np.count_nonzero(cells.counts[empty])))
    assert rows[0] > 1.1 * rows[1]
    assert visited[0] > 1.3 * visited[1]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("stroke", "heat"), [(1.0, math.inf), (math.inf, 8.0)], ids=["short stroke", "little heat"]
)
def test_what_fills_cells_fills_more_of_them_than_the_papers_draws(
    stroke: float, heat: float, run: Path
) -> None:
    """Within the limits of a real damper's log it filled 48 % of the cells, and the draws 59 %."""
    law = law_of_run(run, None)
    limits = replace(LIMITS, stroke=stroke)
    if math.isfinite(heat):
        limits = replace(limits, heat=heat, effort=1.0, idle_effort=0.2, slow_effort=0.1)
    filled = designed_for(law, limits, law.rate, 4.0, 0, criterion="fill")[0]
    shares: list[float] = []
    for commands in (filled, papers_sequence(limits, law.rate, 4.0, np.random.default_rng(0))):
        cells = cells_of_run(law, limits, law.rate, 4.0, one_way=False)
        cells.known(commands.field, commands.speed)
        shares.append(cells.share())
    assert shares[0] > 1.05 * shares[1]


@pytest.mark.slow
def test_the_recommended_law_of_a_run_is_asked(run: Path) -> None:
    """The law that was best on the rows held out was asked, which the training rows had not chosen."""
    good(
        "fit",
        "log.csv",
        "--models",
        "bingham",
        "casson",
        "--lag",
        "none",
        "--out",
        "two",
        cwd=run.parent,
    )
    place = run.parent / "two"
    other = read_run(place).names[1]
    file = place / "run.json"
    body = json.loads(file.read_text(encoding="utf-8")) | {"recommended": other}
    body.pop("digest")
    file.write_text(json.dumps({**body, "digest": digest_of(body)}), encoding="utf-8")
    assert law_of_run(place, None).name == other


@pytest.mark.slow
def test_a_log_that_is_there_is_worth_what_it_would_teach(run: Path) -> None:
    law = law_of_run(run, None)
    knowledge = Knowledge(law.model, law.rows, law.rate)
    commands = chosen_sequence(LIMITS, law.rate, 3.0, np.random.default_rng(0))
    log = Sensitivity(law.model).of_commands([(commands.field, commands.speed)], law.rows.period)
    before = knowledge.criterion(knowledge.information)
    worth = knowledge.worth(log)
    knowledge.learn(commands)
    assert worth == pytest.approx(before - knowledge.criterion(knowledge.information))
    assert 0.0 < knowledge.worth(log) < worth


@pytest.mark.parametrize(
    ("text", "region"),
    [
        ("field 0..2 A, slip +-5 rad/s", Region((0.0, 2.0), (-5.0, 5.0))),
        ("slip -1.5 .. 3e1", Region((-math.inf, math.inf), (-1.5, 30.0))),
    ],
)
def test_a_region_is_read(text: str, region: Region) -> None:
    assert region_of(text) == region


@pytest.mark.parametrize("text", ["", "field", "speed 0..1", "field 1-2"])
def test_a_region_that_is_none(text: str) -> None:
    with pytest.raises(SettingError, match="no range"):
        region_of(text)


@pytest.mark.slow
def test_the_command_says_what_it_expects(run: Path) -> None:
    place = run.parent
    words = (
        "--run",
        "run",
        "--seconds",
        "3",
        "--where",
        "field 0..900 V, slip +-9 rad/s",
        "--force",
    )
    said = good("excite", *words, cwd=place)
    assert "half width of the 95 % interval" in said
    assert "with the log" in said
    assert "--where is a region" in refused(
        "excite", "--run", "run", "--where", "field 5e6..6e6", "--force", cwd=place
    )
    kept = json.loads(good("excite", *words, "--json", cwd=place))
    assert 0.0 < kept["half_widths"]["T_y"]["after"] < kept["half_widths"]["T_y"]["now"]


def test_chance_in_the_first_interval_counts_by_the_share_that_old_rows_keep() -> None:
    """An interval that chance made twice as wide as the noise says, before and after new rows."""
    number = Estimate("T_y", "", "N m", 1.0, 0.8, 1.2)
    for shrink, alike, foretold in (
        (1.0, 1.0, 0.2),  # nothing new
        (
            0.1,
            1.0,
            0.2 * 0.1 * np.sqrt(0.01 + 0.99 / 4.0),
        ),  # nearly all is new, and has no such chance
        (0.1, 1e9, 0.02),  # neighbours are alike: new rows are like the old ones
    ):
        expected = Expectation(
            np.ones(1), np.array([shrink]), 0.0, 0.0, 0.0, alike, np.array([0.1])
        )
        ((now, after),) = expected.half_widths([number])
        assert now == pytest.approx(0.2)
        assert after == pytest.approx(foretold, rel=1e-6)
    unknown = Expectation(np.ones(1), np.array([0.5]), 0.0, 0.0, 0.0, 1.0, np.array([np.nan]))
    assert unknown.half_widths([number])[0][1] == pytest.approx(0.1)


@pytest.mark.slow
def test_the_sequence_is_for_the_kind_of_device_that_the_run_is_of(tmp_path: Path) -> None:
    """A damper's run in m/s asked for no device, and got commands in rad for a brake."""
    rows = ["t [s],I [A],v [m/s],F [N]"]
    for row in range(3000):
        speed = 0.1 * math.cos(0.04 * row)
        current = (row // 100) % 3
        rows.append(
            f"{row / 500},{current},{speed:.5f},{(20 + 80 * current) * math.tanh(speed / 0.02):.4f}"
        )
    (tmp_path / "log.csv").write_text("\n".join(rows) + "\n")
    good("fit", "log.csv", "--models", "bingham", "--lag", "none", "--out", "run", cwd=tmp_path)
    said = good("excite", "--run", "run", "--seconds", "2", "--out", "next.csv", cwd=tmp_path)
    assert "COMMANDS for a damper" in said
    assert " rad" not in said
    header = next(
        line for line in (tmp_path / "next.csv").read_text().splitlines() if "slip" in line
    )
    assert "slip [m/s],position [m]" in header


@pytest.mark.slow
def test_a_law_without_further_inputs_is_asked_where_the_recommended_law_has_some(
    tmp_path: Path,
) -> None:
    """A report printed the command, and the command ended in an error."""
    folder = warm_run(tmp_path)
    assert read_run(folder).recommended == "bingham+lag+softening"
    assert law_of_run(folder, None).name == "bingham+lag"
    with pytest.raises(
        SettingError, match="has further inputs, and a sequence sets fields and motions alone"
    ):
        law_of_run(folder, "bingham+lag+softening")
