"""A plug-in that computes other efforts than when a model was fitted is told: the torque was another, in silence."""

from __future__ import annotations

import json
import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest

from erclutch.errors import RunError
from erclutch.fit.comparison import Settings, compare
from erclutch.logs.dataset import build_dataset
from erclutch.models.load import load_model
from erclutch.models.model_file import digest_of
from erclutch.models.stages import stage_named, stages_at, stages_of
from tests.support.installed_plugin import Install, install
from tests.support.pair import single_log
from tests.support.slow_params import slow_behind

__all__ = ["install"]
LAW = """
from dataclasses import replace
from erclutch.models.laws.bingham import LAW as OURS

def odd(form):
    law = OURS.law(form)
    def columns(E, w, *numbers):
        first, second = law.columns(E, w, *numbers)
        return {factor} * first, second
    return replace(law, name="odd", columns=columns)

THING = replace(OURS, law=odd, ladder={{}}, aliases=())
"""
STAGE = """
import copy
from erclutch.models.stages import stage_named
OURS = stage_named("lag")

class Odd(type(OURS)):
    def respond(self, signal, clock, q, rows):
        return {factor} * OURS.respond(signal, clock, q, rows)

THING = copy.copy(OURS)
object.__setattr__(THING, "__class__", Odd)
object.__setattr__(THING, "name", "odd")
"""


def forget_stages() -> None:
    for kept in (stage_named, stages_of, stages_at):
        kept.cache_clear()


@pytest.fixture
def forgotten() -> Iterator[None]:
    """No test behind these finds their stage."""
    yield
    forget_stages()


@pytest.mark.slow
@pytest.mark.usefixtures("forgotten")
@pytest.mark.parametrize(
    ("group", "text", "model"),
    slow_behind(
        1,
        [
            ("laws", LAW, "odd"),
            ("stages", STAGE, "bingham+odd"),
            ("stages", STAGE, "fnn-3+odd"),
        ],
    ),
)
def test_a_plug_in_that_computes_other_efforts_is_told(
    group: str,
    text: str,
    model: str,
    install: Install,
    tmp_path: Path,
) -> None:
    points = f"[erclutch.{group}]\nodd = bench_odd:THING\n"

    def installed(factor: float) -> None:
        forget_stages()
        install("bench-odd", points, text.format(factor=factor))

    installed(1.0)
    fitted = compare(build_dataset(single_log(1.0)), Settings((model,), lag="none"))
    path = tmp_path / "model.json"
    body = fitted.entries[0].outcome.model.to_dict()
    path.write_text(json.dumps(body), encoding="utf-8")
    assert load_model(path).name == model

    shutil.rmtree(tmp_path / "bench_odd-1.5.dist-info")
    installed(1.001)
    said = r"compute other efforts than when it was fitted, with bench-odd 1\.5"
    with pytest.raises(RunError, match=said):
        load_model(path)

    # A file of an earlier version of erclutch has no efforts.
    older = {key: value for key, value in body.items() if key not in ("efforts", "digest")}
    path.write_text(json.dumps({**older, "digest": digest_of(older)}), encoding="utf-8")
    assert load_model(path).name == model
