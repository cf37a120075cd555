# SPDX-License-Identifier: MIT
"""What a cell is begun from: which chains of URDFs are arms, what they are called, what goes together, and sizes."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache, cached_property
from pathlib import Path

import numpy as np

from mrts.base.arrays import Array
from mrts.base.errors import InputError, is_number
from mrts.base.formats.urdf import Urdf
from mrts.base.input_file import LARGEST_NUMBER, is_uri, named_in
from mrts.base.rigid_transform import RigidTransform
from mrts.cell.generation import arm_of_urdf, read_urdf
from mrts.cell.remarks import urdf_remarks
from mrts.following.coordinated_motion import POSTURES, lacking_freedom
from mrts.following.tracking import random_starts
from mrts.starting.arm import Arm
from mrts.starting.tips import FEWEST_JOINTS, SIDES, first_link, hands, links_beyond, moved_by, side_of

WIDTH, LIFT, GRID = 0.3, 0.2, 0.12
"""Of the box, of the lift, and between heights that are tried, as shares of the shortest arm's reach."""

MOST_HANDS = 2

TOO_FEW = f"holding an object takes {FEWEST_JOINTS}; a cell of planar arms begins with the one of `mrts demo`"
"""Said of a chain with fewer joints."""

STANDARD_GRAVITY = np.array([0.0, 0.0, -9.81])
"""World axes [m/s²]."""

ROBOT, TIP, BASE = "--robot", "--tip", "--base"


@dataclass(frozen=True, eq=False)
class Request:
    """What a cell is begun from.

    Attributes:
        name: Of the cell.
        arms: Its arms, two or more.
        one_machine: Whether they are arms of one machine, whose bases stay where the URDF has them.
        gravity: World, Shape (3,) [m/s²].
        mass: Of the object [kg], where the user gave it.
    """

    name: str
    arms: tuple[Arm, ...]
    one_machine: bool
    gravity: Array
    mass: float | None

    @cached_property
    def up(self) -> Array:
        """Against gravity, along an axis of the world, Shape (3,)."""
        best = int(np.argmax(np.abs(self.gravity)))
        if self.gravity[best] == 0:
            return np.array([0.0, 0.0, 1.0])
        return np.asarray(-np.sign(self.gravity[best]) * np.eye(3)[best] + 0.0)

    def length(self, share: float) -> float:
        """A share of the shortest arm's reach, of two digits at most [m]."""
        length = share * min(arm.reach for arm in self.arms)
        step = 10.0 ** np.floor(np.log10(length)) / 2
        return float(np.round(max(np.round(length / step), 1) * step, 6))

    @property
    def width(self) -> float:
        """Between the hands' tips [m]."""
        return self.length(WIDTH)

    @property
    def between_hands(self) -> float:
        """What hands that reach beyond their tips leave of the width, a tenth at least [m]."""
        left = self.width - 2 * max(arm.overhang for arm in self.arms)
        return max(left, self.width / 10)

    @property
    def grid(self) -> float:
        """Between places that are tried [m]."""
        return self.length(GRID)

    def force(self, mass: float) -> Array:
        """Of each hand on an object at rest, Shape (3,) [N]."""
        return -mass * self.gravity / len(self.arms)


@dataclass(frozen=True, eq=False)
class _Chosen:
    """One arm: the URDF that it is of, as it was named and as it was read, and its tip."""

    robot: int
    reference: str
    path: Path
    tree: Urdf
    tip: str


def request_of(
    folder: Path,
    *,
    name: str,
    robots: Sequence[str],
    tips: Sequence[str] = (),
    bases: Sequence[RigidTransform] = (),
    mass: float | None = None,
    gravity: Array = STANDARD_GRAVITY,
) -> Request:
    """The request that a user's words are.

    Args:
        folder: Where the cell file will stand.
        name: Of the cell.
        robots: URDFs, as in a cell file or relative to the current folder.
        tips: Of each robot, or several of a single one; none where they are to be found.
        bases: Of each robot: where the root of its URDF is in the world; none where they are to be proposed.
        mass: Of the object [kg].
        gravity: World, Shape (3,) [m/s²].

    Raises:
        InputError: If a URDF or a value breaks a rule.
    """
    if mass is not None and not (is_number(mass, 0, LARGEST_NUMBER) and mass > 0):
        raise InputError("mass", "must be a number > 0, in kg.", value=mass)
    chosen = _chosen(robots, tips)
    standing = 1 + max(arm.robot for arm in chosen)
    if bases and len(bases) != standing:
        rule = f"give it once for each robot, in their order: {standing} times, or not at all."
        raise InputError(BASE, rule, value=len(bases))
    machines = {one.path for one in chosen if len(_machine(chosen, one)) > 1}
    alone = len(machines) == 1 and all(one.path in machines for one in chosen)
    if machines and not alone and not bases:
        rule = (
            "is needed for each robot where one has several arms: they cannot be moved about by themselves. Or choose "
            "one arm of each with --tip, once for each --robot."
        )
        raise InputError(BASE, rule)
    arm_of = cache(arm_of_urdf)  # two of a kind have one chain
    arms = []
    for one, called in zip(chosen, _names([one.tip for one in chosen]), strict=True):
        fellows = [fellow.tip for fellow in _machine(chosen, one)]
        chain, com = arm_of(one.path, one.tree, first_link(one.tree, fellows), one.tip)
        T_root_base = chain.source.T_base_root.inverse()
        in_place = T_root_base if len(fellows) > 1 else None
        arms.append(
            Arm(
                replace(chain, name=called),
                com,
                path=one.path.absolute(),
                urdf=one.reference if is_uri(one.reference) else named_in(folder, one.path),
                base=bases[one.robot] @ T_root_base if bases else in_place,
                beyond=links_beyond(one.tree, one.tip),
            )
        )
    for arm in arms:
        _check_movable(arm)
    return Request(name, tuple(arms), alone and not bases, np.asarray(gravity), mass)


def _check_movable(arm: Arm) -> None:
    """Check that an arm can hold an object at all."""
    if (count := len(arm.robot.joints)) < FEWEST_JOINTS:
        has = f"the chain to '{arm.robot.source.tip_link}' has {count} joint{'s' * (count > 1)}"
        raise InputError(arm.path, f"{has}, and {TOO_FEW}. Choose another tip or robot.")
    for remark in urdf_remarks(arm.robot):
        if remark.code == "limits-equal":
            raise InputError(arm.path, remark.text)
    q = random_starts(arm.robot, POSTURES)
    if lacking := lacking_freedom(arm.robot.joints, arm.at(q).jacobian, list(range(6))):
        raise InputError(arm.path, f"{lacking} Choose another tip or robot.")


def _chosen(robots: Sequence[str], tips: Sequence[str]) -> list[_Chosen]:
    files = {robot: read_urdf(Path(ROBOT), Path.cwd(), robot) for robot in robots}
    read = [files[robot] for robot in robots]  # two of a kind are read once
    if tips:
        places = [0] * len(tips) if len(read) == 1 else list(range(len(read)))
        if len(places) != len(tips):
            rule = f"give it once for each --robot, in their order: {len(read)} times, or not at all."
            raise InputError(TIP, rule, value=list(tips))
        found = [_Chosen(at, robots[at], *read[at], tip) for at, tip in zip(places, tips, strict=True)]
        for arm in found:
            if arm.tip not in arm.tree.links:
                rule = f"there is no such link in {arm.path.name}; its links are {', '.join(arm.tree.links)}."
                raise InputError(TIP, rule, value=arm.tip)
        if len(read) == 1 and not _differ(found):  # several of a kind
            found = [replace(arm, robot=index) for index, arm in enumerate(found)]
    else:
        found = []
        for at, (_, tree) in enumerate(read):
            seen = hands(tree)
            counts = {link: len(moved_by(tree, link)) for link in seen or tree.links}
            if not 1 <= len(seen) <= MOST_HANDS or (len(seen) == MOST_HANDS and len({*counts.values()}) > 1):
                movable = [f"{link} ({count} joints)" for link, count in counts.items() if count >= FEWEST_JOINTS]
                if not movable:
                    raise InputError(robots[at], f"has no link that so many joints move: {TOO_FEW}.")
                seems = f"seems to have {len(seen)} hands" if seen else "does not say which link holds the object"
                rule = f"{seems}: choose with --tip, once an arm. There are {', '.join(movable)}."
                raise InputError(robots[at], rule)
            found += [_Chosen(at, robots[at], *read[at], tip) for tip in sorted(seen, key=side_of)]
    return [found[0], replace(found[0], robot=1)] if len(found) == 1 else found  # two of a kind


def _machine(chosen: list[_Chosen], arm: _Chosen) -> list[_Chosen]:
    same = [other for other in chosen if other.path == arm.path]
    return same if _differ(same) and len(same) > 1 else [arm]


def _differ(arms: list[_Chosen]) -> bool:
    return len({tuple(moved_by(arm.tree, arm.tip)) for arm in arms}) == len(arms)


def _names(tips: list[str]) -> list[str]:
    sides = [side_of(tip) for tip in tips]
    if len(tips) > len(SIDES):
        return [f"arm_{index + 1}" for index in range(len(tips))]
    return sides if {*sides} == {*SIDES} else list(SIDES)[: len(tips)]
