# SPDX-License-Identifier: MIT
"""Where arms may stand, hold a box between them, and lift it: the best few layouts that the arms' geometry admits."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array, apply
from mrts.base.errors import InputError, MotionError
from mrts.base.rigid_transform import RigidTransform, rotations_from_vectors, snap_rotation, vectors_from_rotations
from mrts.following.tracking import nearest_turns
from mrts.starting.arm import Arm, ArmState
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


SAMPLES = 4000

SETTLED_SAMPLES = 600
"""Of these, the ones whose hands stand nearest to a wanted direction are moved to it."""

SEED = 19

SETTLING_STEPS = 40
LIFTING_STEPS = 8
LIFT_SAMPLES = 5

LONGEST_STEP = 0.3
"""Of a joint in one step [rad or m]."""

LEAST_DAMPING = 1e-9
"""Keeps the normal equations regular where an arm is singular; far below the squares of singular values that pass."""

REACHED = 1e-6
"""Error of a pose that counts as reached [m, rad]: what is written is only where the search of the motion starts."""

ROUNDING = 1e-9
"""Entries of rotations this near to 0 and ±1 are those."""

DECIMALS = 6
"""Of places of hands [m]."""

EDGE = 0.1
"""Share of a joint's range at either end from which no posture is drawn."""

FREE_TURN = np.pi
"""A joint without limits, or with wider ones, is drawn from this far to either side of its middle [rad]."""

FREE_SLIDE = 0.5

EASY_MARGIN, EASY_CONDITION = 0.25, 0.15
"""Share of a joint's range to its limit, and inverse condition number, beyond which more is hardly worth anything."""

NEAREST, FARTHEST = 0.3, 0.75
"""Distance from the first joint's axis to the hand, as a share of the reach, outside of which a posture is cramped."""

BELOW_BASE = 0.05
"""How far a joint may stand below the base, as a share of the reach: the floor."""


@dataclass(frozen=True, eq=False)
class Stand:
    """Where an arm stands, and how it holds something in a wanted place.

    Attributes:
        T_world_base: Of its base link.
        T_world_tip: Of its hand at the start.
        posture: Shape (n,) [rad or m].
        score: From 0 to 1; the larger, the farther from all limits along the lift.
    """

    T_world_base: RigidTransform
    T_world_tip: RigidTransform
    posture: Array
    score: float


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
    """Bases around the object, on the floor and facing it."""
    count = len(request.arms)
    first = np.eye(3)[int(np.argmax(request.up == 0))]
    away = request.width / 2 + distance * min(arm.reach for arm in request.arms)
    bases = []
    for angle in np.pi + 2 * np.pi * np.arange(count) / count:
        out = rotations_from_vectors(angle * request.up) @ first
        turn = rotations_from_vectors((angle + np.pi) * request.up)
        bases.append(RigidTransform(snap_rotation(turn, within=ROUNDING), np.round(away * out, METRES) + 0.0))
    return bases


def _between(request: Request, bases: Sequence[RigidTransform], lift: Array, force: Array) -> list[Layout]:
    """Layouts with the box between arms, before a machine too, or above and below."""
    proposed = request.arms[0].base is None
    middle, out = _middle(request, bases)
    pair = len(out) == 2  # noqa: PLR2004 (a pair)
    forward = np.cross(request.up, (out[-1] - out[0]) / 2) * (pair and not proposed)
    found = []
    for arm, T, direction in zip(request.arms, bases, out, strict=True):
        facings = _directions(request, direction, forward)
        start = middle + request.width / 2 * direction
        found.append(_stands(request, arm, T, facings, start, forward, lift, force))
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
        length = np.linalg.norm(out, axis=1)
        if np.min(length) >= request.grid / 10:
            return np.round(middle, METRES - 1), out / length[:, None]
        if not request.one_machine:
            break
    if request.one_machine:
        rule = "as it is, the arms of the machine stand above one another: give the gravity that fits the URDF's axes."
        raise InputError("--gravity", rule, value=request.gravity.tolist())
    raise InputError("--base", "two arms stand in one place; one object must fit between them.")


def _directions(request: Request, out: Array, forward: Array) -> list[tuple[int, Array]]:
    """Where a hand may point after the kind of each: twice its place in `DIRECTIONS`, and one more for backward."""
    down = -request.up
    ahead = [(0, -out), (2, down - out), (8, down)]
    if np.any(forward):
        ahead += [(4, forward - out), (5, -forward - out), (6, forward), (7, -forward)]
    return [(kind, direction / np.linalg.norm(direction)) for kind, direction in ahead]


def _stands(
    request: Request,
    arm: Arm,
    T: RigidTransform,
    facings: Sequence[tuple[int, Array]],
    start: Array,
    forward: Array,
    lift: Array,
    force: Array,
) -> dict[tuple[int, ...], Stand]:
    """The best posture of an arm with its base at T, by kind of direction and steps of the grid forward and up.

    Steps begin where the hand would be with the object in the middle, `start`; all vectors are in world axes.
    """
    up, gravity = T.R.T @ request.up, T.R.T @ request.gravity
    ways = [(kind, T.R.T @ facing) for kind, facing in facings]
    turns = [(kind, facing, R) for kind, facing in ways for R in _rolls(arm, facing, up)]
    rotations = np.array([R for _, _, R in turns])
    q = drawn_postures(arm)
    state = arm.at(q)
    nearness = np.einsum("nij,kij->nk", state.R, rotations)  # the trace of Rᵀ R_k: 1 + 2 cos of the angle
    chosen = np.argsort(-np.max(nearness, axis=1), kind="stable")[:SETTLED_SAMPLES]
    q, turn = q[chosen], np.argmax(nearness[chosen], axis=1)
    R, facing = rotations[turn], np.array([facing for _, facing, _ in turns])[turn]
    axes = np.array([forward, request.up])
    steps = np.round((state.p[chosen] @ T.R.T + T.p - start) @ axes.T / request.grid)
    p = (start + request.grid * steps @ axes - T.p) @ T.R
    q, near = _settle(arm, q, R, p, SETTLING_STEPS)
    score, effort = np.where(near, 1.0, 0.0), np.zeros(len(q))
    along = q
    for step in np.linspace(0, 1, LIFT_SAMPLES):
        along, near = _settle(arm, along, R, p + step * (T.R.T @ lift), LIFTING_STEPS)
        state = arm.at(along)
        limited = np.max(np.abs(arm.torque(state, gravity, T.R.T @ force)) / arm.robot.torque_upper, axis=1)
        effort = np.maximum(effort, limited)
        score = np.minimum(score, near * _ease(request, arm, along, state, facing, gravity))
    score = score * np.clip(1.2 - effort, 0, 1)
    found: dict[tuple[int, ...], Stand] = {}
    for at in np.argsort(-score, kind="stable"):
        key = (turns[turn[at]][0], *map(int, steps[at]))
        if score[at] > 0 and key not in found:
            tip = RigidTransform(snap_rotation(T.R @ R[at], within=ROUNDING), np.round(T.p + T.R @ p[at], DECIMALS))
            found[key] = Stand(T, tip, q[at], float(score[at]))
    return found


def _rolls(arm: Arm, facing: Array, up: Array) -> list[Array]:
    """Rotations of the tip that point the hand somewhere, four about the direction."""
    second = np.roll(np.abs(arm.approach), 1)
    own = np.stack([arm.approach, second, np.cross(arm.approach, second)], axis=1)
    side = np.cross(up, facing)
    if np.linalg.norm(side) < STEEPEST:
        side = np.roll(np.abs(np.round(up)), 1)
    side = side / np.linalg.norm(side)
    sides = (side, np.cross(facing, side), -side, -np.cross(facing, side))
    return [np.stack([facing, axis, np.cross(facing, axis)], axis=1) @ own.T for axis in sides]


def _settle(arm: Arm, q: Array, R: Array, p: Array, steps: int) -> tuple[Array, NDArray[np.bool_]]:
    """Joint positions moved until the tip has a pose, by damped Newton steps, and which came there within limits.

    Of all drawn postures at once, and before there is a cell with compiled kinematics to track.
    """
    q = q.copy()
    for _ in range(steps):
        state = arm.at(q)
        error, J = _error(state, R, p), state.jacobian
        damping = LEAST_DAMPING + 0.5 * np.sum(error**2, axis=1)
        square = J @ J.transpose(0, 2, 1) + damping[:, None, None] * np.eye(J.shape[1])
        step = apply(J.transpose(0, 2, 1), np.linalg.solve(square, error[:, :, None])[:, :, 0])
        q += step * LONGEST_STEP / np.max(np.abs(step), axis=1, keepdims=True, initial=LONGEST_STEP)
    near = np.max(np.abs(_error(arm.at(q), R, p)), axis=1) <= REACHED
    q = nearest_turns(arm.robot, q, arm.middle())
    inside = np.all((q >= arm.robot.position_lower) & (q <= arm.robot.position_upper), axis=1)
    return q, near & inside


def _error(state: ArmState, R: Array, p: Array) -> Array:
    return np.concatenate([p - state.p, vectors_from_rotations(R @ state.R.transpose(0, 2, 1))], axis=1)


def _half_range(arm: Arm) -> Array:
    free = np.where(arm.robot.turns, FREE_TURN, FREE_SLIDE)
    span = arm.robot.position_upper - arm.robot.position_lower
    half: Array = np.minimum(np.where(np.isfinite(span), span / 2, free), free)
    return half


def drawn_postures(arm: Arm) -> Array:
    """Random postures, the same for the same arm, Shape (SAMPLES, n) [rad or m]."""
    shares = np.random.default_rng(SEED).uniform(-1, 1, (SAMPLES, len(arm.robot.joints)))
    drawn: Array = arm.middle() + (1 - EDGE) * shares * _half_range(arm)
    return drawn


def _ease(request: Request, arm: Arm, q: Array, state: ArmState, facing: Array, gravity: Array) -> Array:
    """How far from limits and singularities arms are, from 0 to 1, Shape (N,)."""
    to_limit = np.minimum(q - arm.robot.position_lower, arm.robot.position_upper - q) / _half_range(arm)
    margin = np.min(to_limit, axis=1, initial=1.0)
    scale = np.array([1 / arm.reach] * 3 + [1.0] * 3)
    values = np.linalg.svd(scale[:, None] * state.jacobian, compute_uv=False)
    condition = values[:, -1] / values[:, 0]
    up = -gravity / max(float(np.linalg.norm(gravity)), 1.0)
    level = facing - np.outer(facing @ up, up)
    from_base = state.p - state.points[:, 0]
    away = from_base - np.outer(from_base @ up, up)
    distance = np.linalg.norm(away, axis=1) / arm.reach
    cramped = np.clip(distance / NEAREST, 0.1, 1) * np.clip((1 - distance) / (1 - FARTHEST), 0.1, 1)
    ease = np.clip(margin / EASY_MARGIN, 0, 1) ** 0.5 * np.clip(condition / EASY_CONDITION, 0, 1) ** 0.5 * cramped
    beyond = np.einsum("nki,ni->nk", state.points - state.p[:, None], facing)
    ease *= np.where(np.max(beyond, axis=1) > NEAREST * EDGE * arm.reach, 0.3, 1.0)  # a link where the object is
    if not request.one_machine:
        outward = np.einsum("ni,ni->n", away, level) / np.maximum(np.linalg.norm(away, axis=1), EDGE * arm.reach)
        ease *= np.clip(outward, 0.1, 1)
        ease *= np.where(np.min(state.points @ up, axis=1) < -BELOW_BASE * arm.reach, 0.3, 1.0)
    return np.asarray(ease, dtype=np.float64)
