"""What cannot be exported or verified: one clear error, nothing half-written."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from erclutch.cli import app
from erclutch.errors import ErclutchError, ExportError, RunError
from erclutch.export import ExportOptions, export_model, step_of, verify_export
from erclutch.models.law_model import TorqueModel
from erclutch.models.load import load_model
from erclutch.models.model_file import digest_of
from erclutch.models.networks.network_model import NetworkModel
from erclutch.signals.speed import Derivative


def test_a_model_with_nan_is_refused_by_name(
    law: Callable[..., TorqueModel], tmp_path: Path
) -> None:
    model = law("bingham")
    bad = replace(model, gains={**model.gains, "eta_1": float("nan")})
    with pytest.raises(ExportError, match="eta_1 is nan"):
        export_model(bad, tmp_path / "out")
    assert list(tmp_path.iterdir()) == []


def test_a_network_with_an_infinite_weight_is_refused(network: Callable[..., NetworkModel]) -> None:
    model = network("fnn-3")
    weights = {**model.weights, "b1": model.weights["b1"] * float("inf")}
    with pytest.raises(ExportError, match="b1 is"):
        step_of(replace(model, weights=weights))


@pytest.mark.parametrize("name", ["string", "Math", "erc_core", "ERC_x"])
def test_a_name_of_another_header(
    law: Callable[..., TorqueModel], name: str, tmp_path: Path
) -> None:
    """With the export's folder among those of includes, `#include <string.h>` would take the export."""
    with pytest.raises(ExportError, match="is the name of another header"):
        export_model(law("bingham"), tmp_path / "out", options=ExportOptions(name=name))
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("name", ["", "2nd", "a-b", "int", "class", "_x", "a__b", "größe", "a b"])
def test_a_name_that_is_no_c_identifier(
    law: Callable[..., TorqueModel], name: str, tmp_path: Path
) -> None:
    with pytest.raises(ExportError, match="no name for C functions"):
        export_model(law("bingham"), tmp_path / "out", options=ExportOptions(name=name))
    assert list(tmp_path.iterdir()) == []


def test_a_run_in_place_of_its_model_is_refused_with_the_call_that_gives_it(tmp_path: Path) -> None:
    class Run:
        """A run as far as an export looks at it."""

        def model(self) -> None:
            """The recommended model."""

    for given, remedy in (
        ("a.run", r"erclutch.read_run\('a.run'\).model\(\)"),
        (Run(), r"run.model\(\)"),
    ):
        with pytest.raises(ExportError, match=remedy):
            export_model(given, tmp_path / "out")
    assert list(tmp_path.iterdir()) == []


def test_a_name_too_long_for_c(law: Callable[..., TorqueModel]) -> None:
    with pytest.raises(ExportError, match="21 characters"):
        step_of(law("bingham"), ExportOptions(name="a" * 21))


class Opaque:
    """An estimator with predict and nothing that says how."""

    def predict(self, x: Any) -> Any:
        return x


@pytest.mark.parametrize("thing", [Opaque(), lambda x: x, None, {"kind": "x"}])
def test_an_opaque_estimator_is_refused_with_the_reason(thing: object, tmp_path: Path) -> None:
    with pytest.raises(ExportError, match="its equation is not known"):
        export_model(thing, tmp_path / "out")


def test_a_model_of_a_newer_schema(law: Callable[..., TorqueModel], tmp_path: Path) -> None:
    body = {k: v for k, v in law("bingham").to_dict().items() if k != "digest"} | {"schema": 2}
    path = tmp_path / "model.json"
    path.write_text(json.dumps({**body, "digest": digest_of(body)}), encoding="utf-8")
    with pytest.raises(
        RunError, match="schema 2, of a newer version of erclutch; this version reads schema 1"
    ) as caught:
        load_model(path)
    assert "pip install --upgrade erclutch" in str(caught.value)


def test_a_network_of_a_newer_schema(network: Callable[..., NetworkModel], tmp_path: Path) -> None:
    body = {k: v for k, v in network("fnn-3").to_dict().items() if k != "digest"} | {"schema": 9}
    path = tmp_path / "model.json"
    path.write_text(json.dumps({**body, "digest": digest_of(body)}), encoding="utf-8")
    with pytest.raises(RunError, match=r"schema 9, of a newer version.*Update erclutch"):
        load_model(path)


def test_a_folder_that_cannot_be_written(law: Callable[..., TorqueModel], tmp_path: Path) -> None:
    with pytest.raises(ExportError, match="parent folder does not exist"):
        export_model(law("bingham"), tmp_path / "no" / "out")
    (tmp_path / "file").write_text("x", encoding="utf-8")
    with pytest.raises(ExportError, match=r"does not exist|cannot be written"):
        export_model(law("bingham"), tmp_path / "file" / "out")
    (tmp_path / "mine").mkdir()
    with pytest.raises(ExportError, match="is not an export"):
        export_model(law("bingham"), tmp_path / "mine", force=True)


@pytest.mark.slow
def test_a_disk_that_fails_leaves_nothing(
    law: Callable[..., TorqueModel], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(source: Any, to: Any, flag: int) -> bool:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("erclutch.files.places._renamed", full)
    with pytest.raises(ExportError, match="No space left"):
        export_model(law("bingham"), tmp_path / "out")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.slow
def test_an_export_is_replaced_only_when_told_to(
    law: Callable[..., TorqueModel], tmp_path: Path
) -> None:
    export_model(law("bingham"), tmp_path / "out")
    with pytest.raises(ExportError, match="there is an export already"):
        export_model(law("hem"), tmp_path / "out")
    export_model(law("hem"), tmp_path / "out", force=True)
    assert (tmp_path / "out" / "hem.c").is_file()
    assert not (tmp_path / "out" / "bingham.c").exists()


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (ExportOptions(precision="float16"), "precision"),  # type: ignore[arg-type]
        (ExportOptions(period=0.0), "a period of 0 s"),
        (ExportOptions(period=float("nan")), "a period of nan s"),
        (ExportOptions(limits=(1.0, -1.0)), "effort limits"),
        (ExportOptions(limits=(0.0, float("inf"))), "effort limits"),
        (ExportOptions(inputs="angles", derivative=Derivative("savgol")), "samples of the future"),
        (
            ExportOptions(inputs="angles", derivative=Derivative("kalman", 800.0)),
            "a cutoff of 800 Hz",
        ),
        (ExportOptions(period=1e-7), "rows at a period"),
    ],
)
def test_an_option_that_does_not_fit(
    law: Callable[..., TorqueModel], options: ExportOptions, says: str
) -> None:
    model = law("bingham", "coaxial", "lag")
    model = replace(model, shape={**model.shape, "delay": 0.04})
    with pytest.raises(ErclutchError, match=says):
        step_of(model, options)


def test_a_network_with_dynamics_needs_a_period(network: Callable[..., NetworkModel]) -> None:
    with pytest.raises(ExportError, match="--period"):
        step_of(network("fnn-3", "coaxial", "lag"))


@pytest.mark.slow
def test_a_memory_at_another_period_is_told(
    law: Callable[..., TorqueModel], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    still, lagged = law("bingham", "coaxial"), law("bingham", "coaxial", "lag")
    own = lagged.period
    assert (
        step_of(lagged).other_period
        == step_of(lagged, ExportOptions(period=1.004 * own)).other_period
        == ""
    )
    assert step_of(still, ExportOptions(period=3.0 * own)).other_period == ""
    path = tmp_path / "model.json"
    path.write_text(json.dumps(lagged.to_dict()), encoding="utf-8")
    app(
        ["export", str(path), "--out", str(tmp_path / "out"), "--period", "0.004"],
        exit_on_error=False,
    )
    said = " ".join(capsys.readouterr().out.split())
    assert f"fitted to rows of {1e3 * own:.4g} ms and is called every 4 ms." in said
    assert "Fit with --resample 250Hz" in said


def test_past_rows_are_of_the_training_period(
    network: Callable[..., NetworkModel], tmp_path: Path
) -> None:
    model = network("fnn-3", past=(1, 4))
    with pytest.raises(ExportError, match="past rows, dynamics or filter need a sampling period"):
        step_of(model)
    known = replace(model, period=1.0003e-3)
    with pytest.raises(
        ExportError, match=r"a period of 0.002 s for a network whose inputs are rows 1, 4"
    ):
        export_model(known, tmp_path / "out", options=ExportOptions(period=2e-3))
    assert list(tmp_path.iterdir()) == []
    assert step_of(known, ExportOptions(period=1e-3)).period == 1e-3
    assert step_of(known).period == 1.0003e-3
    # A network that looks at the present row alone may run at any period, and so may a law's lag.
    assert (
        step_of(replace(network("fnn-3"), period=1e-3), ExportOptions(period=2e-3)).period == 2e-3
    )


def test_a_networks_file_holds_its_period(
    network: Callable[..., NetworkModel], tmp_path: Path
) -> None:
    model = replace(network("fnn-3", past=(1,)), period=2.5e-3)
    path = tmp_path / "model.json"
    path.write_text(json.dumps(model.to_dict()), encoding="utf-8")
    read = load_model(path)
    assert isinstance(read, NetworkModel)
    assert read.period == 2.5e-3
    body = {k: v for k, v in model.to_dict().items() if k != "digest"} | {"period_s": -1.0}
    path.write_text(json.dumps({**body, "digest": digest_of(body)}), encoding="utf-8")
    with pytest.raises(RunError, match="period_s is"):
        load_model(path)


def test_a_target_that_does_not_exist(law: Callable[..., TorqueModel], tmp_path: Path) -> None:
    with pytest.raises(ExportError, match="Did you mean python"):
        export_model(law("bingham"), tmp_path / "out", "pyhton")


@pytest.mark.slow
def test_float32_that_leaves_no_digits_is_refused(
    law: Callable[..., TorqueModel], tmp_path: Path
) -> None:
    model = law("rbfm-10")
    # Gains that cancel, as fits of many kernels have them: the direction in which the kernels hardly change anything.
    columns = model.structure.law.columns(np.linspace(0.0, 1.0, 99), np.ones(99), 1.0)[2:]
    flat = np.linalg.svd(np.column_stack(columns))[2][-1]
    names = [name for name in model.gains if name.startswith("k_") and name.endswith("_1")]
    gains = {**model.gains, **{name: 1e7 * float(g) for name, g in zip(names, flat, strict=True)}}
    with pytest.raises(ExportError, match=r"terms that nearly cancel.*--precision float64"):
        export_model(
            replace(model, gains=gains),
            tmp_path / "out",
            options=ExportOptions(precision="float32"),
        )


@pytest.mark.slow
def test_a_changed_file_is_found(law: Callable[..., TorqueModel], tmp_path: Path) -> None:
    folder = export_model(law("bingham"), tmp_path / "out")
    source = folder / "bingham.c"
    source.write_text(source.read_text(encoding="ascii").replace("0x1", "0x2", 1), encoding="ascii")
    with pytest.raises(ExportError, match=r"bingham\.c was changed"):
        verify_export(folder)
    source.unlink()
    with pytest.raises(ExportError, match=r"bingham\.c is missing"):
        verify_export(folder)


@pytest.mark.parametrize("text", ["", "[]", "{}", '{"kind": "erclutch export", "schema": 9}'])
def test_what_is_no_export(tmp_path: Path, text: str) -> None:
    with pytest.raises(ExportError):
        verify_export(tmp_path)
    (tmp_path / "export.json").write_text(text, encoding="utf-8")
    with pytest.raises(ExportError):
        verify_export(tmp_path)
