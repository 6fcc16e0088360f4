"""Damaged TOML of a rig and of a mapping: each is read, or refused with a remedy."""

from __future__ import annotations

from pathlib import Path

import numpy as np

import erclutch
from erclutch.logs.mapping import ColumnMap
from erclutch.logs.synthetic import write_synthetic_log
from erclutch.wings.rig.twin.parameters import default_rig, load_rig
from erclutch.wings.rig.twin.parameters_file import write_rig
from tests.support.log_formats import mutated

KINDS = ("rig", "mapping")
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
    (folder / "mapping.toml").write_text(_MAPPING, encoding="utf-8")


def fault_of(kind: str, number: int, folder: Path) -> str:
    """What reading a damaged file of a kind did wrong; "" where it was read or refused."""
    damaged = folder / f"damaged-{kind}.toml"
    damaged.write_bytes(_damaged((folder / f"{kind}.toml").read_bytes(), (KINDS.index(kind), number)))
    try:
        if kind == "rig":
            load_rig(damaged)
        else:
            erclutch.read(folder / "log.csv", mapping=ColumnMap.from_toml(damaged))
    except erclutch.ErclutchError as error:
        return "" if error.remedy else f"no remedy: {error}"
    except Exception as error:
        return f"{kind} {number}: {type(error).__name__}: {str(error)[:100]}"
    return ""


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
