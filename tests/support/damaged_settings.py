"""Damaged files of a rig, a mapping, a saved plan, a mapping beside its log, a model: read, or refused with a remedy.

A model that is read has a torque that is finite, whatever its file says. Half of the damaged models have a value of
another kind or size under a digest that fits it: a digest tells damage, not intent.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

import erclutch
from erclutch.logs import read_table
from erclutch.logs.mapping import ColumnMap
from erclutch.logs.planning.whole_plan import plan_of
from erclutch.logs.saved_plan import save_plan
from erclutch.logs.synthetic import write_synthetic_log
from erclutch.models.load import load_model
from erclutch.models.model_file import digest_of
from erclutch.signals.clock import Clock, Span
from erclutch.signals.device import Element
from erclutch.wings.rig.twin.parameters import default_rig, load_rig
from erclutch.wings.rig.twin.parameters_file import write_rig
from tests.support.exported_models import MODELS
from tests.support.log_formats import mutated

#: The quickest first: what they leave of their time goes to those behind them.
KINDS = ("model", "sidecar", "rig", "mapping", "plan")
_MODELS = ("bingham, single", "casson+lag, single", "fnn-3+rise-fall, single")
_ENTRIES: tuple[Any, ...] = (
    *(
        None,
        True,
        -1,
        0,
        3,
        1e-300,
        1e300,
        10**400,
        "x",
        "<script>",
        "../../x",
        "\u202e",
        "bingham" * 99,
    ),
    *([], {}, [[]], [1e18], [0.0] * 10_000, {"a": 1}),
)
_VALUES = (
    "-1",
    "1e400",
    "nan",
    "[]",
    "{}",
    "true",
    "'x'",
    "1979-05-27T07:32:00Z",
    "9" * 30,
    '"\\u0000"',
    "{value = nan}",
)
_MAPPING = """time = {column = "time", unit = "s"}
[columns]
field = {column = "field", unit = "V"}
slip = {column = "slip", unit = "rad/s"}
effort = {column = "torque", unit = "N*m"}
"""


def make_settings(folder: Path) -> None:
    """A short log, and one sound file of each kind."""
    write_synthetic_log(folder / "whole.csv")
    rows = (folder / "whole.csv").read_text(encoding="utf-8").splitlines(keepends=True)
    (folder / "log.csv").write_text("".join(rows[:400]), encoding="utf-8")
    write_rig(folder / "rig.toml", default_rig())
    for kind in ("mapping", "sidecar"):
        (folder / f"{kind}.toml").write_text(_MAPPING, encoding="utf-8")
    plan = plan_of(read_table(folder / "log.csv"), ColumnMap.from_toml(folder / "mapping.toml"))
    save_plan(plan, folder / "plan.toml")
    for place, name in enumerate(_MODELS):
        text = json.dumps(MODELS[name].to_dict())
        (folder / f"model-{place}.json").write_text(text, encoding="utf-8")
    (folder / "beside").mkdir()
    (folder / "beside" / "log.csv").write_bytes((folder / "log.csv").read_bytes())


def fault_of(kind: str, number: int, folder: Path) -> str:
    """What reading a damaged file of a kind did wrong; "" where it was read or refused."""
    seed = (KINDS.index(kind), number)
    try:
        if kind == "model":
            return _fault_of_model(number, folder, seed)
        whole = (folder / f"{kind}.toml").read_bytes()
        damaged = (
            folder / "beside" / "log.csv.toml"
            if kind == "sidecar"
            else folder / f"damaged-{kind}.toml"
        )
        damaged.write_bytes(_damaged(whole, seed))
        if kind == "rig":
            load_rig(damaged)
        elif kind == "sidecar":
            erclutch.read(folder / "beside" / "log.csv")
        else:
            erclutch.read(folder / "log.csv", mapping=ColumnMap.from_toml(damaged))
    except erclutch.ErclutchError as error:
        return "" if error.remedy else f"{kind} {number}: no remedy: {error}"
    except Exception as error:
        return f"{kind} {number}: {type(error).__name__}: {str(error)[:100]}"
    return ""


def _fault_of_model(number: int, folder: Path, seed: tuple[int, int]) -> str:
    whole = (folder / f"model-{number % len(_MODELS)}.json").read_bytes()
    damaged = folder / "damaged.json"
    damaged.write_bytes(_with_another_entry(whole, seed) if number % 2 else mutated(whole, seed))
    model = load_model(damaged)
    rows = np.linspace(-2.0, 2.0, 50)
    effort = model.effort(
        [Element(rows, rows[::-1])], Clock(np.linspace(0.0, 0.049, 50), (Span(0, 50, 1e-3),))
    )
    return "" if np.isfinite(effort).all() else f"model {number}: an effort that is not finite"


def _with_another_entry(data: bytes, seed: tuple[int, int]) -> bytes:
    """The file of a model with one entry of another kind or size, and a digest that fits."""
    rng = np.random.default_rng(seed)
    body: Any = json.loads(data)
    inside: Any = body
    while True:
        keys: list[Any] = list(inside) if isinstance(inside, dict) else list(range(len(inside)))
        key = keys[int(rng.integers(len(keys)))]
        if not (isinstance(inside[key], dict | list) and inside[key] and rng.random() < 0.8):
            break
        inside = inside[key]
    inside[key] = _ENTRIES[int(rng.integers(len(_ENTRIES)))]
    body.pop("digest", None)
    return json.dumps({**body, "digest": digest_of(body)}).encode()


def _damaged(data: bytes, seed: tuple[int, int]) -> bytes:
    rng = np.random.default_rng(seed)
    lines = data.decode().split("\n")
    at, how = int(rng.integers(len(lines))), int(rng.integers(5))
    if how == 0:
        lines[at] = lines[int(rng.integers(len(lines)))]
    elif how == 1 and "=" in lines[at]:
        lines[at] = f"{lines[at].split('=')[0]}= {_VALUES[int(rng.integers(len(_VALUES)))]}"
    elif how == 2:
        lines[at] = lines[at] * 50
    elif how == 3:
        lines.insert(at, f"[a{'.b' * int(rng.integers(1, 300))}]")
    else:
        return mutated(data, (seed[0], int(rng.integers(1 << 30))))
    return "\n".join(lines).encode()
