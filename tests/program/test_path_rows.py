"""Rows where the speed varies: put together by the kernel, and by numpy from the same generated functions."""

import numpy as np
import pytest
import yaml
from conftest import DATA
from random_motors import drawn_motors

import mrts
from mrts.limits.rows import LimitRows, RowName
from mrts.program.sample_problem import build_sample_problem

SHIPPED = {"planar_dual_arm": "lift.yaml", "dual_ur5": "lift_and_turn.yaml", "squeeze": "lift_and_turn.yaml"}
ROUNDING = 1e-12  # of the largest entry: sums in another order
SAMPLES = 300  # more than a chunk of the kernel


def pushing_limit(cell, motion):
    """What the object accelerates with, r̈ and ṙ² together, and nothing else."""
    along = motion.object.twist[:, :1], motion.object.acceleration[:, :1]
    joints, wrenches = motion.q.shape[1], len(cell.robots) * len(cell.wrench_components)
    return LimitRows(
        names=(RowName("acceleration", unit="m/s²"),),
        lower=np.array([-3.0]),
        upper=np.array([2.0]),
        torque_matrix=np.zeros((1, joints)),
        wrench_matrix=np.zeros((1, wrenches)),
        rate=along[0],
        square=along[1],
    )


@pytest.mark.parametrize("how", ["given", "velocities apart", "motors", "a limit of its own"])
@pytest.mark.parametrize("name", SHIPPED)
def test_the_kernel_puts_the_same_rows_together(name, how):
    cell = mrts.load_cell(DATA.parent / name / "cell.yaml")
    given = yaml.safe_load((DATA.parent / name / SHIPPED[name]).read_text()) | {"samples": SAMPLES}
    motion = mrts.follow_object(cell, mrts.sample_motion(mrts.MotionDescription.model_validate(given)))
    if how == "velocities apart":
        cell = cell.without_velocity_limits()
    elif how == "motors":
        cell = drawn_motors(np.random.default_rng(len(name)), cell)
    elif how == "a limit of its own":
        cell = cell.with_limits(pushing_limit)
    ours = build_sample_problem(cell, motion, varying=True)
    theirs = build_sample_problem(cell, motion, varying=True, samples=np.arange(motion.samples))
    for attribute in (
        *("torque_map", "torque_offset", "torque_speed", "wrench_map", "wrench_offset"),
        *("A", "lower", "upper", "speed", "unit", "is_cap"),
    ):
        one, other = getattr(ours, attribute), getattr(theirs, attribute)
        if other is None:
            assert one is None
            continue
        finite = np.isfinite(other)
        np.testing.assert_array_equal(one[~finite], other[~finite])
        size = max(1.0, float(np.max(np.abs(other[finite]), initial=0.0)))
        np.testing.assert_allclose(one[finite], other[finite], atol=ROUNDING * size, rtol=0)
    assert ours.names == theirs.names
    assert (ours.torque_speed is None) == (how != "motors")
