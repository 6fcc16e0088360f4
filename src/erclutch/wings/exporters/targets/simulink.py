"""Target simulink writes MATLAB functions (%#codegen), and the C step as a pure function for a C Caller block."""

from __future__ import annotations

import ctypes
import shutil
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from erclutch.errors import ExportError
from erclutch.export.c.compilers import native, natives, run, shared_flags
from erclutch.export.cost import state_bytes
from erclutch.export.encode import matlab_string
from erclutch.export.exported_step import ExportedStep
from erclutch.export.step_record import step_record
from erclutch.export.step_vectors import vectors_of
from erclutch.export.target_check import Check, near, to_the_bit
from erclutch.export.targets import c
from erclutch.wings.exporters.matlab_function import block_function, step_function

TITLE = "MATLAB functions for Simulink and MATLAB Coder, and the C step for a C Caller block with its settings"


def write(step: ExportedStep, folder: Path) -> None:
    """NAME_step.m, NAME_block.m, NAME_setup.m, the C files and NAME_caller.c and .h."""
    n, record = step.name, step_record(step)
    c.write_core(step, folder)
    texts = {
        f"{n}_step.m": step_function(step, record),
        f"{n}_block.m": block_function(step, record),
        f"{n}_setup.m": _setup(step),
        f"{n}_caller.h": _caller_header(step),
        f"{n}_caller.c": _caller_source(step),
    }
    for name, text in texts.items():
        (folder / name).write_text(text, encoding="ascii")


def caller_bytes(step: ExportedStep) -> int:
    """Bytes of state that the block carries: no compiler pads more than this."""
    return (state_bytes(step) + 15) // 8 * 8


def _caller_header(step: ExportedStep) -> str:
    n, N, p = step.name, step.name.upper(), step.precision
    return f"""/* {n} as a pure function, for Simulink's C Caller block: the state goes in and comes out,
   through a Unit Delay whose initial condition is zeros. */
#ifndef {N}_CALLER_H
#define {N}_CALLER_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {{
#endif

void {n}_caller(const {p.c_type} input[{len(step.inputs)}], const uint8_t before[{caller_bytes(step)}],
    {p.c_type} effort[1], uint32_t flags[1], uint8_t after[{caller_bytes(step)}]);

#ifdef __cplusplus
}}
#endif

#endif
"""


def _caller_source(step: ExportedStep) -> str:
    n, p, size = step.name, step.precision, caller_bytes(step)
    return f"""#include "{n}_caller.h"

#include <string.h>

#include "{n}.h"

/* Fails to compile if the state does not fit. */
typedef char {n}_fits[(sizeof({n}_state) <= {size}u) ? 1 : -1];

void {n}_caller(const {p.c_type} input[{len(step.inputs)}], const uint8_t before[{size}],
    {p.c_type} effort[1], uint32_t flags[1], uint8_t after[{size}])
{{
    {n}_state state;
    memcpy(&state, before, sizeof state);
    if (state.exact == 0u) /* zeros: the first step */
    {{
        (void){n}_reset(&state);
    }}
    flags[0] = {n}_step(&state, input, &effort[0]);
    memset(after, 0, {size}u);
    memcpy(after, &state, sizeof state);
}}
"""


def _setup(step: ExportedStep) -> str:
    n, size = step.name, caller_bytes(step)
    return f"""function {n}_setup(model)
%{n.upper()}_SETUP Settings of a Simulink model for {n}, and a C Caller block with the delay that carries its state.
%   {n.upper()}_SETUP(MODEL) with the name of an open model. Simulink R2018b or newer.
    here = fileparts(mfilename('fullpath'));
    set_param(model, 'SimCustomHeaderCode', '#include "{n}_caller.h"');
    set_param(model, 'SimUserIncludeDirs', ['"' here '"']);
    set_param(model, 'SimUserSources', sprintf('"%s"\\n"%s"', fullfile(here, '{n}_caller.c'), fullfile(here, '{n}.c')));
    set_param(model, 'SimParseCustomCode', 'on');
    % Generated code takes the same files.
    set_param(model, 'RTWUseSimCustomCode', 'on');
    caller = [model '/{n}'];
    add_block('simulink/User-Defined Functions/C Caller', caller);
    set_param(caller, 'FunctionName', '{n}_caller');
    ports = get_param(caller, 'FunctionPortSpecification');
    sizes = {{'{len(step.inputs)}', '{size}', '1', '1', '{size}'}};
    scopes = {{'Input', 'Input', 'Output', 'Output', 'Output'}};
    for i = 1:numel(scopes)
        ports.InputArguments(i).Scope = scopes{{i}};
        ports.InputArguments(i).Size = sizes{{i}};
    end
    delay = [model '/{n} state'];
    add_block('simulink/Discrete/Unit Delay', delay);
    set_param(delay, 'InitialCondition', 'zeros({size}, 1, ''uint8'')', 'SampleTime', '{step.period or -1!r}');
    add_line(model, '{n}/3', '{n} state/1', 'autorouting', 'on');
    add_line(model, '{n} state/1', '{n}/2', 'autorouting', 'on');
end
"""


# --- verify ----------------------------------------------------------------------------------------------------------


def verify(step: ExportedStep, folder: Path) -> Iterator[Check]:
    """The MATLAB function in GNU Octave, the caller's function compiled.

    Raises:
        ExportError: neither Octave nor a C compiler is found.
    """
    octave = shutil.which("octave-cli") or shutil.which("octave")
    if octave is None and not natives():
        raise ExportError(
            "neither Octave nor a C compiler is found", where=str(folder), remedy="Install one: apt install octave"
        )
    if octave is not None:
        yield _in_octave(step, folder, octave)
    if natives():
        yield _called(step, folder)


_SCRIPT = """
addpath(folder);
kind = '{kind}';
file = fopen('rows.bin'); rows = fread(file, [{inputs}, Inf], ['*' kind]); fclose(file);
state = zeros({state}, 1, kind);
count = columns(rows);
effort = zeros(count, 1); flags = zeros(count, 1);
for k = 1:count
    [effort(k), flags(k), state] = {name}_step(rows(:, k), state);
end
clear {name}_block
again = zeros(count, 1);
for k = 1:count
    again(k) = {name}_block(rows(:, k));
end
if ~isequal(again, effort), error('the block does not give what the step gives'); end
file = fopen('out.bin', 'w'); fwrite(file, [effort; flags], 'double'); fclose(file);
"""


def _in_octave(step: ExportedStep, folder: Path, octave: str) -> Check:
    vectors, record = vectors_of(step), step_record(step)
    values = {"kind": "single" if step.precision.width == 32 else "double", "inputs": len(step.inputs)}
    text = _SCRIPT.format(**values, state=record.size, name=step.name)
    with tempfile.TemporaryDirectory() as work:
        place = Path(work)
        np.ascontiguousarray(vectors.rows).tofile(place / "rows.bin")
        moved = f"cd({matlab_string(work)}); folder = {matlab_string(str(folder.resolve()))};"
        (place / "check.m").write_text(f"1;\n{moved}\n{text}", encoding="utf-8")
        words = [octave, "--no-gui", "--norc", "--quiet", str(place / "check.m")]
        run(words, f"{step.name}_step.m does not run", "Export the model again")
        found = np.fromfile(place / "out.bin").reshape(2, -1)
    return near(step, vectors, "GNU Octave", found[0], found[1].astype(np.uint32))


def _called(step: ExportedStep, folder: Path) -> Check:
    """The C Caller's function, state going round as in the block."""
    vectors, n, p = vectors_of(step), step.name, step.precision
    with tempfile.TemporaryDirectory() as work:
        library = Path(work) / "caller.so"
        files = [folder / f"{n}_caller.c", folder / f"{n}.c"]
        native().build(files, library, "-O2", *shared_flags(library))
        function = getattr(ctypes.CDLL(str(library)), f"{n}_caller")
    function.restype = None
    effort: NDArray[Any] = np.zeros(len(vectors.rows), p.dtype)
    flags = np.zeros(len(vectors.rows), np.uint32)
    states = np.zeros((2, caller_bytes(step)), np.uint8)
    rows = np.ascontiguousarray(vectors.rows)
    for k in range(len(rows)):
        arrays = (rows[k], states[k % 2], effort[k : k + 1], flags[k : k + 1], states[1 - k % 2])
        function(*(ctypes.c_void_p(a.ctypes.data) for a in arrays))
    return to_the_bit(step, vectors, f"C Caller function, {native().name}", effort, flags)
