"""Models are read from their files, whatever they are."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, cast

from erclutch import registry
from erclutch.errors import PluginError, RunError
from erclutch.files.given_files import plain_words, small_json
from erclutch.models import residual_model
from erclutch.models.law_model import KIND as LAW_KIND
from erclutch.models.law_model import model_from_dict
from erclutch.models.model import Model
from erclutch.models.networks.network_file import network_from_dict
from erclutch.models.networks.network_model import KIND
from erclutch.models.residual_model import residual_from_dict

Reader = Callable[[Mapping[str, Any], str], Model]


def load_model(path: str | Path) -> Model:
    """Read the JSON file of a model: a law, a network, or a law with a network.

    Raises:
        RunError: the file is missing, is no JSON, or is not a model that this version reads.
    """
    if Path(path).is_dir():
        raise RunError(
            "a folder, not a model's file",
            where=str(path),
            remedy="For a run, use erclutch.read_run(folder).model(name), or give a file of its models folder",
        )
    try:
        body = small_json(Path(path))
    except (OSError, ValueError) as error:
        remedy = "Check the path; give a run, or a file of its models folder"
        raise RunError(
            f"no readable model: {plain_words(error)}", where=str(path), remedy=remedy
        ) from error
    if not isinstance(body, dict):
        raise RunError("not a JSON object", where=str(path), remedy="Give a model file of a run")
    content = cast(dict[str, Any], body)
    kind = str(content.get("kind"))
    read = _READERS.get(kind)
    failed: list[PluginError] = []
    if read is None:  # a kind that another package brings: `fit.candidate.Kind.readers`
        for plugin in registry.plugins(registry.KINDS):
            if plugin.own:
                continue
            # A package that fails is no reason why models of other kinds are not read.
            try:
                brought = plugin.value
                with plugin.working("does not say which models it reads"):
                    of_kind: Reader | None = brought.readers.get(kind)
            except PluginError as error:
                failed.append(error)
                continue
            if of_kind is not None:
                read = plugin.guarded(of_kind)
                break
    if read is None and failed:
        raise failed[0]
    return (read or model_from_dict)(content, str(path))


_READERS: Mapping[str, Reader] = {
    LAW_KIND: model_from_dict,
    KIND: network_from_dict,
    residual_model.KIND: residual_from_dict,
}
