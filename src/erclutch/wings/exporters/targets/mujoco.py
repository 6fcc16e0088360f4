"""Target mujoco makes the compiled step a user actuator of MuJoCo (Python), with an example model."""

from __future__ import annotations

import sys
from collections.abc import Generator, Iterator
from contextlib import contextmanager
from importlib import import_module, invalidate_caches, resources
from pathlib import Path
from types import ModuleType

import numpy as np

from erclutch._version import __version__
from erclutch.errors import ExportError
from erclutch.export.encode import comment
from erclutch.export.exported_step import ExportedStep
from erclutch.export.step_numbers import reference, run
from erclutch.export.step_record import has_memory
from erclutch.export.step_vectors import vectors_of
from erclutch.export.target_check import Check, ulps
from erclutch.export.targets import python
from erclutch.signals.array import largest_size

TITLE = "the compiled step as a user actuator of MuJoCo, with an example model"
#: MuJoCo takes larger numbers for a failed simulation.
_LARGEST = 1e8
_SIMULATED = 100  # steps of the example


def write(step: ExportedStep, folder: Path) -> None:
    """The Python target's files, NAME_mujoco.py and the example NAME.xml."""
    n = step.name
    python.write(step, folder)
    actuator = resources.files("erclutch.wings.exporters") / "mujoco_actuator.py"
    code = actuator.read_text(encoding="utf-8")
    speeds = step.filter is None
    tail = f'''

def {n}(model: Any, effort: str = "effort", **names: Any) -> Actuator:
    """{comment(step.model.name)} as actuator `effort` of a model; see `Actuator` for the names."""
    from {n} import load

    defaults: dict[str, Any] = {{
        "fields": {_fields(step)!r},
        "joints": {_joints(step)!r},
        "positions": {not speeds},
        "further": {len(step.extras)},
        "period": {step.period if has_memory(step) else None!r},
    }}
    return Actuator(load, model, effort, **{{**defaults, **names}})
'''
    (folder / f"{n}_mujoco.py").write_text(code.rstrip() + "\n" + tail, encoding="utf-8")
    (folder / f"{n}.xml").write_text(example_model(step), encoding="utf-8")


def _fields(step: ExportedStep) -> tuple[str, ...]:
    return ("E1", "E2") if step.elements == 2 else ("field",)


def _joints(step: ExportedStep) -> tuple[str, ...]:
    return ("theta", "alpha") if step.elements == 2 else ("slip",)


def _control_range(step: ExportedStep) -> tuple[float, float]:
    """Range of the field; MuJoCo wants some width, also of a model with one field."""
    low, high = step.field.range
    if low < high:
        return (low, high)
    return (low, max(step.search.plus, step.search.origin))


def example_model(step: ExportedStep) -> str:
    """A model of MuJoCo in which the actuator moves a joint, as XML."""
    pair = step.elements == 2
    arm = _joints(step)[-1]
    low, high = _control_range(step)
    actuators = "\n".join(
        f'    <general name="{name}" joint="{arm}" gainprm="0" biastype="none" '
        f'ctrllimited="true" ctrlrange="{low:.9g} {high:.9g}"/>'
        for name in _fields(step)
    )
    gear = 1 if pair else -1  # a single element brakes its slip; a pair drives its output
    period = step.period or 1e-3
    largest = largest_size(step.model.trained_on.effort) or 1.0
    # An arm that the largest effort accelerates by 100 rad/s^2 or m/s^2.
    inertia = f"{largest / 100.0:.6g}"
    slides = not pair and (step.model.units.slip == "m/s" or step.model.units.effort == "N")
    if slides:
        joint = 'type="slide" axis="1 0 0"'
        mass, turning = inertia, "1"
    else:
        joint = 'type="hinge" axis="0 0 1"'
        mass, turning = "1", inertia
    inertial = f'<inertial pos="0 0 0" mass="{mass}" diaginertia="{turning} {turning} {turning}"/>'
    drive = motor = ""
    if pair:
        drive = f"""    <body name="drive">
      <joint name="theta" type="hinge" axis="0 0 1" damping="{largest:.6g}"/>
      {inertial}
      <geom type="cylinder" size="0.03 0.01" contype="0" conaffinity="0" mass="0"/>
    </body>
"""
        motor = f'    <velocity name="motor" joint="theta" kv="{10 * largest:.6g}"/>\n'
    return f"""<!-- {step.headline} as an actuator; written by erclutch {__version__}.
     The ctrl of {" and ".join(_fields(step))} is the field; the force of "effort" comes from
     {step.name}_mujoco.py.
     Units are those of the model: joints in {"m and m/s" if slides else "rad and rad/s"} where it was trained so. -->
<mujoco model="{step.name}">
  <option timestep="{period:.9g}" gravity="0 0 0" integrator="implicitfast"/>
  <worldbody>
{drive}    <body name="arm">
      <joint name="{arm}" {joint}/>
      {inertial}
      <geom type="capsule" fromto="0 0 0 0.2 0 0" size="0.01" contype="0" conaffinity="0" mass="0"/>
    </body>
  </worldbody>
  <actuator>
{motor}{actuators}
    <general name="effort" joint="{arm}" gear="{gear}" gainprm="0" biastype="user"/>
  </actuator>
</mujoco>
"""


# --- verify ----------------------------------------------------------------------------------------------------------


def verify(step: ExportedStep, folder: Path) -> Iterator[Check]:
    """The actuator's force in the example model at the rows of the test vectors, and a hundred steps of simulation.

    Raises:
        ExportError: MuJoCo is not installed, or the simulation fails.
    """
    try:
        import mujoco
    except ImportError as error:
        raise ExportError("mujoco is not installed", remedy="Run: pip install mujoco") from error
    model = mujoco.MjModel.from_xml_path(str(folder / f"{step.name}.xml"))
    rows = vectors_of(step).rows
    held = np.where(np.isfinite(rows), rows, np.inf)
    sizes = np.abs(held)
    rows = rows[np.all(sizes < _LARGEST, axis=1)]
    expected, expected_flags = run(step, rows)
    forces = np.zeros(len(rows))
    flags = np.zeros(len(rows), np.uint32)
    with _imported(step, folder) as module:
        # The actuator's force at each row, set by hand, and its flags.
        data = mujoco.MjData(model)
        elements = step.elements
        effort = model.actuator("effort").id
        with getattr(module, step.name)(model) as actuator:
            for k, row in enumerate(rows.astype(np.float64)):
                data.time = k * (step.period or model.opt.timestep)
                for name, field in zip(_fields(step), row[:elements], strict=True):
                    data.ctrl[model.actuator(name).id] = field
                for name, motion in zip(_joints(step), row[elements:], strict=False):
                    joint = data.joint(name)
                    motions = joint.qvel if step.filter is None else joint.qpos
                    motions[0] = motion
                actuator.further[:] = list(row[2 * elements :])
                mujoco.mj_fwdPosition(model, data)
                mujoco.mj_fwdVelocity(model, data)
                mujoco.mj_fwdActuation(model, data)
                forces[k] = data.actuator_force[effort]
                flags[k] = actuator.flags

        # A hundred steps of the example at half the field and half the speed.
        data = mujoco.MjData(model)
        low, high = _control_range(step)
        speed = 0.5 * step.slip.range[1]
        with getattr(module, step.name)(model) as actuator:
            first_field = model.actuator(_fields(step)[0])
            data.ctrl[first_field.id] = 0.5 * (low + high)
            if step.elements == 2:
                data.ctrl[model.actuator("motor").id] = speed
            else:
                data.joint("slip").qvel[0] = speed
            for _ in range(_SIMULATED):
                mujoco.mj_step(model, data)
            samples = actuator.samples
    motion = np.concatenate([data.qpos, data.qvel])
    if not np.all(np.isfinite(motion)):
        raise ExportError("the simulation of the example fails", remedy="Export the model again")
    arm_speed = float(data.joint(_joints(step)[-1]).qvel[0])

    other = (forces.astype(step.precision.dtype) != expected) | (flags != expected_flags)
    exact, _ = reference(step, rows)
    largest = largest_size(forces - exact)
    yield Check(
        f"MuJoCo {mujoco.__version__}",
        len(rows),
        int(np.count_nonzero(other)),
        ulps(step, largest),
        note=f"{_SIMULATED} steps of the example: {samples} samples, arm at {arm_speed:.3g}",
    )


@contextmanager
def _imported(step: ExportedStep, folder: Path) -> Generator[ModuleType]:
    """NAME_mujoco.py, which imports NAME.py beside it; both are forgotten again: another export may have the name."""
    wrapper = f"{step.name}_mujoco"
    names = (step.name, wrapper)
    kept = {name: sys.modules.pop(name) for name in names if name in sys.modules}
    wrote_no_bytecode = sys.dont_write_bytecode
    sys.dont_write_bytecode = True
    place = str(folder.resolve())
    sys.path.insert(0, place)
    try:
        invalidate_caches()
        yield import_module(wrapper)
    finally:
        sys.path.remove(place)
        sys.dont_write_bytecode = wrote_no_bytecode
        for name in names:
            sys.modules.pop(name, None)
        sys.modules.update(kept)
