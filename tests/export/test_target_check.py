"""What a target computed against what it should have: bits, flags, counts, limits. And letters in LaTeX."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from erclutch.arithmetic.precision import FLOAT32, FLOAT64
from erclutch.errors import ExportError
from erclutch.export import target_check
from erclutch.export.encode import latex
from erclutch.export.target_check import Check, compare, near, to_the_bit, ulps


def made(precision: Any = FLOAT64, band: int = 0) -> tuple[Any, Any]:
    """A step of scale 3, and its vectors: four efforts, two inverses at rest, one of the next step."""
    own = precision.dtype.type
    effort = np.array([1.0, -2.0, 0.0, 3.0], own)
    vectors = SimpleNamespace(
        rows=np.zeros((4, 2)),
        effort=effort,
        numpy=effort.astype(np.float64),
        field=np.array([0.5, 0.25], own),
        field_now=np.array([0.75], own),
        band=np.full((band, 2), 0.125, own),
        flags=np.array([0, 1, 2, 3], np.uint32),
        field_flags=np.array([4, 5], np.uint32),
        field_now_flags=np.array([6], np.uint32),
    )
    return SimpleNamespace(precision=precision, scale=3.0), vectors


def printed(vectors: Any, precision: Any, rows: int) -> list[str]:
    values = np.concatenate(
        [vectors.effort, vectors.field, vectors.field_now, vectors.band.ravel()]
    )[:rows]
    flags = [0, 1, 2, 3, 4, 5, 6, *[0] * vectors.band.size]
    return [
        f"{int(b):x} {flag}" for b, flag in zip(values.view(precision.bits), flags, strict=False)
    ]


@pytest.mark.parametrize("precision", [FLOAT32, FLOAT64])
@pytest.mark.parametrize("band", [0, 2])
def test_lines_are_compared_bit_by_bit(precision: Any, band: int) -> None:
    program, vectors = made(precision, band)
    for rows in {7, 7 + 2 * band}:
        lines = printed(vectors, precision, rows)
        found = compare(program, vectors, "here", "\n\n".join(lines), note="n")
        assert (found.where, found.count, found.other_bits, found.ulp, found.note) == (
            "here",
            rows,
            0,
            0.0,
            "n",
        )
        assert found.passed
    lines[0] = f"{int(lines[0].split()[0], 16) + 2:x} 0"
    lines[-1] = lines[-1].rsplit(" ", 1)[0] + " 9"
    found = compare(program, vectors, "here", "\n".join(lines))
    assert (found.other_bits, found.passed) == (2, False)
    step = np.spacing(precision.dtype.type(1.0)) / np.spacing(precision.dtype.type(3.0))
    assert found.ulp == pytest.approx(2.0 * step)


@pytest.mark.parametrize("rows", [0, 6, 8, 10, 12])
def test_too_few_or_too_many_lines(rows: int) -> None:
    program, vectors = made(band=2)
    lines = (printed(vectors, FLOAT64, 11) * 2)[:rows]
    with pytest.raises(ExportError, match=f"unreadable results: {rows} results for 7 vectors"):
        compare(program, vectors, "here", "\n".join(lines))
    for wrong in ("0", "0 x", "xyz 0"):
        with pytest.raises(ExportError, match="unreadable results"):
            compare(program, vectors, "here", "\n".join([*printed(vectors, FLOAT64, 6), wrong]))


def test_flags_count_as_bits_do() -> None:
    program, vectors = made()
    flags = vectors.flags.copy()
    flags[2] ^= 8
    assert to_the_bit(program, vectors, "here", vectors.effort, flags).other_bits == 1
    assert (
        to_the_bit(program, vectors, "here", -vectors.effort, vectors.flags).other_bits == 4
    )  # the sign of zero too


def test_targets_of_others_have_a_limit(monkeypatch: pytest.MonkeyPatch) -> None:
    program, vectors = made()
    place = float(np.spacing(3.0))
    monkeypatch.setattr(
        target_check, "bound", lambda program, rows, precision=None: np.array([1.0, 2.0]) * place
    )
    effort = vectors.numpy + np.array([0.0, 0.0, 11.0, 0.0]) * place
    found = near(program, vectors, "there", effort, vectors.flags)
    assert (found.allowed, found.ulp, found.other_bits, found.count) == (12.0, 11.0, None, 4)
    assert found.passed
    assert not near(program, vectors, "there", vectors.numpy + 13.0 * place, vectors.flags).passed
    assert near(program, vectors, "there", effort, vectors.flags + 1).other_bits == 4
    assert near(program, vectors, "there", effort * np.nan, vectors.flags).ulp == np.inf
    monkeypatch.setattr(
        target_check, "bound", lambda program, rows, precision=None: np.array([1.6])
    )
    assert near(program, vectors, "there", effort, vectors.flags).allowed == pytest.approx(
        8.0 + 0.03 / place
    )
    assert ulps(program, 5.0 * place) == 5.0


def test_what_passes() -> None:
    assert Check("x", 1, None, 3.0, 3.0).passed
    assert not Check("x", 1, None, 3.1, 3.0).passed
    assert not Check("x", 1, 1, 0.0).passed
    assert Check("x", 1, 0, 1e9).passed


@pytest.mark.parametrize(
    ("text", "tex"),
    [
        ("a b", "a b"),
        ("é", "é"),
        ("ω", r"$\omega$"),
        ("Ω", r"$\Omega$"),
        ("λ", r"$\lambda$"),
        ("Λ", r"$\Lambda$"),
        ("ο", "{[}U+03BF{]}"),
        ("x⁻¹", "x$^{-}$$^{1}$"),
        ("ﬁ", "fi"),
        ("漢", "{[}U+6F22{]}"),
        ("Α", "{[}U+0391{]}"),
    ],
)
def test_letters_of_latex(text: str, tex: str) -> None:
    assert latex(text) == tex
