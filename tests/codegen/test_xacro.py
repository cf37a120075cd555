"""A xacro in the place of a URDF: it is expanded, with all that it includes, whenever a cell is read."""

import numpy as np
import pytest
import yaml
from conftest import DATA
from same_cells import same_cell

import mrts
from mrts.starting import reading

XACRO = 'xmlns:xacro="http://www.ros.org/wiki/xacro"'
ARM = f"""<robot name="planar_arm" {XACRO}>
<xacro:arg name="far" default="false"/>
<xacro:include filename="more.xacro"/>
<xacro:include filename="$(find arm_parts)/numbers.xacro"/>
"""
MESH = '<visual><geometry><mesh filename="{}"/></geometry></visual></link>'
LIMITED = 'type="revolute"><limit lower="-3" upper="${reach}" effort="1" velocity="1"/>'


@pytest.fixture
def cell(tmp_path):
    """The planar cell with its arm as a xacro that includes a neighbour and a file of a package, and names meshes."""
    head, _, rest = (DATA / "planar_arm.urdf").read_text(encoding="utf-8").partition('<robot name="planar_arm">')
    for mesh in ("meshes/upper.stl", "package://arm_parts/fore.stl", "package://nowhere/hand.stl"):
        rest = rest.replace("</inertial>\n  </link>", f"</inertial>{MESH.format(mesh)}", 1)
    rest = rest.replace('type="continuous">', LIMITED, 1)
    (tmp_path / "arm.urdf.xacro").write_text(head + ARM + rest, encoding="utf-8")
    (tmp_path / "more.xacro").write_text(f"<robot {XACRO}/>")
    (tmp_path / "arm_parts").mkdir()
    (tmp_path / "arm_parts" / "fore.stl").write_text("")
    numbers(tmp_path, 2.0)
    given = yaml.safe_load((DATA / "cell.yaml").read_text(encoding="utf-8"))
    for robot in given["robots"]:
        robot["urdf"] = "arm.urdf.xacro"
    path = tmp_path / "cell.yaml"
    path.write_text(yaml.safe_dump(given), encoding="utf-8")
    return path


def numbers(folder, reach):
    """The included file; what it says of the shoulder's upper limit is in the manifest, and not in the C."""
    far = '<xacro:property name="far" value="$(arg far)"/>'
    reach = f'{far}<xacro:property name="reach" value="${{3.5 if far else {reach}}}"/>'
    (folder / "arm_parts" / "numbers.xacro").write_text(f"<robot {XACRO}>{reach}</robot>")


def with_arguments(path, arguments, **keys):
    given = yaml.safe_load(path.read_text(encoding="utf-8"))
    given["robots"][0] |= {"xacro_args": arguments} | keys
    path.write_text(yaml.safe_dump(given), encoding="utf-8")


def reach(path):
    return [robot.position_upper[0] for robot in mrts.load_cell(path).robots]


def test_a_cell_of_a_xacro_follows_what_it_includes(cell):
    assert reach(cell) == [2.0, 2.0]
    numbers(cell.parent, 2.25)
    assert reach(cell) == [2.25, 2.25]
    with_arguments(cell, {"far": True})
    assert reach(cell) == [3.5, 2.25]
    again = cell.parent / "again.yaml"
    mrts.load_cell(cell).to_yaml(again)
    assert same_cell(mrts.load_cell(again), mrts.load_cell(cell))


NO_PACKAGE = (
    r"^\S+arm\.urdf\.xacro: [^:]*: the package 'arm_parts' is not found\. Looked .*AMENT_PREFIX_PATH.* 'arm_parts' "
)
RECURSIVE = f'<robot {XACRO}><xacro:macro name="m" params=""><xacro:m/></xacro:macro><xacro:m/></robot>'

MISTAKES = {
    "unknown argument": (lambda cell: with_arguments(cell, {"fra": True}), "no argument 'fra'; there are far"),
    "no xacro": (lambda cell: with_arguments(cell, {"far": True}, urdf="arm.urdf"), "'xacro_args' are of a xacro"),
    "expression": (lambda cell: numbers(cell.parent, "1 / 0"), r"arm\.urdf\.xacro: cannot be expanded \(.*division"),
    "include": (lambda cell: (cell.parent / "more.xacro").unlink(), r"cannot be expanded \(.*more\.xacro"),
    "package": (lambda cell: (cell.parent / "arm_parts").rename(cell.parent / "parts"), NO_PACKAGE),
    "recursion": (lambda cell: (cell.parent / "more.xacro").write_text(RECURSIVE), "cannot be expanded"),
    "gone": (lambda cell: (cell.parent / "arm.urdf.xacro").unlink(), "there is no such xacro"),
}


@pytest.mark.parametrize("mistake", MISTAKES)
def test_mistakes_in_a_xacro(mistake, cell):
    change, rule = MISTAKES[mistake]
    change(cell)
    with pytest.raises(mrts.InputError, match=rule):
        mrts.load_cell(cell)


def test_mrts_new_takes_arguments(cell, monkeypatch):
    monkeypatch.chdir(cell.parent)

    def request_of(robot):
        gravity, arguments = np.array([0, -9.81, 0]), {"far": "true"}
        return reading.request_of(cell.parent, name="cell", robots=[robot], gravity=gravity, xacro_args=arguments)

    request = request_of("arm.urdf.xacro")
    assert [each.arm.robot.position_upper[0] for each in request.arms] == [3.5, 3.5]
    assert [each.xacro_args for each in request.arms] == [{"far": "true"}] * 2
    with pytest.raises(mrts.InputError, match="--xacro-arg: no --robot is a xacro"):
        request_of(str(DATA / "planar_arm.urdf"))
