"""A small run, and one of a pair, that the tests of reports share."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from erclutch.fit.comparison import Settings, compare
from erclutch.logs import read
from erclutch.logs.covering_stretches import USUAL_SHARE
from erclutch.logs.dataset import build_dataset
from erclutch.logs.synthetic import write_synthetic_log
from erclutch.report.numbers.run_material import Material, material_of
from erclutch.runs.run_folder import read_run
from erclutch.runs.written_run import write_run

_NAMES = ("quadratic", "bingham", "fnn-2")
#: With and without a lag, and with a memory, each named: a search for their stages takes three times as long.
MODELS = (*_NAMES, *(f"{name}+lag" for name in _NAMES), "bingham+lag+dahl/field")


def make_run(
    folder: Path,
    *,
    seconds: float = 4.0,
    models: tuple[str, ...] = MODELS,
    lag: str = "none",
    test: float = USUAL_SHARE,
) -> Path:
    """Fit a SYNTHETIC log and keep the run."""
    log = folder / "log.csv"
    write_synthetic_log(log, seconds)
    recording = read(log)
    settings = Settings(models=models, lag=lag, test=test)  # pyright: ignore[reportArgumentType]
    found = compare(build_dataset(recording), settings)
    return write_run(folder / "run", found, [recording], reading={"field": "field [V]"})


@pytest.fixture(scope="session")
def run_maker() -> Callable[..., Path]:
    """`make_run`, for tests that want a run of their own."""
    return make_run


@pytest.fixture(scope="session")
def kept_run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run that no test changes."""
    return make_run(tmp_path_factory.mktemp("report"))


@pytest.fixture(scope="session")
def material(kept_run: Path) -> Material:
    """The same, read."""
    return material_of(read_run(kept_run))
