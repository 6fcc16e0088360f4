"""Names by which rheometers call shear rates, stresses, viscosities and moduli, in the languages of instruments."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterable, Mapping
from typing import Literal

import numpy as np

from erclutch.logs.columns.levels_in_names import stated_in, without_field
from erclutch.signals.array import Array

Quantity = Literal["rate", "stress", "viscosity"]
Role = Literal[Quantity, "other", "unknown"]

#: Words by which instruments and people name a column, as patterns over a plain name; German, French, Spanish, Chinese,
#: Japanese and more behind English. Quantities that share a word or a unit with a flow curve and are none come first.
_WORDS: dict[Role, tuple[str, ...]] = {
    "other": (
        *(
            "modul",
            "normal",
            "oscill",
            "complex",
            "komplex",
            "kinemat",
            "frequen",
            r"\bfreq\b",
            "yield",
            r"\bratio\b",
        ),
        # Numbers over those of a solvent or of a rest.
        *(r"\b(?:relativ|reduced|specific|intrinsic|inherent|differential)", "dimensionless"),
        *("reduziert", "spezifisch", "相对", "相対", "比粘度", "относит"),
        # What a field or a change adds, how far an oscillation goes.
        *(
            r"δ ?[τσ]",
            r"\bdelta[ -]?(?:tau|sigma|stress)",
            "increase",
            "increment",
            "zunahme",
            "difference",
            "differenz",
        ),
        *("augmentation", "amplitud", "增量", "振幅", "прирост"),
        # A fluid that is stretched is not sheared.
        *(
            "exten[st]",
            "elongat",
            "tensile",
            "stretch",
            "biaxial",
            "hencky",
            "dehnrate",
            "dehnvisk",
            "dehngesch",
        ),
        *("zugspann", "traction", "拉伸", "伸長", "растяж"),
        *("concentrat", "konzentrat", "концентрац", "浓度", "濃度"),
        *(
            r"\bstrain\b(?![ -]?rate)",
            "(?<!taux de )(?<!vitesse de )deformation",
            "torque",
            "drehmoment",
            "couple",
        ),
        *(
            r"\bpress(?:ure)?\b",
            r"\bdruck",
            r"\bpression",
            r"\bpres[is]on",
            "pressao",
            "压力",
            "圧力",
        ),
        *("speed", "drehzahl", "flow rate", "moment", r"\brpm\b", r"\bstress[ -]?rate"),
        *(
            "temp",
            "time",
            "zeit",
            "tiempo",
            "interval",
            "duration",
            "sampling",
            r"\bgap\b",
            "spalt",
            "angle",
            "winkel",
            "status",
        ),
        *(
            r"\bpoint",
            r"\bpts?\b",
            r"\bpkt",
            r"\bno\b",
            r"\bnr\b",
            r"stand\w+ dev",
            r"\bstd\b",
            "error",
        ),
        # How long a step took, and which rows of another table it is.
        *(r"\bdauer\b", r"\bduree\b", r"\bduracion\b", r"\bdurata\b", r"\bindex\b", r"\bcount\b"),
        # What replicates scatter by.
        *(
            r"\bs ?d\b",
            r"\bse\b",
            r"\bsem\b",
            r"\bst(?:d|ab)?dev",
            r"\brsd\b",
            r"\bcv\b",
            r"\berr\b",
            "±",
            "uncertain",
        ),
        *(
            "abweichung",
            "ecart[ -]type",
            "desviacion",
            "desvio",
            "标准偏?差",
            "標準偏差",
            "отклонен",
        ),
        *("температур", "врем", "давлен", "скорост. ротора", "об мин", "угол", "крутящ"),
        *("温度", "时间", "時間", "扭矩", "トルク", "序号", "点", "转速", "回転", "频率", "周波数"),
        # The highest stress of a start-up is no steady one; a tensor's component is numbered behind a colon.
        *(
            r"\bmax(?:imum)?\b",
            r"(?<!\d )\bmin(?:imum)?\b",
            r"\bci ?\d*\b",
            r"\bpeak\b",
            "overshoot",
            r":\d$",
        ),
    ),
    "viscosity": (
        *(
            "viscosi",
            "visko[sz]i",
            r"\bvisc\b",
            r"\beta\b",
            "η",
            "lepkosc",
            "вязкост",
            "점도",
            "粘度",
            "黏度",
            "粘性",
        ),
    ),
    "rate": (
        *(
            "shear[ -]?rates?",
            "strain[ -]?rate",
            "^rates?$",
            "gamma[ -]?dot",
            r"\bgammap\b",
            r"\bgp\b",
            r"\bsr\b",
        ),
        r"\bs rate\b",
        *(r"^d\b", "γ\u0307", "γ", "schergesch", "scherrate", "schergef", "gradient de"),
        *("(?:taux|vitesse) de (?:cisail|deform)",),
        *(
            "(?:velocidad|tasa) de (?:corte|ciza|deform)",
            "taxa de (?:cisalh|deform)",
            "gradiente di veloc",
        ),
        *(
            "velocita di taglio",
            "afschuifsnelheid",
            "szybkosc scin",
            "kayma h[iı]z",
            "скорост. (?:сдвига|деформац)",
        ),
        *("전단 ?(?:속도|율)", "剪切速[率度]", "剪切率", "せん断速度", "ずり速度", r"\bg ?dot\b"),
    ),
    "stress": (
        *(
            "shear[ -]?stress",
            r"\bstress\b",
            r"\btau\b",
            "τ",
            r"\bsigma\b",
            "σ",
            "^ss$",
            "schubspannung",
            "scherspannung",
        ),
        *(
            "contrainte",
            "cission",
            "esfuerzo",
            "tension (?:de corte|cort)",
            "tensao de (?:cisalh|corte)",
        ),
        *(
            "sforzo di taglio",
            "schuifspanning",
            "naprezenie scin",
            "kayma gerilm",
            r"напряж\w* сдвига",
        ),
        *(
            "전단 ?응력",
            "剪切应力",
            "剪切力",
            "剪應力",
            "剪应力",
            "切应力",
            "せん断応力",
            "ずり応力",
        ),
    ),
}
#: Columns that only an oscillation fills: what is stored and lost in a turn there and back.
_OSCILLATION = re.compile(
    r"(?:storage|loss|complex) (?:shear )?modul|\b(?:g|eta|n)\*(?!c?m?m\b)|η\*|\bg'|\(elastic component\)"
    r"|speichermodul|verlustmodul"
    r"|complex viscosity|komplexe viskos"
    r"|module de (?:conservation|perte)|modulo de (?:almacen|perda|perdida)|[储儲貯贮][能存蔵](?:模量|弹性率|弾性率)"
    r"|损耗模量|損失弾性率|\bg ?(?:prime|[′’´`])|tan ?\(?(?:delta|δ)|verlustfaktor|loss (?:factor|tangent)"
)
#: A stress over a yield stress, a viscosity over that of a solvent.
_QUOTIENT = re.compile(
    r"(?:tau|sigma|eta|visc|stress|[τση])[\w ]*/\s*(?:tau|sigma|eta|visc|stress|[τση])"
)
_LONGEST = 100  # characters of a name
_TIME = re.compile(r"\btime\b|^t\b|zeit|\btemps\b|tiempo|tempo|врем|时间|時間|시간")
_STRAIN = re.compile(
    r"\bstrain\b(?![ -]?rate)|dehnung|deformation(?! ?rate)|деформац|应变|歪|ひずみ|변형률"
)
_STEADY = 0.002  # of its median: a stress that stays within was set, as no fluid keeps its stress
_SET = 0.02  # of its median: so was a strain
_NEARLY_ALL = 0.9  # of the rows: the others are the step to what is held
_BY_NAME: dict[Role, re.Pattern[str]] = {
    role: re.compile("|".join(words)) for role, words in _WORDS.items()
}
_LOGARITHM = re.compile(r"(?:log|lg|ln)[ _]?(?:10)?[ _(\[]|log10|sqrt|root|√")


def plain_name(name: str) -> str:
    """A name in small letters without accents, with spaces for underscores."""
    signs = unicodedata.normalize("NFKD", name.lower())
    # The dot above gamma stays: it makes a strain a rate. So do the marks of Japanese letters.
    bare = "".join(
        sign for sign in signs if sign in "\u0307\u3099\u309a" or not unicodedata.combining(sign)
    )
    bare = unicodedata.normalize("NFC", bare)
    return re.sub(r"[_\s./]+", " ", bare).strip()


def said_by_name(name: str) -> Role:
    """The role that a name alone speaks for."""
    if "/" in name and _QUOTIENT.search(name[:_LONGEST].lower()):
        return "other"
    plain = plain_name(re.sub(r"\s*\(\d+\)$", "", name))
    for role, pattern in _BY_NAME.items():
        if pattern.search(plain):
            return role
    return "unknown"


def is_a_logarithm(name: str) -> bool:
    """Whether a column holds logarithms, or roots as Casson's plot has them: they are no rates and no stresses."""
    return _LOGARITHM.match(name.lower().lstrip("(")) is not None


def tells_a_flow_curve(names: Iterable[str]) -> bool:
    """Whether names tell a shear rate, and a shear stress or a viscosity, or levels of a field alone (``1 kV/mm``)."""
    others: list[str] = []
    said: set[str | None] = set()
    for name in names:
        said.add(said_by_name(name))
        if said_by_name(name) != "rate":
            others.append(name)
    if "rate" not in said:
        return False
    are_levels = all(
        stated_in(name) is not None and not plain_name(without_field(name)) for name in others
    )
    return not said.isdisjoint(("stress", "viscosity")) or (len(others) > 1 and are_levels)


def of_oscillation(names: Iterable[str]) -> list[str]:
    """The names of columns that only an oscillation fills."""
    return [name for name in names if _OSCILLATION.search(plain_name(name))]


def held_in_time(columns: Mapping[str, Array]) -> str:
    """What a rheometer's course in time is that holds its stress or its strain, to end a sentence; "" for others.

    A creep and a relaxation tell of a fluid's memory: they have neither a flow curve nor the motion of a device.

    Args:
        columns: of a table, each shape (n,).
    """
    plain = {name: plain_name(name) for name in columns}
    strains = [name for name in columns if _STRAIN.search(plain[name])]
    stresses = [name for name in columns if said_by_name(name) == "stress"]
    has_a_time = any(_TIME.search(each) for each in plain.values())
    if not has_a_time or len(strains) != 1 or len(stresses) != 1:
        return ""
    stress = columns[stresses[0]]
    strain = columns[strains[0]]
    if _is_held(stress, _STEADY) and not _is_held(strain, _SET):
        return f"a creep of a rheometer: it holds {stresses[0]} and watches {strains[0]}"
    if _is_held(strain, _SET) and not _is_held(stress, _SET):
        return f"a relaxation of a rheometer: it holds {strains[0]} and watches {stresses[0]}"
    return ""


def _is_held(values: Array, share: float) -> bool:
    """Whether nearly all values are one number to so large a share of it, and no zero."""
    known = values[np.isfinite(values)]
    if known.size < 6:
        return False
    middle = float(np.median(known))
    return (
        middle != 0.0
        and float(np.mean(np.abs(known - middle) <= share * abs(middle))) >= _NEARLY_ALL
    )
