"""From which law the search for stages begins: a plain law with a stage may say more than a law that bends."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from erclutch.fit.choice.ladder import (
    OVER_CHANCE,
    WORTH,
    bent,
    fades_with_the_sign,
    grown,
    may_show,
)
from erclutch.fit.choice.rungs import Rung, by_chance, folds_of, numbers_of_fit, rung_of
from erclutch.fit.choice.scoring import TOLERATED
from erclutch.fit.choice.stage_families import has_to_take_off, widened
from erclutch.fit.solver.outcome import FitOutcome
from erclutch.logs.dataset import Dataset
from erclutch.models.law_model import TorqueModel
from erclutch.models.laws import ladder, without_yield
from erclutch.models.laws.yield_stress import POWER
from erclutch.models.structure import Structure

#: Other laws that are tried with the memory that was found, or with a hump.
MOST_FORMS = 3
#: Times the error of the base, on the training rows, that a drag may have which is the better law once both bend.
_NEAR_UNBENT = 2.0
#: The stage that gives a plain law a friction that falls with the slip.
_HUMP = "stribeck"


def plainest_of_the_best(laws: Sequence[FitOutcome[TorqueModel]]) -> FitOutcome[TorqueModel]:
    """The law with the fewest numbers that is nearly the best on the training rows."""
    best = min(laws, key=lambda law: law.train_cost)
    near = [law for law in laws if law.train_cost <= (1.0 + TOLERATED) * best.train_cost]
    return min(near, key=lambda law: (law.parameters, law.train_cost))


def plainest_with_form(laws: Sequence[FitOutcome[TorqueModel]]) -> FitOutcome[TorqueModel]:
    """The law with the fewest numbers among those with a form of the yield effort and no memory, or among all.

    Of Bingham's and Casson's law without a field, which have as many, Bingham's: it is the first of the ladder.
    """
    plain: list[FitOutcome[TorqueModel]] = []
    for law in laws:
        structure = law.model.structure
        if structure.law.yield_form is not None and not structure.remembers:
            plain.append(law)
    order = ladder()  # of names, from the plainest

    def plainness(law: FitOutcome[TorqueModel]) -> tuple[int, int]:
        name = law.model.structure.law.name
        return law.parameters, order.index(name) if name in order else len(order)

    return min(plain or laws, key=plainness)


def grown_from_the_plainest(
    train: Dataset,
    plain: FitOutcome[TorqueModel],
    rungs: Sequence[Rung],
) -> list[Rung]:
    """The rungs from the plainest law on, where the last says more than that of the base; else none.

    A law that bends over the slip stands in for a stage with a corner, so the stage shows little beside that law. To
    climb twice costs little on points of a table.
    """
    structure = plain.model.structure
    if structure == rungs[0].structure:
        return []
    others = grown(train, structure, tuple(train.extras))
    # As many numbers or fewer may err a little more; further numbers have to take off what a stage would have to.
    last, other = rungs[-1], others[-1]
    most = (1.0 + WORTH) * last.error
    if other.numbers_of_fit > last.numbers_of_fit:
        most = (1.0 - max(WORTH, OVER_CHANCE * by_chance(last, other))) * last.error
    return others if other.error <= most else []


def plain_for_a_hump(
    train: Dataset,
    laws: Sequence[FitOutcome[TorqueModel]],
    base: FitOutcome[TorqueModel],
) -> FitOutcome[TorqueModel]:
    """A plainer law in place of the base, where the hump of its friction says as much with no more numbers.

    Some laws of fluids have a yield effort that falls with the slip. They describe dry friction that falls too, by
    numbers that no one can read as levels and a speed of it.
    """
    most = numbers_of_fit(base.model.structure)
    plainer: list[tuple[FitOutcome[TorqueModel], Structure]] = []  # each with its hump
    for law in sorted(laws, key=lambda law: (law.parameters, law.train_cost)):
        structure = law.model.structure
        humped = widened(structure, _HUMP)
        has_form = structure.law.yield_form is not None
        if has_form and not structure.remembers and numbers_of_fit(humped) <= most:
            plainer.append((law, humped))
    if not plainer:
        return base
    folds = folds_of(train)
    # Errors on the rows between, the law with the fewest numbers first.
    with_hump: list[tuple[float, FitOutcome[TorqueModel]]] = []
    for law, humped in plainer[:MOST_FORMS]:
        here = rung_of(folds, law.model.structure, dict(law.model.shape))
        if may_show(train, here, humped, has_to_take_off(_HUMP)):
            rung = rung_of(folds, humped, here.numbers)
            if not fades_with_the_sign(rung, _HUMP):
                with_hump.append((rung.error, law))
    if not with_hump:
        return base
    least = min(error for error, _ in with_hump)
    error, plain = next(pair for pair in with_hump if pair[0] <= (1.0 + WORTH) * least)
    of_base = rung_of(folds, base.model.structure, dict(base.model.shape))
    return plain if error <= (1.0 + WORTH) * of_base.error else base


def drag_once_bent(
    train: Dataset,
    laws: Sequence[FitOutcome[TorqueModel]],
    base: FitOutcome[TorqueModel],
) -> FitOutcome[TorqueModel]:
    """A law of a drag in place of the base, where both need an effort that saturates in the field and it errs by less.

    The laws were fitted with a power of the field. A viscosity that the field changes then stands in for the bend over
    the field. Among laws of fluids the base stays: they stand in for a memory as well, which comes after.
    """
    most = _NEAR_UNBENT**2 * base.train_cost
    drags: list[FitOutcome[TorqueModel]] = []
    for law in laws:
        structure = law.model.structure
        takes_a_power = structure.law.yield_form is POWER
        if without_yield(structure.specification) and takes_a_power and law.train_cost <= most:
            drags.append(law)
    if not drags or base in drags:
        return base
    drag = min(drags, key=lambda law: law.train_cost)
    folds = folds_of(train)
    of_base = bent(folds, rung_of(folds, base.model.structure, dict(base.model.shape)))
    structure = replace(drag.model.structure, dynamics=base.model.structure.dynamics)
    of_drag = bent(folds, rung_of(folds, structure, dict(drag.model.shape)))
    return drag if of_drag.error < (1.0 - WORTH) * of_base.error else base
