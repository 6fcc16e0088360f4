"""Every row of logs beyond memory is scored block by block, with the figures that all rows at once would give."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from scipy.io import savemat

from erclutch.errors import RunError
from erclutch.fit.choice.scoring import score
from erclutch.fit.comparison import Comparison, Settings, compare
from erclutch.logs import any_size
from erclutch.logs.any_size import RowsOfLogs, read_rows
from erclutch.logs.batches import neighbours
from erclutch.logs.dataset import Dataset, build_dataset
from erclutch.logs.reading import Reading
from erclutch.logs.synthetic import synthetic_log
from erclutch.runs.every_row import PartSums, predictions, score_every_row
from erclutch.runs.every_row_folder import (
    FILE,
    FOLDER,
    KeptParts,
    read_every_row,
    unfinished_plan,
    write_every_row,
)
from erclutch.runs.run_folder import read_run
from erclutch.runs.scoring_plan import HeldOut, Part, plan_of
from erclutch.runs.tasks import Tasks, tasks_on
from erclutch.runs.written_run import write_run

pytestmark = [pytest.mark.slow, pytest.mark.usefixtures("read_here")]

ROWS = 60_000
MODELS = ("bingham+lag", "bingham+lag+dahl/field+effort-lag", "fnn-4", "bingham+fnn-4+lag")


def log_file(path: Path) -> Path:
    """60 s of the SYNTHETIC log, with a gap after each 20 s."""
    columns = synthetic_log(ROWS / 1000.0)
    time = columns["time"][1] + np.arange(ROWS) // 20_000
    named = {
        f"{name} [{unit}]": values for name, (unit, values) in columns.items() if name != "time"
    }
    pq.write_table(pa.table({"time [s]": time, **named}), path, row_group_size=16_384)
    return path


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return log_file(tmp_path_factory.mktemp("every-row") / "log.parquet")


@pytest.fixture(scope="module")
def fitted(log: Path) -> tuple[RowsOfLogs, Comparison]:
    """A comparison of some stretches of the log, of which tasks begin behind each gap."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(any_size, "_WITHOUT_ROWS", 0)
        patch.setattr(any_size, "_TASK", 15_000)
        rows = read_rows([log], Reading(), memory=any_size._FOR_EACH_BYTE * 32.0 * 30_000)  # pyright: ignore[reportPrivateUsage]
    return rows, compare(rows.data, Settings(MODELS, lag="none"))


@pytest.fixture(scope="module")
def whole(log: Path) -> Dataset:
    return build_dataset(Reading().read(log, "single"))


def models_of(comparison: Comparison) -> dict[str, Any]:
    return {entry.name: entry.outcome.model for entry in comparison.entries}


def blocks_of(data: Dataset, edges: list[int]) -> Iterator[Dataset]:
    """The rows in blocks that end at some rows; the second is shorter than what a block needs ahead of it."""
    for start, stop in zip([0, *edges], [*edges, data.rows], strict=True):
        yield neighbours(data, start, stop)


@pytest.mark.parametrize("edges", [[30_000], [9_000, 9_100, 19_990, 20_000, 20_001, 43_000]])
def test_blocks_are_predicted_as_all_rows_at_once(
    fitted: tuple[RowsOfLogs, Comparison], whole: Dataset, edges: list[int]
) -> None:
    """A border is not seen: states go on, and what a delay reaches back to is there."""
    models = models_of(fitted[1])
    model = models["bingham+lag+dahl/field+effort-lag"]
    delayed = replace(model, shape={**model.shape, "delay": 0.0213})
    models["delayed"] = delayed
    at_once = {name: each.predict(whole) for name, each in models.items()}
    in_blocks: dict[str, list[np.ndarray]] = {name: [] for name in models}
    for _, _, predicted in predictions(models, blocks_of(whole, edges)):
        for name, effort in predicted.items():
            in_blocks[name].append(effort)
    for name, efforts in in_blocks.items():
        np.testing.assert_allclose(
            np.concatenate(efforts), at_once[name], rtol=0, atol=1e-9, err_msg=name
        )


def test_figures_are_those_of_all_rows(
    fitted: tuple[RowsOfLogs, Comparison], whole: Dataset
) -> None:
    rows, comparison = fitted
    plan = plan_of(rows, comparison)
    assert len(plan.parts) == 3
    assert plan.rows == ROWS > plan.kept_rows == comparison.data.rows
    figures = score_every_row(plan, models_of(comparison), Reading(), Tasks(None))
    held = plan.logs[0].held_out.of(0, ROWS)
    np.testing.assert_array_equal(held[rows.places], comparison.test)
    for name, model in models_of(comparison).items():
        predicted = model.predict(whole)
        for of, mask in ((figures.test, held), (figures.train, ~held)):
            wanted, found = score(whole.effort[mask], predicted[mask]), of[name]
            assert found.rows == wanted.rows
            for figure in ("mse", "rmse", "share", "r2", "largest"):
                assert getattr(found, figure).value == pytest.approx(
                    getattr(wanted, figure).value, rel=1e-9
                )
            assert found.bias == pytest.approx(wanted.bias, abs=1e-12)
            assert found.rmse.low < found.rmse.value < found.rmse.high
            wide, narrow = (x.rmse.high - x.rmse.low for x in (found, wanted))
            assert 0.4 < wide / narrow < 2.5


def test_a_log_that_changed_while_its_blocks_were_scored_is_told(
    fitted: tuple[RowsOfLogs, Comparison],
) -> None:
    """Each block is of one file; but hours may lie between the first block and the last."""
    rows, comparison = fitted
    plan = plan_of(rows, comparison)
    changed = replace(plan, logs=(replace(plan.logs[0], digest="another"),))
    with pytest.raises(RunError, match="changed since it was fitted"):
        score_every_row(changed, models_of(comparison), Reading(), Tasks(None))


def test_the_place_where_tasks_run_changes_no_figure(fitted: tuple[RowsOfLogs, Comparison]) -> None:
    rows, comparison = fitted
    plan, models = plan_of(rows, comparison), models_of(comparison)
    here = score_every_row(plan, models, Reading(), Tasks(None)).to_dict()
    for cluster, workers in ((None, 2), ("processes", 2)):
        with tasks_on(cluster, workers) as tasks:
            assert score_every_row(plan, models, Reading(), tasks).to_dict() == here
            assert (tasks.peak is None) == tasks.here


def test_recordings_of_a_file_that_is_read_whole_are_scored_too(tmp_path: Path) -> None:
    """And those that are brought to another rate."""
    path = tmp_path / "log.mat"
    savemat(path, {name: values for name, (_, values) in synthetic_log(40.0).items()})
    how = Reading(rate=500.0)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(any_size, "_WITHOUT_ROWS", 0)
        rows = read_rows([path], how, memory=any_size._FOR_EACH_BYTE * 32.0 * 12_000)  # pyright: ignore[reportPrivateUsage]
    comparison = compare(rows.data, Settings(("bingham+lag",), lag="none"))
    plan = plan_of(rows, comparison)
    figures = score_every_row(plan, models_of(comparison), how, Tasks(None))
    whole = build_dataset(how.read(path, "single"))
    assert plan.rows == whole.rows
    (model,) = models_of(comparison).values()
    held = plan.logs[0].held_out.of(0, whole.rows)
    wanted = np.mean((whole.effort - model.predict(whole))[held] ** 2)
    assert figures.test[model.name].mse.value == pytest.approx(wanted, rel=1e-9)
    changed = replace(plan, logs=(replace(plan.logs[0], digest="another"),))
    with pytest.raises(RunError, match="changed since it was fitted"):
        score_every_row(changed, models_of(comparison), how, Tasks(None))


def test_rows_that_were_not_kept_are_what_the_kept_row_before_them_is() -> None:
    held_out = HeldOut((100, 200, 300), (False, True, False))
    assert [bool(held_out.of(at, 1)[0]) for at in (0, 99, 100, 199, 200, 299, 300, 10_000)] == [
        *(False, False, False, False, True, True, False, False)
    ]


class StoppedError(Exception):
    """What ends a scoring in between."""


def kept_run(folder: Path, fitted: tuple[RowsOfLogs, Comparison]) -> Any:
    rows, comparison = fitted
    return read_run(write_run(folder, comparison, rows.logs, reading={}))


def test_a_scoring_that_was_interrupted_goes_on(
    tmp_path: Path, fitted: tuple[RowsOfLogs, Comparison]
) -> None:
    rows, comparison = fitted
    models = models_of(comparison)
    run = kept_run(tmp_path / "run", fitted)
    assert read_every_row(run) is None
    plan = plan_of(rows, comparison, str(run.body["digest"]))
    whole = score_every_row(plan, models, Reading(), Tasks(None)).to_dict()

    def stop(done: int, total: int) -> None:
        if done > 41_000:
            raise StoppedError

    with pytest.raises(StoppedError):
        score_every_row(
            plan, models, Reading(), Tasks(None), kept=KeptParts(run.folder, plan), progress=stop
        )
    assert sorted(path.name for path in (run.folder / FOLDER).iterdir()) == [
        "part-0.npz",
        "part-1.npz",
        "plan.json",
    ]

    again = unfinished_plan(read_run(run.folder))
    assert again == plan
    seen: list[int] = []
    names = {name: run.model(name) for name in run.names}
    kept = KeptParts(run.folder, again)
    figures = score_every_row(
        again,
        names,
        Reading(),
        Tasks(None),
        kept=kept,
        progress=lambda done, total: seen.append(done),
    )
    assert min(seen) > 40_000  # only the last part was read
    assert figures.to_dict() == whole
    write_every_row(run.folder, figures)
    assert not (run.folder / FOLDER).exists()
    assert read_every_row(read_run(run.folder)) == whole
    with pytest.raises(RunError, match="every row is scored already"):
        unfinished_plan(run)


def test_a_plan_that_does_not_fit_is_refused(
    tmp_path: Path, log: Path, fitted: tuple[RowsOfLogs, Comparison]
) -> None:
    rows, comparison = fitted
    run = kept_run(tmp_path / "run", fitted)
    with pytest.raises(RunError, match="no scoring of every row was begun here"):
        unfinished_plan(run)
    plan = plan_of(rows, comparison, str(run.body["digest"]))
    changed = tmp_path / "log.parquet"
    changed.write_bytes(log.read_bytes()[:-1])
    for other, problem in (
        (replace(plan, run="another"), "belongs to another run"),
        (
            replace(plan, logs=(replace(plan.logs[0], path=str(tmp_path / "gone.parquet")),)),
            "gone.parquet: cannot be",
        ),
        (
            replace(plan, logs=(replace(plan.logs[0], path=str(changed)),)),
            "changed since it was fitted",
        ),
    ):
        KeptParts(run.folder, other)
        with pytest.raises(RunError, match=problem):
            unfinished_plan(run)
        with pytest.raises(RunError, match="belongs to another plan"):
            KeptParts(run.folder, plan)
        (run.folder / FOLDER / "plan.json").unlink()
    KeptParts(run.folder, plan)
    path = run.folder / FOLDER / "plan.json"
    path.write_text(path.read_text().replace("log.parquet", "other.parquet"))
    with pytest.raises(RunError, match="was changed"):
        unfinished_plan(run)


def test_damaged_sums_are_refused(tmp_path: Path, fitted: tuple[RowsOfLogs, Comparison]) -> None:
    rows, comparison = fitted
    plan = plan_of(rows, comparison)
    kept = KeptParts(tmp_path, plan)
    score_every_row(plan, models_of(comparison), Reading(), Tasks(None), kept=kept)
    with pytest.raises(RunError, match="has the sums of other models"):
        kept.sums(3, 1)
    path = tmp_path / FOLDER / "part-1.npz"
    own = path.read_bytes()
    path.write_bytes((tmp_path / FOLDER / "part-0.npz").read_bytes())
    with pytest.raises(RunError, match=r"part-1\.npz: has the sums of other rows"):
        kept.sums(3, len(MODELS))
    path.write_bytes(own[:500])
    with pytest.raises(RunError, match=r"part-1\.npz: cannot be read"):
        kept.sums(3, len(MODELS))


def of_one_row_less(sums: PartSums) -> PartSums:
    return replace(sums, rows=np.concatenate([sums.rows[:-1], sums.rows[-1:] - 1.0]))


#: What a worker may give in place of the sums of a part.
LIES: dict[str, Callable[[Part, PartSums], tuple[Part, PartSums]]] = {
    "of other rows": lambda part, sums: (replace(part, at=part.at + 1), sums),
    "shapes": lambda part, sums: (part, replace(sums, square=sums.square[:1])),
    "effort.: .79, 1.": lambda part, sums: (part, replace(sums, effort=sums.effort[:, None])),
    "finite": lambda part, sums: (part, replace(sums, effort=sums.effort * np.inf)),
    "are numbers": lambda part, sums: (part, replace(sums, largest=sums.largest * np.nan)),
    "rows held out": lambda part, sums: (part, of_one_row_less(sums)),
    "held out, not": lambda part, sums: (part, replace(sums, held=~sums.held)),
}


@pytest.mark.parametrize("said", LIES)
def test_a_worker_that_lies_is_told(fitted: tuple[RowsOfLogs, Comparison], said: str) -> None:
    """Its sums are of another part, of another shape, not finite, or count other rows: no figure is made of them."""
    rows, comparison = fitted
    plan, models = plan_of(rows, comparison), models_of(comparison)

    class Lying(Tasks):
        def __call__(
            self, of: Callable[[Part], Any], items: Iterable[Part]
        ) -> Iterator[tuple[Part, PartSums]]:
            return (LIES[said](*of(part)) for part in items)

    with pytest.raises(
        RunError, match=rf"log\.parquet: .* do not fit what was asked for: .*{said}"
    ):
        score_every_row(plan, models, Reading(), Lying(None))


def test_kept_sums_that_do_not_fit_are_made_again(
    tmp_path: Path, fitted: tuple[RowsOfLogs, Comparison]
) -> None:
    rows, comparison = fitted
    plan, models = plan_of(rows, comparison), models_of(comparison)
    kept = KeptParts(tmp_path, plan)
    right = score_every_row(plan, models, Reading(), Tasks(None), kept=kept).to_dict()
    kept.keep(1, of_one_row_less(kept.sums(3, len(MODELS))[1]))
    assert score_every_row(plan, models, Reading(), Tasks(None), kept=kept).to_dict() == right


def test_figures_of_another_run_are_refused(
    tmp_path: Path, fitted: tuple[RowsOfLogs, Comparison]
) -> None:
    rows, comparison = fitted
    run = kept_run(tmp_path / "run", fitted)
    figures = score_every_row(
        plan_of(rows, comparison, "another"), models_of(comparison), Reading(), Tasks(None)
    )
    write_every_row(run.folder, figures)
    with pytest.raises(RunError, match="belongs to another run"):
        read_every_row(run)
    path = run.folder / FILE
    path.write_text(path.read_text().replace(": 0.", ": 1.", 1))
    with pytest.raises(RunError, match="was changed"):
        read_every_row(run)
