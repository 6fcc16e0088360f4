"""Whether a model that is freer of physics is worth its freedom, by rows that its fit has not seen."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from erclutch.fit.choice.scoring import TOLERATED, excess
from erclutch.signals.array import Array

#: Squared error of a freer model on each part, over that of the model that more physics binds: fading costs a little.
_NO_MORE = 1.02


def worth_their_freedom(
    errors: Mapping[str, Sequence[Array]],
    freedom: Mapping[str, int],
    seed: int = 0,
    may_lose: float = 0.0,
) -> dict[str, int]:
    """The models that may be recommended by their errors on parts that they were not fitted to, with their freedom.

    A model that is freer of physics has to be worth it: the best model of less freedom errs clearly more than the freer
    one over all parts, and no less than it on any single part. What is better on most parts and worse on others has
    learned something that holds on some rows only, and the next log may be of the others. Blocks of one log are all of
    the same motion, and little happens in some: there the freer one may lose a little of what it gains elsewhere.

    Args:
        errors: by model, measured less estimated effort on each part.
        freedom: by model, from 0, a law.
        seed: of the band that tells "clearly".
        may_lose: what the freer model may lose on some parts, as a share of what it gains on others, in squares.
    """
    squares: dict[str, float] = {}
    for name, own in errors.items():
        whole = np.concatenate(own)
        squares[name] = float(whole @ whole)
    allowed: dict[str, int] = {}
    for level in sorted(set(freedom.values())):
        best = min(allowed, key=lambda name: squares[name], default=None)
        as_free = [name for name, own in freedom.items() if own == level]
        for name in as_free:
            if best is None:
                allowed[name] = level
            elif not loses(errors[name], errors[best], may_lose):
                freer = np.concatenate(errors[name])
                bound = np.concatenate(errors[best])
                saved = excess(bound, freer, seed=seed)
                if saved.value > TOLERATED and saved.low > 0.0:
                    allowed[name] = level
    return allowed


def loses(freer: Sequence[Array], bound: Sequence[Array], may_lose: float) -> bool:
    """Whether a freer model loses too much on single parts to the model that more physics binds.

    Args:
        freer: its errors on the first parts, or on all; on the others it may yet gain all that there is.
        bound: errors on all parts of the other model.
        may_lose: as a share of what is gained, in squares.
    """
    lost = 0.0
    gained = sum(float(error @ error) for error in bound[len(freer) :])
    for error, error_of_bound in zip(freer, bound, strict=False):
        square = float(error @ error)
        square_of_bound = float(error_of_bound @ error_of_bound)
        if not _NO_MORE * square_of_bound >= square:  # also where a square is no number
            lost += square - square_of_bound
        gained += max(square_of_bound - square, 0.0)
    return lost != 0.0 and not lost <= may_lose * gained
