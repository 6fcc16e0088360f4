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
_NEXT_TO_NOTHING = 0.01  # of the error


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


def is_law(entry: Mapping[str, Any]) -> bool:
    """Whether a model is a law alone, from its entry in run.json: networks have weights."""
    return not entry["fit"]["weights"]


def stage_names(entry: Mapping[str, Any]) -> tuple[str, ...]:
    """Names of the stages of a model, from its entry in run.json."""
    _law, *parts = specification_of(entry).split("+")
    return tuple(part for part in parts if part != NONE and not is_network(part))


def stages_in(entry: Mapping[str, Any]) -> tuple[Stage, ...]:
    """The stages of a model, from its entry in run.json."""
    chain = "+".join(stage_names(entry))
    return stages_of(chain or NONE)


def stage_values(entry: Mapping[str, Any], stage: Stage) -> dict[str, float]:
    """The numbers of one of a model's stages by name, as the stage computes with them."""
    dynamics = entry["dynamics"]
    return {parameter.name: float(dynamics[parameter.name]) for parameter in stage.parameters(1.0)}


def remembers_slip(entry: Mapping[str, Any]) -> bool:
    """Whether a stage on the slip keeps a state."""
    at_rest = SlipAndStrength(0.0, 1.0)
    for stage in stages_in(entry):
        if stage.place == "slip" and stage.initial(at_rest, stage_values(entry, stage)):
            return True
    return False


def stage_gain(ranking: Sequence[Mapping[str, Any]]) -> StageGain | None:
    """The best model with stages beside the best one that differs in nothing but some of them; None without such.

    Past samples, inputs and the law or network itself are the same in both, so that stages are credited with nothing
    else. Stages that change next to nothing stand for none of the others.
    """
    first: StageGain | None = None
    for entry in ranking:
        stages = stage_names(entry)
        for other in ranking:
            others_stages = stage_names(other)
            if not (
                set(others_stages) < set(stages)
                and _without_stages(other) == _without_stages(entry)
            ):
                continue
            added = tuple(name for name in stages if name not in others_stages)
            gain = StageGain(entry, other, added)
            if abs(_error(other) - _error(entry)) > _NEXT_TO_NOTHING * _error(other):
                return gain
            first = first or gain
    return first


def _error(entry: Mapping[str, Any]) -> float:
    """The RMSE over the rows held out; 0 where it is not finite."""
    return float(entry["test"]["rmse"][0] or 0.0)


def _without_stages(entry: Mapping[str, Any]) -> tuple[list[str], str, str]:
    """The law, the network, or both, of which a name is made; and all else that is no stage: its inputs, its label."""
    first, *others = specification_of(entry).split("+")
    networks = [part for part in others if is_network(part)]
    _, _, label = str(entry["name"]).partition("@")
    return [first, *networks], label, entry.get(APART, "")


def specification_of(entry: Mapping[str, Any]) -> str:
    """The specification of a model, without a label of this run."""
    return str(entry.get(MODEL, entry["name"]))
