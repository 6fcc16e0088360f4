"""The check of an exported controller in C: a tiny main that runs samples through it and compares every bit."""

from __future__ import annotations

from erclutch.export.c.c_printer import table
from erclutch.export.exported_step import ExportedStep
from erclutch.export.targets import c
from erclutch.signals.array import Array

#: What a sample holds, and what comes out, in the order of the C.
INPUTS = ("wanted", "rate", "theta_dot", "alpha_dot", "alpha", "torque", "motor_torque")
OUTPUTS = ("field1", "field2", "estimate")


def check_source(
    step: ExportedStep,
    rows: Array,
    printed: str = "",
    *,
    plain: bool = False,
) -> str:
    """A tiny main: prints bits and flags of every sample, or compares them with those that are given."""
    n = step.name
    p = step.precision
    expected = [line.split() for line in printed.splitlines()]  # bits of each output, and the flags
    if not expected:
        expected = [["0"] * (len(OUTPUTS) + 1)] * len(rows)
    lines: list[str] = []
    for *words, flags in expected:
        numbers = [f"0x{word}{p.bits_suffix}" for word in words]
        lines.append("{" + ", ".join([*numbers, f"{flags}u"]) + "}")
    answers = table(p.c_bits, "answers", lines, 1, f"[{len(OUTPUTS) + 1}]")

    # The loop over the samples: with each observer in turn, from a reset each quarter; or plain, by the defaults.
    form = "%0" + f'{p.width // 4}" PRIx{p.width} " '
    given = "\n".join(
        f"        input.{name} = number(samples[i][{place}]);" for place, name in enumerate(INPUTS)
    )
    compared = "\n".join(
        f"        good &= is_same(output.{name}, answers[i][{place}]);"
        for place, name in enumerate(OUTPUTS)
    )
    shown = ", ".join(f"bits_of(output.{name})" for name in OUTPUTS)
    every, turns, tuned = len(rows), "", ""
    if not plain:
        every = len(rows) // 4
        turns = f"settings.observer = 1u + (i / {every}u) % 3u;"
        values = {"gain_rate": "2", "integral_rate": "5", "drive_inertia": f"1 / ({n}_real)4096"}
        tuned = "\n".join(
            f"    settings.{name} = ({n}_real){value};" for name, value in values.items()
        )
    return f"""/* Checks the controller of {n} on this machine: make check. Exit code 0 if every bit is as expected.
   With PRINT defined it prints all bits instead. The samples go through it with each observer in turn. */
#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#include "{n}.h"

{c.bit_functions(step)}
{c.rows_of_bits(step, "samples", rows)}
{answers}
static int is_same({n}_real x, word expected)
{{
    return bits_of(x) == expected;
}}

int main(void)
{{
    static {n}_controller controller;
    {n}_settings settings = {n.upper()}_CONTROL_DEFAULTS;
    unsigned bad = 0u;
    unsigned i;
{tuned}
    for (i = 0u; i < {len(rows)}u; i++)
    {{
        {n}_input input;
        {n}_output output;
        uint32_t flags;
        int good;
        if (i % {every}u == 0u)
        {{
            {turns}
            (void){n}_control_reset(&controller, &settings);
        }}
{given}
        flags = {n}_control_step(&controller, &input, &output);
#ifdef PRINT
        printf("{form * len(OUTPUTS)}%" PRIu32 "\\n", {shown}, flags);
#endif
        good = flags == (uint32_t)answers[i][{len(OUTPUTS)}];
{compared}
        bad += good ? 0u : 1u;
    }}
#ifndef PRINT
    printf("{n}: %u samples through the controller, %u not to the bit\\n", {len(rows)}u, bad);
#endif
    return bad == 0u ? 0 : 1;
}}
"""
