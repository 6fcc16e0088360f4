"""The equations that a report shows are those of the code, whether they were kept or are made now."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from erclutch.models.laws import law_from_name, shown_laws
from erclutch.report.html import equations
from erclutch.report.html.equations import made_terms, memory_terms_of, terms_of
from erclutch.report.html.symbols import equation_text


@pytest.fixture(autouse=True)
def _own_cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Any:
    monkeypatch.setenv("ERCLUTCH_CACHE", str(tmp_path / "cache"))
    terms_of.cache_clear()
    yield
    terms_of.cache_clear()


def forget() -> None:
    """What this process has in memory; the cache's files stay."""
    terms_of.cache_clear()


@pytest.mark.slow
def test_what_is_kept_is_what_the_code_gives(monkeypatch: pytest.MonkeyPatch) -> None:
    for device in ("single", "coaxial"):
        for name in (*shown_laws(), "hem/forward"):
            made = made_terms(law_from_name(name, device))
            assert list(terms_of(name, device)) == made
            forget()
            with monkeypatch.context() as patched:
                patched.setattr(equations, "made_terms", pytest.fail)
                assert list(terms_of(name, device)) == made
            assert len(made) == len(law_from_name(name, device).gains)


def test_terms_of_memory() -> None:
    terms = memory_terms_of("lag+dahl-2+viscous+effort-lag")
    assert [re.sub("<[^>]*>", "", term).replace("&InvisibleTimes;", "") for term in terms] == [
        *("Ts1s1", "Ts2s2", "Tz1s1y(E)", "Tz2s2y(E)"),
        *("Tvv", "Tvyvy(E)"),
    ]
    memory_terms_of.cache_clear()
    assert memory_terms_of("lag+dahl-2+viscous+effort-lag") == terms
    assert memory_terms_of("lag+effort-lag") == ()


def test_names_in_an_equation_become_symbols() -> None:
    assert equation_text("tau_e T' = z1^2 - |w|^p") == (
        "<i>τ</i><sub>e</sub> <i>T</i>′ = <i>z</i><sub>1</sub><sup>2</sup> − |<i>w</i>|<sup><i>p</i></sup>"
    )


def test_another_law_of_the_same_name_is_not_mistaken(monkeypatch: pytest.MonkeyPatch) -> None:
    before = terms_of("bingham", "single")
    forget()
    law = law_from_name("bingham")
    columns: Any = lambda E, w, w_s, n: (np.tanh(w / w_s) * E * E * E, w)  # noqa: E731
    monkeypatch.setattr(equations, "law_from_name", lambda *_: replace(law, columns=columns))
    assert terms_of("bingham", "single") != before


@pytest.mark.parametrize("damage", [b"", b"[", b"[1]", b'{"a": "b"}', b"\xff"])
def test_a_damaged_cache_is_made_again(tmp_path: Path, damage: bytes) -> None:
    before = terms_of("casson", "single")
    (kept,) = (tmp_path / "cache").iterdir()
    kept.write_bytes(damage)
    forget()
    assert terms_of("casson", "single") == before


def test_an_equation_of_which_a_letter_changed_in_the_cache_is_made_again(tmp_path: Path) -> None:
    """The report printed another equation, in silence."""
    before = terms_of("casson", "single")
    (kept,) = (tmp_path / "cache").iterdir()
    whole = kept.read_text(encoding="utf-8")
    kept.write_text(whole.replace("<mi>w</mi>", "<mi>v</mi>", 1), encoding="utf-8")
    assert kept.read_text(encoding="utf-8") != whole
    forget()
    assert terms_of("casson", "single") == before


def test_no_cache_can_be_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "file").write_text("in the way")
    monkeypatch.setenv("ERCLUTCH_CACHE", str(tmp_path / "file"))
    assert list(terms_of("casson", "single")) == made_terms(law_from_name("casson"))
