"""Tables and bags begin and end with torques that hold still, and are the same motion when read again."""

import numpy as np
import pytest
from changed_robots import with_robots
from gantries import gantries, straight
from shipped_cells import scaled_path

import mrts
from mrts.following.coordinate import coordinate
from mrts.limits import limit_rows
from mrts.motion.rows_at_rest import HOLDING_STEP, moving_rows, pushing_ends
from mrts.output.trajectory_table import played_rows

STATICS = 1e-9


def plan(cell, motion, way):
    return mrts.retime(cell, motion).retimed if way == "optimal" else mrts.scale(cell, motion, sharing=way)


@pytest.mark.parametrize("way", ["optimal", mrts.LoadSharing()])
@pytest.mark.parametrize("name", ["planar", "spatial"])
def test_the_first_and_the_last_row_hold_still(name, way, planar_cell, dual_ur5):
    """By the terms at rest, G + JᵀF and Σ B F = Q, within all limits."""
    cell, folder = (planar_cell, "planar_dual_arm") if name == "planar" else (dual_ur5, "dual_ur5")
    result = plan(cell, scaled_path(folder, 0.15, 101, "cubic"), way)
    rows, done = played_rows(result.trajectory), result.trajectory
    assert len(rows["t"]) == done.motion.samples + 2
    assert rows["t"][0] == 0
    step = min(HOLDING_STEP, np.min(np.diff(done.time)))
    np.testing.assert_allclose(np.diff(rows["t"])[[0, -1]], step, rtol=1e-9)
    np.testing.assert_allclose(np.diff(rows["t"])[1:-1], np.diff(done.time), rtol=1e-9)
    assert np.any(np.abs(done.ddq[-1]) > 1)  # what a controller would hold for ever
    terms = cell.functions("terms", done.motion.samples, done.motion.inputs(cell.load))
    limits = limit_rows(cell, done.motion)
    for row in (0, -1):
        assert not np.any(rows["dq"][row])
        assert not np.any(rows["ddq"][row])
        np.testing.assert_array_equal(rows["q"][row], done.q[row])
        rest = rows["tau"][row] - terms["G"][row]
        for robot, joints in cell.joint_slices.items():
            rest[joints] -= terms["J"][row][:, joints].T @ rows["F"][row, cell.wrench_slices[robot]]
        np.testing.assert_allclose(rest, 0, atol=STATICS)
        np.testing.assert_allclose(terms["B"][row] @ rows["F"][row], terms["Q"][row], atol=STATICS)
        value = limits.at(np.array([row])).value(rows["tau"][[row]], rows["F"][[row]], 0.0, 0.0)
        assert np.max(limits.excess(value)) <= 1e-8
    np.testing.assert_array_equal(rows["tau"][1:-1], done.torque)


@pytest.mark.parametrize(("length", "samples"), [(1e-6, 301), (0.3, 31)])
def test_a_fastest_timing_read_again_is_the_fastest(length, samples, planar_cell, tmp_path):
    found = mrts.retime(planar_cell, scaled_path("planar_dual_arm", length, samples, "trapezoid"), between=None)
    mrts.write_trajectory_csv(found.retimed, tmp_path / "plan.csv")
    files = [tmp_path / "plan.csv"]
    if length > 1e-3:  # a bag counts whole nanoseconds
        mrts.write_ros_bag(found.retimed, tmp_path / "bag")
        files.append(tmp_path / "bag")
    for file in files:
        table = mrts.load_motion(file)
        assert coordinate(planar_cell, table).samples == samples
        again = mrts.scale(planar_cell, table, between=None)
        assert again.trajectory.duration == pytest.approx(found.duration, rel=1e-6)
        assert again.range.upper.c2 == pytest.approx(1, rel=1e-6)
        np.testing.assert_allclose(again.trajectory.torque, found.retimed.trajectory.torque, atol=1e-3)
        np.testing.assert_allclose(again.trajectory.holding.torque, found.retimed.trajectory.holding.torque, atol=1e-6)
        assert mrts.retime(planar_cell, table, between=None).duration == pytest.approx(found.duration, rel=1e-3)


def test_only_rows_at_rest_beside_an_acceleration_are_left_out():
    """A wait that somebody recorded is part of his motion."""
    q, dq, ddq = np.array([[0.0], [0.0], [0.5], [1.0], [1.0]]), np.zeros((5, 1)), np.zeros((5, 1))
    dq[2], ddq[[1, 3], 0] = 1.0, (2.0, -2.0)
    time, none = np.array([0.0, 1e-3, 0.1, 0.2, 0.201]), np.zeros((5, 0))
    assert moving_rows(time, q, dq, ddq) == slice(1, 4)
    assert pushing_ends(dq[1:4], ddq[1:4]) == (True, True)
    assert moving_rows(time, q, dq, np.zeros((5, 1))) == slice(0, 5)
    assert moving_rows(time, q, dq, none) == moving_rows(time, q, none, none) == slice(1, 4)
    assert moving_rows(time * 1.1, q, none, none) == slice(0, 5)
    moved = q.copy()
    moved[0] = -1e-9
    assert moving_rows(time, moved, dq, ddq) == slice(0, 4)
    assert moving_rows(time[:2], q[:2], dq[:2], ddq[:2]) == slice(0, 2)


PUSH = {"wrench_lower": np.array([0.5, -np.inf, -np.inf]), "wrench_upper": np.array([10.0, np.inf, np.inf])}
DRIVE = {"torque_lower": np.array([0.5, -20.0, -20.0])}


@pytest.mark.parametrize(
    ("limits", "options"),
    [(PUSH, {}), (DRIVE, {}), (DRIVE, {"sharing": mrts.LoadSharing()}), (DRIVE, {"distribute": "reserve"})],
    ids=["contacts", "drives", "shares", "reserve"],
)
def test_a_cell_that_cannot_hold_still_says_so(limits, options, tmp_path):
    """Two gantries whose contacts or drives must push: at rest nothing takes the push."""
    time = np.linspace(0, 1, 101)
    cell = with_robots(gantries(tmp_path), **limits)
    result = mrts.scale(cell, straight(time, time**2 / 2, time, 1.0), **options)
    assert result.trajectory.holding.ends == (False, False)
    (remark,) = [warning for warning in result.warnings if warning.code == "no-row-at-rest"]
    assert remark.sample == 0
    assert "do not let the cell hold still where the motion starts" in remark.text
    assert remark.text in result.summary()
    assert result.motion.remarks == ()
    carried = mrts.torques_for_load(result, result.cell.load)
    assert carried.warnings == result.warnings
    np.testing.assert_array_equal(played_rows(result.trajectory)["t"], result.trajectory.time)
