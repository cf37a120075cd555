"""Two gantries that push one object along x, for closed forms."""

import numpy as np
from random_motors import equipped
from shipped_cells import cell_of_arms

import mrts
from mrts.motion.object_motion import ObjectMotion

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
    carried = {"mass": 3, "inertia": [1, 1, 1]} | ({"variation": variation} if variation else {})
    carried |= {"velocity": object_velocity} if object_velocity else {}
    return mrts.load_cell(cell_of_arms(folder, *robots, name="gantries", gravity=gravity, plane="xy", object=carried))


def along_x(samples=101, **changes):
    description = {"duration": 1.0, "samples": samples, "profile": "cubic"}
    description |= {"start": {"xyz": [0, 0, 0]}, "end": {"xyz": [2, 0, 0]}}
    return mrts.load_motion(description | changes)


def straight(time, x, v, a):
    """A motion along x of any positions, velocities and accelerations."""
    place, twist, acceleration = np.zeros((3, len(time), 6))
    place[:, 0], twist[:, 0], acceleration[:, 0] = x, v, a
    turned = np.tile(np.eye(3), (len(time), 1, 1))
    return ObjectMotion(time, place[:, :3], turned, twist, acceleration, checked=False)


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
    time = np.linspace(0, 1, len(order)) if wait else time
    return straight(time, x[order], v[order], a[order])


def loop(time, turned, speed, rate, radius=0.5):
    """The object around a vertical circle, its top inward, turned off the topmost place by so much at each time."""
    none = np.zeros_like(time)
    out = np.column_stack([np.sin(turned), np.cos(turned), none])
    along = np.column_stack([np.cos(turned), -np.sin(turned), none])
    twist, acceleration = np.zeros((2, len(time), 6))
    twist[:, :3], twist[:, 5] = radius * speed[:, None] * along, -speed
    acceleration[:, :3] = radius * (rate[:, None] * along - (speed**2)[:, None] * out)
    acceleration[:, 5] = -rate
    rotation = np.stack([-along, -out, np.tile([0.0, 0.0, 1.0], (len(time), 1))], axis=2)
    return ObjectMotion(time, radius * out, rotation, twist, acceleration, checked=False)


UPHILL = 36 / 11  # m/s²; against it the two arms and the object need 36 of 40 N
VISCOUS = 6.0  # N s/m of each arm


def uphill_gantries(folder, viscous=VISCOUS, **motors):
    """Gantries that push uphill against viscous friction: as the motion slows down, its inertia helps them."""
    cell = gantries(folder, gravity=(-UPHILL, 0, 0))
    return equipped(cell, viscous=[viscous, 0, 0], **motors)
