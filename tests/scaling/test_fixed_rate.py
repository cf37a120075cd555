"""A plan at the rate of a controller: equal steps, rest at both ends, and all limits at its samples."""

import numpy as np
import pytest

import mrts
from mrts.output.trajectory_table import played_rows

ROUNDING = 1e-7
"""Residual of the dynamics [N m], of torques around 100 N m."""

RATES = 11.5

PLANS = {
    "constant": mrts.scale,
    "optimal": lambda cell, motion: mrts.retime(cell, motion).retimed,
    "smooth": lambda cell, motion: mrts.retime(cell, motion, rates=RATES).retimed,
}

LONGER = 0.03
"""Share by which a plan of 250 Hz may take longer: steps and cubic rows around a jump of the acceleration (2 %)."""


@pytest.mark.parametrize("name", PLANS)
def test_a_plan_at_250_hz_keeps_all_limits_and_ends_at_rest(name, dual_ur5, lift_and_turn):
    plan = PLANS[name](dual_ur5, lift_and_turn)
    sampled = plan.at_rate(250)
    done, rows = sampled.trajectory, played_rows(sampled.trajectory)
    np.testing.assert_array_equal(done.time, np.arange(len(done.time)) / 250)
    np.testing.assert_array_equal(rows["t"], np.arange(len(rows["t"])) / 250)
    assert plan.trajectory.duration <= done.duration <= (1 + LONGER) * plan.trajectory.duration
    for row in (0, -1):
        np.testing.assert_allclose(rows["q"][row], plan.trajectory.q[row], atol=1e-12)
        assert not np.any(np.abs(rows["dq"][row]) > 1e-9)
        assert not np.any(rows["ddq"][row]) or not done.holding.ends[row]
    residuals = sampled.residuals()
    assert residuals.limits <= mrts.scaling.scale.LIMIT_TOLERANCE
    assert max(residuals.arms, residuals.object) <= ROUNDING
    moved = np.diff(done.q, axis=0) - (done.dq[:-1] + done.dq[1:]) / 500
    bent = np.max(np.abs(np.diff(done.ddq, axis=0)), axis=0) / 12 / 250**2  # of the trapezoidal rule
    assert np.all(np.abs(moved) <= 2 * bent + 1e-12)
    if name == "smooth":
        limits = np.concatenate([robot.torque_upper for robot in dual_ur5.robots])
        assert np.all(np.abs(np.diff(done.torque, axis=0)) * 250 <= RATES * limits * (1 + 1e-6))


def test_a_rate_whose_rows_do_not_lead_from_one_to_the_next_is_refused(planar_cell, lift):
    with pytest.raises(mrts.InputError, match=r"^rate = 5.0: is too low"):
        mrts.retime(planar_cell, lift, rates=10.0).retimed.at_rate(5.0)
