# SPDX-License-Identifier: MIT
"""All that is to know of a cell, in one list."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

from mrts.base.remark import Remark
from mrts.cell.remarks.assumptions import assumptions, missing_masses
from mrts.cell.remarks.joint_sources import joint_sources
from mrts.cell.remarks.object_inertia import inertia_remarks
from mrts.cell.remarks.placeholders import effort_remarks, placeholder_efforts
from mrts.cell.remarks.unit_remarks import TORQUE_UNIT, unit_remarks
from mrts.cell.remarks.unlike_limits import unlike_limits

if TYPE_CHECKING:
    from mrts.cell.cell import Cell


def cell_remarks(cell: "Cell") -> Iterator[Remark]:
    """All that is to know of a cell: what its files and its numbers as they are now lead to."""
    joints = joint_sources(cell)
    placeholders = placeholder_efforts(cell, joints)
    units = [*unit_remarks(cell, joints, placeholders)]
    codes = {remark.code for remark in units}
    yield from cell.remarks
    yield from units
    if not codes & {"mass-grams", "inertia-unit"}:  # which make it fit
        yield from inertia_remarks(cell)
    yield from effort_remarks(placeholders)
    if TORQUE_UNIT not in codes:
        yield from unlike_limits(cell, joints)
    yield from missing_masses(joints)
    yield from assumptions(cell, joints)
