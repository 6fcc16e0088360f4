"""What a rheometer gives may be no signal of a device: moduli, an oscillation, a shear rate beside a torque."""

from __future__ import annotations

from erclutch.logs.columns.rheometer_names import of_oscillation, said_by_name
from erclutch.logs.columns.shapes import takes_both_signs
from erclutch.logs.planning.draft import Draft

#: How the frequency of a sine is written that a speed of turning is written like, too.
_OMEGAS = frozenset({"ω", "omega", "w"})


def pass_over_oscillations(draft: Draft) -> None:
    """Take what a rheometer's oscillation fills for no signal: moduli, amplitudes of stresses in Pa, its frequency.

    The stress itself goes to and fro. The omega of a sine is no speed.
    """
    moduli = of_oscillation(draft.table.columns)
    if not moduli:
        return
    amplitudes: list[str] = []
    for column in draft.seen.columns.values():
        is_a_size = not takes_both_signs(column.values)
        is_an_omega = column.spoken.plain_stem in _OMEGAS
        if is_a_size and (column.fits(("Pa",)) or is_an_omega):
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
