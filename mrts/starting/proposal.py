# SPDX-License-Identifier: MIT
"""A first cell and a first motion that were tried: layouts, loads and durations until the range of c² has room.

Comments in their files say what was read, proposed and assumed.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from math import ceil, floor, isfinite, log10
from typing import Any

import numpy as np

from mrts.base.errors import MotionError, MrtsError, Remark, printable
from mrts.base.rigid_transform import RigidTransform
from mrts.base.yaml_text import yaml_text
from mrts.cell.cell import Cell
from mrts.cell.cell_keys import pose_keys
from mrts.following.clearance import clearance_remarks
from mrts.motion.motion_file import load_motion
from mrts.program.between_samples import BETWEEN
from mrts.scaling.scale import ScalingResult, scale
from mrts.starting.arm import Arm
from mrts.starting.layouts import Layout, Stand, drawn_postures, layouts
from mrts.starting.request import Request

LOAD_SHARE = 0.1
"""Of the arms' own mass that the object has: an industrial arm carries a quarter of its mass or less."""

LOADS = (1.0, 0.5, 0.2, 0.1, 0.05, 0.02, 0.01)
"""Shares of the load that are tried, until the motors bear it."""

LIFTS = (1.0, 0.5, 0.25)

TRIED_LAYOUTS = 4

FIRST_DURATION = 2.0
"""[s]; then the one in which the motion may be played about twice as fast as given."""

SPARE = 2.0
"""How many times as fast as given the motion may be played at least."""

SHORTEST, LONGEST = 1e-3, 60.0
"""Of the motion [s]. Efforts that are placeholders, and no velocity limits, make it shorter than anyone would move."""

STRONG = 2.0
"""Torques that are assumed where a URDF says nothing: so many times what its worst posture takes at rest."""

WEAKEST, WEAKEST_SHARE = 1.0, 0.1
"""Least torque that is assumed [N m or N], and as a share of the largest of its arm: a wrist turns the load."""

DIGITS = 6

COMMENT_AT = 50

Tell = Callable[[int, int, str], None]
"""To be told which of how many tries it is, and what is tried."""


@dataclass(frozen=True, eq=False)
class Proposal:
    """A cell and a motion that can be played.

    Attributes:
        request: What was asked.
        layout: Where everything is.
        mass: Of the object [kg].
        cell: Keys and values of the cell file.
        motion: Likewise of the motion file.
        result: What `mrts.scale` finds.
        collisions: What is to say of them.
    """

    request: Request
    layout: Layout
    mass: float
    cell: dict[str, Any]
    motion: dict[str, Any]
    result: ScalingResult
    collisions: tuple[Remark, ...]


def propose(request: Request, tell: Tell = lambda _done, _total, _note: None) -> Proposal:
    """A cell and a motion that can be played; of the layouts for a mass and a lift the first without a collision."""
    own = sum(float(np.sum(arm.robot.source.carried_mass)) for arm in request.arms)
    first = request.mass or (LOAD_SHARE * own if own > 0 else 1.0)
    reason = ""
    colliding: list[Proposal] = []
    for lift, share_of_lift in enumerate(LIFTS):
        found: list[Layout] = []
        for load, share_of_load in enumerate(LOADS):
            mass = float(f"{first * share_of_load:.2g}")
            tell(lift * len(LOADS) + load, len(LIFTS) * len(LOADS), f"{mass:g} kg")
            try:
                found = found or layouts(request, mass, share_of_lift)
            except MotionError as error:
                reason = reason or str(error)
                continue
            for layout in found[:TRIED_LAYOUTS]:
                try:
                    tried = _tried(request, layout, mass)
                except MrtsError as error:
                    reason = str(error)
                    continue
                if all(remark.severity != "hint" for remark in tried.collisions):
                    return tried
                colliding.append(tried)
            if colliding:  # a lighter box would alike; a shorter lift may not
                break
    if colliding:
        return colliding[0]
    with_loads = "" if request.mass is None else f" with {request.mass:g} kg, nor with {mass:g} kg"
    raise MotionError(f"nothing was found that can be played{with_loads}. The last try: {reason}")


def _tried(request: Request, layout: Layout, mass: float) -> Proposal:
    keys = _cell_keys(request, layout, mass)
    first = _played(request, keys, _motion_keys(layout, FIRST_DURATION), None)
    duration = FIRST_DURATION
    if isfinite(c2 := _c2(first, 0.0)):
        duration = max(SHORTEST, _rounded_up(FIRST_DURATION * SPARE / c2**0.5))
    if duration > LONGEST:
        raise MotionError(f"the motion would take {duration:.3g} s: the arms can hardly hold {mass:g} kg")
    for robot, joints in zip(keys["robots"], first.cell.joint_slices.values(), strict=True):
        robot["posture"] = (np.round(first.motion.q[0, joints], DIGITS) + 0.0).tolist()
    motion = _motion_keys(layout, duration)
    result = _played(request, keys, motion, BETWEEN)
    _c2(result, 1.0)
    _, said = clearance_remarks(result.cell, result.motion)
    return Proposal(request=request, layout=layout, mass=mass, cell=keys, motion=motion, result=result, collisions=said)


def _c2(result: ScalingResult, least: float) -> float:
    """The largest c², which must be more than the least."""
    end = result.range.upper
    if result.trajectory is None or not end.c2 > least:
        raise MotionError(result.sentence())
    return end.c2


def _played(request: Request, keys: dict[str, Any], motion: dict[str, Any], between: float | None) -> ScalingResult:
    paths = [{"urdf": str(arm.path)} for arm in request.arms]
    robots = [robot | path for robot, path in zip(keys["robots"], paths, strict=True)]
    cell = Cell.from_description(keys | {"robots": robots}, folder=request.arms[0].path.parent)
    return scale(cell, load_motion(motion), between=between)


def _motion_keys(layout: Layout, duration: float) -> dict[str, Any]:
    start, end = (np.round(place, 6) + 0.0 for place in (layout.position, layout.position + layout.lift))
    return {"duration": duration, "profile": "quintic", "start": {"xyz": start.tolist()}, "end": {"xyz": end.tolist()}}


def _cell_keys(request: Request, layout: Layout, mass: float) -> dict[str, Any]:
    keys: dict[str, Any] = {"name": request.name, "gravity": request.gravity.tolist()}
    keys["object"] = {"mass": mass, "shape": {"box": layout.sides.tolist()}}
    stands = zip(request.arms, layout.stands, strict=True)
    return keys | {"robots": [_robot_keys(request, arm, stand, layout, mass) for arm, stand in stands]}


def _robot_keys(request: Request, arm: Arm, stand: Stand, layout: Layout, mass: float) -> dict[str, Any]:
    chain = arm.robot
    T = RigidTransform(stand.T_world_tip.R, np.round(stand.T_world_tip.p - layout.position, 9) + 0.0)
    robot: dict[str, Any] = {"name": chain.name, "urdf": arm.urdf}
    robot |= {"base_link": chain.source.base_link, "tip_link": chain.source.tip_link}
    robot |= {"base": pose_keys(stand.T_world_base), "grasp": pose_keys(T), "posture": stand.posture.tolist()}
    if np.any(np.isinf(known := chain.torque_upper)):  # the URDF does not say them
        robot["torque"] = np.where(np.isfinite(known), known, _assumed_torque(request, arm, mass)).tolist()
    return robot


def _assumed_torque(request: Request, arm: Arm, mass: float) -> Any:
    share = mass * float(np.linalg.norm(request.gravity)) / len(request.arms)
    state = arm.at(drawn_postures(arm))
    pulls = [arm.torque(state, sign * axis * 9.81, -sign * share * axis) for axis in np.eye(3) for sign in (1, -1)]
    worst = np.max(np.abs(pulls), axis=(0, 1))
    least = max(WEAKEST, WEAKEST_SHARE * float(np.max(worst)))
    return np.array([_rounded_up(max(STRONG * each, least)) for each in worst])


def _rounded_up(number: float) -> float:
    """To two digits."""
    step = 10.0 ** (floor(log10(number)) - 1)
    return float(f"{ceil(number / step) * step:.2g}")


def cell_file(proposal: Proposal) -> str:
    """Text of the cell file."""
    request, mass = proposal.request, "assumed" if proposal.request.mass is None else "as asked for"
    if request.mass not in {None, proposal.mass}:
        mass = f"{request.mass:g} were asked for, which the motors cannot hold"
    standing = "as asked for" if request.arms[0].base is not None else "proposed"
    comments = {
        "gravity": "world, m/s²",
        "mass": mass,
        "shape": "assumed: a uniform box, which gives the inertia as well",
        "base_link": "where the chain begins",
        "tip_link": "holds the object",
        "base": f"base link in the world, {'where the URDF has it' if request.one_machine else standing}",
        "grasp": "tip in the object, whose frame is in its centre of mass",
        "posture": "at the start, proposed",
        "torque": "assumed: the URDF has no effort. Put the data sheet's here",
    }
    return (
        f"# {len(request.arms)} arms carry a box: begun by mrts new.\n"
        "# What the URDFs do not say was proposed or assumed; change what you know better.\n"
        "# Lengths in m, angles in rad, masses in kg, torques in N m (N of prismatic joints).\n"
        f"{_commented(yaml_text(proposal.cell), comments)}"
        "# Nothing bounds yet what the hands exert on the object: see wrench and contact.\n"
    )


def motion_file(proposal: Proposal) -> str:
    """Text of the motion file."""
    lift = float(np.linalg.norm(proposal.layout.lift))
    comments = {
        "duration": "s; proposed: the cell may play it faster",
        "profile": "or sinusoid, trapezoid, cubic",
        "end": "with rpy: [0, 0, 0.3] it turns as well",
    }
    return (
        f"# The object goes up by {lift:g} m, from rest to rest: begun by mrts new.\n"
        "# Poses are those of its centre of mass in the world; lengths in m, angles in rad.\n"
        f"{_commented(yaml_text(proposal.motion), comments)}"
    )


def _commented(text: str, comments: Mapping[str, str]) -> str:
    """The same YAML with a comment behind lines that begin with a key."""
    lines = []
    for line in text.splitlines():
        comment = comments.get(line.strip(" -").partition(":")[0])
        lines.append(line if comment is None else f"{line:<{COMMENT_AT}} # {printable(comment)}")
    return "\n".join(lines) + "\n"
