"""The exported controller: the loop's bits, everywhere the same bits, proved, and refused where it cannot be."""

from __future__ import annotations

import ctypes
import math
import re
import subprocess
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from erclutch.errors import ExportError
from erclutch.export import ExportOptions, export_model, step_of, verify_export
from erclutch.export.c.compilers import EXACT, STRICT, native, natives
from erclutch.export.targets import c
from erclutch.export.targets.python import build
from erclutch.signals.speed import Derivative, live
from erclutch.wings.live.c_core import Core
from erclutch.wings.live.controller_check import OUTPUTS
from erclutch.wings.live.layout import EVENT_BITS, FRAME, MOST, SAMPLE, SETTINGS
from erclutch.wings.live.settings import LoopProgram, LoopSettings, Mode, Waveform
from erclutch.wings.live.targets import controller
from tests.support import live_proof, proof, two_exports
from tests.support.slow_params import slow_but

FLOAT32 = ExportOptions("m", "float32", 1e-3)
FLOAT64 = ExportOptions("m", "float64", 1e-3)
#: Models whose C is compiled in half the time.
BRAKES = ("casson+lag, single", "bingham, single")
#: Advisory rules that tests/export/test_c_rules.py names for the model, and those that the loop's style does not keep.
ADVISORY = {"2.5", "8.7", "8.9", "12.1", "12.3", "13.4", "15.5", "17.8", "19.2"}


def numbers(members: list[str]) -> type[ctypes.Structure]:
    fields = [
        (name, ctypes.c_uint32 if name == "observer" else ctypes.c_double) for name in members
    ]
    fields = [(name, ctypes.c_uint64 if name == "period_ns" else kind) for name, kind in fields]
    return type("Numbers", (ctypes.Structure,), {"_fields_": fields})


#: Libraries by the text of their sources: the same controller is compiled once.
_COMPILED: dict[str, bytes] = {}


def compiled(model: Any, folder: Path, *more: str) -> ctypes.CDLL:
    files = controller.write_core(step_of(model, FLOAT64), folder)
    size = '#include "m.h"\nunsigned size(void) { return (unsigned)sizeof(m_controller); }\n'
    (folder / "size.c").write_text(size)
    sources = [*files, *(folder / name for name in ("size.c", *more))]
    texts = sorted(
        (file.name, file.read_text()) for file in folder.iterdir() if file.suffix in (".c", ".h")
    )
    key = str(texts)
    if key not in _COMPILED:
        # Optimisation gives the same bits, as `test_the_same_bits_everywhere` shows, and takes most of the time.
        native().build(sources, folder / "m.so", "-O0", "-shared", "-fPIC", f"-I{folder}")
        _COMPILED[key] = (folder / "m.so").read_bytes()
    # A file of its own each time: a library that is loaded twice from one path has its numbers once.
    (folder / "m.so").write_bytes(_COMPILED[key])
    return ctypes.CDLL(str(folder / "m.so"))


def steady(lib: ctypes.CDLL, program: Any, share: float, speed: float) -> float:
    """Effort at rest under a share of the largest field; below zero that of clutch 2."""
    field, effort = share * program.field.range[1], ctypes.c_double()
    fields = (max(field, 0.0), max(-field, 0.0))[: program.elements]
    lib.m_steady((ctypes.c_double * 5)(*fields, speed), ctypes.byref(effort))
    return effort.value


@pytest.mark.slow
@pytest.mark.parametrize("observer", slow_but(["motion"], ["none", "sensor", "motion"]))
@pytest.mark.parametrize(
    "label", slow_but(BRAKES, ("bingham+rise-fall, coaxial", "casson+lag, single"))
)
def test_the_controller_is_the_loop_s(
    label: str, observer: Any, models: Mapping[str, Any], tmp_path: Path
) -> None:
    """Fields and estimate of the loop, fed with what the loop saw, but for the last digits of libm's exp and tanh."""
    model = models[label]
    program = step_of(model, FLOAT64)
    device = model.structure.device
    rows, speed = 900, 0.3 * max(abs(x) for x in program.slip.range)
    lib = compiled(model, tmp_path)
    low, high = (
        steady(lib, program, share, speed) for share in (0.2 if device == "single" else -0.7, 0.7)
    )
    middle, top = 0.5 * (low + high), 0.5 * (high - low)
    asked = LoopProgram("torque", Mode.TORQUE, Waveform.SINE, top, 4.0, middle, motor_torque=0.1)
    start = controller.defaults(program)
    given = {
        "observer_bandwidth": 10.0,
        "gain_rate": 2.0,
        "integral_rate": 5.0,
        "drive_inertia": 2e-4,
        "torque_lag": 1e-3,
    }
    own: Any = {name: value for name, value in start.items() if name != "period_ns"} | given
    settings = LoopSettings(device=device, observer=observer, programs=(asked,), **own)
    samples = np.zeros(rows, SAMPLE)
    k = np.arange(rows)
    samples["seq"], samples["time_ns"] = k + 1, (k + 1) * np.uint64(1_000_000)
    samples["theta"] = 1e-3 * speed * k
    samples["torque"] = 0.9 * middle + 0.9 * top * np.sin(2.0 * np.pi * 4e-3 * (k - 2))
    (tmp_path / "live").mkdir()
    library = build(step_of(model, ExportOptions("live", "float64", 1e-3)), tmp_path / "live")
    core, frames = Core(settings, library), np.zeros(rows, FRAME)
    for i in range(rows):
        frames[i] = core.step(samples[i : i + 1], i)[1]
    names = [*controller.settings_of()]
    knows = 1 + ["none", "sensor", "motion"].index(observer)
    config = numbers(names)(**{**own, "period_ns": 1_000_000, "observer": knows})
    memory = ctypes.create_string_buffer(lib.size())
    assert lib.m_control_reset(memory, ctypes.byref(config)) == 1
    out = (ctypes.c_double * 3)()
    found = np.zeros((rows, 3))
    phase = 2.0 * np.pi * 4e-3 * k
    for i in range(rows):
        wanted, rate = frames["reference"][i], top * 2.0 * np.pi * 4.0 * np.cos(phase[i])
        speeds = (frames["theta_dot"][i], frames["alpha_dot"][i])
        sample = (ctypes.c_double * 7)(wanted, rate, *speeds, 0.0, samples["torque"][i], 0.1)
        lib.m_control_step(memory, sample, out)
        found[i] = out
    assert np.ptp(found[:, 0]) > 0.3 * program.field.range[1]
    for column, name in enumerate(OUTPUTS):
        scale = np.max(np.abs(frames[name])) + 1e-9
        off = np.abs(found[:, column] - frames[name]) / scale
        assert np.max(off) <= 1e-6, (name, np.flatnonzero(off > 1e-9)[:5], off[off > 1e-9][:5])


@pytest.mark.slow
@pytest.mark.parametrize(
    "label", slow_but(BRAKES, ("fnn-16, coaxial", "hem, coaxial", "bingham, single"))
)
def test_an_estimate_that_the_inverse_has_said_has_the_bits_of_the_model(
    label: str, models: Mapping[str, Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of a model without a memory the controller does not compute the effort of the same field twice."""
    program = step_of(models[label], FLOAT64)
    rows = controller.sample_rows(program)
    rows[40::50, 2:4] = (1.7e308, -1.7e308)  # both are finite, their difference is not
    wide = {
        **controller.defaults(program),
        "field_limit": 1.4 * program.field.range[1],
    }  # beyond what the log has
    printed: list[bytes] = []
    for again in (False, True):
        if again:
            monkeypatch.setattr(controller, "_known_at_rest", lambda program: False)
        (tmp_path / str(again)).mkdir()
        lib = compiled(models[label], tmp_path / str(again))
        assert ("step_known" in (tmp_path / str(again) / "m.c").read_text()) is not again
        for observer in (1, 2, 3):
            config = numbers([*controller.settings_of()])(
                **{**wide, "period_ns": 1_000_000, "observer": observer}
            )
            memory, out = ctypes.create_string_buffer(lib.size()), (ctypes.c_double * 3)()
            assert lib.m_control_reset(memory, ctypes.byref(config)) == 1
            told = [
                (lib.m_control_step(memory, (ctypes.c_double * 7)(*row), out), bytes(out))
                for row in rows
            ]
            printed.append(repr(told).encode())
    assert printed[:3] == printed[3:]


@pytest.mark.slow
def test_a_single_device_may_turn_fast_while_it_hardly_slips(
    models: Mapping[str, Any], tmp_path: Path
) -> None:
    """A clutch between two shafts: the log's slip says nothing of how fast both turn."""
    program = step_of(models["bingham, single"], FLOAT64)
    lib = compiled(models["bingham, single"], tmp_path)
    fastest = max(abs(end) for end in program.slip.range)
    told: list[list[float]] = []
    for output in (0.0, 40.0 * fastest):
        config = numbers([*controller.settings_of()])(
            **{**controller.defaults(program), "period_ns": 1_000_000, "observer": 1}
        )
        memory, out = ctypes.create_string_buffer(lib.size()), (ctypes.c_double * 3)()
        assert lib.m_control_reset(memory, ctypes.byref(config)) == 1
        for _ in range(100):
            row = [steady(lib, program, 0.5, 20.0), 0.0, output + 20.0, output, 0.0, np.nan, 0.0]
            lib.m_control_step(memory, (ctypes.c_double * 7)(*row), out)
        told.append(list(out))
    assert told[0][0] > 0.0
    assert told[1] == pytest.approx(told[0], rel=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize("column", [2, 3])
def test_a_speed_that_jumps_is_told_and_asks_for_no_field(
    column: int, models: Mapping[str, Any], tmp_path: Path
) -> None:
    """A jump from one end of the log beyond the other in a period. Speed that lasts is believed after some periods."""
    program = step_of(models["bingham+rise-fall, coaxial"], FLOAT64)
    lib = compiled(models["bingham+rise-fall, coaxial"], tmp_path)
    top = max(abs(end) for end in program.slip.range)
    config = numbers([*controller.settings_of()])(
        **{**controller.defaults(program), "period_ns": 1_000_000, "observer": 1}
    )
    memory, out = ctypes.create_string_buffer(lib.size()), (ctypes.c_double * 3)()
    assert lib.m_control_reset(memory, ctypes.byref(config)) == 1
    usual = [steady(lib, program, 0.5, 0.4 * top), 0.0, 0.4 * top, 0.0, 0.0, np.nan, 0.0]
    for _ in range(50):
        events = lib.m_control_step(memory, (ctypes.c_double * 7)(*usual), out)
    before, estimate = out[0], out[2]
    name = "theta-doubted" if column == 2 else "alpha-doubted"
    doubted = EVENT_BITS[name] | EVENT_BITS["glitch"]
    assert before > 0.0
    assert events & doubted == 0
    jump = [*usual]
    jump[column] += 2.5 * top
    events = lib.m_control_step(memory, (ctypes.c_double * 7)(*jump), out)
    assert events & doubted == doubted
    assert out[0] == 0.0
    assert out[2] == pytest.approx(estimate, rel=0.01), "the model keeps the last good speeds"
    told = [
        lib.m_control_step(memory, (ctypes.c_double * 7)(*jump), out) & doubted for _ in range(5)
    ]
    assert told[-1] == 0, "a speed that lasts is one"


@pytest.mark.slow
@pytest.mark.parametrize("bad", ["swinging", "not a number"])
def test_speeds_that_cannot_be_end_the_field_for_good_and_missing_ones_do_not(
    bad: str, models: Mapping[str, Any], tmp_path: Path
) -> None:
    """An encoder that jumped: its filtered speed swung and came to rest, was believed, and the field came back."""
    program = step_of(models["bingham+rise-fall, coaxial"], FLOAT64)
    lib = compiled(models["bingham+rise-fall, coaxial"], tmp_path)
    top = max(abs(end) for end in program.slip.range)
    config = numbers([*controller.settings_of()])(
        **{**controller.defaults(program), "period_ns": 1_000_000, "observer": 1}
    )
    memory, out = ctypes.create_string_buffer(lib.size()), (ctypes.c_double * 3)()
    assert lib.m_control_reset(memory, ctypes.byref(config)) == 1
    usual = [steady(lib, program, 0.5, 0.4 * top), 0.0, 0.4 * top, 0.0, 0.0, np.nan, 0.0]
    swings = [400.0, -300.0, 200.0, -140.0, 100.0, -70.0]  # times the largest slip
    speeds = [np.nan] * 6 if bad == "not a number" else [size * top for size in swings]
    fields, flags = [], 0
    for speed in [0.4 * top] * 50 + speeds + [0.4 * top] * 200:
        sample = (ctypes.c_double * 7)(*usual[:2], speed, *usual[3:])
        flags = lib.m_control_step(memory, sample, out)
        fields.append(out[0])
    assert fields[49] > 0.0
    assert max(fields[50:56]) == 0.0
    is_over = flags & EVENT_BITS["trip"] != 0
    assert (is_over, fields[-1] > 0.0) == ((True, False) if bad == "swinging" else (False, True))


@pytest.mark.slow
@pytest.mark.parametrize("observer", [1, 2, 3])
@pytest.mark.parametrize("column", [0, 1, 2, 5, 6])
def test_a_sample_that_cannot_be_does_no_harm_for_long(
    observer: int, column: int, models: Mapping[str, Any], tmp_path: Path
) -> None:
    """1e30 is finite. Four seconds later fields are what they were on a device that is as its model."""
    program = step_of(models["bingham, single"], FLOAT64)
    lib = compiled(models["bingham, single"], tmp_path)
    wanted = steady(lib, program, 0.5, 20.0)
    given = {"period_ns": 1_000_000, "observer": observer, "integral_rate": 5.0, "gain_rate": 2.0}
    config = numbers([*controller.settings_of()])(
        **{**controller.defaults(program), **given, "drive_inertia": 2e-4}
    )
    fields: list[float] = []
    for spike in (1e30, -1e30):
        memory, out = ctypes.create_string_buffer(lib.size()), (ctypes.c_double * 3)()
        assert lib.m_control_reset(memory, ctypes.byref(config)) == 1
        for k in range(7000):
            motor = out[2] if observer == 3 else 0.0  # the drive is held at its speed
            row = [wanted, 0.0, 20.0, 0.0, 0.0, out[2], motor]
            if k == 3000:
                fields.append(out[0])
                row[column] = spike
            lib.m_control_step(memory, (ctypes.c_double * 7)(*row), out)
            assert all(map(math.isfinite, out))
        fields.append(out[0])
    assert fields[0] > 0.0
    assert fields == pytest.approx([fields[0]] * 4, rel=0.03)


@pytest.mark.slow
@pytest.mark.parametrize("label", ["bingham, single", "hem+rise-fall, coaxial", "fnn-16, coaxial"])
@pytest.mark.parametrize("options", [FLOAT32, FLOAT64], ids=["float32", "float64"])
def test_the_same_bits_everywhere(
    label: str,
    options: ExportOptions,
    models: Mapping[str, Any],
    tmp_path: Path,
    need: Callable[..., None],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    need("gcc", "make")
    # zig is a younger clang, so one of the two compiles each precision, as in `tests/export/test_conformance.py`.
    other = {"float64": "clang", "float32": "zig"}[options.precision]
    taken = tuple(compiler for compiler in natives() if compiler.name != other)
    for place in (c, controller):
        monkeypatch.setattr(place, "natives", lambda: taken)
    folder = export_model(models[label], tmp_path / "out", "controller", options)
    checks = verify_export(folder)
    assert all(check.passed for check in checks)
    assert sum(check.where.startswith("controller") for check in checks) >= len(taken)
    # All levels of optimisation have just given these bits: the Makefile is asked at the quickest.
    make = ["make", "-C", str(folder), "check", "CFLAGS=-O0"]
    said = subprocess.run(make, capture_output=True, text=True, check=True).stdout
    assert "512 samples through the controller, 0 not to the bit" in said
    bench = folder / "m_control_check.c"
    text = bench.read_text()
    first = re.search(r"answers\[512\]\[4\] = \{\n    \{(0x[0-9a-f]+)", text)
    assert first is not None
    bench.write_text(f"{text[: first.start(1)]}0x3f000001{text[first.end(1) :]}")
    failed = subprocess.run(make, capture_output=True, text=True, check=False)
    assert failed.returncode != 0
    assert "1 not to the bit" in failed.stdout
    with pytest.raises(ExportError, match="was changed after the export"):
        verify_export(folder)


#: Whether what the stages keep is finite, in the order of the struct.
KEPT = """
#include "m.h"
unsigned finite(const m_controller *c)
{
    const double kept[] = {c->stages.rest, c->stages.integral, c->stages.late, c->stages.modelled, c->stages.reaction,
        c->stages.speed, c->stages.slow_speed, c->stages.found, c->stages.gave, c->stages.slope, c->stages.turned,
        c->stages.lacking, c->stages.learned[0].gain, c->stages.learned[0].drag, c->stages.learned[0].spread[0],
        c->stages.learned[0].spread[1], c->stages.learned[0].spread[2], c->meter.expected, c->field, c->estimate};
    unsigned i;
    for (i = 0u; i < sizeof kept / sizeof kept[0]; i++) { if (!(kept[i] - kept[i] == 0.0)) { return i + 1u; } }
    return 0u;
}
"""


@pytest.mark.slow
def test_whatever_a_reset_accepts_nothing_overflows(
    models: Mapping[str, Any], tmp_path: Path
) -> None:
    """Each setting at the ends of its range, with samples of any size: what the stages keep stays finite."""
    (tmp_path / "kept.c").write_text(KEPT)
    lib = compiled(models["bingham, single"], tmp_path, "kept.c")
    program, rng = step_of(models["bingham, single"], FLOAT64), np.random.default_rng(1)
    effort = steady(lib, program, 0.5, 20.0)
    plain = {
        **controller.defaults(program),
        "period_ns": 1_000_000,
        "integral_rate": 5.0,
        "gain_rate": 2.0,
    }
    out = (ctypes.c_double * 3)()
    for name in [*controller.settings_of()][1:-1]:
        for end in (SETTINGS[name].least, MOST):
            for observer in (1, 2, 3):
                config = numbers([*controller.settings_of()])(
                    **{**plain, name: end, "observer": observer}
                )
                memory = ctypes.create_string_buffer(lib.size())
                assert lib.m_control_reset(memory, ctypes.byref(config)) == 1, (name, end)
                for k in range(80):
                    row = [effort, 0.0, 20.0, 0.0, 0.0, effort, 0.1]
                    if k % 4 == 3:
                        row[rng.integers(7)] = float(rng.choice([1e308, -1e308, 1e30, 0.0, -20.0]))
                    lib.m_control_step(memory, (ctypes.c_double * 7)(*row), out)
                    assert lib.finite(memory) == 0, (name, end, observer, k, lib.finite(memory))


@pytest.mark.slow
def test_settings_that_cannot_be_leave_the_field_at_zero(
    models: Mapping[str, Any], tmp_path: Path
) -> None:
    lib = compiled(models["bingham, single"], tmp_path)
    program = step_of(models["bingham, single"], FLOAT64)
    good = {**controller.defaults(program), "period_ns": 1_000_000, "observer": 1}
    memory, out = ctypes.create_string_buffer(lib.size()), (ctypes.c_double * 3)()
    sample = (ctypes.c_double * 7)(
        steady(lib, program, 0.5, 20.0), 0.0, 20.0, 0.0, 0.0, np.nan, 0.0
    )
    spoilt = [
        ("period_ns", 99_999),
        ("observer", 4),
        ("drive_drag_2", np.nan),
        ("torque_scale", 0.0),
    ]
    spoilt += [(name, -1.0) for name in ("field_limit", "torque_lead", "rise_rate", "stroke")] + [
        ("fall_rate", np.inf)
    ]
    for name, value in [("", 0.0), *spoilt]:
        config = numbers([*controller.settings_of()])(**({**good, name: value} if name else good))
        assert lib.m_control_reset(memory, ctypes.byref(config)) == (not name), name
        for _ in range(50):
            lib.m_control_step(memory, sample, out)
        assert (out[0] > 0.0) == (not name), name


@pytest.mark.slow
def test_a_controller_is_written_for_a_slow_loop(models: Mapping[str, Any]) -> None:
    """At 100 Hz the filter's usual 150 Hz ended in an error, with a remedy that no option carried out."""
    slow = step_of(models["bingham, single"], replace(FLOAT64, period=0.01))
    gains = live(Derivative("kalman", 40.0), 0.01)
    text, _ = controller.texts(slow)
    assert f"core->momentum.g = {slow.precision.constant(gains.g)};" in text


def test_a_model_with_further_inputs_is_refused(models: Mapping[str, Any], tmp_path: Path) -> None:
    with pytest.raises(ExportError, match="gives its model fields and speeds, and nothing else"):
        export_model(
            models["bingham, single"],
            tmp_path / "out",
            "controller",
            replace(FLOAT64, inputs="angles"),
        )
    assert not (tmp_path / "out").exists()


def test_a_model_without_a_field_has_no_controller(
    models: Mapping[str, Any], tmp_path: Path
) -> None:
    model = models["bingham, single"]
    at_no_field = replace(model, trained_on=replace(model.trained_on, field=(0.0, 0.0)))
    with pytest.raises(ExportError, match="no field gives a wanted effort"):
        export_model(at_no_field, tmp_path / "out", "controller", FLOAT64)
    assert not (tmp_path / "out").exists()


@pytest.mark.slow
@pytest.mark.parametrize("compiler", ["gcc", "clang"])
@pytest.mark.parametrize("precision", ["float32", "float64"])
def test_no_warning(
    compiler: str,
    precision: Any,
    models: Mapping[str, Any],
    tmp_path: Path,
    need: Callable[..., None],
) -> None:
    need(compiler)
    more = ("-Wshadow", "-Wcast-qual", "-Wstrict-prototypes", "-Wdouble-promotion")
    options = ExportOptions("m", precision, 1e-3)
    # The law without a memory has the inverse's answer and a measured torque in one function.
    cases = [
        ("bingham+rise-fall, coaxial", options),
        ("fnn-3+rise-fall, single", options),
        ("bingham, single", replace(options, adapt=True)),
    ]
    for label, asked in cases:
        (file,) = controller.write_core(step_of(models[label], asked), tmp_path)
        words = [compiler, *EXACT, *STRICT, *more, "-c", str(file), "-o", str(tmp_path / "m.o")]
        done = subprocess.run(words, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
        calls = subprocess.run(
            ["nm", "-u", str(tmp_path / "m.o")], capture_output=True, text=True, check=True
        ).stdout
        assert set(re.findall(r"U (\w+)", calls)) <= {
            "memcpy",
            "memset",
            "_GLOBAL_OFFSET_TABLE_",
        }, "no libm"


@pytest.mark.slow
def test_no_required_rule_of_misra_is_broken(
    models: Mapping[str, Any], tmp_path: Path, need: Callable[..., None]
) -> None:
    need("cppcheck")
    controller.write_core(step_of(models["hem+rise-fall, coaxial"], FLOAT32), tmp_path)
    words = ["cppcheck", "--std=c99", "--addon=misra", "--enable=warning,portability", "-q"]
    words += [
        "--suppress=incorrectLogicOperator",
        "--suppress=missingIncludeSystem",
        str(tmp_path / "m.c"),
    ]
    said = subprocess.run(words, capture_output=True, text=True, check=True).stderr
    found = set(re.findall(r"\[misra-c2012-([\d.]+)\]$", said, re.MULTILINE))
    assert "19.2" in found, "the addon ran"
    assert found <= ADVISORY, said


@pytest.mark.slow
@pytest.mark.parametrize("label", live_proof.CONTROLLED)
def test_no_alarm_and_all_within_limits_for_any_bits(
    label: str, models: Mapping[str, Any], tmp_path: Path, need: Callable[..., None]
) -> None:
    need("frama-c")
    said = live_proof.proved_controller(step_of(models[label], FLOAT32), tmp_path)
    assert said.alarms == 0
    assert set(said.shown) == {"step", "lacking", "never_both", "first", "second"}
    assert all(all(shown) for shown in said.shown.values()), said.shown
    source = (tmp_path / "m.c").read_text(encoding="ascii")
    assert source.count("assert \\is_finite(value);") == 1, (
        "the one fact more than of the model, behind the test of bits"
    )
    (tmp_path / "m.c").write_text(
        source.replace("return value < low ? low : high;", "return value;"), encoding="ascii"
    )
    spoilt = proof.analysed(
        tmp_path, ["limits.c"], "-eva-slevel", "200", "-eva-partition-history", "2"
    )
    assert not all(spoilt.shown["first"])


@pytest.mark.slow
@pytest.mark.usefixtures("own_machine")
@pytest.mark.parametrize("options", [FLOAT32, FLOAT64], ids=["float32", "float64"])
def test_the_controller_in_an_fmu(
    options: ExportOptions, models: Mapping[str, Any], tmp_path: Path
) -> None:
    """The C's bits through FMPy; a setting is a parameter, and a setting that cannot be leaves the fields at zero."""
    fmpy = pytest.importorskip("fmpy", reason="pip install fmpy")
    folder = export_model(
        models["bingham+rise-fall, coaxial"], tmp_path / "out", "controller-fmu", options
    )
    (check,) = verify_export(folder)
    assert check.passed
    assert check.count == 512
    program = step_of(models["bingham+rise-fall, coaxial"], options)
    wanted = np.array(
        [(t, 0.5 * program.scale) for t in (0.0, 1.0)], [("time", float), ("wanted", float)]
    )
    for limit, most in ((None, program.field.range[1]), (0.25, 0.25), (-1.0, 0.0)):
        given = {} if limit is None else {"field_limit": limit}
        given |= {"theta_dot": 10.0}
        found = fmpy.simulate_fmu(
            str(folder / "m_fmi3.fmu"), stop_time=0.1, start_values=given, input=wanted
        )
        top = float(np.max(np.maximum(found["field1"], found["field2"])))
        assert top == pytest.approx(min(most, top), rel=1e-6), limit
        assert (top > 0.0) == (limit is None or limit > 0.0), limit


@pytest.mark.slow
@pytest.mark.parametrize("one_file", [False, True])
def test_two_controllers_in_one_program_have_their_own_numbers(
    models: Mapping[str, Any], one_file: bool, tmp_path: Path, need: Callable[..., None]
) -> None:
    """In one file, as a unity build joins them, their functions and constants had the same names."""
    need("gcc")
    sources: list[Path] = []
    body: list[str] = []
    for name, label in (("one", "casson+lag, single"), ("two", "fnn-3+rise-fall, single")):
        home = tmp_path / name
        home.mkdir()
        program = step_of(models[label], ExportOptions(name, "float64", 1e-3))
        sources += controller.write_core(program, home)
        body.append(asked_of(program.name))
    headers = [source.with_suffix(".h") for source in sources]
    together = two_exports.program(tmp_path, sources, headers, body, one_file=one_file)
    assert together.refused == ""
    alone = [
        two_exports.program(tmp_path, [source], [header], [asked], one_file=False).printed
        for source, header, asked in zip(sources, headers, body, strict=True)
    ]
    assert together.printed == "".join(alone)
    assert alone[0] != alone[1]


def asked_of(name: str) -> str:
    """C that prints the fields of a controller for a torque, to the bit."""
    return f"""{{
    static {name}_controller memory;
    {name}_settings settings = {name.upper()}_CONTROL_DEFAULTS;
    {name}_input input = {{0}};
    {name}_output output;
    int i;
    (void){name}_control_reset(&memory, &settings);
    for (i = 0; i < 50; i++)
    {{
        input.wanted = 0.2;
        input.theta_dot = 5.0 + 0.01 * i;
        (void){name}_control_step(&memory, &input, &output);
    }}
    printf("%a %a\\n", (double)output.field1, (double)output.estimate);
}}"""
