"""The equations that a report shows are those of the code."""

from __future__ import annotations

from importlib.resources import files

from erclutch.laws import law_from_name
from erclutch.report.equations import made_file, made_terms, terms_of, usual


def test_what_is_kept_is_what_the_code_gives() -> None:
    """Otherwise: python -m erclutch.report.equations."""
    kept = files("erclutch").joinpath("report/assets/equations.json").read_text(encoding="utf-8")
    assert kept == made_file()


def test_a_term_a_gain() -> None:
    for device, laws in usual().items():
        for law in laws:
            assert len(terms_of(law, device)) == len(law_from_name(law, device).gains)


def test_other_laws_are_made_when_asked_for() -> None:
    assert "bingham/critical/forward" not in usual()["coaxial"]
    assert list(terms_of("bingham/critical/forward", "coaxial")) == made_terms("bingham/critical/forward", "coaxial")
