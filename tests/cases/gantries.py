"""Two gantries that push one object along x, for closed forms."""

from dataclasses import replace

import numpy as np
import yaml
from shipped_cells import sampled

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


def gantries(folder, velocity=0.0, wrench=None, variation=None, object_velocity=None, gravity=(0, 0, 0)):
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
    cell = {"name": "gantries", "gravity": list(gravity), "plane": "xy", "object": carried, "robots": robots}
    (folder / "cell.yaml").write_text(yaml.safe_dump(cell))
    return mrts.load_cell(folder / "cell.yaml")


def along_x(samples=101, **changes):
    description = {"duration": 1.0, "samples": samples, "profile": "cubic"}
    description |= {"start": {"xyz": [0, 0, 0]}, "end": {"xyz": [2, 0, 0]}}
    return sampled(description | changes)


def there_and_back(turn, samples=101, wait=0):
    """Along x to the middle of the gantries' path and back, from rest to rest; the turning point at a share of time."""
    time = np.linspace(0, 1, samples)
    phase = np.clip(np.where(time < turn, time / turn, (time - turn) / (1 - turn)), 0, 1)
    length = np.where(time < turn, turn, 1 - turn)
    sign = np.where(time < turn, 1.0, -1.0)
    x = np.where(time < turn, 0, 1) + sign * (1 - np.cos(np.pi * phase)) / 2
    v = sign * np.pi / length * np.sin(np.pi * phase) / 2
    a = sign * (np.pi / length) ** 2 * np.cos(np.pi * phase) / 2
    v[np.isclose(time, turn)] = v[0] = v[-1] = 0.0
    middle = int(np.argmin(np.abs(time - turn)))
    order = np.concatenate([np.arange(middle), np.full(wait, middle), np.arange(middle, samples)]).astype(int)
    column = np.zeros((len(order), 6))
    twist, acceleration = column.copy(), column.copy()
    twist[:, 0], acceleration[:, 0] = v[order], a[order]
    position = np.zeros((len(order), 3))
    position[:, 0] = x[order]
    time = np.linspace(0, 1, len(order)) if wait else time
    eye = np.broadcast_to(np.eye(3), (len(order), 3, 3))
    return mrts.ObjectMotion(time, position, eye, twist, acceleration, smooth=False)


UPHILL = 36 / 11  # m/s²; against it the two arms and the object need 36 of 40 N
VISCOUS = 6.0  # N s/m of each arm


def uphill_gantries(folder, viscous=VISCOUS, **motors):
    """Gantries that push uphill against viscous friction: as the motion slows down, its inertia helps them."""
    cell = gantries(folder, gravity=(-UPHILL, 0, 0))
    columns = {"viscous": np.array([viscous, 0, 0])} | motors
    robots = (replace(robot, motors=replace(robot.motors, **columns)) for robot in cell.robots)
    return replace(cell, robots=tuple(robots))
