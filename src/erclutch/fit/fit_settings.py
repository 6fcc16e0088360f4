"""What a comparison does, as the user asks for it."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

from erclutch.errors import keywords_checked, require

AUTO = "auto"


@keywords_checked
@dataclass(frozen=True)
class Settings:
    """What a comparison does; together with the log it determines every figure.

    Attributes:
        models: specifications of laws, or one of them; "all" is the ladder, "paper" the laws of the paper's tables.
        lag: "none"; names of stages, such as "lag" (one time constant), "rise-fall" (two) or "dahl" (memory of the
            slip), joined by "+"; "auto": without and with "lag", with "rise-fall" for the best law if the data ask for
            it, and with memory as far as `fit.choice.ladder` finds that the data ask for it. A model may name its own
            stages: "bingham+lag+dahl".
        test: share of each log, its end, that is held out (of each stretch, where a log was taken at one field after
            another); "stretches" all over each log; patterns of the names of logs that are; or "auto": 0.3, or
            "stretches" where the ends have slips or fields that no row before them comes near.
        blocks: blocks in time for cross-validation on the training rows, 2 to 50; 0 for none.
        friction: a column of friction at zero field; None: yes for a single device whose slip turns, no for all others
            (the paper's form of the pair).
        offset: a constant effort; None: as for friction.
        seed: of the bootstrap and of the networks' starts.
        past: rows back, or times such as "2ms", whose samples are inputs of networks too.
        polish: whether networks get a last round over all rows.
        workers: models fitted side by side; changes no figure.
    """

    models: tuple[str, ...] = ("all",)
    lag: str = AUTO
    test: float | str | tuple[str, ...] = AUTO
    blocks: int = 0
    friction: bool | None = None
    offset: bool | None = None
    seed: int = 0
    workers: int = 1
    past: tuple[int | str, ...] = ()
    polish: bool = False

    def __post_init__(self) -> None:
        given: object = self.models
        names = (given,) if isinstance(given, str) else tuple(self.models)
        object.__setattr__(self, "models", names)
        require(0, seed=self.seed)

    def to_dict(self) -> dict[str, Any]:
        """As JSON values, without what changes no figure."""
        values = asdict(self)
        del values["workers"]
        return values
