"""Models from their files, whatever they are."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any, cast

from erclutch.errors import RunError
from erclutch.model import TorqueModel, model_from_dict
from erclutch.networks.model import KIND, NetworkModel, network_from_dict

Model = TorqueModel | NetworkModel


def load_model(path: str | Path) -> Model:
    """Read a model's JSON file: a law's or a network's.

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
        body = json.loads(Path(path).read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError) as error:
        raise RunError(f"no readable model: {error}", where=str(path), remedy="Give a model file of a run") from error
    if not isinstance(body, dict):
        raise RunError("not a JSON object", where=str(path), remedy="Give a model file of a run")
    content = cast(dict[str, Any], body)
    if content.get("kind") == KIND:
        return network_from_dict(content, str(path))
    return model_from_dict(content, str(path))
