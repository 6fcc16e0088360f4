"""Titles of models in plain words, and ids in a ranking: what people read and type in place of a specification."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from erclutch.errors import ErclutchError
from erclutch.models.laws import FORWARD_OPTION, law_from_name
from erclutch.models.networks import is_network
from erclutch.models.stages import needs_time, stage_named

#: What a stage brings, by the place where it works.
_KINDS = {
    "command": "lags",
    "effort": "lags",
    "slip": "memory",
    "temperature": "temperature",
    "position": "ripple",
}
#: Stages on the slip that are no memory of it, though they have a state.
_NO_MEMORY = {"stiffness": "a spring"}
#: Stages on the slip without a state: where a memory stands beside them, its word says enough.
_SHAPES = {
    "sides": "two sides",
    "knees": "knees",
    "stribeck": "a Stribeck hump",
    "stribeck-1": "a Stribeck hump",
    "viscous": "a power of the slip",
}


def id_of(place: int) -> str:
    """A model's id in its run: ``m1`` for place 0, the first of the ranking."""
    return f"m{place + 1}"


def titles_of(names: Sequence[str]) -> dict[str, str]:
    """A title for each model of a ranking, by its name; no two are the same.

    A title says what is beside the law. Only where two models share their title, it also names the stages or the
    network in which they differ.

    Args:
        names: specifications, such as ``casson+fnn-16+lag+dahl``, with a label behind ``@`` where there is one.
    """
    parts = {name: _parts_of(name) for name in names}
    titles = {name: _written(each, ()) for name, each in parts.items()}
    for forms in (False, True):  # lugre first; lugre/field where that does not tell apart
        for shared in _shared(titles):
            alike = [parts[name] for name in shared]
            differing: list[str] = []  # kinds of parts that are not the same in all
            for kind in alike[0].kinds:
                of_kind = {each.kinds[kind] for each in alike}
                if len(of_kind) > 1:
                    differing.append(kind)
            for name in shared:
                titles[name] = _written(parts[name], differing, forms=forms)
    for shared in _shared(titles):  # the order of stages, or two words for one law
        for name in shared:
            titles[name] = f"{titles[name]} ({name})"
    return titles


def title_of(name: str) -> str:
    """The title of a model that stands alone."""
    return titles_of([name])[name]


@dataclass(frozen=True)
class _Parts:
    """What a title is made of.

    Attributes:
        head: the law, or the network that stands alone.
        kinds: names of the parts of each kind that is beside the head, in the order of a title.
        label: what is behind ``@``.
    """

    head: str
    kinds: dict[str, tuple[str, ...]]
    label: str


def _shared(titles: dict[str, str]) -> list[list[str]]:
    """Names of models that share a title, a list for each such title."""
    by_title: dict[str, list[str]] = {}
    for name, title in titles.items():
        by_title.setdefault(title, []).append(name)
    return [names for names in by_title.values() if len(names) > 1]


def _parts_of(name: str) -> _Parts:
    """What the title of a model is made of, from its specification."""
    specification, _, label = name.partition("@")
    first, *further = specification.split("+")
    by_kind: dict[str, list[str]] = {}
    for part in further:
        if is_network(part):
            kind = "a network"
        else:
            try:
                stage = stage_named(part)
                kind = _NO_MEMORY.get(stage.name, _KINDS[stage.place])
            except ErclutchError:  # its package is not here
                kind = part
        by_kind.setdefault(kind, []).append(part)
    on_slip = by_kind.get("memory", [])
    if on_slip and not any(needs_time(stage_named(part)) for part in on_slip):
        del by_kind["memory"]
        for part in on_slip:
            by_kind.setdefault(_SHAPES.get(part, part), []).append(part)
    order = ("a network", "lags", "memory", "a spring", "temperature", "ripple", *by_kind)
    kinds = {kind: tuple(by_kind[kind]) for kind in dict.fromkeys(order) if kind in by_kind}
    if not is_network(first):
        # For example "Casson law" or "Bingham law (critical yield)".
        law, *options = first.split("/")
        try:
            title = law_from_name(law).title
        except ErclutchError:  # its package is not here
            title = law.capitalize()
        stem, bracket, behind = title.partition(" (")
        stem, field, variable = stem.partition(" in ")
        # An abbreviation of the law's name tells nothing apart; a number of kernels does.
        more = f"{bracket}{behind}" if any(sign.isdigit() for sign in behind) else ""
        for option in options:
            more += " (one direction)" if option == FORWARD_OPTION else f" ({option} yield)"
        return _Parts(f"{stem} law{field}{variable}{more}", kinds, label)

    # For example "Network of 10 and 6 neurons".
    sizes, _, form = first.partition("/")
    network, *layers = sizes.split("-")
    what = "Network" if network == "fnn" else "Radial network"
    neurons = "neuron" if layers == ["1"] else "neurons"
    how = f", {form}" if form else ""
    return _Parts(f"{what} of {' and '.join(layers)} {neurons}{how}", kinds, label)


def _written(parts: _Parts, in_full: Sequence[str], *, forms: bool = False) -> str:
    """The title; the parts of some kinds by their names, with or without their forms."""
    words: list[str] = []
    for kind, names in parts.kinds.items():
        word = "a lag" if names in (("lag",), ("effort-lag",)) else kind
        stems = [name if forms else name.partition("/")[0] for name in names]
        words.append(f"{word} ({', '.join(stems)})" if kind in in_full else word)
    title = parts.head
    if words:
        *others, last = words
        listed = f"{', '.join(others)} and {last}" if others else last
        title += f" with {listed}"
    if parts.label:
        title += f", {parts.label.replace('@', ', ')}"
    return title
