"""The ladder of memory: stages are added to the best law as long as blocked validation on the training rows says so.

Each candidate is a rung (`rungs`). The best candidate is taken if it lowers the error on rows that it was not fitted to
by at least `WORTH`; the rows held out for the test are never seen.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from erclutch.fit.choice.rungs import (
    FITTED_ROWS,
    MOST_WHOLE_ROWS,
    Fold,
    Rung,
    by_chance,
    folds_of,
    is_of_grid,
    numbers_of_fit,
    rung_of,
    starts_of,
)
from erclutch.fit.choice.stage_families import (
    edge_of,
    fading_of,
    families,
    feels,
    forgetting_of,
    has_company,
    has_field_behind,
    has_to_take_off,
    is_next,
    simpler_than,
    widened,
    with_field_behind,
)
from erclutch.fit.laws.field_levels import more_numbers_than_fields
from erclutch.fit.laws.fit_law import reference_of
from erclutch.fit.laws.shapes_told import shapes_told
from erclutch.fit.log_groups import FEWEST_GROUPS, groups_of
from erclutch.logs.dataset import Dataset
from erclutch.models.laws.yield_stress import POWER, SATURATING, TANH
from erclutch.models.stages import NONE, stage_named
from erclutch.models.stages.stage import SlipAndStrength
from erclutch.models.structure import Structure
from erclutch.signals.array import Array, largest_size, noise_of, rms
from erclutch.signals.recording import TEMPERATURE

#: Share of the error that a stage must take off.
WORTH = 0.01
#: The same of a stage that sums up the slip: a sensor's zero makes its travel drift, so it must be worth that.
DRIFTING_WORTH = 0.1
#: The same of a field behind a memory beside the field ahead: at fields that no log has, the second has erred by less.
BEHIND_WORTH = 0.05
#: A stage that sums up the slip is tried only where its columns, at some of its numbers, take that share off the error
#: of the rows that they are fitted to, beside the law's columns as they are; so is a striking one, with its own share.
_SHOWING = 0.05
_SHOWING_PLACES = (0.1, 0.3, 0.5, 0.7, 0.9)
#: Training rows for each number of a fit, below which no stage is added: a hundred rows would get seven stages.
_ROWS_A_NUMBER = 10
#: The same of points of a table: none is like the point before.
_POINTS_A_NUMBER = 2
#: Times the share that chance takes off a stage must take off points, which are few while many stages are tried.
OVER_CHANCE = 3.0
#: Widest edge of plays, over the noise of the field, from which on they tell more than that noise is smoothed.
_EDGE_OVER_NOISE = 4.0
#: Times the slip over which the sign turns, at least, over which a hump fades.
_BEYOND_THE_TURN = 2.0
#: Of the slip: a travel that loses more at a time is forgotten before the slip turns (of a sine, after its radian).
_FORGOTTEN = 0.5**0.5
#: Of the largest field: what is no field; and the share of rows without any that tells what a memory does there.
_NO_FIELD = 0.02
_TOLD = 0.02
#: Times the largest field: a yield effort that saturates from there on is straight over all fields of the log.
_FAR = 5.0
#: Correlation from which a column is the effort, or the power that the effort makes, in other numbers.
_OF_THE_EFFORT = 0.999


def grown(
    train: Dataset,
    base: Structure,
    extras: Sequence[str] = (),
    among: Sequence[str] | None = None,
) -> list[Rung]:
    """The rungs that validation asks for, from the base to the richest.

    Args:
        train: the training rows.
        base: the law to begin with, with its stages on the command.
        extras: further inputs that may get a gain, and the temperature, of which stages may make factors.
        among: names of the stages to try, the simplest of a family first; None: all.
    """
    folds = folds_of(train)
    first = rung_of(folds, base, {})
    rungs = [bent(folds, first)]
    known = among
    if known is None:
        known = [name for family in families() for name in family]
    # What may still be added: stages by their names, and further inputs as ``=NAME``.
    left = [name for name in known if feels(train, base, name, extras)]
    left += [f"={name}" for name in extras if name != TEMPERATURE]
    rows_a_number = _POINTS_A_NUMBER if train.in_no_time else _ROWS_A_NUMBER
    while left:
        here = rungs[-1]
        left = [name for name in left if name.removeprefix("=") not in here.structure.extras]
        tried = [name for name in left if is_next(left, name) and has_company(here.structure, name)]
        worth_of, showing = _that_have_to_show(train, here, tried)
        counting = any(map(_counts_from_the_start, showing))
        if counting and folds[0].data.rows < min(train.rows, MOST_WHOLE_ROWS):
            # From here on the whole log counts: in a stretch that is cut out of it such a stage would begin anew.
            folds = folds_of(train, whole=True)
            here = rung_of(folds, here.structure, here.numbers)
            rungs[-1] = here
        worthy: dict[str, Rung] = {}
        for name in tried:
            if name in worth_of and name not in showing:
                continue
            richer = widened(here.structure, name)
            if numbers_of_fit(richer) * rows_a_number > train.rows:
                continue
            rung = _rung_above(folds, here, richer, name)
            if _edge_in_noise(train, rung, name) or fades_with_the_sign(rung, name):
                continue
            other = in_place_of_a_travel(train, rung, name)
            if other and other not in left:
                continue
            if other:
                name = other
                rung = rung_of(folds, widened(here.structure, name), here.numbers)
            over_chance = OVER_CHANCE if train.in_no_time else 1.0
            worth = max(worth_of.get(name, WORTH), over_chance * by_chance(here, rung))
            if rung.error < (1.0 - worth) * here.error:
                worthy[name] = rung
        if not worthy:
            break

        # Of those that take off as much, the one with the fewest numbers: a LuGre state is a Dahl state with two more.
        best = min(worthy.values(), key=lambda rung: rung.error)
        alike: list[str] = []
        for name, rung in worthy.items():
            is_near = rung.error <= (1.0 + WORTH) * best.error
            if is_near or best.error >= (1.0 - by_chance(rung, best)) * rung.error:
                alike.append(name)
        taken = min(alike, key=lambda name: (worthy[name].numbers_of_fit, worthy[name].error))
        new = worthy[taken]
        rungs.append(bent(folds, new) if len(rungs) == 1 else new)
        for name in (*simpler_than(left, taken), taken):
            left.remove(name)
    rungs[-1] = _without_stand_ins(folds, rungs[-1], base)
    return rungs


def _that_have_to_show(
    train: Dataset, here: Rung, tried: Sequence[str]
) -> tuple[dict[str, float], list[str]]:
    """The share that each stage must take off which has to show first, and those of these stages that do show."""
    worth_of: dict[str, float] = {}
    showing: list[str] = []
    for name in tried:
        counts = _counts_from_the_start(name)
        share = _SHOWING if counts else has_to_take_off(name)
        if share:
            worth_of[name] = DRIFTING_WORTH if counts else share
            if may_show(train, here, widened(here.structure, name), share):
                showing.append(name)
    return worth_of, showing


def _counts_from_the_start(name: str) -> bool:
    """Whether what is tried is a stage that counts from the start of a log; ``=NAME`` is a further input."""
    return not name.startswith("=") and bool(getattr(stage_named(name), "from_the_start", ""))


def _without_stand_ins(folds: Sequence[Fold], rung: Rung, base: Structure) -> Rung:
    """The rung without the stages of the base, and without a bend over the field, where unseen rows do not miss them.

    Before anything told of a spring, say, a lag or a bend took some of its effort for its own. Now that the rung has
    the spring, these stand-ins may have nothing left to say.
    """
    if base.dynamics != NONE and rung.structure != base:
        of_base = base.dynamics.split("+")
        kept = [name for name in rung.structure.dynamics.split("+") if name not in of_base]
        fewer = replace(rung.structure, dynamics="+".join(kept) or NONE)
        leaner = rung_of(folds, fewer, rung.numbers)
        worth = max(WORTH, by_chance(leaner, rung))
        if rung.error >= (1.0 - worth) * leaner.error:
            rung = leaner

    # Back to the power of the field that the base has.
    was_bent = rung.structure.law.yield_form is SATURATING and base.law.yield_form is POWER
    if not was_bent:
        return rung
    law_of_base = replace(rung.structure, specification=base.specification, law=base.law)
    straight = rung_of(folds, law_of_base, rung.numbers)
    worth = max(WORTH, by_chance(straight, rung))
    is_straight = rung.numbers["E_s"] > _FAR or rung.error >= (1.0 - worth) * straight.error
    return straight if is_straight else rung


def _rung_above(folds: Sequence[Fold], here: Rung, richer: Structure, name: str) -> Rung:
    """The rung of a richer structure, from the numbers of the rung here on.

    Iron that keeps a field saturates too, and either shows little without the other. So where the iron is new, a yield
    effort that saturates is tried beside a power of the field. A memory that helps is tried with the field behind it
    too: then it has a share without a field, and an effort that follows the field at once.

    Args:
        folds: the rows.
        here: the rung below.
        richer: its structure with what is new.
        name: of what is new.
    """
    behind = with_field_behind(richer, name) if tells_without_field(folds[0].data) else None
    if behind is not None and has_field_behind(here.structure, name):
        return rung_of(folds, behind, here.numbers)
    rung = rung_of(folds, richer, here.numbers)
    if behind is not None and rung.error < (1.0 - WORTH) * here.error:
        other = rung_of(folds, behind, rung.numbers)
        worth = max(BEHIND_WORTH, by_chance(rung, other))
        if other.error < (1.0 - worth) * rung.error:
            return other
    if of_iron(richer) and not of_iron(here.structure) and richer.law.yield_form is POWER:
        saturating = rung_of(folds, richer.with_yield_form(TANH), here.numbers)
        if saturating.error < (1.0 - WORTH) * rung.error:
            return saturating
    return rung


def bent(folds: Sequence[Fold], rung: Rung) -> Rung:
    """The rung with a yield effort that saturates in the field, where that takes a share of the error off.

    Else stages stand in for the bend that a power of the field has not. Where whole fields are left out of the fits,
    these choose the form.
    """
    data = folds[0].data
    whole_fields = len(set(groups_of(data).field)) >= FEWEST_GROUPS
    if rung.structure.law.yield_form is not POWER or whole_fields:
        return rung
    saturating = rung.structure.with_yield_form(SATURATING)
    if more_numbers_than_fields(data, saturating):
        return rung
    other = rung_of(folds, saturating, rung.numbers)
    worth = max(WORTH, by_chance(rung, other))
    return other if other.error < (1.0 - worth) * rung.error else rung


def tells_without_field(data: Dataset) -> bool:
    """Whether rows tell what a memory does without a field: a share that none shows would be a guess at no field."""
    shares: list[float] = []  # of the rows, one an element
    for element in data.elements:
        size = np.abs(element.field)
        none = size <= _NO_FIELD * largest_size(size)
        shares.append(float(np.mean(none)))
    return min(shares) >= _TOLD


def of_iron(structure: Structure) -> bool:
    """Whether a stage keeps the field as iron does."""
    return any(getattr(stage, "of_iron", False) for stage in structure.stages)


def may_show(train: Dataset, here: Rung, richer: Structure, share: float = _SHOWING) -> bool:
    """Whether a further stage may take a share of the error off, by its columns beside those of the rung as they are.

    No search is made: one of a stage that counts from the start runs over the whole log, and few logs need the stage.
    Another form of a stage has no numbers of its own to look at: those of the first form do not suit it.
    """
    reference = reference_of(train, richer.extras)
    if {shape.name for shape in richer.shapes(reference.period)} <= here.numbers.keys():
        return True
    shapes = shapes_told(train, richer, reference)
    every = -(-train.rows // FITTED_ROWS)  # rounded up
    effort = train.effort[::every]
    least: list[float] = []  # error of either structure at the best of its starts
    for structure in (here.structure, richer):
        errors: list[float] = []
        names = [shape.name for shape in structure.shapes(reference.period)]
        own = [shape for shape in shapes if shape.name in names]
        grid = is_of_grid(structure, here.numbers)
        for q in starts_of(own, here.numbers, _SHOWING_PLACES, grid=grid):
            columns = structure.columns(
                train.elements,
                train.clock,
                reference,
                q,
                slice(None, None, every),
                extras=train.extras,
            )
            beside = np.column_stack(columns)
            if not np.isfinite(beside).all():
                errors.append(np.inf)
                continue
            gains, *_ = np.linalg.lstsq(beside, effort, rcond=None)
            errors.append(rms(effort - beside @ gains))
        least.append(min(errors))
    without, beside_it = least
    return beside_it < (1.0 - share) * without


def of_law(train: Dataset, rung: Rung, law: Structure) -> Rung:
    """The stages and further inputs of a rung with another law; it saturates where the iron of the rung does."""
    other = replace(law, dynamics=rung.structure.dynamics, extras=rung.structure.extras)
    if of_iron(other) and rung.structure.law.yield_form is TANH and other.law.yield_form is POWER:
        other = other.with_yield_form(TANH)
    folds = folds_of(train, whole=rung.structure.counts_from_the_start)
    return rung_of(folds, other, rung.numbers)


def helpful(train: Dataset, rung: Rung) -> dict[str, float]:
    """The spare columns of the log that would lower the error of a rung, as a share of it, most helpful first.

    Left out is a column that was made of the effort itself, such as a power: no controller has it before the effort.
    """
    spare: dict[str, Array] = {}
    powers = [train.effort * element.slip for element in train.elements]
    for name, column in train.spare.items():
        made_of_effort = False
        for made in (train.effort, *powers):
            both_change = np.ptp(made) > 0.0 and np.ptp(column) > 0.0
            if both_change and abs(np.corrcoef(column, made)[0, 1]) > _OF_THE_EFFORT:
                made_of_effort = True
                break
        if not made_of_effort:
            spare[name] = column
    if not spare or not rung.error > 0.0:
        return {}
    wide = replace(train, extras={**train.extras, **spare})
    folds = folds_of(wide, whole=rung.structure.counts_from_the_start)
    gains: dict[str, float] = {}  # share of the error that each column takes off
    for name in spare:
        wider = rung_of(folds, widened(rung.structure, f"={name}"), rung.numbers)
        gains[name] = 1.0 - wider.error / rung.error
    most_helpful_first = sorted(gains.items(), key=lambda item: -item[1])
    return {name: gain for name, gain in most_helpful_first if gain >= WORTH}


def fades_with_the_sign(rung: Rung, name: str) -> bool:
    """Whether a hump fades where the law's sign still turns: a sign that turns sooner would say the same.

    Of rates over decades the lowest lie below the least slip over which a sign can turn.
    """
    fading = fading_of(name)
    return bool(fading) and rung.numbers[fading] < _BEYOND_THE_TURN * rung.numbers.get("w_s", 0.0)


def in_place_of_a_travel(train: Dataset, rung: Rung, name: str) -> str:
    """The stage that stands for a travel which is forgotten while the slip lasts; "" where the travel is true.

    Such a travel is the slip, some time late, and no spring is told. Beside a viscous effort it says no more than an
    inertia whose acceleration passes a low-pass.
    """
    forgetting, instead = forgetting_of(name)
    if not forgetting:
        return ""
    stage = stage_named(name)
    forgets_after = rung.numbers[forgetting]  # s
    for element in train.elements:
        signal = SlipAndStrength(element.slip, np.ones(train.rows))
        (travel,) = stage.respond(signal, train.clock, [forgets_after], slice(None))
        # What is forgotten in a second; as large as the slip where no travel is left to remember.
        forgotten = rms(travel) / forgets_after
        if forgotten > _FORGOTTEN * rms(element.slip):
            return instead
    return ""


def _edge_in_noise(train: Dataset, rung: Rung, name: str) -> bool:
    """Whether the edge of a stage lies in the noise of a measured field: it smooths the noise, and no iron is told."""
    edge = edge_of(name)
    if not edge:
        return False
    # Noise from row to row shows in the bends; a command that stands still or ramps has none.
    noise = max(noise_of(element.field) for element in train.elements)
    reference = reference_of(train)
    return rung.numbers[edge] * reference.field < _EDGE_OVER_NOISE * noise
