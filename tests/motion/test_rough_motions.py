"""Motions as people have them: few digits or rows, joints besides; and those whose columns contradict each other."""

from dataclasses import replace

import numpy as np
import pytest
from motion_tables import TURNED, columns_of, moved, object_columns, read, scaled, write_motion, write_table
from ros_bags import message, trajectory, write_bag
from scipy.interpolate import CubicSpline

import mrts
from mrts.following.coordinate import coordinate
from mrts.motion.object_courses import PROFILES
from mrts.motion.rounded_samples import rounding, splines_through


@pytest.mark.parametrize(("name", "samples"), [("lift", 101), ("turn", 11)])
@pytest.mark.parametrize(
    ("kept", "form", "tolerance"),
    [
        (("q", "dq", "ddq"), ".5f", 1e-4),
        (("q", "dq"), ".12g", 1e-8),
        (("q", "dq"), ".5g", 2e-4),
        (("q",), ".12g", 5e-4),
        (("q",), ".5g", 2e-3),
    ],
)
def test_joint_tables_of_few_digits_and_rows(tmp_path, dual_ur5, exact, name, samples, kept, form, tolerance):
    """All of what is known down to the positions alone, rounded: c²⁺ is that of the exact motion."""
    followed, c2 = exact[name, samples]
    found = read(dual_ur5, write_table(tmp_path / "joints.csv", columns_of(dual_ur5, followed, kept), form))
    assert found.range.upper.c2 == pytest.approx(c2, rel=tolerance)
    np.testing.assert_allclose(found.motion.q, followed.q, atol=4e-4)


@pytest.mark.parametrize(("name", "samples"), [("lift", 101), ("turn", 11)])
@pytest.mark.parametrize(
    ("rates", "form", "tolerance"), [(True, ".5g", 1e-4), (False, ".8g", 1e-3), (False, ".4f", 2e-2)]
)
def test_object_tables_of_few_digits_and_rows(tmp_path, dual_ur5, exact, name, samples, rates, form, tolerance):
    followed, c2 = exact[name, samples]
    found = read(dual_ur5, write_table(tmp_path / "object.csv", object_columns(followed.object, rates=rates), form))
    assert found.range.upper.c2 == pytest.approx(c2, rel=tolerance)


@pytest.mark.parametrize(
    ("profile", "tolerance"), [("sinusoid", 1e-6), ("cubic", 5e-4), ("quintic", 1e-6), ("trapezoid", 5e-3)]
)
def test_positions_alone_tell_accelerations_at_the_ends_too(tmp_path, dual_ur5, profile, tolerance):
    """Sinusoid, cubic and trapezoid start with an acceleration, which natural splines take for none."""
    followed = mrts.follow_object(dual_ur5, moved(TURNED, 101, profile))
    c2 = mrts.scale(dual_ur5, followed).range.upper.c2
    tables = (columns_of(dual_ur5, followed, ("q",)), object_columns(followed.object, rates=False))
    for columns in tables:
        found = read(dual_ur5, write_table(tmp_path / "motion.csv", columns))
        assert found.range.upper.c2 == pytest.approx(c2, rel=tolerance)


def test_a_joint_that_rounding_puts_past_its_limit(tmp_path, dual_ur5, exact):
    """A plan that uses the whole of a joint, printed with five digits; a milliradian is no rounding."""
    followed, _ = exact["turn", 101]
    path = write_table(tmp_path / "joints.csv", columns_of(dual_ur5, followed), ".4f")
    highest = np.max(followed.q, axis=0)

    def limited(margin):
        limits = (highest[part] + margin for part in dual_ur5.joint_slices.values())
        pairs = zip(dual_ur5.robots, limits, strict=True)
        return replace(dual_ur5, robots=tuple(replace(robot, position_upper=upper) for robot, upper in pairs))

    assert read(limited(0.0), path).status.admits_motion
    with pytest.raises(mrts.MotionError, match="passes a position limit"):
        read(limited(-1e-3), path)


def test_velocities_are_taken_where_they_are(tmp_path, dual_ur5, exact):
    """Accelerations of velocities are an order better than those of positions; `samples` reads between the rows."""
    followed, _ = exact["turn", 11]
    write_table(tmp_path / "joints.csv", columns_of(dual_ur5, followed, ("q", "dq")))
    table = mrts.load_motion(tmp_path / "joints.csv")
    time, (_, dq, ddq), course, _ = table.of(["left/elbow"])
    assert course.rate is not None
    np.testing.assert_allclose(dq[:, 0], columns_of(dual_ur5, followed)["dq.left/elbow"], atol=1e-11)
    np.testing.assert_allclose(ddq, CubicSpline(time, dq)(time, 1), atol=1e-12)
    fine = mrts.load_motion(write_motion(tmp_path, joints="joints.csv", samples=101))
    truth, c2 = exact["turn", 101]
    np.testing.assert_allclose(coordinate(dual_ur5, fine).q, truth.q, atol=1e-3)
    assert mrts.scale(dual_ur5, fine).range.upper.c2 == pytest.approx(c2, rel=0.05)
    write_table(tmp_path / "joints.csv", columns_of(dual_ur5, followed))
    with pytest.raises(mrts.InputError, match="a table with accelerations keeps its own times"):
        mrts.load_motion(write_motion(tmp_path, joints="joints.csv", samples=101))


def test_joints_of_no_arm_are_passed_over(tmp_path, dual_ur5, exact):
    """A gripper in the table, a gripper and a third arm in the bag, with their own times: named, and without effect."""
    followed, c2 = exact["turn", 101]
    columns = columns_of(dual_ur5, followed)
    gripper = {"q.left/finger": np.linspace(0, 0.04, 101), "q.rail/slide": np.zeros(101), "dq.rail/slide": np.ones(101)}
    found = read(dual_ur5, write_table(tmp_path / "joints.csv", columns | gripper))
    assert found.range.upper.c2 == pytest.approx(c2, rel=1e-8)
    (remark,) = found.motion.remarks
    assert remark.code == "extra-joints"
    assert remark.text.endswith("were passed over: left/finger, rail/slide.")

    arms = [
        (f"/{robot.name}/joint_trajectory", message(*trajectory(robot, followed, dual_ur5.joint_slices[robot.name])))
        for robot in dual_ur5.robots
    ]
    still = [[stamp, np.zeros(1), np.zeros(0), np.zeros(0)] for stamp in (0, 7 * 10**8)]
    third = trajectory(dual_ur5.robots[0], followed, slice(0, 6))
    others = [
        ("/a_gripper/joint_trajectory", message(["finger"], still)),
        ("/a_gripper/joint_trajectory", message(["finger"], still)),
        ("/gripper/joint_trajectory", message(["finger"], still)),
        ("/one_point/joint_trajectory", message(["latch"], still[:1])),
        ("/third/joint_trajectory", message(*third)),
    ]
    found = read(dual_ur5, write_bag(tmp_path / "bag", [*others, *arms]))
    assert found.range.upper.c2 == pytest.approx(c2, rel=1e-6)
    text = found.motion.remarks[0].text
    for name in ("a_gripper/finger", "gripper/finger", "one_point/latch", "third/elbow"):
        assert name in text


@pytest.mark.parametrize(("form", "unit"), [(".3f", 1e-3), (".5g", 1e-5), (".8g", 1e-8), (".12g", 0)])
def test_the_rounding_of_printed_digits(form, unit):
    """Against what the digits really cut off, for values of up to one, and of up to a hundred."""
    values = np.random.default_rng(6).uniform(-1, 1, 500)
    for size in (1.0, 100.0):
        printed = np.array([float(format(size * value, form)) for value in values])
        cut_off = np.sqrt(np.mean((printed - size * values) ** 2))
        assert rounding(printed) == pytest.approx(cut_off if unit else 0, rel=0.15)


def test_smooth_paths_within_the_rounding():
    """The second derivative of sin t from five decimals, at steps where interpolation finds noise only."""
    time = np.linspace(0, 3, 3001)
    values = np.round(np.sin(time), 5)
    spline, moved_by = splines_through(time, values[:, None])
    assert 0 < moved_by < 2e-5
    np.testing.assert_allclose(spline(time, 2)[:, 0], -np.sin(time), atol=0.01)
    assert np.max(np.abs(CubicSpline(time, values)(time, 2) + np.sin(time))) > 5
    spline, moved_by = splines_through(time, np.sin(time)[:, None])
    assert moved_by == 0
    np.testing.assert_array_equal(spline(time)[:, 0], np.sin(time))


def swapped(columns, one, other):
    names = {one: other, other: one}
    return {names.get(name, name): values for name, values in columns.items()}


MISTAKES = {
    "degrees a second": lambda columns: scaled(columns, "dq.", 180 / np.pi),
    "degrees": lambda columns: scaled(columns, "q.", 180 / np.pi),
    "sign of velocities": lambda columns: scaled(columns, "dq.left", -1),
    "sign of accelerations": lambda columns: scaled(columns, "ddq.right", -1),
    "accelerations too large by half": lambda columns: scaled(columns, "ddq.", 1.5),
    "milliseconds": lambda columns: scaled(columns, "t", 1000),
    "velocities swapped": lambda columns: swapped(columns, "dq.left/elbow", "dq.left/wrist_1_turn"),
    "no velocities": lambda columns: scaled(columns, "dq.", 0),
    "one arm late": lambda columns: {
        name: np.roll(values, 10) if "left" in name else values for name, values in columns.items()
    },
    "object: millimetres a second": lambda columns: scaled(columns, "v", 1000),
    "object: degrees a second": lambda columns: scaled(columns, "w", 180 / np.pi),
    "object: axes swapped": lambda columns: swapped(columns, "vy", "vz"),
    "object: sign": lambda columns: scaled(columns, "vy", -1),
    "object: sign of accelerations": lambda columns: scaled(columns, "ay", -1),
    "object: milliseconds": lambda columns: scaled(columns, "t", 1000),
    "object: accelerations too large by half": lambda columns: scaled(columns, "a", 1.5),
}


@pytest.mark.parametrize("mistake", MISTAKES)
@pytest.mark.parametrize(("samples", "form"), [(101, ".12g"), (11, ".5g")])
def test_wrong_tables_are_refused(tmp_path, dual_ur5, exact, mistake, samples, form):
    """At any number of digits and rows."""
    motion = exact["turn", samples][0]
    of_object = mistake.startswith("object")
    columns = object_columns(motion.object, rates=True) if of_object else columns_of(dual_ur5, motion)
    with pytest.raises(mrts.MrtsError, match=r"do not lead|do not close|do not fit|position limit"):
        read(dual_ur5, write_table(tmp_path / "motion.csv", MISTAKES[mistake](columns), form))


SMALL_MISTAKES = {
    "millimetres for metres": (1e-3, 1e-3),
    "sign": (-1, -1),
    "sign of accelerations": (1, -1),
    "accelerations twice": (1, 2),
}


@pytest.mark.parametrize("mistake", SMALL_MISTAKES)
@pytest.mark.parametrize(("length", "duration"), [(1e-4, 1.0), (1e-3, 60.0), (1e-5, 60.0)])
def test_wrong_tables_of_small_or_slow_motions_are_refused(length, duration, mistake):
    """What rounding may leave out is no more than a share of what moves."""
    u = np.linspace(0, 1, 101)
    s, ds, dds = PROFILES["cubic"](u)
    position, twist, acceleration = np.zeros((101, 3)), np.zeros((101, 6)), np.zeros((101, 6))
    position[:, 2], twist[:, 2], acceleration[:, 2] = length * s, length / duration * ds, length / duration**2 * dds
    eye = np.broadcast_to(np.eye(3), (101, 3, 3))
    assert mrts.ObjectMotion(u * duration, position, eye, twist, acceleration)
    rates, changes = SMALL_MISTAKES[mistake]
    with pytest.raises(mrts.InputError, match="do not lead"):
        mrts.ObjectMotion(u * duration, position, eye, rates * twist, changes * acceleration)
