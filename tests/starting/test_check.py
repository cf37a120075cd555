"""`mrts.check`: what is wrong, assumed, out of reach, and its cause, against what was damaged on purpose."""

import json
import re

import damaged_cells
import numpy as np
import pytest
from conftest import DATA, UR5
from damaged_cells import HINTS, MISTAKES, damaged, sound, written
from draws import draws
from published_robots import single_arm_cell
from shipped_cells import changed_cell, shipped_motion

import mrts
from mrts.base.errors import InputError
from mrts.cell.cell import cell_to_compile
from mrts.cell.remarks import POINT_MASSES, WEIGHTLESS
from mrts.starting.check import joint_table
from mrts.starting.request import request_of

SHIPPED = [
    (DATA / "cell.yaml", DATA / "lift.yaml"),
    (UR5 / "poor_cell.yaml", UR5 / "lift_and_turn.yaml"),
    (DATA.parent / "squeeze" / "cell.yaml", DATA.parent / "squeeze" / "lift_and_turn.yaml"),
]


@pytest.mark.parametrize(("cell", "motion"), SHIPPED, ids=lambda path: f"{path.parent.name}/{path.stem}")
def test_what_is_shipped_is_fine_and_leads_to_no_hint(cell, motion):
    found = mrts.check(cell, motion)
    assert (found.status, found.mistakes, found.hints) == ("fine", (), ())
    assert all(arm.follows and arm.nearest_limit for arm in found.arms)
    assert "None" not in str(found)


@pytest.mark.parametrize("damage", HINTS)
def test_a_likely_mistake_is_named_and_nothing_else(damage, tmp_path):
    rng = np.random.default_rng(len(damage))
    found = mrts.check(*written(tmp_path, *damaged(damage, int(rng.integers(2)))))
    assert [hint.code for hint in found.hints] == [HINTS[damage][0]]
    assert not found.mistakes


WHOLE_TURNS = 'lower="-6.283185307179586" upper="6.283185307179586"'


@pytest.mark.parametrize(
    ("wrong", "code"),
    [
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
    if code == "limits-equal":
        with pytest.raises(mrts.InputError, match=r"cannot move shoulder_pan: the upper"):
            request_of(tmp_path, **given)
    else:
        assert request_of(tmp_path, **given).arms


def test_a_posture_outside_the_joint_limits_is_told(dual_ur5):
    left = dual_ur5.robots[0]
    found = dual_ur5.with_postures({left.name: [*left.posture[:2], 3.5, *left.posture[3:]]})
    assert [one.code for one in found.all_remarks if one not in dual_ur5.all_remarks] == ["posture-outside"]


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


def test_a_posture_that_works_is_named_where_the_given_one_does_not(dual_ur5, tmp_path):
    """A long way with a turn, which the arm's other elbow does not reach."""
    cell, motion = sound()
    motion["end"] = {"xyz": [0.1, 0.3, 0.6], "rpy": [0.2, 0, 1.2]}
    cell["robots"][0]["base"]["xyz"] = [-0.7, 0, 0]
    cell["robots"][0]["posture"] = [-3.1666, -1.6203, 1.7971, -0.1768, -4.7374, -1.5708]
    paths = written(tmp_path, cell, motion)
    left = mrts.check(*paths).arms[0]
    path = mrts.load_motion(paths[1])
    alone = dual_ur5.with_values({"robots.left.base.xyz": [-0.7, 0, 0], "robots.right.base.xyz": [0.6, 0.3, 0]})
    given = cell["robots"][0]["posture"]
    with pytest.raises(mrts.MotionError, match="robot 'left'", check=lambda error: str(error) == left.failure):
        mrts.follow_object(alone.with_postures({"left": given}), path)
    mrts.follow_object(alone.with_postures({"left": left.posture.tolist()}), path)


@pytest.mark.quick
def test_cells_and_motions_of_python_are_checked_as_their_files_are():
    files = DATA / "cell.yaml", DATA / "lift.yaml"
    expected, cell = mrts.check(*files), mrts.load_cell(files[0])
    keys = shipped_motion()
    for motion in (keys, mrts.load_motion(keys)):
        found = mrts.check(cell, motion)
        assert (found.status, found.arms) == ("fine", expected.arms)
        assert list(joint_table(found.robots)) == list(joint_table(expected.robots))
        assert [remark.code for remark in found.remarks] == [remark.code for remark in expected.remarks]
    assert mrts.check(cell, mrts.follow_object(cell, mrts.load_motion(keys))).status == "fine"
    wrong = mrts.check(cell, keys | {"profile": "fast", "speed": 1})
    assert [(error.where, error.key) for error in wrong.mistakes] == [("motion", ""), ("motion", "profile")]
    far = cell.with_values({"robots[1].base": {"xyz": [4.3, 0, 0]}})
    near, lost = mrts.check(far, keys).arms
    assert (near.follows, lost.follows, lost.ways) == (True, False, 0)


def test_no_way_out_of_reach_leads_to_the_end(tmp_path):
    """The right arm holds the object at its start."""
    cell, motion = sound()
    motion["end"]["xyz"] = [-1.5, 0.3, 0.5]
    right = mrts.check(*written(tmp_path, cell, motion)).arms[1]
    assert right.ways > 1
    assert (right.follows, right.posture) == (False, None)


Y, Z = "0 1 0", "0 0 1"
LINK = (
    '<link name="{}"><inertial><mass value="2"/><inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/>'
    "</inertial></link>"
)
JOINT = (
    '<joint name="j{0}" type="{1}"><parent link="l{2}"/><child link="l{0}"/><origin xyz="{3}"/><axis xyz="{4}"/>'
    '<limit lower="-2.5" upper="2.5" effort="150" velocity="3"/></joint>'
)


def arm(folder, axes, up="0 0 0.2"):
    """A URDF of joints with given axes at zero, each above the one before; one given with 'slide' is prismatic."""
    parts = ['<robot name="arm">', LINK.format("l0")]
    for number, axis in enumerate(axes, start=1):
        kind = "prismatic" if axis.startswith("slide ") else "revolute"
        parts.append(LINK.format(f"l{number}"))
        parts.append(JOINT.format(number, kind, number - 1, up, axis.removeprefix("slide ")))
    path = folder / "arm.urdf"
    path.write_text("\n".join([*parts, "</robot>"]), encoding="utf-8")
    return path


ARMS = {
    "two axes in one line": ([Z, Y, Y, Y, Z, Z], "0 0 0.2", 5, "j5, j6 together give only 1"),
    "four parallel axes": ([Z, Y, Y, Y, Y, Z], "0 0 0.2", 5, "j2, j3, j4, j5 together give only 3"),
    "all axes upright": ([Z, Z, Z, Z, Z, "slide " + Z], "0.2 0 0.1", 4, "In no posture does it move about x, about y"),
}


@pytest.mark.parametrize("name", ARMS)
def test_the_rank_and_what_is_lost_are_told(name, tmp_path):
    axes, up, rank, said = ARMS[name]
    urdf = arm(tmp_path, axes, up)
    cell, motion = sound()
    for robot in cell["robots"]:
        robot |= {"urdf": str(urdf), "tip_link": f"l{len(axes)}", "posture": [0.3] * len(axes), "torque": [100] * 6}
    found = mrts.check(*written(tmp_path, cell, motion))
    (mistake,) = found.mistakes
    assert (found.status, mistake.key) == ("wrong-input", "robot 'left'")
    assert f"in {rank} independent directions, but holding the object takes 6" in mistake.rule
    assert said in mistake.rule
    with pytest.raises(InputError, check=lambda error: error.rule == mistake.rule):
        mrts.follow_object(cell_to_compile(tmp_path / "cell.yaml"), mrts.load_motion(tmp_path / "motion.yaml"))
    given = {"name": "cell", "robots": [str(urdf)], "tips": [f"l{len(axes)}"]}
    with pytest.raises(InputError, match=f"in {rank} independent", check=lambda error: error.where == str(urdf)):
        request_of(tmp_path, **given)


NO_EXTENT = 'ixx="0" ixy="0" ixz="0" iyy="0" iyz="0" izz="0"'


def test_links_without_mass_and_points_are_told(tmp_path):
    text = (DATA / "planar_arm.urdf").read_text(encoding="utf-8")
    for mass, given in (("4", "0"), ("0.5", "0.5")):
        text = re.sub(
            rf'<mass value="{mass}"/>\s*<inertia [^>]*>', f'<mass value="{given}"/><inertia {NO_EXTENT}/>', text
        )
    (tmp_path / "arm.urdf").write_text(text)
    path = changed_cell(tmp_path, lambda cell: cell["robots"][0].update(urdf="arm.urdf"))
    assert {remark.code: remark.text for remark in mrts.check(path).warnings} == {
        "links-without-mass": f"{WEIGHTLESS} (left: elbow)",
        "links-without-inertia": f"{POINT_MASSES} (left: hand)",
    }
