"""Motions as people have them: few digits or rows, no accelerations, joints besides, hands a little off."""

from dataclasses import replace

import numpy as np
import pytest
from conftest import DATA
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation
from test_motion_files import write_motion
from test_ros_trajectory import KIND, PARTS, message, trajectory, write_bag

import mrts
from mrts.cli import main
from mrts.coordination.coordinate import coordinate
from mrts.coordination.grasp_closure import grasp_gaps, tip_motions
from mrts.inverse_kinematics.grasp_tracking import tip_rates
from mrts.motion.rounded_samples import rounding, splines_through
from mrts.motion.velocity_profile import PROFILES
from mrts.viewer.player_state import PlayerState

UR5 = DATA.parent / "dual_ur5"
START, LIFTED, TURNED = {"xyz": [0, 0.1, 0.35]}, {"xyz": [0, 0.1, 0.5]}, {"xyz": [0.03, 0.2, 0.5], "rpy": [0.2, 0, 0.3]}
QUATERNION_NAMES = ["px", "py", "pz", "qx", "qy", "qz", "qw"]
RATE_NAMES = ["vx", "vy", "vz", "wx", "wy", "wz", "ax", "ay", "az", "alphax", "alphay", "alphaz"]


def moved(end, samples=101, profile="quintic"):
    poses = [{"rpy": [0, 0, 0]} | pose for pose in (START, end)]
    keys = {"duration": 0.8, "samples": samples, "profile": profile, "start": poses[0], "end": poses[1]}
    return mrts.sample_motion(mrts.MotionDescription(**keys))


@pytest.fixture(scope="module")
def exact(dual_ur5):
    """Joints that carry the object exactly, and their c²⁺, by end and number of rows."""
    found = {}
    for name, end in (("lift", LIFTED), ("turn", TURNED)):
        for samples in (11, 101):
            followed = mrts.follow_object(dual_ur5, moved(end, samples))
            found[name, samples] = followed, mrts.scale(dual_ur5, followed).range.upper.c2
    return found


def columns_of(cell, followed, kept=("q", "dq", "ddq")):
    names = [f"{robot.name}/{joint}" for robot in cell.robots for joint in robot.joints]
    columns = {"t": followed.object.time}
    for part in kept:
        columns |= dict(zip([f"{part}.{name}" for name in names], getattr(followed, part).T, strict=True))
    return columns


def object_columns(motion, *, rates):
    values = [motion.position, Rotation.from_matrix(motion.rotation).as_quat()]
    names = QUATERNION_NAMES + (RATE_NAMES if rates else [])
    if rates:
        values += [motion.twist, motion.acceleration]
    return {"t": motion.time} | dict(zip(names, np.concatenate(values, axis=1).T, strict=True))


def write_table(path, columns, form=".12g"):
    rows = np.column_stack(list(columns.values()))
    lines = [",".join(columns), *(",".join(format(value, form) for value in row) for row in rows)]
    path.write_text("\n".join(lines) + "\n")
    return path


def read(cell, path):
    return mrts.scale(cell, mrts.load_motion(path))


def codes(motion):
    return [remark.code for remark in motion.remarks]


@pytest.mark.parametrize("name", ["lift", "turn"])
@pytest.mark.parametrize("samples", [11, 101])
@pytest.mark.parametrize(
    ("kept", "form", "tolerance"),
    [
        (("q", "dq", "ddq"), ".8g", 1e-6),
        (("q", "dq", "ddq"), ".5f", 1e-4),
        (("q", "dq", "ddq"), ".5g", 2e-4),
        (("q", "dq"), ".12g", 1e-8),
        (("q", "dq"), ".5f", 1e-4),
        (("q", "dq"), ".5g", 2e-4),
        (("q",), ".12g", 5e-4),
        (("q",), ".8g", 1e-3),
        (("q",), ".5f", 1e-3),
        (("q",), ".5g", 2e-3),
    ],
)
def test_joint_tables_of_few_digits_and_rows(tmp_path, dual_ur5, exact, name, samples, kept, form, tolerance):
    """All of what is known down to the positions alone, rounded: c²⁺ is that of the exact motion."""
    followed, c2 = exact[name, samples]
    found = read(dual_ur5, write_table(tmp_path / "joints.csv", columns_of(dual_ur5, followed, kept), form))
    assert found.range.upper.c2 == pytest.approx(c2, rel=tolerance)
    np.testing.assert_allclose(found.motion.q, followed.q, atol=4e-4)


@pytest.mark.parametrize("name", ["lift", "turn"])
@pytest.mark.parametrize("samples", [11, 101])
@pytest.mark.parametrize(
    ("rates", "form", "tolerance"),
    [(True, ".8g", 1e-7), (True, ".5g", 1e-4), (False, ".8g", 1e-3), (False, ".5f", 2e-3), (False, ".4f", 2e-2)],
)
def test_object_tables_of_few_digits_and_rows(tmp_path, dual_ur5, exact, name, samples, rates, form, tolerance):
    followed, c2 = exact[name, samples]
    found = read(dual_ur5, write_table(tmp_path / "object.csv", object_columns(followed.object, rates=rates), form))
    assert found.range.upper.c2 == pytest.approx(c2, rel=tolerance)


@pytest.mark.parametrize(
    ("profile", "tolerance"), [("sinusoid", 1e-6), ("cubic", 5e-4), ("quintic", 1e-6), ("trapezoid", 5e-3)]
)
@pytest.mark.parametrize("end", [LIFTED, TURNED], ids=["lift", "turn"])
def test_positions_alone_tell_accelerations_at_the_ends_too(tmp_path, dual_ur5, end, profile, tolerance):
    """Sinusoid, cubic and trapezoid start with an acceleration, which natural splines take for none."""
    followed = mrts.follow_object(dual_ur5, moved(end, 101, profile))
    c2 = mrts.scale(dual_ur5, followed).range.upper.c2
    tables = (columns_of(dual_ur5, followed, ("q",)), object_columns(followed.object, rates=False))
    for columns in tables:
        found = read(dual_ur5, write_table(tmp_path / "motion.csv", columns))
        assert found.range.upper.c2 == pytest.approx(c2, rel=tolerance)


@pytest.mark.parametrize(("form", "tolerance"), [(".12g", 1e-6), (".5f", 1e-3)])
def test_object_tables_without_accelerations(tmp_path, dual_ur5, exact, form, tolerance):
    followed, c2 = exact["turn", 101]
    columns = object_columns(followed.object, rates=True)
    known = {name: values for name, values in columns.items() if name not in RATE_NAMES[6:]}
    found = read(dual_ur5, write_table(tmp_path / "object.csv", known, form))
    assert found.range.upper.c2 == pytest.approx(c2, rel=tolerance)
    with pytest.raises(mrts.InputError, match="rates do not lead"):
        mrts.load_motion(write_table(tmp_path / "object.csv", scaled(known, "w", 180 / np.pi), form))


def test_the_signs_of_quaternions_mean_nothing(tmp_path):
    columns = object_columns(moved(TURNED), rates=False)
    path = tmp_path / "object.csv"
    plain = mrts.load_motion(write_table(path, columns))
    flips = np.random.default_rng(2).choice([-1.0, 1.0], 101)
    flipped = {name: values * flips if name.startswith("q") else values for name, values in columns.items()}
    again = mrts.load_motion(write_table(path, flipped))
    for field in ("rotation", "twist", "acceleration"):
        np.testing.assert_allclose(getattr(again, field), getattr(plain, field), atol=1e-12)


def test_a_joint_that_rounding_puts_past_its_limit(tmp_path, dual_ur5, exact):
    """A plan that uses the whole of a joint, printed with five digits; a milliradian is no rounding."""
    followed, _ = exact["turn", 101]
    path = write_table(tmp_path / "joints.csv", columns_of(dual_ur5, followed), ".4f")
    highest = np.max(followed.q, axis=0)
    for margin, allowed in ((0.0, True), (-1e-3, False)):
        robots = [
            replace(robot, position_upper=highest[dual_ur5.joint_slices[robot.name]] + margin)
            for robot in dual_ur5.robots
        ]
        cell = replace(dual_ur5, robots=tuple(robots))
        if allowed:
            assert read(cell, path).status.admits_motion
        else:
            with pytest.raises(mrts.MotionError, match="passes a position limit"):
                read(cell, path)


def test_an_orientation_that_only_trembles_is_none_that_moves(tmp_path, dual_ur5, exact):
    """Rotations of a lift from another program carry noise of 1e-8 rad; the motion is the lift all the same."""
    followed, c2 = exact["lift", 101]
    noise = Rotation.from_rotvec(1e-8 * np.random.default_rng(4).normal(size=(101, 3))).as_matrix()
    trembling = replace(followed.object, rotation=noise @ followed.object.rotation)
    assert mrts.scale(dual_ur5, trembling).range.upper.c2 == pytest.approx(c2, rel=1e-6)
    for rates in (True, False):
        table = write_table(tmp_path / "object.csv", object_columns(trembling, rates=rates), ".12g")
        assert read(dual_ur5, table).range.upper.c2 == pytest.approx(c2, rel=1e-5 if rates else 0.05)


@pytest.mark.parametrize(("kept", "tolerance"), [(PARTS, 1e-6), (PARTS[:2], 1e-6), (PARTS[:1], 1e-4)])
@pytest.mark.parametrize("name", ["lift", "turn"])
def test_bags_with_and_without_accelerations(tmp_path, dual_ur5, exact, name, kept, tolerance):
    """Stamps of whole nanoseconds leave noise of 1e-8 rad in the orientation of a lift."""
    followed, c2 = exact[name, 101]
    slices = dual_ur5.joint_slices
    messages = [
        (f"/{robot.name}/joint_trajectory", message(*trajectory(robot, followed, slices[robot.name], kept)))
        for robot in dual_ur5.robots
    ]
    bag = write_bag(tmp_path / "bag", messages)
    assert read(dual_ur5, bag).range.upper.c2 == pytest.approx(c2, rel=tolerance)


def test_velocities_are_taken_where_they_are(tmp_path, dual_ur5, exact):
    """Accelerations of velocities are an order better than those of positions; `samples` reads between the rows."""
    followed, _ = exact["turn", 11]
    write_table(tmp_path / "joints.csv", columns_of(dual_ur5, followed, ("q", "dq")))
    table = mrts.load_motion(tmp_path / "joints.csv")
    assert set(table.differentiated.values()) == {"velocities"}
    name = "left/elbow"
    np.testing.assert_allclose(table.velocities[name], columns_of(dual_ur5, followed)[f"dq.{name}"], atol=1e-11)
    expected = CubicSpline(followed.object.time, table.velocities[name])(followed.object.time, 1)
    np.testing.assert_allclose(table.accelerations[name], expected, atol=1e-12)
    fine = mrts.load_motion(write_motion(tmp_path, joints="joints.csv", samples=101))
    truth, c2 = exact["turn", 101]
    np.testing.assert_allclose(coordinate(dual_ur5, fine).q, truth.q, atol=1e-3)
    assert mrts.scale(dual_ur5, fine).range.upper.c2 == pytest.approx(c2, rel=0.05)
    write_table(tmp_path / "joints.csv", columns_of(dual_ur5, followed))
    with pytest.raises(mrts.InputError, match="a table with accelerations keeps its own times"):
        mrts.load_motion(write_motion(tmp_path, joints="joints.csv", samples=101))


def test_arms_that_are_known_differently_are_read_alike(tmp_path, dual_ur5, exact):
    """Accelerations of one arm only: both take the splines of their positions, as where neither has any."""
    followed, c2 = exact["turn", 101]
    columns = columns_of(dual_ur5, followed)
    mixed = {name: values for name, values in columns.items() if not name.startswith(("dq.right", "ddq.right"))}
    found = read(dual_ur5, write_table(tmp_path / "mixed.csv", mixed))
    alone = read(dual_ur5, write_table(tmp_path / "alone.csv", columns_of(dual_ur5, followed, ("q",))))
    assert found.range.upper.c2 == alone.range.upper.c2
    assert found.range.upper.c2 == pytest.approx(c2, rel=1e-4)


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
    found = read(dual_ur5, write_bag(tmp_path / "bag", [*others, *arms], KIND))
    assert found.range.upper.c2 == pytest.approx(c2, rel=1e-6)
    text = found.motion.remarks[0].text
    for name in ("a_gripper/finger", "gripper/finger", "one_point/latch", "third/elbow"):
        assert name in text


def test_a_column_that_is_missing_for_one_joint_is_named(tmp_path, dual_ur5, exact):
    """No gap that is filled in silently: the columns of one robot go together."""
    columns = columns_of(dual_ur5, exact["turn", 101][0])
    for lacking, words in (
        (["ddq.left/elbow"], "gives ddq of 'left/shoulder_pan', but not of 'left/elbow'"),
        (["dq.left/elbow", "ddq.left/elbow"], "gives dq of 'left/shoulder_pan', but not of 'left/elbow'"),
        (["dq.left/elbow"], "the column 'ddq.left/elbow' needs a column 'dq.left/elbow'"),
    ):
        left = {name: values for name, values in columns.items() if name not in lacking}
        with pytest.raises(mrts.InputError, match=words):
            read(dual_ur5, write_table(tmp_path / "joints.csv", left))


def test_a_needed_joint_is_not_made_up_for_by_a_similar_one(tmp_path, dual_ur5, exact):
    columns = columns_of(dual_ur5, exact["turn", 101][0], ("q",))
    typo = {name.replace("left/elbow", "left/elbwo"): values for name, values in columns.items()}
    table = mrts.load_motion(write_table(tmp_path / "joints.csv", typo))
    with pytest.raises(
        mrts.InputError, match=r"nothing is said of joint 'left/elbow' .* There is 'left/elbwo', .* is it"
    ):
        mrts.scale(dual_ur5, table)


def perturbed(followed, size, turns=2):
    """Joints off the exact ones by smooth waves, with their own derivatives; sizes in rad."""
    rng = np.random.default_rng(11)
    time = followed.object.time
    rate = 2 * np.pi * turns / time[-1]
    shift = rng.uniform(0, 2 * np.pi, followed.q.shape[1])
    amplitude = size * rng.uniform(0.5, 1, followed.q.shape[1])
    angle = rate * time[:, None] + shift
    return replace(
        followed,
        q=followed.q + amplitude * np.sin(angle),
        dq=followed.dq + amplitude * rate * np.cos(angle),
        ddq=followed.ddq - amplitude * rate**2 * np.sin(angle),
    )


def assert_closed(cell, motion, tolerance=1e-9):
    """By the arms' forward kinematics: positions, velocities and accelerations of all hands fit the object."""
    tips = tip_motions(cell, motion.q, motion.dq, motion.ddq)
    gaps = grasp_gaps(cell, motion.object, tips)
    assert max(np.max(gaps.distance), np.max(gaps.angle)) < tolerance
    for robot, tip in zip(cell.robots, tips, strict=True):
        velocity, acceleration = tip_rates(cell, robot, motion.object)
        np.testing.assert_allclose(tip.velocity, velocity, atol=tolerance)
        np.testing.assert_allclose(tip.acceleration, acceleration, atol=100 * tolerance)


def assert_own_derivatives(motion, tolerance):
    """Velocities and accelerations are those of the positions: differences of these in between."""
    time = motion.object.time
    line = CubicSpline(time, motion.q)
    inner = slice(5, -5)
    np.testing.assert_allclose(line(time, 1)[inner], motion.dq[inner], atol=tolerance)
    np.testing.assert_allclose(line(time, 2)[inner], motion.ddq[inner], atol=100 * tolerance)
    place = CubicSpline(time, motion.object.position)
    np.testing.assert_allclose(place(time, 1)[inner], motion.object.twist[inner, :3], atol=tolerance)


@pytest.mark.parametrize("kept", [("q", "dq", "ddq"), ("q", "dq"), ("q",)])
def test_hands_a_little_off_are_moved_onto_the_grasps(tmp_path, dual_ur5, exact, kept):
    """Waves of about 1 mm and 2 mrad: the range is that of the exact motion but for what the waves themselves cost."""
    followed, c2 = exact["turn", 101]
    table = mrts.load_motion(
        write_table(tmp_path / "joints.csv", columns_of(dual_ur5, perturbed(followed, 8e-4), kept))
    )
    found = mrts.scale(dual_ur5, table)
    assert_closed(dual_ur5, found.motion)
    assert_own_derivatives(found.motion, 3e-4)
    assert found.range.upper.c2 == pytest.approx(c2, rel=0.03)
    *rough, remark = found.motion.remarks
    assert [each.code for each in rough] == (["rough-accelerations"] if kept == ("q",) else [])
    assert remark.code == "chain-closed"
    assert 0 <= remark.sample < 101
    assert "'left'" in remark.text or "'right'" in remark.text
    moved_by = np.max(np.abs(found.motion.q - np.column_stack([table.positions[name] for name in table.positions])))
    assert f"by more than {moved_by:.3g} rad or m" in remark.text


@pytest.mark.quick
def test_hands_of_a_planar_cell_are_moved_in_its_plane(tmp_path, planar_cell, lift):
    followed = mrts.follow_object(planar_cell, lift)
    c2 = mrts.scale(planar_cell, followed).range.upper.c2
    table = write_table(tmp_path / "joints.csv", columns_of(planar_cell, perturbed(followed, 3e-4)))
    found = read(planar_cell, table)
    assert_closed(planar_cell, found.motion)
    assert codes(found.motion) == ["chain-closed"]
    assert np.max(np.abs(found.motion.object.position[:, 2])) < 1e-12
    assert found.range.upper.c2 == pytest.approx(c2, rel=0.05)


def test_a_closed_table_is_retimed_and_viewed(tmp_path, dual_ur5, exact):
    """Every way in takes the bound."""
    table = mrts.load_motion(
        write_table(tmp_path / "joints.csv", columns_of(dual_ur5, perturbed(exact["turn", 11][0], 4e-3, turns=1)))
    )
    for play in (mrts.retime, PlayerState):
        with pytest.raises(mrts.MotionError, match="do not close the chain"):
            play(dual_ur5, table)
    bound = mrts.ClosureBound(0.02, 0.02)
    assert_closed(dual_ur5, mrts.retime(dual_ur5, table, closure=bound).motion)
    assert_closed(dual_ur5, PlayerState(dual_ur5, table, closure=bound).result.motion)


def test_a_smaller_gap_costs_less(tmp_path, dual_ur5, exact):
    followed, c2 = exact["turn", 101]
    off = []
    for size in (8e-4, 8e-5):
        write_table(tmp_path / "joints.csv", columns_of(dual_ur5, perturbed(followed, size)))
        off.append(abs(read(dual_ur5, tmp_path / "joints.csv").range.upper.c2 / c2 - 1))
    assert off[1] < 0.15 * off[0] + 1e-9


def test_the_order_of_the_robots_does_not_matter(dual_ur5, exact):
    """The object goes where the hands carry it on the mean, so no hand is the one that is believed."""
    noisy = perturbed(exact["turn", 101][0], 8e-4)
    columns = columns_of(dual_ur5, noisy)
    parts = [{name[len(part) + 1 :]: columns[name] for name in columns if name.startswith(f"{part}.")}
             for part in ("q", "dq", "ddq")]  # fmt: skip
    table = mrts.JointTable(UR5 / "joints.csv", noisy.object.time, *parts)
    object_of_mean = coordinate(dual_ur5, table).object
    carried = []
    for robot, tip in zip(dual_ur5.robots, tip_motions(dual_ur5, noisy.q, noisy.dq, noisy.ddq), strict=True):
        rotation = tip.rotation @ robot.T_object_tip.R.T
        carried.append(tip.position - rotation @ robot.T_object_tip.p)
    np.testing.assert_allclose(object_of_mean.position, np.mean(carried, axis=0), atol=1e-12)


def test_a_given_object_stays_where_it_is(dual_ur5, exact):
    followed, c2 = exact["turn", 101]
    found = mrts.scale(dual_ur5, perturbed(followed, 5e-4))
    assert_closed(dual_ur5, found.motion)
    np.testing.assert_array_equal(found.motion.object.position, followed.object.position)
    np.testing.assert_allclose(found.motion.q, followed.q, atol=1e-9)
    assert found.range.upper.c2 == pytest.approx(c2, rel=1e-6)


def test_exact_joints_are_left_as_they_are(dual_ur5, exact):
    followed, _ = exact["turn", 101]
    assert coordinate(dual_ur5, followed) is followed


def test_the_bound_on_the_gap_is_an_option(tmp_path, dual_ur5, exact, capsys):
    path = write_table(tmp_path / "joints.csv", columns_of(dual_ur5, perturbed(exact["turn", 101][0], 4e-3)))
    command = ["scale", str(UR5 / "cell.yaml"), str(path)]
    assert main(command) == 2
    said = capsys.readouterr().err
    for words in (
        "The tip of 'right' is off its grasp by",
        " at sample ",
        "0.002 m and 0.005 rad are allowed",
        "--closure",
    ):
        assert words in said
    assert main([*command, "--closure", "0.02"]) == 0
    assert main([*command, "--closure", "0.02,0.001"]) == 2
    assert "0.02 m and 0.001 rad are allowed" in capsys.readouterr().err
    closed = mrts.scale(dual_ur5, mrts.load_motion(path), closure=mrts.ClosureBound(0.02)).motion
    assert_closed(dual_ur5, closed)
    for text, words in (
        ("much", "--closure = 'much': must be a number in m, or m and rad"),
        ("1,2,3", "--closure = '1,2,3'"),
        ("-1", "--closure: position = -1.0: must be > 0"),
        ("nan", "must be > 0 and at most 0.1"),
        ("0.01,inf", "--closure: rotation = inf"),
    ):
        assert main([*command, f"--closure={text}"]) == 2
        assert words in capsys.readouterr().err
    with pytest.raises(mrts.InputError, match=r"closure.*ClosureBound"):
        mrts.scale(dual_ur5, mrts.load_motion(path), closure=0.02)


def test_a_tighter_bound_is_kept(tmp_path, dual_ur5, exact):
    path = write_table(tmp_path / "joints.csv", columns_of(dual_ur5, exact["turn", 101][0]), ".5f")
    assert read(dual_ur5, path).status.admits_motion
    with pytest.raises(mrts.MotionError, match=r"do not close the chain.* 1e-06 m and 2.5e-06 rad are allowed"):
        mrts.scale(dual_ur5, mrts.load_motion(path), closure=mrts.ClosureBound(1e-6))


def scaled(columns, prefix, factor):
    return {name: values * (factor if name.startswith(prefix) else 1) for name, values in columns.items()}


def swapped(columns, one, other):
    names = {one: other, other: one}
    return {names.get(name, name): values for name, values in columns.items()}


JOINT_MISTAKES = {
    "degrees a second": lambda columns: scaled(columns, "dq.", 180 / np.pi),
    "degrees a second, one joint": lambda columns: scaled(columns, "dq.right/elbow", 180 / np.pi),
    "degrees": lambda columns: scaled(columns, "q.", 180 / np.pi),
    "sign of velocities": lambda columns: scaled(columns, "dq.left", -1),
    "sign of accelerations": lambda columns: scaled(columns, "ddq.right", -1),
    "accelerations too large by half": lambda columns: scaled(columns, "ddq.", 1.5),
    "milliseconds": lambda columns: scaled(columns, "t", 1000),
    "joints swapped": lambda columns: swapped(columns, "q.left/elbow", "q.left/wrist_1_turn"),
    "velocities swapped": lambda columns: swapped(columns, "dq.left/elbow", "dq.left/wrist_1_turn"),
    "no velocities": lambda columns: scaled(columns, "dq.", 0),
    "one arm late": lambda columns: {
        name: np.roll(values, 10) if "left" in name else values for name, values in columns.items()
    },
}


@pytest.mark.parametrize("mistake", JOINT_MISTAKES)
@pytest.mark.parametrize(("samples", "form"), [(101, ".12g"), (101, ".5g"), (11, ".5g")])
def test_wrong_joint_tables_are_refused(tmp_path, dual_ur5, exact, mistake, samples, form):
    """At any number of digits and rows."""
    columns = JOINT_MISTAKES[mistake](columns_of(dual_ur5, exact["turn", samples][0]))
    with pytest.raises(mrts.MrtsError, match=r"do not lead|do not close|do not fit|position limit"):
        read(dual_ur5, write_table(tmp_path / "joints.csv", columns, form))


OBJECT_MISTAKES = {
    "millimetres a second": lambda columns: scaled(columns, "v", 1000),
    "degrees a second": lambda columns: scaled(columns, "w", 180 / np.pi),
    "axes swapped": lambda columns: swapped(columns, "vy", "vz"),
    "sign": lambda columns: scaled(columns, "vy", -1),
    "sign of accelerations": lambda columns: scaled(columns, "ay", -1),
    "milliseconds": lambda columns: scaled(columns, "t", 1000),
    "accelerations too large by half": lambda columns: scaled(columns, "a", 1.5),
}


@pytest.mark.parametrize("mistake", OBJECT_MISTAKES)
@pytest.mark.parametrize(("samples", "form"), [(101, ".12g"), (101, ".5g"), (11, ".5g")])
def test_wrong_object_tables_are_refused(tmp_path, exact, mistake, samples, form):
    columns = OBJECT_MISTAKES[mistake](object_columns(exact["turn", samples][0].object, rates=True))
    with pytest.raises(mrts.InputError, match="do not lead"):
        mrts.load_motion(write_table(tmp_path / "object.csv", columns, form))


SMALL_MISTAKES = {
    "millimetres for metres": (1e-3, 1e-3),
    "sign": (-1, -1),
    "sign of accelerations": (1, -1),
    "accelerations twice": (1, 2),
    "no accelerations": (1, 0),
    "no velocities": (0, 0),
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


def test_positions_that_are_noise_twice_differentiated_are_refused(tmp_path, dual_ur5, exact):
    followed, c2 = exact["turn", 101]
    noise = np.random.default_rng(5).normal(size=followed.q.shape)
    rough = replace(followed, q=followed.q + 1e-6 * noise)
    found = read(dual_ur5, write_table(tmp_path / "joints.csv", columns_of(dual_ur5, rough, ("q",))))
    assert found.range.upper.c2 == pytest.approx(c2, rel=0.05)
    rougher = replace(followed, q=followed.q + 3e-5 * noise)
    with pytest.raises(mrts.MotionError, match="accelerations, which were found from the positions, are rough"):
        read(dual_ur5, write_table(tmp_path / "joints.csv", columns_of(dual_ur5, rougher, ("q",))))


@pytest.mark.parametrize(
    ("form", "unit"), [(".5f", 1e-5), (".3f", 1e-3), (".5g", 1e-5), (".8g", 1e-8), (".12g", 0), (".17g", 0)]
)
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
    (spline,), (moved_by,) = splines_through(time, values[:, None])
    assert 0 < moved_by < 2e-5
    np.testing.assert_allclose(spline(time, 2), -np.sin(time), atol=0.01)
    assert np.max(np.abs(CubicSpline(time, values)(time, 2) + np.sin(time))) > 5
    (spline,), (moved_by,) = splines_through(time, np.sin(time)[:, None])
    assert moved_by == 0
    np.testing.assert_array_equal(spline(time), np.sin(time))


def test_the_digits_of_the_smallest_numbers_do_not_overflow():
    assert rounding(np.array([0.0, 1e-320, 0.25])) == pytest.approx(rounding(np.array([0.0, 0.0, 0.25])))
