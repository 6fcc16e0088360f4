"""The digital twin of the brake: clutch CH1 alone, with its output held."""

from __future__ import annotations

from erclutch.wings.live.offered_rig import OfferedRig
from erclutch.wings.live.rigs.twin import served_twin, stepped_twin

RIG = OfferedRig(
    place=2,
    chosen=lambda asked: (served_twin(asked, brake=True), None),
    stepped=stepped_twin,
    is_twin=True,
)
