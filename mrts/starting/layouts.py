# SPDX-License-Identifier: MIT
"""Where arms may stand, hold a box between them, and lift it: the best few layouts that the arms' geometry admits."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.base.errors import InputError, MotionError
from mrts.base.rigid_transform import RigidTransform, plane_normal, rotations_from_vectors, snap_rotation
from mrts.starting.arm import Arm, twist_rows
from mrts.starting.postures import ROUNDING, Stand, Wanted, find_stands
from mrts.starting.request import LIFT, Request

FLATNESS = (1.0, 0.6, 0.5)
"""Sides of the box: between the hands, across, upward."""

DISTANCES = (0.35, 0.5)
"""From the box to where bases are proposed, as shares of the shortest arm's reach."""

DIRECTIONS = (("inward", 1.0), ("inward and down", 0.9), ("inward and forward", 0.9), ("forward", 0.8), ("down", 0.6))
"""Where hands may point, with what each is worth beside the others: a box is held best
between hands that face each other."""

IN_FLOOR = 0.3
"""What a layout is worth beside others whose object starts in the floor."""

METRES = 3
"""Decimals of positions that are proposed [m]."""

STEEPEST = 0.3
"""A hand is level if its direction is not steeper than this cosine to the vertical leaves it; else its side counts."""


@dataclass(frozen=True, eq=False)
class Layout:
    """Where everything is at the start.

    Attributes:
        position: Of the object, Shape (3,) [m]; its axes are those of the world.
        sides: Of the box that the object is taken for, Shape (3,) [m].
        lift: From the start to the end, Shape (3,) [m].
        stands: By arm.
        score: From 0 to 1; the larger, the farther from limits.
    """

    position: Array
    sides: Array
    lift: Array
    stands: tuple[Stand, ...]
    score: float


def layouts(request: Request, mass: float, share: float = 1.0) -> list[Layout]:
    """Layouts in which every arm can hold the box and lift it, the best first."""
    lift, force = request.length(share * LIFT) * request.up, request.force(mass)
    given = [arm.base for arm in request.arms if arm.base is not None]
    tried = [given] if given else [_proposed_bases(request, distance) for distance in DISTANCES]
    found = [layout for bases in tried for layout in _between(request, bases, lift, force)]
    if not found:
        raise MotionError(
            "no posture was found in which every arm holds one box and lifts it. Give other tips (--tip)"
            f"{'' if request.one_machine else ' or other bases (--base)'}."
        )
    return sorted(found, key=lambda layout: -layout.score)


def _sides(request: Request, out: Array) -> Array:
    high = int(np.argmax(np.abs(request.up)))
    along = int(np.argmax(np.abs(np.where(np.arange(3) == high, 0, out))))
    across = 3 - high - along
    sides = np.empty(3)
    sides[[along, across, high]] = [float(f"{request.width * share:.2g}") for share in FLATNESS]
    sides[along] = min(sides[along], round(request.between_hands, METRES))
    return sides


def _proposed_bases(request: Request, distance: float) -> list[RigidTransform]:
    """Bases around the object, on the floor and facing it; in a plane as the URDF has them."""
    count, level = len(request.arms), request.up == 0
    if request.plane is not None:
        level = level & (plane_normal(request.plane) == 0)
    first = np.eye(3)[int(np.argmax(level))]
    away = request.width / 2 + distance * min(arm.reach for arm in request.arms)
    bases = []
    for angle in np.pi + 2 * np.pi * np.arange(count) / count:
        out = rotations_from_vectors(angle * request.up) @ first
        turn = np.eye(3) if request.plane else rotations_from_vectors((angle + np.pi) * request.up)
        bases.append(RigidTransform(snap_rotation(turn, within=ROUNDING), np.round(away * out, METRES) + 0.0))
    return bases


def _turn(up: Array, start: Array, end: Array) -> Array:
    angle = np.arctan2(np.cross(start, end) @ up, start @ end)
    turned: Array = rotations_from_vectors(angle * up)
    return turned


def _between(request: Request, bases: Sequence[RigidTransform], lift: Array, force: Array) -> list[Layout]:
    """Layouts with the box between arms, before a machine too, or above and below."""
    proposed = request.arms[0].base is None
    middle, out = _middle(request, bases)
    pair = len(out) == 2 and request.plane is None  # noqa: PLR2004 (a pair)
    forward = np.cross(request.up, (out[-1] - out[0]) / 2) * (pair and not proposed)
    found = []
    for arm, T, direction in zip(request.arms, bases, out, strict=True):
        facings, kinds = _directions(request, direction, forward)
        start = middle + request.width / 2 * direction
        found.append(find_stands(arm, _wanted(request, arm, facings, kinds, lift, force, T, start, forward)))
    made = []
    for key in set.intersection(*({*each} for each in found)):
        if request.one_machine and np.any(forward) and (key[1] < 1 or key[0] % 2):
            continue  # behind its back
        stands = tuple(each[key] for each in found)
        position = np.round(middle + request.grid * (key[1] * forward + key[2] * request.up), METRES)
        sides = _sides(request, out[0])
        in_floor = proposed and np.any(force) and (position - sides / 2) @ request.up < 0
        worth = DIRECTIONS[key[0] // 2][1] * (IN_FLOOR if in_floor else 1.0)
        made.append(Layout(position, sides, lift, stands, worth * min(stand.score for stand in stands)))
    return made


def _middle(request: Request, bases: Sequence[RigidTransform]) -> tuple[Array, Array]:
    """The middle of the arms, Shape (3,) [m], and the level direction to each, Shape (arms, 3)."""
    chains = [arm.robot for arm in request.arms]
    for joint in range(min(len(chain.joints) for chain in chains)):  # shoulders may begin in one breastbone
        anchors = np.array([T.p + T.R @ chain.points[joint] for T, chain in zip(bases, chains, strict=True)])
        middle = anchors.mean(axis=0)
        out = anchors - middle
        out -= np.outer(out @ request.up, request.up)
        if request.plane is not None:
            normal = plane_normal(request.plane)
            out -= np.outer(out @ normal, normal)
        length = np.linalg.norm(out, axis=1)
        if np.min(length) >= request.grid / 10:
            return np.round(middle, METRES - 1), out / length[:, None]
        if not request.one_machine:
            break
    if request.one_machine:
        rule = "as it is, the arms of the machine stand above one another: give the gravity that fits the URDF's axes."
        raise InputError("--gravity", rule, value=request.gravity.tolist())
    raise InputError("--base", "two arms stand in one place; one object must fit between them.")


def _directions(request: Request, out: Array, forward: Array) -> tuple[Array, NDArray[np.intp]]:
    """Where a hand may point, and the kind of each: twice its place in `DIRECTIONS`, and one more for backward."""
    down = -request.up
    ahead = [(0, -out), (2, down - out), (8, down)]
    if np.any(forward):
        ahead += [(4, forward - out), (5, -forward - out), (6, forward), (7, -forward)]
    facings = np.array([direction / np.linalg.norm(direction) for _, direction in ahead])
    return facings, np.array([kind for kind, _ in ahead])


def _wanted(
    request: Request,
    arm: Arm,
    facings: Array,
    kinds: NDArray[np.intp],
    lift: Array,
    force: Array,
    T: RigidTransform,
    start: Array,
    forward: Array,
) -> Wanted:
    """What one arm with its base at T is asked, in its base frame.

    `start` is where its hand would be with the object in the middle.
    """
    rotations, pointing, kind = [], [], []
    for facing, of_kind in zip(facings, kinds, strict=True):
        turns = _rolls(request, arm, T.R.T @ facing, T.R.T @ request.up)
        rotations += turns
        pointing += [T.R.T @ facing] * len(turns)
        kind += [of_kind] * len(turns)

    return Wanted(
        T_world_base=T,
        rotations=np.array(rotations),
        facing=np.array(pointing),
        kinds=np.array(kind),
        start=start,
        axes=np.array([forward, request.up]),
        grid=request.grid,
        rows=twist_rows(request.plane),
        gravity=T.R.T @ request.gravity,
        force=T.R.T @ force,
        lift=T.R.T @ lift,
        stands=not request.one_machine,
    )


def _rolls(request: Request, arm: Arm, facing: Array, up: Array) -> list[Array]:
    """Rotations of the tip that point the hand somewhere: four about the direction; in a plane there is one."""
    if request.plane is not None:
        at_zero = arm.robot.T_base_tip.R
        normal = plane_normal(request.plane)
        return [_turn(normal, at_zero @ arm.approach, facing) @ at_zero]
    second = np.roll(np.abs(arm.approach), 1)
    own = np.stack([arm.approach, second, np.cross(arm.approach, second)], axis=1)
    side = np.cross(up, facing)
    if np.linalg.norm(side) < STEEPEST:
        side = np.roll(np.abs(np.round(up)), 1)
    side = side / np.linalg.norm(side)
    sides = (side, np.cross(facing, side), -side, -np.cross(facing, side))
    return [np.stack([facing, axis, np.cross(facing, axis)], axis=1) @ own.T for axis in sides]
