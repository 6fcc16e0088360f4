"""Target simulink writes MATLAB functions (%#codegen), and the C step as a pure function for a C Caller block."""

from __future__ import annotations

import ctypes
import shutil
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
from erclutch.files import scratch_folder
from erclutch.wings.exporters.matlab_function import block_function, number_class, step_function

TITLE = "MATLAB functions for Simulink and MATLAB Coder, and the C step for a C Caller block with its settings"


def write(step: ExportedStep, folder: Path) -> None:
    """NAME_step.m, NAME_block.m, NAME_setup.m, the C files and NAME_caller.c and .h."""
    n = step.name
    record = step_record(step)
    c.write_core(step, folder)
    N = n.upper()
    real = step.precision.c_type
    inputs = len(step.inputs)
    size = caller_bytes(step)
    setup = f"""function {n}_setup(model)
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
    caller_header = f"""/* {n} as a pure function, for Simulink's C Caller block: the state goes in and comes out,
   through a Unit Delay whose initial condition is zeros. */
#ifndef {N}_CALLER_H
#define {N}_CALLER_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {{
#endif

void {n}_caller(const {real} input[{inputs}], const uint8_t before[{size}],
    {real} effort[1], uint32_t flags[1], uint8_t after[{size}]);

#ifdef __cplusplus
}}
#endif

#endif
"""
    caller_source = f"""#include "{n}_caller.h"

#include <string.h>

#include "{n}.h"

/* Fails to compile if the state does not fit. */
typedef char {n}_fits[(sizeof({n}_state) <= {size}u) ? 1 : -1];

void {n}_caller(const {real} input[{inputs}], const uint8_t before[{size}],
    {real} effort[1], uint32_t flags[1], uint8_t after[{size}])
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
    texts = {
        f"{n}_step.m": step_function(step, record),
        f"{n}_block.m": block_function(step, record),
        f"{n}_setup.m": setup,
        f"{n}_caller.h": caller_header,
        f"{n}_caller.c": caller_source,
    }
    for name, text in texts.items():
        (folder / name).write_text(text, encoding="ascii")


def caller_bytes(step: ExportedStep) -> int:
    """Bytes of state that the block carries: no compiler pads more than this."""
    return (state_bytes(step) + 15) // 8 * 8


# --- verify ----------------------------------------------------------------------------------------------------------


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


def verify(step: ExportedStep, folder: Path) -> Iterator[Check]:
    """The MATLAB function in GNU Octave, the caller's function compiled.

    Raises:
        ExportError: neither Octave nor a C compiler is found.
    """
    octave = shutil.which("octave-cli") or shutil.which("octave")
    compiler_there = bool(natives())
    if octave is None and not compiler_there:
        raise ExportError(
            "neither Octave nor a C compiler is found",
            where=str(folder),
            remedy="Install one: apt install octave",
        )
    n = step.name
    vectors = vectors_of(step)
    rows = np.ascontiguousarray(vectors.rows)

    # The step row by row in GNU Octave, and the block beside it.
    if octave is not None:
        script = _SCRIPT.format(
            kind=number_class(step),
            inputs=len(step.inputs),
            state=step_record(step).size,
            name=n,
        )
        with scratch_folder() as work:
            place = Path(work)
            rows.tofile(place / "rows.bin")
            head = f"cd({matlab_string(work)}); folder = {matlab_string(str(folder.resolve()))};"
            check = place / "check.m"
            check.write_text(f"1;\n{head}\n{script}", encoding="utf-8")
            words = [octave, "--no-gui", "--norc", "--quiet", str(check)]
            run(words, f"{n}_step.m does not run", "Export the model again")
            of_octave, octave_flags = np.fromfile(place / "out.bin").reshape(2, -1)
        yield near(step, vectors, "GNU Octave", of_octave, octave_flags.astype(np.uint32))

    # The C Caller's function, state going round as in the block.
    if compiler_there:
        with scratch_folder() as work:
            library = Path(work) / "caller.so"
            files = [folder / f"{n}_caller.c", folder / f"{n}.c"]
            native().build(files, library, "-O2", *shared_flags(library))
            function = getattr(ctypes.CDLL(str(library)), f"{n}_caller")
        function.restype = None
        effort: NDArray[Any] = np.zeros(len(rows), step.precision.dtype)
        flags = np.zeros(len(rows), np.uint32)
        before = np.zeros(caller_bytes(step), np.uint8)
        after = np.zeros_like(before)
        for k, row in enumerate(rows):
            arrays = (row, before, effort[k : k + 1], flags[k : k + 1], after)
            function(*(ctypes.c_void_p(array.ctypes.data) for array in arrays))
            before, after = after, before
        yield to_the_bit(step, vectors, f"C Caller function, {native().name}", effort, flags)
