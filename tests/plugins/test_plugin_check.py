"""A law of others that cannot be exported, or is hostile, is told by ``erclutch laws --check``, not after a fit."""

from __future__ import annotations

from dataclasses import replace

import pytest

from erclutch import registry
from erclutch.cli import plugin_check
from erclutch.cli.plugin_check import fault_of, recorded_fault
from tests.support.installed_plugin import Install, install

__all__ = ["install"]
POINT = "[erclutch.laws]\nodd = bench_odd:LAW\n"
LAW = """
import numpy as np
from erclutch.models.laws.law import VISCOSITY, YIELD, Law, LawFamily
from erclutch.models.laws.smooth import TRANSITION_SLIP, direction

def odd(form):
    def columns(E, w, w_s, *field):
        return {first}, w
    return Law(name="odd", title="Odd", source="none", columns=columns, shape=(TRANSITION_SLIP, *form.shape),
               gains=(YIELD, VISCOSITY))

LAW = LawFamily(law=odd, formula="none", about="None.", curves="w_s=0.05 n=2 T_y=1 eta=0.1", ladder={{}})
"""
SOUND = LAW.format(first="form.factor(E, *field) * direction(w, w_s)")


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (SOUND, ""),
        ("raise RuntimeError('no licence')", "no licence"),
        (LAW.format(first="np.sort(w)"), "depends on other rows"),
        ("raise SystemExit(0)", "cannot be loaded"),
        ("LAW = 3", "it must be LawFamily"),
        (LAW.format(first="np.asarray(w)[:3]"), "no finite array of the rows"),
        (LAW.format(first="np.linalg.norm(w) * w"), "depends on other rows"),
        (LAW.format(first="w * np.nan"), "no finite array of the rows"),
    ],
)
def test_what_is_wrong_with_a_law_is_said(text: str, said: str, install: Install) -> None:
    install("bench-odd", POINT, text)
    found = recorded_fault("erclutch.laws", "odd")
    assert said in found if said else found == "", found


@pytest.mark.slow
@pytest.mark.parametrize(
    ("text", "said"),
    [
        (SOUND, ""),
        ("import os; os._exit(0)", "it ends the program (code 0)"),
        ("while True: pass", "it does not come to an end within 6 s"),
        ("import os; os.kill(os.getpid(), 11)", "it ends the program"),
        ("print('checked: '); raise ValueError('no')", "no"),
    ],
)
def test_a_hostile_package_harms_its_own_process_only(
    text: str, said: str, install: Install
) -> None:
    install("bench-odd", POINT, text)
    found = fault_of(
        registry.find("erclutch.laws", "odd"), seconds=6.0 if "while" in text else 60.0
    )
    assert said in found if said else found == "", found


@pytest.mark.slow
def test_a_law_with_a_name_of_ours_is_never_loaded(
    install: Install, capsys: pytest.CaptureFixture[str]
) -> None:
    from erclutch.cli.plugin_list import list_plugins

    install("bench-odd", POINT.replace("odd =", "casson ="), "raise RuntimeError('it was loaded')")
    assert not list_plugins(json=True, check=True)
    said = capsys.readouterr().out
    assert "casson is erclutch's own" in said
    assert "it was loaded" not in said


@pytest.mark.slow
def test_the_check_is_of_others_only(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    from erclutch.cli.plugin_list import list_plugins

    asked: list[registry.Plugin] = []
    monkeypatch.setattr(plugin_check, "fault_of", lambda plugin: asked.append(plugin) or "")
    list_plugins(json=True, check=True)
    assert not [plugin for plugin in asked if plugin.own]
    assert replace(registry.find("erclutch.laws", "casson"), package="other").own is False
