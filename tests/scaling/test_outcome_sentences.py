"""What a result says in one sentence, for every outcome: the range, what it means in seconds, and what sets it."""

from dataclasses import replace

import numpy as np
import pytest

import mrts
import mrts.output.limit_table

pytestmark = pytest.mark.quick

AT_REST = {"duration": 1.0, "samples": 11, "profile": "quintic", "start": {"xyz": [1.25, 1, 0]}}


def with_vertical_force(cell, least, largest):
    """Strong arms whose hands must press upward by some force."""
    robots = tuple(
        replace(
            robot,
            torque_lower=robot.torque_lower * 100,
            torque_upper=robot.torque_upper * 100,
            wrench_lower=np.array([-np.inf, least, -np.inf]),
            wrench_upper=np.array([np.inf, largest, np.inf]),
        )
        for robot in cell.robots
    )
    return replace(cell, robots=robots)


@pytest.fixture(scope="module")
def start_of_lowering():
    """Downward, speeding up: fast it weighs little, slow it weighs its 4.9 N; 0.095 s."""
    low = mrts.sample_motion(
        mrts.MotionDescription.model_validate(
            {"duration": 0.5, "profile": "sinusoid", "start": {"xyz": [1.25, 1.5, 0]}, "end": {"xyz": [1.25, 1.0, 0]}}
        )
    )
    fields = (low.time, low.position, low.rotation, low.twist, low.acceleration)
    return mrts.ObjectMotion(*(field[:20] for field in fields))


@pytest.mark.parametrize(
    ("largest", "says"),
    [
        (2.2, "you must play it 0.35 to 0.767 × as fast as given: 0.2714 to 0.1239 s instead of 0.095 s"),
        (2.45, "you must play it at most 0.767 × as fast as given: 0.1239 s instead of 0.095 s"),
    ],
)
def test_no_slower_than_what_can_be_held(planar_cell, start_of_lowering, largest, says):
    text = mrts.scale(with_vertical_force(planar_cell, 1.0, largest), start_of_lowering).summary()
    assert says in text
    assert "limited at t = 0 s by" in text or "limited above at t = 0 s by" in text
    assert ("below at t = 0.095 s by" in text) == (largest < 2.45)


def test_nothing_that_limits_the_speed(planar_cell):
    description = mrts.MotionDescription.model_validate(AT_REST | {"end": AT_REST["start"]})
    text = mrts.scale(planar_cell, mrts.sample_motion(description)).summary()
    assert text == "c² ∈ [0, ∞): No limit depends on the speed at the samples: you may play it as fast as you like."
