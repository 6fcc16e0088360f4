"""What wings and other packages have to say of several logs together (group ``erclutch.advice``)."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, cast

from erclutch import registry
from erclutch.errors import ErclutchError

if TYPE_CHECKING:
    from erclutch.logs.dataset import Dataset

GROUP = "erclutch.advice"


def advice_on(rows: Dataset) -> list[str]:
    """Sentences about the logs of a data set, none where no wing has any.

    A package whose advice fails costs its own sentences only: one line says so.
    """
    advisers, failed = registry.sound(GROUP, Callable)  # pyright: ignore[reportArgumentType]
    wrong: list[ErclutchError] = [*failed]
    sentences: list[str] = []
    for plugin, advise in advisers:
        try:
            with plugin.working():
                said: Any = advise(rows)
            texts = cast("list[Any]", said if isinstance(said, list) else [said])
            if not isinstance(said, list) or not all(isinstance(text, str) for text in texts):
                raise plugin.fault("does not return a list of texts")
        except ErclutchError as error:
            if plugin.own:
                raise
            wrong.append(error)
        else:
            sentences += texts
    return sentences + [f"Advice was left out: {error}" for error in wrong]
