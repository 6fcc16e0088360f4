"""Names and units are read from the labels of columns, one by one and of all columns together."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Sequence

from erclutch.errors import printable
from erclutch.logs.columns.vocabulary import set_of
from erclutch.signals import units

_SQUARE = re.compile(r"(.+?)\s*\[([^\[\]]*)\]", re.DOTALL)
_ROUND = re.compile(r"(.+?)\s*\(([^()]*)\)", re.DOTALL)
_CURLY = re.compile(r"(.+?)\s*(?:\{([^{}]*)\}|<([^<>]*)>)", re.DOTALL)
#: Brackets and the slash as Chinese and Japanese keyboards write them.
_FULL_WIDTH = str.maketrans("（）［］【】／", "()[][]/")
#: A Chinese or Japanese letter.
EASTERN = re.compile(r"[\u3040-\u30ff\u4e00-\u9fff]")
_EASTERN = re.compile(r"(.*[\u3040-\u30ff\u4e00-\u9fff])\s*([A-Za-zµ°%][\w./·*^%°-]*)", re.DOTALL)
# A letter right behind a Chinese word is its unit where the word says so, else the name of a phase or an axis.
_LETTERS = {"V": "电压 電壓 電圧", "A": "电流 電流", "N": "力 荷重", "s": "时间 時間", "W": "功率"}
_SLASH = re.compile(r"(.+?)\s+(?:/|in)\s+(\S.*)", re.DOTALL)
_UNIT_ALONE = re.compile(r"in\s+(\S+)")  # what an oscilloscope writes over its time
_CHANNEL = re.compile(r"\d{3,4} <([^<>]+)> \(([VA](?:DC|AC))\)")
#: Units that say no more than that a column holds whole numbers of a converter or an encoder.
COUNTS = set_of("count counts LSB lsb bit bits digit digits tick ticks step steps")
# Ends of names that are units (``omega_rad_s``), and how units are written; small letters are taken for large ones.
_AS_THEY_ARE = "A mA V mV kV N kN kg krpm gauss Pa kPa MPa s ms us ns mm cm m rad deg rpm T mT"
_NONE_WRITTEN = ("None", "N/A", "n/a", "null", "NULL", "undefined")  # by programs that know no unit
_JOINT_DIGITS = 2  # of a joint's number at most
_TIMES = ("t", "time", "zeit", "temps")
_SPEEDS = "rad_s=rad/s rads=rad/s radps=rad/s deg_s=deg/s degps=deg/s dps=deg/s m_s=m/s mps=m/s mm_s=mm/s mmps=mm/s"
_OTHER_SPEEDS = (
    "kmh=km/h km_h=km/h kph=km/h rad_per_s=rad/s deg_per_s=deg/s m_per_s=m/s mm_per_s=mm/s"
)
# No in_s: time_in_s is no speed. No rps: radians or revolutions. No kN_m, N_mm, lbf_in: a stiffness is written so too.
_TURNS_A_TIME = "rev_s=turn/s rot_s=turn/s rev_min=rpm rot_min=rpm r_min=rpm 1_min=1/min ft_s=ft/s ft_min=ft/min"
_FIELDS = "kV_m=kV/m V_mm=V/mm kV_mm=kV/mm kA_m=kA/m"
_OTHERS = "Upm=rpm UPM=rpm Hz=Hz kHz=kHz C=°C degC=°C lbf=lbf lb=lbf lbs=lbf kgf=kgf gf=gf pct=% percent=% psi=psi"
_TORQUES = (
    "Nm=N*m N_m=N*m Nmm=N*mm Ncm=N*cm mNm=mN*m kNm=kN*m lb_ft=ft*lbf lb_in=in*lbf ozin=oz*in "
    "oz_in=oz*in inoz=oz*in"
)
_WEIGHTS = (
    "in_oz=oz*in kgcm=kgf*cm kgfcm=kgf*cm kgfm=kgf*m kg_cm=kgf*cm gcm=gf*cm g_cm=gf*cm gfcm=gf*cm"
)
_POUNDS = {
    end: f"{arm}*lbf"
    for arm in ("ft", "in")
    for pound in ("lb", "lbs", "lbf")
    for end in (f"{arm}{pound}", f"{pound}{arm}", f"{arm}_{pound}")
}
_IN_WORDS = "degrees=deg degree=deg radians=rad radian=rad meters=m metres=m millimeters=mm millimetres=mm newtons=N"
_TURNS_IN_WORDS = "turns=turn turns_s=turn/s turns_per_second=turn/s"
_SPEEDS_IN_WORDS = "radians_per_second=rad/s degrees_per_second=deg/s meters_per_second=m/s"
_TIMES_IN_WORDS = "seconds=s milliseconds=ms microseconds=us nanoseconds=ns msec=ms usec=us nsec=ns"
# What only looks like a second or a metre at its end: a shear rate, a viscosity, an acceleration.
_LONGER = (
    "1_s=1/s per_s=1/s Pa_s=Pa*s mPa_s=mPa*s Pas=Pa*s mPas=mPa*s cP=cP m_s2=m/s^2 rad_s2=rad/s^2"
)
_WRITTEN = " ".join(
    (
        *(_SPEEDS, _OTHER_SPEEDS, _TURNS_A_TIME, _FIELDS, _OTHERS, _TORQUES, _WEIGHTS),
        *(_IN_WORDS, _TURNS_IN_WORDS, _SPEEDS_IN_WORDS, _TIMES_IN_WORDS, _LONGER),
    )
)
_ENDS = {
    **{end: end for end in _AS_THEY_ARE.split()},
    **{end: unit for end, _, unit in (pair.partition("=") for pair in _WRITTEN.split())},
    **_POUNDS,
}
# A letter behind such a word, or behind a unit, is no unit: it tells one sensor, phase or side from another.
_SIDES = frozenset("ABCDLR")
_INDICES = frozenset({"A", "C", "T", "s", "m"})
_LENGTHS = frozenset({"position", "displacement", "stroke", "travel", "extension", "weg", "hub"})
_TURNING = set_of("torque moment omega rpm angle theta drehmoment drehzahl winkel couple")
_FORCES_AND_SPEEDS = set_of("force thrust speed velocity kraft geschwindigkeit vitesse fuerza")
_MEASURED = _LENGTHS | _TURNING | _FORCES_AND_SPEEDS
#: Names that are a unit and nothing else: the column is told by it.
_BARE = {
    **{unit: unit for unit in set_of("rpm Nm kN mm ms us mNm rad/s mm/s m/s deg/s N*m")},
    **{"N·m": "N*m", "N.m": "N*m", "millis": "ms", "micros": "us", "ms_today": "ms"},
    **{"milliseconds": "ms", "microseconds": "us", "nanoseconds": "ns"},
    **dict.fromkeys(("RPM", "r/min", "tr/min", "U/min", "Upm"), "rpm"),
    **dict.fromkeys(("newton", "newtons"), "N"),
    **dict.fromkeys(("ampere", "amperes"), "A"),
    **dict.fromkeys(("volt", "volts"), "V"),
    **dict.fromkeys(("millimeters", "millimetres", "millimeter"), "mm"),
    **dict.fromkeys(("meters", "metres"), "m"),
    **dict.fromkeys(("degrees", "degree"), "deg"),
    **{
        "radians": "rad",
        "kilonewtons": "kN",
        "milliamps": "mA",
        "seconds": "s",
        "milliseconds": "ms",
    },
}
_LOWER_ENDS = {
    end.lower(): unit
    for end, unit in _ENDS.items()
    if end not in ("mA", "mV", "mT", "MPa", "T", "C")
}
# Names of a speed that is counted in turns: n is its symbol in ISO 80000-3.
_TURNS = re.compile(
    r"drehzahl|\brpm\b|umdrehung|rotational|rotation|tours|^n(?:_.*)?$|(?<![a-z])(?:speed|spd)|velocity|vitesse|"
    r"velocidad|velocit[aà]|giri|pr[eę]dko[sś][cć]|obrot|ot[aá][cč]k|toerental|varvtal|转速|轉速|回転|회전|вращ|оборот",
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
_IN_A_MODEL = re.compile(r'"?(?:Platform\(\)://)?Model Root/(?:[^/]+/)*"?([^/"]+)"?', re.IGNORECASE)
_OF_A_MESSAGE = "field."  # before each name behind the time, as rostopic echo -p writes it: no field of a device
_FEWEST_ALIKE = 2  # in a file; a single one may be an index (``i_d``)
# A quotient behind an underscore (``SR_1/s``, ``v_m/s``); a capital letter there is an index (``M_A/Nm``).
_QUOTIENT = re.compile(r"(.+)_((?:1|m|[^\W\d_]{2,})/[^/()]+)")
# A quotient behind a blank (``Shear Rate 1/s``, ``Angular Velocity rad/s``): the word before the slash is of the unit.
_BLANK = re.compile(r"(.*[^\W\d_]\S*)\s+((?:1|[^\W\d_]{1,4})/[^\s/()]+)")
# A letter behind a blank (``Force N``), where all names of a file end in units; ``coil A`` alone is the first of two.
_LETTER = re.compile(r"(.*?[^\W\d_]\S*?)(?:\s+[-–])?\s+([AVNTms])")
_COMMA = re.compile(r"(.*[^\W\d_]\S*)\s*,\s*([^\s,]+)")  # as Russian headers have it: ``Сила, Н``
_TIGHT_SLASH = re.compile(r"([^/]*[^\W\d_][^/]*?)/(\([^()]+\)|[^/()]+(?:/[^/()]+)?)")
_BY_R = re.compile(r"(\w[\w.]*?)\.\.(\w[\w.]*)\.")
_PRESSED = re.compile(r"(?<![a-z])(?:mu|cof|friction|normal|reib\w*)(?![a-z])", re.I)
_RPM_WITHIN = re.compile(
    r"(?<![a-z/])(?<!per)(?<!per[_ ])rpm(?![a-z/]|.*per)", re.I
)  # Status_RPM_2; no torque per rpm
_PER_MINUTE = re.compile(r"\s*(?:1\s*/\s*min|min\s*(?:\^|\*\*)?\s*-\s*1|min⁻¹)\s*")


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
        unit = unit.strip()
        if unit and not unit.isdecimal():  # an index is none
            return name, unit
    for pattern in (_ROUND, _SLASH, _CURLY):
        match = pattern.fullmatch(label)
        if match is None:
            continue
        name, unit = (part for part in match.groups() if part is not None)
        unit = unit.strip()
        counts = unit in COUNTS and not unit.startswith("step")  # a step there may be one of a test
        known = units.is_unit(unit) or units.is_temperature(unit)
        if counts or (not unit.isdecimal() and known):
            return name.rstrip("/ ") or name, unit

    behind_a_word = _EASTERN.fullmatch(label)
    if behind_a_word:
        name, unit = behind_a_word.groups()
        words_of_unit = _LETTERS.get(unit, "?").split()
        speaks = len(unit) > 1 or name.endswith(tuple(words_of_unit))
        if speaks and (units.is_unit(unit) or units.is_temperature(unit)):
            return name, unit
    return label, None


_WORD = 5  # letters of a unit that is written out
_POWERS = ("squared", "square", "cubic", "cubed", "sq", "sq.")


def split_end(name: str) -> tuple[str, str | None]:
    """``torque_Nm`` as ``torque`` and ``N*m``, ``rpm`` as itself in ``rpm``; None where no unit ends the name.

    One letter alone before the end is a name of its own (``i_d``, ``F_N``), but for the time (``t_s``). The number of a
    joint or the letter of a side may stand behind the unit (``torque_Nm_2``), or in its place (``Torque_A``). A blank
    may stand for the ``_`` where the unit is longer than a letter (``speed rpm``): ``coil A`` may be the first of two
    coils.
    """
    written = name.strip()
    bare = _BARE.get(written) or _BARE.get(written.lower())
    if bare:
        return name, bare
    # Torque (Nm) in names without brackets: Torque..Nm. as R writes it, Torque_Nm_ as MATLAB does.
    by_r = _BY_R.fullmatch(name.strip())
    front_and_end = (
        "{}_{}".format(by_r[1], by_r[2].replace(".", "_")) if by_r else name.strip().rstrip("_")
    )
    if front_and_end and front_and_end != name.strip():
        stem, unit = split_end(front_and_end)
        return (stem, unit) if unit else (name, None)
    words = name.split()
    for count in (2, 1):  # ``torque N m`` before ``distance m``
        stem = " ".join(words[:-count])
        if stem.lower().endswith(_POWERS):
            return name, None  # squared meters: no length
        end = "_".join(words[-count:])
        unit = _BARE.get(end) or _unit_of_end(end)
        is_time = end == "s" and stem.lower() in _TIMES
        if stem and unit and (len(end) > 1 or is_time):
            return stem, unit

    front, _, last = written.rpartition("_")
    shorter, _, before = front.rpartition("_")
    shortest, _, first = shorter.rpartition("_")
    longest_first = (
        (shortest, f"{first}_{before}_{last}"),
        (shorter, f"{before}_{last}"),
        (front, last),
    )
    for stem, end in longest_first:
        unit = _unit_of_end(end)
        if not unit:
            continue
        if stem.lower().endswith("_per"):
            return name, None  # the last of a quotient that is no unit of ours
        # A letter behind a word for a quantity cannot be its unit: it tells this column from others of its kind.
        word = re.split(r"[\W_]+", stem.lower())[-1]
        is_index = end in _INDICES and word in (_MEASURED - _LENGTHS if end == "m" else _MEASURED)
        if is_index or (end in _SIDES and split_end(stem)[1]):
            continue
        if len(stem) > 1 or stem == "t" or (len(stem) == 1 and len(end) > 2):
            return stem, unit

    is_joint = last.isdecimal() and len(last) <= _JOINT_DIGITS
    if front and (is_joint or last in _SIDES):
        stem, unit = split_end(front)
        if unit and stem != front:
            return f"{stem}_{last}", unit
    return name, None


def _unit_of_end(end: str) -> str | None:
    """The unit that an end of a name is, in small letters too; a word in letters of any size (``Angle_Degrees``)."""
    is_word = len(end) >= _WORD and end.isalpha()
    return _ENDS.get(end) or (_LOWER_ENDS.get(end.lower()) if is_word or end.islower() else None)


def units_behind_names(labels: Sequence[str]) -> dict[str, str]:
    """The units of labels such as ``x_mm``, ``F_N`` and ``Force/N``, where a file has several of them.

    A single label of this form may have an index in place of a unit: ``i_d`` beside ``i_q``, ``F_N`` for the force that
    presses beside a coefficient of friction, ``motor/A`` beside ``motor/B``. Where each label but the time's ends in a
    unit, a letter behind a blank is one as well (``Force N``).
    """
    letters = True  # whether a letter behind a blank is a unit: it is where a unit ends each label
    for label in labels:
        _, end = split_end(label)
        _, behind = _front_and_unit(label, letters=True)
        if behind is None and end is None and label.strip().lower() not in _TIMES:
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
    return units_of if is_eastern or len(units_of) >= _FEWEST_ALIKE else {}


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
    if match:
        front, unit = match.groups()
        unit = unit.removeprefix("(").removesuffix(")")
        if not units.is_unit(unit):
            return front, None
        is_symbol = front in _SYMBOLS and units.fits(unit, (_SYMBOLS[front],))
        is_word = not units.is_unit(front) and not units.is_unit(label)
        return front, unit if is_symbol or is_word else None

    front, _, end = label.partition("_")
    unit = _ENDS.get(end)
    is_celsius = unit == "°C"  # a temperature's unit has no factor, so it fits no symbol
    is_symbol = (
        unit and not is_celsius and front in _SYMBOLS and units.fits(unit, (_SYMBOLS[front],))
    )
    return front, unit if is_symbol else None


def own_unit(name: str, unit: str | None, si_units: Iterable[str]) -> str | None:
    """The unit of a column: the file's (turns a minute where the name says turns), or its name's end if that fits.

    The speed of a shaft in 1/min is one of turns; a shear rate in 1/min is none.
    """
    if unit:
        counts_turns = _TURNS.search(name) and not _SHEARED.search(name)
        return "turn/min" if _PER_MINUTE.fullmatch(unit) and counts_turns else unit
    _, end = split_end(name)
    if not end and _RPM_WITHIN.search(name):
        end = "rpm"
    if not end:
        return None
    return end if end == "°C" or units.fits(end, si_units) else None


def name_columns(
    labels: Sequence[str], own_units: Sequence[str | None] | None = None
) -> tuple[list[str], list[str | None], list[str]]:
    """Unique names, units and notes for header labels; unnamed columns become c1, c2, ... by position.

    Two labels that differ in their unit only keep their whole label as name; the second of two equal ones gets (2).
    Hidden characters of a label are written out. A label's own unit goes before that of ``own_units``, with a note.
    """
    shown: list[str] = []
    for label in labels:
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
    bare: list[str] = []  # names without their units
    units_of: list[str | None] = []
    for label, own in zip(shown, own_units or [None] * len(shown), strict=True):
        name, unit = split_label(label)
        if unit and own and unit != own:
            notes.append(
                f"column {name!r} has two units: {unit} in its name is taken, {own} is not"
            )
        bare.append(name)
        written = unit or own or None
        units_of.append(None if written in _NONE_WRITTEN else written)
    behind = units_behind_names(
        [name for name, unit in zip(bare, units_of, strict=True) if not unit]
    )
    if behind:
        units_of = [unit or behind.get(name) for name, unit in zip(bare, units_of, strict=True)]
        notes.append(f"what stands behind the names {', '.join(behind)} is taken for their units")

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


def _ends_of_paths(labels: Sequence[str]) -> list[str]:
    """Labels without the way through a model and the port behind: ``Torque`` for ``Model Root/Sensors/Torque/Out1``.

    As they were where that leaves two labels the same, or no two are such paths.
    """
    ends: list[str] = []
    paths = 0
    for label in labels:
        name, unit = split_label(label)
        with_port = _PATH.fullmatch(label)
        match = with_port or _IN_A_MODEL.fullmatch(name)
        if match is None:
            ends.append(label)
            continue
        paths += 1
        ends.append(match[1] if with_port or not unit else f"{match[1]} [{unit}]")
    return ends if paths > 1 and len({*ends}) == len(labels) else [*labels]
