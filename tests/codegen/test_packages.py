"""Files of packages, found as ROS, Gazebo and Python's installers leave them."""

from pathlib import Path

import pytest

from mrts.base.errors import InputError
from mrts.base.input_file import FileReference, file_of_uri

pytestmark = pytest.mark.quick

UR5 = "package://example-robot-data/robots/ur_description/urdf/ur5_robot.urdf"


@pytest.fixture(autouse=True)
def no_workspace(monkeypatch):
    for name in ("AMENT_PREFIX_PATH", "ROS_PACKAGE_PATH", "GZ_SIM_RESOURCE_PATH"):
        monkeypatch.delenv(name, raising=False)


def put(folder, inside="urdf/arm.urdf"):
    file = folder / inside
    file.parent.mkdir(parents=True)
    file.write_text("<robot/>")
    return file


def found(tmp_path, uri="package://my_arm/urdf/arm.urdf"):
    return FileReference(uri).path(tmp_path / "cells" / "cell.yaml", tmp_path / "cells")


@pytest.mark.parametrize(
    ("variable", "folder", "scheme"),
    [
        ("AMENT_PREFIX_PATH", "share/my_arm", "package"),
        ("ROS_PACKAGE_PATH", "my_arm", "package"),
        ("GZ_SIM_RESOURCE_PATH", "my_arm", "model"),
    ],
)
def test_where_ros_and_gazebo_look(variable, folder, scheme, tmp_path, monkeypatch):
    """In each folder that the variable lists; one that is not there is passed over."""
    file = put(tmp_path / "install" / folder)
    monkeypatch.setenv(variable, f"{tmp_path / 'gone'}:{tmp_path / 'install'}")
    assert found(tmp_path, f"{scheme}://my_arm/urdf/arm.urdf") == file


def test_a_workspace_around_the_cell_file(tmp_path):
    """A folder of that name above it, or one whose package.xml has the name; that which holds the file."""
    file = put(tmp_path / "arm_checked_out")
    (tmp_path / "arm_checked_out" / "package.xml").write_text("<package><name> my_arm </name></package>")
    inside = tmp_path / "arm_checked_out" / "cells"
    inside.mkdir()
    assert FileReference("package://my_arm/urdf/arm.urdf").path(inside / "cell.yaml", inside) == file
    with pytest.raises(InputError, match="the package 'my_arm' is not found"):
        found(tmp_path)
    beside = put(tmp_path / "my_arm")
    assert found(tmp_path) == beside


def test_installed_packages(tmp_path):
    assert found(tmp_path, UR5).is_file()
    assert found(tmp_path, "package://airo_models/arms/ur5e/ur5e.urdf").is_file()


def test_what_is_not_found_says_where_it_was_looked_for(tmp_path):
    put(tmp_path / "my_arm", "urdf/arm_2.urdf")
    with pytest.raises(
        InputError,
        match=r"package 'my_arm' is at .*my_arm, but holds no file 'urdf/arm\.urdf'; did you mean .*arm_2\.urdf",
    ):
        found(tmp_path)
    with pytest.raises(InputError, match=r"AMENT_PREFIX_PATH, ROS_PACKAGE_PATH.*cmeel\.prefix/share") as told:
        found(tmp_path, "package://their_arm/urdf/arm.urdf")
    assert "robots[].urdf = 'package://their_arm/urdf/arm.urdf'" in str(told.value)
    put(tmp_path / "your_arm")
    for inside in ("../your_arm/urdf/arm.urdf", "urdf/../../your_arm/urdf/arm.urdf"):
        with pytest.raises(InputError, match="leads out of the package 'my_arm'"):
            found(tmp_path, f"package://my_arm/{inside}")
    for uri in (f"package://{'a' * 300}/x", f"package://my_arm/{'a' * 300}", "package://my_arm//etc/passwd"):
        with pytest.raises(InputError, match=r"is not found|holds no file"):
            found(tmp_path, uri)
    for uri in ("package://", "package://arm", "model:///arm.urdf", "package://../arm.urdf"):
        with pytest.raises(InputError, match=r"must be package://NAME/PATH|is not found"):
            file_of_uri("cell.yaml", uri, Path(tmp_path / "cell.yaml"))
