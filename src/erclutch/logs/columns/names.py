"""Names of columns speak for signals, in the languages and the shorthand that people and instruments write.

A name speaks whole (``drehmoment``), without the words beside it (``motor torque, measured``), or by its head: the last
word of an English name, the first of a French or Spanish one, the end of a German or Chinese compound.
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise

from erclutch.logs.columns.labels import EASTERN, split_end


def _set(words: str) -> frozenset[str]:
    return frozenset(words.split())


def plain(name: str) -> str:
    """A name in small letters, without signs."""
    letters = unicodedata.normalize("NFKD", name)
    return re.sub(r"[\W_]", "", letters).lower()


# Names in small letters without signs and accents; a column of another unit than the signal's is no candidate.
NAMES = {
    "field": "field e i u b v voltage current coilcurrent icoil drivecurrent command cmd excitation pwm duty volt amp "
    "amps cur curr strom spannung spulenstrom feld courant tension corriente voltaje tensao corrente tensione iq id "
    "uq ud ia udc fluxdensity magneticfluxdensity magneticflux flux bfield flussdichte induction inducao induccion "
    "磁感应强度 磁通密度 磁束密度 磁场强度 磁場強度 电场强度 電界強度 电流 电压 励磁电流 线圈电流 電流 電圧 "
    "ток напряжение 전류 전압 prad napiecie proud napeti stroom akım gerilim",
    "slip": "slip w v n omega speed velocity vel sliprate slipspeed shearrate gammadot relativespeed rpm anglevelocity "
    "vs vrel drehzahl geschwindigkeit winkelgeschwindigkeit schlupf vitesse velocidad velocidade velocita "
    "thetadot dtheta thetad xdot dx dxdt xd dq qd qdot qvel ydot dy phidot dphi angvel velo spd rotationspeed "
    "速度 转速 角速度 滑差 轉速 回転数 回転速度 "
    "скорость обороты частотавращения угловаяскорость 속도 각속도 회전수 회전속도 predkosc predkoscobrotowa "
    "obroty rychlost otacky snelheid toerental varvtal hastighet hız rotacao giri",
    "position": "position pos x d displacement disp stroke travel angle slipangle weg winkel hub verschiebung "
    "deplacement desplazamiento deslocamento spostamento posicion posicao angulo "
    "theta phi q qpos y s encoder enc extension crosshead drehwinkel auslenkung posizione spostamento carrera course "
    "位移 角度 转角 位置 行程 変位 ストローク "
    "перемещение положение угол ход 변위 위치 각도 przemieszczenie połozenie poloha uhel verplaatsing "
    "positie hoek vinkel konum elongation allongement elongacion alargamiento alongamento allungamento verlangerung "
    "verlaengerung wydluzenie 伸长 伸び 伸长量 удлинение",
    "effort": "effort force torque f m load moment shearstress tau t te drehmoment kraft moment couple fuerza par "
    "forca coppia forza fx fy fz mx my mz tx ty tz loadcell torq trq frc schubspannung torsion effet dampingforce "
    "dampkraft friction tauf taufric reibung frottement 摩擦力 力 扭矩 转矩 力矩 载荷 荷载 阻尼力 荷重 トルク "
    "момент крутящиимомент сила усилие нагрузка 토크 힘 하중 모멘트 마찰력 siła sila kracht koppel vridmoment "
    "obciazenie kuvvet tork ff ffric",
    "E1": "e1 field1 ech1",
    "E2": "e2 field2 ech2",
    "E": "e field",
    "theta": "theta motorangle",
    "theta_dot": "thetadot dtheta motorspeed",
    "alpha": "alpha outputangle",
    "alpha_dot": "alphadot dalpha outputspeed",
    "alpha_raw": "alpharaw screwposition tableposition",
    "T": "torque effort t",
    "motor_torque": "motortorque torquecommand torquecmd",
}
_NAMES = {signal: frozenset(map(plain, names.split())) for signal, names in NAMES.items()}
SINGLE = ("field", "slip", "position", "effort")
#: Words for one signal of several joints, as lists and matrices of a robot are called: joint_velocities_3.
_OF_SEVERAL = {
    "positions": "position",
    "speeds": "speed",
    "velocities": "velocity",
    "torques": "torque",
    "efforts": "effort",
    "forces": "force",
    "currents": "current",
    "angles": "angle",
    "voltages": "voltage",
    "loads": "load",
    "moments": "moment",
}
# Words beside the name that say where or how it was measured.
_BESIDE = _set(
    "measured meas mea msr actual act ist mess gemessen sensor filtered filt motor engine output brake clutch damper "
    "shaft piston angular rotational linear relative total machine cart friction cell du de der des moteur "
    "exp experimental mesure mesuree medida compensate compensated corrected raw value j feedback fb fbk fdb "
    "front rear left right upper lower inner outer fl fr rl rr vorn vorne hinten links rechts avant arriere "
    "gauche droite"
)
#: Words of what a drive was told, and of what is neither signal: no guess is made from the unit of such a column.
TOLD = _set(
    "setpoint set target desired demand demanded commanded command cmd ref reference goal soll consigne consigna "
    "setpt sollwert ziel objetivo consegna"
)
#: What a Chinese or Japanese compound is called by that was told to a supply or a drive.
EASTERN_TOLD = ("设定", "設定", "目标", "目標", "指令", "给定", "命令", "설정", "목표", "지령")
#: Words that say in which sense a device moves, in a column beside a speed without a sign.
SENSES = _set(
    "cw ccw clockwise counterclockwise anticlockwise forward forwards fwd backward backwards back bwd reverse rev left "
    "right up down upward downward in out push pull compression rebound bump extension extend retract positive "
    "negative pos neg vor vorwarts ruck ruckwarts zuruck links rechts auf ab zug druck avant arriere gauche "
    "droite traction adelante atras izquierda derecha"
)
OTHER = _set(
    "pressure druck pression presion presiones pressione pressao temperature temp esc vibration gap diameter thickness "
    "separation abstand werkzeugabstand "
    "noise error normal accuracy resolution power viscosity strain crack radius size length width mass weight h fn "
    "horsepower count counts cycle cycles index sample samples no nr number frame packet seq row rows point points "
    "acceleration accelerazione accel acc accx accy accz beschleunigung aceleracion jerk humidity energy efficiency "
    "wirkungsgrad leistung puissance potencia temperatur temperatura stiffness coefficient coeff mu density inertia "
    "longitud longueur comprimento lunghezza masa masse massa segmento odkształcenie odksztalcenie laps "
    "dehnung stauchung querdehnung zugspannung druckspannung contrainte deformation deformacion deformacao "
    "yield wear film area volume cof latitude longitude altitude date datum fecha err fehler latency delay dt "
    "давление температура вязкость"
)
#: What was computed or bounds a measurement is none.
NOT_MEASURED = _set(
    "predicted pred estimated est estimate simulated sim model calc calculated computed theoretical expected limit max "
    "min std var offset bias residual fit fitted ideal nominal peak design diseno prev previous"
)
#: What the parts of an effort are called that a model adds up.
PARTS_OF_A_MODEL = _set(
    "gravity gravitational friction damping damper inertia inertial coriolis centrifugal viscous coulomb spring "
    "elastic aero aerodynamic drag static stiction schwerkraft gravitation reibung reib daempfung dampfung traegheit"
)
#: Models of friction and networks: a column of such a name holds what a model says of the effort.
_MODELS = _set("dahl lugre stribeck boucwen svm svr pinn lstm gru mlp ann gms maxwellslip")
# Words that turn the head of a name to another thing than the device's own signal.
_AGAINST = {
    "field": _set("battery supply bus link sensor cell strain batt bat psu vbat cc dark leak shunt hall lvdt gauge "
                  "gage potentiometer pot poti tacho tachometer transducer thermocouple thermistor photodiode adc "
                  "led lamp fan heater payload leakage"),
    "slip": _set("rolling entrainment wind air fan pump flow sound stream freestream data frequency freq frequenz "
                 "frame sampling refresh ball disc"),
    "position": _set("throttle valve pedal gps cursor mouse time phase attack incidence"),
    "effort": _set("ball clamp gravity preload clamping gewichts"),
}  # fmt: skip
#: Whose effort is what a loop tells a drive, often in volts.
_LOOPS = frozenset({"control", "controller", "ctrl", "pid"})
#: Short names that mean several things.
NEED_UNIT = _set(
    "v vs vrel t m d n e u b x tau ff load id te par tension q y s phi qd dq dx dy xd course effet torsion id "
    "friction reibung frottement fx fy fz mx my mz tx ty tz"
)
VOLTAGES = _set("u v uq ud udc voltage volt spannung tension voltaje tensao tensione 电压 電圧")
CURRENTS = _set("i iq id idc current strom courant corriente corrente amp amps cur curr 电流 電流")
_ROMANCE = _set(
    "vitesse velocidad velocidade velocita couple force fuerza forza forca par coppia deplacement desplazamiento "
    "deslocamento spostamento posicion posicao posizione angle angulo courant corriente corrente "
    "скорость момент сила ток напряжение перемещение угол усилие predkosc rychlost hastighet"
)
_GERMAN = {
    "field": ("strom", "spannung"),
    "slip": ("drehzahl", "geschwindigkeit"),
    "position": ("weg", "winkel", "hub"),
    "effort": ("moment", "kraft"),
}
_GERMAN_OTHERS = (
    "soll",
    "normal",
    "traegheits",
    "tragheits",
    "schub",
    "scher",
    "quer",
    "gewichts",
    "massen",
    "bezugs",
)
# Compounds that end like a signal and are none: an acceleration, a pressure, a power.
_CJK_OTHERS = (
    *(
        "加速度",
        "压力",
        "壓力",
        "圧力",
        "应力",
        "応力",
        "功率",
        "动力",
        "电力",
        "電力",
        "误差",
        "温度",
        "频率",
    ),
    *(
        "目标",
        "目標",
        "设定",
        "指令",
        "给定",
        "命令",
        "速度比",
        "时间",
        "時間",
        "序号",
        "编号",
        "番号",
        "效率",
        "効率",
    ),
)
_TIME = re.compile(
    r"t|time(?:elapsed|passed)?|zeit|uhrzeit|tijd|temps|tiempo|tempo|timestamps?|elapsed(?:time)?|steptime|seconds?|sec|tsec|times|"
    r"(?:ros|bag|rosbag|test|run|total|sample|relative|local|system|log|rec|elapsed|unix|epoch)?time(?:stamp)?s?|"
    rf"время|{plain('시간')}|czas|cas|tid|zaman|"
    r"stamp|zeitstempel|messzeit|tempsecoule|tiempotranscurrido|.{0,4}时间戳?|时刻|.{0,4}時間|時刻|millis|micros|"
    r"time\d+\w{0,12}samplerate|milliseconds|microseconds|time(?:arr|array|vec|vector)",
    re.IGNORECASE,
)
_SIDE = re.compile(r"(?<=[^\W\d_]{2})[ _-][A-DLR]$")
_PRIME = re.compile(r"['\"′″](?!\w)")  # force d'amortissement has none
_QUOTED = re.compile(r'"([^"]{2,})"')
_AXES = _set("x y z r")
_JOINT = re.compile(r"(?:a|j|ax|axis|joint|dof|achse|gelenk)\d{1,2}")  # MeasuredTorque_A1
_BORDER = re.compile(
    r"(?<=[a-z])(?=[A-Z])|(?<=(?<![A-Za-z])[XYZ])(?=[A-Z][a-z])"
)  # angularVelocity, XVelocity
# The rate of a rate: ddq, qdd, d2x, theta_ddot.
_SHORT_POSITIONS = r"(?:q|x|y|z|s|theta|phi|alpha|pos|angle)"
_SECOND_RATE = re.compile(rf"d(?:d|2){_SHORT_POSITIONS}|{_SHORT_POSITIONS}(?:dd|ddot|2dot|dotdot)")


@dataclass(frozen=True)
class SpokenName:
    """What the name of a column says, for all signals at once.

    Attributes:
        stem: the name without the unit that ends it.
        end: that unit, or None.
        plain: the name in small letters, without signs; and so the stem.
        words: of the whole name.
        stem_words: of the stem.
        forms: signal -> the name that speaks for it, see `_called_as`.
        heads: signal of a single device -> the head of the name, see `headed`.
        numbered: signals of a single device whose name stands in front of a joint's or a channel's number (``dq3``).
        may_be: signals of a single device for which its form, its head, or a name in front of a number speaks.
        within: signals of a single device that a word anywhere in the name speaks for (``act_torque_abs``), where no
            word says that it is something else: enough to propose a column, not to take it.
        lettered: signals of a single device that a letter with an index may be (``x_p``, ``i_c``).
        turned: signals of which a word of the name makes another thing: what was computed, a limit, a rolling speed.
        is_of_a_model: whether the column is called like a model of friction or a network: it holds what the model says.
        is_primed: whether the name has a prime, as G' and G" have: the moduli of an oscillation.
        is_time: whether the column is called like the time.
        ends_in_time: whether its last word is a time.
        is_accounted: whether the name says that the column is no field.
    """

    stem: str
    end: str | None
    plain: str
    plain_stem: str
    words: tuple[str, ...]
    stem_words: tuple[str, ...]
    forms: Mapping[str, str | None]
    heads: Mapping[str, str | None]
    numbered: frozenset[str]
    may_be: frozenset[str]
    within: frozenset[str]
    lettered: frozenset[str]
    turned: frozenset[str]
    is_of_a_model: bool
    is_primed: bool
    is_time: bool
    ends_in_time: bool
    is_accounted: bool

    @property
    def bare_stem(self) -> str:
        """The stem in small letters without the number of a joint, a motor or a channel behind it."""
        return self.plain_stem.rstrip("0123456789")

    def says(self, words: frozenset[str]) -> bool:
        """Whether a word of the stem is one of these."""
        return not words.isdisjoint(self.stem_words)


def spoken_name(name: str) -> SpokenName:
    """What a name says."""
    stem, end = split_end(name)
    return spoken(name, stem, end)


@lru_cache(maxsize=4096)
def spoken(name: str, stem: str, end: str | None) -> SpokenName:
    """What a name says; the same for every column of this name.

    Args:
        name: of a column.
        stem: the name without the unit that ends it.
        end: that unit, or None.
    """
    plain_stem = plain(stem)
    stem_words = tuple(words_of(stem))
    forms = {signal: _called_as(name, stem, signal) for signal in NAMES}
    heads = {signal: headed(stem, signal) for signal in SINGLE}
    may_be = {signal for signal in SINGLE if forms[signal] or heads[signal]}

    turned: set[str] = set()
    for signal in NAMES:
        against = NOT_MEASURED | _AGAINST.get(signal, frozenset())
        if signal == "effort" and _is_effort_of_a_loop(stem_words):
            against |= _LOOPS
        if not against.isdisjoint(stem_words):
            turned.add(signal)

    numbered: set[str] = set()
    bare = plain_stem.rstrip("0123456789")
    if bare != plain_stem:
        alone = "".join(word for word in stem_words if word not in _BESIDE).rstrip(
            "0123456789"
        )  # of motor_dq_0: dq
        numbered = {signal for signal in SINGLE if not _NAMES[signal].isdisjoint((bare, alone))}

    within: set[str] = set()
    if (TOLD | OTHER | NOT_MEASURED).isdisjoint(stem_words):
        words = {word for word in stem_words if len(word) > 2}
        if any(_NAMES[signal] & (words - {"load"}) for signal in ("slip", "position")):
            words -= {"load"}  # the side of a spring whose angle is meant
        within = {
            signal
            for signal in SINGLE
            if signal not in turned and not _NAMES[signal].isdisjoint(words)
        }
    return SpokenName(
        stem,
        end,
        plain(name),
        plain_stem,
        tuple(words_of(name)),
        stem_words,
        forms,
        heads,
        numbered=frozenset(numbered),
        may_be=frozenset(may_be | numbered),
        within=frozenset(within),
        turned=frozenset(turned),
        lettered=frozenset(
            signal
            for signal in SINGLE
            if _has_index(stem_words) and stem_words[0] in _NAMES[signal]
        ),
        is_of_a_model=not _MODELS.isdisjoint(
            [plain(name), *stem_words, *map("".join, pairwise(stem_words))]
        ),
        is_primed=_is_primed(stem),
        is_time=_is_time(name, stem),
        ends_in_time=_ends_in_time(stem_words),
        is_accounted=_is_accounted(stem),
    )


def _is_primed(name: str) -> bool:
    """Whether a name has a prime; quotes around a part of it, as Siemens writes them, are none."""
    return _PRIME.search(_QUOTED.sub(r"\1", name)) is not None


def _has_index(words: Sequence[str]) -> bool:
    """Whether a name is a letter with an index of one or two letters."""
    if len(words) != 2:
        return False
    letter, index = words
    return len(letter) == 1 and len(index) <= 2 and index.isalpha()


def words_of(name: str) -> list[str]:
    """Words of a name, in small letters: at signs, where a small letter meets a large one, and behind an axis."""
    apart = _BORDER.sub(" ", unicodedata.normalize("NFKD", name))
    words = re.sub(r"[^\w\s]|_", " ", re.sub("[\u0300-\u036f]", "", apart)).lower().split()
    if (
        "des" in words and len(words) > 1
    ):  # short for desired at an end, and an article between two French words
        letters = [
            place for place, word in enumerate(words) if not word.isdecimal() and word not in _AXES
        ]
        for place in (letters[0], letters[-1]) if letters else ():
            words[place] = "desired" if words[place] == "des" else words[place]
    return [_OF_SEVERAL.get(word, word) for word in words]


def _called_as(name: str, stem: str, signal: str) -> str | None:
    """The name that speaks for a signal: the whole of it, or what is left without its unit.

    For a single device also what is left without the words beside it; the pair has a motor and an output to tell apart.
    """
    if _is_primed(stem):
        return None  # E' is a fluctuation, G" a loss modulus: neither is E or G
    forms = [plain(name), plain(stem)]
    if signal in SINGLE:
        # A side is a letter: Torque_A beside Torque_B. A coil's A and V are units.
        bare = stem if signal == "field" else _SIDE.sub("", stem)
        forms.append("".join(word for word in words_of(bare) if word not in _BESIDE))
    return next((form for form in forms if form in _NAMES[signal]), None)


def headed(stem: str, signal: str, shared: Collection[str] = ()) -> str | None:
    """The head of a name, where that is a name of a signal of a single device; None for another head.

    ``pitch_velocity`` and ``Traction Force`` are headed; a predicted force, a torque's limit, a rolling speed and the
    voltage of a force sensor are not.

    Args:
        stem: the column's name without the unit that ends it.
        signal: its name.
        shared: words that most columns have in their names, which say nothing of a single one.
    """
    if signal not in SINGLE or _is_primed(stem):
        return None
    if EASTERN.search(stem):
        return _compound(plain(stem), signal)
    parts = [
        re.sub(r"\d+$", "", word)
        for word in words_of(stem)
        if word not in shared and not _JOINT.fullmatch(word)
    ]
    parts = [word for word in parts if word]
    if "per" in parts:
        return None  # a torque per rpm is no speed, and no torque
    while len(parts) > 1 and parts[-1] in _AXES | _BESIDE:
        parts.pop()
    if not parts or {*parts} & (TOLD | OTHER | NOT_MEASURED | _AGAINST[signal]):
        return None
    if signal == "effort" and _is_effort_of_a_loop(parts):
        return None

    heads = [(parts[:-1], parts[-1])]  # the words beside a head, and the head
    if parts[0] in _ROMANCE:
        heads.append((parts[1:], parts[0]))
    if len(parts) > 1:
        heads.append((parts[:-2], "".join(parts[-2:])))
    for rest, head in heads:
        known = head in _NAMES[signal] or _german(head, signal)
        if len(head) > 1 and known and not any(_speaks(word, signal) for word in rest):
            return head
    return None


def _is_effort_of_a_loop(words: Iterable[str]) -> bool:
    """Whether a name is that of a control effort: what a loop tells a drive, and no torque or force of a device."""
    return "effort" in words and not _LOOPS.isdisjoint(words)


def _is_time(name: str, stem: str) -> bool:
    """Whether a column is called like the time; a large T is a torque."""
    if name == "T":
        return False
    return any(_TIME.fullmatch(letters) for letters in (plain(name), plain(stem)))


_TIMES = _set("time timestamp timestamps stamp zeit temps tiempo tempo tijd sec secs seconds")
_NO_TIMES = _set(
    "dead rise fall settling response delay cycle start end stop begin step dwell hold rest constant lag reaction mean "
    "exposure run duration"
)


def _ends_in_time(words: Sequence[str]) -> bool:
    """Whether the last word of a name is a time, and no word makes a span of it: a machine's, a logger's, a channel's.

    French and Spanish names may begin with the time.
    """
    if not words or {*words} & (_NO_TIMES | OTHER):
        return False
    return words[-1] in _TIMES or words[0] in ("temps", "tiempo")


def _speaks(word: str, signal: str) -> bool:
    """Whether a word speaks for another signal than this: the voltage of a force sensor is no field.

    The velocity of a stroke is a velocity, and the load of a load's speed is a shaft.
    """
    if word == "load" and signal in ("slip", "position"):
        return False
    others = {*SINGLE} - {signal} - ({"position"} if signal == "slip" else set())
    return any(len(word) > 2 and word in _NAMES[other] for other in others)


def _german(word: str, signal: str) -> bool:
    ends = tuple(end for end in _GERMAN[signal] if len(word) > len(end) + 2)
    return bool(ends) and word.endswith(ends) and not word.startswith(_GERMAN_OTHERS)


def _compound(name: str, signal: str) -> str | None:
    """The end of a Chinese or Japanese compound that names a signal."""
    if any(other in name for other in _CJK_OTHERS):
        return None
    longest_first = sorted(_NAMES[signal], key=len, reverse=True)
    return next((end for end in longest_first if EASTERN.search(end) and name.endswith(end)), None)


def _is_accounted(stem: str) -> bool:
    """Whether a name says what the column is, and that it is no field: another quantity, or one of another signal."""
    if EASTERN.search(stem):
        others = [*_CJK_OTHERS]
        for signal in SINGLE[1:]:
            others += [word for word in _NAMES[signal] if EASTERN.search(word)]
        return any(word in plain(stem) for word in others)
    spoken = {re.sub(r"\d+$", "", word) for word in words_of(stem)}
    if _SECOND_RATE.fullmatch(plain(stem).rstrip("0123456789")):
        return True
    if spoken & OTHER or any(_speaks(word, "field") for word in spoken):
        return True
    return any(_german(word, signal) for word in spoken for signal in SINGLE[1:])
