"""A log of a robot holds several joints: each is a device, and is read by its own mapping."""

from __future__ import annotations

from erclutch.logs.mapping import ColumnMap
from erclutch.logs.plan import Joint, Plan
from erclutch.logs.planning.whole_plan import plan_of
from erclutch.logs.table import Table
from erclutch.signals.recording import NO_FIELD


def mapping_of_joint(plan: Plan, joint: Joint, told: ColumnMap) -> ColumnMap:
    """What a user would say of a log to read one of its joints.

    Args:
        plan: of the log.
        joint: one of the plan's.
        told: what the user said of the log.
    """
    columns = {"slip": joint.slip, "effort": joint.effort}
    labels = {signal: plan.labels.get(column, column) for signal, column in columns.items()}
    field = plan.signal("field")
    # With one joint given, the columns of the others may be the field again.
    if field is not None and field.reason == NO_FIELD:
        labels["field"] = "none"
    return ColumnMap.from_options(labels).over(told)


def plans_of_joints(plan: Plan, table: Table) -> dict[Joint, Plan]:
    """How each joint of a log is read; none where more is open than which joint is meant.

    Args:
        plan: of the log.
        table: that the plan is for.
    """
    if not plan.leaves_open_which_joint:
        return {}
    plans: dict[Joint, Plan] = {}
    for joint in plan.joints:
        told = mapping_of_joint(plan, joint, plan.told)
        plans[joint] = plan_of(table, told, device=plan.device, invalid=plan.invalid)
    more_is_open = any(each.questions or each.doubts for each in plans.values())
    return {} if more_is_open else plans
