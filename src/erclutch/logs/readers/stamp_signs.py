"""Dates and times of day in other signs than most programs write become those that `dates` reads.

``20240503_140712_250``, ``May 3, 2024 2:07:12 PM``, ``2024年5月3日 14時07分12秒``, ``下午 02:07:12`` and
``[14:07:12.5]`` are dates and times of a logger, a spreadsheet, a console.
"""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import pandas as pd

_MONTHS = ("jan", "feb", "mar", "apr", "may", "jun", "jul", "aug", "sep", "oct", "nov", "dec")
_MONTH = rf"(?P<month>{'|'.join(_MONTHS)})[a-z]{{0,6}}\.?"
_TIME = r"(?P<time>\d{1,2}:\d\d:\d\d(?:\.\d{1,9})?)"
_HALF = r"(?:\s(?P<half>[AP]M))?"
_AROUND = "'\"[]() "  # signs around a stamp that say nothing
_LIKE_A_TIME = re.compile(r"\d:\d\d")  # and no list in brackets
_MORNING = ("上午", "午前", "오전")
_AFTERNOON = ("下午", "午後", "오후")
_HALF_IN_FRONT = re.compile(rf"(?:{'|'.join((*_MORNING, *_AFTERNOON))})\s?")
_FORMS = tuple(
    re.compile(form, re.IGNORECASE)
    for form in (
        # 20240503_140712_250, 20240503T140712.250
        r"(?P<year>\d{4})(?P<month>\d\d)(?P<day>\d\d)[T_ -](?P<h>\d\d)(?P<m>\d\d)(?P<s>\d\d)(?:[._-](?P<f>\d{1,9}))?",
        # 2024-05-03-14-07-12-250, 2024_05_03_14_07_12
        r"(?P<year>\d{4})[-_](?P<month>\d\d)[-_](?P<day>\d\d)[-_T ](?P<h>\d\d)[-_](?P<m>\d\d)[-_](?P<s>\d\d)"
        r"(?:[._-](?P<f>\d{1,9}))?",
        # May 3, 2024 2:07:12 PM
        rf"{_MONTH}\s(?P<day>\d{{1,2}}),?\s(?P<year>\d{{4}}),?\s{_TIME}{_HALF}",
        # Fri May  3 14:07:12.25 2024
        rf"[a-z]{{3}},?\s{_MONTH}\s{{1,2}}(?P<day>\d{{1,2}})\s{_TIME}\s(?P<year>\d{{4}})",
        # 3 May 2024 14:07:12
        rf"(?P<day>\d{{1,2}})\s{_MONTH}\s(?P<year>\d{{4}}),?\s{_TIME}{_HALF}",
        # 2024年5月3日 14時07分12.5秒
        r"(?P<year>\d{4})\s?[年년]\s?(?P<month>\d{1,2})\s?[月월]\s?(?P<day>\d{1,2})\s?[日일]\s?"
        r"(?P<h>\d{1,2})\s?[時时点시]\s?(?P<m>\d{1,2})\s?[分분]\s?(?P<s>\d{1,2})(?:\.(?P<f>\d{1,9}))?\s?[秒초]",
        # 14h07m12.5s, 14h 07min 12s, perhaps behind a date
        r"(?:(?P<date>\d{1,4}[./-]\d{1,2}[./-]\d{1,4})\s)?(?P<h>\d{1,2})\s?h\s?(?P<m>\d\d)\s?m(?:in)?\s?(?P<s>\d{1,2})(?:\.(?P<f>\d{1,9}))?\s?s",
    )
)


def in_usual_signs(texts: pd.Series[Any]) -> pd.Series[Any]:
    """The texts of a column as ``2024-05-03 14:07:12.250``, where all are of one form; else as they are."""
    bare = texts.str.strip(_AROUND)
    if _HALF_IN_FRONT.search(bare.iloc[0]):
        return bare.map(_with_half_behind)
    form = next((form for form in _FORMS if form.fullmatch(bare.iloc[0])), None)
    if form is None:
        return bare if _LIKE_A_TIME.search(bare.iloc[0]) else texts
    matches = [form.fullmatch(text) for text in bare]
    written = [_written(match) for match in matches if match is not None]
    if len(written) < len(texts):
        return bare
    return bare.__class__(written, index=bare.index)


def _with_half_behind(text: str) -> str:
    """``2024/05/03 02:07:12 PM`` of ``2024/05/03 下午 02:07:12``; a text without such a word as it is."""
    word = _HALF_IN_FRONT.search(text)
    if word is None:
        return text
    half = "AM" if word[0].strip() in _MORNING else "PM"
    return f"{text[: word.start()]}{text[word.end() :]} {half}"


def _written(match: re.Match[str]) -> str:
    """The stamp of a match, its date in front if it has one."""
    parts = {key: part for key, part in match.groupdict().items() if part is not None}
    time = parts.get("time") or f"{parts['h']}:{parts['m']}:{parts['s']}.{parts.get('f', '0')}"
    if "half" in parts:
        time += f" {parts['half'].upper()}"
    if "year" not in parts:
        return f"{parts['date']} {time}" if "date" in parts else time
    month = parts["month"]
    number = int(month) if month.isdigit() else 1 + _MONTHS.index(month[:3].lower())
    return f"{parts['year']}-{number:02d}-{int(parts['day']):02d} {time}"
