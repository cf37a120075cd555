# SPDX-License-Identifier: MIT
"""What is said of an arm that cannot follow, by the outcome codes of `mrts.kernel.tracking`."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

from mrts.base.arrays import Array
from mrts.cell.robot import DEGREES_SUSPECTED, Robot
from mrts.kernel.tracking import FOLDED, LEFT_LIMITS, LOST, NO_START, OUT_OF_REACH, PAST_LIMIT, SINGULAR, START_PAST

FURTHER_STARTS = 40
"""Starts tried where the posture leads to nothing: an arm of six joints has up to 16 branches."""

CONDITION_LIMIT = 1e6
"""Condition number of a Jacobian above which an arm counts as singular: ten digits of q' are left."""


@dataclass(frozen=True)
class TrackingFailure:
    """Why an arm cannot follow.

    Attributes:
        kind: In a phrase that its fellows share, such as "out of reach".
        message: With robot, sample and amount.
        sample: The first that it does not follow.
    """

    kind: str
    message: str
    sample: int


class _Wording(NamedTuple):
    """Of an outcome: its kind, what the arm does, why, with amounts and joint, and what to do."""

    kind: str
    does: str
    why: str
    advice: str


_OUT_OF_REACH = _Wording(
    "out of reach",
    "cannot reach its grasp",
    "its tip came no nearer than {0:.3g} m and {1:.3g} rad.",
    "Choose another posture, from which another branch may reach it, or move the path, the base or the grasp.",
)

_PAST_LIMIT = _Wording(
    "past a position limit",
    "passes a position limit",
    "joint '{joint}' would be at {0:.6g}, its limits are [{lower:g}, {upper:g}].{hint}",
    "Choose another posture, path, base or grasp.",
)

_TRIED = f" {1 + FURTHER_STARTS} starts were tried."

WORDINGS = {
    NO_START: _OUT_OF_REACH._replace(advice=_OUT_OF_REACH.advice + _TRIED),
    START_PAST: _PAST_LIMIT._replace(advice=_PAST_LIMIT.advice + _TRIED),
    OUT_OF_REACH: _OUT_OF_REACH,
    PAST_LIMIT: _PAST_LIMIT,
    LEFT_LIMITS: _PAST_LIMIT,
    LOST: _Wording(
        "off their path",
        "loses its branch",
        "a joint is {0:.3g} (rad or m) from where its velocity led.",
        "Use more samples, or keep away from the singularity near there.",
    ),
    FOLDED: _Wording(
        "off their path",
        "loses its branch",
        "of all joint positions that hold the grasp, those near its start and away from its limits end there, and it "
        "would have to jump.",
        "Choose another posture, or a path that keeps nearer to the start.",
    ),
    SINGULAR: _Wording(
        "singular",
        "is singular",
        f"the condition number of its Jacobian is {{0:.3g}}, the limit is {CONDITION_LIMIT:.0e}.",
        "Keep the arm away from full stretch, full fold and aligned axes: move the path, the base or the grasp.",
    ),
}
"""By outcome; only an arm that is followed, or that was passed over, has none."""


def tracking_failure(
    code: int, robot: Robot, time: Array, sample: int, amounts: Sequence[float], joint: int = 0
) -> TrackingFailure:
    """What an outcome says.

    Args:
        code: Of `mrts.kernel.tracking`.
        robot: The arm.
        time: Shape (N,) [s].
        sample: Where.
        amounts: As the code has them.
        joint: Which, of the arm.
    """
    wording = WORDINGS[code]
    degrees = robot.joint_types[joint] == "revolute" and abs(amounts[0]) > DEGREES_SUSPECTED
    why = wording.why.format(
        *amounts,
        joint=robot.joints[joint],
        lower=robot.position_lower[joint],
        upper=robot.position_upper[joint],
        hint=" If these are degrees: positions are in rad." if degrees else "",
    )
    at = f"sample {sample} (t = {time[sample]:.6g} s)"
    message = f"robot '{robot.name}' {wording.does} at {at}: {why} {wording.advice}"
    return TrackingFailure(wording.kind, message, sample)
