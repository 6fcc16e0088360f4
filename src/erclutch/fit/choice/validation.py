"""Training rows that a fit has not seen choose the model; rows held out are looked at when all is decided.

What is left out of a fit is what the model will be asked for later: where logs have fields of their own, whole fields;
where they differ in motion, whole motions; else whole logs, as each of two logs of two motions, or blocks of one log in
time, beside stretches all over it where these go beyond one another. Only models that the training rows leave in
question are fitted again.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from erclutch.errors import CheckError
from erclutch.fit.bands.new_fields import NewFieldErrors
from erclutch.fit.candidate import Fitted
from erclutch.fit.choice.at_no_field import NOT_IN_THE_MIDDLE, in_the_middle
from erclutch.fit.choice.parts_left_out import LeftOut, parts_of_training
from erclutch.fit.choice.recommending import as_good, recommend
from erclutch.fit.choice.scoring import BandedFigure, Score, excess, score
from erclutch.fit.choice.turned_down import what_speaks_against
from erclutch.fit.choice.worth import loses, worth_their_freedom
from erclutch.fit.solver.one_thread import one_thread
from erclutch.fit.solver.outcome import AnyOutcome
from erclutch.logs.dataset import Dataset
from erclutch.logs.held_out import time_folds
from erclutch.models.stages import slip_stages
from erclutch.signals.array import Array, Mask, rms

#: Models are in question whose error on the training rows is at most so many times the least of their kind.
_NEAR = 1.4
_MOST = 3  # of a kind
_MOST_LAWS = 5  # where whole fields or motions tell their forms apart
#: Share by which errors on other fields or motions may differ and are alike (`studies/lowest_field.py --before alike`).
_ALIKE = 0.005
#: The measure of a part is no smaller than this share of the largest least error on any part.
_AT_REST = 0.1


@dataclass(frozen=True)
class Choice:
    """The model that the training rows choose.

    Attributes:
        recommended: its name.
        words: on what it was chosen, for people.
        errors: RMSE of each model in question on parts that it was not fitted to.
        at_new_fields: errors of each model in question on all training rows by fits without the field of a row; none
            where no whole fields were left out.
        against: why each of the other models that may be recommended is not, the end of a sentence about it.
        growth: how many times larger the errors of each model in question are on rows that a fit has not seen, where
            rows alike were left out; none where whole fields, motions or logs were, of which the bands know otherwise.
    """

    recommended: str
    words: str
    errors: Mapping[str, BandedFigure]
    at_new_fields: Mapping[str, NewFieldErrors]
    against: Mapping[str, str]
    growth: Mapping[str, float]


def cross_validated(train: Dataset, fitted: Fitted, blocks: int) -> tuple[float, ...]:
    """RMSE on each block of the training rows in time, fitted on the others; empty for no blocks."""
    errors: list[float] = []
    for block in time_folds(train, blocks) if blocks else ():
        others = train.with_neighbours(~block)
        outcome = fitted.candidate.refit(train, others, fitted.outcome, ())
        error: Array = train.effort - outcome.model.predict(train)
        errors.append(rms(error[block]))
    return tuple(errors)


def chosen(
    train: Dataset,
    fitted: Sequence[Fitted],
    sound: Sequence[str],
    seed: int,
    told: Callable[[float, str], None] = lambda share, doing: None,
) -> Choice | None:
    """The model to recommend, by parts of the training rows that no fit of it has seen.

    Args:
        train: the training rows.
        fitted: all models.
        sound: names of those that may be recommended; none: all may.
        seed: of the bands.
        told: called with the share of the work that is done, and what is done next.

    Returns:
        None where there is no choice, or the rows are too few to leave any out. A single model is refitted only where
        whole fields can be left out, for its errors at new fields; it was chosen by nothing.
    """
    parts = parts_of_training(train)
    allowed = [f for f in fitted if f.outcome.name in sound] or list(fitted)
    if all(f.outcome.freedom for f in allowed):
        # No law is sound: a network still has to be worth its freedom, for such a law may estimate well all the same.
        allowed += [f for f in fitted if not f.outcome.freedom]
    if parts is None or (len(allowed) < 2 and not parts.fields):
        return None
    contenders = list(in_question(allowed, further=parts.further))
    outcomes = {f.outcome.name: f.outcome for f in contenders}

    # Each part is left out of a refit of each contender, and predicted.
    measured = [train.effort[part] for part in parts.masks]
    usable, given_up = _errors_on_parts(contenders, train, parts, seed, told)
    if not usable:
        return None

    # Errors of all parts that choose in a row, in the effort's unit: what people are told.
    asked = {name: own[parts.lowest :] for name, own in usable.items()}
    measured = measured[parts.lowest :]
    effort = np.concatenate(measured)
    rmse: dict[str, BandedFigure] = {}
    for name, own in asked.items():
        estimated = effort - np.concatenate(own)
        rmse[name] = score(effort, estimated, seed=seed).rmse

    # What is compared has each field and each motion count the same.
    freedom = {name: outcomes[name].freedom for name in usable}
    weights = _weights(asked, parts, freedom)
    weighed = {name: _times(weights, own) for name, own in asked.items()}
    weighed_effort = np.concatenate(_times(weights, measured))
    whole: dict[str, Array] = {}
    scores: dict[str, Score] = {}
    for name, own in weighed.items():
        whole[name] = np.concatenate(own)
        estimated = weighed_effort - whole[name]
        scores[name] = score(weighed_effort, estimated, seed=seed)
    worth = worth_their_freedom(weighed, freedom, seed, parts.may_lose)
    best = min(worth, key=lambda name: scores[name].rmse.value)
    scores_of_worth = {name: scores[name] for name in worth}
    excesses = {name: excess(whole[name], whole[best], seed=seed) for name in worth}
    burdens = burdens_of({name: usable[name] for name in worth}, outcomes, parts)
    # No part asks for what is estimated at no field; there most laws that are as good bear each other out.
    good = as_good(scores_of_worth, excesses)
    laws = {name: outcomes[name] for name in good if not freedom[name]}
    aside: dict[str, str] = {}
    if parts.never_without_field and laws:
        middle = {name: usable[name] for name in in_the_middle(train, laws)}
        burdens |= dict.fromkeys(laws, (np.inf, np.inf)) | burdens_of(middle, outcomes, parts)
        aside = dict.fromkeys(laws.keys() - middle.keys(), NOT_IN_THE_MIDDLE)
    _, recommended = recommend(
        scores=scores_of_worth,
        excesses=excesses,
        burden=burdens,
        freedom={name: freedom[name] for name in worth},
    )

    # The first parts are whole fields: together they are all rows, each predicted without its field.
    at_new_fields: dict[str, NewFieldErrors] = {}
    if parts.fields:
        of_fields = parts.masks[: parts.fields]
        rows = np.concatenate([np.flatnonzero(mask) for mask in of_fields])
        by_name = {f.outcome.name: f for f in contenders}
        for name, own in usable.items():
            usual, in_doubt = np.empty((2, train.rows))
            usual[rows] = np.concatenate(own[: parts.fields])
            for mask in of_fields:
                in_doubt[mask] = _largest_in_doubt(by_name[name], train, mask, usual[mask])
            at_new_fields[name] = NewFieldErrors(usual, in_doubt)
    if len(allowed) < 2:
        return Choice(recommended, "", {}, at_new_fields, {}, {})

    seen = asked | {name: own[parts.lowest :] for name, own in given_up.items()}
    others = {f.outcome.name: f.outcome.freedom for f in allowed if f.outcome.name != recommended}
    against = what_speaks_against(
        others, seen, {name: freedom[name] for name in worth}, train.units.effort
    )
    growth = _growth_on_parts(usable | given_up, outcomes, train, parts) if parts.alike else {}
    return Choice(recommended, parts.words, rmse, at_new_fields, against | aside, growth)


def growth_of_errors(unseen: Sequence[Array], seen: Sequence[Array]) -> float:
    """How many times larger a model's errors are on rows that its fit has not seen: of the parts the one in the middle.

    A model of many numbers follows its rows and errs by far more beside them. The part in the middle counts, since one
    part may be unlike all others: what its rows ask for, no fit without them could know.

    Args:
        unseen: errors on each part by a fit without it, in their order; the last parts may lack.
        seen: errors on the same parts by the fit to all.
    """
    times: list[float] = []
    for far, near in zip(unseen, seen, strict=False):
        error_of_the_fit = rms(near)
        if error_of_the_fit > 0.0:  # squares of the smallest errors are zero too
            times.append(rms(far) / error_of_the_fit)
    return float(np.median(times)) if times else 1.0


def _growth_on_parts(
    errors: Mapping[str, Sequence[Array]],
    outcomes: Mapping[str, AnyOutcome],
    train: Dataset,
    parts: LeftOut,
) -> dict[str, float]:
    """How many times larger the errors of each model are on parts that its fit has not seen."""
    growth: dict[str, float] = {}
    for name, own in errors.items():
        seen_by_fit: Array = train.effort - outcomes[name].model.predict(train)
        # Stretches lie between rows that are fitted: by them bands were too narrow for a next log.
        masks = parts.masks[: parts.in_a_row]
        growth[name] = growth_of_errors(own, [seen_by_fit[mask] for mask in masks])
    return growth


def _largest_in_doubt(fitted: Fitted, train: Dataset, part: Mask, error: Array) -> Array:
    """Errors at fields left out, each the largest of all fits that the rows left cannot tell apart, shape (rows,).

    Args:
        fitted: the model.
        train: all training rows.
        part: the rows left out, shape (n,).
        error: measured less estimated effort on these, by the fit that keeps what all fields told.
    """
    # The candidate of another package may know of no doubt.
    refits = getattr(fitted.candidate, "refits_in_doubt", None)
    if refits is None:
        return error
    largest = error
    for outcome in refits(train, train.with_neighbours(~part), fitted.outcome):
        other: Array = (train.effort - outcome.model.predict(train))[part]
        if np.isfinite(other).all():
            largest = np.where(np.abs(other) > np.abs(largest), other, largest)
    return largest


def burdens_of(
    usable: Mapping[str, Sequence[Array]], outcomes: Mapping[str, AnyOutcome], parts: LeftOut
) -> dict[str, tuple[float, float]]:
    """What decides between models that the parts which choose cannot tell apart, by their names; less is better.

    On other rows of the same fields and motions such models do the same, so the fewest parameters decide. Where whole
    fields or motions are left out, the next log may lie beyond all, where the models part, and a parameter more is a
    small price. So the error on all parts decides, those at no field among them: they are evidence, if not enough to
    choose by. Where no row is without a field, the next log may well be: a device is off at times. Motions say nothing
    of that, so the error on whole fields decides. Models that are as free of physics and do not part there either have
    one burden in that, and the fewest parameters decide.
    """
    parameters = {name: float(counted_parameters(outcomes[name])) for name in usable}
    if not parts.further:
        return {name: (count, 0.0) for name, count in parameters.items()}
    telling = usable
    if parts.never_without_field:
        telling = {name: own[: parts.fields] for name, own in usable.items()}
    weights = part_weights(telling)
    errors = {name: _weighed_rms(weights, own) for name, own in telling.items()}

    least: dict[int, float] = {}  # by freedom
    for name, error in errors.items():
        freedom = outcomes[name].freedom
        least[freedom] = min(error, least.get(freedom, error))
    burdens: dict[str, tuple[float, float]] = {}
    for name, error in errors.items():
        of_the_best = least[outcomes[name].freedom]
        is_alike = error <= (1.0 + _ALIKE) * of_the_best
        burdens[name] = (of_the_best if is_alike else error, parameters[name])
    return burdens


def counted_parameters(outcome: AnyOutcome) -> int:
    """Parameters by which models are compared that are as good.

    A yield form counts as one number at most: a form with two is there only where the training rows called for it.
    """
    law = outcome.model.law_part
    form = None if law is None else law.structure.law.yield_form
    if form is None:
        return outcome.parameters
    further = max(0, len(form.shape) - 1)
    return outcome.parameters - further


def _weights(
    asked: Mapping[str, Sequence[Array]], parts: LeftOut, freedom: Mapping[str, int]
) -> list[float]:
    """Factors of the errors on the parts that choose: blocks of one log in time alone are pooled as they are.

    Beside stretches all over the log, such blocks are measured by the models that physics binds most: a freer one that
    errs by next to nothing on stretches would else be forgiven whatever it does beyond its rows.
    """
    if parts.further:
        return part_weights(asked)
    if parts.in_a_row < len(parts.masks):
        least = min(freedom[name] for name in asked)
        return part_weights({name: own for name, own in asked.items() if freedom[name] == least})
    return [1.0] * (len(parts.masks) - parts.lowest)


def _times(weights: Sequence[float], parts: Sequence[Array]) -> list[Array]:
    """Each part times its weight."""
    return [weight * part for weight, part in zip(weights, parts, strict=True)]


def _weighed_rms(weights: Sequence[float], errors: Sequence[Array]) -> float:
    """Of all parts together."""
    weighed = _times(weights, errors)
    return rms(np.concatenate(weighed))


def part_weights(errors: Mapping[str, Sequence[Array]]) -> list[float]:
    """Factors of the errors on each part, so that each field and each motion left out counts the same.

    The next log may be like any part. Errors at the highest field are the largest, and would decide alone. The least
    error on a part is the measure there; a part at rest, where all models are right, has a tenth of the largest at
    least.

    Args:
        errors: by model, measured less estimated effort on each part.
    """
    rmse: list[list[float]] = []  # of each model, one a part
    for of_model in errors.values():
        rmse.append([rms(error) for error in of_model])
    least = np.array(rmse).min(axis=0)  # shape (parts,)
    measure = np.maximum(least, _AT_REST * float(least.max()))
    if not measure.all():
        return [1.0] * measure.size
    return list(float(measure.max()) / measure)


def _errors_on_parts(
    contenders: Sequence[Fitted],
    train: Dataset,
    parts: LeftOut,
    seed: int,
    told: Callable[[float, str], None],
) -> tuple[dict[str, list[Array]], dict[str, list[Array]]]:
    """Measured less estimated effort on each part by fits without it, of the models that are still in question after.

    What physics binds most goes first. A freer model that loses too much to the best of these on the parts that choose
    cannot be recommended (`worth_their_freedom`), so it is not fitted without the other parts: the second value is its
    errors so far.
    """
    usable: dict[str, list[Array]] = {}
    given_up: dict[str, list[Array]] = {}
    freedom = {f.outcome.name: f.outcome.freedom for f in contenders}
    count = len(parts.masks)
    refitted: list[list[Fitted]] = [[] for _ in parts.masks]  # without each part
    levels = sorted(set(freedom.values()))
    for place, level in enumerate(levels):
        # Of the models that may be recommended so far the best, which a freer one must not lose to.
        best: str | None = None
        weights: list[float] = []
        if usable:
            of_parts_that_choose = {name: own[parts.lowest :] for name, own in usable.items()}
            weights = _weights(of_parts_that_choose, parts, freedom)
            weighed = {name: _times(weights, own) for name, own in of_parts_that_choose.items()}
            own_freedom = {name: freedom[name] for name in usable}
            worth = worth_their_freedom(weighed, own_freedom, seed, parts.may_lose)
            best = min(worth, key=lambda name: _weighed_rms(weights, of_parts_that_choose[name]))

        of_level = {f.outcome.name: f for f in contenders if f.outcome.freedom == level}
        errors: dict[str, list[Array]] = {name: [] for name in of_level}
        for number, part in enumerate(parts.masks):
            done = (place * count + number) / (len(levels) * count)
            told(done, f"choosing: part {number + 1} of {count} is left out")
            others = train.with_neighbours(~part)
            for name in list(errors):
                fitted = of_level[name]
                try:
                    with one_thread():
                        outcome = fitted.candidate.refit(
                            train, others, fitted.outcome, refitted[number]
                        )
                        refitted[number].append(Fitted(fitted.candidate, outcome))
                        error: Array = (train.effort - outcome.model.predict(train))[part]
                except CheckError:  # the rows that are left cannot make the model
                    del errors[name]
                    continue
                if not np.isfinite(error).all():
                    del errors[name]
                    continue

                errors[name].append(error)
                if best is None:
                    continue
                asked = errors[name][parts.lowest :]
                bound = usable[best][parts.lowest :]
                so_far = _times(weights[: len(asked)], asked)
                if loses(so_far, _times(weights, bound), parts.may_lose):
                    given_up[name] = errors.pop(name)
        usable |= errors
    return usable, given_up


def in_question(fitted: Sequence[Fitted], *, further: bool) -> Iterator[Fitted]:
    """The models between which the training rows are to choose: the nearest of each freedom.

    Where whole fields or motions are left out, the best law without a memory is in question too: a memory may learn
    what holds at the fields and motions of its rows alone.
    """
    for freedom in (0, 1, 2):
        as_free = [f for f in fitted if f.outcome.freedom == freedom]
        if not as_free:
            continue
        as_free.sort(key=lambda f: f.outcome.train_cost)
        highest = _NEAR**2 * as_free[0].outcome.train_cost
        near = [f for f in as_free if f.outcome.train_cost <= highest]
        if not further or freedom > 0:
            yield from near[:_MOST]
            continue
        taken = near[:_MOST_LAWS]
        yield from taken
        for other in as_free[len(taken) :]:
            if not slip_stages(other.outcome.model.structure.dynamics):
                yield other
                break
