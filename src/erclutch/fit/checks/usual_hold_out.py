"""What is held out where nobody says: the end of each log, or stretches all over it where the end is another motion.

The end is later than the rows of the fit, as all use is. But the end of a log that is driven faster and faster, say,
has slips that no row before comes near: a model would then be fitted to slow rows, and nobody would see how good it can
be at the fast ones. Field and slip decide; the effort has no say.
"""

from __future__ import annotations

from erclutch.fit.checks.finding import Finding
from erclutch.fit.training_range import share_beyond
from erclutch.logs.covering_stretches import STRETCHES, USUAL_SHARE
from erclutch.logs.dataset import Dataset
from erclutch.logs.held_out import hold_out
from erclutch.signals.percent import percent

#: Share of the rows of the ends that no row before comes near, from which stretches are held out in their place.
BEYOND = 0.1
#: They have to leave that part of it at most.
WORTH = 0.5


def usual_hold_out(data: Dataset) -> tuple[float | tuple[str, ...], tuple[Finding, ...]]:
    """What to hold out, as `hold_out` takes it, and what the user is told where that is not the end of each log."""
    if data.in_no_time:  # points all over the table are held out as it is
        return USUAL_SHARE, ()
    beyond = share_beyond(data, hold_out(data, USUAL_SHARE))
    if beyond < BEYOND:
        return USUAL_SHARE, ()
    if share_beyond(data, hold_out(data, STRETCHES)) > WORTH * beyond:
        return USUAL_SHARE, ()
    message = (
        f"{percent(beyond, 1)} of the last {percent(USUAL_SHARE)} of the rows have a field and slip that no row before "
        "them comes near: stretches all over the log are held out in their place"
    )
    remedy = f"--test {USUAL_SHARE:g} holds out the end"
    return (STRETCHES,), (Finding("note", "held out", message, remedy),)
