"""Why a model is not recommended, in words, for people who see it do better on the rows held out."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from erclutch.models.model_titles import title_of
from erclutch.signals.array import Array, rms
from erclutch.signals.units import amount

NOT_IDENTIFIED = "these data do not identify all that it says: --all prints its notes"
_NOT_TRIED = "others of its kind err by less on the training rows, so it was not tried on parts left out of its fit"


def what_speaks_against(
    others: Mapping[str, int],
    errors: Mapping[str, Sequence[Array]],
    worth: Mapping[str, int],
    unit: str,
) -> dict[str, str]:
    """Why each of some models is not recommended, the end of a sentence about it.

    Args:
        others: the freedom of each of them, by name.
        errors: by name, on the parts of the training rows that were left out of the fit; of the first parts alone where
            a model was given up; none where it was not in question.
        worth: the freedom of each model that is worth it, all of whose errors are known.
        unit: of the effort.
    """
    against: dict[str, str] = {}
    for name, freedom in others.items():
        if name not in errors:
            against[name] = _NOT_TRIED
            continue
        # A freer model has to beat the best that more physics binds; a law has to beat the best of all.
        bound = [rival for rival in worth if worth[rival] < freedom] or [
            rival for rival in worth if rival != name
        ]
        rival = min(bound, key=lambda each: rms(np.concatenate(errors[each])))

        # The part on which the model loses most to its rival; where it loses none, both errors over all parts.
        parts: list[tuple[float, float]] = []
        for own, theirs in zip(errors[name], errors[rival], strict=False):
            parts.append((rms(own), rms(theirs)))
        of_own, of_rival = max(parts, key=lambda pair: pair[0] - pair[1])
        where = "on a part of the training rows that its fit had not seen"
        if of_own <= of_rival:
            of_own = rms(np.concatenate(errors[name]))
            of_rival = rms(np.concatenate(errors[rival]))
            where = "its gain on parts of the training rows that its fit had not seen is too little to tell: there"
        own_error = amount(f"{of_own:.4g}", unit)
        against[name] = f"{where} it errs by {own_error}, {title_of(rival)} by {of_rival:.4g}"
    return against
