"""The model that ``erclutch live`` takes on the twin when none is given: fitted to the twin once, kept in the cache."""

from __future__ import annotations

import hashlib
import json
import os
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.console import Console

    from erclutch.rig.parameters import RigParameters

_SECONDS = 60.0
_NAME = "fnn-16"


def twin_model(rig: RigParameters, output: Console) -> Path:
    """The paper's network (16 neurons) on 60 s of the twin's training run; from the cache if it is there."""
    from erclutch import _version
    from erclutch.live.build import cache_folder

    about = json.dumps([_version.__version__, _SECONDS, _NAME, rig.to_dict()], sort_keys=True)
    digest = hashlib.sha256(about.encode()).hexdigest()[:16]
    target = cache_folder() / f"twin-{_NAME}-{digest}.json"
    if not target.exists():
        output.print(f"TWIN: fitting {_NAME} to {_SECONDS:.0f} s of it, once (about 20 s) ...", markup=False)
        _write(target, _fitted(rig))
    return target


def _fitted(rig: RigParameters) -> str:
    from erclutch.comparison import Settings, compare
    from erclutch.dataset import build_dataset
    from erclutch.differentiate import Derivative
    from erclutch.logs import read
    from erclutch.rig.log_file import write_log
    from erclutch.rig.scenarios import prepare

    run = prepare("training", rig=rig, seconds=_SECONDS, seed=1)
    with tempfile.TemporaryDirectory() as folder:
        log = write_log(Path(folder) / "twin.parquet", run.names, run.chunks(), run.about(), rows=run.rows)
        # Speeds by the filter that runs live: the network then knows its delay and its noise.
        data = build_dataset(read(log, device="coaxial"), device="coaxial", derivative=Derivative("kalman"))
    result = compare(data, Settings(models=(_NAME,), lag="none"))
    return json.dumps(result.entry(_NAME).outcome.model.to_dict(), indent=1) + "\n"


def _write(target: Path, text: str) -> None:
    target.parent.mkdir(parents=True, exist_ok=True)
    handle, partial = tempfile.mkstemp(dir=target.parent, prefix=".writing-")
    with os.fdopen(handle, "w", encoding="utf-8") as file:
        file.write(text)
    os.replace(partial, target)
