"""``Key: value`` lines above the rows are read as pairs, and the sampling period that some of them state.

They are texts yet; whoever needs a number of them reads it.
"""

from __future__ import annotations

import re
from collections.abc import Iterable

from erclutch.errors import UnitError
from erclutch.logs.columns.labels import split_label
from erclutch.logs.readers.header_remarks import stated_across_a_mark, stated_among_words
from erclutch.signals import units

_PAIR = re.compile(r"\W*([^\d\W][^:=,;\t]{0,60}?)\s*[:=,;\t]\s*(\S.*?)[\s,;]*")
# A quantity that a remark ends in: ``lever arm 0.15 m``.
_REMARK = re.compile(
    r"\W*([^\d\W][^\d:=,;\t]{1,40}?)\s+([+-]?\d+(?:\.\d+)?\s?([^\W\d_][\w/*^·]*))\s*"
)
# A current or a field among the words of a remark: ``brake test with 0.5 A in the coil``.
_AMONG_WORDS = re.compile(
    r"\W*((?:[^\d\W][^:=,;\t]{0,60}?\s)?)([+-]?\d+(?:\.\d+)?\s(?:m?A|m?T|k?V/mm|k?A/m))(?![\w/])([^:=,;\t]*)"
)
# A cell in quotes, with the mark behind it: signs that part keys from values have no meaning in it.
_QUOTED_KEY = re.compile(r'[\s#%/,;]*"((?:[^"]|"")+)"\s*[:=,;\t]\s*(.*)')
_NUMBER_AND_UNIT = re.compile(
    r'([+-]?[\d.]+(?:[eE][+-]?\d+)?)"?\s*[,;\t]\s*"?([^\d\W][^,;\t"]*|[%°][^,;\t"]*)"?'
)
# A decimal comma; three digits behind it may be thousands.
_DECIMAL_COMMA = re.compile(r'([+-]?\d+),(\d{1,2}|\d{4,})("?\s*[;\t].*)')
# A number that a remark gives in the middle of a line.
_ASSIGNMENT = re.compile(
    r"(?<=[,;] )[^\W\d_]\w{0,20} ?= ?[+-]?\d[\d.eE+-]*(?: ?[^\W\d_][\w/*^]*)?(?=[,;]|\.?\s*$)"
)
# Several statements in a line, and one of them: ``LVDT: 25 mm/V; load cell 200 N/V``.
_BETWEEN_STATEMENTS = re.compile(r"[;,]\s+(?=[^\W\d])")
_STATEMENT = re.compile(r"\W*[^\d\W][^:=,;\t]{0,60}?\s*[:=]\s*[^\s:=][^:=]*")
# Words in brackets behind a statement: ``Gear ratio 5:1 (encoder on the motor)``.
_ASIDE = re.compile(r"(?<=\S)\s+\([^()]*\)\s*$")
# Numbers that were multiplied before they were written: ``All values multiplied by 1000``.
_FACTOR = re.compile(
    r"\W*([^\d\W][^:=,;\t]{0,60}?(?:multiplied|divided|scaled|multipliziert|geteilt) (?:by|mit|durch))"
    r"\s+(\d[\d.eE+-]*)\W*"
)
_MOST_PAIRS = 200  # of a header block
#: Of a period without a unit, in s: a larger number may be one of ms.
LONGEST_PERIOD = 0.5
_PERIOD = re.compile(
    r"(?:sampl\w*|scan)[ _-]*(?:interval|period|time)|dt|T_?s|delta[ _]?[tx]|time[ _]?step|"
    r"tick(?:[ _]?(?:period|size|length))?|abtast(?:zeit|intervall|periode)|p[ée]riode d.[ée]chantillonnage|"
    r"periodo de muestreo|periodo di campionamento|"
    r"采样(?:周期|间隔)|サンプリング(?:周期|間隔)|샘플링 ?주기",
    re.I,
)
_OF_SAMPLES = re.compile(r"([kM]?)(?:fps|SPS|[Ff]rames?/s|(?:S|Sa|[Ss]amples?)/s)(?:ec)?$")
_RATE = re.compile(
    r"(?:sampl\w*|scan|acquisition|data|daq|logg\w*|record\w*|poll\w*|frame)?[ _-]*(?:rate|freq\w*)|fs|f_s|fps|"
    r"sampling|(?:sampl|logg|record|acquir|measur)(?:ed|ing) (?:at|with)|"
    r"(?:abtast|mess)(?:rate|frequenz)|fr[ée]quence d.[ée]chantillonnage|frecuencia de muestreo|"
    r"frequenza di campionamento|采样(?:频率|率)|サンプリング(?:周波数|レート)|샘플링 ?(?:주파수|속도)",
    re.I,
)


#: A frequency that nobody calls one of samples may be that of a motion, as of a slow sine or one whose size is stated.
_MAY_BE_OF_A_MOTION = re.compile(r"freq\w*", re.I)
_SLOWEST_OF_SAMPLES = 10.0  # Hz
_SIZE_OF_A_MOTION = re.compile(
    r"(?:.*[\s_-])?(?:ampl\w*|stroke|sine|sinus\w*|waveform|hub|wellenform|course|excitation|motion)(?:[\s_-].*)?",
    re.I,
)


# Of several samples one was kept, or their mean was.
_THINNED = re.compile(
    r"(?:.*[\W_])?(?:decimat|down-?sampl|sub-?sampl|under-?sampl|averag|oversampl)\w*(?:[\W_].*)?",
    re.I,
)
_ONE_OR_NONE = re.compile(r"(?:1(?:\.0*)?(?!\d)|0|no|none|off|false)\b.*", re.I)
# A time of sampling of many seconds is that of the whole log.
_MAY_BE_A_DURATION = re.compile(r"sampl\w*[ _-]*time", re.I)
_OF_CHANNELS = re.compile(
    r"\s*(?:,\s*\d+\s*channels?|(?:per|/|je)\s*(?:channel|ch|kanal))\s*$", re.I
)


def header_pairs(lines: Iterable[str]) -> dict[str, str]:
    """``Key: value`` lines of a header block as texts, the first 200; a number and its unit may stand in two cells."""
    pairs: dict[str, str] = {}
    for line in lines:
        # The parts of a line, where each of them states something; else the line itself.
        parts = _BETWEEN_STATEMENTS.split(line)
        state_all = all(_STATEMENT.fullmatch(part) or _REMARK.fullmatch(part) for part in parts)
        statements = parts if state_all else [line]
        # Behind them the parts of a remark that say ``dt = 0.002 s`` among other words.
        for text in (*statements, *_ASSIGNMENT.findall(line)):
            said = stated_across_a_mark(text) or stated_across_a_mark(_ASIDE.sub("", text))
            match = _QUOTED_KEY.fullmatch(text) or _PAIR.fullmatch(text)
            if said is None and match is None:
                said = stated_among_words(text)
            if said is not None:
                if len(pairs) < _MOST_PAIRS:
                    pairs.setdefault(*said)
                continue
            if match is None:
                remark = _REMARK.fullmatch(text)
                match = remark if remark and units.is_unit(remark.group(3)) else None
                match = match or _FACTOR.fullmatch(text) or _AMONG_WORDS.fullmatch(text)
            if match is None or len(pairs) == _MOST_PAIRS:
                continue
            key, value, *behind = match.groups()
            if match.re is _AMONG_WORDS:
                key = " ... ".join(filter(None, map(str.strip, [key, *behind])))
            value = value.strip(" \t,;")
            cells = value
            comma = _DECIMAL_COMMA.fullmatch(value)
            if comma:
                whole, decimals, rest = comma.groups()
                cells = f"{whole}.{decimals}{rest}"
            number_and_unit = _NUMBER_AND_UNIT.fullmatch(cells)
            if number_and_unit:
                number, unit = number_and_unit.groups()
                value = f"{number} {unit.strip()}"
            pairs.setdefault(key.strip(), value.strip('"'))
    return pairs


def is_called_a_rate(name: str) -> bool:
    """Whether a whole name is that of a sampling rate or a sampling period."""
    return bool(_RATE.fullmatch(name.strip()) or _PERIOD.fullmatch(name.strip()))


def sample_period(pairs: dict[str, str]) -> tuple[float, str] | None:
    """Sampling period in s that a header block states, and the key that states it; an interval wins over a rate.

    None where it states none, and where it says that of several samples one was kept.
    """
    states_a_motion = any(_SIZE_OF_A_MOTION.fullmatch(key) for key in pairs)
    was_thinned = any(
        _THINNED.fullmatch(key) and not _ONE_OR_NONE.fullmatch(value)
        for key, value in pairs.items()
    )
    if was_thinned:  # whether the rate is that before or behind it, nobody says
        return None
    for pattern, usual_unit, power in ((_PERIOD, "s", 1), (_RATE, "Hz", -1)):
        for key, value in pairs.items():
            name, unit_of_key = split_label(key)
            if not pattern.fullmatch(name.strip()):
                continue
            try:
                number, unit_of_value = units.quantity(
                    _OF_SAMPLES.sub(r"\1Hz", _OF_CHANNELS.sub("", value.strip()))
                )
                written = unit_of_value or unit_of_key
                unit = units.parse(written or usual_unit)
            except UnitError:
                continue
            size = number * unit.factor  # in s or Hz
            if _MAY_BE_A_DURATION.fullmatch(name.strip()):  # of the whole log
                is_of_samples = size <= LONGEST_PERIOD
            elif _MAY_BE_OF_A_MOTION.fullmatch(name.strip()):
                is_of_samples = size >= _SLOWEST_OF_SAMPLES and not states_a_motion
            else:
                is_of_samples = True
            may_be_in_ms = not written and power == 1 and number > LONGEST_PERIOD
            is_a_time = unit.dimension == (("second", float(power)),)
            if number > 0 and is_a_time and is_of_samples and not may_be_in_ms:
                return size**power, key
    return None
