"""The step of a network alone that gives way to a law where no training row was near.

In C a row pays for what it takes: the network, the law, or both. So each of these is an arm of a choice of C, and a
function of its own.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from erclutch.models.model import GivesWay
from erclutch.models.near_cells import faded

Groups = Sequence[Sequence[Any]]


def given_way(
    network: GivesWay,
    effort: Any,
    given: Groups,
    again: Callable[..., Any] | None,
) -> Any:
    """The effort of a network amid training rows, and that of its law where there were none.

    Args:
        network: with a law beyond its rows.
        effort: of the network.
        given: fields in the fluid, slips and further inputs.
        again: records the network's effort from a record and these groups; None for a network with past rows or a
            memory, which has run already.
    """
    counts = [len(group) for group in given]

    def grouped(signals: Sequence[Any]) -> list[list[Any]]:
        """Arguments of a function of C as groups again."""
        own = iter(signals)
        return [[next(own) for _ in range(count)] for count in counts]

    def between(share: Any, law: Any, *signals: Any) -> Any:
        """Where training rows are near, but not all around: the network runs here, and only here, beside the law."""
        assert again is not None
        return faded(again(share.owner, *grouped(signals)), law, share)

    def away_from_rows(*signals: Any) -> Any:
        groups = grouped(signals)
        share = network.nearness.share(*groups)
        law = network.law_beyond(*groups)
        record = share.owner
        if again is None:
            of_network = signals[-1]  # its effort comes behind the groups
            both = faded(of_network, law, share)
        else:
            both = record.call("both", between, share=share, law=law, **named_groups("xwv", groups))
        return record.choose(record.less(0.0, share), both, law)

    record = effort.owner
    signals = named_groups("xwv", given)
    if again is None:
        signals["network"] = effort
    beside = record.call("away", away_from_rows, **signals)
    return record.choose(network.nearness.amid(*given), effort, beside)


def named_groups(letters: str, groups: Groups) -> dict[str, Any]:
    """Arguments of a call: the signals of each group by its letter and their number."""
    return {
        f"{letter}{number}": signal
        for letter, group in zip(letters, groups, strict=True)
        for number, signal in enumerate(group, start=1)
    }
