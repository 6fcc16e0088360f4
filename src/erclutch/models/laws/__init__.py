"""Laws have names: each is a file in this folder or comes from another package (entry point ``erclutch.laws``).

A specification is a law's name and, after slashes, how its yield effort follows the field and ``forward`` if it
keeps its sign: ``bingham``, ``bingham/critical``, ``rbfm-10/square/forward``. Without a form the device decides: square
for the coaxial pair (the paper's), power for a single one. With ``constant`` the field has no say in the yield effort.
"""

from __future__ import annotations

import math
from contextlib import suppress
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from erclutch import registry
from erclutch.errors import PluginError, SettingError
from erclutch.models.laws.law import Dimension, Gain, Law, LawFamily, ShapeParameter, YieldForm
from erclutch.models.laws.outside_law import checked, require_family, typical
from erclutch.models.laws.smooth import FORWARD
from erclutch.models.laws.yield_stress import CONSTANT, YIELD_FORMS
from erclutch.registry import Plugin

__all__ = [
    "FORWARD_OPTION",
    "PAPER",
    "Dimension",
    "Gain",
    "Law",
    "LawFamily",
    "ShapeParameter",
    "Specification",
    "YieldForm",
    "at_one_field",
    "families",
    "ladder",
    "law_from_name",
    "law_names",
    "quick_laws",
    "shown_laws",
    "shown_of",
    "without_yield",
]

GROUP = "erclutch.laws"

_SLIPS = np.array([-1.0, 0.5, 2.0])  # where a law is asked whether the field has a say

#: What ``--models paper`` means: the laws of tables II and III, with the signs that the paper takes as constant.
PAPER = ("bingham/forward", "seo-seo/forward", "hem/forward", "rbfm-5/forward", "rbfm-10/forward")


#: Ends the specification of a law whose yield effort keeps its sign.
FORWARD_OPTION = "forward"


class Specification(NamedTuple):
    """What a law's specification says, in small letters.

    Attributes:
        name: of the law, for example ``hem`` or ``rbfm-10``.
        forms: of its yield effort over the field; one at most where the specification is a right one.
        forward: whether the yield effort keeps its sign.
    """

    name: str
    forms: tuple[str, ...] = ()
    forward: bool = False

    @classmethod
    def of(cls, text: str) -> Specification:
        """From a text such as ``hem/square/forward``."""
        name, *options = text.strip().lower().split("/")
        forms = [option for option in options if option and option != FORWARD_OPTION]
        return cls(name, tuple(dict.fromkeys(forms)), FORWARD_OPTION in options)

    def __str__(self) -> str:
        ending = (FORWARD_OPTION,) if self.forward else ()
        return "/".join([self.name, *self.forms, *ending])


def families(failed: list[PluginError] | None = None) -> dict[str, LawFamily]:
    """All laws by name, ours and those of other packages that load, from the simplest to the richest.

    Args:
        failed: gets what is wrong with each law that does not load.
    """
    by_name: dict[str, LawFamily] = {}
    for plugin in registry.plugins(GROUP):
        try:
            by_name[plugin.name] = family_of(plugin)
        except PluginError as error:
            if failed is not None:
                failed.append(error)

    def place(name: str) -> tuple[float, str]:
        """A law that is not on the ladder stands behind those that are."""
        return min(by_name[name].ladder.values(), default=math.inf), name

    return {name: by_name[name] for name in sorted(by_name, key=place)}


def ladder() -> tuple[str, ...]:
    """What ``--models all`` means, from the simplest to the richest: our own laws.

    A law of another package is fitted where it is named: an installed package changes no figure, and breaks no fit.
    """
    places: list[tuple[int, str]] = []
    for _, family in _own_families():
        places += [(place, specification) for specification, place in family.ladder.items()]
    return tuple(specification for _, specification in sorted(places))


def quick_laws() -> tuple[str, ...]:
    """Our own laws whose numbers are known from few rows, from the simplest to the richest."""
    places: list[tuple[int, str]] = []
    for name, family in _own_families():
        if family.quick:
            places.append((min(family.ladder.values()), name))
    return tuple(name for _, name in sorted(places))


def without_yield(specification: str) -> bool:
    """Whether a law's effort of the field vanishes at rest; of one of our laws, by its specification."""
    name = Specification.of(specification).name
    return any(family.without_yield for own, family in _own_families() if own == name)


def _own_families() -> list[tuple[str, LawFamily]]:
    own = [plugin for plugin in registry.plugins(GROUP) if plugin.own]
    return [(plugin.name, plugin.of_type(LawFamily)) for plugin in own]


def family_of(plugin: Plugin) -> LawFamily:
    """The law of a plug-in; that of another package is looked at.

    Raises:
        PluginError: it cannot be loaded, or a part is of a wrong type.
    """
    family: LawFamily = plugin.of_type(LawFamily)
    if not plugin.own:
        require_family(family, plugin)
    return family


def shown_of(name: str, family: LawFamily) -> tuple[str, ...]:
    """Its specifications in a table of laws: those on the ladder, or its name; N = 2 of a family such as rbfm-N."""
    if family.count is not None:
        return (f"{name}-2",)
    return tuple(family.ladder or (name,))


def shown_laws(failed: list[PluginError] | None = None) -> tuple[str, ...]:
    """A specification for each row of a table of laws, without laws of other packages that fail.

    Args:
        failed: gets what is wrong with each of these.
    """
    shown: list[str] = []
    for name, family in families(failed).items():
        specifications = shown_of(name, family)
        plugin = registry.find(GROUP, name)
        if not plugin.own:  # a law may load and be none that can be used
            try:
                for specification in specifications:
                    law_from_name(specification)
            except SettingError as error:
                if failed is not None:
                    told = isinstance(error, PluginError)
                    failed.append(
                        error if told else plugin.fault(f"has a ladder with {error.problem}")
                    )
                continue
        shown += specifications
    return tuple(shown)


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
    steady = str(Specification.of(specification)._replace(forms=(CONSTANT.name,)))
    law = law_from_name(steady, device)
    numbers = [typical(shape) for shape in law.shape]
    at_weak_field = law.columns(np.full(_SLIPS.size, 0.25), _SLIPS, *numbers)
    at_strong_field = law.columns(np.full(_SLIPS.size, 1.0), _SLIPS, *numbers)
    for weak, strong in zip(at_weak_field, at_strong_field, strict=True):
        if not np.allclose(weak, strong):
            return None
    return steady


def law_names() -> tuple[str, ...]:
    """Names of the laws; ``rbfm-N`` stands for any number of kernels."""
    names: list[str] = []
    for name, family in families().items():
        names.append(name if family.count is None else f"{name}-N")
    return tuple(names)


def law_from_name(specification: str, device: str = "single") -> Law:
    """The law for a specification such as ``bingham`` or ``hem/square/forward``.

    Args:
        specification: a name; after slashes a form out of square, power, critical, saturating, tanh, and ``forward``.
        device: "coaxial" or "single": decides on the form where none is given.

    Raises:
        SettingError: unknown name or form, or a form for a law that has none (PluginError: a law of another package
            fails).
    """
    name, forms, forward = Specification.of(specification)
    plugin, number = _plugin(name)
    family = family_of(plugin)
    form = None
    if isinstance(family.law, Law):
        if forms:
            raise SettingError(
                f"{name} has no choice of yield stress, got {forms[0]!r}", remedy=f"Write {name}"
            )
        law = family.law
    else:
        usual = "square" if device == "coaxial" else "power"
        wanted = "/".join(forms) or usual
        if wanted not in YIELD_FORMS:
            known = ", ".join(f"{name}/{each}" for each in YIELD_FORMS)
            problem = f"unknown yield stress {wanted!r} in {name}/{wanted!r}"
            raise SettingError(problem, remedy=f"Write one of {known}, each also with /forward")
        form = YIELD_FORMS[wanted]
        numbers = [] if number is None else [number]
        with plugin.working():
            law = family.law(form, *numbers)
    if not plugin.own:
        with plugin.working("is no law that can be used"):
            law = checked(law, plugin)
    if form is not None:
        law = replace(law, yield_form=form)
    if not forward:
        return law

    # The yield effort keeps its sign, as the paper writes (10): no transition slip is left.
    def columns(E: Any, w: Any, *shape: Any) -> tuple[Any, ...]:
        return law.columns(E, w, FORWARD, *shape)

    title = f"{law.title}, one direction"
    return replace(law, title=title, columns=columns, shape=law.shape[1:], forward=True)


def _plugin(name: str) -> tuple[Plugin, int | None]:
    """The law of a name, of a name and a number, or of an alias; and the number.

    Raises:
        SettingError: no law has the name.
    """
    known = registry.names(GROUP)
    stem, _, digits = name.rpartition("-")
    if name not in known and stem in known and digits.isdecimal() and len(digits) < 10:
        plugin = registry.find(GROUP, stem)
        if family_of(plugin).count is not None:
            return plugin, int(digits)
    if name in known:
        plugin = registry.find(GROUP, name)
        return plugin, family_of(plugin).count
    for plugin in registry.plugins(GROUP):
        with suppress(PluginError):  # a law that is broken has no aliases
            family = family_of(plugin)
            if name in family.aliases:
                return plugin, family.count
    raise registry.unknown(GROUP, name, (*law_names(), "fnn-N", "rbfn-N"))
