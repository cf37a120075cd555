# SPDX-License-Identifier: MIT
"""Small changes to the numbers of a cell, one at a time: each limit, the mass, where arms stand, where they grasp."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import degrees, pi
from typing import Any, Literal

import numpy as np

from mrts.base.formats.record import Record
from mrts.base.rigid_transform import RigidTransform, multiply, rotation_from_rpy
from mrts.cell.cell import Cell
from mrts.cell.points import PointLimit
from mrts.cell.robot import Robot

AXES = "xyz"

POSES: tuple[Literal["base", "grasp"], ...] = ("base", "grasp")

ChangeKind = Literal[
    "torque", "wrench", "contact", "velocity", "acceleration", "motor speed", "reserve", "mass", "base", "grasp"
]
"""What a change is of: a limit, the reserve that is kept of all of them, the mass, or a pose."""

Changed = tuple[ChangeKind, str, str]
"""Kind, robot and element of what is changed."""

Keys = tuple[Any, ...]
"""Attributes, places in tuples and at last what an array is indexed by, from a cell inward."""

SHARE = 0.1
"""By which limits, mass and reserve are changed, of them."""

SHIFT, TURN = 0.01, pi / 180
"""By which bases and grasps are changed, along an axis [m] and about one [rad]."""


@dataclass(frozen=True, kw_only=True)
class CellChange:
    """One number of a cell changed.

    Attributes:
        kind: What is changed.
        robot: Name of the arm; "object" of its own velocities, empty of mass and reserve.
        element: Joint, wrench component, contact, "linear" or "angular"; of a pose "x" along that axis, "about x"
            around it, world axes of a base and object axes of a grasp; else empty.
        step: By how much: a share of the limit, of the mass or of the reserve, or [m] and [rad] of a pose.
    """

    kind: ChangeKind
    robot: str = ""
    element: str = ""
    step: float

    def __str__(self) -> str:
        return f"{self.what} {self.size}"

    @property
    def what(self) -> str:
        """What is changed: `right/elbow` for its torque limits, `left/fx`, `mass`, `left base about z`."""
        if self.kind in POSES:
            return f"{self.robot} {self.kind} {self.element}"
        if not self.robot:
            return self.kind
        spoken = "" if self.kind in {"torque", "wrench", "contact"} else f" {self.kind}"
        return f"{self.robot}/{self.element}{spoken}"

    @property
    def size(self) -> str:
        """By how much, in words: `+10 %`, `-10 mm`, `+1°`."""
        if self.unit == "m":
            return f"{1000 * self.step:+.4g} mm"
        return f"{degrees(self.step):+.4g}°" if self.unit == "rad" else f"{100 * self.step:+.4g} %"

    @property
    def unit(self) -> str:
        """Of the step: "m" or "rad" of a pose, "1" of a share."""
        if self.kind not in POSES:
            return "1"
        return "rad" if self.element.startswith("about") else "m"

    @property
    def moves_arms(self) -> bool:
        """Whether the arms must follow the object anew."""
        return self.kind in POSES

    def applied(self, cell: Cell) -> Cell:
        """The cell with this change; both sides of a limit move outward by a positive step, a side of 0 stays.

        Raises:
            InputError: If the changed number breaks a rule of the cell.
        """
        if self.kind == "mass":
            return cell.with_mass(cell.mass * (1 + self.step))
        if self.kind in POSES:
            robot = next(robot for robot in cell.robots if robot.name == self.robot)
            if self.kind == "base":
                return with_machine_at(cell, self.robot, self._moved(robot.T_world_base))
            return cell.with_values({f"robots.{self.robot}.grasp": self._moved(robot.T_object_tip)})
        places = [("reserve",)] if self.kind == "reserve" else limit_places(cell)[self.kind, self.robot, self.element]
        for keys in places if self.step > 0 else reversed(places):
            cell = _outward(cell, keys, self.step)
        return cell

    def _moved(self, pose: RigidTransform) -> RigidTransform:
        step = np.array([self.step if self.element[-1] == axis else 0.0 for axis in AXES])
        if self.unit == "m":
            return RigidTransform(pose.R, pose.p + step)
        return RigidTransform(multiply(rotation_from_rpy(*step), pose.R), pose.p)


def cell_changes(cell: Cell) -> tuple[CellChange, ...]:
    """All changes of a cell, each up and down: its limits, in the order of its rows, mass and reserve, and its poses.

    Sides of a limit move together. A joint with a torque-speed curve has its torques changed with the limit, as by
    another motor, and the curve's speeds by themselves. A component that is held at one number is no limit. Arms of one
    machine move with the base of the first of them.
    """
    named: list[Changed] = [*limit_places(cell), ("mass", "", "")]
    if cell.reserve:
        named.append(("reserve", "", ""))
    shares = [(entry, SHARE) for entry in named]
    along, around = free_axes(cell)
    for kind in POSES:
        for robot in cell.robots:
            if kind == "base" and machine_of(cell, robot.name)[0] != robot.name:
                continue
            shares += [((kind, robot.name, axis), SHIFT) for axis in along]
            shares += [((kind, robot.name, f"about {axis}"), TURN) for axis in around]
    return tuple(
        CellChange(kind=kind, robot=robot, element=element, step=sign * step)
        for (kind, robot, element), step in shares
        for sign in (1, -1)
    )


def limit_places(cell: Cell) -> dict[Changed, list[Keys]]:
    """Where the numbers of every limit that bounds something stand among the attributes of a cell, by what it is.

    They are written one after the other as the limit grows, and backwards as it shrinks: a torque limit lies within the
    motor's curve all the while.
    """
    found, arms = dict[Changed, list[Keys]](), [(("robots", at), robot) for at, robot in enumerate(cell.robots)]
    for kind in ("torque", "wrench"):
        for place, robot in arms:
            elements = robot.joints if kind == "torque" else cell.wrench_components
            found |= _bounded(kind, robot.name, elements, robot, place, f"{kind}_lower", f"{kind}_upper")
    for place, robot in arms:
        for at, contact in enumerate(robot.contacts):
            free, where = contact.lower < contact.upper, (*place, "contacts", at)
            found["contact", robot.name, contact.name] = [(*where, "lower", free), (*where, "upper", free)]
    for at, thing in enumerate(cell.carried):
        numbers: list[Keys] = [("friction",)] if thing.friction is not None else []
        numbers += [("half_width", side) for side in range(len(thing.half_width or ()))]
        found["contact", "object", thing.name or ""] = [("carried", at, *keys) for keys in numbers]
    if cell.enforces_velocity_limits:
        found |= _motion_limits(cell, arms, "velocity", "speed", "velocity_limit")
    found |= _motion_limits(cell, arms, "acceleration", "acceleration", "acceleration_lower", "acceleration_upper")
    for place, robot in arms:
        for at, (joint, curve) in enumerate(zip(robot.joints, robot.motors.torque_speed, strict=True)):
            if curve is not None:  # of another motor it changes with the torque limit
                corners = (*place, "motors", "torque_speed", at)
                found.get(("torque", robot.name, joint), []).insert(0, (*corners, np.s_[:, 1]))
                found["motor speed", robot.name, joint] = [(*corners, np.s_[:, 0])]
    return found


def _motion_limits(
    cell: Cell, arms: Sequence[tuple[Keys, Robot]], kind: ChangeKind, of_point: str, *sides: str
) -> dict[Changed, list[Keys]]:
    found: dict[Changed, list[Keys]] = {}
    for place, robot in arms:
        found |= _bounded(kind, robot.name, robot.joints, robot, place, *sides)
        found |= _points(kind, robot.name, robot.point_limits, (*place, "point_limits"), of_point)
    found |= _bounded(kind, "object", ("linear", "angular"), cell, (), f"object_{kind}_limit")
    return found | _points(kind, "object", cell.object_points, ("object_points",), of_point)


def _points(
    kind: ChangeKind, owner: str, points: Sequence[PointLimit], place: Keys, key: str
) -> dict[Changed, list[Keys]]:
    limited = ((at, point) for at, point in enumerate(points) if getattr(point, key) is not None)
    return {(kind, owner, point.name or ""): [(*place, at, key)] for at, point in limited}


def _bounded(
    kind: ChangeKind, name: str, elements: Sequence[str], owner: Robot | Cell, place: Keys, *sides: str
) -> dict[Changed, list[Keys]]:
    """Elements with a limit on some side, unless they are held at one number; a single side holds both ways."""
    upper = getattr(owner, sides[-1])
    lower = getattr(owner, sides[0]) if len(sides) > 1 else -upper
    limited = np.flatnonzero((lower < upper) & (np.isfinite(lower) | np.isfinite(upper))).tolist()
    return {(kind, name, elements[at]): [(*place, side, at) for side in sides] for at in limited}


def free_axes(cell: Cell) -> tuple[str, str]:
    """Axes along which, and about which poses of a cell may move: two and one in a plane."""
    if cell.plane is None:
        return AXES, AXES
    return cell.plane, "".join(sorted({*AXES} - {*cell.plane}))


def _outward(owner: Any, keys: Sequence[Any], step: float) -> Any:
    """A value with the numbers at a place inside moved outward by a share of their size; infinite ones stay."""
    key, *inner = keys
    named = isinstance(key, str)
    value = getattr(owner, key) if named else owner[key]
    if inner:
        changed = _outward(value, inner, -step if named and key.endswith("lower") else step)
    else:
        changed = np.add(value, step * np.where(np.isfinite(value), np.abs(value), 0.0)).tolist()
    if isinstance(owner, np.ndarray):
        moved = owner.copy()
        moved[key] = changed
        return moved
    if isinstance(owner, list | tuple):
        return type(owner)((*owner[:key], changed, *owner[key + 1 :]))
    return owner.model_copy(update={key: changed}) if isinstance(owner, Record) else replace(owner, **{key: changed})


def with_machine_at(cell: Cell, name: str, base: RigidTransform) -> Cell:
    """The same cell with a robot's base elsewhere in the world; the other arms of its machine move along."""
    bases = {robot.name: robot.T_world_base for robot in cell.robots}
    step = base @ bases[name].inverse()
    moved = {one: base if one == name else step @ bases[one] for one in machine_of(cell, name)}
    return cell.with_values({f"robots.{one}.base": pose for one, pose in moved.items()})


def machine_of(cell: Cell, name: str) -> list[str]:
    """Arms of the machine that a robot is an arm of, in the order of the cell; of most robots itself alone."""
    fellows = {one for pair in cell.machines if name in pair for one in pair} | {name}
    return [robot.name for robot in cell.robots if robot.name in fellows]
