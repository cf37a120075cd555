# SPDX-License-Identifier: MIT
"""Small changes to the numbers of a cell, one at a time: each limit, the mass, where arms stand, where they grasp."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from math import degrees, pi
from typing import Annotated, Any, Literal, TypeVar

import numpy as np

from mrts.base.arrays import Array
from mrts.base.formats.record import Rule, check_attributes
from mrts.base.rigid_transform import RigidTransform, multiply, rotation_from_rpy
from mrts.cell.cell import Cell
from mrts.cell.hands import Contact
from mrts.cell.points import CarriedThing, PointLimit
from mrts.cell.robot import Robot

AXES = "xyz"

POSES: tuple[Literal["base", "grasp"], ...] = ("base", "grasp")

ChangeKind = Literal[
    "torque", "wrench", "contact", "velocity", "acceleration", "motor speed", "reserve", "mass", "base", "grasp"
]
"""What a change is of: a limit, the reserve that is kept of all of them, the mass, or a pose."""

Point = TypeVar("Point", bound=PointLimit)

Changed = tuple[ChangeKind, str, str]
"""Kind, robot and element of what is changed."""


SIDES: dict[ChangeKind, tuple[str, ...]] = {
    "torque": ("torque_lower", "torque_upper"),
    "wrench": ("wrench_lower", "wrench_upper"),
    "velocity": ("velocity_limit",),
    "acceleration": ("acceleration_lower", "acceleration_upper"),
}

OF_POINT: dict[ChangeKind, str] = {"velocity": "speed", "acceleration": "acceleration"}
"""What a limited point calls a limit of the kinds that it has."""

Step = Annotated[float, Rule(ge=1e-9, le=0.9)]
"""Whatever its unit: the programs are right to 1e-9."""


@dataclass(frozen=True, kw_only=True)
class ChangeSteps:
    """How far numbers are changed, each up and down.

    Attributes:
        share: Of limits, mass and reserve, as a share of them.
        shift: Of bases and grasps along an axis [m].
        turn: Of bases and grasps about an axis [rad].

    Raises:
        InputError: If one is not a number from 1e-9 to 0.9.
    """

    share: Step = 0.1
    shift: Step = 0.01
    turn: Step = pi / 180

    def __post_init__(self) -> None:
        check_attributes(self, ChangeSteps, "steps")


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
        if self.kind == "reserve":
            return cell.with_reserve(cell.reserve * (1 + self.step))
        if self.robot == "object":
            return replace(cell, **self._of_object(cell))
        if self.kind == "base":
            base = next(robot.T_world_base for robot in cell.robots if robot.name == self.robot)
            return with_machine_at(cell, self.robot, self._moved(base))
        robots = (
            replace(robot, **self._of_robot(cell, robot)) if robot.name == self.robot else robot
            for robot in cell.robots
        )
        return replace(cell, robots=tuple(robots))

    def _of_object(self, cell: Cell) -> dict[str, Any]:
        if self.kind == "contact":
            return {"carried": tuple(self._of_thing(thing) for thing in cell.carried)}
        name = f"object_{self.kind}_limit"
        limit = getattr(cell, name) * (1 + self._steps(_OF_OBJECT))
        return {name: limit, "object_points": tuple(map(self._of_point, cell.object_points))}

    def _of_point(self, point: Point) -> Point:
        key = OF_POINT[self.kind]
        given = getattr(point, key)
        changes = given is not None and point.name == self.element
        return point.model_copy(update={key: given * (1 + self.step)}) if changes else point

    def _of_thing(self, thing: CarriedThing) -> CarriedThing:
        if thing.name != self.element:
            return thing
        more = 1 + self.step
        return thing.model_copy(
            update={
                "friction": thing.friction and thing.friction * more,
                "half_width": thing.half_width and [width * more for width in thing.half_width],
            }
        )

    def _of_robot(self, cell: Cell, robot: Robot) -> dict[str, Any]:
        if self.kind == "grasp":
            return {"T_object_tip": self._moved(robot.T_object_tip)}
        if self.kind == "contact":
            return {"contacts": tuple(self._of_contact(contact) for contact in robot.contacts)}
        steps = self._steps(cell.wrench_components if self.kind == "wrench" else robot.joints)
        changed: dict[str, Any] = {name: _outward(robot, name, steps) for name in SIDES.get(self.kind, ())}
        if self.kind in OF_POINT:
            changed["point_limits"] = tuple(map(self._of_point, robot.point_limits))
        if self.kind in {"torque", "motor speed"}:  # another motor: its curve changes with its torque limit
            factor = np.array([1 + self.step, 1.0] if self.kind == "motor speed" else [1.0, 1 + self.step])
            curves = tuple(
                curve * factor if curve is not None and joint == self.element else curve
                for joint, curve in zip(robot.joints, robot.motors.torque_speed, strict=True)
            )
            changed["motors"] = replace(robot.motors, torque_speed=curves)
        return changed

    def _of_contact(self, contact: Contact) -> Contact:
        if contact.name != self.element:
            return contact
        step = np.where(contact.lower < contact.upper, self.step, 0.0)
        return replace(contact, lower=_outward(contact, "lower", step), upper=_outward(contact, "upper", step))

    def _steps(self, names: Sequence[str]) -> Array:
        return np.array([self.step if name == self.element else 0.0 for name in names])

    def _moved(self, pose: RigidTransform) -> RigidTransform:
        step = np.array([self.step if self.element[-1] == axis else 0.0 for axis in AXES])
        if self.unit == "m":
            return RigidTransform(pose.R, pose.p + step)
        return RigidTransform(multiply(rotation_from_rpy(*step), pose.R), pose.p)


def cell_changes(cell: Cell, steps: ChangeSteps) -> tuple[CellChange, ...]:
    """All changes of a cell, each up and down: its limits, in the order of its rows, mass and reserve, and its poses.

    Sides of a limit move together. A joint with a torque-speed curve has its torques changed with the limit, as by
    another motor, and the curve's speeds by themselves. A component that is held at one number is no limit. Arms of one
    machine move with the base of the first of them.
    """
    named: list[Changed] = [*limit_names(cell), ("mass", "", "")]
    if cell.reserve:
        named.append(("reserve", "", ""))
    shares = [(entry, steps.share) for entry in named]
    along, around = _axes(cell)
    for kind in POSES:
        for robot in cell.robots:
            if kind == "base" and machine_of(cell, robot.name)[0] != robot.name:
                continue
            shares += [((kind, robot.name, axis), steps.shift) for axis in along]
            shares += [((kind, robot.name, f"about {axis}"), steps.turn) for axis in around]
    return tuple(
        CellChange(kind=kind, robot=robot, element=element, step=sign * step)
        for (kind, robot, element), step in shares
        for sign in (1, -1)
    )


def limit_names(cell: Cell) -> Iterator[Changed]:
    """Kind, robot and element of every limit that bounds something."""
    for robot in cell.robots:
        yield from _bounded("torque", robot.name, robot.joints, robot.torque_lower, robot.torque_upper)
    for robot in cell.robots:
        yield from _bounded("wrench", robot.name, cell.wrench_components, robot.wrench_lower, robot.wrench_upper)
    yield from (("contact", robot.name, contact.name) for robot in cell.robots for contact in robot.contacts)
    yield from (("contact", "object", thing.name or "") for thing in cell.carried)
    for kind in OF_POINT:
        if kind == "velocity" and not cell.enforces_velocity_limits:
            continue
        for robot in cell.robots:
            sides = [getattr(robot, name) for name in SIDES[kind]]
            lower, upper = sides if len(sides) > 1 else (-sides[0], sides[0])
            yield from _bounded(kind, robot.name, robot.joints, lower, upper)
            yield from _points(kind, robot.name, robot.point_limits)
        limit = getattr(cell, f"object_{kind}_limit")
        yield from _bounded(kind, "object", _OF_OBJECT, -limit, limit)
        yield from _points(kind, "object", cell.object_points)
    for robot in cell.robots:
        curves = zip(robot.joints, robot.motors.torque_speed, strict=True)
        yield from (("motor speed", robot.name, joint) for joint, curve in curves if curve is not None)


def _points(kind: ChangeKind, owner: str, points: Sequence[PointLimit]) -> Iterator[Changed]:
    limited = (point for point in points if getattr(point, OF_POINT[kind]) is not None)
    yield from ((kind, owner, point.name or "") for point in limited)


def _bounded(kind: ChangeKind, robot: str, elements: Sequence[str], lower: Array, upper: Array) -> Iterator[Changed]:
    """Elements with a limit on some side, unless they are held at one number."""
    is_limit = (lower < upper) & (np.isfinite(lower) | np.isfinite(upper))
    yield from ((kind, robot, element) for element, limited in zip(elements, is_limit.tolist(), strict=True) if limited)


_OF_OBJECT = ("linear", "angular")


def _axes(cell: Cell) -> tuple[list[str], list[str]]:
    forces, moments = ([name[1] for name in cell.wrench_components if name[0] == first] for first in "fn")
    return forces, moments


def _outward(owner: Robot | Contact, name: str, step: Array) -> Array:
    """A side of a limit moved outward by a share of its own size, Shape (r,); one that bounds nothing stays."""
    side: Array = getattr(owner, name)
    moved = step * np.where(np.isfinite(side), np.abs(side), 0.0)
    return side - moved if name.endswith("lower") else side + moved


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
