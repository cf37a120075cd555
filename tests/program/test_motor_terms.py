"""What motors add along a motion: signs of friction, and the same torques from the kernel as from numpy."""

from dataclasses import replace

import numpy as np
import pytest
from random_motors import equipped

import mrts
from mrts.following.coordinated_motion import unchecked_coordinated_motion
from mrts.program.motion_rows import motion_rows, motor_terms, travel_directions
from mrts.program.sample_problem import build_sample_problem


def test_friction_points_along_the_travel_and_is_one_sided_at_rest(lift):
    t = np.linspace(0, 2 * np.pi, 9)
    dq = np.column_stack([np.sin(t / 2), np.sin(t), -np.sin(t / 2), np.zeros(9)])
    ddq = np.column_stack([np.cos(t / 2) / 2, np.cos(t), -np.cos(t / 2) / 2, np.zeros(9)])
    before, after = travel_directions(unchecked_coordinated_motion(lift, dq, dq, ddq))
    assert np.array_equal(before[:, 0], np.ones(9))
    assert np.array_equal(after[:, 0], np.ones(9))
    assert np.array_equal(before[:, 1], [1, 1, 1, 1, 1, -1, -1, -1, -1])
    assert np.array_equal(after[:, 1], [1, 1, 1, 1, -1, -1, -1, -1, -1])
    assert np.array_equal(before[:, 2], -np.ones(9))
    assert not before[:, 3].any()
    assert not after[:, 3].any()


@pytest.mark.quick
def test_at_a_turning_point_limits_move_inward_by_the_dry_friction(planar_cell, lift):
    motion = mrts.follow_object(planar_cell, lift)
    dq, ddq = motion.dq.copy(), motion.ddq.copy()
    dq[4, 1], ddq[4, 1] = 0.0, -3.0
    turning = replace(motion, dq=dq, ddq=ddq)
    cell = equipped(planar_cell, coulomb=2.0)
    terms = motor_terms(cell, turning)
    assert np.array_equal(np.argwhere(terms.turning), [[4, 1]])
    assert terms.dry[4, 1] == 0
    given, narrowed = (build_sample_problem(motion_rows(of, turning)) for of in (planar_cell, cell))
    unit = given.unit[1]
    torque = 2.0 * np.sign(dq) / given.unit[: dq.shape[1]]
    assert narrowed.upper[4, 1] == pytest.approx(given.upper[4, 1] - 2.0 / unit)
    assert narrowed.lower[4, 1] == pytest.approx(given.lower[4, 1] + 2.0 / unit)
    moving = np.abs(dq) > 1e-6
    moving[4, 1] = False
    shift = given.upper[:, : dq.shape[1]] - narrowed.upper[:, : dq.shape[1]]
    np.testing.assert_allclose(shift[moving], torque[moving], atol=1e-12)
