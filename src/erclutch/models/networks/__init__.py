"""A network gives the effort of the whole device from its inputs, with no law inside, from tables of weights.

A specification is ``fnn-16`` (one hidden layer of 16), ``fnn-10-6`` (two layers), ``rbfn-50`` (50 neurons, one spread,
centres by forward selection), and after a slash for the RBFN: ``kmeans`` centres, ``refined`` centres and spread by
Levenberg-Marquardt, ``spreads`` refined with one spread a neuron.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, cast

from erclutch.errors import SettingError
from erclutch.models.stages import NONE, canonical, slip_stages
from erclutch.signals.device import WAYS_OF, DeviceName, names_in_elements

NetworkKind = Literal["fnn", "rbfn"]
Centres = Literal["forward", "kmeans", "refined", "spreads"]

#: The networks of table II; `models.laws.PAPER` are its laws.
PAPER_NETWORKS = ("rbfn-10", "rbfn-50", "fnn-6", "fnn-16", "fnn-10-6")

MOST_NEURONS = 500  # in a layer
MOST_PAST = 1000  # rows back
_FORMS: tuple[Centres, ...] = ("forward", "kmeans", "refined", "spreads")


@dataclass(frozen=True)
class NetworkStructure:
    """What is fitted, without numbers.

    Attributes:
        device: "single" or "coaxial".
        specification: name of the network, for example ``fnn-16``.
        kind: fnn (equations 19, 20) or rbfn (equations 17, 18).
        hidden: neurons of each hidden layer.
        centres: how an RBFN's centres are found.
        dynamics: names of the stages on command, slip and effort, joined by ``+``. Their constants are given to a
            network, not fitted with it.
        past: rows back that are inputs too, for example (1, 2).
        extras: names of further logged inputs.
        field: whether the field is an input; without, the network knows the one field of its log and no other.
        past_extras: whether past samples of the further inputs are inputs too.
    """

    device: DeviceName
    specification: str
    kind: NetworkKind
    hidden: tuple[int, ...]
    centres: Centres = "forward"
    dynamics: str = NONE
    past: tuple[int, ...] = ()
    extras: tuple[str, ...] = ()
    field: bool = True
    past_extras: bool = True

    @property
    def title(self) -> str:
        """Name for people."""
        count = ", ".join(str(n) for n in self.hidden)
        how = "" if self.centres == "forward" else f", {self.centres}"
        return f"{self.kind.upper()} ({count} neuron{'s' if self.hidden != (1,) else ''}{how})"

    @property
    def inputs(self) -> tuple[str, ...]:
        """Names of the inputs, in their order."""
        base = base_inputs(self.device, self.kind, field=self.field)
        recalled = (*base, *self.extras) if self.past_extras else base
        past: list[str] = []
        for rows in self.past:
            past += [f"{name}[-{rows}]" for name in recalled]
        return (*base, *past, *self.remembered, *self.extras)

    @property
    def remembered(self) -> tuple[str, ...]:
        """Names of the inputs that stages on the slip give, elements one after another."""
        names: list[str] = []
        for element in range(len(WAYS_OF[self.device])):
            for stage in slip_stages(self.dynamics):
                names += [names_in_elements(self.device, name)[element] for name in stage.outputs]
        return tuple(names)


def base_inputs(
    device: DeviceName,
    kind: NetworkKind,
    *,
    field: bool = True,
) -> tuple[str, ...]:
    """Inputs of equation (18) for the RBFN, (20) for the FNN; field and slip of a single device; or without field."""
    if device == "single":
        inputs = ("field", "slip")
    else:
        inputs = ("E1-E2", "w1", "w2") if kind == "rbfn" else ("E1-E2", "theta_dot", "alpha_dot")
    return inputs if field else inputs[1:]


def is_network(specification: str) -> bool:
    """Whether a specification names a network (it may still be a wrong one)."""
    kind = specification.strip().lower().partition("-")[0]
    return kind in ("fnn", "rbfn")


def network_from_name(
    specification: str,
    device: DeviceName = "coaxial",
    *,
    dynamics: str = NONE,
    past: tuple[int, ...] = (),
    extras: tuple[str, ...] = (),
    field: bool = True,
) -> NetworkStructure:
    """The network for a specification such as ``fnn-10-6`` or ``rbfn-50/refined``.

    Raises:
        SettingError: no neurons, too many, or a word that is not known.
    """
    name, _, form = specification.strip().lower().partition("/")
    kind, *sizes = name.split("-")
    if (
        not sizes
        or not all(size.isdecimal() and len(size) < 10 for size in sizes)
        or kind not in ("fnn", "rbfn")
    ):
        raise SettingError(
            f"unknown network {specification!r}", remedy="Write fnn-16, fnn-10-6 or rbfn-50"
        )
    hidden = tuple(int(size) for size in sizes)
    if min(hidden) < 1 or max(hidden) > MOST_NEURONS:
        wrong = min(hidden) if min(hidden) < 1 else max(hidden)
        raise SettingError(
            f"a layer of {wrong} neurons in {specification!r}",
            remedy=f"Give each layer 1 to {MOST_NEURONS} neurons",
        )
    if kind == "rbfn" and (len(hidden) > 1 or (form and form not in _FORMS)):
        raise SettingError(
            f"an RBFN has one layer and one of {', '.join(_FORMS)}, got {specification!r}",
            remedy="Write rbfn-50 or rbfn-50/refined",
        )
    if kind == "fnn" and (form or len(hidden) > 5):
        raise SettingError(
            f"unknown network {specification!r}",
            remedy="Write fnn-16 or fnn-10-6, at most 5 layers",
        )
    if any(not 1 <= rows <= MOST_PAST for rows in past):
        raise SettingError(f"past samples {past}", remedy=f"Give 1 to {MOST_PAST} rows back")
    name = "-".join([kind, *map(str, hidden)])
    if form and form != "forward":
        name += f"/{form}"
    centres = cast(Centres, form or "forward")
    return NetworkStructure(
        device, name, kind, hidden, centres, canonical(dynamics), past, extras, field
    )


def table_shapes(structure: NetworkStructure) -> dict[str, tuple[int, ...]]:
    """Shape of each table of weights, in their order."""
    inputs = len(structure.inputs)
    if structure.kind == "rbfn":
        neurons = structure.hidden[0]
        return {
            "centres": (neurons, inputs),
            "spreads": (neurons,),
            "w": (neurons,),
            "b": (1,),
        }
    shapes: dict[str, tuple[int, ...]] = {}
    before = inputs
    for layer, neurons in enumerate(structure.hidden, start=1):
        shapes[f"W{layer}"] = (neurons, before)
        shapes[f"b{layer}"] = (neurons,)
        before = neurons
    shapes["W_out"] = (1, before)
    shapes["b_out"] = (1,)
    return shapes
