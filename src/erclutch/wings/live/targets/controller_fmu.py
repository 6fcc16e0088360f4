"""Target controller-fmu is the exported controller as an FMU 3.0 for co-simulation; its settings are parameters."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from erclutch.export.exported_step import ExportedStep
from erclutch.export.target_check import Check
from erclutch.files import scratch_folder
from erclutch.wings.exporters.fmu.fmu_archive import write_fmu
from erclutch.wings.exporters.fmu.fmu_description import Interface, Port
from erclutch.wings.exporters.fmu.fmu_run import simulated
from erclutch.wings.live.controller_check import INPUTS, OUTPUTS
from erclutch.wings.live.layout import EVENTS
from erclutch.wings.live.targets import controller

TITLE = "torque control, interlock and model as an FMU 3.0 for co-simulation, its settings as parameters"
ALARMS = True
_MEANING = {
    "wanted": "torque that is wanted",
    "rate": "its rate of change",
    "theta_dot": "speed of the drive; of a single device the slip",
    "alpha_dot": "speed of the output; 0 of a single device",
    "alpha": "position of the output",
    "torque": "measured torque, not a number where there is none",
    "motor_torque": "torque that the drive is asked for",
}


def interface(step: ExportedStep) -> Interface:
    """The controller's variables, and what binds the FMU to its C."""
    n = step.name
    units = step.model.units
    effort = units.effort or "1"
    field = step.units[0]
    unit_of = {
        "wanted": effort,
        "torque": effort,
        "motor_torque": effort,
        "theta_dot": units.slip,
        "alpha_dot": units.slip,
    }
    inputs = [Port(name, unit_of.get(name, "?"), None, 0.0, _MEANING[name]) for name in INPUTS]
    field_range = (0.0, step.field.range[1])
    outputs = [
        Port("field1", field, field_range),
        Port("field2", field, field_range),
        Port("estimate", effort, None),
    ]
    starts = controller.defaults(step)
    settings = [name for name in controller.settings_of() if name not in ("period_ns", "observer")]
    parameters = [Port(name, "?", None, starts[name]) for name in settings]
    about = "1: the model alone, 2: a torque sensor, 3: the drive's motion"
    parameters.append(Port("observer", "1", (1.0, 3.0), 1.0, about))
    copied = "\n".join(
        f"    settings.{name} = ({n}_real)parameter[{place}];"
        for place, name in enumerate(settings)
    )
    given = "\n".join(f"    input.{name} = in[{place}];" for place, name in enumerate(INPUTS))
    taken = "\n".join(f"    out[{place}] = output.{name};" for place, name in enumerate(OUTPUTS))
    binding = f"""typedef {n}_controller erc_state;
typedef {n}_real erc_real;
#define erc_reset(state) {n}_reset(&(state)->model)

static void erc_use({n}_controller *state, const double *parameter)
{{
    const double observer = parameter[{len(settings)}];
    {n}_settings settings = {n.upper()}_CONTROL_DEFAULTS;
{copied}
    settings.observer = (observer >= 1.0 && observer < 4.0) ? (uint32_t)observer : 9u;
    (void){n}_control_reset(state, &settings);
}}

static uint32_t erc_step({n}_controller *state, const {n}_real *in, {n}_real *out)
{{
    {n}_input input;
    {n}_output output;
    uint32_t flags;
{given}
    flags = {n}_control_step(state, &input, &output);
{taken}
    return flags;
}}
"""
    flags = (2 ** (len(EVENTS) + 1) - 1, f"those of the model and the events of {n}.h")
    code = controller.texts(step)
    return Interface(
        tuple(inputs),
        tuple(outputs),
        tuple(parameters),
        "fixed",
        True,
        flags,
        code,
        binding,
    )


def write(step: ExportedStep, folder: Path) -> None:
    """NAME_fmi3.fmu.

    Raises:
        ExportError: a model that the controller cannot run, or no compiler here.
    """
    write_fmu(step, folder, 3, interface(step))


def verify(step: ExportedStep, folder: Path) -> Iterator[Check]:
    """Validate and simulate it with FMPy, against the C compiled here, bit by bit."""
    rows = controller.sample_rows(step)
    face = interface(step)
    with scratch_folder() as work:
        controller.write_core(step, Path(work))
        expected = controller.answers(step, rows, Path(work))
    for where, outputs, flags in simulated(step, face, folder, 3, ("CoSimulation",), rows):
        bits = outputs.astype(step.precision.dtype).view(step.precision.bits)
        whole_bits = bits.astype(np.uint64)
        whole_flags = flags.astype(np.uint64)
        simulated_rows = np.column_stack([whole_bits, whole_flags])
        differ = (simulated_rows != expected).any(axis=1)
        other = int(np.count_nonzero(differ))
        yield Check(where, len(rows), other, 0.0)
