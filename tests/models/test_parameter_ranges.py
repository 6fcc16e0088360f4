"""Ranges of all parameters stay: a saved model is refused where a number of it lies outside of them.

After a change on purpose: ``python -m tests.models.test_parameter_ranges`` writes the table anew.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from erclutch.models.laws import law_from_name, shown_laws
from erclutch.models.stages import shown_stages, stage_named

TABLE = Path(__file__).with_name("parameter_ranges.txt")
RICHER = ("dahl-2/field", "lugre/field", "lugre/field/sides", "bouc-wen-2", "effort-second-order")


def lines() -> Iterator[str]:
    """Each parameter of each law and stage of ours: its bounds, the range of its scan, its scale and dimension."""
    laws = [*shown_laws(), "rbfm-5", "casson/power", "casson/critical", "bingham/forward"]
    for name in dict.fromkeys(laws):
        for device in ("single", "coaxial"):
            law = law_from_name(name, device)
            for p in (*law.stimulus_shape, *law.shape):
                scan = " .. ".join(f"{x:.12g}" for x in p.scanned)
                yield f"{device} {name}: {p.name} {p.lower:.12g} .. {p.upper:.12g}, {scan}, {p.scale}, {p.dimension}"
                if p.viscous_over_yield:
                    yield f"{device} {name}: {p.name} is a ratio of viscous to yield effort"
            for g in law.gains:
                yield f"{device} {name}: {g.name} {g.nonnegative} {g.part} {g.dimension}"
    stages = {stage.name: stage for stage in (*shown_stages(), *map(stage_named, RICHER))}
    for name, stage in stages.items():
        for p in stage.parameters(1e-3):
            scan = " .. ".join(f"{x:.12g}" for x in p.scanned)
            yield f"{name}: {p.name} {p.lower:.12g} .. {p.upper:.12g}, {scan}, {p.scale}, {p.dimension}"


def test_ranges_are_those_on_record() -> None:
    assert list(lines()) == TABLE.read_text(encoding="utf-8").splitlines()


if __name__ == "__main__":
    TABLE.write_text("\n".join([*lines(), ""]), encoding="utf-8")
