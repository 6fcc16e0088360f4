"""What a notebook shows of each class of the main job: a line, HTML that keeps to itself, DataFrames, axes."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import erclutch
from erclutch.errors import SettingError
from erclutch.report.numbers.run_material import Material

pytestmark = pytest.mark.slow

_HOSTILE = 'a<script>alert(1)</script>&"\x1b[31m.csv'


@pytest.fixture(scope="module")
def shown() -> dict[str, Any]:
    """One value of each class, of rows that are named by someone hostile."""
    rng = np.random.default_rng(3)
    time = np.arange(1200) * 1e-3
    field, slip = 1e3 * (np.sin(9.0 * time) > 0), 20.0 * np.sin(31.0 * time)
    effort = 4e-4 * field * np.tanh(slip) + 0.01 * slip + 0.01 * rng.normal(size=time.size)
    columns = {"field": field, "slip": slip, "effort": effort}
    log = erclutch.recording_from_arrays(
        columns, {"field": "V", "slip": "rad/s", "effort": "N*m"}, time=time, name=_HOSTILE
    )
    data = erclutch.build_dataset(log)
    found = erclutch.compare(data, erclutch.Settings(models=("bingham", "fnn-2"), lag="none"))
    law, network = found.entry("bingham").outcome.model, found.entry("fnn-2").outcome.model
    values = (log, data, found, found.entries[0], found.entries[0].outcome, law, network)
    return {f"{type(value).__name__}": value for value in values}


def test_single_settings_may_stand_in_the_call(shown: dict[str, Any]) -> None:
    found = erclutch.compare(shown["Dataset"], models=("quadratic",), lag="none")
    assert [entry.name for entry in found.entries] == ["quadratic"]
    assert found.settings.test == 0.3  # what "auto" came to
    assert found.settings.seed == erclutch.Settings().seed


def test_a_model_is_exported_and_verified_from_the_top(
    shown: dict[str, Any], tmp_path: Path
) -> None:
    erclutch.export_model(shown["TorqueModel"], tmp_path / "model", "python")
    assert all(check.passed for check in erclutch.verify_export(tmp_path / "model"))


def test_html_is_escaped_and_asks_for_nothing(shown: dict[str, Any]) -> None:
    for name, value in shown.items():
        drawn = value._repr_html_()
        assert "<table" in drawn, name
        assert "<script" not in drawn
        assert not re.search(r"https?://|url\(|@import", drawn), name
        assert len(drawn) < 100_000, name


def test_a_table_in_a_notebook_is_short_and_says_so(shown: dict[str, Any]) -> None:
    law = shown["TorqueModel"]
    rows = len(law.table())
    assert law._repr_html_().count("<tr") == 1 + min(rows, 8)
    assert (f"{rows - 8} more: .table()" in law._repr_html_()) == (rows > 8)


def test_a_line_needs_few_modules() -> None:
    """A recording writes its line itself, without a module of reports, fits or tables."""
    code = (
        "import sys, numpy as np, erclutch, erclutch.errors\n"
        "from erclutch.signals.recording import Recording\n"
        "log = Recording('a', {'field': np.ones(2)}, {'field': 'V'}, np.arange(2.0), 1.0, ((0, 2),), True, '')\n"
        "before = set(sys.modules)\n"
        "assert repr(log) == 'Recording(a: 2 rows, 2 s at 1 Hz, field [V])', repr(log)\n"
        "print(*sorted(name for name in set(sys.modules) - before if name.startswith('erclutch')))\n"
        "print(*sorted(name for name in sys.modules if name.startswith(('erclutch.report', 'erclutch.fit', 'pandas'))))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split() == []


@pytest.mark.slow
def test_without_the_face_of_the_package_nothing_shows(
    monkeypatch: pytest.MonkeyPatch, shown: dict[str, Any]
) -> None:
    from erclutch.signals import shown as module

    monkeypatch.setattr(module, "_given", [])
    assert repr(shown["Recording"]).startswith("Recording(")
    with pytest.raises(SettingError, match="Import erclutch first"):
        shown["Recording"].table()


def test_a_line_is_a_line(shown: dict[str, Any]) -> None:
    for name, value in shown.items():
        assert repr(value).startswith(f"{name}(")
        assert len(repr(value)) < 300
        assert not re.search(r"[\x00-\x1f]", repr(value)), name
    assert "1200 rows, 1.2 s at 1000 Hz, field [V], slip [rad/s], effort [N*m])" in repr(
        shown["Recording"]
    )


def test_a_recording_goes_out_as_a_frame_and_comes_back(shown: dict[str, Any]) -> None:
    log = shown["Recording"]
    back = erclutch.read(log.to_frame())
    assert back.units == log.units
    np.testing.assert_array_equal(back.time, log.time)
    for name, values in log.signals.items():
        np.testing.assert_array_equal(back.signals[name], values)


@pytest.mark.slow
def test_tables_hold_the_figures_unrounded(shown: dict[str, Any]) -> None:
    found, entry = shown["Comparison"], shown["RankedModel"]
    ranking = found.table()
    assert ranking["specification"].tolist() == [e.name for e in found.entries]
    assert ranking["model"].tolist() == [found.titles[e.name] for e in found.entries]
    assert ranking["rmse [N*m]"].tolist() == [e.test.rmse.value for e in found.entries]
    rows = found.to_frame()
    np.testing.assert_array_equal(rows[f"effort:{entry.name}"], entry.predicted)
    np.testing.assert_array_equal(rows["test"], found.test)
    law = shown["TorqueModel"].table().set_index("parameter")["value"]
    for estimate in found.entry("bingham").outcome.estimates:
        assert law[estimate.name] == estimate.value


def test_a_run_on_disk_shows_what_the_comparison_did(material: Material) -> None:
    run = material.run
    assert run.table()["specification"].tolist() == list(run.names)
    assert "specification" not in run._repr_html_()
    assert "SYNTHETIC" in run._repr_html_()
    assert 'srcdoc="&lt;!doctype html' in run.report()._repr_html_()
    assert run.to_frame().shape == (material.rows.data.rows, 4 + len(run.names))


def test_plots_are_axes_and_wrong_names_are_told(shown: dict[str, Any]) -> None:
    from matplotlib import pyplot

    axes = shown["Comparison"].plot("trace", start=1.0, seconds=0.1)
    assert [type(axis).__name__ for axis in axes] == ["Axes"] * 3
    assert axes[0].get_lines()[0].get_xdata().size == 101
    with pytest.raises(SettingError, match="Plots of a Comparison: ranking, trace"):
        shown["Comparison"].plot("trase")
    with pytest.raises(TypeError, match="begin"):
        shown["Recording"].plot(begin=1.0)
    pyplot.close("all")


def test_every_public_name_is_listed() -> None:
    assert dir(erclutch) == sorted(erclutch.__all__)


def test_a_plot_leaves_the_notebooks_backend_as_it_set_itself_up(
    kept_run: Path, tmp_path: Path
) -> None:
    """The inline backend turns interaction on when it is loaded; else the second plot of a session is not shown."""
    backend = "import matplotlib\nfrom matplotlib.backends.backend_agg import *\nmatplotlib.interactive(True)\n"
    (tmp_path / "inline_like.py").write_text(backend)
    code = f"import erclutch, matplotlib\nerclutch.read_run({str(kept_run)!r}).plot('ranking')\n"
    code += "assert matplotlib.is_interactive()"
    paths = os.pathsep.join((str(tmp_path), *sys.path))
    seen = {**os.environ, "MPLBACKEND": "module://inline_like", "PYTHONPATH": paths}
    subprocess.run([sys.executable, "-c", code], env=seen, check=True)


def test_a_negative_offset_is_taken_away(shown: dict[str, Any]) -> None:
    network = next(value for name, value in shown.items() if name == "NetworkModel")
    lower = replace(network, scaling=replace(network.scaling, effort_offset=-128.5))
    assert f"effort = y {network.scaling.effort_scale:.9g} - 128.5." in lower._repr_html_()
