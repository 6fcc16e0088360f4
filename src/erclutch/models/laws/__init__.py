"""Laws have names: each is a file in this folder or comes from another package (entry point ``erclutch.laws``).

A specification is a law's name and, after slashes, how its yield effort grows with the field and ``forward`` if it
keeps its sign: ``bingham``, ``bingham/critical``, ``rbfm-10/square/forward``. Without a form the device decides: square
for the coaxial pair (the paper's), power for a single one. With ``constant`` the field has no say in the yield effort.
"""

from __future__ import annotations

from contextlib import suppress
from dataclasses import replace
from typing import Any

import numpy as np

from erclutch import registry
from erclutch.errors import PluginError, SettingError
from erclutch.models.laws.law import Dimension, Gain, Law, LawFamily, ShapeParameter, YieldForm
from erclutch.models.laws.outside_law import checked, typical
from erclutch.models.laws.smooth import FORWARD
from erclutch.models.laws.yield_stress import CONSTANT, YIELD_FORMS
from erclutch.registry import Plugin

__all__ = [
    "PAPER",
    "Dimension",
    "Gain",
    "Law",
    "LawFamily",
    "ShapeParameter",
    "YieldForm",
    "at_one_field",
    "families",
    "ladder",
    "law_from_name",
    "law_names",
    "shown_laws",
    "shown_of",
]

GROUP = "erclutch.laws"

_SLIPS = np.array([-1.0, 0.5, 2.0])  # where a law is asked whether the field has a say

#: What ``--models paper`` means: the laws of tables II and III, with the signs that the paper takes as constant.
PAPER = ("bingham/forward", "seo-seo/forward", "hem/forward", "rbfm-5/forward", "rbfm-10/forward")


def families() -> dict[str, LawFamily]:
    """All laws by name, ours and those of other packages, from the simplest to the richest.

    Raises:
        PluginError: a law of another package cannot be loaded.
    """
    found: dict[str, LawFamily] = {plugin.name: plugin.of_type(LawFamily) for plugin in registry.plugins(GROUP)}
    last = max(place for family in found.values() for place in family.ladder.values()) + 1
    return dict(sorted(found.items(), key=lambda item: (min(item[1].ladder.values(), default=last), item[0])))


def ladder() -> tuple[str, ...]:
    """What ``--models all`` means, from the simplest to the richest: our own laws.

    A law of another package is fitted where it is named: an installed package changes no figure, and breaks no fit.
    """
    own = [plugin.of_type(LawFamily) for plugin in registry.plugins(GROUP) if plugin.own]
    places = sorted((place, name) for family in own for name, place in family.ladder.items())
    return tuple(name for _, name in places)


def shown_of(name: str, family: LawFamily) -> tuple[str, ...]:
    """Its specifications in a table of laws: those on the ladder, or its name; N = 2 of a family such as rbfm-N."""
    return tuple(family.ladder or (name,)) if family.count is None else (f"{name}-2",)


def shown_laws() -> tuple[str, ...]:
    """A specification for each row of a table of laws."""
    return tuple(shown for name, family in families().items() for shown in shown_of(name, family))


def at_one_field(specification: str, device: str = "single") -> str | None:
    """The law without the terms that a field decides, for a log with one field; None where it has nothing else to say.

    Args:
        specification: of the law; a form of the yield effort that it names gives way to ``constant``.
        device: "coaxial" or "single".

    Raises:
        SettingError: see `law_from_name`.
    """
    if law_from_name(specification, device).yield_form is None:
        return None
    name, *options = specification.strip().lower().split("/")
    steady = "/".join([name, CONSTANT.name, *(["forward"] if "forward" in options else [])])
    law = law_from_name(steady, device)
    numbers = [typical(shape) for shape in law.shape]
    weak, strong = (law.columns(np.full(_SLIPS.size, field), _SLIPS, *numbers) for field in (0.25, 1.0))
    return steady if all(np.allclose(*pair) for pair in zip(weak, strong, strict=True)) else None


def law_names() -> tuple[str, ...]:
    """Names of the laws; ``rbfm-N`` stands for any number of kernels."""
    return tuple(name if family.count is None else f"{name}-N" for name, family in families().items())


def law_from_name(specification: str, device: str = "single") -> Law:
    """The law for a specification such as ``bingham`` or ``hem/square/forward``.

    Args:
        specification: a name; after slashes a form out of square, power, critical, saturating, tanh, and ``forward``.
        device: "coaxial" or "single": decides on the form where none is given.

    Raises:
        SettingError: unknown name or form, or a form for a law that has none (PluginError: a law of another package
            fails).
    """
    name, *options = specification.strip().lower().split("/")
    forms = [option for option in options if option != "forward"]
    plugin, number = _plugin(name)
    family: LawFamily = plugin.of_type(LawFamily)
    form = None
    if isinstance(family.law, Law):
        if forms:
            raise SettingError(f"{name} has no choice of yield stress, got {forms[0]!r}", remedy=f"Write {name}")
        law = family.law
    else:
        form = _yield_form(name, forms, device)
        with plugin.working():
            law = family.law(form, *(() if number is None else (number,)))
    law = law if plugin.own else checked(law, plugin)
    law = law if form is None else replace(law, yield_form=form)
    return _forward(law) if "forward" in options else law


def _plugin(name: str) -> tuple[Plugin, int | None]:
    """The law of a name, of a name and a number, or of an alias; and the number."""
    known = registry.names(GROUP)
    stem, _, digits = name.rpartition("-")
    if name not in known and stem in known and digits.isdecimal() and len(digits) < 10:
        family = registry.find(GROUP, stem)
        if family.of_type(LawFamily).count is not None:
            return family, int(digits)
    wanted = name if name in known else _aliases().get(name)
    if wanted is None:
        raise registry.unknown(GROUP, name, (*law_names(), "fnn-N", "rbfn-N"))
    plugin = registry.find(GROUP, wanted)
    return plugin, plugin.of_type(LawFamily).count


def _aliases() -> dict[str, str]:
    found: dict[str, str] = {}
    for plugin in registry.plugins(GROUP):
        with suppress(PluginError):  # one that is broken has no aliases
            found.update({alias: plugin.name for alias in plugin.of_type(LawFamily).aliases if alias not in found})
    return found


def _yield_form(name: str, forms: list[str], device: str) -> YieldForm:
    wanted = forms or ["square" if device == "coaxial" else "power"]
    form = YIELD_FORMS.get(wanted[0])
    if form is None or len(wanted) > 1:
        raise SettingError(
            f"unknown yield stress {'/'.join(wanted)!r} in {name}/{'/'.join(wanted)!r}",
            remedy=f"Write one of {', '.join(f'{name}/{known}' for known in YIELD_FORMS)}, each also with /forward",
        )
    return form


def _forward(law: Law) -> Law:
    """The law with a yield effort that keeps its sign, as the paper writes (10): no transition slip is left."""

    def columns(E: Any, w: Any, *shape: Any) -> tuple[Any, ...]:
        return law.columns(E, w, FORWARD, *shape)

    return replace(law, title=f"{law.title}, one direction", columns=columns, shape=law.shape[1:], forward=True)
