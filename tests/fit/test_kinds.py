"""A kind of model is one file: the comparison fits, ranks, keeps and reads back what it has never heard of."""

from __future__ import annotations

import re
import sys
from collections.abc import Generator, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from erclutch import registry
from erclutch.errors import CheckError, ExportError, PluginError, SettingError
from erclutch.export.step_record import step_of
from erclutch.fit.candidate import Fitted, kinds
from erclutch.fit.comparison import Settings, compare
from erclutch.logs import recording_from_arrays
from erclutch.logs.dataset import Dataset, build_dataset
from erclutch.runs.run_folder import read_run
from erclutch.runs.written_run import write_run
from erclutch.signals.recording import Recording

PACKAGE = Path(__file__).parents[2] / "examples" / "erclutch-kind-nearest"
KIND = (PACKAGE / "erclutch_kind_nearest.py").read_text(encoding="utf-8")
FIRST_LINE = "few = train.thinned(_MOST_ROWS)"


def log() -> Recording:
    """A made-up brake whose field switches."""
    rng = np.random.default_rng(0)
    field = np.repeat(rng.uniform(0.0, 1.0, 40), 50)
    slip = 3.0 * np.sin(0.011 * np.arange(2000))
    effort = field * np.tanh(5.0 * slip) + 0.1 * slip + 0.01 * rng.standard_normal(2000)
    units = {"field": "A", "slip": "rad/s", "effort": "N*m"}
    return recording_from_arrays(
        {"field": field, "slip": slip, "effort": effort}, units, rate=1000.0
    )


def bring(folder: Path, text: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """A package with a kind of model, as pip would install it."""
    (folder / "their_kind.py").write_text(text, encoding="utf-8")
    about = folder / "their_kind-1.5.dist-info"
    about.mkdir()
    (about / "METADATA").write_text(
        "Metadata-Version: 2.1\nName: their-kind\nVersion: 1.5\n", encoding="utf-8"
    )
    (about / "entry_points.txt").write_text(
        "[erclutch.kinds]\nnearest = their_kind:KIND\n", encoding="utf-8"
    )
    monkeypatch.syspath_prepend(str(folder))
    registry._others.cache_clear()


@pytest.fixture
def packages(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Generator[Path]:
    yield tmp_path
    monkeypatch.undo()
    sys.modules.pop("their_kind", None)
    registry._others.cache_clear()


def test_ours_are_files_in_the_order_in_which_one_builds_on_another() -> None:
    assert [plugin.name for plugin, _ in kinds()] == [
        "law-alone",
        "law-with-network",
        "network-alone",
    ]


@pytest.mark.slow
def test_another_kind_is_one_file(
    packages: Path, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    lower_places = 'assert {each.candidate.name for each in fitted} in ({"bingham"}, set())'
    bring(packages, KIND.replace(FIRST_LINE, f"{lower_places}; {FIRST_LINE}"), monkeypatch)
    recording = log()
    compared = compare(build_dataset(recording), Settings(("bingham", "nearest-3"), lag="none"))
    assert {entry.name for entry in compared.entries} == {"bingham", "nearest-3"}
    nearest = compared.entry("nearest-3")
    assert nearest.test.share.value < 0.3
    assert nearest.band is not None
    # Of two that are as good the law would go first: neighbours know nothing beyond their rows.
    assert (compared.recommended, nearest.outcome.freedom) == ("bingham", 2)

    run = read_run(write_run(tmp_path / "run", compared, [recording]))
    again = run.model("nearest-3")
    assert_array_equal(again.predict(compared.data), nearest.predicted)
    with pytest.raises(ExportError):
        step_of(again)


@pytest.mark.slow
def test_what_fails_in_another_kind_is_told_with_its_name(
    packages: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    bring(packages, KIND.replace(FIRST_LINE, "raise OSError('no disk')"), monkeypatch)
    why = r"nearest.*of their-kind 1\.5 failed on nearest-3: OSError: no disk"
    with pytest.raises(PluginError, match=why):
        compare(build_dataset(log()), Settings(("nearest-3",), lag="none"))
    compared = compare(build_dataset(log()), Settings(("bingham", "nearest-3"), lag="none"))
    assert [entry.name for entry in compared.entries] == ["bingham"]
    (said,) = [finding for finding in compared.findings if finding.subject == "left out"]
    assert said.level == "warning"
    assert re.search(why, said.message)


@pytest.mark.slow
def test_a_law_that_the_rows_cannot_make_is_left_out(monkeypatch: pytest.MonkeyPatch) -> None:
    from erclutch.fit.kinds import law_alone as law

    fit = law.fit_structure

    def refuse(data: object, structure: object) -> object:
        if getattr(structure, "specification", "").startswith("casson"):
            raise CheckError("no rows for it", remedy="Log more")
        return fit(data, structure)  # type: ignore[arg-type]

    monkeypatch.setattr(law, "fit_structure", refuse)
    compared = compare(build_dataset(log()), Settings(("bingham", "casson"), lag="none"))
    assert [entry.name for entry in compared.entries] == ["bingham"]
    assert [f.message for f in compared.findings if f.subject == "left out"] == [
        "casson is left out: no rows for it"
    ]


@pytest.mark.slow
def test_of_two_fits_with_one_name_the_better_is_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    """A run that keeps two models of one name could not be read."""
    from erclutch.fit.candidate import Grown
    from erclutch.fit.kinds.law_alone import LawCandidate, Laws

    def the_same_without_friction(
        self: Laws, settings: Settings, train: Dataset, fitted: Sequence[Fitted]
    ) -> Grown:
        del self, settings, train
        structure = fitted[0].outcome.model.structure
        return Grown([LawCandidate(replace(structure, friction=False, offset=False))])

    data = build_dataset(log())
    data = replace(data, effort=data.effort + 0.3 * np.sign(data.elements[0].slip))
    settings = Settings(models=("bingham",), lag="none")
    alone = compare(data, settings)
    monkeypatch.setattr(Laws, "grown", the_same_without_friction)
    (entry,) = compare(data, settings).entries
    assert entry.outcome.train_cost == alone.entries[0].outcome.train_cost


def test_a_name_of_no_kind_is_an_unknown_law() -> None:
    with pytest.raises(SettingError, match="unknown law 'nearest-3'"):
        compare(build_dataset(log()), Settings(("nearest-3",)))
