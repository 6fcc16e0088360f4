"""Names and units are read from the labels of columns, one by one and of all columns together."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Collection, Iterable, Sequence

from erclutch.errors import LogError, printable
from erclutch.logs.columns.label_forms import in_usual_form
from erclutch.logs.columns.name_ends import ENDS, TIMES, in_other_letters, split_end
from erclutch.logs.columns.unit_behind_word import split_behind_word
from erclutch.logs.columns.vocabulary import set_of
from erclutch.logs.columns.words_behind_units import without_words_behind
from erclutch.signals import units

_LONGEST = 1000  # letters of a name: to understand a name takes the square of its length
_SQUARE = re.compile(r"(.+?)\s*\[([^\[\]]*)\]", re.DOTALL)
_ROUND = re.compile(r"(.+?)\s*\(([^()]*)\)", re.DOTALL)
_CURLY = re.compile(r"(.+?)\s*(?:\{([^{}]*)\}|<([^<>]*)>|\|\s*([^|]+))", re.DOTALL)
#: Brackets and the slash as Chinese and Japanese keyboards write them.
_FULL_WIDTH = str.maketrans("（）［］【】／", "()[][]/")
#: A Chinese or Japanese letter.
EASTERN = re.compile(r"[\u3040-\u30ff\u4e00-\u9fff]")
_EASTERN = re.compile(r"(.*[\u3040-\u30ff\u4e00-\u9fff])\s*([A-Za-zµ°%][\w./·*^%°-]*)", re.DOTALL)
# A letter right behind a Chinese word is its unit where the word says so, else the name of a phase or an axis.
_LETTERS = {"V": "电压 電壓 電圧", "A": "电流 電流", "N": "力 荷重", "s": "时间 時間", "W": "功率"}
# Words with a unit behind them in one pair of brackets: ``AI1 (Disp mm)``.
_WORDED = re.compile(r"([^\W\d_][^()]*[^\s,()])[\s,]+([^\W\d_°%][^\s,()]*)")
_WORDS_OF_LETTERS = {
    "A": re.compile(r"curr|\bamp|strom|courant|corriente", re.I),
    "V": re.compile(r"volt|spannung|tension", re.I),
    "N": re.compile(r"force|load|kraft|fuerza", re.I),
    "s": re.compile(r"time|zeit|temps", re.I),
    "m": re.compile(r"pos|disp|stroke|weg", re.I),
}
_WRITTEN_OUT = 5  # letters of a unit
_OF_A_UNIT = re.compile(
    r"per|pro|par|por|reciprocal|inverse|square|cubic|scale|arbitrary|\W*", re.I
)
#: Units that are words as well.
_WORDS_TOO = set_of("in min max a at bar are cd mol rev Rev step")
_SLASH = re.compile(r"(.+?)\s+(?:/|in)\s+(\S.*)", re.DOTALL)
_UNIT_ALONE = re.compile(r"in\s+(\S+)")  # what an oscilloscope writes over its time
#: ``[in 1/min]`` is a unit that is told, and no inch; ``[in lbf]`` is an inch, and ``(in use)`` is neither.
_TOLD_IN = re.compile(
    r"in\s+(?!lb|oz|ozf|pound|ounce|hg|h2o|wc|aq)(\S.*)", re.IGNORECASE | re.DOTALL
)
_CHANNEL = re.compile(r"\d{3,4} <([^<>]+)> \(([VA](?:DC|AC))\)")
#: Units that say no more than that a column holds whole numbers of a converter or an encoder.
COUNTS = set_of("count counts LSB lsb bit bits digit digits tick ticks step steps")
#: Units of motions and efforts that no name is written like; and those that speak beside one of them.
_TOLD_ALONE = set_of(
    "rpm RPM 1/min r/min U/min tr/min rad/s deg/s mm mm/s m/s cm/s in/s Nm N·m N*m N.m Ncm Nmm mNm kN lbf"
)
_LOGGED_IN = _TOLD_ALONE | set_of("s ms us A mA V mV kV N mT °C C K bar W kW")
_NONE_WRITTEN = ("None", "N/A", "n/a", "null", "NULL", "undefined")  # by programs that know no unit
# Names of a speed that is counted in turns: n is its symbol in ISO 80000-3.
_TURNS = re.compile(
    r"drehz|umdr\b|\brpm\b|umdrehung|rotational|rotation|tours|(?:^|[./:])n(?:_.*)?$|(?<![a-z])(?:speed|spd|(?:slip|schlupf)(?![a-z]))|velocity|vitesse|"
    r"velocidad|velocit[aà]|rota[cç]|giri|pr[eę]dko[sś][cć]|obrot|ot[aá][cč]k|toerental|varvtal|fordulat|pyörim|kierros|devir|"
    r"tura[tț]|στροφ|转速|轉速|回転|회전|вращ|оборот",
    re.I,
)
_SHEARED = re.compile(r"shear|scher|cisail|cizall|taglio|剪切|せん断|전단|сдвиг", re.I)
# What a single letter in front of a unit is the symbol of (``x_mm``, ``F_N``), as a unit of that quantity.
_SYMBOLS = {
    **dict.fromkeys("t", "s"),
    **dict.fromkeys("dsxyz", "m"),
    **dict.fromkeys("v", "m/s"),
    **dict.fromkeys("fF", "N"),
    **dict.fromkeys("MT", "N*m"),
    **dict.fromkeys("iI", "A"),
    **dict.fromkeys("uUV", "V"),
    **dict.fromkeys("nw", "rad/s"),
    "B": "T",
    "E": "V/m",
    "H": "A/m",
}
# A block of a model with the port behind it, as ControlDesk and dSPACE write it: ``Model Root/Sensors/Torque/Out1``.
_PATH = re.compile(
    r'"?(?:[^/]+/)+"?([^/]*[^/"])"?/"?(?:(?:Out|In)\d*|Value)"?(?:\[0\])?', re.IGNORECASE
)
_IN_ANY_BRACKETS = re.compile(r"\[[^\[\]]*\]|\([^()]*\)")
_SLASH_OF_A_UNIT = "\N{DIVISION SLASH}"  # parts no path: [mm/s] in a block's name
_IN_A_MODEL = re.compile(r'"?(?:Platform\(\)://)?Model Root/(?:[^/]+/)*"?([^/"]+)"?', re.IGNORECASE)
_GIVEN_BY_PLACE = re.compile(r"c\d+")
_COPY = re.compile(r" \(\d+\)$")
_OF_A_MESSAGE = "field."  # before each name behind the time, as rostopic echo -p writes it: no field of a device
_FEWEST_ALIKE = 2  # in a file; a single one may be an index (``i_d``)
# A quotient behind an underscore (``SR_1/s``, ``v_m/s``); a capital letter there is an index (``M_A/Nm``).
_QUOTIENT = re.compile(r"(.+)_((?:1|m|[^\W\d_]{2,})/[^/()]+)")
# A level that was set, such as 1 A in ``Force (1 A)``: a unit with a number in front, where names differ in it alone.
_LEVEL = re.compile(r"[+-]?\d+(?:[.,]\d+)?\s*(?:[^\W\d_]|%)[\w/.·%-]*")
# Of a level behind a name the last letters are no unit of their own: ``v 2 kV/mm``.
_NUMBER_OF_A_LEVEL = re.compile(r"\d ?[kmM]?[VA]$")
# A quotient behind a blank (``Shear Rate 1/s``, ``Angular Velocity rad/s``): the word before the slash is of the unit.
_BLANK = re.compile(r"(.*?[^\W\d_]\S*)(?:\s+[-–—])?\s+((?:1|[^\W\d_]{1,4})/[^\s/()]+)")
# A letter behind a blank (``Force N``), where all names of a file end in units; ``coil A`` alone is the first of two.
_LETTER = re.compile(r"(.*?[^\W\d_]\S*?)(?:(?:\s+[-–—])?\s+|[.=])([AVNTms])")
_COMMA = re.compile(r"(.*[^\W\d_]\S*)\s*,\s*([^\s,]+)")  # as Russian headers have it: ``Сила, Н``
_TIGHT_SLASH = re.compile(r"([^/]*[^\W\d_][^/]*?)/(\([^()]+\)|[^/()]+(?:/[^/()]+)?)")
_PRESSED = re.compile(r"(?<![a-z])(?:mu|cof|friction|normal|reib\w*)(?![a-z])", re.I)
#: As in Status_RPM_2; a torque per rpm is none, nor are tenths or thousands of rpm (``speed_0.1rpm``, ``rpm_x1000``).
_RPM_WITHIN = re.compile(
    r"(?<![a-z/])(?<!per)(?<!per[_ ])(?<!\.\d)(?<!\.0\d)(?<!10)(?<!00)rpm(?![a-z/]|.*per|[_ ]?[x*×]_?\d)",
    re.I,
)
_THOUSANDS_A_MINUTE = re.compile(
    r"\s*[x×*]?\s*(?:1000|10(?:\^|\*\*)3|10³)\s*(?:/\s*min|[x×*·]?\s*(?:1\s*/\s*min|min\s*\^?\s*-\s*1|min⁻¹))\s*"
)
#: Names of the speed that ISO 80000-3 calls rotational frequency, in turns a second.
_COUNTS_TURNS = re.compile(
    r"drehzahl|drehfrequenz|umdrehung|rotation(?:al)? freq|(?:^|[./:])n(?:_(?:ist|mess|act|meas))?$|"
    r"fordulatsz|частота\s+вращ|转速|轉速|回転数|회전수",
    re.I,
)

#: Newtons with a prefix in letters of one size, of which nobody knows the prefix: the unit is asked about.
_MEGA_OR_MILLI = re.compile(
    r"(?:force|load|kraft|thrust|fuerza|forza)[^\W\d_]*[\s_.(\[/:-]+(mn|un)[)\]]?$", re.IGNORECASE
)
#: What may have a sense and is never counted in revolutions.
_GOES_BACK = re.compile(r"torque|moment|force|load|current|speed|vel|couple|kraft", re.IGNORECASE)


def split_label(label: str) -> tuple[str, str | None]:
    """Name and unit of ``V [cm/s]``, ``Force (N)`` or ``time / s``; the whole label and None where no unit is.

    Text in square brackets is taken as a unit even if unknown (an index such as ``u[0]`` apart); round brackets and
    the slash only where the unit is known, and no number is one there (``speed (2)`` is that of a second motor). A
    unit may stand right behind a Chinese or Japanese name (``轉速rpm``).
    Underscores are never read as units: ``N_m`` may be a name.
    """
    label = label.strip()
    in_ascii = label.translate(_FULL_WIDTH)
    if in_ascii != label:
        name, unit = split_label(in_ascii)
        return (name, unit) if unit else (label, None)
    alone = _UNIT_ALONE.fullmatch(label)
    if alone and units.is_unit(alone.group(1)):
        return label, alone.group(1)

    in_brackets = _SQUARE.fullmatch(label)
    if in_brackets:
        name, unit = in_brackets.groups()
        unit = _without_in(unit.strip())
        if unit and not unit.isdecimal():  # an index is none
            return name, in_other_letters(name, unit, may_be_a_letter=True) or unit
    for pattern in (_ROUND, _SLASH, _CURLY):
        match = pattern.fullmatch(label)
        if match is None:
            continue
        name, unit = (part for part in match.groups() if part is not None)
        unit = _without_in(unit.strip())
        unit = in_other_letters(name, unit) or unit
        counts = unit in COUNTS and not unit.startswith("step")  # a step there may be one of a test
        is_reverse = unit in ("rev", "Rev") and _GOES_BACK.search(name)  # Torque (rev) beside (fwd)
        is_a_unit = units.is_known_unit(unit) or units.is_over_a_number(unit)
        known = is_a_unit and not is_reverse
        if counts or (not unit.isdecimal() and known):
            return name.rstrip("/ ") or name, unit
        worded = _WORDED.fullmatch(unit) if pattern is _ROUND else None
        if worded and _ends_in_its_unit(*worded.groups()):
            return f"{name} ({worded[1]})", worded[2]

    behind_a_word = _EASTERN.fullmatch(label)
    if behind_a_word:
        name, unit = behind_a_word.groups()
        words_of_unit = _LETTERS.get(unit, "?").split()
        speaks = len(unit) > 1 or name.endswith(tuple(words_of_unit))
        if speaks and units.is_known_unit(unit):
            return name, unit
    return label, None


def _without_in(unit: str) -> str:
    """``1/min`` of ``in 1/min``, as a German writes it in brackets; else the text as it is."""
    told = _TOLD_IN.fullmatch(unit)
    return told[1] if told and units.is_known_unit(told[1]) else unit


def _ends_in_its_unit(words: str, unit: str) -> bool:
    """Whether a unit ends what stands in brackets: ``AI1 (Disp mm)``; a letter is one where the words say so."""
    if len(unit) == 1:
        said = _WORDS_OF_LETTERS.get(unit)
        return said is not None and said.search(words) is not None
    is_short = len(unit) < _WRITTEN_OUT or "/" in unit
    # Of ``reciprocal seconds`` and ``newton metres`` the words in front are of the unit.
    is_of_words = any(_OF_A_UNIT.fullmatch(word) or units.is_unit(word) for word in words.split())
    return is_short and not is_of_words and unit not in _WORDS_TOO and units.is_unit(unit)


def units_behind_names(labels: Sequence[str]) -> dict[str, str]:
    """The units of labels whose word bears the unit out (``Torque, N·mm``), and of labels that are alike in a file."""
    units_of = _units_of_like_names(labels)
    for label in labels:
        _, unit = split_behind_word(label)
        if unit:
            units_of[label] = unit
    return units_of


def _units_of_like_names(labels: Sequence[str]) -> dict[str, str]:
    """The units of labels such as ``x_mm``, ``F_N`` and ``Force/N``, where a file has several of them.

    A single label of this form may have an index in place of a unit: ``i_d`` beside ``i_q``, ``F_N`` for the force that
    presses beside a coefficient of friction, ``motor/A`` beside ``motor/B``. A symbol with more than a letter behind it
    has a unit there (``U_kV``, ``M_Nm``). Where each label but the time's ends in a
    unit, a letter behind a blank is one as well (``Force N``).
    """
    letters = True  # whether a letter behind a blank is a unit: it is where a unit ends each label
    for label in labels:
        _, behind = _front_and_unit(label, letters=True)
        _, end = split_end(label)
        if behind is None and end is None and label.strip().lower() not in TIMES:
            letters = False

    split = {label: _front_and_unit(label, letters=letters) for label in labels}
    fronts = Counter(split[label][0] for label in labels)
    rubs = any(_PRESSED.search(label) for label in labels)
    units_of: dict[str, str] = {}
    for label, (front, unit) in split.items():
        presses = label.strip() == "F_N" and rubs
        if unit and fronts[front] == 1 and not presses:
            units_of[label] = unit
    is_eastern = any(EASTERN.search(label) for label in units_of)
    # Beside names that end in units (``pos_mm``, ``force_N``) one symbol has a unit too; a letter may be an index.
    are_of_names = sum(split_end(label)[1] is not None for label in labels) >= _FEWEST_ALIKE
    if are_of_names and len(units_of) < _FEWEST_ALIKE:
        return {label: unit for label, unit in units_of.items() if len(unit) > 1 or is_eastern}
    if is_eastern or len(units_of) >= _FEWEST_ALIKE:
        return units_of
    symbols = {label for label in units_of if split[label][0] in _SYMBOLS and "_" in label}
    return {label: unit for label, unit in units_of.items() if label in symbols and len(unit) > 1}


def without_unit(name: str, unit: str | None) -> str:
    """The name of a column without the unit that stands behind it: ``x`` for ``x_mm`` in mm."""
    front, behind = _front_and_unit(name, letters=True)
    return front if unit and behind == unit else name


def _front_and_unit(label: str, *, letters: bool) -> tuple[str, str | None]:
    """What stands in front of the last ``_`` or ``/``, and the unit behind it; None where that is none.

    Args:
        label: of a column.
        letters: whether a letter behind a blank is a unit too.
    """
    label = label.strip()
    front, unit = split_behind_word(label)
    if unit:
        return front, unit
    patterns = (_LETTER, _COMMA, _QUOTIENT, _BLANK) if letters else (_COMMA, _QUOTIENT, _BLANK)
    for pattern in patterns:
        match = pattern.fullmatch(label)
        if match is None:
            continue
        front, unit = match.groups()
        is_plain_number = pattern is _QUOTIENT and units.is_unit(unit) and units.fits(unit, ("",))
        if pattern is _LETTER or (units.is_unit(unit) and not is_plain_number):
            return front, unit

    match = _TIGHT_SLASH.fullmatch(label)
    if match and not _NUMBER_OF_A_LEVEL.search(match[1]):
        front, unit = match.groups()
        unit = unit.removeprefix("(").removesuffix(")")
        if not units.is_unit(unit):
            return front, None
        is_symbol = front in _SYMBOLS and units.fits(unit, (_SYMBOLS[front],))
        is_word = not units.is_unit(front) and not units.is_unit(label)
        return front, unit if is_symbol or is_word else None

    front, _, end = label.partition("_")
    unit = ENDS.get(end)
    is_celsius = unit == "°C"  # a temperature's unit has no factor, so it fits no symbol
    is_symbol = (
        unit and not is_celsius and front in _SYMBOLS and units.fits(unit, (_SYMBOLS[front],))
    )
    return front, unit if is_symbol else None


def own_unit(name: str, unit: str | None, si_units: Collection[str]) -> str | None:
    """The unit of a column: the file's (turns a minute where the name says turns), or its name's end if that fits.

    The speed of a shaft in 1/min is one of turns; a shear rate in 1/min is none. A rotational frequency, n or
    ``Drehzahl``, in 1/s counts turns too; an angular velocity in 1/s is in rad/s.
    """
    if _COUNTS_TURNS.search(name) and units.is_per_second(unit):
        return "turn/s"
    counts_turns = _TURNS.search(name) and not _SHEARED.search(name)
    if unit:
        if counts_turns and _THOUSANDS_A_MINUTE.fullmatch(unit):
            return "krpm"
        return "turn/min" if counts_turns and units.is_per_minute(unit) else unit
    _, end = split_end(name)
    unsure = _MEGA_OR_MILLI.search(name)
    if unsure and "N" in si_units and (unsure[1].islower() or name.isupper()):
        return unsure[1].lower()
    if not end:
        _, in_brackets = split_label(without_words_behind(name))
        # No index: User Parameter [0x2201/31].
        end = in_brackets if in_brackets and units.is_known_unit(in_brackets) else None
    if not end and _RPM_WITHIN.search(name):
        end = "rpm"
    elif end == "1/min" and counts_turns:
        end = "turn/min"
    if not end:
        return None
    return end if end == "°C" or units.fits(end, si_units) else None


def says_a_unit(name: str) -> bool:
    """Whether a unit of whatever quantity stands in a name."""
    if split_end(name)[1]:
        return True
    _, in_brackets = split_label(without_words_behind(name))
    return in_brackets is not None and units.is_known_unit(in_brackets)


def without_copy_number(name: str) -> str:
    """A name without the number that `name_columns` puts behind the name of an earlier column: ``Force (2)``."""
    return _COPY.sub("", name)


def is_given_by_place(name: str) -> bool:
    """Whether a column has no name: `name_columns` calls it by its place then."""
    return _GIVEN_BY_PLACE.fullmatch(name) is not None


def refuse_long_names(names: Iterable[str]) -> None:
    """Refuse a column that is called by more letters than anybody reads.

    Raises:
        LogError: such a name, with its beginning and its length.
    """
    for name in names:
        if len(name) > _LONGEST:
            begins = f"begins with {printable(name[:40])!r} and has {len(name):,} letters"
            raise LogError(
                f"the name of a column {begins}; it may have {_LONGEST:,}", remedy="Shorten it"
            )


def name_columns(
    labels: Sequence[str], own_units: Sequence[str | None] | None = None
) -> tuple[list[str], list[str | None], list[str]]:
    """Unique names, units and notes for header labels; unnamed columns become c1, c2, ... by position.

    Two labels that differ in their unit only keep their whole label as name; the second of two equal ones gets (2).
    Hidden characters of a label are written out. A label's own unit goes before that of ``own_units``, with a note.

    Raises:
        LogError: a label is too long.
    """
    refuse_long_names(labels)
    shown: list[str] = []
    for label in in_usual_form(labels):
        written = printable(label.strip())
        channel = _CHANNEL.fullmatch(written)  # 101 <Coil I> (ADC), as Keysight writes Coil I (A)
        shown.append(f"{channel[1]} ({channel[2][0]})" if channel else written)
    if len(shown) > 1 and all(label.startswith(_OF_A_MESSAGE) for label in shown[1:]):
        shown = [label.removeprefix(_OF_A_MESSAGE) for label in shown]
    notes: list[str] = []
    ends = _ends_of_paths(shown)
    if ends != shown:
        shown = ends
        notes.append("names are the last parts of the paths in a model")
    # Labels may be the same but for a level in brackets: t (0 A) and t (1 A) are no times in amperes.
    alike: dict[str, dict[str, str]] = {}  # by the name in front: level -> label
    for label in shown:
        match = _ROUND.fullmatch(label) or _SQUARE.fullmatch(label)
        if match and _LEVEL.fullmatch(match[2].strip()):
            alike.setdefault(match[1], {})[match[2]] = label
    with_levels = {
        label for levels in alike.values() if len(levels) > 1 for label in levels.values()
    }

    bare: list[str] = []  # names without their units
    units_of: list[str | None] = []
    for label, own in zip(shown, own_units or [None] * len(shown), strict=True):
        name, unit = (label, None) if label in with_levels else split_label(label)
        if unit and own and unit != own:
            notes.append(
                f"column {name!r} has two units: {unit} in its name is taken, {own} is not"
            )
        bare.append(name)
        written = unit or (own and in_other_letters(name, own, may_be_a_letter=True)) or own or None
        units_of.append(None if written in _NONE_WRITTEN else written)
    behind = units_behind_names(
        [name for name, unit in zip(bare, units_of, strict=True) if not unit]
    )
    if behind:
        units_of = [unit or behind.get(name) for name, unit in zip(bare, units_of, strict=True)]
        notes.append(f"what stands behind the names {', '.join(behind)} is taken for their units")

    alone = [name.strip("[] ()") for name in bare]
    if not any(units_of) and are_units_alone(alone):
        units_of = ["rpm" if units.is_per_minute(unit) else unit for unit in alone]
        units_of = [None if unit and unit.lower() in TIMES else unit for unit in units_of]
        notes.append("the columns are called by their units alone")

    count = Counter(bare)
    copies: Counter[str] = Counter()
    names: dict[str, None] = {}
    for number, (label, name) in enumerate(zip(shown, bare, strict=True), start=1):
        name = (name if count[name] == 1 else label) or f"c{number}"
        unique = name
        while unique in names:
            copies[name] += 1
            unique = f"{name} ({copies[name] + 1})"
        if unique != name:
            notes.append(
                f"column {number} has the name '{name}' of an earlier one: renamed '{unique}'"
            )
        names[unique] = None
    return list(names), units_of, notes


def are_units_alone(names: Sequence[str]) -> bool:
    """Whether each name but the time's is a unit that a bench logs in, and one is of a speed, a length or a torque."""
    others = [name for name in names if name.lower() not in TIMES]
    are_units = _LOGGED_IN.issuperset(others) and not _TOLD_ALONE.isdisjoint(others)
    return are_units and len({*others}) == len(others) > 1


def _ends_of_paths(labels: Sequence[str]) -> list[str]:
    """Labels without the way through a model and the port behind: ``Torque`` for ``Model Root/Sensors/Torque/Out1``.

    As they were where that leaves two labels the same, or no two are such paths.
    """
    ends: list[str] = []
    paths = 0
    for label in labels:
        name, unit = split_label(label)
        whole_units = _IN_ANY_BRACKETS.sub(
            lambda bracket: bracket[0].replace("/", _SLASH_OF_A_UNIT), label
        )
        with_port = _PATH.fullmatch(whole_units)
        match = with_port or _IN_A_MODEL.fullmatch(name)
        if match is None:
            ends.append(label)
            continue
        paths += 1
        end = match[1].replace(_SLASH_OF_A_UNIT, "/")
        ends.append(end if with_port or not unit else f"{end} [{unit}]")
    return ends if paths > 1 and len({*ends}) == len(labels) else [*labels]
