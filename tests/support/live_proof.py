r"""What Frama-C's Eva proves of the live loop: its interlock, what it believes of a sensor, the exported controller.

See docs/proof.md. Needs frama-c-base.
"""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from erclutch.export import ExportedStep
from erclutch.wings.live.controller_check import INPUTS
from erclutch.wings.live.targets import controller
from tests.support.proof import Proof, analysed, any_real, longest_loop

DRIVERS = Path(__file__).resolve().parents[1] / "wings" / "live"
LIVE = Path(__file__).resolve().parents[2] / "src" / "erclutch" / "wings" / "live" / "c"
#: Models whose controller goes through Eva.
CONTROLLED = ("bingham, single", "bingham+rise-fall, coaxial")


def proved_interlock(folder: Path) -> Proof:
    """Run Eva on the interlock of the live loop, under the configurations that the loop lets through."""
    for source in (*LIVE.glob("*.[ch]"), DRIVERS / "interlock_any.c"):
        shutil.copy(source, folder)
    options = ("-c11", "-eva-slevel", "200", "-eva-partition-history", "2")
    return analysed(folder, ["interlock_any.c", "erc_interlock.c"], *options)


def proved_plausibility(folder: Path) -> Proof:
    """Run Eva on what the live loop believes of a torque sensor, fed with any bits."""
    for source in (*LIVE.glob("*.[ch]"), DRIVERS / "plausible_any.c"):
        shutil.copy(source, folder)
    history = (
        "-eva-split-return",
        "full",
        "-eva-partition-history",
        "1",
        "-eva-interprocedural-history",
    )
    files = ["plausible_any.c", "erc_turned.c", "erc_plausible.c"]
    # At a level of 8 two alarms are left; at 15 the same is proved in twice the time.
    return analysed(folder, files, "-c11", "-eva-slevel", "11", *history)


def proved_controller(step: ExportedStep, folder: Path) -> Proof:
    """Run Eva on the exported controller with any settings and samples, and resets at any time; and on its interlock.

    The fields that leave the controller are those of its interlock, so what is shown of these holds for the controller.
    """
    controller.write_core(step, folder)
    files = {"driver.c": controller_driver(step), "limits.c": limits_driver(step)}
    for name, text in files.items():
        (folder / name).write_text(text, encoding="ascii")
    # At a level of 5 two alarms are left; at 12 the same is proved in a quarter more time.
    loops = ("-eva-slevel", "8", "-eva-auto-loop-unroll", str(max(16, longest_loop(step))))
    whole = analysed(folder, ["driver.c", f"{step.name}.c"], *loops)
    last = analysed(folder, ["limits.c"], "-eva-slevel", "200", "-eva-partition-history", "2")
    return replace(
        whole,
        alarms=whole.alarms + last.alarms,
        shown={**whole.shown, **last.shown},
        seconds=whole.seconds + last.seconds,
    )


def limits_driver(step: ExportedStep) -> str:
    """C that asks the interlock of the exported file for any bits, under settings that a reset lets through."""
    n, p = step.name, step.precision
    limit, tiny, huge = (p.constant(float(x)) for x in (step.field.range[1], *_ends(p.dtype)))
    kind = "float" if p.width == 32 else "double"
    return f"""#include "{n}.c"
#include "__fc_builtin.h"
volatile uint64_t source;
{any_real(f"{n}_real")}int main(void)
{{
    {n}_settings settings = {n.upper()}_CONTROL_DEFAULTS;
    {n}_real field = 0, ask[3], out[3];
    while (source)
    {{
        settings.period_ns = 100000u + source % 999900001u;
        settings.rise_rate = Frama_C_{kind}_interval({tiny}, {huge});
        settings.fall_rate = Frama_C_{kind}_interval({tiny}, {huge});
        settings.stroke = Frama_C_{kind}_interval(0, {huge});
        ask[0] = any_real();
        ask[1] = any_real();
        ask[2] = any_real();
        {n}_interlock(&settings, field, any_real(), any_real(), ask, out);
        /*@ check never_both: out[0] == 0 || out[1] == 0; */
        /*@ check first: \\is_finite(out[0]) && 0 <= out[0] <= {limit}; */
        /*@ check second: \\is_finite(out[1]) && 0 <= out[1] <= {limit}; */
        field = out[0] - out[1];
    }}
    return 0;
}}
"""


def _ends(dtype: np.dtype[Any]) -> tuple[float, float]:
    """The smallest number above zero with all its digits, and the largest."""
    return float(np.finfo(dtype).tiny), float(np.finfo(dtype).max)


def controller_driver(step: ExportedStep) -> str:
    """C that resets and steps the controller in a loop of unknown length."""
    n = step.name
    any_of = {"double": "any_real()", "uint64_t": "source", "uint32_t": "any()"}
    config = "".join(
        f"        settings.{name} = {any_of[kind]};\n"
        for name, kind in controller.settings_of().items()
        if name != "field_limit"
    )
    given = "".join(f"        input.{name} = any_real();\n" for name in INPUTS)
    return f"""#include "{n}.h"
volatile uint64_t source;
static uint32_t any(void) {{ return (uint32_t)source; }}
{any_real(f"{n}_real")}int main(void)
{{
    static {n}_controller controller;
    {n}_settings settings = {n.upper()}_CONTROL_DEFAULTS;
    {n}_input input;
    {n}_output out;
    (void){n}_control_reset(&controller, &settings);
    while (any())
    {{
{config}        if (any()) {{ (void){n}_control_reset(&controller, &settings); }}
{given}        (void){n}_control_step(&controller, &input, &out);
        /*@ check step: \\is_finite(out.estimate); */
        /*@ check lacking: \\is_finite(controller.stages.lacking); */
    }}
    return 0;
}}
"""
