"""What a law makes of a log once its effort is turned, where the effort opposes the slip as it is."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from erclutch.fit.checks.finding import Finding
from erclutch.fit.choice.standing import NEXT_TO_NOTHING
from erclutch.fit.fit_settings import AUTO, Settings
from erclutch.fit.kinds.law_alone import LawCandidate, structures_of, with_memory
from erclutch.fit.solver.outcome import AnyOutcome
from erclutch.logs.dataset import Dataset
from erclutch.models.stages import NONE
from erclutch.signals.array import Array, Mask, rms
from erclutch.signals.percent import percent


def with_turned_fit(
    finding: Finding,
    data: Dataset,
    test: Mask,
    settings: Settings,
    outcomes: Sequence[AnyOutcome],
) -> Finding:
    """The finding that a sign is wrong, with what a law makes of the log once its effort is turned.

    Where neither way explains anything, no sign is in question.
    No law can follow an effort that opposes the slip, so the ranking of such a log says nothing of what the turned log
    would give. One law is fitted to it, with memory as far as the rows ask for it.
    """
    turned = replace(data, effort=-data.effort)
    train = turned.take(~test)
    stages = settings.lag if settings.lag != AUTO else NONE
    plain = structures_of(turned, settings, [("bingham", stages)])
    base = [LawCandidate(structure).fit(train, (), 1) for structure in plain]
    law = base[-1]
    if settings.lag in (AUTO, NONE):
        remembering, _ = with_memory(train, base)
        if remembering:
            law = remembering[-1].fit(train, (), 1)
    error: Array = turned.effort - law.model.predict(turned)
    spread = float(np.std(data.effort[test])) or 1.0
    share = rms(error[test]) / spread

    # What laws of the log as it is make of the training rows.
    mean_squares = [
        outcome.train_cost / outcome.train_rows for outcome in outcomes if not outcome.weights
    ]
    as_it_is = min(mean_squares, default=np.inf) ** 0.5
    spread_of_training = float(np.std(data.effort[~test])) or 1.0
    share_as_it_is = as_it_is / spread_of_training
    share_turned = (law.train_cost / law.train_rows) ** 0.5 / spread_of_training
    if min(share_as_it_is, share_turned) > NEXT_TO_NOTHING:
        # Noise opposes the slip as often as not: to turn it would bring nobody on.
        message = f"{finding.message}, but no law explains the training rows with either sign"
        return Finding(
            "warning",
            "explained",
            message,
            "Look at the columns and their units: a wrong one may be noise",
        )
    if share_as_it_is <= share_turned:
        # A zero that is off, or a device that drives, opposes the slip too: to turn the sign would bring nobody on.
        message = (
            f"{finding.message}, but a law of the log as it is errs by {percent(share_as_it_is)} of the standard "
            f"deviation on the training rows, and {law.model.name} by {percent(share_turned)} with the effort turned"
        )
        return Finding(
            "warning",
            "power",
            message,
            "Check the zero of the effort's sensor, and whether the device drives",
        )
    message = (
        f"{finding.message}; with the effort turned, {law.model.name} errs by {percent(share_turned)} of the standard "
        f"deviation on the training rows and by {percent(share, 1)} on the rows held out; no law of the log as it is "
        f"errs by less than {percent(share_as_it_is)} on the training rows"
    )
    return replace(finding, message=message)
