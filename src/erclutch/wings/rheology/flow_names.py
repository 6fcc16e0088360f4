"""By their names columns of a flow curve are rates, stresses or viscosities, in the languages of instruments."""

from __future__ import annotations

import re
import unicodedata
from typing import Literal

Quantity = Literal["rate", "stress", "viscosity"]
Role = Literal[Quantity, "other", "unknown"]

#: Words by which instruments and people name a column, as patterns over a plain name; German, French, Spanish, Chinese
#: and Japanese behind English. Quantities that share a word or a unit with a flow curve and are none come first.
_WORDS: dict[Role, tuple[str, ...]] = {
    "other": (
        *("modul", "normal", "oscill", "complex", "komplex", "kinemat", "frequen", r"\bfreq\b", "yield", "ratio"),
        *(r"\bstrain\b(?! ?rate)", "deformation", "torque", "drehmoment", "couple", "speed", "drehzahl", "flow rate"),
        *("temp", "time", "zeit", "tiempo", "interval", "sampling", r"\bgap\b", "spalt", "angle", "winkel", "status"),
        *(r"\bpoint", r"\bpts?\b", r"\bpkt", r"\bno\b", r"\bnr\b"),
        *("温度", "时间", "時間", "扭矩", "トルク", "序号", "点"),
    ),
    "viscosity": ("viscosi", "viskosi", r"\bvisc\b", r"\beta\b", "η", "粘度", "黏度", "粘性"),
    "rate": (
        *("shear ?rates?", "strain ?rate", "^rates?$", "gamma ?dot", r"\bgammap\b", r"\bgp\b", r"\bsr\b", r"\bd\b"),
        *("γ\u0307", "γ", "schergesch", "scherrate", "schergef", "taux de cisail", "vitesse de cisail", "gradient de"),
        *("velocidad de (?:corte|ciza)", "tasa de (?:corte|ciza)", "剪切速率", "剪切率", "せん断速度", "ずり速度"),
    ),
    "stress": (
        *("shear ?stress", r"\bstress\b", r"\btau\b", "τ", r"\bsigma\b", "σ", "schubspannung", "scherspannung"),
        *("contrainte", "cission", "esfuerzo", "tension (?:de corte|cort)"),
        *("剪切应力", "剪應力", "切应力", "せん断応力", "ずり応力"),
    ),
}
_BY_NAME: dict[Role, re.Pattern[str]] = {role: re.compile("|".join(words)) for role, words in _WORDS.items()}


def plain_name(name: str) -> str:
    """A name in small letters without accents, with spaces for underscores."""
    signs = unicodedata.normalize("NFKD", name.lower())
    # The dot above gamma stays: it makes a strain a rate.
    bare = "".join(sign for sign in signs if sign == "\u0307" or not unicodedata.combining(sign))
    return re.sub(r"[_\s./]+", " ", bare).strip()


def said_by_name(name: str) -> Role:
    """The role that a name alone speaks for."""
    plain = plain_name(re.sub(r"\s*\(\d+\)$", "", name))
    for role, pattern in _BY_NAME.items():
        if pattern.search(plain):
            return role
    return "unknown"
