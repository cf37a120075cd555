# SPDX-License-Identifier: MIT
"""What the hands can exert on the object."""

import numpy as np

from mrts.cell.cell import Cell
from mrts.cell.hands.contact import in_object_axes
from mrts.following.coordinated_motion import CoordinatedMotion
from mrts.limits.object_axes import object_axes
from mrts.limits.rows import LimitRows, RowName


def contact_limits(cell: Cell, motion: CoordinatedMotion) -> LimitRows:
    """Rows lower <= A F_i <= upper of every contact of every robot, in base axes or in those that turn with the object.

    Args:
        cell: The cell.
        motion: Its motion.
    """
    contacts = [(robot, contact) for robot in cell.robots for contact in robot.contacts]
    names = tuple(
        RowName("contact", robot.name, f"{contact.name} {row}", unit)
        for robot, contact in contacts
        for row, unit in zip(contact.rows, contact.units, strict=True)
    )
    in_base, in_object = np.zeros((2, len(names), len(cell.robots) * len(cell.wrench_components)))
    start = 0
    for robot, contact in contacts:
        stop, columns = start + len(contact.rows), cell.wrench_slices[robot.name]
        if contact.frame == "base":
            in_base[start:stop, columns] = contact.A
        elif contact.frame == "object":
            in_object[start:stop, columns] = contact.A
        else:
            in_object[start:stop, columns] = in_object_axes(contact.A, robot.T_object_tip.R, cell.wrench_components)
        start = stop
    turns = bool(np.any(in_object))
    return LimitRows(
        names=names,
        lower=np.concatenate([np.zeros(0), *(contact.lower for _, contact in contacts)]),
        upper=np.concatenate([np.zeros(0), *(contact.upper for _, contact in contacts)]),
        torque_matrix=np.zeros((len(names), motion.q.shape[1])),
        wrench_matrix=in_base,
        object_matrix=in_object if turns else None,
        object_axes=object_axes(cell, motion) if turns else None,
    )
