"""Terms of a law that the rows cannot tell are left out: a law with fewer terms that says the same stays eligible."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np

from erclutch.fit.laws.field_levels import more_numbers_than_fields
from erclutch.fit.laws.fit_law import fit_structure
from erclutch.fit.laws.law_problem import separable
from erclutch.fit.solver.outcome import FitOutcome
from erclutch.fit.solver.variable_projection import project
from erclutch.logs.dataset import Dataset
from erclutch.models.composition import FRICTION, OFFSET
from erclutch.models.law_model import TorqueModel
from erclutch.models.laws.smooth import TRANSITION_SLIP
from erclutch.models.stages import needs_time, slip_stages

#: Share by which the cost may grow when a term that cannot be told is taken out.
_NO_WORSE = 0.01
#: The same of points of a table, in squares of the noise of a point: once in twenty times chance takes more off.
_BY_CHANCE = 4.0
#: A constant effort so many times the largest effort of the rows cancels another term, and says nothing at other slips.
_CANCELLED = 3.0
#: Unknowns of a law whose lack of rank may come from a term that was added.
_SHORT_LAW = 8


def with_terms_told(train: Dataset, law: FitOutcome[TorqueModel]) -> FitOutcome[TorqueModel]:
    """A law without the terms that these rows cannot tell from its others: constant effort, friction, or its own.

    Where the slip keeps its sign, say, a constant effort and a yield effort are one column: the sum is known, its parts
    are not. The term that was added to the law goes; a law with fewer terms that says the same stays eligible.
    So does friction where a bound alone makes the fit look sound: with two fields, say, friction, yield effort and
    exponent are three numbers for two, and the exponent or the friction ends on its bound.

    A constant effort far beyond all efforts cancels a yield effort that is as large: the rows tell their difference
    alone, and at rest such a law gives millions. It goes whatever the error.

    A law with memory may go without those of its own terms that the memory says better. Where all of the yield effort
    has a memory, nothing tells over which slip the law's own would turn; a power of the slip and a viscosity are one
    column where the power is one.
    """
    structure = law.model.structure
    propped = structure.friction and more_numbers_than_fields(train, structure)
    constant = abs(law.model.gains.get(OFFSET.name, 0.0))
    cancelled = constant > _CANCELLED * float(np.max(np.abs(train.effort)))
    if law.sound and not propped and not cancelled:
        return law
    offset = {OFFSET.name}
    friction = set(structure.names_of(FRICTION.name))
    without = [
        (offset, "a constant effort", replace(structure, offset=False)),
        (friction, "friction", replace(structure, friction=False)),
        (
            offset | friction,
            "a constant effort and friction",
            replace(structure, offset=False, friction=False),
        ),
    ]
    added: set[str] = set()  # terms beside those of the law itself
    if structure.offset:
        added |= offset
    if structure.friction:
        added |= friction
    # A long series of kernels loses rank by itself: no term that was added can cure that.
    trade_off = law.unknowns <= _SHORT_LAW and (law.rank < law.unknowns or not law.converged)
    if propped:
        without.insert(0, without.pop(1))  # friction first: it is what the fields do not tell
    no_worse = _NO_WORSE
    if train.in_no_time:
        no_worse = max(no_worse, _BY_CHANCE / max(law.train_rows - law.parameters, 1))
    most = (1.0 + no_worse) * law.train_cost
    start = list(law.model.shape.values())

    told = _with_ways_told(train, law, most)
    if told is not None:
        return told

    unknown = set(law.unidentified)
    # Friction that hardly is there has no slip over which its sign turns.
    if TRANSITION_SLIP.name in unknown:
        unknown |= friction
    for terms, words, fewer in without:
        must_go = cancelled and terms == offset
        in_doubt = must_go or trade_off or terms & unknown or (propped and terms == friction)
        if not (terms <= added and in_doubt):
            continue
        # With memory the search goes on from the law's own numbers.
        starts = [start] if structure.remembers else []
        cured = fit_structure(train, fewer, starts=starts, most=None if must_go else most)
        if must_go or (cured.sound and cured.train_cost <= most):
            note = f"left out: {words}, which these rows cannot tell from the law's own terms"
            return replace(cured, notes=(*law.notes, note))
    if law.sound or not structure.remembers:
        return law

    # Its own terms, one at a time and then two.
    own = [gain for gain in structure.law.gains if gain.nonnegative]
    own += [gain for gain in structure.gains_of_element if gain.name == FRICTION.name]
    singles = [(gain,) for gain in own]
    for some in (*singles, *itertools.combinations(own, 2)):
        names = [name for gain in some for name in structure.names_of(gain.name)]
        cured = fit_structure(train, structure, starts=[start], without=names, most=most)
        if cured.sound and cured.train_cost <= most:
            words = " and ".join(gain.meaning for gain in some)
            note = f"left out: {words}, which these rows cannot tell from the memory's terms"
            return replace(cured, notes=(*law.notes, note))
    return law


def _with_ways_told(
    train: Dataset, law: FitOutcome[TorqueModel], most: float
) -> FitOutcome[TorqueModel] | None:
    """A law without friction that differs between the ways, where a constant effort says the same.

    Wherever the slip is far from rest such friction is a constant effort. None where the law is worse without it.
    """
    structure = law.model.structure
    if not structure.offset:
        return None
    for stage in slip_stages(structure.dynamics):
        for gain in stage.gains:
            names = structure.names_of(gain.name)
            in_doubt = not law.unidentified or {*names, OFFSET.name} & set(law.unidentified)
            of_ways = gain.part is None and not needs_time(stage) and in_doubt
            if not of_ways:
                continue
            start = list(law.model.shape.values())
            # A search is worth its time where the rows of a log hardly miss the gain; one of points takes little.
            if not train.in_no_time:
                reference = law.model.reference
                shapes = structure.shapes(reference.period)
                without = {*law.without, *names}
                problem = separable(train, structure, reference, shapes, slice(None), without)
                if not project(problem, start).cost <= most:  # nor where it is no number
                    continue
            cured = fit_structure(train, structure, starts=[start], without=names, most=most)
            if cured.sound and cured.train_cost <= most:
                words = f"left out, since a constant effort says the same here: {gain.meaning}"
                return replace(cured, notes=(*law.notes, words))
    return None
