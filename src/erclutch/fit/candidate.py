"""A candidate is a model that a comparison may fit; a kind of model says which candidates some rows and settings give.

A kind is a file of `fit/kinds`, or comes from another package (entry point ``erclutch.kinds``). The comparison knows
nothing of any kind: it asks each one for its candidates, fits them, and asks what the fits call for next.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, Protocol, cast

import numpy as np

from erclutch import registry
from erclutch.errors import PluginError, SettingError
from erclutch.fit.checks.data_check import steady_command
from erclutch.fit.checks.finding import Finding
from erclutch.fit.checks.no_time import refuse_memory
from erclutch.fit.fit_settings import AUTO, Settings
from erclutch.fit.solver.outcome import AnyOutcome
from erclutch.logs.dataset import Dataset
from erclutch.models.laws import law_from_name
from erclutch.models.model import Model
from erclutch.models.stages import NONE, canonical
from erclutch.signals.array import Mask

GROUP = registry.KINDS
#: Names of `Settings.models` that stand for several.
SETS = ("all", "paper")


class Candidate(Protocol):
    """A model that may be fitted: its structure, without numbers."""

    @property
    def name(self) -> str:
        """Identifier of the model that will come out."""
        ...

    @property
    def plugins(self) -> tuple[registry.Plugin, ...]:
        """What the model needs of other packages: laws and stages."""
        return ()

    def fit(self, train: Dataset, fitted: Sequence[Fitted], workers: int) -> AnyOutcome:
        """Fit it to the training rows.

        Args:
            train: the rows.
            fitted: what was fitted to the same rows before, by kinds of a lower place.
            workers: starts side by side; changes no figure.

        Raises:
            CheckError: these rows cannot make this model; the comparison goes on without it.
        """
        ...

    def refit(
        self,
        train: Dataset,
        kept: Mask,
        outcome: AnyOutcome,
        fitted: Sequence[Fitted],
    ) -> AnyOutcome:
        """Fit the same model to some of the training rows, from its numbers on: what was chosen stays chosen.

        Args:
            train: all training rows: states run through them, for field and slip are known where the effort is not.
            kept: the rows to fit, shape (n,).
            outcome: of `fit`.
            fitted: what was fitted to the same rows before.
        """
        ...

    def refits_in_doubt(
        self, train: Dataset, kept: Mask, outcome: AnyOutcome
    ) -> Sequence[AnyOutcome]:
        """Fits to the same rows as `refit` that differ in what these rows cannot tell; none where they tell all.

        Args:
            train: all training rows.
            kept: the rows to fit, shape (n,).
            outcome: of `fit`.
        """
        return ()

    def fit_again(self, data: Dataset, outcome: AnyOutcome) -> AnyOutcome:
        """Fit the same model to all rows, for use and not for judging.

        Args:
            data: training rows and rows held out.
            outcome: of `fit`, from whose numbers on.
        """
        every = np.ones(data.rows, np.bool_)
        return self.refit(data, every, outcome, ())


@dataclass(frozen=True)
class Fitted:
    """A candidate and what came out of its fit."""

    candidate: Candidate
    outcome: AnyOutcome


@dataclass(frozen=True)
class Grown:
    """What the fits of a kind call for: further candidates, and what was seen on the way."""

    candidates: Sequence[Candidate] = ()
    findings: tuple[Finding, ...] = ()


class Kind(ABC):
    """A kind of model.

    Attributes:
        place: kinds are fitted in this order, so that one may build on the fits of those before.
        side_by_side: whether its candidates are fitted side by side; else one after another, each with all workers.
        work: time that its candidates take, and what their fits call for, beside that of other kinds. It only moves the
            bar that shows how much is done.
        words: how many words, joined by ``+``, name a model ahead of its stages.
        readers: how models of another package are read from their files, by what a file says that its ``kind`` is.
    """

    place: int
    side_by_side: bool = True
    work: tuple[float, float] = (1.0, 1.0)
    words: int = 1
    readers: Mapping[str, Callable[[Mapping[str, Any], str], Model]] = MappingProxyType({})

    @abstractmethod
    def means(self, model: str) -> bool:
        """Whether a specification, its stages included, names a model of this kind."""

    def members(self, of: str) -> tuple[str, ...]:
        """Specifications of ours that stand in one of `SETS`; those of another package are asked for by name."""
        return ()

    @abstractmethod
    def candidates(self, settings: Settings, train: Dataset) -> Sequence[Candidate]:
        """What is asked for.

        Raises:
            SettingError: a model that cannot be.
        """

    def grown(self, settings: Settings, train: Dataset, fitted: Sequence[Fitted]) -> Grown:
        """What the fits so far, of this kind and of those before, call for besides."""
        return Grown()


class OutsideKind(Kind):
    """A kind of another package: what it raises names the package, and so does an answer that is none."""

    def __init__(self, kind: Kind, plugin: registry.Plugin) -> None:
        """Look at what the kind says of itself.

        Raises:
            PluginError: an attribute is of a wrong type.
        """
        self.kind, self._plugin = kind, plugin
        with plugin.working("does not say what it is"):
            self.place, self.words = int(kind.place), int(kind.words)
            self.side_by_side = bool(kind.side_by_side)
            first, further = kind.work
            self.work = (float(first), float(further))
            self.readers = dict(kind.readers)

    def means(self, model: str) -> bool:
        """See `Kind.means`."""
        return bool(self._plugin.guarded(self.kind.means)(model))

    def candidates(self, settings: Settings, train: Dataset) -> Sequence[Candidate]:
        """See `Kind.candidates`."""
        return self._candidates(self._plugin.guarded(self.kind.candidates)(settings, train))

    def grown(self, settings: Settings, train: Dataset, fitted: Sequence[Fitted]) -> Grown:
        """See `Kind.grown`."""
        grown = self._plugin.guarded(self.kind.grown)(settings, train, fitted)
        if not isinstance(grown, Grown):
            raise self._plugin.fault(f"returns a {type(grown).__name__}, it must be a Grown")
        return Grown(self._candidates(grown.candidates), grown.findings)

    def _candidates(self, given: Any) -> Sequence[Candidate]:
        if not isinstance(given, list | tuple):
            raise self._plugin.fault(
                f"returns a {type(given).__name__}, it must be a list of candidates"
            )
        for each in cast("Sequence[Any]", given):
            works = callable(getattr(each, "fit", None)) and callable(getattr(each, "refit", None))
            if not works or not isinstance(getattr(each, "name", None), str):
                raise self._plugin.fault(
                    f"gives {each!r:.40} as a candidate; a candidate has a name, fit and refit"
                )
        return cast("Sequence[Candidate]", given)


def kinds() -> list[tuple[registry.Plugin, Kind]]:
    """All kinds in the order of their places, each with the plug-in that brings it; without those that fail."""
    return sorted(_kinds_and_failures()[0], key=lambda pair: pair[1].place)


def _kinds_and_failures() -> tuple[list[tuple[registry.Plugin, Kind]], list[PluginError]]:
    """All kinds that load, and what is wrong with each of the others."""
    loaded, failures = registry.sound(GROUP, Kind)
    usable: list[tuple[registry.Plugin, Kind]] = []
    for plugin, kind in loaded:
        try:
            usable.append((plugin, kind if plugin.own else OutsideKind(kind, plugin)))
        except PluginError as error:
            failures.append(error)
    return usable, failures


def kind_of(model: str) -> Kind:
    """The kind that a name means: one of ours before those of other packages; our first for what no other knows.

    Raises:
        PluginError: nobody knows the name, and a kind of another package, which might, fails.
    """
    loaded, failures = _kinds_and_failures()
    ours = sorted((kind for plugin, kind in loaded if plugin.own), key=lambda kind: kind.place)
    laws, *further = ours
    others = [kind for plugin, kind in loaded if not plugin.own]
    try:
        law_from_name(model.split("+")[0])
    except SettingError:
        is_law = False
    else:
        is_law = True
        others = [kind for kind in others if kind.words > 1]  # no package takes the name of a law
    for kind in (*further, *others):
        if kind.means(model):
            return kind
    if failures and not is_law:
        problem = f"nobody knows the model {model!r:.60}, and {failures[0].problem}"
        raise PluginError(problem, remedy=failures[0].remedy)
    return laws


def asked(settings: Settings, train: Dataset, kind: Kind) -> list[tuple[str, str]]:
    """The models of a kind that are asked for, each with its stages: its own, or those of the settings.

    Memoryless ones come first.
    """
    own: list[tuple[str, str]] = []  # models that name their stages
    without: list[str] = []
    for model in names(settings):
        meant = kind_of(model)
        if kind is not (meant.kind if isinstance(meant, OutsideKind) else meant):
            continue
        words = model.replace(" ", "").split("+")
        specification = "+".join(words[: kind.words])
        stages = "+".join(words[kind.words :])
        if stages:
            own.append((specification, stages))
        else:
            without.append(specification)

    # A model that names none is fitted with the stages of the settings, or as far as a lag can be told.
    forms = (settings.lag,)
    if settings.lag == AUTO:
        forms = (NONE,) if steady_command(train) or train.in_no_time else (NONE, "lag")
    named_stages = [stages for _, stages in own]
    refuse_memory(train, [*forms, *named_stages], past=bool(settings.past))
    pairs = [(specification, form) for form in forms for specification in without]
    return [(specification, canonical(form)) for specification, form in (*pairs, *own)]


def names(settings: Settings) -> list[str]:
    """All models that are asked for, sets of them spelled out."""
    # Installing a package changes no figure: a set has our own models, and another package's are asked for by name.
    ours = [kind for plugin, kind in kinds() if plugin.own]
    every: list[str] = []
    for name in settings.models:
        if name not in SETS:
            every.append(name)
            continue
        for kind in ours:
            every += kind.members(name)
    return every
