"""`contact` of a cell file: what it becomes, and what is refused with file, key, value and rule."""

import numpy as np
import pytest
from conftest import DATA
from shipped_cells import changed_cell

import mrts

PAD = {"friction": 0.5, "normal": [0, 0, 1], "half_width": [0.03, 0.02], "force": [0, 100]}
CUP = {"holding_force": 80, "friction": 0.5, "radius": 0.03, "normal": [0, 0, 1]}
JAWS = {"force": 60, "friction": 0.5, "half_width": [0.02, 0.01], "axis": [0, 1, 0]}
FLAT = {"friction": 0.5, "normal": [0, 1, 0], "half_width": [0.03], "force": [0, 100]}


def cell_with(contacts, place, name="dual_ur5", **change):
    """A shipped cell with contacts of the left robot."""
    return changed_cell(place, lambda cell: cell["robots"][0].update(contact=contacts, **change), name)


def planar_with(contacts, place, **change):
    return cell_with(contacts, place, "planar_dual_arm", **change)


def test_contacts_are_read_in_order_and_named_by_kind(tmp_path):
    rows = {"A": [[0, 0, -1, 0, 0, 0], [0, 0, 1, 0, 0, 0]], "upper": [3, 200]}
    box = {"upper": [None, 40, None, None, None, 3], "frame": "object"}
    given = [{"pad": PAD}, {"suction": CUP}, {"gripper": JAWS}, {"rows": rows}, {"box": box}, {"pad": PAD}]
    cell = mrts.load_cell(cell_with(given, tmp_path))
    left, right = cell.robots
    assert right.contacts == ()
    assert [contact.name for contact in left.contacts] == ["pad", "suction", "gripper", "rows", "box", "pad2"]
    assert [len(contact.rows) for contact in left.contacts] == [17, 17, 30, 2, 2, 17]
    assert [contact.frame for contact in left.contacts] == ["tip"] * 4 + ["object", "tip"]
    (made,) = cell.with_values({"robots.right.contact": [{"pad": PAD}]}).robots[1].contacts
    read = left.contacts[0]
    assert read.rows == made.rows
    for array in ("A", "lower", "upper"):
        assert np.array_equal(getattr(read, array), getattr(made, array))
    assert (left.contacts[4].rows, left.contacts[4].units) == (("fy", "nz"), ("N", "N m"))
    assert cell.without_wrench_limits().robots[0].contacts == ()


WRONG = [
    ([{"pad": PAD | {"normal": [0, 0, 0]}}], "[0].pad.normal", "zero length"),
    ([{"pad": PAD | {"normal": [0, 1]}}], "[0].pad.normal", "has 2 values, at least 3 belong here"),
    ([{"pad": PAD | {"friction": -0.5}}], "[0].pad.friction", "must be >= 1e-06"),
    ([{"suction": CUP | {"holding_force": -1}}], "[0].suction.holding_force", "must be >= 1e-06"),
    ([{"suction": CUP | {"radius": 0}}], "[0].suction.radius", "must be >= 1e-06"),
    ([{"gripper": JAWS | {"force": 0}}], "[0].gripper.force", "must be >= 1e-06"),
    ([{"pad": PAD | {"half_width": [0.03]}}], "[0].pad.half_width", "must be [a, b]"),
    ([{"pad": PAD | {"force": [50, 20]}}], "[0].pad.force", "0 <= least < most"),
    ([{"pad": PAD | {"force": [-5, 20]}}], "[0].pad.force", "cannot pull"),
    ([{"pad": PAD | {"force": [0, float("inf")]}}], "[0].pad.force[1]", "finite"),
    ([{"pad": PAD | {"wide": 1}}], "[0].pad", "unknown key 'wide'"),
    ([{"pad": {"friction": 0.5}}], "[0].pad.normal", "this key is required"),
    ([{"pad": PAD, "box": {"upper": [1] * 6}}], "[0]", "is one of box, pad, suction, gripper, rows"),
    ([{"box": {}}], "[0].box", "must limit something"),
    ([{"box": {"upper": [1, 2, 3]}}], "[0].box.upper", "must have 6 values (fx, fy, fz, nx, ny, nz)"),
    ([{"box": {"lower": [2] * 6, "upper": [1] * 6}}], "[0].box.lower, upper = [2.0, 1.0]", "row 'fx' must"),
    ([{"box": {"upper": [1] * 6, "frame": "hand"}}], "[0].box.frame", "must be 'tip', 'object' or 'base'"),
    ([{"rows": {"A": [[1, 0, 0, 0, 0]], "upper": [1]}}], "[0].rows.A", "each of fx, fy"),
    ([{"rows": {"A": [[1, 0, 0, 0, 0, 0]], "upper": [1, 2]}}], "[0].rows.A", "2 rows, as many as upper"),
    ([{"rows": {"A": [[0] * 6], "upper": [1]}}], "[0].rows.lower, upper", "row '1' must hold a number beside 0"),
    ([{"pad": PAD}] * 21, "", "has 21 values, at most 20"),
]
WRONG_IN_A_PLANE = [
    ([{"pad": FLAT | {"normal": [0, 0, 1]}}], "[0].pad.normal", "must lie in the plane"),
    ([{"pad": FLAT | {"half_width": [0.1, 0.1]}}], "[0].pad.half_width", "the contact is a line"),
    ([{"gripper": JAWS | {"half_width": [0.02], "axis": [0, 0, 1]}}], "[0].gripper.axis", "must lie in the plane"),
    ([{"box": {"upper": [1] * 6}}], "[0].box.upper", "must have 3 values (fx, fy, nz)"),
    ([{"rows": {"A": [[1] * 6], "upper": [1]}}], "[0].rows.A", "each of "),
]


@pytest.mark.parametrize(
    ("make", "contacts", "key", "rule"),
    [*((cell_with, *each) for each in WRONG), *((planar_with, *each) for each in WRONG_IN_A_PLANE)],
)
def test_what_cannot_be_is_refused_by_file_key_and_rule(make, contacts, key, rule, tmp_path):
    path = make(contacts, tmp_path)
    with pytest.raises(mrts.InputError) as error:
        mrts.load_cell(path)
    said = str(error.value)
    assert str(path) in said
    assert rule in said
    assert f"contact{key}" in said.replace(" (left)", "")


def tilted(place, turn):
    """The planar arm with a tip frame that is turned out of the plane."""
    text = (DATA / "planar_arm.urdf").read_text()
    fixed = (
        '<link name="turned"/><joint name="turn" type="fixed"><parent link="contact"/><child link="turned"/>'
        f'<origin xyz="0 0 0" rpy="{turn}"/></joint></robot>'
    )
    (place / "tilted.urdf").write_text(text.replace("</robot>", fixed))
    return str(place / "tilted.urdf")


def test_tip_axes_of_a_planar_cell_are_those_in_its_plane(tmp_path):
    """A tip link whose y axis is normal to the plane has forces along x and z; one that is askew has no tip axes."""
    turn = "1.5707963267948966 0 0"
    change = {"urdf": tilted(tmp_path, turn), "tip_link": "turned", "wrench": {}}
    grasp = {"xyz": [-1.1, 0, 0], "rpy": [1.5707963267948966, 0, 0]}
    wrong = {"lower": [None] * 3, "upper": [1] * 4}
    with pytest.raises(mrts.InputError, match=r"\(fx, fz, ny\)"):
        mrts.load_cell(planar_with([{"box": wrong}], tmp_path, grasp=grasp, **change))
    limits = {"lower": [-3, -4, -2], "upper": [5, 6, 0.5]}
    turned = mrts.load_cell(planar_with([{"box": limits}], tmp_path, grasp=grasp, **change))
    # tip x, z, y are object x, -y, z up to sign: R = Rx(90°) turns z to -y and y to z
    same = {"lower": [-3, -6, -2], "upper": [5, 4, 0.5], "frame": "object"}
    straight = mrts.load_cell(planar_with([{"box": same}], tmp_path, wrench={}))
    lift = mrts.load_motion(DATA / "lift.yaml")
    ours, theirs = mrts.scale(turned, lift), mrts.scale(straight, lift)
    assert ours.range.upper.c2 == pytest.approx(theirs.range.upper.c2, rel=1e-9)
    np.testing.assert_allclose(ours.trajectory.torque, theirs.trajectory.torque, atol=1e-6)
    assert max(use.share for use in ours.trajectory.limit_uses if use.name.kind == "contact") > 0.99
    change = {"urdf": tilted(tmp_path, "0.3 0 0"), "tip_link": "turned", "wrench": {}}
    askew = {"xyz": [-1.1, 0, 0], "rpy": [0.3, 0, 0]}
    with pytest.raises(mrts.InputError, match="one must be normal to the plane"):
        mrts.load_cell(planar_with([{"box": limits}], tmp_path, grasp=askew, **change))
    again = mrts.load_cell(planar_with([{"box": same}], tmp_path, grasp=askew, **change))
    assert mrts.scale(again, lift).range.upper.c2 == pytest.approx(theirs.range.upper.c2, rel=1e-9)
