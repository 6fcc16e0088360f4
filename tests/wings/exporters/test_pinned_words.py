"""What exports say stays as it is kept beside this file: of options that will and will not do, and of foreign text.

`tests/conftest.py` says how to pin anew after a change that is meant.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from erclutch.export import ExportOptions, encode, export_model, step_of, verify_export
from erclutch.export.c import compilers
from erclutch.export.c_names import c_name
from erclutch.export.cost import cost_text
from erclutch.export.export_folder import read_export
from erclutch.export.monotone import apart, monotone_share, sides
from erclutch.export.rounding import refuse_noise
from erclutch.export.step_vectors import odd_values, vectors_of
from erclutch.export.target_check import Check, near, ulps
from erclutch.export.targets import c
from erclutch.models.alarms import alarms_of
from erclutch.models.band import Band
from erclutch.models.model import Model
from erclutch.signals.speed import Derivative
from erclutch.wings.exporters.fmu.fmu_archive import token
from erclutch.wings.exporters.fmu.fmu_description import interface
from tests.support.pinning import Pinned, told

LABELS = (
    "bingham, single",
    "hem+rise-fall, coaxial",
    "fnn-3+rise-fall, single",
    "fnn-16, coaxial",
    "bingham+fnn-3, single",
)


OPTIONS: tuple[dict[str, Any], ...] = (
    {},
    *(
        {"period": p}
        for p in (
            0.9e-7,
            1e-7,
            1e-3,
            1.009e-3,
            1.011e-3,
            10.0,
            10.1,
            0.0,
            -1.0,
            float("nan"),
            float("inf"),
        )
    ),
    *(
        {"limits": pair}
        for pair in ((-1.0, 1.0), (1.0, -1.0), (1.0, 1.0), (0.0, float("inf")), (float("nan"), 1.0))
    ),
    *({"inputs": "angles", **more} for more in ({}, {"period": 1e-3})),
    *(
        {"inputs": "angles", "period": 1e-3, "derivative": Derivative(name)}
        for name in ("savgol", "difference", "lowpass")
    ),
    *({"alarms": True, **more} for more in ({}, {"period": 1e-3})),
    {"adapt": True},
    {"precision": "float16"},
)


@pytest.mark.slow
@pytest.mark.parametrize("label", LABELS)
def test_options(label: str, models: dict[str, Model], pinned: Pinned) -> None:
    def said(options: dict[str, Any]) -> Any:
        step = step_of(models[label], ExportOptions(**options))
        own = [
            step.name,
            step.inputs,
            step.units,
            step.period,
            step.filter and vars(step.filter),
            list(step.limits),
        ]
        return [
            *own,
            vars(step.field),
            vars(step.slip),
            step.both,
            step.scale,
            vars(step.search),
            step.measures,
        ]

    pinned([told(lambda o=o: said(o)) for o in OPTIONS])


def test_alarms(pinned: Pinned) -> None:
    widths = tuple(0.01 * 1.1**k for k in range(24))
    head: Any = (0.95, 0.01, 40.0)
    ranges: Any = ((0.0, 600.0), (-20.0, 20.0), (100.0, 300.0, 500.0), (5.0, 15.0))
    parts: Any = (*head, *ranges, widths, tuple(1.5 * w for w in widths))
    band = Band(*parts)
    found: list[Any] = []
    for largest, period in ((2.0, 1e-3), (0.5, 0.02), (2.0, 10.0)):
        alarms = alarms_of(band, largest, period)
        named = {k: v for k, v in vars(alarms).items() if k != "band"}
        found.append(
            [
                named,
                [
                    alarms.wealth(x, s, t)
                    for x in (1.0, 9.0)
                    for s in (0.0, 0.1, 1.0)
                    for t in (0.05, 0.5)
                ],
            ]
        )
    pinned(found)


def test_names_of_c(pinned: Pinned) -> None:
    wanted = (
        None,
        "",
        "m",
        "m1",
        "1m",
        "m-1",
        "int",
        "while",
        "main",
        "erc_model",
        "a" * 20,
        "a" * 21,
        "é",
        "a b",
        "_a",
        "A",
    )
    names = ("bingham+lag", "fnn-16", "a/b+c", "9", "", "x" * 40, "int")
    pinned(
        [
            [told(lambda w=w: c_name("bingham", w)) for w in wanted],
            [told(lambda n=n: c_name(n)) for n in names],
        ]
    )


def test_foreign_text(pinned: Pinned) -> None:
    texts = (
        "plain ~!#$%&'()*+,-./:;<=>?@[]^_`{|}",
        "*/ /* // ??/ \\",
        "\"quoted\" 'so'",
        *("µ°Ω·²⁻¹½é ß Ж 漢 −–", "a\nb\tc\x00\x7f", "--", "-->]]>", "~^\\_", "ΓΔαοπ√∞", ""),
    )
    ways = (
        encode.comment,
        encode.c_string,
        encode.matlab_string,
        encode.markup,
        encode.latex,
        encode.markdown,
    )
    pinned({way.__name__: [way(text) for text in texts] for way in ways})


@pytest.mark.slow
@pytest.mark.parametrize("label", [*LABELS, "on-off, coaxial", "rbfm-5+lag, coaxial"])
def test_numbers_around_a_step(label: str, models: dict[str, Model], pinned: Pinned) -> None:
    model = models[label]
    step = step_of(model, ExportOptions(period=1e-3))
    signed = np.linspace(-1.0, 1.0, 7)
    edges = [e[np.abs(e) < 1e30].tolist() for e in odd_values(step)]
    own = [
        sides(model),
        monotone_share(model),
        [x.tolist() for x in apart(model, signed)],
        cost_text(step),
    ]
    pinned([*own, edges, ulps(step, 1e-9)])
    refuse_noise(step)


@pytest.mark.slow
def test_a_check_passes_at_its_limit_and_no_further(models: dict[str, Model]) -> None:
    assert [
        Check("x", 1, other, ulp, 4.0).passed for other in (None, 0, 1) for ulp in (3.9, 4.0, 4.1)
    ] == [
        *(True, True, False),
        *(True, True, False),
        *(False, False, False),
    ]
    step = step_of(models["bingham, single"], ExportOptions(period=1e-3))
    vectors = vectors_of(step)
    exact = near(step, vectors, "x", vectors.numpy, vectors.flags)
    assert (exact.other_bits, exact.ulp, exact.passed) == (None, 0.0, True)
    off = vectors.numpy + np.where(
        np.arange(vectors.numpy.size) == 7, 2.0 * exact.allowed * ulps(step, 1.0) ** -1, 0.0
    )
    assert not near(step, vectors, "x", off, vectors.flags).passed
    assert near(step, vectors, "x", off, vectors.flags).ulp == pytest.approx(
        2.0 * exact.allowed, rel=0.05
    )
    assert (
        near(step, vectors, "x", vectors.numpy, vectors.flags ^ 1).other_bits == vectors.flags.size
    )
    assert near(step, vectors, "x", vectors.numpy * np.nan, vectors.flags).ulp == np.inf


@pytest.mark.slow
def test_a_token_is_of_the_c_alone(models: dict[str, Model]) -> None:
    face = interface(step_of(models["bingham, single"], ExportOptions(period=1e-3)))
    assert token(replace(face, code=(face.code[0], "another"))) == token(face)
    assert token(replace(face, code=(face.code[0] + " ", face.code[1]))) != token(face)


@pytest.mark.slow
@pytest.mark.parametrize(
    "label",
    ["fnn-3+rise-fall, single", pytest.param("hem+rise-fall, coaxial", marks=pytest.mark.slow)],
)
@pytest.mark.parametrize("to", ["c", "python"])
def test_inverses_and_steps_have_their_bits_in_c(
    to: str,
    label: str,
    models: dict[str, Model],
    tmp_path: Path,
    need: Callable[..., None],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """One compiler at one level; the slow tests have all of them."""
    need("gcc")
    monkeypatch.setattr(c, "_LEVELS", ("-O1",))
    monkeypatch.setattr(c, "natives", lambda: compilers.natives()[:1])
    monkeypatch.setattr(c, "foreign", tuple)
    folder = export_model(models[label], tmp_path / to, to, ExportOptions(name="m", period=2e-3))
    checks = verify_export(folder)
    assert [(check.passed, check.other_bits) for check in checks] == [(True, 0)] * (
        1 if to == "c" else 2
    )
    assert all(check.count >= 300 for check in checks)
    assert read_export(folder).step.period == 2e-3
