"""What is exported for every kind of model stays: texts by their digests, numbers around them by their values.

The product of an export is its text, so a change of any line, however small, is to be seen here and meant. Numbers in
the texts count to nine digits: the last digits of a model's parameters differ between processors. After a change that
is meant, the values are pinned anew (`tests/conftest.py` says how); their difference says which models and targets the
change reaches.
"""

from __future__ import annotations

import hashlib
import re
import zipfile
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from erclutch._version import __version__
from erclutch.arithmetic.precision import FLOAT32, FLOAT64
from erclutch.export.c import c_header
from erclutch.export.c.compilers import Compiler
from erclutch.export.cost import operations, state_bytes
from erclutch.export.exported_step import ExportedStep, ExportOptions
from erclutch.export.rounding import bound, measured
from erclutch.export.step_record import step_of, step_record
from erclutch.export.step_vectors import vectors_of
from erclutch.export.targets import c, target
from erclutch.models.band import Band
from erclutch.models.model import Model
from erclutch.models.residual_model import ResidualModel
from erclutch.signals.speed import Derivative
from erclutch.wings.exporters.fmu import fmu_archive
from erclutch.wings.exporters.onnx_graph import onnx_model
from erclutch.wings.exporters.targets import cpp

pytestmark = pytest.mark.slow

WIDTHS = tuple(0.01 * 1.3**k for k in range(24))
BAND = Band(
    *(0.95, 0.01, 40.0, (0.0, 2000 / 3), (-30.1, 30.1), (100.0, 300.0, 500.0), (5.0, 20.0)),
    *(WIDTHS, tuple(1.5 * w for w in WIDTHS)),
)
#: Options beside the usual ones, and the models that are exported with them.
OPTIONS: Mapping[str, tuple[Mapping[str, Any], tuple[str, ...]]] = {
    "float32": (
        {"precision": "float32"},
        (
            "hem+rise-fall, coaxial",
            "rbfn-13+lag, single",
            "fnn-7, coaxial",
            "seo-seo, coaxial",
            "bingham+fnn-3, single",
        ),
    ),
    "angles": (
        {"inputs": "angles", "limits": (-3.0, 4.0), "period": 2e-3},
        ("hem+rise-fall, coaxial", "bingham, single", "fnn-10-6+lag, coaxial"),
    ),
    "difference": (
        {"inputs": "angles", "derivative": Derivative("difference")},
        ("casson+lag, single", "fnn-7, coaxial"),
    ),
    "alarms": (
        {"alarms": True},
        ("bingham, single", "bingham+rise-fall, coaxial", "fnn-16, coaxial"),
    ),
    "adapt": (
        {"adapt": True, "precision": "float32"},
        ("bingham, single", "bingham+rise-fall, coaxial"),
    ),
}
#: Of these pairs, those of the fast tests: each option once.
QUICK = {
    ("rbfn-13+lag, single", "float32"),
    ("bingham, single", "angles"),
    ("casson+lag, single", "difference"),
    ("bingham, single", "alarms"),
    ("bingham, single", "adapt"),
}
#: Models without further options whose numbers are looked at too.
COMPUTED = (
    "on-off+rise-fall, single",
    "rbfm-5+lag, coaxial",
    "fnn-3+rise-fall, single",
    "bingham/forward+rise-fall+dahl-2/field+inertia+effort-lag, coaxial",
    "herschel-bulkley+two-lags+stops-2+bouc-wen-2+lugre/field+hysteretic-tanh+stiffness+effort-second-order, single",
    "hem+rbfn-5+lag, coaxial",
)
_NUMBER = re.compile(
    r"(?<![\w.])(?:0x[\da-f]+\.?[\da-f]*p[+-]\d+|\d+\.\d+(?:e[+-]?\d+)?|\d+e[+-]?\d+)",
    re.IGNORECASE,
)
#: What holds the digest of the C: a token, the name of a library.
_DIGEST = re.compile(r"\{[\da-f]{8}(?:-[\da-f]{4}){3}-[\da-f]{12}\}|(?<=lib)m-[\da-f]{12}(?=\.so)")


#: C of an FMU that is the same for all models.
FMU_C = {"fmu-core.h", "fmu-common.h", "fmu-fmi2.h", "fmu-fmi2.c", "fmu-fmi3.h", "fmu-fmi3.c"}


def made(model: Any, options: str) -> ExportedStep:
    """The step, of a model whose last digits do not show: the digest is the name's."""
    low, high = model.trained_on.effort
    owner = model.law if isinstance(model, ResidualModel) else model
    owner = replace(
        owner, trained_on=replace(owner.trained_on, effort=(round(low, 6), round(high, 6)))
    )
    model = replace(model, law=owner) if isinstance(model, ResidualModel) else owner
    asked = OPTIONS[options][0] if options else {}
    model = replace(model, band=BAND) if "alarms" in asked else model
    digest = hashlib.sha256(f"{model.name}, {model.structure.device}".encode()).hexdigest()
    return replace(
        step_of(model, ExportOptions(**{"name": "m", "period": 1e-3, **asked})), digest=digest
    )


def _digits(found: re.Match[str]) -> str:
    text = found[0]
    return f"{float.fromhex(text) if text[1:2] in ('x', 'X') else float(text):.9g}"


def said(text: str) -> str:
    """A text without its last digits and the version of erclutch."""
    return _NUMBER.sub(_digits, _DIGEST.sub("DIGEST", text.replace(__version__, "VERSION")))


def texts(step: ExportedStep, folder: Path, patch: pytest.MonkeyPatch) -> dict[str, dict[str, str]]:
    """By target and file. No compiler runs: what it makes is empty."""
    patch.setattr("erclutch.export.targets.python.native", lambda: Compiler("none", ("none",)))
    patch.setattr(c, "vectors_header", lambda *_: "")  # numbers are looked at below
    for module in (c, cpp):
        patch.setattr(module, "vectors_of", lambda _: None)
    patch.setattr(c_header, "measured", lambda _: (1.25e-9, 2.5e-9))
    patch.setattr(
        Compiler, "build", lambda _, sources, out, *flags: out.write_bytes(" ".join(flags).encode())
    )
    found: dict[str, dict[str, str]] = {}
    for to in ("c", "python", "cpp", "simulink", "mujoco"):
        if step.measures and to in ("simulink", "mujoco"):
            continue
        (folder / to).mkdir()
        target(to).value.write(step, folder / to)
        files = {
            p.relative_to(folder / to).as_posix(): p
            for p in sorted((folder / to).rglob("m*"))
            if p.is_file()
        }
        own = {n: p for n, p in files.items() if to == "c" or p.name not in ("m.c", "m.h")}
        found[to] = {
            n: p.read_text("utf-8") for n, p in own.items() if not n.endswith("_vectors.h")
        }
    if not step.measures:
        found["onnx"] = {"m.onnx": graph_text(onnx_model(step, step_record(step, remember=False)))}
        patch.setattr(fmu_archive, "build_binaries", lambda *_: ["none"])
        for version in (2, 3):
            fmu_archive.write_fmu(step, folder, version)
            with zipfile.ZipFile(folder / f"m_fmi{version}.fmu") as fmu:
                own = [n for n in fmu.namelist() if Path(n).name not in FMU_C and "m." not in n]
                found[f"fmu{version}"] = {n: fmu.read(n).decode() for n in own}
    return found


def graph_text(model: Any) -> str:
    """Names, shapes, values and operations, in no words of the package onnx."""
    from onnx import helper, numpy_helper

    graph = model.graph
    ports = [
        (x.name, x.type.tensor_type.elem_type, [d.dim_value for d in x.type.tensor_type.shape.dim])
        for x in (*graph.input, *graph.output)
    ]
    values = [
        (x.name, str(y.dtype), y.shape, y.tolist())
        for x in graph.initializer
        for y in [numpy_helper.to_array(x)]
    ]
    nodes = [
        (
            n.op_type,
            *n.input,
            "to",
            *n.output,
            *((a.name, helper.get_attribute_value(a)) for a in n.attribute),
        )
        for n in graph.node
    ]
    said = [(p.key, p.value) for p in model.metadata_props]
    return "\n".join(map(repr, (model.doc_string, *said, *ports, *values, *nodes)))


def numbers_of(step: ExportedStep) -> dict[str, Any]:
    """What is counted, bounded and computed around the step."""
    vectors, record = vectors_of(step, 96, 32), step_record(step).record
    rows = vectors.rows.astype(np.float64)
    search = step.search
    found: dict[str, Any] = {
        "operations": dict(sorted(operations(record.flat(), step).items())),
        "state": state_bytes(step),
        "rounding": measured(step),
        "search": [
            search.segments,
            search.tolerance,
            search.width,
            search.most,
            search.monotone_share,
        ],
        "flags": [
            int(f.sum()) for f in (vectors.flags, vectors.field_flags, vectors.field_now_flags)
        ],
    }
    good = np.flatnonzero(np.all(np.abs(rows[:, : step.model_inputs]) < 1e4, axis=1))[:48]
    with np.errstate(all="ignore"):
        bounds = [bound(step, rows[good], p) for p in (FLOAT32, FLOAT64)]
    reals = {
        "rows": rows[good, : step.model_inputs],
        "numpy": vectors.numpy,
        **{
            "effort": vectors.effort,
            "field": vectors.field,
            "now": vectors.field_now,
            "band": vectors.band,
        },
        **{"bound32": bounds[0], "bound64": bounds[1]},
    }
    return found | {name: _summed(values) for name, values in reals.items()}


def _summed(values: Any) -> list[float]:
    """How large the numbers are, and a sum that knows their order."""
    flat = np.asarray(values, np.float64).ravel()
    return [float(np.abs(flat).sum()), float(flat @ np.cos(np.arange(flat.size)))]


def _found(key: str, step: ExportedStep, folder: Path, patch: pytest.MonkeyPatch) -> dict[str, Any]:
    made: dict[str, Any] = {to: digest(files) for to, files in texts(step, folder, patch).items()}
    return made | (numbers_of(step) if key in (*OPTIONS, *COMPUTED) else {})


def test_every_model(
    model: Model, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, pinned: Callable[..., None]
) -> None:
    if "rbfm-10" not in model.name:  # rbfm-5 has all that it has
        pinned(
            _found(
                f"{model.name}, {model.structure.device}", made(model, ""), tmp_path, monkeypatch
            )
        )


@pytest.mark.parametrize(
    ("label", "options"),
    [
        pytest.param(label, name, marks=() if (label, name) in QUICK else pytest.mark.slow)
        for name, (_, labels) in OPTIONS.items()
        for label in labels
    ],
)
def test_every_option(
    label: str,
    options: str,
    models: dict[str, Model],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    pinned: Callable[..., None],
) -> None:
    pinned(_found(options, made(models[label], options), tmp_path, monkeypatch))


def digest(files: Mapping[str, str]) -> str:
    """Of the files of a target, their names included."""
    whole = "".join(f"{name}\0{said(files[name])}\0" for name in sorted(files))
    return hashlib.sha256(whole.encode()).hexdigest()[:16]
