"""Whether a run recommends a model at all is decided here; terminal, report, tables, app, export and live ask.

The training rows choose a model (`fit.choice.validation`). It is recommended only if it explains rows held out, and if
nobody has to settle a sign first. Otherwise it is the nearest one, and whoever wants it has to name it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from erclutch.fit.checks.effort_and_slip import SIGN

#: Error as a share of the standard deviation from which a model explains next to nothing.
NEXT_TO_NOTHING = 0.95
#: The same that nothing but an effort which stands still over these rows makes.
_STANDS_STILL = 1e100


@dataclass(frozen=True)
class Standing:
    """What the chosen model of a comparison is.

    Attributes:
        sound: whether its fit converged and the data identify all that it says.
        why_none: why no model is recommended, "" where there is no such reason: the end of a sentence about the model.
        sign_open: whether the reason is a sign that is not settled.
    """

    sound: bool
    why_none: str
    sign_open: bool = False

    @property
    def word(self) -> str:
        """What to call the chosen model: recommended, or nearest."""
        return "recommended" if self.sound and not self.why_none else "nearest"


def explains(share: float | None, r2_low: float | None) -> bool:
    """Whether a model explains rows that it has not seen; one that does not is never recommended.

    Args:
        share: RMSE over the standard deviation of the effort; None: not finite.
        r2_low: lower end of the 95 % band of R2; None: not finite.
    """
    return share is not None and r2_low is not None and share <= NEXT_TO_NOTHING and r2_low > 0.0


def standing(chosen: Mapping[str, Any], subjects: set[str]) -> Standing:
    """What the chosen model is.

    Args:
        chosen: its entry in the ranking of a run, as JSON values.
        subjects: of the findings of the run.
    """
    if SIGN in subjects:
        return Standing(
            bool(chosen["sound"]),
            "was fitted before the sign of the effort is settled",
            sign_open=True,
        )
    share, *_ = chosen["test"]["share"]
    _, r2_low, _ = chosen["test"]["r2"]
    why_none = ""
    if not explains(share, r2_low):
        # Few rows, or rows that are all alike, leave open what a model explains that errs by little on them.
        little = share is not None and share <= NEXT_TO_NOTHING
        what = "cannot be told from a constant on" if little else "explains nothing of"
        why_none = f"{what} the rows held out"
        if share is not None and share > _STANDS_STILL:
            why_none += ", over which the measured effort stands still"
    return Standing(bool(chosen["sound"]), why_none)


def standing_of_run(body: Mapping[str, Any]) -> Standing:
    """The standing of a run (JSON values): of the model that its training rows chose, else of the best."""
    chosen = next(entry for entry in body["ranking"] if entry["name"] == chosen_name(body))
    if not body["recommended"]:
        return Standing(bool(chosen["sound"]), "was chosen by nothing")
    return standing(chosen, {finding["subject"] for finding in body["findings"]})


def chosen_name(body: Mapping[str, Any]) -> str:
    """The model that stands for a run, as JSON values: the chosen one, else the best."""
    return str(body["recommended"] or body["best"])
