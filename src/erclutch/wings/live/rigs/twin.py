"""The digital twin of the paper's rig, in a process of its own; of a single device where the model is of one."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from erclutch.wings.live.offered_rig import AskedRig, OfferedRig

if TYPE_CHECKING:
    from erclutch.wings.live.session import ServedRig
    from erclutch.wings.rig.interface import SteppedRig


def served_twin(asked: AskedRig, *, brake: bool) -> ServedRig:
    """The twin of the pair, or of the brake CH1 alone with its output held."""
    from erclutch.signals.channels import NamedChannels
    from erclutch.signals.device import Units
    from erclutch.wings.live.session import ServedRig

    spec: dict[str, Any] = {
        "kind": "twin",
        "seed": asked.options.seed,
        "single": brake,
        "locked": brake,
    }
    if asked.options.rig_file is not None:
        spec["rig_file"] = str(asked.options.rig_file.resolve())
    named = NamedChannels({}, Units("N*m", "", "rad/s"), motor=True, sensor=True)
    return ServedRig("twin-brake" if brake else "twin", "TWIN", spec, named)


def _chosen(asked: AskedRig) -> tuple[ServedRig, None]:
    from erclutch.models.load import load_model

    single = asked.model is not None and load_model(asked.model).structure.device == "single"
    return served_twin(asked, brake=single), None


def stepped_twin(spec: Mapping[str, Any]) -> tuple[SteppedRig, float]:
    """The twin of a specification, ready to be stepped, and its lead in m."""
    from erclutch.wings.rig.interface import RigCommand
    from erclutch.wings.rig.twin.parameters import load_rig
    from erclutch.wings.rig.twin.twin import Twin

    rig = load_rig(spec.get("rig_file") or None)
    warm = Twin(rig)
    warm.command(RigCommand(0.1, 0.0, 0.1))
    for _ in range(3):  # compiled now, not in the first step
        warm.step()
    twin = Twin(
        rig,
        seed=int(spec.get("seed", 0)),
        locked=bool(spec.get("locked", False)),
        single=bool(spec.get("single", False)),
        speed=float(spec.get("speed", 0.0)),
    )
    return twin, rig.value("screw.lead")


RIG = OfferedRig(place=1, chosen=_chosen, stepped=stepped_twin, is_twin=True)
