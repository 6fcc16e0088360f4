"""Models of the twin for ``erclutch live`` and ``erclutch experiment``: fitted to it once, kept in the cache."""

from __future__ import annotations

import hashlib
import json
import os
import tempfile
from collections.abc import Sequence
from importlib import resources
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.console import Console

    from erclutch.rig.parameters import RigParameters

_SECONDS = 60.0
_LIVE = "fnn-16"
_MADE_BY = ("rig", "laws", "networks", "fit")


def twin_model(rig: RigParameters, output: Console) -> Path:
    """The paper's network (16 neurons) on 60 s of the twin's training run; from the cache if it is there."""
    return twin_models(rig, (_LIVE,), output)[0]


def twin_models(rig: RigParameters, names: Sequence[str], output: Console) -> list[Path]:
    """Models of the twin, fitted together where they are not in the cache.

    Args:
        rig: parameters of the twin.
        names: specifications, memoryless.
        output: told when something is fitted.

    Returns:
        Their files, in order.
    """
    from erclutch import _version
    from erclutch.live.build import cache_folder
    from erclutch.runs import file_name

    about = json.dumps([_version.__version__, _code(), _SECONDS, rig.to_dict()], sort_keys=True)
    digest = hashlib.sha256(about.encode()).hexdigest()[:16]
    files = {name: cache_folder() / f"twin-{file_name(name)}-{digest}.json" for name in names}
    missing = tuple(name for name, file in files.items() if not file.exists())
    if missing:
        output.print(f"TWIN: fitting {', '.join(missing)} to {_SECONDS:.0f} s of it, once ...", markup=False)
        for name, text in _fitted(rig, missing).items():
            _write(files[name], text)
    return list(files.values())


def _code() -> str:
    """Digest of what simulates and fits: a model that older code made is not taken for this code's."""
    package = resources.files("erclutch")
    files = (f for name in _MADE_BY for f in package.joinpath(name).iterdir() if f.name.endswith(".py"))
    return hashlib.sha256(b"".join(f.read_bytes() for f in sorted(files, key=str))).hexdigest()


def _fitted(rig: RigParameters, names: tuple[str, ...]) -> dict[str, str]:
    from erclutch.comparison import Settings, compare
    from erclutch.dataset import build_dataset
    from erclutch.differentiate import Derivative
    from erclutch.logs import read
    from erclutch.rig.log_file import write_log
    from erclutch.rig.scenarios import prepare

    run = prepare("training", rig=rig, seconds=_SECONDS, seed=1)
    with tempfile.TemporaryDirectory() as folder:
        log = write_log(Path(folder) / "twin.parquet", run.names, run.chunks(), run.about(), rows=run.rows)
        # Speeds by the filter that runs live: the models then know its delay and its noise.
        data = build_dataset(read(log, device="coaxial"), device="coaxial", derivative=Derivative("kalman"))
    result = compare(data, Settings(models=names, lag="none"))
    found = {entry.name: entry.outcome.model for entry in result.entries}
    return {name: json.dumps(found[name].to_dict(), indent=1) + "\n" for name in names}


def _write(target: Path, text: str) -> None:
    target.parent.mkdir(parents=True, exist_ok=True)
    handle, partial = tempfile.mkstemp(dir=target.parent, prefix=".writing-")
    with os.fdopen(handle, "w", encoding="utf-8") as file:
        file.write(text)
    os.replace(partial, target)
