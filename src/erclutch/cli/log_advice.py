"""What wings and other packages have to say of several logs together (group ``erclutch.advice``)."""

from __future__ import annotations

from typing import TYPE_CHECKING

from erclutch import registry

if TYPE_CHECKING:
    from erclutch.logs.dataset import Dataset

GROUP = "erclutch.advice"


def advice_on(rows: Dataset) -> list[str]:
    """Sentences about the logs of a data set, none where no wing has any.

    Raises:
        PluginError: advice of another package fails.
    """
    sentences: list[str] = []
    for plugin in registry.plugins(GROUP):
        with plugin.working():
            sentences += plugin.value(rows)
    return sentences
