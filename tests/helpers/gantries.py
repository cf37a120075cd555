"""Two gantries that push one object along x, for closed forms."""

import yaml

import mrts

GANTRY = """<robot name="gantry"><link name="base"/>
<link name="x"><inertial><mass value="2"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
<link name="y"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
<link name="tip"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="slide_x" type="prismatic"><parent link="base"/><child link="x"/><axis xyz="1 0 0"/>
<limit lower="-9" upper="9" effort="20" velocity="{velocity}"/></joint>
<joint name="slide_y" type="prismatic"><parent link="x"/><child link="y"/><axis xyz="0 1 0"/>
<limit lower="-9" upper="9" effort="20" velocity="0"/></joint>
<joint name="turn" type="continuous"><parent link="y"/><child link="tip"/><axis xyz="0 0 1"/>
<limit effort="20" velocity="0"/></joint></robot>"""


def gantries(folder, velocity=0.0, wrench=None, variation=None, object_velocity=None):
    """Two gantries of 4 kg push an object of 3 kg along x with 20 N each; its path has length 2."""
    (folder / "gantry.urdf").write_text(GANTRY.format(velocity=velocity))
    limits = {} if wrench is None else {"wrench": {"lower": [-wrench, None, None], "upper": [wrench, None, None]}}
    robots = [
        {"name": name, "urdf": "gantry.urdf", "tip_link": "tip", "posture": [0, 0, 0], "base": {"xyz": [0, y, 0]}}
        | {"grasp": {"xyz": [0, y, 0]}}
        | limits
        for name, y in (("near", -1), ("far", 1))
    ]
    carried = {"mass": 3, "inertia": [1, 1, 1]}
    if variation:
        carried["variation"] = variation
    if object_velocity:
        carried["velocity"] = object_velocity
    cell = {"name": "gantries", "gravity": [0, 0, 0], "plane": "xy", "object": carried, "robots": robots}
    (folder / "cell.yaml").write_text(yaml.safe_dump(cell))
    return mrts.load_cell(folder / "cell.yaml")


def along_x(samples=101, **changes):
    description = {"duration": 1.0, "samples": samples, "profile": "cubic"}
    description |= {"start": {"xyz": [0, 0, 0]}, "end": {"xyz": [2, 0, 0]}}
    return mrts.sample_motion(mrts.MotionDescription.model_validate(description | changes))
