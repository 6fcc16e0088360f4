"""Laws as candidates: those asked for, and a second time constant and memory as far as the rows call for them."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np

from erclutch.fit.candidate import Candidate, Fitted, Grown, Kind, asked
from erclutch.fit.checks.data_check import steady_command
from erclutch.fit.checks.field_drag import field_drags
from erclutch.fit.checks.finding import Finding
from erclutch.fit.checks.noisy_acceleration import noisy_acceleration
from erclutch.fit.checks.one_field import refuse_field_terms
from erclutch.fit.checks.releasing_field import field_releases
from erclutch.fit.checks.spare_columns import spare_columns
from erclutch.fit.choice.base_law import (
    MOST_FORMS,
    drag_once_bent,
    grown_from_the_plainest,
    plain_for_a_hump,
    plainest_of_the_best,
    plainest_with_form,
)
from erclutch.fit.choice.ladder import (
    grown,
    helpful,
    of_iron,
    of_law,
)
from erclutch.fit.choice.parts_left_out import parts_of_training
from erclutch.fit.choice.rungs import Rung
from erclutch.fit.choice.scoring import TOLERATED, independent_rows, information_criteria
from erclutch.fit.fit_settings import AUTO, Settings
from erclutch.fit.laws.field_levels import more_numbers_than_fields
from erclutch.fit.laws.fit_law import fit_structure, refit_near
from erclutch.fit.laws.terms_told import with_terms_told
from erclutch.fit.log_groups import FEWEST_GROUPS, groups_of
from erclutch.fit.solver.one_thread import one_thread
from erclutch.fit.solver.outcome import AnyOutcome, FitOutcome
from erclutch.logs.dataset import Dataset
from erclutch.models.law_model import TorqueModel
from erclutch.models.laws import (
    PAPER,
    Specification,
    at_one_field,
    ladder,
    law_from_name,
    without_yield,
)
from erclutch.models.laws.yield_stress import (
    CONSTANT,
    FALLING,
    POWER,
    SATURATING,
    TANH,
)
from erclutch.models.model import full_name
from erclutch.models.stages.inertia import SMOOTH_INERTIA
from erclutch.models.structure import Structure
from erclutch.registry import Plugin
from erclutch.signals.array import Mask

#: A constant effort and friction, which a law may lose again.
_ADDED_TERMS = 2
#: Separate time constants are asked for by the data when they lower the criterion by this much: "very strong" evidence.
_EVIDENCE = 10.0


#: The ways over the field that few fields leave in doubt: these forms, and as steep as most fluids are.
_DOUBTFUL = (POWER, TANH, SATURATING)
_RISES = ((POWER, "n", 2.0), (TANH, "E_s", 0.5))


@dataclass(frozen=True)
class LawCandidate(Candidate):
    """A law with its stages.

    Attributes:
        structure: what is fitted.
        notes: what is said of the model from the start.
        outcome: its fit to the training rows, where a search has made it already.
        near: numbers that a search found for it on some of the rows, in the order of its shapes; its fit starts there.
    """

    structure: Structure
    notes: tuple[str, ...] = ()
    outcome: FitOutcome[TorqueModel] | None = None
    near: tuple[float, ...] = ()

    @property
    def name(self) -> str:
        """Identifier of the model."""
        return full_name(self.structure.specification, self.structure.dynamics)

    @property
    def plugins(self) -> tuple[Plugin, ...]:
        """The law and the stages of other packages."""
        return self.structure.plugins

    def fit(self, train: Dataset, fitted: Sequence[Fitted], workers: int) -> AnyOutcome:
        """The law without the terms that these rows cannot tell; see `Candidate.fit`."""
        outcome = self.outcome
        if outcome is None:
            if self.near:
                law = fit_structure(train, self.structure, starts=[self.near])
            else:
                law = fit_structure(train, self.structure)
            outcome = with_terms_told(train, law)
        return replace(outcome, notes=(*self.notes, *outcome.notes))

    def refit(
        self,
        train: Dataset,
        kept: Mask,
        outcome: AnyOutcome,
        fitted: Sequence[Fitted],
    ) -> AnyOutcome:
        """The exponent of a form that saturates stays where the fields left cannot tell it; see `Candidate.refit`."""
        form = self.structure.law.yield_form
        told_by_all = form is SATURATING or (form is POWER and self.structure.friction)
        few = told_by_all and more_numbers_than_fields(train.take(kept), self.structure)
        return refit_near(
            train, outcome.model, kept, held=("n",) if few else (), without=outcome.without
        )

    def refits_in_doubt(
        self, train: Dataset, kept: Mask, outcome: AnyOutcome
    ) -> Sequence[AnyOutcome]:
        """Two fields and a friction do not tell how the yield effort rises: as the field, or as its square?

        `refit` holds what all fields told, the one that is left out among them. See `Candidate.refits_in_doubt`.
        """
        model = outcome.model
        if not self.structure.friction or self.structure.law.yield_form not in _DOUBTFUL:
            return ()
        as_power = self.structure.with_yield_form(POWER)
        if not more_numbers_than_fields(train.take(kept), as_power):
            return ()
        doubtful: list[AnyOutcome] = []
        for form, name, number in _RISES:
            structure = self.structure.with_yield_form(form)
            numbers = {**model.shape, name: number}
            shapes = structure.shapes(model.reference.period)
            shape = {own.name: numbers[own.name] for own in shapes}
            start = replace(model, structure=structure, shape=shape)
            doubtful.append(refit_near(train, start, kept, held=(name,), without=outcome.without))
        return doubtful

    def fit_again(self, data: Dataset, outcome: AnyOutcome) -> AnyOutcome:
        """The law's numbers get intervals, which `refit` leaves out; see `Candidate.fit_again`."""
        law = outcome.model.law_part
        start = list(law.shape.values())
        return fit_structure(data, law.structure, starts=[start], without=outcome.without)


class Laws(Kind):
    """Laws of the effort, with stages on command, slip and effort."""

    place = 0
    work = (2.0, 3.0)  # the search for memory takes longest

    def means(self, model: str) -> bool:
        """Any name may be a law's: what it is not, the laws themselves say best."""
        return True

    def members(self, of: str) -> tuple[str, ...]:
        """The ladder, or the laws of the paper's tables."""
        return ladder() if of == "all" else PAPER

    def candidates(self, settings: Settings, train: Dataset) -> Sequence[LawCandidate]:
        """The laws that are asked for, in the order of the ladder, memoryless ones first."""
        return [LawCandidate(structure) for structure in structures_for(train, settings)]

    def grown(self, settings: Settings, train: Dataset, fitted: Sequence[Fitted]) -> Grown:
        """A second time constant and memory, where stages are left to the data and these ask for them."""
        laws = laws_among(fitted)
        if settings.lag != AUTO:
            return Grown()

        # The plainest of the best lagged laws with a second time constant, if the training rows ask for it.
        quicker: list[FitOutcome[TorqueModel]] = []
        lagged = [law for law in laws if law.model.structure.dynamics == "lag"]
        if lagged and not steady_command(train):
            one = plainest_of_the_best(lagged)
            two = replace(one.model.structure, dynamics="rise-fall")
            # Intervals take half the time of a fit, and few logs ask for the second time constant.
            with one_thread():
                if _called_for(train, one, fit_structure(train, two, intervals=False)):
                    quicker = [fit_structure(train, two)]
        named: set[str | None] = set()  # laws that were asked for by name
        releases = field_releases(train)
        for name, _ in asked(settings, train, KIND):
            if name in settings.models:
                named.add(_law_of(name, train, releases=releases))
        remembering, findings = with_memory(train, [*laws, *quicker], named)
        known = [LawCandidate(law.model.structure, outcome=law) for law in quicker]
        return Grown([*known, *remembering], findings)


KIND = Laws()


def laws_among(fitted: Sequence[Fitted]) -> list[FitOutcome[TorqueModel]]:
    """The fits of laws, in their order."""
    return [each.outcome for each in fitted if each.outcome.model.law_part is each.outcome.model]


def structures_for(data: Dataset, settings: Settings) -> list[Structure]:
    """The laws that are asked for, in the order of the ladder, memoryless ones first.

    A law of a drag is among all laws only where the rows look like a drag; by its name it is fitted to any rows.

    Raises:
        SettingError: an unknown model or lag.
    """
    pairs = asked(settings, data, KIND)
    drags = [name for name, _ in pairs if without_yield(name) and name not in settings.models]
    if drags and not field_drags(data):
        pairs = [(name, stages) for name, stages in pairs if name not in drags]
    return structures_of(data, settings, pairs)


def usual_terms(data: Dataset) -> tuple[bool, bool]:
    """Whether a law of these rows has friction at zero field, and a constant effort, where nobody says so.

    The paper's pair has neither. Friction is told from a constant effort only where the slip turns.
    """
    alone = data.device == "single"
    return alone and not data.one_way, alone


def structures_of(
    data: Dataset,
    settings: Settings,
    named: Sequence[tuple[str, str]],
) -> list[Structure]:
    """Laws by name, each with its stages; at one field without field terms, or not at all."""
    if data.one_field:
        # What was named is refused; of a set of laws only those go on that one field can tell.
        spelled_out = {model.partition("+")[0] for model in settings.models}
        given = [name for name, _ in named if name in spelled_out]
        refuse_field_terms(data, given, settings.lag, settings.friction)

    usual_friction, usual_offset = usual_terms(data)
    friction = usual_friction if settings.friction is None else settings.friction
    offset = usual_offset if settings.offset is None else settings.offset

    releases = field_releases(data)
    pairs = [(_law_of(name, data, releases=releases), stages) for name, stages in named]
    structures: list[Structure] = []
    for name, stages in dict.fromkeys(pairs):
        if name is None:
            continue
        law = law_from_name(name, data.device)
        # A yield effort that no field changes is friction already.
        own_friction = friction and law.yield_form is not CONSTANT
        structures.append(Structure(data.device, name, law, stages, own_friction, offset))
    return structures


def _law_of(name: str, data: Dataset, *, releases: bool) -> str | None:
    """The canonical specification of a law for these rows; None where it is nothing at one field.

    ``ss`` and ``seo-seo`` are one, and files carry one name. Where the field releases the device, a law without a form
    of its own takes the one that falls: all others grow with the field.
    """
    law = law_from_name(name, data.device)
    specification = Specification.of(name)._replace(name=law.name)
    takes_a_form = law.yield_form is not None and not specification.forms
    if takes_a_form and releases:
        specification = specification._replace(forms=(FALLING.name,))
    full = str(specification)
    return at_one_field(full, data.device) if data.one_field else full


def _called_for(
    train: Dataset,
    plain: FitOutcome[TorqueModel],
    richer: FitOutcome[TorqueModel],
    to_spare: int = 0,
) -> bool:
    """Whether the training rows give very strong evidence for a law with more numbers, or would with some to spare."""
    # Rows of one log are alike, so the criterion counts those that are independent, as many for both laws.
    errors = [train.effort - law.model.predict(train) for law in (plain, richer)]
    independent = min(independent_rows(error) for error in errors)

    def criterion(law: FitOutcome[TorqueModel], numbers: int) -> float:
        criteria = information_criteria(law.train_cost, law.train_rows, independent, numbers)
        return criteria["bic_independent"]

    return (
        criterion(richer, richer.parameters - to_spare)
        < criterion(plain, plain.parameters) - _EVIDENCE
    )


def with_memory(
    train: Dataset,
    laws: Sequence[FitOutcome[TorqueModel]],
    named: Collection[str | None] = (),
) -> tuple[list[LawCandidate], tuple[Finding, ...]]:
    """The best law with stages of memory, as far as blocked validation on the training rows asks for them.

    Laws that were asked for by name get the same memory: without it they would look as if they had lost. The findings
    name columns of the log that would take more of the error off, and a speed that is too noisy.

    Args:
        train: the training rows.
        laws: the fits to them.
        named: specifications of the laws that were asked for by name.
    """
    known: list[FitOutcome[TorqueModel]] = []
    for outcome in laws:
        law = outcome.model.structure.law
        if not law.forward and not law.stimulus:
            known.append(outcome)
    if not known:
        return [], ()

    # Where the rows do not tell a law's own numbers they do not with memory either, and it would not be recommended.
    known = [outcome for outcome in known if outcome.sound] or known

    # Behind the stages of the best.
    best = min(known, key=lambda law: law.train_cost)
    base = plainest_of_the_best(known)
    with one_thread():
        base = plain_for_a_hump(train, known, base)
        base = drag_once_bent(train, known, base)
    first_rung = replace(base.model.structure, dynamics=best.model.structure.dynamics)
    with one_thread():
        rungs = grown(train, first_rung, tuple(train.extras))
        if train.in_no_time:
            plain = plainest_with_form(known)
            of_plain = grown_from_the_plainest(train, plain, rungs)
            if of_plain:
                base, first_rung, rungs = plain, plain.model.structure, of_plain
        gains_of_columns = helpful(train, rungs[-1])

    findings: list[Finding] = []
    if SMOOTH_INERTIA in rungs[-1].structure.dynamics.split("+"):
        findings.append(noisy_acceleration(rungs[-1].numbers["tau_a"], train.period))
    findings += spare_columns(train, gains_of_columns)

    rungs = rungs if rungs[0].structure != first_rung else rungs[1:]
    if not rungs:
        return [], tuple(findings)
    # The first step up and the last: the smallest memory that helps, and all that helps. They may be the same.
    wanted = {rung.structure: rung for rung in (rungs[0], rungs[-1])}
    candidates = [_of_rung(rung, base.notes) for rung in wanted.values()]
    if len(set(groups_of(train).field)) >= FEWEST_GROUPS or of_iron(rungs[-1].structure):
        parts = parts_of_training(train)
        # Of laws that are as good the one in the middle at no field is taken, and of two none is.
        count = MOST_FORMS if parts is not None and parts.never_without_field else 1
        others = _of_another_form(train, rungs[-1], known, base, count)
        saturating = _that_saturate(train, rungs[-1], others)
        candidates = [*others, *saturating, *candidates]  # the last stays the richest
    made = {candidate.structure.specification for candidate in candidates}
    for law in known:
        own = law.model.structure.specification
        if own in named and own not in made:
            made.add(own)
            with one_thread():
                rung = of_law(train, rungs[-1], law.model.structure)
            # Behind iron its yield effort saturates, and that law may stand there already.
            if all(rung.structure != candidate.structure for candidate in candidates):
                candidates.insert(0, _of_rung(rung, law.notes))
    return candidates, tuple(findings)


def _of_another_form(
    train: Dataset,
    rung: Rung,
    laws: Sequence[FitOutcome[TorqueModel]],
    base: FitOutcome[TorqueModel],
    count: int,
) -> list[LawCandidate]:
    """The best of a few other laws, so many, with the memory of the last rung.

    At a field that no log has, its form counts.

    Without a memory these laws are nearly as good as the base. Whole fields that are left out choose between both.
    """
    nearly = (1.0 + TOLERATED) ** 2 * base.train_cost
    if of_iron(rung.structure):
        nearly = np.inf  # without its iron no law is near, whichever it is
    others: list[FitOutcome[TorqueModel]] = []
    for law in laws:
        structure = law.model.structure
        has_form = structure.law.yield_form is not None
        is_base = structure.specification == base.model.structure.specification
        if law.train_cost <= nearly and has_form and not is_base and not structure.remembers:
            others.append(law)
    if not others:
        return []
    others.sort(key=lambda law: (law.parameters, law.train_cost))
    few = others[:MOST_FORMS]
    with one_thread():
        rungs = [of_law(train, rung, law.model.structure) for law in few]
    best = sorted(range(len(few)), key=lambda place: rungs[place].error)[:count]
    return [_of_rung(rungs[place], few[place].notes) for place in best]


def _that_saturate(
    train: Dataset,
    rung: Rung,
    others: Sequence[LawCandidate],
) -> list[LawCandidate]:
    """The law of the last rung and the other law, with a yield effort that saturates in the field.

    A power that bends as a magnetic fluid does is steepest at zero field, and leaves no friction there. The exponent of
    a small field is a further number, which the training rows have to call for.
    """
    saturating: list[LawCandidate] = []
    known = [other.structure for other in others]
    for structure in (rung.structure, *known):
        if structure.law.yield_form is not POWER:
            continue
        with one_thread():
            near = of_law(train, rung, structure.with_yield_form(TANH))
            taken = with_terms_told(
                train, fit_structure(train, near.structure, starts=[(*near.numbers.values(),)])
            )
            near = of_law(train, rung, structure.with_yield_form(SATURATING))
            starts = [(*near.numbers.values(),)]
            # Intervals take half the time of a fit, and few logs ask for the exponent, even without the added terms.
            bare = fit_structure(train, near.structure, starts=starts, intervals=False)
            if _called_for(train, taken, bare, to_spare=_ADDED_TERMS):
                richer = with_terms_told(train, fit_structure(train, near.structure, starts=starts))
                if richer.sound and _called_for(train, taken, richer):
                    taken = richer
        if taken.model.structure not in known:  # such a form may have been asked for
            saturating.append(LawCandidate(taken.model.structure, outcome=taken))
    return saturating


def _of_rung(rung: Rung, notes: tuple[str, ...]) -> LawCandidate:
    """A law whose fit starts where the search for memory ended."""
    numbers = tuple(rung.numbers.values())
    return LawCandidate(rung.structure, notes, near=numbers)
