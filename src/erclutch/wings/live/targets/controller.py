"""Target controller is the live loop's torque control and the model in one C99 file, in the target's number format.

Its C is the loop's own (``c/erc_torque.c``, ``c/erc_interlock.c``), said in the words of the model's file: the model's
number type, its functions in place of a library's, its prefix. So what is proved and tested of the loop is what runs on
the target. docs/control.md says how to use it.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from erclutch.errors import ExportError
from erclutch.export.c.c_header import header
from erclutch.export.c.c_source import source
from erclutch.export.c.compilers import Compiler, foreign, native, natives, run
from erclutch.export.encode import comment
from erclutch.export.exported_step import ExportedStep
from erclutch.export.monotone import releases
from erclutch.export.step_record import feels_state
from erclutch.export.target_check import Check
from erclutch.export.targets import c
from erclutch.files import scratch_folder
from erclutch.signals.array import Array, largest_size
from erclutch.signals.speed import live, usual_cutoff
from erclutch.wings.live.controller_check import INPUTS, check_source
from erclutch.wings.live.layout import CONSTANTS, EVENT_BITS, EVENTS, LEAST, MOST, SETTINGS
from erclutch.wings.live.motion_limits import USUAL_FILTER
from erclutch.wings.live.sensor_limits import torque_limits
from erclutch.wings.live.settings import LoopSettings

TITLE = "torque control, interlock and model in one C99 file, with test vectors and make check"
ALARMS = True
_HERE = Path(__file__).parents[1]
_ROWS = 512
#: Times the largest slip of the log: a sample beyond is none.
_FASTEST = 10.0
#: Times the largest slip of the log: from one end of the log to the other. No speed jumps further in a period.
_REVERSAL = 2.0
#: What the model's alarms get: a torque that can be, where the slip says what it has to be.
_MEASURED = "const double zero = 0.0, torque = core->meter.good && erc_slipping(core) ? input->torque : zero / zero;"
#: Files of the loop that the controller is made of, in the order in which they call each other.
_PARTS = ("turned", "plausible", "torque", "interlock")
#: Constants of the loop that the controller names too.
_NAMED = (
    "COAXIAL",
    "SINGLE",
    "BY_MODEL",
    "BY_SENSOR",
    "BY_MOTION",
    "STILL",
    "EARLIER",
    "ZERO_BEFORE_TRIP",
)
_NUMBER = re.compile(r"(?<![\w.])(\d+\.\d*(?:e[-+]?\d+)?|\d+e[-+]?\d+)(?![\w.])")


def write(step: ExportedStep, folder: Path) -> None:
    """The files of target c, with the controller in them, and its own test vectors.

    Raises:
        ExportError: a model that the loop cannot run either, or no compiler here.
    """
    write_core(step, folder)
    c.write_bench(step, folder)
    n = step.name
    rows = sample_rows(step)
    with scratch_folder() as work:
        printed = _printed(native(), folder, Path(work), step, rows)
    (folder / f"{n}_control_check.c").write_text(
        check_source(step, rows, printed), encoding="ascii"
    )

    # The check of the controller stands beside that of the model in each rule of the Makefile.
    makefile = folder / "Makefile"
    make = makefile.read_text(encoding="ascii")
    make = make.replace(
        f"check: {n}_check\n\t./{n}_check\n", f"check: {n}_check {n}_control_check\n\t./{n}_check\n"
    )
    make = make.replace(f"\t./{n}_check\n", f"\t./{n}_check\n\t./{n}_control_check\n", 1)
    build = f"{n}_control_check: {n}_control_check.c {n}.c {n}.h\n"
    build += f"\t$(CC) $(CFLAGS) $(EXACT) $(WARN) {n}_control_check.c {n}.c -o $@\n"
    make = make.replace(".PHONY: clean\n", f"{build}\n.PHONY: clean\n")
    make = make.replace(f"rm -f {n}_check", f"rm -f {n}_check {n}_control_check")
    makefile.write_text(make, encoding="ascii")


def write_core(step: ExportedStep, folder: Path) -> list[Path]:
    """The .c and .h alone; returns the files to compile.

    Raises:
        ExportError: see `texts`.
    """
    for text, kind in zip(texts(step), "ch", strict=True):
        (folder / f"{step.name}.{kind}").write_text(text, encoding="ascii")
    return [folder / f"{step.name}.c"]


def texts(step: ExportedStep) -> tuple[str, str]:
    """The .c and .h: the model's, and the controller after it.

    Raises:
        ExportError: a model of positions, without a field or released by it, or with inputs beyond the loop's.
    """
    if step.filter is not None or step.extras:
        problem = "the controller gives its model fields and speeds, and nothing else"
        raise ExportError(
            problem,
            where=step.model.name,
            remedy="Export a model without further inputs, of speeds",
        )
    problem = ""
    if step.field.range == (0.0, 0.0):
        problem = "the model was fitted without a field, so no field gives a wanted effort"
    elif releases(step.model):
        problem = (
            "the effort falls as the field grows, and this controller's way to safety is no field"
        )
    if problem:
        remedy = "Export it with --to c, which gives the effort"
        raise ExportError(problem, where=step.model.name, remedy=remedy)
    code = _read("target_c/controller.c")
    for name in _PARTS:
        # Functions that the loop's files share are this file's own.
        part = re.sub(
            r"^((?:void|double|bool|uint32_t) erc_\w+\()",
            r"static \1",
            _body(name),
            flags=re.MULTILINE,
        )
        code = code.replace(f"@{name.upper()}@", part)
    for key, value in _places(step).items():
        code = code.replace(f"@{key}@", value)
    # Functions and constants of the loop's files under the export's name: a build may join two exports in a file.
    functions = "|".join(re.findall(r"^static [\w ]+?(?!erc_)\b(\w+)\(", code, flags=re.MULTILINE))
    code = re.sub(rf"\b({functions})\(", r"NAME_control_\1(", code)
    constants = "|".join(re.findall(r"^#define (\w+)", code, flags=re.MULTILINE))
    code = re.sub(rf"\b({constants})\b", r"NAME_CONTROL_\1", code)

    model_code = source(step, frozenset({"exp", "tanh"}))
    if _known_at_rest(step):
        # A step that takes the effort before its limits from its caller, if the caller knows it.
        n = step.name
        given = f"{n}_state *state, const {n}_real input[{n.upper()}_INPUTS]"
        head = f"uint32_t {n}_step({given}, {n}_real *effort)\n{{\n"
        of_known = f"uint32_t {n}_step_known({given}, const {n}_real *known, {n}_real *effort)"
        before, _, rest = model_code.partition(head)
        assert rest
        body, end, after = rest.partition("\n}\n")
        body, count = re.subn(
            r"( unlimited = )(.*);",
            r"\1((known != NULL) && (row_good != 0u)) ? *known : (\2);",
            body,
        )
        assert count == 1
        own_header = f'#include "{n}.h"\n'
        before = before.replace(own_header, f"{own_header}\n#include <stddef.h>\n", 1)
        about = (
            "/* The step; where the effort before its limits is known, it is not computed again. */"
        )
        plain = f"\n{head}    return {n}_step_known(state, input, NULL, effort);"
        model_code = f"{before}{about}\nstatic {of_known}\n{{\n{body}{end}{plain}{end}{after}"

    model_header = header(step).replace(
        "#include <stdint.h>", "#include <stdbool.h>\n#include <stdint.h>", 1
    )
    before, end_of_cplusplus, after = model_header.rpartition("#ifdef __cplusplus\n}\n")
    assert end_of_cplusplus
    declared = _worded(step, _declared(step))
    return (
        f"{model_code}\n{_worded(step, code)}",
        f"{before}{declared}\n{end_of_cplusplus}{after}",
    )


# --- the loop's C in the words of the model's file -------------------------------------------------------------------


def _read(name: str) -> str:
    return (_HERE / name).read_text(encoding="utf-8")


def _body(part: str) -> str:
    """A file of the loop without its includes."""
    return re.sub(r"^#include .*\n", "", _read(f"c/erc_{part}.c"), flags=re.MULTILINE)


def _loop_code() -> str:
    """All C of the loop that the controller is made of."""
    return "".join([*map(_body, _PARTS), _read("target_c/controller.c")])


def _members() -> dict[str, str]:
    """Each setting that the controller looks at, with the line of the loop's layout that declares it."""
    used = set(re.findall(r"config(?:->|\.)(\w+)", _loop_code()))
    members = {"period_ns": "    uint64_t period_ns;"}
    for name, note in SETTINGS.items():
        if name in used:
            unit = f"[{note.unit}] " if note.unit else ""
            members[name] = f"    double {name}; /* {unit}{note.meaning} */"
    return members


def _of_kind(kind: str) -> str:
    """The controller's settings of a kind, as C."""
    names = [name for name in _members() if name in SETTINGS and SETTINGS[name].kind == kind]
    return ", ".join(f"config->{name}" for name in names)


def defaults(step: ExportedStep) -> dict[str, float]:
    """Settings to begin with: the range of the training data, and a supply that goes over it in a period."""
    period = step.period or 1e-3
    largest = step.field.range[1]
    fastest = largest_size(step.slip.range)
    band = 0.0 if step.model.band is None else step.model.band.settled
    known = {
        "period_ns": round(period * 1e9),
        "field_limit": largest,
        "rise_rate": largest / period,
        "fall_rate": largest / period,
        "torque_lead": 2.0 * period,
        "least_slip": 0.05 * fastest,
        "torque_scale": step.scale / 16.0,
        "theta_glitch": _REVERSAL * fastest,
        "alpha_glitch": _REVERSAL * fastest,
        **torque_limits(step.scale, band, period),
    }
    plain = LoopSettings()
    return {name: known.get(name, getattr(plain, name, 0.0)) for name in _members()}


def settings_of() -> dict[str, str]:
    """The settings of a controller and their types in the loop's C."""
    types = {name: line.split()[0] for name, line in _members().items()}
    types["observer"] = "uint32_t"
    return types


def _places(step: ExportedStep) -> dict[str, str]:
    """What stands in ``target_c/controller.c`` at each place that its text leaves open."""
    miss = "rest_miss" if feels_state(step) else "miss"
    signals = ["applied[0]", "theta_dot - alpha_dot"]
    if step.elements == 2:
        signals = ["applied[0]", "applied[1]", "theta_dot", "alpha_dot"]
    if step.measures:
        signals.append("torque")
    period = step.period or 1e-3
    usual = live(replace(USUAL_FILTER, cutoff=usual_cutoff(period)), period)
    constant = step.precision.constant
    known, step_call = "", "NAME_step(&core->model, sample, &core->estimate)"
    if _known_at_rest(step):
        # The step holds fields within the log's range, the inverse does not.
        largest = constant(step.field.range[1])
        same = f"core->field == core->stages.found && fabs(core->field) <= {largest}"
        is_known = f"asked && !core->stages.locked && {same}"
        known = f"const double *known = ({is_known}) ? &core->stages.gave : NULL; /* the inverse has said it */"
        step_call = "NAME_step_known(&core->model, sample, known, &core->estimate)"
    return {
        "HELD": str(step.elements),
        "REST": f"NAME_{miss}",
        "HOLD": f"{LoopSettings().hold}u",
        "TRIP": f"{LoopSettings().trip}u",
        "MEASURED": _MEASURED if step.measures else "",
        "FASTEST": constant(_FASTEST * largest_size(step.slip.range)),
        "FILTER_G": constant(usual.g),
        "FILTER_H": constant(usual.h),
        "ABOVE_ZERO": _of_kind("ABOVE_ZERO"),
        "FROM_ZERO": _of_kind("FROM_ZERO"),
        "SIGNED": _of_kind("SIGNED"),
        "MOST": constant(MOST),
        "LEAST": constant(LEAST),
        "SAMPLE": "\n    ".join(
            f"sample[{place}] = {signal};" for place, signal in enumerate(signals)
        ),
        "KNOWN": known,
        "STEP": step_call,
    }


def _known_at_rest(step: ExportedStep) -> bool:
    """Whether the model's effort is what the inverse says of a field: no memory, and zero field is in the log."""
    return not feels_state(step) and step.field.range[0] <= 0.0


def _declared(step: ExportedStep) -> str:
    """The controller's part of the header."""
    lines = list(_members().values())
    numbers: list[str] = []
    for name, value in defaults(step).items():
        is_integer = name == "period_ns"
        numbers.append(f"{int(value)}u" if is_integer else step.precision.constant(float(value)))
    struct = re.compile(
        r"/\* What (?:a device gives|the stages|is known).*?\} erc_\w+;\n", re.DOTALL
    )
    structs = struct.findall(_read("c/erc_state.h"))
    units = step.model.units
    text = _read("target_c/controller.h")
    text = text.replace("@SETTINGS@", "\n".join(lines))
    text = text.replace("@HOLD@", str(LoopSettings().hold))
    text = text.replace("@STAGES@", "\n".join(structs))
    text = text.replace("@DEFAULTS@", ", \\\n    ".join([*numbers, "NAME_BY_MODEL"]))
    text = text.replace("@UNITS@", comment(f"{units.effort or '1'} and {units.slip or '1'}"))

    code = _loop_code()
    macros: list[str] = []
    for name, meaning in EVENTS:
        macro = _macro(name)
        if f"ERC_{macro}" in code:
            macros.append(
                f"#define NAME_EVENT_{macro} ((uint32_t){EVENT_BITS[name]}u) /* {meaning} */"
            )
    for name in _NAMED:
        value = CONSTANTS[f"ERC_{name}"]
        macros.append(f"#define NAME_{name} {value}u")
    device = "SINGLE" if step.elements == 1 else "COAXIAL"
    macros.append(f"#define NAME_DEVICE NAME_{device}")
    return "\n".join(["/* --- control --- */", "", "", *macros, "", text])


def _macro(event: str) -> str:
    return event.upper().replace("-", "_")


def _worded(step: ExportedStep, text: str) -> str:
    """C of the loop with the model's number type, functions and prefix."""
    n = step.name
    suffix = step.precision.suffix
    text = re.sub(r"core->config\.device\b", "ERC_DEVICE", text)
    text = re.sub(
        r"if \(isfinite\((\w+)\)\) \{\n",
        r"if (isfinite(\1)) {\n        /*@ assert \\is_finite(\1); */\n",
        text,
    )
    text = re.sub(r"\bisfinite\(([^()]*)\)", rf"({n}_finite(\1) != 0u)", text)
    text = re.sub(r"\b(exp|tanh)\(", rf"{n}_\1(", text).replace("fabs(", f"{n}_control_size(")
    text = text.replace("@SIZE@", f"__builtin_fabs{suffix}")
    text = text.replace("erc_inverse(core, ", f"{n}_inverse(")
    if suffix:
        text = _NUMBER.sub(rf"\1{suffix}", text)
    text = re.sub(r"\bdouble\b", f"{n}_real", text)
    # Of steps only differences count: 32 bits tell them for 49 days, and 64 are dear on a small processor.
    text = re.sub(r"\buint64_t step\b", "uint32_t step", text)
    text = re.sub(r"\berc_config\b", f"{n}_settings", text)
    text = re.sub(r"\berc_core\b", f"{n}_controller", text)
    events = "|".join(map(_macro, EVENT_BITS))
    text = re.sub(rf"\bERC_({events})\b", r"NAME_EVENT_\1", text)
    text = re.sub(r"\bNAME_(?=[A-Z])", f"{n.upper()}_", text.replace("ERC_", "NAME_"))
    return re.sub(r"\bNAME_|\berc_", f"{n}_", text)


# --- test bench ------------------------------------------------------------------------------------------------------


def sample_rows(step: ExportedStep, odd: int = 24) -> Array:
    """Samples of a drive that turns while the wanted torque swings, some of them with an odd value, shape (n, 7)."""
    rng = np.random.default_rng(int(step.digest[:12], 16))
    k = np.arange(_ROWS)
    fastest = largest_size(step.slip.range)
    swing = np.where(k < _ROWS // 2, 0.3, 1.2)  # within the model's efforts, then beyond
    wanted = step.scale * np.sin(2.0 * np.pi * k / 128.0) * swing
    speed = 0.4 * fastest * (1.0 + 0.5 * np.sin(2.0 * np.pi * k / 300.0))
    output = 0.1 * fastest * np.sin(2.0 * np.pi * k / 97.0) * (step.elements == 2)
    speed[300:330] = output[300:330]  # both sides at one speed
    speed[330:400] *= -1.0
    torque = 0.9 * wanted + 0.02 * step.scale * rng.standard_normal(_ROWS)
    torque[100:120] = np.nan
    rate = np.asarray(np.gradient(wanted), np.float64) / (step.period or 1e-3)
    motor = 0.1 * step.scale * np.sign(speed)
    columns = [wanted, rate, speed, output, 0.0 * k, torque, motor]
    rows = np.array(columns, np.float64).T.copy()
    values = (np.nan, np.inf, -np.inf, 1e30, -1e30, 0.0)
    for at in rng.choice(_ROWS, odd, replace=False):
        rows[at, rng.integers(len(INPUTS))] = values[rng.integers(len(values))]
    return rows


def answers(step: ExportedStep, rows: Array, folder: Path) -> NDArray[np.uint64]:
    """Bits of each sample's outputs and its flags, by the default settings, shape (n, 4); the C lies in the folder."""
    printed = _printed(native(), folder, folder, step, rows, plain=True)
    bits: list[list[int]] = []
    for line in printed.splitlines():
        *words, flags = line.split()
        bits.append([*(int(word, 16) for word in words), int(flags)])
    return np.array(bits, np.uint64)


def _printed(
    compiler: Compiler,
    folder: Path,
    work: Path,
    step: ExportedStep,
    rows: Array,
    *,
    plain: bool = False,
    compiled: Path | None = None,
) -> str:
    """What the controller makes of the samples, by a compiler; its object of the exported file may be there already."""
    n = step.name
    bench = work / "bench.c"
    program = work / "bench"
    text = check_source(step, rows, plain=plain).replace("return bad == 0u ? 0 : 1;", "return 0;")
    bench.write_text(text, encoding="ascii")
    static = ("-static",) if compiler.runner else ()
    model = compiled or folder / f"{n}.c"
    # Every level gives the same bits, and the file is run once: the quickest level will do.
    compiler.build([bench, model], program, "-DPRINT", f"-I{folder}", "-O0", *static)
    return run(
        [*compiler.runner, str(program)],
        f"{n} compiled by {compiler.name} failed",
        "Export it again",
    )


def verify(step: ExportedStep, folder: Path) -> Iterator[Check]:
    """The model's vectors and the controller's, under every compiler and emulator of this machine."""
    compilers = (*natives(), *foreign())
    with scratch_folder() as work:
        place = Path(work)
        objects = [c.compile_model(compiler, folder, place, step, "-O2") for compiler in compilers]
        yield from c.verify_in(place, step, folder)

        check = (folder / f"{step.name}_control_check.c").read_text()
        vectors = re.search(r"answers\[.*?= \{\n(.*?)\n\};", check, re.DOTALL)
        if vectors is None:
            raise ExportError(
                "the test vectors are gone", where=str(folder), remedy="Export the model again"
            )
        expected: list[str] = []  # lines as the bench prints them
        for line in vectors[1].splitlines():
            words = [bits or flags for bits, flags in re.findall(r"0x([0-9a-f]+)|\b(\d+)u", line)]
            if words:
                expected.append(" ".join(words))
        rows = sample_rows(step)
        for compiler, compiled in zip(compilers, objects, strict=True):
            lines = _printed(compiler, folder, place, step, rows, compiled=compiled).split("\n")
            printed = lines[: len(expected)]
            other = sum(line != wanted for line, wanted in zip(printed, expected, strict=True))
            yield Check(f"controller, {compiler.name}", len(expected), other, 0.0)
