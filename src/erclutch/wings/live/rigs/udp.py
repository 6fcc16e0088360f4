"""A rig behind UDP at an address: somebody else's controller that speaks the packets."""

from __future__ import annotations

from typing import TYPE_CHECKING

from erclutch.wings.live.offered_rig import AskedRig, OfferedRig

if TYPE_CHECKING:
    from erclutch.wings.rig.rig_plugins import UdpRig


def _chosen(asked: AskedRig) -> tuple[UdpRig, None]:
    from erclutch.models.load import load_model
    from erclutch.wings.rig.rig_plugins import udp_rig

    device = asked.reading.device or "coaxial"
    if asked.model is not None:
        device = load_model(asked.model).structure.device
    return udp_rig(asked.options.address, asked.options.session, device), None


RIG = OfferedRig(place=4, chosen=_chosen)
