"""Waypoints and CSV tables: smooth, right at the given poses, and strict; velocity profiles by their integrals."""

import numpy as np
import pytest
from conftest import UR5
from motion_tables import columns_of, object_table, read, write_motion, write_table
from scipy.integrate import cumulative_simpson, quad
from scipy.spatial.transform import Rotation

import mrts
from mrts.motion.object_courses import CORNERS, PROFILES, trapezoid

pytestmark = pytest.mark.quick

WAYPOINTS = [
    {"xyz": [0.0, 0.1, 0.35], "rpy": [0, 0, 0]},
    {"xyz": [0.02, 0.15, 0.42], "rpy": [0.1, 0, 0.1]},
    {"xyz": [0.03, 0.2, 0.5], "rpy": [0.2, 0, 0.3]},
    {"xyz": [0.0, 0.15, 0.45], "rpy": [0.1, 0.1, 0.2]},
]


def assert_smooth(motion, tolerance):
    """Rates and accelerations are derivatives: integrated, they give back pose and rate."""
    moved = cumulative_simpson(motion.twist[:, :3], x=motion.time, axis=0, initial=0)
    np.testing.assert_allclose(moved, motion.position - motion.position[0], atol=tolerance)
    steps = Rotation.from_matrix(motion.rotation[1:] @ motion.rotation[:-1].transpose(0, 2, 1)).as_rotvec()
    means = steps / np.diff(motion.time)[:, None]
    np.testing.assert_allclose(means, (motion.twist[1:, 3:] + motion.twist[:-1, 3:]) / 2, atol=100 * tolerance)
    sped = cumulative_simpson(motion.acceleration, x=motion.time, axis=0, initial=0)
    np.testing.assert_allclose(sped, motion.twist - motion.twist[0], atol=100 * tolerance)


def test_waypoints_are_passed_on_a_smooth_path(tmp_path, dual_ur5):
    path = write_motion(tmp_path, duration=1.0, samples=2001, profile="quintic", waypoints=WAYPOINTS)
    motion = mrts.load_motion(path)
    assert_smooth(motion, 1e-6)
    assert np.max(np.abs(motion.twist[[0, -1]])) < 1e-12
    for waypoint in WAYPOINTS:
        distance = np.linalg.norm(motion.position - waypoint["xyz"], axis=1)
        k = int(np.argmin(distance))
        assert distance[k] < 1e-3  # between two samples
        wanted = Rotation.from_euler("xyz", waypoint["rpy"]).as_matrix()
        assert Rotation.from_matrix(motion.rotation[k] @ wanted.T).magnitude() < 1e-2
    short = write_motion(tmp_path, duration=1.0, profile="quintic", waypoints=WAYPOINTS)
    assert mrts.scale(dual_ur5, mrts.load_motion(short)).status is mrts.ScalingStatus.FEASIBLE


def test_a_coarse_table_is_resampled_on_its_spline(tmp_path):
    given = mrts.load_motion(UR5 / "lift_and_turn.yaml")
    lines = object_table(given, rates=False).splitlines()
    (tmp_path / "motion.csv").write_text("\n".join([lines[0], *lines[1::10]]))
    read = mrts.load_motion(write_motion(tmp_path, file="motion.csv", samples=101))
    assert len(read.time) == 101
    np.testing.assert_allclose(read.position, given.position, atol=2e-3)
    assert_smooth(read, 1e-4)


TABLE_MISTAKES = {
    "missing column": (lambda text: text.replace(",qw", ",qq", 1), ["columns are needed too: qw"]),
    "unknown column": (
        lambda text: text.replace("\n", ",0\n").replace(",0\n", ",extra\n", 1),
        ["unknown column 'extra'"],
    ),
    "half of the rates": (lambda text: text.replace("alphaz", "alphazz", 1), ["columns are needed too: alphaz"]),
    "a word": (lambda text: text.replace("\n3,", "\nthree,", 1), ["row 1, column t", "'three'", "finite number"]),
    "short row": (lambda text: text + "4,5\n", ["row 102", "2 values for 20 columns"]),
    "time back": (lambda text: text + text.splitlines()[1] + "\n", ["row 102, column t", "later than the row before"]),
    "no quaternion": (
        lambda text: text.replace("\n3,0,0.1,0.35,0,0,0,1,", "\n3,0,0.1,0.35,0,0,0,2,", 1),
        ["length 1", "it has 2"],
    ),
    "one row": (lambda text: "\n".join(text.splitlines()[:2]), ["1 rows of values", "at least 2"]),
    "empty": (lambda _: "", ["is empty"]),
    "twice a name": (lambda text: text.replace("py", "px", 1), ["'px' stands twice"]),
    "semicolons": (lambda text: text.replace(",", ";"), ["has one column", "commas"]),
    "huge": (lambda text: text.replace("\n3,0,", "\n3,1e300,", 1), ["row 1, column px", "'1e300'"]),
    "no time": (lambda text: text.replace("t,", "time,", 1), ["a column 't'"]),
}


def test_mistakes_in_a_table(tmp_path):
    text = object_table(mrts.load_motion(UR5 / "lift_and_turn.yaml"), rates=True)
    for mistake, (spoil, expected) in TABLE_MISTAKES.items():
        (tmp_path / "motion.csv").write_text(spoil(text))
        with pytest.raises(mrts.InputError) as refused:
            mrts.load_motion(write_motion(tmp_path, file="motion.csv"))
        for part in ["motion.csv", *expected]:
            assert part in str(refused.value), mistake


def test_joints_may_be_named_without_their_robot_where_that_tells_them(tmp_path, dual_ur5, exact):
    """By `q.` columns or by positions alone; where two arms have such a joint, the error names both."""
    cell = mrts.load_cell(UR5.parent / "upper_body" / "cell.yaml")  # one machine: its joints differ in name
    columns = columns_of(cell, mrts.follow_object(cell, mrts.load_motion(UR5.parent / "upper_body" / "lift.yaml")))
    positions = {name: values for name, values in columns.items() if name[0] in "tq"}
    for given, spelt in (
        (columns, lambda name: name.replace("left/", "").replace("right/", "")),
        (positions, lambda name: name.rpartition("/")[2]),
    ):
        bare = {spelt(name): values for name, values in given.items()}
        named, told = (
            mrts.scale(cell, mrts.load_motion(write_table(tmp_path / "joints.csv", table)), between=None)
            for table in (given, bare)
        )
        assert told.range.upper.c2 == named.range.upper.c2
        assert not any("passed over" in str(remark) for remark in told.warnings)
    columns = columns_of(dual_ur5, exact["turn", 101][0])
    shared = {name.replace("left/elbow", "elbow"): values for name, values in columns.items()}
    with pytest.raises(mrts.InputError, match=r"joint 'left/elbow' .* of two, are elbow: is one"):
        read(dual_ur5, write_table(tmp_path / "shared.csv", shared))


INTEGRATION = 1e-9  # of scipy's adaptive quadrature
TOP_ACCELERATION = 4.5  # 1 / (ramp (1 - ramp)) with a ramp of a third


@pytest.mark.parametrize("name", PROFILES)
def test_a_profile_is_the_integral_of_its_derivatives_from_rest_to_rest(name):
    profile = PROFILES[name]
    u = np.linspace(0.0, 1.0, 31)
    s, ds, _ = profile(u)
    assert s[0] == 0
    np.testing.assert_allclose([s[-1], ds[0], ds[-1]], [1, 0, 0], atol=INTEGRATION)
    for order, values in ((1, s), (2, ds)):
        for end, value in zip(u, values, strict=True):
            corners = [corner for corner in (1 / 3, 2 / 3) if corner < end]
            area, _ = quad(
                lambda at, order=order: float(profile(np.array([at]))[order][0]), 0, end, points=corners or None
            )
            assert abs(area - value) < INTEGRATION


@pytest.mark.parametrize("name", PROFILES)
def test_corners_are_where_the_acceleration_jumps(name):
    u = np.linspace(0.0, 1.0, 1001)  # its steps are far below a jump, and no corner is among these
    steps = np.flatnonzero(np.abs(np.diff(PROFILES[name](u)[2])) > 1)
    corners = np.array(CORNERS.get(PROFILES[name], ()))
    np.testing.assert_array_equal(steps, np.searchsorted(u, corners) - 1)


def test_samples_at_a_trapezoids_corners_take_the_ramps_acceleration():
    for samples in range(4, 602, 3):
        for u in (np.linspace(0, 1, samples), np.arange(samples) / (samples - 1)):
            third = (samples - 1) // 3
            acceleration = trapezoid(u)[2]
            assert acceleration[third] == TOP_ACCELERATION, samples
            assert acceleration[2 * third] == -TOP_ACCELERATION, samples
            assert np.count_nonzero(acceleration == 0) == third - 1, samples
