"""Made-up files in the forms that loggers and people write, each with the numbers behind it.

Each seed draws a device, names of a language, units, a dialect, decimal and thousands marks, a row of units, text above
the table, jitter, a code for no measurement, an encoding and a container. The data are SYNTHETIC.
"""

from __future__ import annotations

import gzip
import json
import warnings
from collections import Counter
from collections.abc import Generator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from signal import SIGALRM, alarm
from signal import signal as handle
from typing import TypeVar

import numpy as np

from erclutch.errors import ErclutchError
from erclutch.logs import ColumnMap, apply, plan_of, table_of_log
from erclutch.logs.readers import child_process, reader_in_child
from erclutch.signals.array import Array, Mask

_T = TypeVar("_T")
RIGHT, ASKED, REFUSED, MISREAD = "right", "asked", "refused", "misread"
ROWS = 300
LONGEST = 120  # s of the clock that one file may take

#: Names of time, position, slip, field and effort of a turning device and of one along a line, by language.
TURNING: Mapping[str, Sequence[Sequence[str]]] = {
    "english": (
        ("Time", "Angle", "Speed", "Current", "Torque"),
        ("time", "angle", "angular_velocity", "coil_current", "brake_torque"),
        ("Timestamp", "Shaft angle", "Shaft speed", "Coil current", "Friction torque"),
    ),
    "german": (
        ("Zeit", "Winkel", "Drehzahl", "Strom", "Drehmoment"),
        ("Messzeit", "Drehwinkel", "Motordrehzahl", "Spulenstrom", "Bremsmoment"),
    ),
    "french": (
        ("Temps", "Angle", "Vitesse", "Courant", "Couple"),
        ("temps", "angle", "vitesse de rotation", "courant bobine", "couple"),
    ),
    "spanish": (
        ("Tiempo", "Ángulo", "Velocidad", "Corriente", "Par"),
        ("tiempo", "ángulo", "velocidad angular", "corriente", "par"),
    ),
    "chinese": (("时间", "角度", "转速", "电流", "扭矩"), ("时间", "转角", "电机转速", "线圈电流", "制动扭矩")),
    "japanese": (("時間", "角度", "回転数", "電流", "トルク"),),
}  # fmt: skip
STRAIGHT: Mapping[str, Sequence[Sequence[str]]] = {
    "english": (
        ("Time", "Displacement", "Velocity", "Current", "Force"),
        ("t", "disp", "vel", "current", "force"),
        ("Time", "Piston displacement", "Piston velocity", "Applied current", "Damping force"),
    ),
    "german": (
        ("Zeit", "Weg", "Geschwindigkeit", "Strom", "Kraft"),
        ("Zeit", "Kolbenweg", "Kolbengeschwindigkeit", "Spulenstrom", "Dämpferkraft"),
    ),
    "french": (
        ("Temps", "Déplacement", "Vitesse", "Courant", "Force"),
        ("temps", "déplacement piston", "vitesse piston", "courant", "force d'amortissement"),
    ),
    "spanish": (("Tiempo", "Desplazamiento", "Velocidad", "Corriente", "Fuerza"),),
    "chinese": (("时间", "位移", "速度", "电流", "阻尼力"), ("采样时间", "活塞位移", "活塞速度", "电流", "载荷")),
    "japanese": (("時間", "変位", "速度", "電流", "荷重"),),
}  # fmt: skip
#: Units as written, with what one of them is in SI units.
UNITS: Mapping[str, Sequence[tuple[str, float]]] = {
    "time": (("s", 1.0), ("ms", 1e-3), ("s", 1.0), ("sec", 1.0)),
    "angle": (("rad", 1.0), ("deg", np.pi / 180), ("°", np.pi / 180)),
    "turning": (("rpm", np.pi / 30), ("rad/s", 1.0), ("deg/s", np.pi / 180), ("r/min", np.pi / 30)),
    "torque": (("Nm", 1.0), ("N*m", 1.0), ("mNm", 1e-3), ("N·m", 1.0), ("N.m", 1.0)),
    "length": (("mm", 1e-3), ("m", 1.0), ("cm", 1e-2)),
    "straight": (("mm/s", 1e-3), ("m/s", 1.0), ("cm/s", 1e-2)),
    "force": (("N", 1.0), ("kN", 1e3)),
    "current": (("A", 1.0), ("mA", 1e-3)),
}
#: Columns that are none of the signals, with a unit or "".
SPARE = (
    ("Temperature", "°C"),
    ("Index", ""),
    ("Acceleration", "m/s^2"),
    ("Pressure", "bar"),
    ("Error", ""),
    ("Speed setpoint", ""),
)
ENCODINGS: Mapping[str, Sequence[str]] = {
    "chinese": ("utf-8", "utf-8-sig", "gb18030", "utf-16"),
    "japanese": ("utf-8", "utf-8-sig", "utf-16", "shift_jis"),
    "": ("utf-8", "utf-8-sig", "cp1252", "utf-16"),
}


@dataclass(frozen=True)
class MadeUp:
    """A made-up log.

    Attributes:
        traits: what was drawn, for messages.
        truth: signal -> numbers in SI units (or as logged, where the file has no units), shape (rows,).
        time: in s from the first row, shape (rows,).
        unmeasured: rows that hold a code in place of a measurement.
    """

    traits: str
    truth: Mapping[str, Array]
    time: Array
    unmeasured: Mask


def _formatted(values: Array, digits: int, decimal: str, thousands: str) -> list[str]:
    """Numbers as texts."""
    texts = [
        f"{value:,.{digits}f}" if thousands else f"{value:.{digits}f}" for value in values.tolist()
    ]
    marks = str.maketrans({".": decimal, ",": thousands})
    return [text.translate(marks) for text in texts]


def write(path: Path, seed: int) -> tuple[Path, MadeUp]:
    """Write the log of a seed; its name is made from ``path`` with the suffix of its container."""
    draw = np.random.default_rng(seed)

    def one(options: Sequence[_T]) -> _T:
        return options[int(draw.integers(len(options)))]

    turning = bool(draw.integers(2))
    language = one(tuple(TURNING))
    names: dict[str, str] = dict(
        zip(
            ("time", "position", "slip", "field", "effort"),
            one((TURNING if turning else STRAIGHT)[language]),
            strict=True,
        )
    )
    kinds = (
        ("time", "angle", "turning", "current", "torque")
        if turning
        else ("time", "length", "straight", "current", "force")
    )
    place = one(("[]", "()", "row", "in", "[]", "()", "row", "none"))  # of the units
    shown: dict[str, tuple[str, float]] = dict(
        zip(names, (one(UNITS[kind]) for kind in kinds), strict=True)
    )

    rate = one((50.0, 100.0, 1000.0, 256.0))
    steady = np.arange(ROWS) / rate
    time = (
        steady + draw.normal(0.0, one((0.0, 0.0, 0.05, 0.2)) / rate, ROWS)
        if one((False, True))
        else steady
    )
    time = np.sort(time) - time.min()
    beat = 2 * np.pi * rate / one((40.0, 60.0, 90.0))
    swing = one((0.5, 2.0)) if turning else one((0.005, 0.02))
    truth = {
        "position": swing * np.sin(beat * time),
        "slip": swing * beat * np.cos(beat * time),
        "field": one((0.5, 1.0, 2.0)) * (np.arange(ROWS) // one((25, 40, 75)) % 3),
    }
    scale = one((0.4, 3.0)) if turning else one((40.0, 900.0, 2500.0))
    truth["effort"] = scale * (1 + truth["field"]) * np.tanh(
        truth["slip"] / (0.3 * swing * beat)
    ) + 0.01 * scale * draw.normal(size=ROWS)
    carried = [
        "time",
        *one((("position", "slip"), ("slip",), ("position",))),
        *one((("field",), ("field",), ())),
        "effort",
    ]

    container = one(("csv", "csv", "csv", "csv.gz", "xlsx", "jsonl"))
    place = "[]" if container == "jsonl" and place == "row" else place
    between = one((",", ";", "\t", "|"))
    decimal = one((".", ",")) if between in ";\t" and container.startswith("csv") else "."
    thousands = (
        one(("", "", "", "." if decimal == "," else ","))
        if between in ";\t" and container.startswith("csv")
        else ""
    )
    code = one((0.0, 0.0, 0.0, -999.0, -9999.0)) if not thousands else 0.0
    unmeasured = np.zeros(ROWS, dtype=np.bool_)
    columns: dict[str, Array] = {}
    units: dict[str, str] = {}
    for signal in carried:
        unit, factor = shown[signal] if place != "none" else ("", 1.0)
        numbers = time if signal == "time" else truth[signal]
        columns[names[signal]] = numbers / factor
        units[names[signal]] = unit
    if code:
        start, length = int(draw.integers(20, 250)), one((1, 3, 10))
        unmeasured[start : start + length] = True
        columns[names["effort"]] = np.where(
            unmeasured,
            code * max(1.0, 10.0 ** np.ceil(np.log10(np.abs(columns[names["effort"]]).max() / 99))),
            columns[names["effort"]],
        )
        if np.abs(columns[names["effort"]][unmeasured]).max() not in (
            999.0,
            9999.0,
            99999.0,
            999999.0,
        ):
            columns[names["effort"]][unmeasured] = truth["effort"][unmeasured] / (
                shown["effort"][1] if place != "none" else 1.0
            )
            unmeasured[:] = False
    for spare, unit in (
        SPARE[int(k)] for k in draw.choice(len(SPARE), int(draw.integers(3)), replace=False)
    ):
        columns[spare] = (
            np.arange(1.0, ROWS + 1.0)
            if spare == "Index"
            else np.asarray(20.0 + 0.3 * draw.normal(size=ROWS))
        )
        units[spare] = "" if place == "none" else unit
    order = (
        list(columns)
        if one((True, False))
        else [
            names["time"],
            *draw.permutation([name for name in columns if name != names["time"]]).tolist(),
        ]
    )
    labels = {name: _label(name, units[name], place) for name in order}
    encoding = one(ENCODINGS.get(language, ENCODINGS[""]))
    file = path.with_suffix("." + container)
    digits = {
        name: 0
        if name == "Index"
        else max(4, int(np.ceil(6 - np.log10(np.median(np.abs(columns[name])) + 1e-12))))
        for name in order
    }
    if container == "xlsx":
        _write_workbook(
            file,
            [labels[name] for name in order],
            [units[name] for name in order] if place == "row" else [],
            [columns[name] for name in order],
        )
    elif container == "jsonl":
        text = "\n".join(
            json.dumps(
                {labels[name]: float(columns[name][k]) for name in order}, ensure_ascii=False
            )
            for k in range(ROWS)
        )
        file.write_text(text, encoding="utf-8")
    else:
        head = one(([], [], ["Test bench 4", "Operator: N. N."], ["# a comment"]))
        rows = [between.join(labels[name] for name in order)]
        rows += [between.join(units[name] or "-" for name in order)] if place == "row" else []
        cells = [_formatted(columns[name], digits[name], decimal, thousands) for name in order]
        rows += [between.join(row) for row in zip(*cells, strict=True)]
        data = (one(("\n", "\r\n")).join([*head, *rows]) + "\n").encode(encoding, "replace")
        file.write_bytes(gzip.compress(data, mtime=0) if container.endswith("gz") else data)
    form = f"{container} {between!r} {decimal}{thousands} {encoding}"
    traits = f"{language}, units {place}, {form}, code {code:g}, {list(labels.values())}"
    kept = {signal: truth[signal] for signal in carried if signal != "time"}
    return file, MadeUp(traits, kept, time, unmeasured)


def _label(name: str, unit: str, place: str) -> str:
    if not unit or place in ("row", "none"):
        return name
    return {"[]": f"{name} [{unit}]", "()": f"{name} ({unit})", "in": f"{name} in {unit}"}[place]


def _write_workbook(
    file: Path, labels: Sequence[str], units: Sequence[str], columns: Sequence[Array]
) -> None:
    from openpyxl import Workbook

    book = Workbook(write_only=True)
    sheet = book.create_sheet("Messung")
    sheet.append(list(labels))
    if units:
        sheet.append(list(units))
    for row in zip(*(column.tolist() for column in columns), strict=True):
        sheet.append(list(row))
    book.save(file)


def judged(file: Path, made: MadeUp) -> tuple[str, str]:
    """The outcome of one file, and what was asked, refused or misread."""
    try:
        table = table_of_log(file, ColumnMap(), None)
        plan = plan_of(table, ColumnMap())
        if plan.questions or plan.doubts:
            return ASKED, "; ".join(
                [*(question.short for question in plan.questions), *plan.doubts]
            )
        log = apply(plan, table)
    except ErclutchError as error:
        return REFUSED, str(error)
    kept = ~made.unmeasured
    if log.rows != int(kept.sum()):
        return MISREAD, f"{log.rows} rows of {int(kept.sum())}"
    taken = {
        name
        for name in ("field", "slip", "position", "effort")
        if any(each.signal == name and each.column for each in plan.signals)
    }
    if taken != made.truth.keys():
        return MISREAD, f"signals {sorted(taken)}"
    for name, numbers in made.truth.items():
        size = float(np.abs(numbers).max())
        if not np.allclose(log.signals[name], numbers[kept], atol=2e-4 * size):
            return MISREAD, f"{name} is {log.signals[name][:3]}, not {numbers[kept][:3]}"
    step = float(np.median(np.diff(made.time)))
    if not np.isclose(log.period, step, rtol=0.1):
        return MISREAD, f"a row each {log.period:g} s, not {step:g} s"
    return RIGHT, ""


@contextmanager
def read_in_this_process() -> Generator[None]:
    """Readers that start a process for each file work in this one: the same code, in a tenth of the time."""

    def answered(module: str, path: Path, *arguments: str, **limits: float) -> child_process.Answer:
        assert module == reader_in_child.__name__, limits
        arrays, texts = reader_in_child.answer_of(str(path), *arguments)
        sent = json.loads(json.dumps(texts))  # as the texts of a process come
        return [np.ascontiguousarray(values, np.float64) for values in arrays], sent

    started = child_process.run
    child_process.run = answered
    try:
        yield
    finally:
        child_process.run = started


@contextmanager
def limited(seconds: int) -> Generator[None]:
    """A file that takes longer ends the whole try, and the traceback shows where."""

    def end(number: int, frame: object) -> None:
        raise TimeoutError(f"a file took longer than {seconds} s")

    before = handle(SIGALRM, end)
    alarm(seconds)
    try:
        yield
    finally:
        alarm(0)
        handle(SIGALRM, before)


def tried(seeds: Sequence[int], folder: Path, *, said: bool = True) -> Counter[str]:
    """Outcomes of the files of some seeds."""
    outcomes = Counter[str]()
    for seed in seeds:
        file, made = write(folder / f"made-up-{seed}", seed)
        with warnings.catch_warnings(), read_in_this_process(), limited(LONGEST):
            warnings.simplefilter("error")
            outcome, why = judged(file, made)
        outcomes[outcome] += 1
        if said and outcome != RIGHT:
            print(f"{outcome:8} seed {seed}: {why[:160]} <- {made.traits}", flush=True)
        file.unlink()
    return outcomes
