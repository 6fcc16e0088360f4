"""A column may tell the level of a valve or a supply by a word in each row: ``soft``, ``medium``, ``hard``.

The words become numbers, which count their places: a field needs numbers, and as words they would part the rows into
logs that nobody knows the field of.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from erclutch.errors import listed
from erclutch.logs.columns.levels_in_words import places_of
from erclutch.logs.columns.names import spoken_name, words_of
from erclutch.logs.columns.vocabulary import set_of
from erclutch.logs.columns.word_columns import with_words_used_up
from erclutch.logs.table import Table
from erclutch.signals.array import Array

#: What such a column is called; a material or a specimen may be soft or hard too.
_SETTINGS = set_of(
    "setting settings level levels mode valve damping stage knob switch stufe stellung einstellung ventil "
    "ventilstellung modus dampfung niveau reglage soupape ajuste nivel modo valvula livello regolazione valvola "
    "档 档位 模式 设置 等级 设定 設定 モード レベル 단계 모드 설정"
)


def with_places_of_words(table: Table) -> Table:
    """The table with such columns as numbers; else as it is."""
    columns: dict[str, Array] = {}
    said_of: list[str] = []
    for name, words in table.words.items():
        is_a_setting = (
            not _SETTINGS.isdisjoint(words_of(name)) or "field" in spoken_name(name).may_be
        )
        places = places_of(words.words) if is_a_setting else None
        if places is None or not (words.of_row >= 0).all():
            continue
        columns[name] = np.asarray(places, np.float64)[words.of_row]
        said = [f"{word} ({place})" for word, place in zip(words.words, places, strict=True)]
        said_of.append(f"column {name} tells levels by words, which are counted: {listed(said)}")
    if not columns:
        return table
    for name in columns:
        table = with_words_used_up(table, name)
    unreadable = {name: why for name, why in table.unreadable.items() if name not in columns}
    return replace(
        table,
        columns={**table.columns, **columns},
        unreadable=unreadable,
        notes=(*table.notes, *said_of),
    )
