"""A network is read from its file; numbers and names that no fit can give are refused."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from erclutch.models import model_file
from erclutch.models.law_model import TorqueModel, model_from_dict
from erclutch.models.networks import network_from_name, table_shapes
from erclutch.models.networks.network_inputs import STRENGTH
from erclutch.models.networks.network_model import KIND, NetworkModel, Scaling
from erclutch.models.stages import slip_stages, stages_of
from erclutch.signals.array import Array

_STEEPEST = 10.0  # exponent of the field in a memory's strength


def network_from_dict(
    body: Mapping[str, Any],
    where: str = "model",
    *,
    alone: bool = True,
) -> NetworkModel:
    """The network that `NetworkModel.to_dict` wrote; not alone, it has the strength of the field from its law.

    Raises:
        RunError: another schema, a missing or unfitting entry, or numbers that do not match the digest.
    """
    return model_file.read_model(body, KIND, where, lambda content: _network_from(content, alone))


def _network_from(body: Mapping[str, Any], alone: bool) -> NetworkModel:
    # The inputs tell whether the field is one of them, and past samples of further inputs.
    past = tuple(model_file.whole_number_of(k, "past") for k in body["past"])
    extras = model_file.names_of(body["extras"], "extras")
    made = network_from_name(
        model_file.specification_of(body["network"], "network"),
        model_file.device_of(body),
        dynamics=model_file.specification_of(body["dynamics"]["form"], "dynamics"),
        past=past,
        extras=extras,
    )
    structure = replace(
        made,
        field=body["inputs"][0] == made.inputs[0],
        past_extras=all(f"{name}[-{k}]" in body["inputs"] for k in past for name in extras),
    )
    if list(structure.inputs) != body["inputs"]:
        raise ValueError(f"inputs are {body['inputs']!r:.100}")

    strength: dict[str, float] = {}
    if alone and slip_stages(structure.dynamics):
        for name in STRENGTH:
            strength[name] = model_file.number_of(body["dynamics"][name], name, positive=True)
    if strength.get("n_m", 0.0) > _STEEPEST:
        raise ValueError(f"n_m is {strength['n_m']:g}, above {_STEEPEST:g}")
    scaling = body["scaling"]
    count = len(structure.inputs)
    weights: dict[str, Array] = {}
    for name, shape in table_shapes(structure).items():
        weights[name] = model_file.table_of(body["weights"][name], name, *shape)
    # Squared, so the sign has no say.
    if np.any(np.abs(weights.get("spreads", 1.0)) < model_file.SMALLEST):
        raise ValueError("a spread is 0")
    period: float | None = None
    if "period_s" in body:
        period = model_file.number_of(body["period_s"], "period_s", positive=True)
    units = model_file.units_of(body)
    beyond: TorqueModel | None = None
    if "beyond" in body:
        beyond = model_from_dict(body["beyond"])
    if beyond is not None and (beyond.structure.device, beyond.units) != (structure.device, units):
        raise ValueError(
            f"the law {beyond.name} beyond the rows is of another device or has other units"
        )
    if beyond is not None and not set(beyond.extras) <= set(structure.extras):
        raise ValueError(
            f"the law {beyond.name} beyond the rows has inputs that the network has not"
        )
    # Numbers of the stages; those in the unit of the slip may be as large as they like.
    stage_numbers: dict[str, float] = {}
    for stage in stages_of(structure.dynamics):
        for parameter in stage.parameters(period or model_file.LONGEST_PERIOD):
            name = parameter.name
            value = model_file.number_of(body["dynamics"][name], name, positive=parameter.lower > 0)
            least = min(0.0, parameter.lower)  # a yield effort may rise with the temperature
            too_large = not parameter.dimension.slip and value > parameter.upper
            if value < least or too_large:
                raise ValueError(f"{name} is {value:g}, not from {least:g} to {parameter.upper:g}")
            stage_numbers[name] = value
    ranges = [
        model_file.pair_of(body["input_range"][place], "range of an input")
        for place in range(count)
    ]
    return NetworkModel(
        structure=structure,
        scaling=Scaling(
            offset=model_file.table_of(scaling["offset"], "offset", count),
            scale=model_file.table_of(scaling["scale"], "scale", count, positive=True),
            effort_offset=model_file.number_of(scaling["effort_offset"], "effort_offset"),
            effort_scale=model_file.number_of(scaling["effort_scale"], "effort_scale"),
        ),
        weights=weights,
        dynamics={**stage_numbers, **strength},
        units=units,
        trained_on=model_file.range_of(body),
        input_range=np.array(ranges),
        about=model_file.about_of(body),
        period=period,
        beyond=beyond,
        near=model_file.near_of(body.get("near", ()), structure.device),
    )
