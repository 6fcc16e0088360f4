"""Section III-B commands pseudorandom square and sine fields and a pseudorandom square motor torque.

A field is signed: positive goes to CH1, negative to CH2, so only one clutch is ever under field. Half a period of a
square or sine lasts 1 / (2 f). Usable on hardware: the sequence does not look at the rig.
"""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

from erclutch.errors import SettingError
from erclutch.signals.array import Array
from erclutch.wings.rig.twin.parameters import RigParameters


@dataclass(frozen=True)
class FieldSettings:
    """How a field sequence is drawn; a rig file's section [excitation] has the rig's own.

    Attributes:
        largest: largest command (0.5 = 2000 V).
        lowest, highest: frequencies in Hz.
        peakedness: amplitudes are largest x uniform ** peakedness; 1 draws them evenly.
        sines: share of stretches that are sines, the others squares.
        alternating: chance that the next half-period of a square changes side.
        stretch: mean length of a stretch of one kind in s.
    """

    largest: float = 0.5
    lowest: float = 2.0
    highest: float = 100.0
    peakedness: float = 1.0
    sines: float = 0.5
    alternating: float = 0.9
    stretch: float = 1.0

    def __post_init__(self) -> None:
        if not 0 < self.lowest < self.highest or not self.largest > 0:
            given = (
                f"frequencies {self.lowest:g} to {self.highest:g} Hz, amplitude {self.largest:g}"
            )
            raise SettingError(
                given, remedy="Give a lowest frequency below the highest, and an amplitude above 0"
            )


def field_settings(rig: RigParameters, **changes: float) -> FieldSettings:
    """How a rig's field commands are drawn, with some of it changed."""
    names = [one.name for one in fields(FieldSettings)]
    own = {key: value for key, value in rig.section("excitation").items() if key in names}
    return FieldSettings(**{"largest": rig.value("supply.command_limit"), **own, **changes})


def held_peakedness(rig: RigParameters) -> float:
    """Peakedness of the field commands while the output is held (section IV-E)."""
    return rig.value("excitation.peakedness") * rig.value("excitation.held_peakedness")


def field_sequence(
    rows: int,
    rng: np.random.Generator,
    settings: FieldSettings,
    rate: float = 1000.0,
) -> Array:
    """Signed field commands, shape (rows,): stretches of squares and of whole half-sines."""
    out = np.zeros(rows)
    k = 0
    side = 1.0
    while k < rows:
        length = int(rng.exponential(settings.stretch) * rate)
        end = min(k + length + 20, rows)
        sines = rng.random() < settings.sines
        while k < end:
            width = _half_period(rng, settings, rate)
            if not sines:
                other_side = rng.random() < settings.alternating
                side = -side if other_side else float(rng.choice((-1.0, 1.0)))
                out[k : k + width] = side * _amplitude(rng, settings)
                k += width
                continue
            width = max(2, width)
            height = _amplitude(rng, settings)
            for _ in range(int(rng.integers(1, 5))):
                wave = side * height * np.sin(np.pi * np.arange(width) / width)
                out[k : k + width] = wave[: rows - k]
                k += width
                side = -side
                if k >= rows:
                    return out
    return out


def _half_period(rng: np.random.Generator, settings: FieldSettings, rate: float) -> int:
    """Rows of half a period; periods are drawn evenly."""
    half_period = rng.uniform(0.5 / settings.highest, 0.5 / settings.lowest)  # [s]
    return max(1, round(half_period * rate))


def _amplitude(rng: np.random.Generator, settings: FieldSettings) -> float:
    return settings.largest * float(rng.random()) ** settings.peakedness


def torque_sequence(
    rows: int,
    rng: np.random.Generator,
    low: float = 0.04,
    high: float = 0.15,
    rate: float = 1000.0,
    settings: FieldSettings | None = None,
) -> Array:
    """Pseudorandom square motor torque in N m, shape (rows,); frequencies as those of the field."""
    frequencies = settings or FieldSettings()
    out = np.empty(rows)
    k = 0
    while k < rows:
        width = _half_period(rng, frequencies, rate)
        out[k : k + width] = rng.uniform(low, high)
        k += width
    return out


def half_sine_torque(rows: int, rng: np.random.Generator, rig: RigParameters) -> Array:
    """Positive halves of sines of random height and frequency in N m, shape (rows,), as in section IV-D."""
    drawn = rig.section("excitation")
    out = np.zeros(rows)
    k = 0
    while k < rows:
        frequency = rng.uniform(drawn["half_sine_slowest"], drawn["half_sine_fastest"])
        width = int(500.0 / frequency)  # rows of 1 ms
        height = rng.uniform(drawn["half_sine_low"], drawn["half_sine_high"])
        wave = height * np.sin(np.pi * np.arange(width) / width)
        out[k : k + width] = wave[: rows - k]
        k += width
    return out


def both_ways_torque(rows: int, rng: np.random.Generator) -> Array:
    """Squares up to the motor's rated torque, now one way and now the other, so that the slip changes sign."""
    size = torque_sequence(rows, rng, 0.04, 0.30, settings=FieldSettings(highest=20.0))
    side = torque_sequence(rows, rng, -1.0, 1.0, settings=FieldSettings(lowest=0.5, highest=5.0))
    return np.copysign(size, side)
