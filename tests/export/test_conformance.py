"""Every model on every target: the bits of the emulation, and NumPy's numbers within the stated bounds."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace
from itertools import product
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from erclutch.arithmetic.evaluation import evaluate
from erclutch.arithmetic.precision import FLOAT32, FLOAT64
from erclutch.arithmetic.record import Record
from erclutch.export import Check, ExportOptions, export_model, step_of, verify_export
from erclutch.export.c.compilers import EXACT, STRICT, natives
from erclutch.export.c.compilers import run as told
from erclutch.export.exported_step import NON_FINITE, OUT_OF_REACH, ExportedStep
from erclutch.export.rounding import ULPS, Errors, bound, filter_error, oscillator_error
from erclutch.export.step_numbers import inverse, inverse_now, named, numbers, reference, run
from erclutch.export.step_record import feels_next_field, rest_record
from erclutch.export.step_vectors import odd_values, ordinary, rows_of, vectors_of
from erclutch.export.target_check import compare, ulps
from erclutch.export.targets.c import write
from erclutch.models.law_model import TorqueModel
from erclutch.models.model import Model
from erclutch.models.networks.network_model import NetworkModel
from erclutch.models.stages import slip_stages
from erclutch.models.stages.oscillator import coefficients
from erclutch.signals.array import Array
from tests.support.slow_params import slow_but

#: Bounds of docs/export.md, in units of the last place at the largest training effort: float64 has NumPy's bits.
BOUND = {"float64": 0.0, "float32": 8.0}
PERIOD = 1e-3


def program(model: Model, precision: str = "float64", **options: object) -> ExportedStep:
    return step_of(
        model, ExportOptions(**{"name": "m", "precision": precision, "period": PERIOD, **options})
    )  # type: ignore[arg-type]


def _against_numpy(model: Model, precision: str, count: int) -> None:
    made = program(model, precision)
    rows = rows_of(made, np.random.default_rng(5), count)
    effort, flags = run(made, rows)
    expected, expected_flags = reference(made, rows)
    assert np.all(np.isfinite(effort))
    assert np.array_equal(flags, expected_flags)
    difference = np.abs(effort - expected)
    # Where a network gives way to a law, a cell's share makes 16 last digits of the effort of one of the field.
    assert ulps(made, float(np.max(difference))) <= BOUND[precision] * (
        1.0 if model.gives_way is None else 16.0
    )
    if precision == "float32":  # in float64 the difference is nought
        # The stated bound of the error analysis, NumPy's own rounding included, holds row by row. A row's bound takes
        # five times as long as its effort and follows from that row and those before.
        first = rows[:2_000]
        assert np.all(difference[:2_000] <= bound(made, first) + bound(made, first, FLOAT64))


@pytest.mark.slow
def test_the_bound_says_something(model: Model) -> None:
    """An oscillation, a filter and a memory do not make it grow from row to row."""
    made = program(model)
    limit = bound(made, ordinary(made, np.random.default_rng(3), 300))
    assert 0.0 < np.max(limit) < 1e-6 * made.scale


def test_step_is_numpys(model: Model) -> None:
    _against_numpy(model, "float64", 300)


@pytest.mark.slow
@pytest.mark.parametrize("precision", ["float64", "float32"])
def test_step_is_numpys_on_ten_thousand_rows(model: Model, precision: str) -> None:
    # A memory of the slip is computed row by row, and takes as long for fewer rows.
    _against_numpy(model, precision, 2_000 if slip_stages(model.structure.dynamics) else 10_000)


@pytest.mark.slow
def test_a_fitted_model_gives_predicts_bits(tmp_path: Path, need: Callable[..., None]) -> None:
    """Gains of 1e7 that cancel, large weights: what a unit in the last place of an exp becomes."""
    from erclutch.fit.comparison import Settings, compare
    from erclutch.runs.run_folder import read_run
    from erclutch.runs.written_run import write_run
    from tests.support.pair import pair_log, pair_rows

    need("gcc")
    found = compare(pair_rows(20.0), Settings(models=("rbfm-10", "fnn-16", "rbfn-50"), lag="none"))
    write_run(tmp_path / "run", found, [pair_log(20.0)])
    fitted = read_run(tmp_path / "run")
    kernels = fitted.model("rbfm-10")
    assert isinstance(kernels, TorqueModel)
    assert max(abs(g) for g in kernels.gains.values()) > 1e4
    for name in sorted(fitted.names):
        model = fitted.model(name)
        _against_numpy(model, "float64", 10_000)
        folder = export_model(
            model, tmp_path / name, "python", ExportOptions(name="m", period=PERIOD)
        )
        _sound(verify_export(folder), "float64", 2)


def test_numpys_own_functions_would_not_do(models: dict[str, Model]) -> None:
    """That the bits agree is no chance: with NumPy's exp and tanh they do not."""
    from erclutch.signals.clock import Clock
    from erclutch.signals.device import Element

    rng = np.random.default_rng(4)
    elements = [
        Element(rng.uniform(0.0, 600.0, 2000), rng.uniform(-30.0, 30.0, 2000)) for _ in range(2)
    ]
    clock = Clock(np.zeros(2000), ())
    for label in ("fnn-16, coaxial", "hem, coaxial", "seo-seo, coaxial", "rbfn-50, coaxial"):
        model = models[label]
        own, other = (model.effort(elements, clock, exactly=flag) for flag in (True, False))
        assert np.count_nonzero(own != other) > 0
        assert np.max(np.abs(own - other)) < 1e-13 * np.max(np.abs(own))


def _sound(checks: list[Check], precision: str, least: int, model: Model | None = None) -> None:
    assert len(checks) >= least
    assert [c.where for c in checks if not c.passed or c.other_bits != 0] == []
    gives_way = model is not None and model.gives_way is not None
    assert max(c.ulp for c in checks) <= BOUND[precision] * (16.0 if gives_way else 1.0)


@pytest.mark.slow
@pytest.mark.parametrize("precision", ["float64", "float32"])
def test_every_compiler_and_processor_gives_the_same_bits(
    model: Model,
    precision: str,
    tmp_path: Path,
    need: Callable[..., None],
    boards: ModuleType,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    need(
        "gcc", "clang", "qemu-aarch64", "qemu-ppc", "aarch64-linux-gnu-gcc", "powerpc-linux-gnu-gcc"
    )
    need("arm-none-eabi-gcc", "qemu-system-arm")
    pytest.importorskip("ziglang", reason="pip install ziglang")
    options = ExportOptions(name="m", precision=precision, period=PERIOD)  # type: ignore[arg-type]
    folder = export_model(model, tmp_path / "c", "c", options)
    # zig is a younger clang, so one of the two compiles each precision; the file calls nothing of a C library.
    other = {"float64": "clang", "float32": "zig"}[precision]
    taken = [compiler for compiler in natives() if compiler.name != other]
    monkeypatch.setattr("erclutch.export.targets.c.natives", lambda: taken)
    # Two compilers at three levels, two processors under qemu-user.
    _sound(verify_export(folder), precision, 8, model)
    made = program(model, precision)
    # Neither board computes with doubles: both call the same library for them, so one of the two shows what it gives.
    for board in boards.BOARDS if precision == "float32" else boards.BOARDS[-1:]:
        outcome = boards.run_board(
            board, made, folder, tmp_path, repeats=1
        )  # bits are asked for, no speed
        _sound([compare(made, vectors_of(made), board.name, outcome.printed)], precision, 1, model)
        assert outcome.note.endswith("flash")


@pytest.mark.slow
@pytest.mark.parametrize("name", slow_but(("fnn-6-7",), ("fnn-16", "fnn-6-7", "fnn-4-5-9")))
def test_a_network_has_the_same_bits_with_vectors_and_without(
    name: str, network: Callable[..., NetworkModel], tmp_path: Path, need: Callable[..., None]
) -> None:
    """Float32 has a text of the forward pass for each: neurons left over from fours, two layers, saturated ones."""
    need("gcc")
    made = program(network(name), "float32")
    write(made, tmp_path)
    text = (tmp_path / "m.c").read_text(encoding="ascii")
    assert text.count("static m_real m_network(") == 2
    sources = [str(tmp_path / file) for file in ("m.c", "m_check.c")]
    for options in ((), ("-U__SSE2__", "-U__ARM_NEON")):
        checked = tmp_path / "checked"
        command = ["gcc", *EXACT, *STRICT, "-O2", *options, *sources, "-o", str(checked)]
        told(command, "not compiled", "")
        told([str(checked)], "other bits", "")  # exits with 1 where a bit is another


@pytest.mark.usefixtures("compiled_plainly")
@pytest.mark.slow
@pytest.mark.parametrize("precision", ["float64", "float32"])
def test_python_gives_the_same_bits(
    model: Model, precision: str, tmp_path: Path, need: Callable[..., None]
) -> None:
    need("gcc")
    options = ExportOptions(name="m", precision=precision, period=PERIOD)  # type: ignore[arg-type]
    folder = export_model(model, tmp_path / "p", "python", options)
    _sound(verify_export(folder), precision, 2, model)


@pytest.mark.slow
@pytest.mark.parametrize("inputs", ["angles"])
@pytest.mark.parametrize(
    "label", ["hem+rise-fall, coaxial", "fnn-16, coaxial", "casson+lag, single"]
)
def test_angles_are_differentiated_as_live_does(
    models: dict[str, Model], label: str, inputs: str
) -> None:
    from erclutch.signals.speed import Derivative, live

    made = program(models[label], inputs=inputs, derivative=Derivative("kalman", 120.0))
    plain = program(models[label])
    e = made.elements
    speeds = ordinary(plain, np.random.default_rng(2), 300)
    rows = speeds.copy()
    # Smooth enough to stay within half a turn: the wrap has a test of its own.
    rows[:, e : 2 * e] = 0.3 * np.sin(np.outer(np.arange(300) * PERIOD, 40.0 + 7.0 * np.arange(e)))
    for k in range(e, 2 * e):
        filter_ = live(Derivative("kalman", 120.0), PERIOD)
        speeds[:, k] = [filter_.step(x) for x in rows[:, k]]
    effort, flags = run(made, rows)
    expected, expected_flags = run(plain, speeds)
    assert np.array_equal(flags, expected_flags)
    assert np.max(np.abs(effort - expected)) <= 1e-10 * made.scale


@pytest.mark.slow
def test_an_angle_that_wraps_is_the_angle_that_goes_on(models: dict[str, Model]) -> None:
    made = program(models["hem+rise-fall, coaxial"], inputs="angles")
    angle = np.cumsum(np.full(700, 0.025))
    rows = np.column_stack([np.full(700, 300.0), np.zeros(700), angle, 0.4 * angle])
    wrapped = rows.copy()
    wrapped[:, 2:] %= 2 * np.pi
    through, _ = run(made, rows)
    around, _ = run(made, wrapped)
    assert angle[-1] > 5 * np.pi
    assert np.max(np.abs(through - around)) < 1e-9 * made.scale


def test_the_last_good_row_stands_in_for_a_bad_one(models: dict[str, Model]) -> None:
    made = program(models["hem, coaxial"])
    rows = ordinary(made, np.random.default_rng(1), 20)
    rows[:3, 0] = np.nan
    rows[7] = np.inf
    effort, flags = run(made, rows)
    assert list(effort[:3]) == [0.0, 0.0, 0.0]
    assert effort[7] == effort[6] != 0.0
    assert list(flags[[0, 1, 2, 7]] & NON_FINITE) == [NON_FINITE] * 4
    assert not np.any(flags[[3, 4, 8]] & NON_FINITE)


@pytest.mark.parametrize("label", ["hem, coaxial", "fnn-7, coaxial", "casson+lag, single"])
def test_a_row_with_one_bad_number_counts_as_the_row_before(
    models: dict[str, Model], label: str
) -> None:
    made = program(models[label])
    rows = ordinary(made, np.random.default_rng(1), 20)
    held = rows.copy()
    held[7] = rows[6]
    expected = run(made, held)[0]
    for i in range(rows.shape[1]):
        bad = rows.copy()
        bad[7, i] = np.nan
        effort, flags = run(made, bad)
        assert np.array_equal(effort, expected)
        assert flags[7] & NON_FINITE


BINARY_OPERATIONS = {
    "add": np.add,
    "subtract": np.subtract,
    "multiply": np.multiply,
    "divide": np.divide,
}
FUNCTIONS = {
    "exp": np.exp,
    "expm1": np.expm1,
    "tanh": np.tanh,
    "negate": np.negative,
    "absolute": np.absolute,
}


@pytest.mark.parametrize("name", [*BINARY_OPERATIONS, *FUNCTIONS])
def test_the_error_of_an_operation_is_neither_too_small_nor_twice_too_large(name: str) -> None:
    """Errors of the arguments far above rounding: the bound is the largest deviation at their ends."""
    record = Record()
    function = BINARY_OPERATIONS.get(name) or FUNCTIONS[name]
    count = 2 if name in BINARY_OPERATIONS else 1
    node = record.operand(name, *(record.input(f"x{i}") for i in range(count))).node
    for values in ((1.3, -0.7), (-0.4, 2.1)):
        x, e = np.array(values[:count]), np.array([1e-6, 3e-6])[:count]
        value, error = Errors(None, FLOAT64).apply(
            node, [np.array([[a], [b]]) for a, b in zip(x, e, strict=True)]
        )[:, 0]
        ends = [
            function(*(x + e * np.array(signs))) for signs in product((-1.0, 1.0), repeat=count)
        ]
        worst = float(np.max(np.abs(np.array(ends) - function(*x))))
        assert value == pytest.approx(float(function(*x)), rel=1e-15)
        assert worst * (1.0 - 1e-5) <= error <= worst * (1.0 + 1e-5)


@pytest.mark.parametrize("name", [*BINARY_OPERATIONS, *FUNCTIONS])
def test_the_rounding_of_an_operation_is_that_of_its_result(name: str) -> None:
    record = Record()
    count = 2 if name in BINARY_OPERATIONS else 1
    node = record.operand(name, *(record.input(f"x{i}") for i in range(count))).node
    exact = [np.array([[a], [0.0]]) for a in (1.3, -0.7)[:count]]
    value, error = Errors(None, FLOAT64).apply(node, exact)[:, 0]
    units = {"negate": 0.0, "absolute": 0.0, **ULPS["float64"]}.get(name, 0.5)
    assert error == pytest.approx(units * FLOAT64.epsilon * abs(value), rel=1e-12, abs=0.0)


def test_the_error_of_an_oscillator_is_bounded_from_both_sides() -> None:
    rng = np.random.default_rng(6)
    signal = rng.uniform(-1.0, 1.0, 400)
    q = {"tau": 4e-3, "zeta": 0.3}
    noise = 1e-6 * rng.choice([-1.0, 1.0], 400)
    a11, a12, a21, a22 = coefficients(4e-3, 0.3, PERIOD)
    passes, into = np.array([[a11, a12], [a21, a22]]), np.array([1.0 - a11, -a21])

    def driven(given: Array, kind: type = np.float64) -> Array:
        state, out = np.zeros(2, kind), []
        for u in given.astype(kind):
            state = passes.astype(kind) @ state + into.astype(kind) * u
            out.append(state[0])
        return np.array(out)

    # The worst signs of the errors are those of the answer to a single push, backwards in time.
    answer = driven(np.eye(1, 400)[0])
    worst = 1e-6 * float(np.abs(answer).sum())
    limit = oscillator_error(q, PERIOD, driven(signal), signal, np.full(400, 1e-6), FLOAT64)
    assert float(np.max(np.abs(driven(signal + noise) - driven(signal)))) <= worst
    assert worst <= limit[-1] <= 1.01 * worst
    # Rounding alone, in float32 against float64.
    rounding = float(np.max(np.abs(driven(signal, np.float32) - driven(signal))))
    alone = oscillator_error(q, PERIOD, driven(signal), signal, np.zeros(400), FLOAT32)
    assert rounding <= alone[-1] <= 300.0 * rounding


def _at_rest(made: ExportedStep, rows: Array) -> Array:
    settled = rest_record(made)
    return evaluate(
        settled.record, named(settled, rows.astype(made.precision.dtype)), numbers(made)
    )[0]


@pytest.mark.slow
@pytest.mark.parametrize("precision", ["float64", pytest.param("float32", marks=pytest.mark.slow)])
def test_inverse_gives_the_field_of_an_effort(model: Model, precision: str) -> None:
    made = program(model, precision)
    rng = np.random.default_rng(11)
    rows = ordinary(made, rng, 64)
    wanted = _at_rest(made, rows)
    field, flags = inverse(made, rows, wanted)
    # Every one of these efforts is that of some field, so all are within reach.
    assert np.mean((flags & OUT_OF_REACH) == 0) > (
        0.99 if made.search.monotone_share == 1.0 else 0.9
    )
    again = rows.copy()
    again[:, 0] = np.maximum(field, 0.0) if made.elements == 2 else field
    if made.elements == 2:
        again[:, 1] = np.maximum(-field, 0.0)
    reached = (flags & OUT_OF_REACH) == 0
    steep = made.scale * 2.0 ** (-14 if precision == "float32" else -40)
    assert np.max(np.abs(_at_rest(made, again) - wanted)[reached]) <= steep


def test_out_of_reach_gives_the_nearest_end_and_says_so(models: dict[str, Model]) -> None:
    made = program(models["hem, coaxial"])
    speeds = np.array([[0.0, 0.0, 20.0, 0.0]] * 2)
    field, flags = inverse(made, speeds, np.array([1e3, -1e3]))
    assert list(flags & OUT_OF_REACH) == [OUT_OF_REACH] * 2
    assert list(field) == [made.search.plus, made.search.minus]


# --- inverse of the next step ----------------------------------------------------------------------------------------


def _with_delay(model: Model, delay: float) -> Model:
    if isinstance(model, TorqueModel):
        return replace(model, shape={**model.shape, "delay": delay})
    assert isinstance(model, NetworkModel)
    return replace(model, dynamics={**model.dynamics, "delay": delay})


def _applied(made: ExportedStep, rows: Array, k: int, field: float) -> tuple[float, int]:
    """Effort and flags of a row where its field is the signed one."""
    again = rows[: k + 1].copy()
    again[k, : made.elements] = (
        [max(field, 0.0), max(-field, 0.0)] if made.elements == 2 else [field]
    )
    effort, flags = run(made, again)
    return float(effort[k]), int(flags[k])


AHEAD = [
    "casson+rise-fall+dahl-2/field+inertia+effort-lag, single",
    "bingham/forward+rise-fall+dahl-2/field+inertia+effort-lag, coaxial",
    "fnn-16+rise-fall+dahl-2/field+inertia+effort-lag, coaxial",
    "hem+rise-fall, coaxial",
    "fnn-3+rise-fall, single",
]
AHEAD_QUICK = AHEAD[3:]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("precision", "count"),
    [
        ("float64", 12),
        pytest.param("float64", 40, marks=pytest.mark.slow),
        pytest.param("float32", 40, marks=pytest.mark.slow),
    ],
)
@pytest.mark.parametrize("label", slow_but(AHEAD_QUICK, AHEAD))
def test_the_field_for_the_next_step_gives_its_effort(
    models: dict[str, Model], label: str, precision: str, count: int
) -> None:
    made = program(_with_delay(models[label], 0.3e-3), precision)
    rows = ordinary(made, np.random.default_rng(8), count)
    # Near what the row gives anyway: a step changes little of what the memory holds.
    wanted = run(made, rows)[0] + np.random.default_rng(9).normal(size=count) * 2e-3 * made.scale
    wanted[::4] = run(made, rows)[0][::4]
    field, flags = inverse_now(made, rows, wanted)
    reached = (flags & OUT_OF_REACH) == 0
    assert np.all(reached[::4]), "the row's own field gives it"
    assert count // 4 < np.count_nonzero(reached) < count
    steep = made.scale * 2.0 ** (-14 if precision == "float32" else -40)
    for k in range(1, count):
        found = _applied(made, rows, k, float(field[k]))[0]
        if reached[k]:
            assert abs(found - wanted[k]) <= steep
        else:  # no field of a grid comes nearer, and the flag is true
            grid = np.linspace(made.search.minus, made.search.plus, 9)
            others = [abs(_applied(made, rows, k, f)[0] - wanted[k]) for f in grid.tolist()]
            assert abs(found - wanted[k]) <= min(others) + steep


@pytest.mark.slow
@pytest.mark.parametrize("label", slow_but(AHEAD[:1], AHEAD[:3]))
def test_behind_a_dead_time_the_next_effort_is_out_of_reach(
    models: dict[str, Model], label: str
) -> None:
    from erclutch.export.c.c_header import header

    made = program(_with_delay(models[label], 1.3e-3))
    assert not feels_next_field(made)
    assert feels_next_field(program(_with_delay(models[label], 0.3e-3)))
    assert "dead time" in header(made)
    rows = ordinary(made, np.random.default_rng(8), 12)
    effort = run(made, rows)[0]
    field, flags = inverse_now(made, rows, effort + 0.1 * made.scale)
    assert list(flags[1:]) == [OUT_OF_REACH] * 11
    assert list(field[1:]) == [made.search.origin] * 11
    # In the first row the fluid has settled at the row's own field, so the field counts at once.
    assert inverse_now(made, rows[:1], effort[:1])[1][0] == 0


@pytest.mark.slow
@pytest.mark.parametrize(
    "label", slow_but(AHEAD_QUICK, [*AHEAD, "hem, coaxial", "bingham+fnn-3, single"])
)
def test_after_a_reset_the_inverse_of_the_next_step_is_the_inverse_at_rest(
    models: dict[str, Model], label: str
) -> None:
    made = program(models[label])
    rows = ordinary(made, np.random.default_rng(4), 6)
    wanted = np.random.default_rng(5).uniform(*made.model.trained_on.effort, 6)
    field, flags = inverse(made, rows, wanted)
    for k in range(6):
        now, now_flags = inverse_now(made, rows[k : k + 1], wanted[k : k + 1])
        assert now[0] == pytest.approx(field[k], abs=4 * made.search.width)
        assert now_flags[0] == flags[k]


def test_a_bad_row_has_no_field_for_the_next_step(models: dict[str, Model]) -> None:
    made = program(models[AHEAD[0]], inputs="angles")
    rows = ordinary(made, np.random.default_rng(5), 5)
    rows[:, 1] = [0.1, np.nan, 2e6, 0.1, 0.1]
    rows[:, 0] = [np.nan, 1.0, 1.0, np.inf, 1.0]
    field, flags = inverse_now(made, rows, np.array([0.1, 0.1, 0.1, 0.1, np.nan]))
    assert list(flags & NON_FINITE) == [0, NON_FINITE, NON_FINITE, 0, NON_FINITE]
    assert list(field[[1, 2, 4]]) == [0.0] * 3
    assert np.all(np.isfinite(field))


# --- names -----------------------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_names_of_the_state_are_names_in_c(models: dict[str, Model]) -> None:
    from erclutch.export.step_record import step_record

    for model in models.values():
        record = step_record(program(model)).record
        names = [*record.after, *record.registers(), *record.labels.values()]
        assert all(re.fullmatch(r"[A-Za-z][A-Za-z0-9_]*", name) for name in names)
        assert len({*record.after, *record.registers()}) == len(record.after) + len(
            record.registers()
        )


def test_a_stage_whose_state_has_no_name_in_c_is_refused(
    models: dict[str, Model], monkeypatch: pytest.MonkeyPatch
) -> None:
    from erclutch.errors import ExportError
    from erclutch.export.step_record import step_record
    from erclutch.models.stages.effort_lag import EffortLag

    step_record.cache_clear()
    monkeypatch.setattr(EffortLag, "initial", lambda self, signal, q: {"Größe": signal})
    monkeypatch.setattr(
        EffortLag, "step", lambda self, memory, signal, q, period: (memory.keep("Größe", signal),)
    )
    with pytest.raises(ExportError, match="no name in C"):
        program(models[AHEAD[0]])


@pytest.mark.parametrize("period", [1e-4, 1e-3])
def test_the_bound_of_a_speed_from_angles(models: dict[str, Model], period: float) -> None:
    """The filter in float32 against float64, over angles within half a turn."""
    step = step_of(models["bingham, single"], ExportOptions("m", "float32", period, "angles"))
    filter_ = step.filter
    assert filter_ is not None
    angles = np.random.default_rng(0).uniform(-np.pi, np.pi, 2000).astype(np.float32)

    def speeds(kind: type) -> Array:
        g, h, t = kind(filter_.g), kind(filter_.h), kind(period)
        at, speed, out = kind(angles[0]), kind(0), [0.0]
        for angle in angles[1:]:
            ahead = at + t * speed
            off = kind(angle) - ahead
            at, speed = ahead + g * off, speed + h * off / t
            out.append(float(speed))
        return np.array(out)

    worst = float(np.max(np.abs(speeds(np.float32) - speeds(np.float64))))
    assert worst <= filter_error(step, FLOAT32) <= 100.0 * worst


def test_edges_have_both_zeros_and_both_infinities(models: dict[str, Model]) -> None:
    for column in odd_values(
        step_of(models["hem+rise-fall, coaxial"], ExportOptions("m", "float32", PERIOD))
    ):
        assert set(np.signbit(column[column == 0.0])) == {False, True}
        assert set(column[np.isinf(column)]) == {-np.inf, np.inf}
