"""The digital twin of the brake: clutch CH1 alone, with its output held."""

from __future__ import annotations

from typing import TYPE_CHECKING

from erclutch.wings.live.offered_rig import AskedRig, OfferedRig
from erclutch.wings.live.rigs.twin import served_twin, stepped_twin

if TYPE_CHECKING:
    from erclutch.wings.live.session import ServedRig


def _chosen(asked: AskedRig) -> tuple[ServedRig, None]:
    return served_twin(asked, brake=True), None


RIG = OfferedRig(place=2, chosen=_chosen, stepped=stepped_twin, is_twin=True)
