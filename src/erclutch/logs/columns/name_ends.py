"""The end of a column's name may be its unit: ``torque_Nm``, ``brakeTorqueNm``, ``Torque.N.m.``, ``speed rpm``."""

from __future__ import annotations

import re
from contextlib import suppress
from functools import lru_cache

from erclutch.errors import UnitError
from erclutch.logs.columns.glued_speeds import is_glued_speed, split_glued_speed
from erclutch.logs.columns.prefixes_in_words import split_written_out
from erclutch.logs.columns.quantities_in_words import is_of
from erclutch.logs.columns.unit_behind_word import split_behind_word
from erclutch.logs.columns.vocabulary import set_of
from erclutch.logs.columns.words_behind_units import without_words_behind
from erclutch.signals.units import fits

#: Names that are kept once they are understood: a file may have as many columns, and each rule asks for each name anew.
KEPT_NAMES = 1 << 14

# Ends of names that are units (``omega_rad_s``), and how units are written; small letters are taken for large ones.
_AS_THEY_ARE = "A mA V mV kV N mN kN daN kp ozf kg krpm uA gauss Pa kPa MPa s ms us ns um mm cm m rad mrad deg rpm T mT"
_JOINT_DIGITS = 2  # of a joint's number at most
TIMES = ("t", "time", "zeit", "temps")
_SPEEDS = "rad_s=rad/s rads=rad/s radps=rad/s deg_s=deg/s degps=deg/s dps=deg/s m_s=m/s mps=m/s mm_s=mm/s mmps=mm/s"
_OTHER_SPEEDS = (
    "kmh=km/h km_h=km/h kph=km/h rad_per_s=rad/s deg_per_s=deg/s m_per_s=m/s mm_per_s=mm/s "
    "rad_per_sec=rad/s deg_per_sec=deg/s m_per_sec=m/s mm_per_sec=mm/s "
    "cm_s=cm/s cmps=cm/s cm_per_s=cm/s inps=in/s ips=in/s in_per_s=in/s in_per_sec=in/s kmph=km/h "
    "mrad_s=mrad/s mradps=mrad/s mdeg_s=mdeg/s um_s=um/s m_min=m/min cm_min=cm/min mm_min=mm/min mm_per_min=mm/min"
)
# No in_s: time_in_s is no speed. No rps: radians or revolutions. No kN_m, N_mm, lbf_in: a stiffness is written so too.
_TURNS_A_TIME = (
    "rev_s=turn/s rot_s=turn/s rev_min=rpm rot_min=rpm r_min=rpm revps=turn/s rev_per_s=turn/s rev_per_min=rpm "
    "1_min=1/min ft_s=ft/s ft_min=ft/min"
)
_FIELDS = "kV_m=kV/m V_mm=V/mm kV_mm=kV/mm kVmm=kV/mm kA_m=kA/m kA_per_m=kA/m A_per_m=A/m kAm=kA/m kApm=kA/m Oe=Oe"
_OTHERS = (
    "Upm=rpm UPM=rpm RPM=rpm Hz=Hz kHz=kHz C=°C degC=°C lbf=lbf lb=lbf lbs=lbf kgf=kgf gf=gf pct=% "
    "percent=% psi=psi mph=mph kA=kA"
)
_TORQUES = (
    "Nm=N*m N_m=N*m Nmm=N*mm Ncm=N*cm mNm=mN*m cNm=cN*m dNm=dN*m daNm=daN*m uNm=uN*m kNm=kN*m "
    "lb_ft=ft*lbf lb_in=in*lbf ozin=oz*in oz_in=oz*in inoz=oz*in"
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
_NEWTONS_IN_WORDS = "newton=N kilonewtons=kN kilonewton=kN millinewtons=mN millinewton=mN"
_INCHES_IN_WORDS = "inches=in inch=in pounds=lbf kips=kip kip=kip klbf=kip klbs=kip"
# Ampere-turns are amperes, as SI has them, and no turns of a shaft.
_AMPERE_TURNS = "A_turns=A A_turn=A amp_turns=A ampere_turns=A Aturns=A"
_TURNS_IN_WORDS = "turns=turn turns_s=turn/s turns_per_second=turn/s"
_SPEEDS_IN_WORDS = "radians_per_second=rad/s degrees_per_second=deg/s meters_per_second=m/s"
_TIMES_IN_WORDS = (
    "seconds=s milliseconds=ms microseconds=us nanoseconds=ns msec=ms usec=us nsec=ns millis=ms micros=us nanos=ns "
    "minutes=min mins=min hours=h hrs=h"
)
# What only looks like a second or a metre at its end: a shear rate, a viscosity, an acceleration.
_LONGER = (
    "1_s=1/s per_s=1/s Pa_s=Pa*s mPa_s=mPa*s Pas=Pa*s mPas=mPa*s cP=cP m_s2=m/s^2 rad_s2=rad/s^2"
)
_WRITTEN = " ".join(
    (
        *(_SPEEDS, _OTHER_SPEEDS, _TURNS_A_TIME, _FIELDS, _OTHERS, _TORQUES, _WEIGHTS),
        *(
            _IN_WORDS,
            _NEWTONS_IN_WORDS,
            _INCHES_IN_WORDS,
            _AMPERE_TURNS,
            _TURNS_IN_WORDS,
            _SPEEDS_IN_WORDS,
            _TIMES_IN_WORDS,
            _LONGER,
        ),
    )
)
ENDS = {
    **{end: end for end in _AS_THEY_ARE.split()},
    **{end: unit for end, _, unit in (pair.partition("=") for pair in _WRITTEN.split())},
    **_POUNDS,
}
# A letter behind such a word, or behind a unit, is no unit: it tells one sensor, phase or side from another.
_SIDES = frozenset("ABCDLR")
_INDICES = frozenset({"A", "C", "T", "s", "m"})
_LENGTHS = frozenset({"position", "displacement", "stroke", "travel", "extension", "weg", "hub"})
#: What is measured in inches where ``in`` ends its name; of a position or a torque it is the input's.
_IN_INCHES = _LENGTHS - {"position"} | {"disp", "crosshead", "gap"}
_IN_INCHES_A_SECOND = frozenset({"v", "vel", "velocity", "speed"})  # time_in_s is none
#: A unit in the plural that is the name of its quantity as well: the name keeps it.
_AMPS_OR_VOLTS = re.compile(r"(?:[_ .-](?i:(amp|volt)s?)|(?<=[a-z])(Amp|Volt)s?)$")
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
        "minutes": "min",
        "hours": "h",
    },
}
_LOWER_ENDS = {
    end.lower(): unit
    for end, unit in ENDS.items()
    if end not in ("mA", "kA", "mV", "mT", "mN", "MPa", "T", "C", "kAm", "Oe")
}
#: ``Torque (N.m)`` and ``Torque(N.m)`` as R writes them: each sign is a dot.
_BY_R = re.compile(r"(\w[\w.]*?)\.\.?(\w[\w.]*)\.")
#: ``Winkel °``; 90° in a name is a place.
_BEFORE_DEGREES = " _,.:=/-"
#: A name, a mark that programs put between words, and what may be a unit: ``torque.mNm``, ``speed@rpm``.
_BEHIND_A_MARK = re.compile(r"(.*[^\W_])[.:@#~|/-]([^\W\d_]{2}\w*)")
#: What stands in front of units.
_PREFIXES = ("da", *"mkcduµM")
#: Where a word of a name begins with a large letter: ``brakeTorqueNm``.
_CAPITAL = re.compile(r"(?<=[a-z])(?=[A-Z])")
#: A large letter behind such a word is its unit.
_LETTERS_BEHIND = {
    "A": set_of("current strom amps courant corriente"),
    "V": set_of("voltage volts spannung tension"),
    "N": set_of("force load kraft"),
    "C": set_of("temp temperature temperatur"),
    "S": set_of("time zeit"),
}
_TORQUE = re.compile(
    r"torque|torsion|moment(?!um)|(?<!o)couple|koppel|扭矩|转矩|力矩|轉矩|トルク|토크|момент",
    re.IGNORECASE,
)
_TORQUE_SYMBOL = re.compile(r"[TM]\d?")
#: Units of two meanings or in letters of another size, by what the name says: as written each is another, or none.
_IN_SMALL_LETTERS = (
    # Of a torque rev is the reverse.
    (
        re.compile(r"theta|angle|phi|winkel|rotation", re.IGNORECASE),
        {"rev": "turn", "revs": "turn"},
    ),
    (
        re.compile(
            r"curr|strom|courant|corrent|corriente|amps?\b|^i(?:_|\b)|电流|電流", re.IGNORECASE
        ),
        {"ma": "mA", "Ma": "mA", "MA": "mA"},
    ),
    (
        re.compile(r"volt|spannung|tension|tensi[oó]n|^[uv](?:_|\b)|电压|電圧", re.IGNORECASE),
        {"mv": "mV", "MV": "mV", "kv": "kV", "KV": "kV"},
    ),
    (
        re.compile(r"flux|field|feld|induction|^b(?:_|\b)|磁", re.IGNORECASE),
        {"mt": "mT", "Mt": "mT", "MT": "mT"},
    ),
    (
        re.compile(r"force|load|kraft|effort|fuerza|forza|thrust|^f(?:_|\b)", re.IGNORECASE),
        {
            **dict.fromkeys(("kn", "KN"), "kN"),
            **dict.fromkeys(("cn", "cN", "CN"), "cN"),
            **dict.fromkeys(("dan", "DAN"), "daN"),
            **dict.fromkeys(("uN", "µN"), "uN"),
            **dict.fromkeys(("LB", "LBS", "LBF"), "lbf"),
            **{"MN": "MN", "KIP": "kip", "KIPS": "kip", "KG": "kg", "KGF": "kgf", "GF": "gf"},
            **dict.fromkeys(("g", "gram", "grams", "GRAM", "GRAMS"), "g"),
        },
    ),
    (
        re.compile(r"stress|pressure|tau|druck|spannung|contrainte|pression", re.IGNORECASE),
        {"pa": "Pa", "PA": "Pa", "kpa": "kPa", "KPA": "kPa", "MPA": "MPa"},
    ),
)
_CAPITALS = {
    **{"NM": "N*m", "KNM": "kN*m", "nm": "N*m", "knm": "kN*m", "mnm": "mN*m"},
    **{"ncm": "N*cm", "nmm": "N*mm", "NCM": "N*cm", "NMM": "N*mm"},
    **{"kgfcm": "kgf*cm", "kgfm": "kgf*m", "kgm": "kgf*m", "gfcm": "gf*cm"},
}
#: ``Speed rev/min``: such a unit may be written in any of a hundred ways, so `erclutch.signals.units` is asked.
_FRACTION = re.compile(r"[^\W\d_]{1,7}/[^\W\d_]{1,7}")
_RATES = ("rad/s", "m/s", "V/m", "A/m", "1/s")
_DASHES = " -–—"
_MARKS = _DASHES + "_,.:=|"
_WORD = 5  # letters of a unit that is written out
#: A unit in front of a name, where no unit ends the name: ``ms_time``, ``mA current``, ``kN:force``.
_IN_FRONT = re.compile(r"([^\s_:\d]{2,12})[ _:.]([^\W\d_]{3,20})(?:[ _.]\w{1,30})?")
#: Units that stand right behind the word of their quantity (``currentmA``).
_RIGHT_BEHIND = "ms us ns mA kA mV kV kN mm cm mNm kNm Ncm Nmm Nm".split()
#: What is a unit behind a word for the time alone: pos_min is the least position, and x_h a height.
_BEHIND_A_TIME = {"min": "min", "h": "h", "hr": "h", "sec": "s", "sek": "s", "sekunden": "s"}
#: Units that are words in front of another: the smallest, the input, the back, the gravity.
_WORDS_IN_FRONT = set_of("min in rev ft at bar mol pt pa cd lb turns turn cycle")
_POWERS = ("squared", "square", "cubic", "cubed", "sq", "sq.")


@lru_cache(maxsize=KEPT_NAMES)  # many rules of a plan ask about the same few names
def split_end(name: str) -> tuple[str, str | None]:
    """``torque_Nm`` as ``torque`` and ``N*m``, ``rpm`` as itself in ``rpm``; None where no unit ends the name.

    One letter alone before the end is a name of its own (``i_d``, ``F_N``), but for the time (``t_s``). The number of a
    joint or the letter of a side may stand behind the unit (``torque_Nm_2``), or in its place (``Torque_A``). A blank
    may stand for the ``_`` where the unit is longer than a letter (``speed rpm``): ``coil A`` may be the first of two
    coils. Words that tell what was done with the numbers may stand behind the unit (``Force_kN_filtered``).
    """
    written = name.strip()
    if is_glued_speed(written):
        return split_glued_speed(written)
    front, written_out = split_written_out(written)
    if written_out:
        return front, written_out
    angle = written.removesuffix("°").rstrip(_BEFORE_DEGREES)
    if written.endswith("°") and angle[-1:].isalpha():
        return angle, "deg"
    stem, unit = _split_at_end(name)
    front, whole_unit = split_behind_word(written)
    if whole_unit and (unit is None or len(front) < len(stem.rstrip(_MARKS))):
        return front, whole_unit  # of Torque Newton meters no m
    shorter = without_words_behind(name)
    if unit or shorter == written:
        return stem, unit
    stem, unit = split_end(shorter)
    return (stem + written[len(shorter) :], unit) if unit else (name, None)


def _split_at_end(name: str) -> tuple[str, str | None]:
    """A name and the unit that is its end; the whole name and None where none is."""
    written = name.strip()
    word = _AMPS_OR_VOLTS.search(written)  # at the end of coil_amps
    letter = word[0].strip("_ .-")[0].upper() if word else None
    bare = _BARE.get(written) or _BARE.get(written.lower()) or letter
    if bare:
        return name, bare
    # Torque (Nm) in names without brackets: Torque..Nm. as R writes it, Torque_Nm_ as MATLAB does.
    is_by_r = _BY_R.fullmatch(written)
    stem, unit = _split_at_dot(name) if is_by_r else _split_at_mark(written)
    if is_by_r or unit:
        return stem, unit
    without_bracket = written.rstrip("_")
    if without_bracket and without_bracket != written:
        stem, unit = split_end(without_bracket)
        return (stem, unit) if unit else (name, None)
    words = name.split()
    for count in (2, 1):  # ``torque N m`` before ``distance m``
        stem = " ".join(words[:-count]).rstrip(_DASHES)
        if stem.lower().endswith(_POWERS):
            return name, None  # squared meters: no length
        end = "_".join(words[-count:])
        unit = _BARE.get(end) or _unit_of_end(end) or in_other_letters(stem, end)
        unit = unit or _of_a_time(stem, end)
        # Of a level nothing but its number would be left: ``2 kV/mm``.
        if unit is None and _FRACTION.fullmatch(end) and not stem.replace(".", "").isdigit():
            with suppress(UnitError):  # ``cmd/act`` is none
                unit = end if fits(end, _RATES) is not None else None
        is_time = end in ("s", "h") and stem.lower() in TIMES
        if stem and unit and (len(end) > 1 or is_time or end == "g"):
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
        unit = _unit_of_end(end) or in_other_letters(stem, end) or _inches(stem, end)
        unit = unit or _of_a_time(stem, end)
        if not unit:
            continue
        if stem.lower().endswith("_per"):
            return name, None  # the last of a quotient that is no unit of ours
        # A letter behind a word for a quantity cannot be its unit: it tells this column from others of its kind.
        word = re.split(r"[\W_]+", stem.lower())[-1]
        is_index = end in _INDICES and word in (_MEASURED - _LENGTHS if end == "m" else _MEASURED)
        if is_index or (end in _SIDES and split_end(stem)[1]):
            continue
        is_symbol = len(stem) == 1 and (len(end) > 2 or (len(end) == 2 and end not in ENDS))
        if len(stem) > 1 or stem == "t" or is_symbol:
            return stem, unit

    is_joint = last.isdecimal() and len(last) <= _JOINT_DIGITS
    if front and (is_joint or last in _SIDES):
        stem, unit = split_end(front)
        if unit and stem != front:
            return f"{stem}_{last}", unit
    return _split_without_a_mark(name)


def _split_at_mark(name: str) -> tuple[str, str | None]:
    """``vel`` and ``mm/s`` of ``vel.mm_s``, which is not in s; the whole name and None where no unit is behind a mark.

    Nor is there one where a unit stands in front of the mark, as in ``torque_N.mm``: both are parts of it.
    """
    parts = _BEHIND_A_MARK.fullmatch(name)
    if parts is None:
        return name, None
    unit = _unit_of_end(parts[2]) or in_other_letters(parts[1], parts[2])
    if unit is None:
        return name, None
    # A force over mm is a stiffness: behind a dash or a slash the unit is one of the word before.
    if name[len(parts[1])] in "/-" and not is_of(unit, _last_word(parts[1])):
        return name, None
    *front, word = re.split(r"[\W_]+", parts[1])
    return (name, None) if front and _unit_of_end(word) else (parts[1], unit)


def _split_at_dot(name: str) -> tuple[str, str | None]:
    """``Torque`` and ``N*m`` of ``Torque..N.m.``, by the longest end that is a unit."""
    parts = [part for part in name.strip().split(".") if part]
    for place in range(1, len(parts)):
        unit = _unit_of_end("_".join(parts[place:]))
        if unit and place > 1 and _unit_of_end(parts[place - 1]):
            return name, None  # a dot of mN.m is a product or a quotient
        if unit:
            return ".".join(parts[:place]), unit
    return name, None


def _split_without_a_mark(name: str) -> tuple[str, str | None]:
    """``torque`` and ``N*m`` of ``torqueNm``, ``time`` and ``ms`` of ``ms_time``; None where no unit is told.

    Some units are told right behind the word for what they measure, as ``mA`` of ``coilCurrentmA``.
    """
    for split in (_split_at_capital, _split_at_front):
        stem, unit = split(name)
        if unit:
            return stem, unit
    for end in _RIGHT_BEHIND:
        stem = name.removesuffix(end)
        if stem != name and is_of(end, _last_word(stem)):
            return stem, ENDS[end]
    return name, None


def _split_at_capital(name: str) -> tuple[str, str | None]:
    """``brakeTorque`` and ``N*m`` of ``brakeTorqueNm``; the whole name and None where no such unit ends it."""
    words = _CAPITAL.split(name)
    for count in (3, 2, 1):
        stem = "".join(words[:-count])
        end = "_".join(words[-count:])
        unit = ENDS.get(end) or _LOWER_ENDS.get(end.lower())
        if end == "MNm":
            return name, None  # mega, or milli with the large letter of a word
        if not stem or not unit or len(end) < 2:
            continue
        # ``torquem`` and ``Nm`` are a torque in mN*m.
        prefix = next(filter(stem.endswith, _PREFIXES), "")
        whole = "Nm" if end == "NM" else end
        prefixed = ENDS.get(prefix + whole) if prefix else None
        if prefixed is None:
            return stem, unit
        shorter = stem.removesuffix(prefix)
        word = _last_word(shorter)
        # A word for a quantity is left, or no letter. Else nobody knows: ``peakNm``, ``stiffnesskNm``.
        if word and word not in _MEASURED:
            return stem + end, None
        return shorter.rstrip("_.:@#~|= "), prefixed
    last_word = re.split(r"[\W_]+", words[-2].lower())[-1] if len(words) > 1 else ""
    if last_word in _LETTERS_BEHIND.get(words[-1], ()):
        return "".join(words[:-1]), ENDS.get(words[-1]) or words[-1].lower()
    return name, None


def _split_at_front(name: str) -> tuple[str, str | None]:
    """``time`` and ``ms`` of ``ms_time``; the whole name and None where its first word is no unit of the next one."""
    match = _IN_FRONT.fullmatch(name.strip())
    if match is None:
        return name, None
    unit = match[1]
    # The act of act_force is a unit to pint, as the foot of foot.position is.
    is_another_word = unit in _WORDS_IN_FRONT or (unit.isalpha() and unit not in ENDS)
    unit = ENDS.get(unit, unit)
    if is_another_word or not is_of(unit, match[2].lower()):
        return name, None
    return name.strip()[len(match[1]) + 1 :], unit


def _last_word(name: str) -> str:
    """In small letters; "" behind a digit or a sign."""
    return re.split(r"[\W\d_]+|(?<=[a-z])(?=[A-Z])", name)[-1].lower()


def in_other_letters(name: str, unit: str, *, may_be_a_letter: bool = False) -> str | None:
    """The unit that ``NM`` is behind the name of a torque, or ``ma`` behind that of a current; None for other units.

    Behind another name NM may be a nautical mile, ma a time, and kn a knot. No device has a current in megaamperes.

    Args:
        name: in front of the unit.
        unit: as written.
        may_be_a_letter: whether one small letter is a unit there, and tells no phase or side from another.
    """
    is_torque = _TORQUE.search(name) or _TORQUE_SYMBOL.fullmatch(name.strip())
    if is_torque and unit in _CAPITALS:
        return _CAPITALS[unit]
    for quantity, written in _IN_SMALL_LETTERS:
        if quantity.search(name) and unit in written:
            return written[unit]
        if quantity.search(name) and may_be_a_letter and unit and unit in "avn":
            return unit.upper() if unit.upper() in {each[-1] for each in written.values()} else None
    return None


def _inches(stem: str, end: str) -> str | None:
    """The unit that ``in`` or ``in_s`` is behind the name of a length or a speed; None elsewhere: it is a word."""
    word = re.split(r"[\W_]+", stem.lower())[-1]
    if end.lower() == "in" and word in _IN_INCHES:
        return "in"
    return "in/s" if end.lower() == "in_s" and word in _IN_INCHES_A_SECOND else None


def _of_a_time(stem: str, end: str) -> str | None:
    """The minutes of ``elapsed_min`` and the hours of ``time_h``; None where the stem is no time."""
    word = re.split(r"[\W_]+", stem.lower().removesuffix("_in").removesuffix(" in"))[-1]
    is_time = word in TIMES or is_of("ms", word)
    return _BEHIND_A_TIME.get(end.lower().rstrip(".")) if is_time else None


def _unit_of_end(end: str) -> str | None:
    """The unit that an end of a name is, in small letters too; a word in letters of any size (``Angle_Degrees``)."""
    if "Per" in end:  # mmPerS
        return _LOWER_ENDS.get("_".join(_CAPITAL.split(end)).lower())
    is_word = len(end) >= _WORD and end.isalpha()
    return ENDS.get(end) or (_LOWER_ENDS.get(end.lower()) if is_word or end.islower() else None)
