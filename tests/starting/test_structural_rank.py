"""Arms with joints enough that do not move their hands in all directions: refused with the rank that geometry gives."""

import pytest
from damaged_cells import sound, written

import mrts
from mrts.base.errors import InputError
from mrts.cell.loading import cell_to_compile
from mrts.starting.reading import request_of

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
    with pytest.raises(InputError) as refused:
        mrts.follow_object(cell_to_compile(tmp_path / "cell.yaml"), mrts.load_motion(tmp_path / "motion.yaml"))
    assert refused.value.rule == mistake.rule
    given = {"name": "cell", "robots": [str(urdf)], "tips": [f"l{len(axes)}"]}
    if rank == 5:  # the others move in a plane to `mrts new`
        with pytest.raises(InputError) as refused:
            request_of(tmp_path, **given)
        assert f"in {rank} independent directions" in refused.value.rule
        assert refused.value.where == str(urdf)
