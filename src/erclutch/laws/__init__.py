"""The laws by name.

A specification is a law's name and, after a slash, the form of its yield stress: ``bingham``, ``bingham/critical``,
``rbfm-10/square``. Without a form the device decides: square for the coaxial pair (the paper's), power for a single
one.
"""

from __future__ import annotations

import difflib
from collections.abc import Callable

from erclutch.errors import SettingError
from erclutch.laws.bingham import bingham
from erclutch.laws.casson import casson
from erclutch.laws.cho_choi_jhon import cho_choi_jhon
from erclutch.laws.hem import hem
from erclutch.laws.herschel_bulkley import herschel_bulkley
from erclutch.laws.law import Dimension, Gain, Law, Shape
from erclutch.laws.practice import on_off, quadratic
from erclutch.laws.rbfm import rbfm
from erclutch.laws.seo_seo import seo_seo
from erclutch.laws.yield_stress import POWER, SQUARE, YIELD_FORMS, YieldForm

__all__ = ["LADDER", "Dimension", "Gain", "Law", "Shape", "YieldForm", "law_from_name", "law_names"]

_WITH_YIELD: dict[str, Callable[[YieldForm], Law]] = {
    "bingham": bingham,
    "herschel-bulkley": herschel_bulkley,
    "casson": casson,
    "seo-seo": seo_seo,
    "cho-choi-jhon": cho_choi_jhon,
    "hem": hem,
}
_WITHOUT_YIELD: dict[str, Callable[[], Law]] = {"on-off": on_off, "quadratic": quadratic}
_SHORT = {"ss": "seo-seo", "ccj": "cho-choi-jhon", "hb": "herschel-bulkley", "rbfm": "rbfm-5"}

#: What ``--models all`` means, from the simplest to the richest.
LADDER = (
    "on-off",
    "quadratic",
    "bingham",
    "bingham/critical",
    "casson",
    "herschel-bulkley",
    "seo-seo",
    "cho-choi-jhon",
    "hem",
    "rbfm-5",
    "rbfm-10",
)


def law_names() -> tuple[str, ...]:
    """Names of the laws; ``rbfm-N`` stands for any number of kernels."""
    return (*_WITHOUT_YIELD, *_WITH_YIELD, "rbfm-N")


def law_from_name(specification: str, device: str = "single") -> Law:
    """The law for a specification such as ``bingham`` or ``hem/square``.

    Args:
        specification: name, or name/form with a form out of square, power, critical.
        device: "coaxial" or "single": decides on the form where none is given.

    Raises:
        SettingError: unknown name or form, or a form for a law that has none.
    """
    name, _, form_name = specification.strip().lower().partition("/")
    name = _SHORT.get(name, name)
    if name in _WITHOUT_YIELD:
        if form_name:
            raise SettingError(f"{name} has no choice of yield stress, got {form_name!r}", remedy=f"Write {name}")
        return _WITHOUT_YIELD[name]()
    default = SQUARE if device == "coaxial" else POWER
    form = YIELD_FORMS.get(form_name) if form_name else default
    if form is None:
        raise SettingError(
            f"unknown yield stress {form_name!r} in {specification!r}",
            remedy=f"Write one of {', '.join(f'{name}/{known}' for known in YIELD_FORMS)}",
        )
    if name.startswith("rbfm-") and name[5:].isdigit():
        return rbfm(form, int(name[5:]))
    if name not in _WITH_YIELD:
        near = difflib.get_close_matches(name, law_names(), n=1)
        hint = f"Did you mean {near[0]}? " if near else ""
        raise SettingError(f"unknown model {name!r}", remedy=f"{hint}Known are {', '.join(law_names())}")
    return _WITH_YIELD[name](form)
