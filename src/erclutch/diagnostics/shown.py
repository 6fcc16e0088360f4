"""Which models a picture shows when it cannot show all of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

Role = Literal["recommended", "best", "baseline"]


@dataclass(frozen=True)
class Shown:
    """A model that pictures show.

    Attributes:
        name: of the model.
        role: why it is shown.
    """

    name: str
    role: Role


def shown_models(body: Mapping[str, Any]) -> tuple[Shown, ...]:
    """The recommended model, the best one and the plainest one of a run (`run.json`), each once."""
    ranking = body["ranking"]
    picks: tuple[tuple[Role, str], ...] = (
        ("recommended", body["recommended"]),
        ("best", body["best"]),
        ("baseline", _plainest(ranking)),
    )
    found: dict[str, Role] = {}
    for role, name in picks:
        found.setdefault(name, role)
    return tuple(Shown(name, role) for name, role in found.items())


def _plainest(ranking: Sequence[Mapping[str, Any]]) -> str:
    """Bingham without memory where it was fitted, else the model with the fewest parameters."""
    finite = [e for e in ranking if e["test"]["rmse"][0] is not None]
    bingham = [e for e in finite if e["name"].startswith("bingham") and "+" not in e["name"]]
    chosen = min(bingham or finite or ranking, key=lambda e: (e["parameters_count"], e["name"]))
    return str(chosen["name"])
