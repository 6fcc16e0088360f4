"""How engineers write units, in the languages and the machines of this world, and what pint understands by each.

A line here is all that another spelling takes.
"""

from __future__ import annotations

import re

#: Raised digits and signs, as they are written on the line.
RAISED = str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹⁺⁻", "0123456789+-")
# A turn, a minute and a second in a score of languages: what stands over the line of a fraction, and under it.
_TURN = (
    r"(?:U|[Uu]mdr|[Uu]mdrehungen|r|R|REV|trs?|tours?|revs?|rotations?|giri|giros?|vueltas?|obr|ot|omw|varv|kierr|rot|ford|f(?=\s*/\s*perc)"
    r"|(?:d|dev|devir)(?=\s*/\s*(?:dk|dak|sn|san))|t(?=\s*/\s*mi?n(?!\w))|обор|στρ|vòng|รอบ|회전)\.?"
)
_MINUTE = r"(?:mn|MIN|minut[oa]|минут[уы]|dk|dak|dakika|perc|λεπτό|phút|นาที|분)(?!\w)"
_SECOND = r"(?:sn|san|saniye|δευτ|giây)(?!\w)"
_FRACTIONS = (
    (rf"(?<![\w.]){_TURN}(?=\s*/)", "turn"),
    (rf"(?<![\w.]){_TURN}\s?[.·]?\s?min\s?(?:\^?-1|⁻¹)", "turn/min"),
    (rf"/\s*{_MINUTE}", "/min"),
    (rf"/\s*{_SECOND}", "/s"),
    (r"(?<!\w)(?:r\.\s?p\.\s?m\.?|upm|σ\.α\.λ\.?)(?!\w)", "rpm"),
)
# A minus one that stands for the line of a fraction: no bench counts in turns of a millisecond.
_OVER_A_SECOND = tuple(
    (rf"{written}\s?(?:\^?-1|⁻¹)", f"{length}/s")
    for written, length in (
        ("ms", "m"),
        ("mms", "mm"),
        ("cms", "cm"),
        ("rads", "rad"),
        ("degs", "deg"),
    )
)
# Chinese, Japanese and Korean units, the longer before the shorter that it holds.
_EASTERN = (
    (r"(?:转|轉|回転|(?<![A-Za-z])r)\s*(?:/|每|毎)\s*(?:分钟|分鐘|分|min)", "rpm"),
    ("毫秒|ミリ秒|밀리초", "ms"),
    ("微秒", "us"),
    ("分钟|分鐘|分", "min"),
    ("秒|초", "s"),
    ("微米", "um"),
    ("毫米|ミリメートル", "mm"),
    ("厘米", "cm"),
    ("米|メートル", "m"),
    ("弧度|ラジアン", "rad"),
    ("度", "deg"),
    ("千牛|キロニュートン", "kN"),
    ("牛顿|牛|ニュートン", "N"),
    ("毫安", "mA"),
    ("安培|安|アンペア", "A"),
    ("毫伏", "mV"),
    ("伏特|伏|ボルト", "V"),
    ("毫特", "mT"),
    ("高斯", "G"),
    ("千帕", "kPa"),
    ("帕|パスカル", "Pa"),
)
_CYRILLIC = (
    ("с", "s"),
    ("сек", "s"),
    ("мс", "ms"),
    ("мин", "min"),
    ("м", "m"),
    ("мм", "mm"),
    ("см", "cm"),
    ("мкм", "um"),
    ("км", "km"),
    ("мкс", "us"),
    ("ч", "h"),
    ("об", "turn"),
    ("кг", "kg"),
    ("кгс", "kgf"),
    ("рад", "rad"),
    ("град", "deg"),
    ("Н", "N"),
    ("кН", "kN"),
    ("мН", "mN"),
    ("Нм", "N*m"),
    ("кНм", "kN*m"),
    ("мНм", "mN*m"),
    ("Па", "Pa"),
    ("кПа", "kPa"),
    ("мПа", "mPa"),
    ("МПа", "MPa"),
    ("А", "A"),
    ("мА", "mA"),
    ("мкА", "uA"),
    ("В", "V"),
    ("мВ", "mV"),
    ("кВ", "kV"),
    ("Тл", "T"),
    ("мТл", "mT"),
    ("Гс", "G"),
)
# Written unit -> what pint understands by it. Pint reads Nm as newton x molal, U/min as enzyme units, gauss in CGS.
SPELLINGS = (
    # As names of variables are written, where a capital begins a word: degPerSec, NPerMm, degParSec.
    *(
        (re.compile(rf"(?<=[A-Za-z])P(?:er|ar|or){capital}(?![A-Z\d])"), f"/{capital.lower()}")
        for capital in "SMHKDRCI"
    ),
    # A share of what is stated behind it: % of 3000 rpm.
    (
        re.compile(
            r"^(?:100\s?%\s?=|%\s?(?:of|von|vom|de|di|del|van)?(?![^\W\d]))\s*(\d+(?:\.\d+)?)\s*(?=[^\W\d])"
        ),
        r"0.01*\1*",
    ),
    *((re.compile(written), means) for written, means in _FRACTIONS),
    *((re.compile(rf"(?<![\w.]){written}(?!\w)"), means) for written, means in _OVER_A_SECOND),
    *((re.compile(written), means) for written, means in _EASTERN),
    # A power may stand behind: кгс/см², Н/м2.
    *((re.compile(rf"(?<!\w){written}(?![^\W\d²³])"), means) for written, means in _CYRILLIC),
    (re.compile(r"\b(?:oz|ozf|ounces?)\s*[-.*·]?\s*in(?:ch|ches)?\b"), "ounce_force*inch"),
    (re.compile(r"\bin\s*[-.*·]?\s*(?:oz|ozf)\b"), "ounce_force*inch"),
    *(
        (
            re.compile(
                rf"\b(?:{pounds}\s*[-.*·]?\s*{arm}|{arm}\s*[-.*·]?\s*{pounds})\b", re.IGNORECASE
            ),
            means,
        )
        for pounds in ("(?:lbf|lbs|lb|pounds?)",)
        for arm, means in (
            ("(?:inch|in)", "pound_force*inch"),
            ("(?:foot|feet|ft)", "pound_force*foot"),
        )
    ),
    (re.compile(r"(?<![\w.])lbs?f?(?!\w)", re.IGNORECASE), "pound_force"),
    # Some machines write in capitals, and nothing is over a siemens.
    (re.compile(r"/\s*(?:S|SEC|Sec)(?!\w)"), "/s"),
    *(
        (re.compile(rf"(?<![\w.]){capitals}(?!\w)"), capitals.lower())
        for capitals in ("MM", "CM", "M", "IN", "DEG", "MS", "AMPS", "GAUSS")
    ),
    (re.compile(r"(?<![\w.])(?:SEC|Sec)(?!\w)"), "s"),
    (re.compile(r"(?<![\w.])KN(?!\w)"), "kN"),
    (re.compile(r"(?<![\w.])K[Gg](f?)(?!\w)"), r"kg\1"),  # kelvin times gram is nothing
    (re.compile(r"(?<![\w.])K[Pp]a(?!\w)"), "kPa"),
    (re.compile(r"(?<![\w.])KV(?!\w)"), "kV"),
    # Pint reads kmph as a thousand miles an hour.
    (re.compile(r"(?<![\w.])(?:[Kk]mp?h|KMP?H)(?!\w)"), "km/h"),
    (re.compile("º"), "°"),  # the sign of an ordinal, from a Spanish keyboard
    (re.compile(r"(?<![\w.])Mpa(?!\w)"), "MPa"),
    # A dot may stand for the line of the fraction.
    (re.compile(r"(?<![\w.])rad\.s(?:-1)?(?![\w-])"), "rad/s"),
    (re.compile(r"(?<![\w.])([mk]?)(?:[Nn]ewton|N)[-. ]?[Mm]et(?:er|re)s?(?!\w)"), r"\1N*m"),
    (re.compile(r"[·⋅∙×•・･]"), "*"),  # the signs that people type for a product
    (re.compile(r"(?<![\w.])([mk]?)N[?\ufffd]m(?!\w)"), r"\1N*m"),  # a point that an encoding lost
    (re.compile(r"(?<![\w.])n[-.*]m(?!\w)"), "N*m"),  # nm without a sign is the nanometre
    # In capitals too: NM without a sign may be a nautical mile, and the name tells (`logs/columns/labels.py`).
    (re.compile(r"(?<![\w.])(k?)N\s?[-.*]\s?M(?!\w)"), r"\1N*m"),
    (re.compile(r"(?<![\w.])(k?gf|dyne?)\s?[-.]\s?([cm]?m)(?!\w)"), r"\1*\2"),
    # A torque in kilograms times an arm is one of weights; what goes on is an inertia, a momentum or a newton.
    (
        re.compile(
            r"(?<![\w.])(k?g)(?:\s*[-.*·]\s*|\s+|(?=cm))([cm]?m)(?![\w^*/²])(?!\s*[/*^])(?![.\s]+s)"
        ),
        r"\1f*\2",
    ),
    (re.compile(r"\b((?:da|[numcdhkMGµμ])?N)\s*[-.]?\s*([mc]?m)\b"), r"\1*\2"),
    # Where powers are written out a dot is a product: kg.m.s-2.
    (re.compile(r"(?<=[\w²³])\.(?=[A-Za-zµμ].*-\d)"), "*"),
    # The mil of a machinist; that of a gunner is no unit of a bench.
    (re.compile(r"(?<![\w.])mils?(?!\w)"), "thou"),
    (re.compile(r"(?<![\w.])kp(?!\w)"), "kgf"),
    (re.compile(r"^\s*[x×*]\s*(?=\d)"), ""),  # x1000 rpm
    (re.compile(r"(?<=\w)\s*[x×]\s*(?=\d+(?:\.\d+)?\s*$)"), "*"),  # rpm x1000
    # Pint reads Pas as several pascals.
    (re.compile(r"(?<![\w.])([munkMµμ]?Pa)\s?s(?![\w^])"), r"\1*s"),
    (re.compile(r"-¹"), "^-1"),
    (re.compile(r"(?<![\w.])(?:revs?|REV|rotations?)(?!\w)"), "turn"),
    (
        re.compile(
            r"(?<![\w.])(?:[Uu]mdrehung(?:en)?|[Uu]mdr\.?|revolu(?:tion|ciones)|vueltas|tours|giri|obroty|otáčky|varv"
            r"|оборот(?:ы|ов)?|圈|바퀴)(?!\w)"
        ),
        "turn",
    ),
    (re.compile(r"(?<![\w.])[Aa]mps?(?!\w)"), "ampere"),  # pint reads amps as attometers per second
    (re.compile(r"(?<![\w.])([mkuµμ]?V)[\s_]?(?:DC|AC|dc|ac|RMS|rms|eff)(?!\w)"), r"\1"),
    # ADC without a blank may be the counts of a converter.
    (
        re.compile(r"(?<![\w.])([mkuµμ]?A)(?:[\s_]DC|[\s_]AC|[\s_]?(?:dc|ac|RMS|rms|eff))(?!\w)"),
        r"\1",
    ),
    (re.compile(r"(?<![\w.])rads(?!\w)"), "rad"),  # and rads as a dose
    (re.compile(r"(?<![\w.])(?:dps|DPS)(?!\w)"), "deg/s"),
    (re.compile(r"(?<![\w.])(?:ips|IPS)(?!\w)"), "inch/s"),
    (re.compile(r"(?<![\w.])(?:RPM|Rpm|Upm|UPM)(?!\w)"), "rpm"),
    (re.compile(r"([A-Za-zµμ°])(-?[1-9])(?!\w)"), r"\1^\2"),
    (
        re.compile(
            r"(?<![\w.])(m?)(?:[Ss]egs?|[Ss]egundos?|[Ss]ek|[Ss]ekunden|secondes?|secs|saniye|sn)(?!\w)\.?"
        ),
        r"\1s",
    ),
    (re.compile(r"(?<![\w.])([mk]?)(?:gauss|Gauss|Gs|G)(?!\w)"), r"(1e-4*\1T)"),
    (re.compile(r"(?<![\w.])([mk]?)(?:oersted|Oersted|Oe)(?!\w)"), r"(79.57747154594767*\1A/m)"),
    (
        re.compile(r"(?<![\w.])(?:Grad|Gradi|gradi|grader|grados?|graus?|degrés?|stopni)(?!\w)"),
        "deg",
    ),
    (re.compile(r"(?<![\w.])(?:voltios?|Voltios?)(?!\w)"), "V"),
    (re.compile(r"(?<![\w.])(?:[Aa]mperios?|[Aa]mpères?)(?!\w)"), "A"),
    (re.compile(r"(?<![\w.])(?:Min|MIN)(?!\w)"), "min"),  # and Min as a million inches
)
