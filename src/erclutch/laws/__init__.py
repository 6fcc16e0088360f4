"""The laws by name.

A specification is a law's name and, after slashes, how its yield effort grows with the field and ``forward`` if it
keeps its sign: ``bingham``, ``bingham/critical``, ``rbfm-10/square/forward``. Without a form the device decides: square
for the coaxial pair (the paper's), power for a single one.
"""

from __future__ import annotations

import difflib
from collections.abc import Callable
from dataclasses import replace
from typing import Any

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
from erclutch.laws.smooth import FORWARD
from erclutch.laws.yield_stress import YIELD_FORMS, YieldForm

__all__ = ["LADDER", "PAPER", "Dimension", "Gain", "Law", "Shape", "YieldForm", "law_from_name", "law_names"]

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

#: What ``--models paper`` means: the laws of tables II and III, with the signs that the paper takes as constant.
PAPER = ("bingham/forward", "seo-seo/forward", "hem/forward", "rbfm-5/forward", "rbfm-10/forward")


def law_names() -> tuple[str, ...]:
    """Names of the laws; ``rbfm-N`` stands for any number of kernels."""
    return (*_WITHOUT_YIELD, *_WITH_YIELD, "rbfm-N")


def law_from_name(specification: str, device: str = "single") -> Law:
    """The law for a specification such as ``bingham`` or ``hem/square/forward``.

    Args:
        specification: a name; after slashes a form out of square, power, critical, and ``forward``.
        device: "coaxial" or "single": decides on the form where none is given.

    Raises:
        SettingError: unknown name or form, or a form for a law that has none.
    """
    name, *options = specification.strip().lower().split("/")
    forward = "forward" in options
    law = _law(_SHORT.get(name, name), [o for o in options if o != "forward"], device)
    return _forward(law) if forward else law


def _law(name: str, forms: list[str], device: str) -> Law:
    if name in _WITHOUT_YIELD:
        if forms:
            raise SettingError(f"{name} has no choice of yield stress, got {forms[0]!r}", remedy=f"Write {name}")
        return _WITHOUT_YIELD[name]()
    wanted = forms or ["square" if device == "coaxial" else "power"]
    form = YIELD_FORMS.get(wanted[0])
    if form is None or len(wanted) > 1:
        raise SettingError(
            f"unknown yield stress {'/'.join(wanted)!r} in {name}/{'/'.join(wanted)!r}",
            remedy=f"Write one of {', '.join(f'{name}/{known}' for known in YIELD_FORMS)}, each also with /forward",
        )
    if name.startswith("rbfm-") and name[5:].isdigit():
        return rbfm(form, int(name[5:]))
    if name not in _WITH_YIELD:
        near = difflib.get_close_matches(name, law_names(), n=1)
        hint = f"Did you mean {near[0]}? " if near else ""
        raise SettingError(f"unknown model {name!r}", remedy=f"{hint}Known are {', '.join(law_names())}")
    return _WITH_YIELD[name](form)


def _forward(law: Law) -> Law:
    """The law with a yield effort that keeps its sign, as the paper writes (10): no transition slip is left."""

    def columns(E: Any, w: Any, *shape: Any) -> tuple[Any, ...]:
        return law.columns(E, w, FORWARD, *shape)

    return replace(law, title=f"{law.title}, one direction", columns=columns, shape=law.shape[1:], forward=True)
