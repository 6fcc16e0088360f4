"""``erclutch live`` and ``erclutch experiment`` use models that are fitted to the twin once and kept in the cache."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Sequence
from functools import partial
from importlib import resources
from pathlib import Path
from typing import TYPE_CHECKING

from erclutch.files import cache_folder, scratch_folder, unwritable, whole_file

if TYPE_CHECKING:
    from rich.console import Console

    from erclutch.signals.device import DeviceName
    from erclutch.wings.rig.twin.parameters import RigParameters

_SECONDS = 60.0  # [s], of the TWIN's log that its models are fitted to
#: The brake switches fast against a slip that hardly moves: the lag of its field is most of what a law would miss.
_LIVE = {"coaxial": "fnn-16", "single": "fnn-16+lag"}
_MADE_BY = ("wings/rig", "models", "fit")
_UNWRITABLE = partial(unwritable, remedy="Set ERCLUTCH_CACHE to a folder that can be written")


def twin_model(rig: RigParameters, output: Console, device: DeviceName = "coaxial") -> Path:
    """The paper's network (16 neurons) on 60 s of the twin's training run, or of its brake; cached."""
    return twin_models(rig, (_LIVE[device],), output, device)[0]


def twin_models(
    rig: RigParameters,
    names: Sequence[str],
    output: Console,
    device: DeviceName = "coaxial",
) -> list[Path]:
    """Models of the twin, fitted together where they are not in the cache.

    Args:
        rig: parameters of the twin.
        names: specifications.
        output: told when something is fitted.
        device: the pair, or CH1 alone as a brake.

    Returns:
        Their files, in order.
    """
    from erclutch import _version
    from erclutch.runs.run_shape import file_name

    # A model that older code made is not taken for this code's.
    package = resources.files("erclutch")
    sources: list[Path] = []
    for name in _MADE_BY:
        sources += Path(str(package.joinpath(name))).rglob("*.py")
    code = hashlib.sha256()
    for source in sorted(sources, key=str):
        code.update(source.read_bytes())
    about = json.dumps(
        [_version.__version__, code.hexdigest(), _SECONDS, device, rig.to_dict()], sort_keys=True
    )
    digest = hashlib.sha256(about.encode()).hexdigest()[:16]
    files = {name: cache_folder() / f"twin-{file_name(name)}-{digest}.json" for name in names}
    missing = tuple(name for name, file in files.items() if not file.exists())
    if missing:
        from erclutch.fit.comparison import Settings, compare
        from erclutch.logs import read
        from erclutch.logs.dataset import build_dataset
        from erclutch.logs.log_writer import write_log
        from erclutch.signals.speed import Derivative
        from erclutch.wings.rig.twin.scenarios import prepare

        output.print(
            f"TWIN: fitting {', '.join(missing)} to {_SECONDS:.0f} s of it, once ...", markup=False
        )
        scenario = "training" if device == "coaxial" else "brake"
        run = prepare(scenario, rig=rig, seconds=_SECONDS, seed=1)
        with scratch_folder() as folder:
            place = Path(folder) / "twin.parquet"
            log = write_log(place, run.names, run.chunks(), run.about(), rows=run.rows)
            # Speeds by the filter that runs live: the models then know its delay and its noise.
            filtered = Derivative("kalman")
            data = build_dataset(read(log, device=device), device=device, derivative=filtered)
        for entry in compare(data, Settings(models=missing, lag="none")).entries:
            file = files[entry.name]
            file.parent.mkdir(parents=True, exist_ok=True)
            with whole_file(file, _UNWRITABLE) as partial:
                text = json.dumps(entry.outcome.model.to_dict(), indent=1) + "\n"
                partial.write_text(text, encoding="utf-8")
    return list(files.values())
