"""A table may have a row for each test: names of its columns say what is the largest, smallest or mean of a test."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from typing import NamedTuple

from erclutch.logs.columns.names import spoken_name
from erclutch.logs.columns.vocabulary import set_of

PEAKS = ("max", "maximum", "maximal", "peak", "pk", "spitze", "pic", "pico", "picco")
MEANS = ("mean", "avg", "average", "mittel", "mittelwert", "moyenne", "moyen", "media", "medio")
LEAST = ("min", "minimum")
#: What a test is summed up by; at a point at rest or at the turn of a motion the earlier words say more.
WORDS = (*PEAKS, *MEANS, "rms", *LEAST, "std", "stdev", "stddev", "sd", "var", "ptp", "pp")
#: Of those the words for a spread, which is no value of the signal.
SPREADS = frozenset({"std", "stdev", "stddev", "sd", "var"})
_BEHIND = re.compile(
    rf"(.*[^\W_])[_ .-]*(?:\b|_|(?<=[a-z])(?=[A-Z])|(?<=^.))({'|'.join(WORDS)})", re.I
)
_IN_FRONT = re.compile(rf"({'|'.join(WORDS)})[_ .-]+([^\W\d_].*)", re.IGNORECASE)
_AMPLITUDES = set_of("amplitude ampl amplitud amplitudine ampiezza amplituda")
_FREQUENCIES = set_of("frequency freq frequenz frequence frecuencia frequencia frequenza f hz")
#: Rows of a table of tests at most.
MOST_TESTS = 1000


class SumOfATest(NamedTuple):
    """What a column sums up, and by which word: ``force`` and ``peak``."""

    called: str
    word: str


def sum_of_a_test(name: str) -> SumOfATest | None:
    """What a name says that was summed up: of ``Peak force``, ``Fmax`` and ``speed_mean``; None for other names."""
    stem = spoken_name(name).stem.strip()
    if len(stem) > 60:
        return None
    match = _IN_FRONT.fullmatch(stem)
    if match is not None:
        return SumOfATest(match[2], match[1].lower())
    match = _BEHIND.fullmatch(stem)
    return None if match is None else SumOfATest(match[1].rstrip("_ .-"), match[2].lower())


def sums_of(names: Iterable[str], signal: str) -> dict[str, str]:
    """Columns that sum up a signal, with the word by which they do, but for those of a spread."""
    sums: dict[str, str] = {}
    for name in names:
        summed = sum_of_a_test(name)
        if summed is None or summed.word in SPREADS:
            continue
        said = spoken_name(summed.called)
        if said.forms[signal] or signal in said.may_be:
            sums[name] = summed.word
    return sums


def amplitude_and_frequency(names: Mapping[str, str | None]) -> tuple[str, str] | None:
    """The only two columns that are called an amplitude and a frequency, by names with units; None for none.

    Args:
        names: units of columns by name.
    """
    amplitudes: list[str] = []
    frequencies: list[str] = []
    for name, unit in names.items():
        said = spoken_name(name)
        unit_of_name = unit or said.end
        if said.says(_AMPLITUDES) and unit_of_name not in ("Hz", "A", "V", "N"):
            amplitudes.append(name)
        if said.plain_stem in _FREQUENCIES and unit_of_name in (None, "", "Hz"):
            frequencies.append(name)
    if len(amplitudes) != 1 or len(frequencies) != 1:
        return None
    return amplitudes[0], frequencies[0]
