"""The chosen model once more, fitted to all rows: nothing is left to judge it, so it stands beside the judged one.

What was chosen stays chosen: law, stages, size of a network and the share of it that is kept. Only the numbers move.
Its band is that of the judged model, whose errors on rows that it had not seen are known.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from erclutch.errors import SettingError
from erclutch.fit.comparison import Comparison


def with_final_fit(comparison: Comparison) -> Comparison:
    """The comparison with its recommended model refitted on all rows, those held out included.

    Raises:
        SettingError: no model is recommended, or the comparison does not know how its models are fitted.
        CheckError: all rows cannot make the model.
    """
    name = comparison.recommended
    why_none = comparison.standing.why_none
    if why_none or name not in comparison.candidates:
        problem = f"{name} {why_none or 'cannot be fitted again'}, so it is not fitted to all rows"
        raise SettingError(problem, where="--final", remedy="Leave --final out")
    judged: Any = comparison.entry(name).outcome
    final = comparison.candidates[name].fit_again(comparison.data, judged)
    model = replace(final.model, band=judged.model.band)
    return replace(comparison, final=replace(final, model=model))
