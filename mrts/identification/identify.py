# SPDX-License-Identifier: MIT
"""Armature and friction of an arm's motors from a recording of its free motion: numbers with their confidence.

Positions and efforts go through one filter, a Butterworth low pass of second order run forwards and backwards: it is
flat far below its cutoff, where arms move, delays nothing, and forgets within a period of its cutoff. Effort must not
keep what positions have lost: filtered alike, both sides of an equation that is linear in them stay equal. Velocities
and accelerations are those of the quintic spline through the smoothed positions.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from textwrap import indent
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array, freeze
from mrts.base.errors import InputError, Remark, check_type, is_number, printable
from mrts.base.version import __version__
from mrts.base.words import first_names
from mrts.base.yaml_text import yaml_text
from mrts.cell.cell import Cell
from mrts.cell.robot import DEGREES_SUSPECTED, Robot
from mrts.following.joint_columns import MOST_NAMED, columns_by_joint, required_columns
from mrts.motion.joint_recording import JointRecording, RecordedJoint, load_recording

DEFAULT_CUTOFF = 20.0
"""Of the filter [Hz]: ten times what large arms move at, far below where counted positions have their noise."""

SLOW_SAMPLING = 10.0
"""Samples in a period of the default cutoff: it is lower than `DEFAULT_CUTOFF` where there would be fewer."""

FEWEST_SAMPLES = 5.0
"""Samples in a period of a cutoff that is asked for: with fewer the filter takes away next to nothing."""

ORDER = 2
"""Of the filter, run twice: with more it would ring."""

FORGOTTEN = 1.0
"""Periods of the cutoff after which the filter has forgotten a sample but for 1 %."""

ENDS = 4.0
"""Periods of the cutoff at both ends of a recording, where the filter has to guess what was before and after."""

FEWEST_BLOCKS = 20
"""Blocks of a recording: with fewer, nothing can be said of four numbers and how sure they are."""

SLOWEST = 0.01
"""Speeds below this are not known to be a motion [rad/s or m/s]: elastic arms creep where friction holds them."""

SLOW_SHARE = 0.05
"""Share of a joint's fastest speed below which its friction is not the one modelled: it sticks, and grows when slow."""

NOISE_MULTIPLE = 4.0
"""Speeds below this many times the noise of the speed may have either sign."""

UNEVEN = 1e-3
"""Share of a step by which times of even samples may be off: stamps are rounded."""

LONGEST_GAP = 0.25
"""Periods of the cutoff between two samples that are still bridged: what happens in longer ones is not known."""

DEGREE = 5
"""Of the spline through smoothed positions."""

CONFIDENCE = 0.95
"""Of the intervals."""

INDEPENDENT = 0.01
"""Share of a column that the other columns must leave, or the motion does not tell its parameter from theirs."""

NO_SIZE = 1e-12
"""Of a singular value, as a share of the largest: rounding of 0."""

REFERENCE_RAMP = 0.1
"""Time to the joint's fastest speed [s] that gives the largest acceleration to speak of."""

UNCERTAIN = 0.05
"""Share of the torque limit by which half an interval may put the torque in doubt, at the fastest the joint can do."""

BANDWIDTH = 0.5
"""Lags that carry the covariance of residuals, by the root of the number of blocks: with fewer, intervals are too
narrow where residuals follow each other; more do not help with some hundred blocks."""

EXPLAINED = 0.5
"""Share of an effort's variance that model and motors explain at least, or something is wrong with either."""


NOISY = 0.01
"""Share of a joint's squared accelerations that may be noise: its inertia is too small by as much."""


DIGITS = 5
"""Significant digits in the YAML: more than any recording tells."""

UNITS = {
    "armature": ("kg m²", "kg"),
    "coulomb": ("N m", "N"),
    "viscous": ("N m s/rad", "N s/m"),
}
"""Of a parameter, for a revolute and for a prismatic joint, in the order of the columns of the regression; an offset of
the effort follows, which no motor has."""


@dataclass(frozen=True, eq=False)
class RecordedMotion:
    """What was recorded of one arm, smoothed: means of B blocks.

    A block is a period of the cutoff, beyond which the filter does not tie samples to each other.

    Attributes:
        cutoff: Of the filter [Hz].
        time: Shape (B,) [s] from 0.
        used: Which blocks count, as the sign of the velocity is known, as far back and ahead as the filter reaches,
            Shape (B, n).
        velocity: Shape (B, n) [rad/s or m/s].
        acceleration: Shape (B, n) [rad/s² or m/s²].
        sign: Sign of the velocity, filtered like the effort, Shape (B, n).
        effort: Shape (B, n) [N m or N].
        left_over: Effort without the torque of the rigid bodies, Shape (B, n) [N m or N].
        speed_noise: Standard deviation of what noise of the positions leaves in velocities, Shape (n,) [rad/s or m/s].
    """

    cutoff: float
    time: Array
    used: NDArray[np.bool_]
    velocity: Array
    acceleration: Array
    sign: Array
    effort: Array
    left_over: Array
    speed_noise: Array

    def __post_init__(self) -> None:
        freeze(self)


@dataclass(frozen=True, eq=False)
class ArmMotors:
    """The motors of one arm, joint side of their gears, and what they leave unexplained.

    The first four are by parameter: "armature" (rotor inertia by the square of the gear ratio [kg m² or kg]), "coulomb"
    (dry friction [N m or N]) and "viscous" (friction by speed [N m s/rad or N s/m]).

    Attributes:
        robot: The arm.
        motion: What was recorded of it, in blocks.
        value: Shape (n,), 0 where it is not identified.
        half_width: Half the interval of 95 % confidence, Shape (n,), infinity where it is not identified.
        reasons: Why the motion does not show it, "" where it does, Shape (n,).
        bounded: Whether it is 0 because it must not be negative, Shape (n,).
        offset: Constant part of the effort, which no motor has: a sensor's zero, a load that the model lacks,
            Shape (n,) [N m or N].
        residual_rms: Of what was not explained, means of blocks, Shape (n,) [N m or N].
        explained: Share of the effort's variance that model and motors explain, Shape (n,).
        fitted: What the motors say of what the rigid bodies leave over, Shape (B, n) [N m or N].
    """

    robot: Robot
    motion: RecordedMotion
    value: dict[str, Array]
    half_width: dict[str, Array]
    reasons: dict[str, NDArray[np.str_]]
    bounded: dict[str, NDArray[np.bool_]]
    offset: Array
    residual_rms: Array
    explained: Array
    fitted: Array

    def __post_init__(self) -> None:
        freeze(self)


@dataclass(frozen=True, eq=False, repr=False)
class MotorIdentification:
    """What `identify` found.

    Attributes:
        cell: Name of the cell.
        recording: The file.
        arms: The arms that were recorded.
        remarks: What to know of it.
    """

    cell: str
    recording: Path
    arms: tuple[ArmMotors, ...]
    remarks: tuple[Remark, ...]

    def __repr__(self) -> str:
        return f"<MotorIdentification of {self.cell}: {', '.join(arm.robot.name for arm in self.arms)}>"

    @property
    def empty(self) -> bool:
        """Whether no parameter is identified of all joints of an arm, so that nothing can be written."""
        return not any(np.all(why == "") for arm in self.arms for why in arm.reasons.values())

    def sentence(self) -> str:
        """The outcome in one line."""
        reasons = np.concatenate([why for arm in self.arms for why in arm.reasons.values()])
        arms = ", ".join(arm.robot.name for arm in self.arms)
        return f"{np.count_nonzero(reasons == '')} of {reasons.size} parameters of the motors of {arms} identified"

    def to_yaml(self) -> str:
        """The `motors` block of each recorded robot, as it stands in a cell file, with what is known of its numbers.

        A parameter that the motion does not show of every joint is left out, and a comment says why.
        """
        lines = [
            f"# Found by mrts {__version__} for cell {printable(self.cell)} from {printable(self.recording.name)}.",
            "# Put each `motors` block under its robot in the cell file. ± is half an interval of 95 % confidence.",
            "robots:",
        ]
        for arm in self.arms:
            lines += [f"  - name: {arm.robot.name}", *_block(arm)]
        return "\n".join(lines) + "\n"


def identify(cell: Cell, recording: JointRecording | Path | str, *, cutoff: float | None = None) -> MotorIdentification:
    """Find armature, Coulomb and viscous friction of every joint from a recording of the arms' free motion.

    The arms move without the object, and nothing touches them. What the torque of the rigid bodies leaves of the
    measured effort is fitted by bounded least squares, joint by joint:

        effort - τ_rb(q, q̇, q̈) = I_a q̈ + b q̇ + τ_c sign(q̇) + offset,  I_a, b, τ_c >= 0

    Where a joint is so slow that its sign of travel is not known, nothing is asked of it. `motors` that the cell has
    already are not used.

    Args:
        cell: The cell; of its arms, links and gravity are used.
        recording: What was measured, or the file: `mrts.load_recording`. All arms, or some.
        cutoff: Of the filter [Hz]; None takes 20 Hz, or less where samples are too few.

    Raises:
        InputError: If the recording lacks a joint of an arm or its effort, is too short, or nothing moves in it.
    """
    check_type("cell", cell, Cell)
    if cutoff is not None and (not is_number(cutoff, 0) or cutoff == 0):
        raise InputError("cutoff", "must be a number > 0, in Hz.", value=cutoff)
    if not isinstance(recording, JointRecording):
        recording = load_recording(recording)
    found = _recorded_arms(cell, recording)
    remarks: list[Remark] = []
    arms = []
    for robot, joints in found:
        motion = smoothed_motion(cell, robot, recording.path, joints, cutoff)
        _check_units(recording, robot, joints, motion)
        arms.append(_identify_arm(robot, motion))
        remarks += _remarks(arms[-1])
    if not any(np.any(arm.motion.used) for arm in arms):
        raise InputError(
            recording.path,
            "nothing moves in this recording faster than what rest looks like: record a motion that turns every joint "
            "to and fro.",
        )
    if missing := [robot.name for robot in cell.robots if robot not in [robot for robot, _ in found]]:
        remarks.append(Remark("not-recorded", f"the recording says nothing of {', '.join(missing)}."))
    return MotorIdentification(cell.name, recording.path, tuple(arms), tuple(remarks))


def _recorded_arms(cell: Cell, recording: JointRecording) -> list[tuple[Robot, list[RecordedJoint]]]:
    columns, arms = [*recording.joints, *recording.unusable], []
    found = columns_by_joint(cell, recording.path, columns)
    for robot in cell.robots:
        if any(f"{robot.name}/{joint}" in found for joint in robot.joints):
            own, _ = required_columns(cell, [robot], recording.path, recording.joints, recording.unusable)
            arms.append((robot, [recording.joints[name] for name in own]))
    if not arms:
        names, first = first_names(sorted(columns), MOST_NAMED), f"{cell.robots[0].name}/{cell.robots[0].joints[0]}"
        raise InputError(
            recording.path,
            f"no arm of cell '{cell.name}' has joints of these names: {names}. Names are ROBOT/JOINT as in the cell "
            f"file and its URDF, such as '{first}'; in a bag, ROBOT is the first name of the topic.",
        )
    return arms


def _check_units(recording: JointRecording, robot: Robot, joints: list[RecordedJoint], motion: RecordedMotion) -> None:
    """Refuse positions in degrees, beyond two turns and limits, and an effort that stays while its joint moves."""
    limits = np.maximum(np.abs(robot.position_lower), np.abs(robot.position_upper))
    for place, (name, joint) in enumerate(zip(robot.joints, joints, strict=True)):
        furthest = float(np.max(np.abs(joint.position)))
        if robot.position_units[place] == "rad" and furthest > max(limits[place], DEGREES_SUSPECTED):
            raise InputError(
                recording.path,
                f"is more than two turns and its limit, {limits[place]:.4g}: positions are in rad, are these degrees?",
                key=f"position of {robot.name}/{name}",
                value=furthest,
            )
        if np.ptp(joint.effort) == 0 and np.any(motion.used[:, place]):
            raise InputError(
                recording.path,
                "is constant although the joint moves: no effort was measured.",
                key=f"effort of {robot.name}/{name}",
                value=float(joint.effort[0]),
            )


def smoothed_motion(
    cell: Cell, robot: Robot, path: Path, joints: list[RecordedJoint], cutoff: float | None
) -> RecordedMotion:
    """The recorded motion of one arm.

    Args:
        cell: The cell.
        robot: The arm.
        path: Of the recording, for messages.
        joints: What was recorded of its joints, base to tip.
        cutoff: Of the filter [Hz]; None takes `DEFAULT_CUTOFF`, or less where samples are too few.

    Raises:
        InputError: If the recording is too short, or the cutoff too high for it.
    """
    from scipy.interpolate import make_interp_spline  # noqa: PLC0415 (slow to import)
    from scipy.ndimage import minimum_filter1d  # noqa: PLC0415 (likewise)
    from scipy.signal import butter, sosfiltfilt  # noqa: PLC0415 (likewise)

    start, end = max(joint.time[0] for joint in joints), min(joint.time[-1] for joint in joints)
    step = max(float(np.median(np.diff(joint.time))) for joint in joints)
    rate = 1 / step
    if cutoff is None:
        cutoff = min(DEFAULT_CUTOFF, rate / SLOW_SAMPLING)
    elif cutoff > rate / FEWEST_SAMPLES:
        rule = f"must be at most {rate / FEWEST_SAMPLES:.4g} Hz: the recording has {rate:.4g} samples a second."
        raise InputError("cutoff", rule, value=cutoff)
    count = int(np.floor((end - start) / step * (1 + UNEVEN))) + 1
    if count < (FEWEST_BLOCKS + 2 * ENDS) * round(rate / cutoff):
        least = (FEWEST_BLOCKS + 2 * ENDS) / cutoff
        raise InputError(
            path,
            f"holds all joints of robot '{robot.name}' for {max(end - start, 0.0):.3g} s; the filter of {cutoff:.4g} Hz"
            f" needs at least {least:.3g} s, a good identification 20 s or more.",
        )
    time = start + step * np.arange(count)
    position, effort, gap = np.empty((3, count, len(joints)))
    for place, (joint, unit) in enumerate(zip(joints, robot.position_units, strict=True)):
        turned = np.unwrap(joint.position) if unit == "rad" else joint.position  # encoders leap from π to -π
        within = np.clip(time, joint.time[0], joint.time[-1])
        position[:, place] = make_interp_spline(joint.time, turned, k=3)(within)
        effort[:, place] = np.interp(within, joint.time, joint.effort)
        after = np.clip(np.searchsorted(joint.time, time), 1, len(joint.time) - 1)
        gap[:, place] = joint.time[after] - joint.time[after - 1]
    low_pass = butter(ORDER, cutoff, fs=rate, output="sos")
    q = sosfiltfilt(low_pass, position, axis=0)
    spline = make_interp_spline(time - start, q, k=DEGREE)
    dq, ddq = (np.asarray(spline(time - start, order), dtype=np.float64) for order in (1, 2))
    # 2π f_c √(2 f_c / 3 f_s) times white noise of the positions
    speed_noise = 2 * np.pi * cutoff * np.sqrt(2 * cutoff / (3 * rate)) * np.std(position - q, axis=0)
    fastest = np.max(np.abs(dq), axis=0)
    slow = np.abs(dq) <= np.maximum(np.maximum(SLOW_SHARE * fastest, NOISE_MULTIPLE * speed_noise), SLOWEST)
    sure = ~slow & (gap <= LONGEST_GAP / cutoff)
    ends, reach = (int(np.ceil(periods * rate / cutoff)) for periods in (ENDS, FORGOTTEN))
    sure[:ends], sure[-ends:] = False, False
    known = minimum_filter1d(sure.astype(np.float64), 2 * reach + 1, axis=0, mode="nearest")
    sign, effort = (sosfiltfilt(low_pass, part, axis=0) for part in (np.sign(dq), effort))
    left_over = effort - _rigid_torque(cell, robot, q, dq, ddq)
    block = round(rate / cutoff)
    whole = count // block * block
    at, surely, velocity, acceleration, sign, effort, left_over = (
        part[:whole].reshape(-1, block, *part.shape[1:]).mean(axis=1)
        for part in (time - start, known, dq, ddq, sign, effort, left_over)
    )
    return RecordedMotion(cutoff, at, surely == 1, velocity, acceleration, sign, effort, left_over, speed_noise)


def _rigid_torque(cell: Cell, robot: Robot, q: Array, dq: Array, ddq: Array) -> Array:
    """Torque of the links alone along a motion, the other arms at rest, Shape (N, n) [N m or N]."""
    part, every = cell.joint_slices[robot.name], np.tile(cell.posture, (len(q), 1))
    moving, changing = np.zeros((2, *every.shape))
    every[:, part], moving[:, part], changing[:, part] = q, dq, ddq
    nothing = {"load": np.zeros_like(cell.load), "object_wrench": np.zeros(cell.library.wrenches)}  # is held
    motion = {"q": every, "dq": moving, "ddq": changing}
    return cell.functions("played_torques", len(q), motion | nothing)["torque"][:, part]


def _identify_arm(robot: Robot, motion: RecordedMotion) -> ArmMotors:
    limits = np.maximum(np.abs(robot.torque_lower), np.abs(robot.torque_upper))
    recorded = np.max(np.abs(motion.velocity), axis=0)
    fastest = np.where(np.isfinite(robot.velocity_limit), robot.velocity_limit, recorded)
    columns = np.stack([motion.acceleration, motion.sign, motion.velocity], axis=2)
    parts = [
        fit_joint(columns[:, place], left_over, used, float(fastest[place]), float(limits[place]))
        for place, (left_over, used) in enumerate(zip(motion.left_over.T, motion.used.T, strict=True))
    ]
    theta, half_width, reasons, held = map(np.array, zip(*parts, strict=True))
    known, used = reasons == "", motion.used
    fitted = np.einsum("bjk,jk->bj", columns, theta[:, :3]) + theta[:, 3]
    count = np.maximum(np.count_nonzero(used, axis=0), 1)
    mean = np.sum(np.where(used, motion.effort, 0.0), axis=0) / count
    offs = (motion.left_over - fitted, motion.effort - mean)
    left, variance = (np.sum(np.where(used, off, 0.0) ** 2, axis=0) / count for off in offs)
    by_parameter = np.where(known, theta[:, :3], 0.0), np.where(known, half_width, np.inf), reasons, held & known
    value, width, why, bounded = (dict(zip(UNITS, of.T, strict=True)) for of in by_parameter)
    explained = 1 - left / np.where(variance > 0, variance, np.inf)
    return ArmMotors(robot, motion, value, width, why, bounded, theta[:, 3], np.sqrt(left), explained, fitted)


def _remarks(arm: ArmMotors) -> Iterator[Remark]:
    """What to know of each joint of an arm.

    Least squares take accelerations for exact, so noisy ones leave too little inertia. The mean acceleration of a
    block is the difference of two velocities by the block's length.
    """
    for place, joint in enumerate(arm.robot.joints):
        name = f"{arm.robot.name}/{joint}"
        for kind, reasons in arm.reasons.items():
            if reasons[place]:
                yield Remark("not-excited", f"{kind} of '{name}' is not identified: {reasons[place]}.")
            if arm.bounded[kind][place]:
                yield Remark(
                    "bound-active",
                    f"{kind} of '{name}' is 0 ± {arm.half_width[kind][place]:.2g} because it cannot be negative: where "
                    "it should not be near 0, masses of the URDF or efforts are wrong.",
                )
        if arm.explained[place] < EXPLAINED:
            yield Remark(
                "unexplained-effort",
                f"only {100 * max(arm.explained[place], 0.0):.2g} % of the effort of '{name}' is explained: is it in "
                "N m (N) and not in A, on the joint side of the gear, was nothing in the hand, is the URDF that of "
                "this arm, and its zero?",
            )
        moving = arm.motion.acceleration[arm.motion.used[:, place], place]
        noise = 2 * (arm.motion.speed_noise[place] * arm.motion.cutoff) ** 2
        share = noise / np.mean(moving**2) if len(moving) and np.any(moving) else 0.0
        if share > NOISY:
            yield Remark(
                "noisy-positions",
                f"noise of the positions of '{name}' is {100 * share:.2g} % of its squared accelerations: its armature "
                "is too small by that share of the whole inertia that the joint turns. Lower the cutoff, or accelerate "
                "more.",
            )


def fit_joint(
    columns: Array, left_over: Array, used: NDArray[np.bool_], fastest: float, torque_limit: float
) -> tuple[Array, Array, NDArray[np.str_], NDArray[np.bool_]]:
    """Least squares of effort - τ_rb = I_a q̈ + τ_c sign(q̇) + b q̇ + offset, with I_a, τ_c, b >= 0.

    Variances come from the residuals: the larger of the two that ordinary least squares and Newey and West (1987)
    give, who let residuals depend on the motion and on each other along time (`used` says where blocks are missing).
    What is held at 0 has that of the fit without the bounds.

    Args:
        columns: q̈, sign(q̇), q̇ of B blocks along time, Shape (B, 3).
        left_over: effort - τ_rb, Shape (B,) [N m or N].
        used: Which blocks count, Shape (B,).
        fastest: Speed that the joint may have [rad/s or m/s].
        torque_limit: That it has [N m or N].

    Returns:
        I_a, τ_c, b and offset, Shape (4,); of the first three half their interval, why they are not identified, or "",
        and whether they are 0 because they must not be negative, Shape (3,) each.
    """
    from scipy.optimize import lsq_linear  # noqa: PLC0415 (slow to import)
    from scipy.special import stdtrit  # noqa: PLC0415 (likewise)

    full = np.column_stack([columns, np.ones(len(columns))])
    X, y = full[used], left_over[used]
    theta, half, held = np.zeros(4), np.full(3, np.inf), np.zeros(4, dtype=bool)
    reasons = np.full(3, "it hardly moves in the recording")
    if len(y) > X.shape[1]:
        scale = np.sqrt(np.mean(X**2, axis=0))
        scale[scale == 0] = 1.0
        X = X / scale
        _, sizes, V = np.linalg.svd(X, full_matrices=False)
        # what the others leave of a column is 1 by the length of its row of the pseudoinverse
        left = 1 / np.linalg.norm(V / np.maximum(sizes, NO_SIZE * sizes[0])[:, None], axis=0)
        independent = left > INDEPENDENT * np.sqrt(len(y))
        free = np.linalg.lstsq(X, y, rcond=INDEPENDENT**2)[0]
        bounded = lsq_linear(X, y, ([0.0, 0.0, 0.0, -np.inf], np.inf), method="bvls")
        theta, held = np.asarray(bounded.x, dtype=np.float64), np.asarray(bounded.active_mask != 0)
        error = _standard_errors(full / scale, left_over, used, theta, ~held)
        error[held] = _standard_errors(full / scale, left_over, used, free, np.ones(len(free), bool))[held]
        theta, error = theta / scale, error / scale
        half = float(stdtrit(len(y) - X.shape[1], (1 + CONFIDENCE) / 2)) * error[:3]
        doubt = half * np.array([fastest / REFERENCE_RAMP, 1.0, fastest])
        reasons = _reasons(columns[used], independent, doubt, torque_limit)
    return theta, half, reasons, held[:3]


def _standard_errors(
    full: Array, left_over: Array, used: NDArray[np.bool_], theta: Array, varied: NDArray[np.bool_]
) -> Array:
    """Of the parameters that are varied, 0 of the others, Shape (4,)."""
    X = np.where(used[:, None], full, 0.0)[:, varied]
    residual = np.where(used, left_over - full @ theta, 0.0)
    count = int(np.count_nonzero(used))
    freedom = count - X.shape[1]
    inverse = np.linalg.pinv(X.T @ X)
    ordinary = inverse * (residual @ residual) / freedom
    scores = X * residual[:, None]
    between = scores.T @ scores
    lags = int(BANDWIDTH * np.sqrt(count))
    for lag in range(1, lags + 1):
        crossed = scores[lag:].T @ scores[:-lag]
        between += (1 - lag / (lags + 1)) * (crossed + crossed.T)
    robust = inverse @ between @ inverse * count / freedom
    errors = np.zeros(len(varied))
    errors[varied] = np.sqrt(np.maximum(np.diag(ordinary), np.diag(robust)))
    return errors


def _reasons(columns: Array, independent: NDArray[np.bool_], doubt: Array, torque_limit: float) -> NDArray[np.str_]:
    one_way = np.min(columns[:, 1]) * np.max(columns[:, 1]) > 0
    reasons = []
    for place in range(3):
        if not independent[place]:
            told = "it moves one way only" if one_way else "it moves at one speed"
            reasons.append(told if place else "it hardly accelerates")
        elif doubt[place] > UNCERTAIN * torque_limit:
            share = 100 * doubt[place] / torque_limit
            reasons.append(f"the motion and its noise leave {share:.3g} % of the torque limit in doubt")
        else:
            reasons.append("")
    return np.array(reasons)


def _block(arm: ArmMotors) -> list[str]:
    rms = ", ".join(f"{value:.3g} {unit}" for value, unit in zip(arm.residual_rms, arm.robot.torque_units, strict=True))
    time, cutoff = arm.motion.time, arm.motion.cutoff
    told = [f"{time[-1] - time[0]:.3g} s, filter {cutoff:.4g} Hz; residual rms {rms}"]
    motors: dict[str, Any] = {}
    for name, (turning, sliding) in UNITS.items():
        value, half_width, reasons = arm.value[name], arm.half_width[name], arm.reasons[name]
        if all(reasons == ""):
            block = motors if name == "armature" else motors.setdefault("friction", {})
            block[name] = [float(f"{number:.{DIGITS}g}") for number in value]
            zero = ", ".join(np.array(arm.robot.joints)[arm.bounded[name]])
            widths = ", ".join(f"{width:.2g}" for width in half_width)
            units = " or ".join(dict.fromkeys(turning if of == "rad" else sliding for of in arm.robot.position_units))
            told.append(f"{name} in {units} ± {widths}{f'; held at 0: {zero}' if zero else ''}")
        else:
            told.append(f"{name} is not known of every joint, so it is left out:")
            joints = zip(arm.robot.joints, reasons, value, half_width, strict=True)
            told += [f"  {joint}: {why or f'{number:.4g} ± {width:.2g}'}" for joint, why, number, width in joints]
    block_text = yaml_text({"motors": motors}) if motors else ""
    return [f"    # {printable(line)}" for line in told] + indent(block_text, "    ").splitlines()
