"""The rows that a model is asked about are of its device, in its units, at its rate, with all of its further inputs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from erclutch.errors import ErclutchError, MappingError, shell_word
from erclutch.models.model import Model, Rows
from erclutch.signals.array import Array
from erclutch.signals.recording import POSITION, TEMPERATURE
from erclutch.signals.units import UNKNOWN

_SAME_PERIOD = 0.01  # share by which a log's period may differ from the model's
#: How the further inputs with a name of their own are given.
_NAMED = {
    TEMPERATURE: "Name its column with --temperature",
    POSITION: "Name its column with --position, beside that of --slip",
}


def require_same_signals(model: Model, data: Rows) -> None:
    """Refuse rows of another device, in other units or at another rate than those that a model was trained on.

    Past samples are rows: at another sampling rate they would be other instants.

    Raises:
        ErclutchError: they are.
    """
    device = model.structure.device
    units = model.units
    if units.field == UNKNOWN and data.units.field == "":
        # A model of a field without a stated unit also takes a field that has no dimension.
        units = replace(units, field="")
    if data.device != device:
        raise ErclutchError(
            f"data of device {data.device} ({data.units.text()}) for a model of {device} ({model.units.text()})",
            where=model.name,
            remedy="Read the log with the device of the training data",
        )
    if data.units != units:
        where: str = getattr(data, "where", model.name)  # rows of a caller's own may not know
        problem = (
            f"{data.units.text()}, for the model {model.name} of a log with {model.units.text()}"
        )
        here: list[str] = []  # options for the log that is read now
        at_home: list[str] = []  # and for that of the model
        for signal in ("field", "slip", "effort"):
            given_unit: str = getattr(data.units, signal)
            wanted_unit: str = getattr(units, signal)
            if given_unit == wanted_unit:
                continue
            options, told = (at_home, given_unit) if wanted_unit == UNKNOWN else (here, wanted_unit)
            column = f"COLUMN [{told or '-'}]"
            options.append(f"--{signal} {shell_word(column)}")
        which = "these columns" if len(here) > 1 else "this column"
        remedy = f"Read the log in the model's units; if it says none and is in them, name {which}: {' '.join(here)}"
        if at_home:
            remedy = f"Fit the model's own log again with its units, such as {' '.join(at_home)}"
        raise ErclutchError(problem, where=where, remedy=remedy)
    # Rows of a caller's own may know none.
    given_units: Mapping[str, str] = getattr(data, "extra_units", {})
    for name, unit in model.extra_units.items():
        given = given_units.get(name, UNKNOWN)
        if UNKNOWN not in (unit, given) and given != unit:
            raise ErclutchError(
                f"the further input {name} is in {given}, for a model of it in {unit}",
                where=model.name,
                remedy="Read the log with the unit of the training data",
            )
    own = model.period if model.past else None
    if not own:
        return
    for span in data.clock.spans:
        if span.period and abs(span.period - own) > _SAME_PERIOD * own:
            raise ErclutchError(
                f"rows at {1 / span.period:.6g} Hz for a network with past samples at {1 / own:.6g} Hz",
                where=model.name,
                remedy=f"Read the log with --resample {1 / own:.6g}",
            )


def further_inputs(names: Sequence[str], given: Mapping[str, Array]) -> dict[str, Array]:
    """The further inputs that a model needs, out of those of some rows.

    Raises:
        MappingError: one is not there.
    """
    for name in names:
        if name not in given:
            known = ", ".join(given) or "none"
            raise MappingError(
                f"the model's input {name!r} is not in these rows (further inputs here: {known})",
                remedy=_NAMED.get(name, f"Read the log with --input {shell_word(name)}"),
            )
    return {name: given[name] for name in names}
