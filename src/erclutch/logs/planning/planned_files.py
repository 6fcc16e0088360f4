"""A file that is called a trajectory, a reference or a simulation holds what was planned: its effort is doubted.

Names of its columns may be bare (``torque``), and its numbers are as good as those of a sensor; only the name of the
file tells. It is no alarm where columns themselves say what was measured or told, where the name says so
(``reference_test.csv``), or where a planned motion has the noise of a sensor, which no plan has.
"""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import PurePath

import numpy as np

from erclutch.errors import shell_word
from erclutch.logs.columns.names import words_of
from erclutch.logs.columns.shapes import FEW, known_rows
from erclutch.logs.columns.vocabulary import MEASURED, TOLD, set_of
from erclutch.logs.planning.draft import Draft
from erclutch.logs.planning.missing_columns import called_and_not_measured
from erclutch.signals.array import SIGMA_OF_MAD, Array

_SIMULATED = set_of(
    "sim sims simulated simulation simulations simulacion simulacao simulazione simulado simule predicted prediction "
    "predictions estimated theoretical theory calculated computed fem fea comsol ansys abaqus"
)
#: Whose motion nobody measured.
_PLANNED = set_of(
    "traj trajs trajectory trajectories trajektorie trajectoire trayectoria traiettoria planned planning desired "
    "setpoint setpoints setpt sollwert sollwerte soll geplant consigne consignes consigna consignas deseado deseada "
    "demanded commanded feedforward"
)
#: The same, where no word beside speaks of a test: a reference may be the brake that others are held against.
_MAYBE_PLANNED = set_of("reference references ref refs target targets cmd cmds command commands")
_EASTERN_SIMULATED = ("仿真", "模拟", "シミュレーション", "시뮬레이션")
_EASTERN_PLANNED = ("轨迹", "规划", "期望", "目标", "指令", "设定", "軌道", "目標", "궤적", "목표")
#: Words of a file that was measured.
_TESTS = set_of(
    "test tests run runs trial trials experiment experiments exp experimental log logs logged data rec record recorded "
    "recording sample specimen messung versuch essai ensayo prova brake clutch damper baseline"
)
_SAID_MEASURED = MEASURED - {"act", "actual", "ist"} | {"experimental", "experiment", "recorded"}

#: Share of the third differences that change their sign: noise has 0.77, a course of 4 rows a cycle 0.5.
_WHITE = 0.6
_NOISY = 5e-4  # of the spread of a signal
_STEPS_OF_A_FORMAT = 3.0  # above which noise is no rounding
_ROWS = 5000  # that are looked at
#: Median size of third differences of noise of one: their deviation is the root of 1 + 9 + 9 + 1.
_OF_THIRD_DIFFERENCES = np.sqrt(20.0) / SIGMA_OF_MAD


def doubt_what_was_planned(draft: Draft) -> None:
    """Doubt an effort of a file that is called a plan or a simulation; who names its column says it is measured."""
    table = draft.table
    is_our_own = bool(table.origin) or table.device is not None
    how = "" if is_our_own else _made_how(draft)
    if not how:
        return
    effort = draft.guessed("effort")
    if effort is not None:
        label = effort.answer or shell_word(table.label(effort.column))
        before = f"{effort.doubt}; and it is" if effort.doubt else ""
        why = f"of a file whose name says that it was {how}, not measured"
        doubt = f"{before} {why}: give --effort {label} if a sensor measured it".lstrip()
        draft.doubt("effort", doubt, effort.answer)
    elif (question := draft.questions.get("effort")) is not None:
        why = f"the file's name says that it was {how}, not measured"
        question = question.adding(f"; {why}")
        modelled = called_and_not_measured(draft.seen.without(draft.taken), "effort")
        modelled = [each for each in modelled if not each.spoken.says(TOLD)]
        if how == "computed" and len(modelled) == 1 and not question.option:
            # In a simulation every column is the model's: its effort is offered, as a bare torque is.
            option = f"--effort {shell_word(table.label(modelled[0].name))}"
            question = replace(question, option=option)
        draft.questions["effort"] = question


def _made_how(draft: Draft) -> str:
    """How the name of the file says that its numbers were made; "" for a log that may be measured."""
    stem = PurePath(draft.table.name).stem
    words = {re.sub(r"\d+$", "", word) for word in words_of(stem)}
    if "desire" not in stem.lower():
        words.discard("desired")  # "des" is an article of French names
    in_columns: set[str] = set()
    for column in draft.seen.columns.values():
        in_columns.update(column.spoken.stem_words)

    if not words.isdisjoint(_SIMULATED) or any(sign in stem for sign in _EASTERN_SIMULATED):
        return "" if (words | in_columns) & _SAID_MEASURED else "computed"
    is_plan = not words.isdisjoint(_PLANNED) or any(sign in stem for sign in _EASTERN_PLANNED)
    if not is_plan and not words.isdisjoint(_MAYBE_PLANNED):
        is_plan = words.isdisjoint(_TESTS)
    if not is_plan or (words & _SAID_MEASURED) or in_columns & (MEASURED | TOLD):
        return ""
    for signal in ("effort", "slip", "position"):
        chosen = draft.signals.get(signal)
        values = draft.table.columns.get(chosen.column) if chosen is not None else None
        if values is not None and _has_noise(values):
            return ""
    return "planned"


def _has_noise(values: Array) -> bool:
    """Whether a column has the noise of a sensor: more than its format rounds off, and white from row to row."""
    (known,) = known_rows(values)
    known = known[:_ROWS]
    if known.size < FEW:
        return False
    third = np.diff(known, 3)
    moving = third[third != 0.0]
    spread = float(known.std())
    if moving.size < FEW // 2 or spread == 0.0:
        return False
    turns = np.count_nonzero(np.diff(np.sign(moving)) != 0) / (moving.size - 1)
    noise = float(np.median(np.abs(third))) / _OF_THIRD_DIFFERENCES
    steps = np.diff(np.unique(known))
    least = float(np.quantile(steps, 0.01))
    is_rounding = noise < _STEPS_OF_A_FORMAT * least
    return bool(turns > _WHITE and noise > _NOISY * spread and not is_rounding)
