# SPDX-License-Identifier: MIT
"""Inverse kinematics by Newton steps in the kernel's C: at samples, or along motions of many variants of one cell.

One motion is one variant. What is said of an arm that cannot follow goes by the codes of `mrts.kernel.tracking`.

Of all joint positions that hold its grasp a redundant arm takes those nearest to a reference, near a limit measured in
stretched positions: the minimiser of a distance H(q) on the set that holds the grasp, so a function of the object's
pose alone, whatever the samples and the speed (the extended Jacobian method: Baillieul 1985; the gradient of H away
from limits: Liégeois 1977). With the grasp's multipliers F

    h(q) - h(reference) = JᵀF,    h_j(q) = q_j + LIMIT_PUSH (x⁺⁵ - x⁻⁵),

where x⁺ and x⁻ grow from 0 to 1 over the zone beside the upper and the lower limit. Both equations, differentiated
along the path, give q' and q'' (kernel/c/tracking.c).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.base.errors import MotionError
from mrts.base.manifest import GRAVITY_SIZE, ROBOT_SIZE
from mrts.cell.cell import KNOWN_CELLS, Cell
from mrts.cell.robot import DEGREES_SUSPECTED, Robot
from mrts.kernel import tracking
from mrts.kernel.binding import filled
from mrts.kernel.tracking import PATH, follow_variants
from mrts.motion.object_motion import ObjectMotion

POSE_TOLERANCE = 1e-10
"""Largest remaining pose error [m, rad]; Newton's quadratic convergence usually leaves 1e-15."""


STARTING_STEPS = 300
"""Steps from the posture to the grasp at t = 0; a few dozen are usual."""

FURTHER_STEPS = 60
"""Steps from each further start; those that take more lead nowhere."""

TRACKING_STEPS = 30
"""Steps from the predicted positions at a sample; two or three are usual."""

SETTLED_PREFERENCE = 1e-8
"""Largest step left in the null space of a redundant arm [rad or m]; Newton's convergence usually leaves 1e-15."""

CONDITION_LIMIT = 1e6
"""Condition number of a Jacobian above which an arm counts as singular: ten digits of q' are left."""

POSITION_TOLERANCE = 1e-9
"""How far a joint may pass its position limit [rad or m]: rounding."""

FURTHER_STARTS = 40
"""Starts tried where the posture leads to nothing: an arm of six joints has up to 16 branches."""

SEED = 13

SPREAD = 2.0
"""The further starts reach from the posture to this far from it in every joint, evenly [rad or m]."""

LIMIT_ZONE, NARROWEST_ZONE, WIDEST_ZONE = 0.5, 1e-3, 3.0
"""Width of the zone beside a position limit, as a share of the joint's range: a narrow one brakes hard in it. At least,
so that a joint whose limits coincide does not divide by 0, and at most, also with one limit only [rad or m]."""

LIMIT_PUSH = 20.0
"""What h adds at a limit [rad or m]: many times any distance to a reference, so that limits win over nearness."""

MULTI_STARTS = 400
"""Seeded random starts: each of up to 16 branches is then found many times."""

BRANCH_SEED = 20

SAME_BRANCH = 1e-6
"""Joint positions closer than this, whole turns aside, are one branch [rad or m]."""

FEWEST_JOINTS = 3
"""Of an arm with a shoulder and a wrist."""

PARALLEL = 1e-9
"""Sine of the angle between axes below which they are parallel."""

CLEARLY = 1e-6
"""Distance that no rounding makes [m]: a grasp nearer than this to what an arm reaches is left to the search."""

OUT_OF_REACH = "out of reach"

_NO_REACH = (OUT_OF_REACH, "cannot reach its grasp", "its tip came no nearer than {0:.3g} m and {1:.3g} rad.")
_MOVED = "Choose another posture, from which another branch may reach it, or move the path, the base or the grasp."
_PAST = (
    "past a position limit",
    "passes a position limit",
    "joint '{joint}' would be at {0:.6g}, its limits are [{lower:g}, {upper:g}].{hint}",
)
_OTHER = "Choose another posture, path, base or grasp."
_TRIED = f" {1 + FURTHER_STARTS} starts were tried."

WORDINGS = {
    tracking.NO_START: (*_NO_REACH, _MOVED + _TRIED),
    tracking.START_PAST: (*_PAST, _OTHER + _TRIED),
    tracking.OUT_OF_REACH: (*_NO_REACH, _MOVED),
    tracking.PAST_LIMIT: (*_PAST, _OTHER),
    tracking.LEFT_LIMITS: (*_PAST, _OTHER),
    tracking.LOST: (
        "off their path",
        "loses its branch",
        "a joint is {0:.3g} (rad or m) from where its velocity led.",
        "Use more samples, or keep away from the singularity near there.",
    ),
    tracking.FOLDED: (
        "off their path",
        "loses its branch",
        "of all joint positions that hold the grasp, those near its start and away from its limits end there.",
        "Choose another posture, or a path that keeps nearer to the start.",
    ),
    tracking.SINGULAR: (
        "singular",
        "is singular",
        f"the condition number of its Jacobian is {{0:.3g}}, the limit is {CONDITION_LIMIT:.0e}.",
        "Keep the arm away from full stretch, full fold and aligned axes: move the path, the base or the grasp.",
    ),
}
"""By outcome: its kind, what the arm does, why, and what to do; one that is followed, or passed over, has none."""


@dataclass(frozen=True)
class TrackingFailure:
    """Why an arm cannot follow; its kind is a phrase that others share: "out of reach"."""

    kind: str
    message: str


def tracking_failure(
    code: int, robot: Robot, time: Array, sample: int, amounts: Sequence[float], joint: int = 0
) -> TrackingFailure:
    """What an outcome says."""
    kind, does, why, advice = WORDINGS[code]
    degrees = robot.joint_types[joint] == "revolute" and abs(amounts[0]) > DEGREES_SUSPECTED
    why = why.format(
        *amounts,
        joint=robot.joints[joint],
        lower=robot.position_lower[joint],
        upper=robot.position_upper[joint],
        hint=" If these are degrees: positions are in rad." if degrees else "",
    )
    at = f"sample {sample} (t = {time[sample]:.6g} s)"
    return TrackingFailure(kind, f"robot '{robot.name}' {does} at {at}: {why} {advice}")


@dataclass(frozen=True)
class TrackedVariants:
    """What became of V variants.

    Attributes:
        robots: Their arms.
        time: Shape (V, N) [s].
        q: Shape (V, N, m) [rad or m], inside the limits where whole turns do it; likewise `dq` and `ddq`. Of an arm
            that fails, what was found before.
        dq: q'.
        ddq: q''.
        outcome: How each ends for each arm, Shape (V, n) of `mrts.kernel.tracking.OUTCOME`.
        reasons: By variant, why it cannot follow, where that is known without a search.
    """

    robots: tuple[Robot, ...]
    time: Array
    q: Array
    dq: Array
    ddq: Array
    outcome: NDArray[np.void]
    reasons: dict[int, str]

    @property
    def followed(self) -> NDArray[np.bool_]:
        """Variants that all arms followed, Shape (V,)."""
        return np.asarray((self.outcome["code"] == tracking.FOLLOWED).all(axis=1))

    def of_arm(self, variant: int, arm: int) -> TrackingFailure | None:
        """Why an arm of a variant cannot follow; None if it does."""
        code, sample, joint, _, amounts = self.outcome[variant, arm].tolist()
        if code not in WORDINGS:
            return None
        return tracking_failure(code, self.robots[arm], self.time[variant], sample, amounts, joint)

    def failure(self, variant: int) -> TrackingFailure | None:
        """Why a variant cannot follow: of the first arm that ends on the way, or else passes a limit."""
        if variant in self.reasons:
            return TrackingFailure(OUT_OF_REACH, self.reasons[variant])
        codes = dict(enumerate(self.outcome[variant]["code"].tolist()))
        ends = [arm for arm, code in codes.items() if code != tracking.FOLLOWED]
        on_the_way = [arm for arm in ends if codes[arm] != tracking.PAST_LIMIT]
        return self.of_arm(variant, (on_the_way or ends)[0]) if ends else None


def is_redundant(cell: Cell, robot: Robot) -> bool:
    """Whether an arm has more joints than its wrench has components."""
    return len(robot.joints) > len(cell.wrench_components)


@lru_cache(maxsize=KNOWN_CELLS)
def tracking_rule(cell: Cell) -> Any:
    """How the arms of a cell hold their grasps and follow, as C reads it."""
    lower, upper = map(cell.stacked, ("position_lower", "position_upper"))
    zone = np.clip(LIMIT_ZONE * (upper - lower), NARROWEST_ZONE, WIDEST_ZONE)
    return filled(
        tracking.TRACKING,
        start_steps=STARTING_STEPS,
        further_steps=FURTHER_STEPS,
        steps=TRACKING_STEPS,
        reached=POSE_TOLERANCE,
        condition=CONDITION_LIMIT,
        drift=SETTLED_PREFERENCE,
        past=POSITION_TOLERANCE,
        components=tuple(cell.wrench_rows),
        wish=filled(tracking.PREFERENCE, lower=lower, upper=upper, zone=zone, push=LIMIT_PUSH),
        turns=cell.stacked("turns"),
        geometry=cell.geometry,
    )


def solve_grasps(
    cell: Cell,
    motion: ObjectMotion,
    samples: NDArray[np.intp] | slice,
    start: Array,
    steps: int,
    *,
    near: Array | None = None,
    rates: tuple[Array | None, Array | None] = (None, None),
) -> tuple[Array, Array, Array, Array]:
    """Damped Newton steps (Sugihara 2011) at samples, one for each of T sets of joints to start from, or one for all.

    Args:
        start: Shape (T, m) [rad or m].
        near: Positions that redundant arms stay near, Shape (m,); None moves them no further than needed.
        rates: q' and q'', Shape (T, m), which are moved in place to the nearest that keep the grasps; None for none. A
            direction that a singular arm has lost is left as it was.

    Returns:
        Joint positions with the smallest errors met, of those without the most settled in the null space, Shape (T, m)
        [rad or m]; errors of position [m] and of rotation [rad], and the step still to go in the null space, zero for
        an arm that has none [rad or m], Shape (T, n) each.
    """
    library, count = cell.library, len(start)
    given = {name: getattr(motion, name)[samples] for name in PATH if name != "time"}
    shapes = {name: PATH[name] for name in given} | {"reference": start.shape[1:]}
    places, strides = tracking.strided(count, shapes, given | {"reference": start if near is None else near[None]})
    if near is None:
        places[-1] = None
    q = np.array(start, dtype=np.float64, order="C")
    gap, turn, drift = np.zeros((3, count, library.robots))
    library.following.mrts_hold(count, tracking_rule(cell), steps, places, strides, q, *rates, gap, turn, drift)
    return q, gap, turn, drift


def reached(gap: Array, turn: Array) -> NDArray[np.bool_]:
    """Which arms hold their grasps, by errors of position and rotation, Shape (T, n) each."""
    found: NDArray[np.bool_] = np.maximum(gap, turn) <= POSE_TOLERANCE
    return found


def joints_on_grasps(cell: Cell, target: ObjectMotion, q: Array, dq: Array, ddq: Array) -> tuple[Array, Array, Array]:
    """Joints on the grasps near the given ones, with the rates nearest to theirs that keep them there, Shape (N, m).

    Raises:
        MotionError: If an arm does not reach its grasp from there; names robot and sample.
    """
    rates = np.array(dq, order="C"), np.array(ddq, order="C")
    held, gap, turn, _ = solve_grasps(cell, target, slice(None), q, TRACKING_STEPS, rates=rates)
    if not reached(gap, turn).all():
        sample, arm = map(int, np.unravel_index(int(np.argmax(np.maximum(gap, turn))), gap.shape))
        amounts = [float(gap[sample, arm]), float(turn[sample, arm])]
        failure = tracking_failure(tracking.OUT_OF_REACH, cell.robots[arm], target.time, sample, amounts)
        raise MotionError(failure.message)
    return held, *rates


def nearest_rates(
    cell: Cell, target: ObjectMotion, samples: NDArray[np.intp], q: Array, dq: Array, ddq: Array
) -> tuple[Array, Array]:
    """Velocities and accelerations nearest to the given ones that keep the tips on the grasps at some samples.

    All are Shape (k, m). The positions are on the grasps. A direction that a singular arm has lost is left as given.
    """
    rates = np.array(dq, order="C"), np.array(ddq, order="C")
    solve_grasps(cell, target, samples, q, 0, rates=rates)
    return rates


def check_regular(cell: Cell, time: Array, q: Array) -> None:
    """Check that no arm is singular along a motion, Shape (N, m).

    Raises:
        MotionError: Names robot and sample.
    """
    jacobians = cell.functions("kinematics", len(q), {"q": q})["jacobian"]
    for robot, joints in zip(cell.robots, cell.joint_slices.values(), strict=True):
        condition = np.linalg.cond(jacobians[:, :, joints])
        if not np.all(condition < CONDITION_LIMIT):
            worst = int(np.argmax(condition))
            amounts = condition[[worst]].tolist()
            raise MotionError(tracking_failure(tracking.SINGULAR, robot, time, worst, amounts).message)


def follow_from(cell: Cell, motion: ObjectMotion, start: Array) -> TrackedVariants:
    """Follow the grasps along a motion from V positions that hold them, Shape (V, m), each branch by continuity."""
    path = {name: getattr(motion, name)[None] for name in PATH}
    given = {**path, "geometry": cell.geometry[None], "posture": start}
    none = np.zeros(len(start), dtype=bool)
    found = follow_variants(cell.library, tracking_rule(cell), none, given, held=True)
    time = np.broadcast_to(path["time"], (len(start), len(motion.time)))
    return TrackedVariants(cell.robots, time, *found, {})


def track_variants(
    cell: Cell, path: Mapping[str, Array], geometry: Array, posture: Array, refused: NDArray[np.bool_]
) -> TrackedVariants:
    """Start and follow V variants of one cell along their motions.

    Where an arm cannot reach its grasp at t = 0 from its posture, or only past its limits, further starts are tried. Of
    what they lead to inside the limits the arm takes the nearest to its posture.

    Args:
        cell: One of them; its chains, limits of positions and components are those of all.
        path: Of the object: `mrts.kernel.tracking.PATH` with V, or 1 where all share one, and N before each shape.
        posture: Of all joints, Shape (V or 1, m) [rad or m].
        refused: Variants that are passed over, Shape (V,); they end as `REFUSED`.
    """
    library, rule = cell.library, tracking_rule(cell)
    given, passed = {**path, "geometry": geometry, "posture": posture}, refused.copy()
    if len(refused) > 1:  # one is searched in less time
        passed[list(_out_of_reach(cell, path, geometry, np.flatnonzero(~refused), slice(1)))] = True
    found = follow_variants(library, rule, passed, given)
    time = np.broadcast_to(path["time"], (len(refused), path["time"].shape[1]))
    tracked = TrackedVariants(cell.robots, time, *found, {})
    failed = (~refused & ~tracked.followed).nonzero()[0]
    if not failed.size:
        return tracked
    tracked.reasons.update(_out_of_reach(cell, path, geometry, failed))
    code = tracked.outcome["code"]
    may_start = np.any((code == tracking.NO_START) | (code == tracking.START_PAST), axis=1)
    may_start[list(tracked.reasons)] = False
    again = np.flatnonzero(may_start)
    if again.size:
        some = {name: _some(value, again) for name, value in given.items()}
        parts = zip(cell.robots, cell.joint_slices.values(), strict=True)
        further = [further_starts(robot, some["posture"][:, own]) for robot, own in parts]
        some["further"] = np.concatenate(further, axis=2)
        retried = follow_variants(library, rule, np.zeros(len(again), dtype=bool), some)
        for whole, part in zip(found, retried, strict=True):
            whole[again] = part
    return tracked


def _out_of_reach(
    cell: Cell, path: Mapping[str, Array], geometry: Array, chosen: NDArray[np.intp], samples: slice = slice(None)
) -> dict[int, str]:
    """Of some variants those whose links are too short at some samples: why, of the first such arm."""
    parts = (_some(path[name], chosen)[:, samples] for name in ("time", "position", "rotation"))
    time, position, rotation = (part.swapaxes(0, 1) for part in parts)
    geometry, reasons = _some(geometry, chosen), dict[int, str]()
    for index, robot in enumerate(cell.robots):
        if (reach := arm_reach(robot)) is None:
            continue
        (shoulder, wrist, longest), of = reach, geometry[:, GRAVITY_SIZE + ROBOT_SIZE * index :]
        base, tip = of[:, :9].reshape(-1, 3, 3), of[:, 12:21].reshape(-1, 3, 3)
        held = position + (rotation @ (of[:, 21:24] + tip @ wrist)[..., None])[..., 0]
        distance = np.linalg.norm(held - of[:, 9:12] - base @ shoulder, axis=-1)
        times, distances = (np.broadcast_to(part, (len(part), len(chosen))).T for part in (time, distance))
        for place in np.flatnonzero((distances > longest + CLEARLY).any(axis=1)).tolist():
            sample = int(np.argmax(distances[place]))
            far, at = float(distances[place, sample]), f"sample {sample} (t = {times[place, sample]:.6g} s)"
            why = (
                f"robot '{robot.name}' cannot reach its grasp at {at}: its wrist would be {far:.6g} m from its "
                f"shoulder and reaches {longest:.6g} m: {far - longest:.3g} m too far. Move the path, the base or "
                "the grasp."
            )
            reasons.setdefault(int(chosen[place]), why)
    return reasons


def further_starts(robot: Robot, posture: Array) -> Array:
    """Where the search goes on from where an arm's posture leads to nothing, Shape (…, FURTHER_STARTS, n_i).

    Always the same: the middle of its limits, and random ones farther and farther from the posture, Shape (…, n_i).
    """
    low, high = robot.position_lower, robot.position_upper
    steps = np.linspace(0, SPREAD, FURTHER_STARTS)[:, None]
    turns = np.random.default_rng(SEED).uniform(-1, 1, (FURTHER_STARTS, len(robot.joints)))
    starts: Array = np.clip(posture[..., None, :] + steps * turns, low, high)
    limited = np.isfinite(low) & np.isfinite(high)
    starts[..., 0, limited] = (low[limited] + high[limited]) / 2
    return starts


def _some(values: Array, variants: NDArray[np.intp]) -> Array:
    """What some variants have of values with V or 1 first."""
    return values if len(values) == 1 else values[variants]


def nearest_turns(robot: Robot, q: Array, posture: Array) -> Array:
    """Joint positions with whole turns added to come nearest to a posture, each Shape (…, n_i) [rad or m]."""
    return np.where(robot.turns, posture + (q - posture + np.pi) % (2 * np.pi) - np.pi, q)


def _turned_inside(robot: Robot, q: Array) -> Array:
    """Joint positions with whole turns added that bring them inside their limits, Shape (n_i,), where some do."""
    turns = np.ceil((robot.position_lower - q) / (2 * np.pi) - POSITION_TOLERANCE).clip(min=0)
    turns -= np.ceil((q - robot.position_upper) / (2 * np.pi) - POSITION_TOLERANCE).clip(min=0)
    moved = q + np.where(robot.turns, 2 * np.pi * turns, 0.0)
    return np.where(_outside(robot, moved) <= POSITION_TOLERANCE, moved, q)


def _outside(robot: Robot, q: Array) -> Array:
    """How far joint positions, Shape (…, n_i), are beyond a limit, negative inside."""
    return np.maximum(robot.position_lower - q, q - robot.position_upper)


def check_joint_limits(cell: Cell, time: Array, q: Array, tolerance: float = POSITION_TOLERANCE) -> None:
    """Check the position limits of all joints along a motion, Shape (N, m), passed by a tolerance at most [rad or m].

    Raises:
        MotionError: Names robot, joint, the first such sample, value and limits.
    """
    for robot in cell.robots:
        own = q[:, cell.joint_slices[robot.name]]
        beyond = _outside(robot, own) > tolerance
        if np.any(beyond):
            sample = int(np.argmax(np.any(beyond, axis=1)))
            joint = int(np.argmax(beyond[sample]))
            at = [float(own[sample, joint])]
            raise MotionError(tracking_failure(tracking.PAST_LIMIT, robot, time, sample, at, joint).message)


def branches_at_start(cell: Cell, index: int, motion: ObjectMotion, starts: int = MULTI_STARTS) -> Array:
    """Joint positions of one arm that hold its grasp at t = 0 inside its limits, each branch once, Shape (k, n_i)."""
    robot = cell.robots[index]
    joints = cell.joint_slices[robot.name]
    redundant = is_redundant(cell, robot)
    start = np.tile(cell.posture, (starts, 1))
    start[:, joints] = random_starts(robot, starts)
    reference = np.clip(cell.posture, *map(cell.stacked, ("position_lower", "position_upper")))
    held, gap, turn, drift = solve_grasps(cell, motion, slice(1), start, STARTING_STEPS, near=reference)
    settled = reached(gap, turn) & (drift <= SETTLED_PREFERENCE)
    distinct: list[Array] = []
    for candidate in held[settled[:, index]][:, joints]:
        # a redundant arm has settled where its null space points, whole turns and all
        near = candidate if redundant else nearest_turns(robot, candidate, robot.posture)
        near = _turned_inside(robot, near)
        inside = np.all(_outside(robot, near) <= POSITION_TOLERANCE)
        apart = (nearest_turns(robot, near, other) - other for other in distinct)
        if inside and not any(np.max(np.abs(off)) < SAME_BRANCH for off in apart):
            distinct.append(near)
    return np.array(distinct).reshape(-1, len(robot.joints))


def random_starts(robot: Robot, count: int, seed: int = BRANCH_SEED) -> Array:
    """Joint positions of an arm, within half a turn (or pi m) and its limits, its posture first, Shape (count, n_i)."""
    rng = np.random.default_rng(seed)
    low, high = (np.clip(end, robot.position_lower, robot.position_upper) for end in (-np.pi, np.pi))
    starts = rng.uniform(low, high, (count, len(robot.joints)))
    starts[0] = robot.posture
    return starts


def arm_reach(robot: Robot) -> tuple[Array, Array, float] | None:
    """Shoulder in the base frame and wrist in the tip frame, each Shape (3,) [m], and how far they may be apart [m].

    The shoulder, where the second axis is nearest to the first, goes around the first axis; the wrist, where the last
    axis but one is nearest to the last, goes around the last one, which the grasp holds. Between them lie links of
    fixed length. Past axes that are parallel, a point keeps its place along them, and across them comes no further than
    the links reach. None for an arm with few joints, or with prismatic ones.
    """
    if len(robot.joints) < FEWEST_JOINTS or set(robot.joint_types) != {"revolute"}:
        return None
    axes, points = robot.axes, robot.points
    shoulder, first = _nearest(axes[1], points[1], axes[0], points[0])
    wrist, last = _nearest(axes[-2], points[-2], axes[-1], points[-1])
    longest = float(np.linalg.norm(shoulder - first) + np.linalg.norm(wrist - last))
    at, joint, end = shoulder, 1, len(axes) - 2
    while joint < end:
        along, start, across = axes[joint], at, 0.0
        while joint + 1 < end and np.linalg.norm(np.cross(axes[joint + 1], along)) <= PARALLEL:
            across += float(np.linalg.norm(np.cross(points[joint + 1] - at, along)))
            at, joint = points[joint + 1], joint + 1
        to = wrist if joint + 1 == end else _nearest(axes[joint + 1], points[joint + 1], along, at)[0]
        across += float(np.linalg.norm(np.cross(to - at, along)))
        longest += float(np.hypot(across, (to - start) @ along))
        at, joint = to, joint + 1
    longest += float(np.linalg.norm(wrist - at))  # of three joints, along the axis between
    tip = robot.T_base_tip
    return first, tip.R.T @ (last - tip.p), longest


def _nearest(axis: Array, point: Array, other: Array, through: Array) -> tuple[Array, Array]:
    """The points of two lines that are nearest to each other; of parallel ones any such pair."""
    across = np.cross(axis, other)
    square = float(across @ across)
    if square <= PARALLEL**2:
        return point, through + ((point - through) @ other) * other
    along = np.cross(through - point, other) @ across / square
    nearest = point + along * axis
    return nearest, through + ((nearest - through) @ other) * other
