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


def given_way(network: GivesWay, effort: Any, given: Groups, again: Callable[..., Any] | None) -> Any:
    """The effort of a network amid training rows, and that of its law where there were none.

    Args:
        network: with a law beyond its rows.
        effort: of the network.
        given: fields in the fluid, slips and further inputs.
        again: records the network's effort from a record and these groups; None for a network with past rows or a
            memory, which has run already.
    """
    counts, record = [len(group) for group in given], effort.owner

    def parts(signals: Sequence[Any]) -> list[list[Any]]:
        own = iter(signals)
        return [[next(own) for _ in range(count)] for count in counts]

    def mixed(share: Any, law: Any, *signals: Any) -> Any:
        assert again is not None
        return faded(again(share.owner, *parts(signals)), law, share)

    def away(*signals: Any) -> Any:
        groups = parts(signals)
        share, law = network.nearness.share(*groups), network.law_beyond(*groups)
        inside = share.owner
        if again is None:
            both = faded(signals[-1], law, share)
        else:
            both = inside.call("both", mixed, share=share, law=law, **named_groups("xwv", groups))
        return inside.choose(inside.less(0.0, share), both, law)

    own = {"network": effort} if again is None else {}
    beside = record.call("away", away, **named_groups("xwv", given), **own)
    return record.choose(network.nearness.amid(*given), effort, beside)


def named_groups(letters: str, groups: Groups) -> dict[str, Any]:
    """Arguments of a call: the signals of each group by its letter and their number."""
    return {f"{a}{i + 1}": x for a, group in zip(letters, groups, strict=True) for i, x in enumerate(group)}
