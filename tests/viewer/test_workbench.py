"""The workbench without a browser: what changes lead to, undo, gaps of arms that do not reach, and what is saved."""

import os
import shutil
import time
from dataclasses import replace

import numpy as np
import pytest
import trimesh
import yaml
from conftest import DATA

import mrts
from mrts.base.edited_yaml import edited_yaml
from mrts.base.rigid_transform import RigidTransform
from mrts.motion.motion_file import described_motion
from mrts.scene.cell_shapes import body_poses
from mrts.scene.held_body import held_body
from mrts.viewer.controls.places import Place, in_plane, moved_by, offset_of, places
from mrts.viewer.player_state import PlayerState
from mrts.viewer.workbench.choices import Choices, Given
from mrts.viewer.workbench.held_poses import tip_pose
from mrts.viewer.workbench.saved_choices import motion_text, save_choices
from mrts.viewer.workbench.workbench import Workbench

UR5 = DATA.parent / "dual_ur5"
PATIENCE = 60.0
"""[s]"""

SAME = 1e-9
"""Of numbers that were found twice by the same programs from numbers that passed through a text."""


@pytest.fixture
def planar(planar_cell, lift):
    return Given(planar_cell, lift, described_motion(DATA / "lift.yaml"))


@pytest.fixture
def spatial(dual_ur5):
    path = UR5 / "lift_and_turn.yaml"
    return Given(dual_ur5, mrts.load_motion(path), described_motion(path))


def answered(bench):
    """The newest answer, once there is nothing left to do."""
    end, errors = time.monotonic() + PATIENCE, []
    while True:
        waits = bench.waits
        errors += [one for one in bench.take() if isinstance(one, mrts.MrtsError)]
        if not waits:
            assert not errors, errors
            return bench.answer
        assert time.monotonic() < end
        time.sleep(0.001)


def changed(given, choices):
    bench = Workbench(given)
    bench.edit(choices)
    return answered(bench)


def test_each_change_has_the_answer_of_the_changed_cell(spatial):
    """The independent side changes the cell by its own methods and asks `mrts.scale` and `mrts.retime`."""
    cell, motion = spatial.cell, spatial.motion
    bench = Workbench(spatial)
    base, grasp = Place("base", "left"), Place("grasp", "right")
    shifted = moved_by(base.given_pose(spatial), np.array([0.02, -0.01, 0.0]), np.array([0.0, 0.0, 0.05]))
    regrasped = moved_by(grasp.given_pose(spatial), np.array([0.0, 0.01, 0.0]), np.zeros(3))
    start = bench.choices
    left = cell.robots[0]
    limits = left.torque_upper * np.where(np.array(left.joints) == "elbow", 0.2, 1.0)
    by_hand = {"xyz": [-0.78, -0.01, 0.0], "rpy": [0, 0, 0.05]}
    cases = {
        "mass": (replace(start, mass=11.0), cell.with_mass(11.0)),
        "limit": (start.with_limit(("torque", "left", "elbow"), 0.2), cell.with_values({"robots.left.torque": limits})),
        "base": (
            base.with_pose(start, shifted),
            cell.with_values({"robots.left.base": by_hand}),
        ),
        "grasp": (grasp.with_pose(start, regrasped), cell.with_values({"robots.right.grasp.xyz": [0.25, 0.01, 0.0]})),
    }
    for name, (choices, wanted) in cases.items():
        bench.edit(choices, name)
        found = answered(bench).state.result.range.upper.c2
        assert found == pytest.approx(mrts.scale(wanted, motion).range.upper.c2, rel=SAME), name
    bench.edit(replace(start, profile="optimal"))
    assert answered(bench).state.trajectory.duration == pytest.approx(mrts.retime(cell, motion).duration, rel=SAME)
    bench.edit(replace(start, shares=(0.7, 0.3)))
    fixed = mrts.scale(cell, motion, sharing=mrts.LoadSharing(np.array([0.7, 0.3])))
    assert answered(bench).state.result.range.upper.c2 == pytest.approx(fixed.range.upper.c2, rel=SAME)


def test_a_smooth_timing_keeps_its_rates_and_can_be_played_slower(planar):
    answer = changed(planar, Choices(profile="smooth", torque_rate=20.0))
    state = answer.state
    assert state.admissible
    assert state.trajectory.duration > mrts.retime(planar.cell, planar.motion).duration
    rate = np.abs(np.diff(state.trajectory.torque, axis=0) / np.diff(state.trajectory.time)[:, None])
    largest = 20.0 * np.concatenate([robot.torque_upper for robot in planar.cell.robots])
    assert np.max(rate / largest) < 1.001
    slower = state.at_speed(0.5)
    assert slower.trajectory.duration == pytest.approx(2 * state.trajectory.duration)
    assert state.trajectory.c == 1  # which stays as it was
    assert "smooth timing" in state.sentence()


def test_the_newest_of_many_changes_is_answered_and_undone_at_once(planar):
    bench = Workbench(planar)
    first = bench.answer.state.result.range.upper.c2
    for mass in np.linspace(0.6, 2.0, 40):
        bench.edit(replace(bench.choices, mass=float(mass)), "mass")
    assert answered(bench).choices.mass == 2.0
    bench.end_gesture()
    bench.edit(replace(bench.choices, mass=3.0), "mass")
    bench.undo()
    assert answered(bench).choices.mass == 2.0
    bench.undo()  # the whole gesture
    assert answered(bench).state.result.range.upper.c2 == first
    bench.undo()  # there is nothing before it
    assert answered(bench).choices.mass is None
    bench.redo()
    assert answered(bench).choices.mass == 2.0
    bench.reset()
    assert answered(bench).choices.mass is None


def test_a_corner_of_the_load_is_that_load(planar):
    given = replace(planar, cell=planar.cell.with_variation(mass=(0.5, 3.0)))
    everything = Workbench(given).answer.state.result.range.upper.c2
    heavy = changed(given, Choices(corner={"mass": 3.0})).state.result.range.upper.c2
    wanted = mrts.scale(given.cell.with_load(given.cell.load_box.load_at({"mass": 3.0})), given.motion)
    assert heavy == pytest.approx(wanted.range.upper.c2, rel=SAME)
    assert heavy >= everything * (1 - SAME)


def test_an_arm_that_does_not_reach_is_shown_as_near_as_it_comes(spatial):
    """The gap is the distance from the drawn tip to the grasp; the object still moves."""
    end = Place("end").given_pose(spatial)
    answer = changed(spatial, Choices(end=RigidTransform(end.R, end.p + np.array([0.0, 0.0, 0.6]))))
    found = answer.held
    assert answer.state is None
    assert "cannot reach" in answer.message
    lost = int(np.flatnonzero(~np.all(found.reached, axis=1))[0])
    assert 0 < lost < len(found.time) - 1
    for sample in (0, lost, len(found.time) - 1):
        for index, (robot, part) in enumerate(zip(found.cell.robots, found.cell.joint_slices.values(), strict=True)):
            R, p = body_poses(robot, found.q[sample : sample + 1, part])
            _, tip = tip_pose(robot, R[0], p[0])
            grasp = found.position[sample] + found.rotation[sample] @ robot.T_object_tip.p
            assert np.linalg.norm(tip - grasp) == pytest.approx(found.gap[sample, index], abs=1e-9)
    assert np.max(found.gap[-1]) > 0.05


def test_what_breaks_a_rule_is_told_and_leaves_the_answer(planar):
    bench = Workbench(planar)
    before = bench.answer
    bench.edit(replace(bench.choices, postures={"left": [0.0]}))
    answer = answered(bench)
    assert "robot 'left': posture = [0.0]" in answer.message
    bench.undo()
    assert answered(bench).state.result.range.upper.c2 == before.state.result.range.upper.c2


def test_a_ranked_configuration_is_played(planar):
    bench = Workbench(planar)
    assert bench.configuration_labels() == []
    bench.rank()
    answered(bench)
    labels = bench.configuration_labels()
    assert len(labels) == len(bench.study.ranked) == 4
    for label, configuration in zip(labels, bench.study.ranked, strict=True):
        bench.edit(bench.with_configuration(label))
        assert answered(bench).state.result.range.upper.c2 == pytest.approx(configuration.c2_upper, rel=1e-9)
    with pytest.raises(mrts.InputError, match="none of those that were ranked"):
        bench.with_configuration("5: left 9")


def test_a_joint_table_fixes_the_configuration_and_its_ends(planar, tmp_path):
    followed = mrts.follow_object(planar.cell, planar.motion)
    names = [f"{robot.name}/{joint}" for robot in planar.cell.robots for joint in robot.joints]
    columns = [dict(zip(names, part.T, strict=True)) for part in (followed.q, followed.dq, followed.ddq)]
    table = mrts.JointTable(tmp_path / "joints.csv", planar.motion.time, *columns)
    bench = Workbench(Given(planar.cell, table))
    assert "fixes the configuration" in bench.fixed_configuration
    assert {place.kind for place in places(bench.given)} == {"base", "grasp"}


def test_limits_that_are_passed_are_named_the_worst_first(dual_ur5, spatial):
    state = PlayerState(dual_ur5, spatial.motion)
    assert state.violations() == []
    state.choose_speed(state.speeds.upper)
    named = state.violations()
    assert named[0].name.kind == "velocity"
    assert [one.excess for one in named] == sorted((one.excess for one in named), reverse=True)
    assert named[0].excess == pytest.approx(state.excess.max(), rel=1e-12)


def test_poses_of_a_planar_cell_stay_in_its_plane(planar):
    given = Place("base", "left").given_pose(planar)
    wild = moved_by(given, np.array([0.1, 0.2, 0.3]), np.array([0.4, 0.5, 0.6]))
    shift, turn = offset_of(in_plane(planar.cell, wild, given), given)
    np.testing.assert_allclose(shift, [0.1, 0.2, 0.0], atol=1e-12)
    np.testing.assert_allclose(turn, [0.0, 0.0, 0.6], atol=1e-12)


def test_the_body_is_closed_and_spans_the_grasps(dual_ur5):
    """Each contact lies at the drawn body, even where the inertia says nothing of a handle there."""
    bare = replace(dual_ur5, object_shape=None)
    far = bare.with_values({"robots.left.grasp.xyz": [-0.6, 0.1, 0.3], "robots.right.grasp.xyz": [0.05, 0.02, 0.01]})
    for cell in (dual_ur5, bare, far):
        body = held_body(cell)
        mesh = trimesh.Trimesh(body.vertices, body.faces, process=False)
        assert mesh.is_watertight
        assert mesh.volume > 0
        contacts = np.array([robot.T_object_tip.p for robot in cell.robots])
        _, distance, _ = trimesh.proximity.closest_point(mesh, contacts)
        assert np.max(distance) < 0.1 * np.ptp(body.vertices)


@pytest.fixture
def files(tmp_path):
    folder = shutil.copytree(UR5, tmp_path / "cell")
    return folder / "cell.yaml", folder / "lift_and_turn.yaml"


def of_files(files):
    cell, motion = files
    return Given(mrts.load_cell(cell), mrts.load_motion(motion), described_motion(motion), cell, motion)


def test_saved_files_hold_what_was_changed_and_keep_the_rest(files):
    given = of_files(files)
    base, end = Place("base", "left"), Place("end")
    choices = replace(Choices(mass=9.5), end=moved_by(end.given_pose(given), np.array([0, 0, 0.05]), np.zeros(3)))
    choices = base.with_pose(choices, moved_by(base.given_pose(given), np.array([0.02, 0, 0]), np.array([0, 0, 0.1])))
    choices = choices.with_limit(("torque", "left", "elbow"), 0.5)
    (cell, motion), remark = save_choices(given, choices, "other.yaml", "moved.yml", overwrite=False)
    assert remark == ""
    shown, saved = changed(given, choices), mrts.scale(mrts.load_cell(cell), mrts.load_motion(motion))
    assert saved.range.upper.c2 == pytest.approx(shown.state.result.range.upper.c2, rel=SAME)
    lines, before = cell.read_text().splitlines(), files[0].read_text().splitlines()
    assert sum(line not in before for line in lines) == 3  # mass, base, and a key of torques
    assert "  mass: 9.5                              # kg" in lines
    assert sum("#" in line for line in lines) == sum("#" in line for line in before)


@pytest.mark.parametrize(
    "name",
    [
        *("../out.yaml", "/out.yaml", "a/b.yaml", ".hidden.yaml", "out.txt", "", "..", "x\n.yaml", "a\\b.yaml", "CON"),
        "🦾" * 90 + ".yaml",
    ],  # more bytes than a file system takes
)
def test_nothing_is_saved_elsewhere(files, name):
    given, before = of_files(files), sorted(os.walk(files[0].parent.parent))
    with pytest.raises(mrts.InputError, match="must be a name"):
        save_choices(given, Choices(), name, "", overwrite=True)
    with pytest.raises(mrts.InputError, match=r"must be a name|cell file"):
        save_choices(given, Choices(), "fine.yaml", name or "fine.yaml", overwrite=True)
    assert sorted(os.walk(files[0].parent.parent)) == before


def test_files_are_replaced_only_when_asked_and_links_never(files):
    given, text = of_files(files), files[0].read_text()
    with pytest.raises(mrts.InputError, match="exists already"):
        save_choices(given, Choices(mass=9.0), "new.yaml", "lift_and_turn.yaml", overwrite=False)
    assert not (files[0].parent / "new.yaml").exists()
    save_choices(given, Choices(mass=9.0), "cell.yaml", "", overwrite=True)
    assert files[0].read_text() == text.replace("mass: 8.0", "mass: 9")
    (files[0].parent / "link.yaml").symlink_to(files[1])
    with pytest.raises(mrts.InputError, match="is a link"):
        save_choices(given, Choices(), "link.yaml", "", overwrite=True)


@pytest.mark.quick
@pytest.mark.parametrize("which", ["start", "end"])
def test_an_end_that_the_file_repeats_moves_alone(which, tmp_path):
    """An alias is not where its value is written: such a file is written anew, and read here by `mrts`."""
    path = tmp_path / "motion.yaml"
    path.write_text("duration: 2\nprofile: sinusoid\nstart: &here {xyz: [1, 1, 0]}\nend: *here\n", encoding="utf-8")
    given = Given(None, None, described_motion(path), None, path)
    moved = RigidTransform(np.eye(3), np.array([1.0, 1.5, 0.0]))
    text, remark = motion_text(given, Choices(**{which: moved}))
    assert "motion file was written anew" in remark
    path.write_text(text, encoding="utf-8")
    ends = mrts.load_motion(path).position[[0, -1]]
    np.testing.assert_allclose(ends, [[1, 1.5, 0], [1, 1, 0]] if which == "start" else [[1, 1, 0], [1, 1.5, 0]])


@pytest.mark.parametrize(
    ("text", "keys", "value"),
    [
        ("a: 1  # one\nb: [1, 2]\n", ("b",), [3.5, 4.0]),
        ("a: 1  # one\nb: [1, 2]\n", ("c", "d"), 1e-3),
        ("r:\n  - base:\n      xyz:\n        - 1\n        - 2  # two\n  - {a: y}\n", ("r", 0, "base", "xyz"), [5.0]),
        ("r:\n  - name: x\n  - {name: y}  # why\n", ("r", 1, "base", "xyz"), [1.0, 2.0]),
        ("r:\n  - name: x  # end", ("r", 0, "posture"), [0.1, None]),
    ],
)  # fmt: skip
def test_an_edit_changes_one_value_and_no_comment(text, keys, value):
    done = edited_yaml(text, {keys: value})
    wanted = yaml.safe_load(text)
    place = wanted
    for key in keys[:-1]:
        place = place.setdefault(key, {}) if isinstance(place, dict) else place[key]
    place[keys[-1]] = value
    assert yaml.safe_load(done) == wanted
    assert all(comment in done for comment in ("# one", "# why", "# end") if comment in text)
