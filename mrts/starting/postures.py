# SPDX-License-Identifier: MIT
"""Postures in which an arm can hold something: far from its limits and singularities, and strong enough to lift it."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array, apply
from mrts.base.rigid_transform import RigidTransform, snap_rotation, vectors_from_rotations
from mrts.starting.arm import Arm, ArmState

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
class Wanted:
    """Where a hand may hold something, base frame unless said otherwise; K directions.

    Attributes:
        T_world_base: Where the arm stands.
        rotations: Of the tip, Shape (K, 3, 3).
        facing: Where the hand points in each, Shape (K, 3).
        kinds: What tells directions apart that are no alternatives for one another, Shape (K,).
        start: A place of the hand, world, Shape (3,) [m].
        axes: Along which its other places lie, world, Shape (2, 3).
        grid: Between places [m].
        rows: Of a twist that count, of a planar arm fewer.
        gravity: Shape (3,) [m/s²].
        force: Of the hand on the object, Shape (3,) [N].
        lift: Where the hand goes from there, Shape (3,) [m].
        stands: Whether the base stands on a floor, above which the arm should stay.
    """

    T_world_base: RigidTransform
    rotations: Array
    facing: Array
    kinds: NDArray[np.intp]
    start: Array
    axes: Array
    grid: float
    rows: list[int]
    gravity: Array
    force: Array
    lift: Array
    stands: bool


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


def find_stands(arm: Arm, wanted: Wanted) -> dict[tuple[int, ...], Stand]:
    """The best posture of each kind of direction and number of steps along both axes."""
    q = drawn_postures(arm)
    state = arm.at(q)
    nearness = np.einsum("nij,kij->nk", state.R, wanted.rotations)  # the trace of Rᵀ R_k: 1 + 2 cos of the angle
    kind = np.argmax(nearness, axis=1)
    chosen = np.argsort(-np.max(nearness, axis=1), kind="stable")[:SETTLED_SAMPLES]
    q, kind = q[chosen], kind[chosen]
    R = wanted.rotations[kind]
    T = wanted.T_world_base
    steps = np.round((state.p[chosen] @ T.R.T + T.p - wanted.start) @ wanted.axes.T / wanted.grid)
    p = (wanted.start + wanted.grid * steps @ wanted.axes - T.p) @ T.R
    q, near = settle(arm, q, R, p, wanted.rows, SETTLING_STEPS)
    score, effort = np.where(near, 1.0, 0.0), np.zeros(len(q))
    along = q
    for step in np.linspace(0, 1, LIFT_SAMPLES):
        along, near = settle(arm, along, R, p + step * wanted.lift, wanted.rows, LIFTING_STEPS)
        state = arm.at(along)
        limited = np.max(np.abs(arm.torque(state, wanted.gravity, wanted.force)) / arm.robot.torque_upper, axis=1)
        effort = np.maximum(effort, limited)
        score = np.minimum(score, near * _ease(arm, along, state, wanted, wanted.facing[kind]))
    score = score * np.clip(1.2 - effort, 0, 1)
    found: dict[tuple[int, ...], Stand] = {}
    for at in np.argsort(-score, kind="stable"):
        key = (int(wanted.kinds[kind[at]]), *map(int, steps[at]))
        if score[at] > 0 and key not in found:
            tip = RigidTransform(snap_rotation(T.R @ R[at], within=ROUNDING), np.round(T.p + T.R @ p[at], DECIMALS))
            found[key] = Stand(T, tip, q[at], float(score[at]))
    return found


def settle(arm: Arm, q: Array, R: Array, p: Array, rows: list[int], steps: int) -> tuple[Array, NDArray[np.bool_]]:
    """Joint positions moved until the tip has a pose, by damped Newton steps, and which came there within limits.

    Of all drawn postures at once, and before there is a cell with compiled kinematics to track.
    """
    q = q.copy()
    for _ in range(steps):
        state = arm.at(q)
        error, J = _error(state, R, p)[:, rows], state.jacobian[:, rows]
        damping = LEAST_DAMPING + 0.5 * np.sum(error**2, axis=1)
        square = J @ J.transpose(0, 2, 1) + damping[:, None, None] * np.eye(J.shape[1])
        step = apply(J.transpose(0, 2, 1), np.linalg.solve(square, error[:, :, None])[:, :, 0])
        q += step * LONGEST_STEP / np.max(np.abs(step), axis=1, keepdims=True, initial=LONGEST_STEP)
    near = np.max(np.abs(_error(arm.at(q), R, p)[:, rows]), axis=1) <= REACHED
    q = _unwound(arm, q)
    inside = np.all((q >= arm.robot.position_lower) & (q <= arm.robot.position_upper), axis=1)
    return q, near & inside


def _error(state: ArmState, R: Array, p: Array) -> Array:
    return np.concatenate([p - state.p, vectors_from_rotations(R @ state.R.transpose(0, 2, 1))], axis=1)


def _unwound(arm: Arm, q: Array) -> Array:
    """The same positions of turning joints, as near to the middle as whole turns bring them."""
    turns = arm.robot.turns
    middle = arm.middle()
    return np.asarray(np.where(turns, middle + (q - middle + np.pi) % (2 * np.pi) - np.pi, q), dtype=np.float64)


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


def _ease(arm: Arm, q: Array, state: ArmState, wanted: Wanted, facing: Array) -> Array:
    """How far from limits and singularities arms are, from 0 to 1, Shape (N,)."""
    to_limit = np.minimum(q - arm.robot.position_lower, arm.robot.position_upper - q) / _half_range(arm)
    margin = np.min(to_limit, axis=1, initial=1.0)
    scale = np.array([1 / arm.reach] * 3 + [1.0] * 3)[wanted.rows]
    values = np.linalg.svd(scale[:, None] * state.jacobian[:, wanted.rows], compute_uv=False)
    condition = values[:, -1] / values[:, 0]
    up = -wanted.gravity / max(float(np.linalg.norm(wanted.gravity)), 1.0)
    level = facing - np.outer(facing @ up, up)
    from_base = state.p - state.points[:, 0]
    away = from_base - np.outer(from_base @ up, up)
    distance = np.linalg.norm(away, axis=1) / arm.reach
    cramped = np.clip(distance / NEAREST, 0.1, 1) * np.clip((1 - distance) / (1 - FARTHEST), 0.1, 1)
    ease = np.clip(margin / EASY_MARGIN, 0, 1) ** 0.5 * np.clip(condition / EASY_CONDITION, 0, 1) ** 0.5 * cramped
    beyond = np.einsum("nki,ni->nk", state.points - state.p[:, None], facing)
    ease *= np.where(np.max(beyond, axis=1) > NEAREST * EDGE * arm.reach, 0.3, 1.0)  # a link where the object is
    if wanted.stands:
        outward = np.einsum("ni,ni->n", away, level) / np.maximum(np.linalg.norm(away, axis=1), EDGE * arm.reach)
        ease *= np.clip(outward, 0.1, 1)
        ease *= np.where(np.min(state.points @ up, axis=1) < -BELOW_BASE * arm.reach, 0.3, 1.0)
    return np.asarray(ease, dtype=np.float64)
