"""What run.json says of the stages of a model, whatever the chain: which there are, and what they gain."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from erclutch.models.networks import is_network
from erclutch.models.stages import NONE, stages_of
from erclutch.models.stages.stage import SlipAndStrength, Stage

#: Key of an entry that stands for a model of another run under a name of its own: the model's name there.
MODEL = "model"
#: Key of such an entry: all that changes the model and is no stage, as text.
APART = "apart"


@dataclass(frozen=True)
class StageGain:
    """Two entries that differ in stages alone.

    Attributes:
        richer, plainer: the entries.
        added: names of the stages that only the richer one has.
    """

    richer: Mapping[str, Any]
    plainer: Mapping[str, Any]
    added: tuple[str, ...]


def stage_names(entry: Mapping[str, Any]) -> tuple[str, ...]:
    """Names of the stages of a model, from its entry in run.json."""
    return tuple(name for name in _name(entry).split("+")[1:] if name != NONE and not is_network(name))


def stages_in(entry: Mapping[str, Any]) -> tuple[Stage, ...]:
    """The stages of a model, from its entry in run.json."""
    return stages_of("+".join(stage_names(entry)) or NONE)


def stage_values(entry: Mapping[str, Any], stage: Stage) -> dict[str, float]:
    """The numbers of one of a model's stages by name, as the stage computes with them."""
    return {p.name: float(entry["dynamics"][p.name]) for p in stage.parameters(1.0)}


def remembers_slip(entry: Mapping[str, Any]) -> bool:
    """Whether a stage on the slip keeps a state."""
    return any(
        stage.place == "slip" and stage.initial(SlipAndStrength(0.0, 1.0), stage_values(entry, stage))
        for stage in stages_in(entry)
    )


def stage_gain(ranking: Sequence[Mapping[str, Any]]) -> StageGain | None:
    """The best model with stages beside the best one that differs in nothing but some of them; None without such.

    Past samples, inputs and the law or network itself are the same in both, so that stages are credited with nothing
    else.
    """
    for entry in ranking:
        own = stage_names(entry)
        plainer = [e for e in ranking if _alike(e, entry) and set(stage_names(e)) < set(own)]
        if plainer:
            added = tuple(name for name in own if name not in stage_names(plainer[0]))
            return StageGain(entry, plainer[0], added)
    return None


def _alike(one: Mapping[str, Any], other: Mapping[str, Any]) -> bool:
    return _without_stages(one) == _without_stages(other) and one.get(APART, "") == other.get(APART, "")


def _without_stages(entry: Mapping[str, Any]) -> list[str]:
    """The law, the network, or both, of which a name is made."""
    first, *others = _name(entry).split("+")
    return [first, *filter(is_network, others)]


def _name(entry: Mapping[str, Any]) -> str:
    return str(entry.get(MODEL, entry["name"]))
