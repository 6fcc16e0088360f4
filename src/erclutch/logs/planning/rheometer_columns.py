"""What a rheometer gives may be no signal of a device: moduli, an oscillation, a shear rate beside a torque."""

from __future__ import annotations

from erclutch.logs.columns.rheometer_names import of_oscillation, said_by_name
from erclutch.logs.columns.shapes import takes_both_signs
from erclutch.logs.planning.draft import Draft


def pass_over_oscillations(draft: Draft) -> None:
    """Take what a rheometer's oscillation fills for no signal: moduli, and amplitudes of stresses, in Pa.

    The stress itself goes to and fro.
    """
    moduli = of_oscillation(draft.table.columns)
    if not moduli:
        return
    amplitudes: list[str] = []
    for column in draft.seen.columns.values():
        if column.fits(("Pa",)) and not takes_both_signs(column.values):
            amplitudes.append(column.name)
    named = draft.taken
    draft.no_signals += [
        name for name in dict.fromkeys([*moduli, *amplitudes]) if name not in named
    ]


def doubt_a_shear_rate_beside_a_torque(draft: Draft) -> None:
    """Doubt a guessed slip that is a shear rate beside a torque or a force, which make no power together."""
    effort = draft.signals.get("effort")
    slip = draft.guessed("slip")
    if effort is None or slip is None:
        return
    is_called_a_rate = said_by_name(slip.column) == "rate"
    is_rate = is_called_a_rate and draft.seen.columns[slip.column].fits(("1/s",))
    if is_rate and effort.si in ("N*m", "N"):
        doubt = f"which is a shear rate, beside a torque or a force in {effort.si}"
        draft.doubt("slip", doubt)


def doubt_an_oscillation(draft: Draft) -> None:
    """Doubt a guessed effort beside the moduli of an oscillation: a rheometer gives the sizes of its sines."""
    effort = draft.guessed("effort")
    swings = of_oscillation(draft.seen.columns)
    if effort is not None and len(swings) > 1:
        draft.doubt(
            "effort", f"which is of an oscillation of a rheometer, beside {', '.join(swings[:3])}"
        )
