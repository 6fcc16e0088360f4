"""Each joint of a robot is a device: the logs of the robot are read once for each of its joints."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from erclutch.errors import MappingError, placed
from erclutch.logs import ColumnMap, plan_of, table_of_log
from erclutch.logs.joints_of_log import mapping_of_joint
from erclutch.logs.mapping import file_mapping, map_over
from erclutch.logs.reading import Reading
from erclutch.signals.device import DeviceName


@dataclass(frozen=True)
class JointLogs:
    """The logs of one joint.

    Attributes:
        paths: of the logs, in order.
        mapping: what is said of each of them so that this joint is read.
    """

    paths: tuple[str, ...]
    mapping: ColumnMap


def logs_of_joints(
    files: Sequence[Path], reading: Reading, device: DeviceName
) -> dict[str, JointLogs]:
    """The logs of each joint by its name, in the order of the joints in the first log.

    Args:
        files: logs of one robot, or of robots with the same columns.
        reading: what the user said of them.
        device: see `erclutch.wings.fleet.fleet.fit_many`.

    Raises:
        MappingError: a log has no joints, or more is open than which joint is meant.
        LogError: a log cannot be read.
    """
    mappings: dict[str, ColumnMap] = {}
    paths: dict[str, list[str]] = {}
    for file in files:
        given = map_over(reading.mapping, None)
        told = given.over(file_mapping(file, reading.mapping_file))
        table = table_of_log(file, told, device, reading.variable or told.variable)
        plan = plan_of(table, told, device=device, invalid=reading.invalid)
        if not plan.leaves_open_which_joint:
            with placed(file.name):
                plan.require_answers()
            # A doubt about more than the joint is told as it is.
            if plan.joints:
                plan.require_sureness()
            remedy = f"Look at it with erclutch inspect {shlex.quote(str(file))}, or leave --by joint out"
            raise MappingError("no joints are told apart in it", where=file.name, remedy=remedy)
        for joint in plan.joints:
            mapping = mapping_of_joint(plan, joint, given)
            if mappings.setdefault(joint.name, mapping) != mapping:
                problem = (
                    f"{joint.name} has other columns than in {Path(paths[joint.name][0]).name}"
                )
                remedy = "Fit these logs by themselves"
                raise MappingError(problem, where=file.name, remedy=remedy)
            paths.setdefault(joint.name, []).append(str(file))
    return {name: JointLogs(tuple(paths[name]), mappings[name]) for name in paths}
