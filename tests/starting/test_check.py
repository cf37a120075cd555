"""`mrts.check`: what is wrong, assumed, and out of reach, against what was damaged on purpose."""

import json
import re

import damaged_cells
import numpy as np
import pytest
from conftest import DATA, UR5
from damaged_cells import HINTS, MISTAKES, damaged, sound, written
from draws import draws
from published_robots import single_arm_cell
from shipped_cells import shipped, shipped_motion

import mrts
from mrts.starting.reading import HOPELESS, request_of

SHIPPED = [
    (DATA / "cell.yaml", DATA / "lift.yaml"),
    (UR5 / "poor_cell.yaml", UR5 / "lift_and_turn.yaml"),
    (DATA.parent / "squeeze" / "cell.yaml", DATA.parent / "squeeze" / "lift_and_turn.yaml"),
]

SEARCHED = 1e-4
"""What the search for the nearest place leaves of a distance [m]: a weight, not a rule, keeps the hand turned."""


@pytest.mark.parametrize(("cell", "motion"), SHIPPED, ids=lambda path: f"{path.parent.name}/{path.stem}")
def test_what_is_shipped_is_fine_and_leads_to_no_hint(cell, motion):
    found = mrts.check(cell, motion)
    assert (found.status, found.mistakes, found.hints) == ("fine", (), ())
    assert all(arm.follows and arm.margin is not None for arm in found.arms)
    assert "None" not in str(found)


@pytest.mark.parametrize("damage", HINTS)
def test_a_likely_mistake_is_named_and_nothing_else(damage, tmp_path):
    rng = np.random.default_rng(len(damage))
    found = mrts.check(*written(tmp_path, *damaged(damage, int(rng.integers(2)))))
    assert [hint.code for hint in found.hints] == [HINTS[damage][0]]
    assert not found.mistakes


TORQUE, VELOCITY, MASS = 'effort="28"', 'velocity="3.141592653589793"', '<mass value="'


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({TORQUE: 'effort="2.8"'}, ["wrist_1", "torque", "28 N m (URDF)", "2.8 N m (URDF)", "10-fold"]),
        (
            {TORQUE: 'effort="2"', VELOCITY: 'velocity="180"'},
            ["shoulder_pan", "velocity", "3.142 rad/s (URDF)", "180 rad/s (URDF)", "57.3-fold"],
        ),
        ({TORQUE: 'effort="3"', VELOCITY: 'velocity="0.4"'}, None),
        ({TORQUE: 'effort="2.8"', MASS: '<mass value="1'}, None),
    ],
)
def test_limits_that_differ_tenfold_between_alike_arms_are_told_once(changes, told, tmp_path):
    (cell, motion), text = sound(), damaged_cells.URDF.read_text(encoding="utf-8")
    for old, new in changes.items():
        text = text.replace(old, new, 1)
    urdf = tmp_path / "arm.urdf"
    urdf.write_text(text, encoding="utf-8")
    cell["robots"][1]["urdf"] = str(urdf)
    found = mrts.check(*written(tmp_path, cell, motion))
    assert [hint.code for hint in found.hints] == (["limits-unlike"] if told else [])
    for words in told or ():
        assert words in found.hints[0].text
    assert found.status == "fine"


WHOLE_TURNS = 'lower="-6.283185307179586" upper="6.283185307179586"'


def in_mm(text):
    numbers = re.compile('xyz="([^"]*)"')
    return numbers.sub(lambda xyz: 'xyz="' + " ".join(f"{1000 * float(word)}" for word in xyz[1].split()) + '"', text)


@pytest.mark.parametrize(
    ("wrong", "code"),
    [
        (in_mm, "urdf-millimetres"),
        (lambda text: text.replace(WHOLE_TURNS, 'lower="0" upper="0"', 1), "limits-equal"),
        (lambda text: text.replace(WHOLE_TURNS, 'lower="-360" upper="360"'), "limits-degrees"),
    ],
)
def test_numbers_of_a_urdf_that_no_arm_has_are_named(wrong, code, tmp_path):
    """And no cell is begun where none could move."""
    urdf = tmp_path / "arm.urdf"
    urdf.write_text(wrong((UR5 / "ur5_class_arm.urdf").read_text(encoding="utf-8")), encoding="utf-8")
    assert [hint.code for hint in mrts.check(single_arm_cell(tmp_path, str(urdf), "tool0", 6)).hints] == [code]
    given = {"name": "cell", "robots": [str(urdf)]}
    if code in HOPELESS:
        with pytest.raises(mrts.InputError, match=r"seem to be in mm|cannot move shoulder_pan: the upper"):
            request_of(tmp_path, **given)
    else:
        assert request_of(tmp_path, **given).arms


@pytest.mark.quick
def test_all_that_is_wrong_is_told_at_once(tmp_path):
    rng = np.random.default_rng(19)
    for _ in range(draws(25)):
        cell, motion = sound()
        chosen = rng.choice([*MISTAKES], size=rng.integers(2, 7), replace=False)
        for key in chosen:
            MISTAKES[key](cell, motion)
        paths = written(tmp_path, cell, motion)
        found = mrts.check(*paths)
        told = [str(mistake) for mistake in found.mistakes]
        assert found.status == "wrong-input"
        for key in chosen:
            assert any(key in text for text in told), (key, told)
        assert len({*told}) == len(told)
        assert all(mistake.where in {*map(str, paths), str(damaged_cells.URDF)} for mistake in found.mistakes)
        assert [entry["text"] for entry in json.loads(found.json_text())["mistakes"]] == told


def test_what_is_wrong_in_urdfs_is_told_besides_what_is_wrong_in_the_cell(tmp_path):
    cell, motion = sound()
    text = damaged_cells.URDF.read_text(encoding="utf-8").replace('effort="28"', 'effort="0"')
    (tmp_path / "arm.urdf").write_text(text.replace('<mass value="', '<mass value="-', 1), encoding="utf-8")
    cell["robots"][0]["urdf"] = "arm.urdf"
    paths = written(tmp_path, cell, motion)
    alone = [str(mistake) for mistake in mrts.check(*paths).mistakes]
    assert any("mass" in text for text in alone)
    with pytest.raises(mrts.InputError) as caught:
        mrts.load_cell(paths[0])
    assert [str(each) for each in caught.value.each()] == alone
    cell["object"]["mass"] = -1
    told = [str(mistake) for mistake in mrts.check(*written(tmp_path, cell, motion)).mistakes]
    assert {*alone} <= {*told}
    assert any("object.mass" in text for text in told)


def test_the_gap_of_a_planar_arm_is_what_its_links_lack(tmp_path):
    """Two links reach the sum of their lengths; what is missing lies along the stretched arm."""
    rng = np.random.default_rng(5)
    cell, motion = shipped(), shipped_motion(samples=11)
    for _ in range(draws(3)):
        angle = rng.uniform(-np.pi, np.pi)
        cell["robots"][0]["base"]["xyz"] = [float(4 * np.cos(angle)), float(4 * np.sin(angle)), 0.0]
        found = mrts.check(*written(tmp_path, cell, motion))
        left, right = found.arms
        assert right.follows
        assert not left.follows
        robot, path = _uncompiled(tmp_path / "cell.yaml").robots[0], mrts.load_motion(tmp_path / "motion.yaml")
        tip = path.position[0] + path.rotation[0] @ robot.T_object_tip.p
        R = path.rotation[0] @ robot.T_object_tip.R
        wrist = tip - R @ robot.T_base_tip.R.T @ (robot.T_base_tip.p - robot.points[2]) - robot.T_world_base.p
        lengths = np.linalg.norm(np.diff(robot.points, axis=0), axis=1)
        missing = wrist * (1 - np.sum(lengths) / np.linalg.norm(wrist))
        np.testing.assert_allclose(left.nearest.off, missing, atol=SEARCHED)
        assert left.nearest.turn < 10 * SEARCHED


def _uncompiled(path):
    from mrts.cell.loading import uncompiled_cell  # noqa: PLC0415
    from mrts.cell.source_files import read_without_generating  # noqa: PLC0415

    return uncompiled_cell(read_without_generating(path)[0], path.parent)


def test_a_proposed_move_lets_the_compiled_cell_follow(dual_ur5, tmp_path):
    cell, motion = sound()
    cell["robots"][0]["base"]["xyz"] = [-1.1, -0.1, 0.1]
    paths = written(tmp_path, cell, motion)
    left, right = mrts.check(*paths).arms
    assert right.follows
    assert left.shift is not None
    far = dual_ur5.with_values({"robots.left.base.xyz": [-1.1, -0.1, 0.1]})
    path = mrts.load_motion(paths[1])
    with pytest.raises(mrts.MotionError) as caught:
        mrts.follow_object(far, path)
    assert str(caught.value) == left.failure
    mrts.follow_object(dual_ur5.with_values({"robots.left.base.xyz": np.add(left.shift, [-1.1, -0.1, 0.1])}), path)


def test_a_posture_that_works_is_named_where_the_given_one_does_not(dual_ur5, tmp_path):
    """A long way with a turn, which the arm's other elbow does not reach."""
    cell, motion = sound()
    motion["end"] = {"xyz": [0.1, 0.3, 0.6], "rpy": [0.2, 0, 1.2]}
    cell["robots"][0]["base"]["xyz"] = [-0.7, 0, 0]
    cell["robots"][0]["posture"] = [-3.1666, -1.6203, 1.7971, -0.1768, -4.7374, -1.5708]
    paths = written(tmp_path, cell, motion)
    left = mrts.check(*paths).arms[0]
    path = mrts.load_motion(paths[1])
    alone = dual_ur5.with_values({"robots.left.base.xyz": [-0.7, 0, 0]}).with_values(
        {"robots.right.base.xyz": [0.6, 0.3, 0]}
    )
    given = cell["robots"][0]["posture"]
    with pytest.raises(mrts.MotionError, match="robot 'left'") as caught:
        mrts.follow_object(alone.with_postures({"left": given}), path)
    assert str(caught.value) == left.failure
    assert left.followed == left.samples
    mrts.follow_object(alone.with_postures({"left": left.posture.tolist()}), path)


@pytest.mark.quick
def test_cells_and_motions_of_python_are_checked_as_their_files_are():
    files = DATA / "cell.yaml", DATA / "lift.yaml"
    expected, cell = mrts.check(*files), mrts.load_cell(files[0])
    keys = shipped_motion()
    for motion in (keys, mrts.load_motion(keys)):
        found = mrts.check(cell, motion)
        assert (found.status, found.arms) == ("fine", expected.arms)
        assert found.to_json()["joints"] == expected.to_json()["joints"]
        assert [remark.code for remark in found.remarks] == [remark.code for remark in expected.remarks]
    assert mrts.check(cell, mrts.follow_object(cell, mrts.load_motion(keys))).status == "fine"
    wrong = mrts.check(cell, keys | {"profile": "fast", "speed": 1})
    assert [(error.where, error.key) for error in wrong.mistakes] == [("motion", ""), ("motion", "profile")]
    far = cell.with_values({"robots[1].base": {"xyz": [4.3, 0, 0]}})
    assert [arm.follows for arm in mrts.check(far, keys).arms] == [True, False]
