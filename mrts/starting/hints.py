# SPDX-License-Identifier: MIT
"""What was perhaps meant by a cell and a motion that do not fit."""

from collections.abc import Iterator
from itertools import combinations

import numpy as np

from mrts.base.errors import MrtsError
from mrts.base.remark import Remark
from mrts.cell.cell import Cell
from mrts.cell.remarks import FAR, LONGEST_ARM, NEAR, arm_length, base_remarks
from mrts.following.coordinate import columns_by_joint, coordinate
from mrts.motion.joint_table import JointTable
from mrts.motion.object_motion import ObjectMotion


def swapped_columns(cell: Cell, table: JointTable) -> Iterator[Remark]:
    """A hint where given joints would hold the grasps if two arms had each other's columns."""
    columns = columns_by_joint(cell, table.path, [*table.positions])
    for one, other in combinations(cell.robots, 2):
        ours, theirs = ([columns[f"{robot.name}/{joint}"] for joint in robot.joints] for robot in (one, other))
        if len(ours) != len(theirs):
            continue
        try:
            coordinate(cell, table.renamed(dict(zip(ours + theirs, theirs + ours, strict=True))))
        except MrtsError:
            continue
        yield Remark.hint(
            "swapped-columns",
            f"the joints would hold the grasps if '{one.name}' and '{other.name}' had each other's columns of "
            f"{table.path.name}: are the two swapped?",
        )
        return


def motion_units(cell: Cell, motion: ObjectMotion) -> Iterator[Remark]:
    """Remarks on lengths of a motion, or of bases beside it, that are likely in mm."""
    longest = max(arm_length(robot) for robot in cell.robots)
    if not 0 < longest <= LONGEST_ARM:
        return
    bases = max(float(np.linalg.norm(robot.T_world_base.p)) for robot in cell.robots)
    furthest = float(np.max(np.linalg.norm(motion.position, axis=1)))
    if furthest > FAR * longest + bases and furthest / 1000 < NEAR * longest + bases:
        yield Remark.hint(
            "motion-millimetres",
            f"the motion takes the object {furthest:.4g} m from the origin, no base is farther from it than "
            f"{bases:.3g} m, and the longest arm is {longest:.3g} m long: its lengths seem to be in mm.",
        )
    if not any(remark.code == "base-millimetres" for remark in cell.all_remarks):
        for robot in cell.robots:
            yield from base_remarks(robot, motion.position[0], motion.position[0], longest)
