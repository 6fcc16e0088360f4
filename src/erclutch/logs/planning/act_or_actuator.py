"""``force_act`` is the actual force beside a told one, and may be the actuator's beside a load's: it is asked about."""

from __future__ import annotations

from erclutch.logs.columns.vocabulary import TOLD
from erclutch.logs.planning.draft import Draft

_MOTIONS_AND_EFFORT = ("slip", "position", "effort")


def doubt_what_act_means(draft: Draft) -> None:
    """Doubt a guess whose name says ``act`` beside another column of its kind, unless a told one explains the word.

    Where the log has a set point, ``act`` says that the other is what was measured.
    """
    for signal in _MOTIONS_AND_EFFORT:
        chosen = draft.guessed(signal)
        if chosen is None or chosen.sureness == "doubtful":
            continue
        column = draft.seen.columns[chosen.column]
        if "act" not in column.spoken.stem_words:
            continue
        own_words = {*column.spoken.stem_words} - {"act"}
        told: list[str] = []
        others: list[str] = []
        for other in draft.seen.without(draft.taken):
            if column.unit and other.unit and other.kind != column.kind:
                continue
            is_told = other.spoken.says(TOLD)
            shares_a_word = not own_words.isdisjoint(other.spoken.stem_words)
            if signal in other.spoken.may_be or (is_told and shares_a_word):
                (told if is_told else others).append(other.name)
        if others and not told:
            doubt = f"in whose name act may mean actual or actuator, beside {', '.join(others)}"
            draft.doubt(signal, doubt)
