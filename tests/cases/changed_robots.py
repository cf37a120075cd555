"""Cells with other numbers of all their robots, or of the first."""

from dataclasses import replace


def with_robots(cell, **changes):
    """The cell with these fields of every robot."""
    return replace(cell, robots=tuple(replace(robot, **changes) for robot in cell.robots))


def with_left(cell, **changes):
    """The cell with these fields of its first robot."""
    left, *others = cell.robots
    return replace(cell, robots=(replace(left, **changes), *others))
