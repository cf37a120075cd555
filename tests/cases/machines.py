"""One machine with two arms: the shipped planar ones on a torso that turns and slides."""

import re

import numpy as np
import yaml
from conftest import DATA

TURN = 0.3
"""Position of the turntable in the cells below [rad]."""

ARM = (DATA / "planar_arm.urdf").read_text(encoding="utf-8")


def machine():
    """The shipped cell's two arms on one torso that slides up on a turning column; a flap hangs on the left forearm."""
    parts = ['<robot name="machine"><link name="root"/><link name="column"/><link name="torso"/>']
    for side, x in (("left", 0.0), ("right", 2.5)):
        body = ARM[ARM.index("<link") : ARM.index("</robot>")]
        parts.append(re.sub(r'(name|link)="(\w+)"', rf'\1="{side}_\2"', body))
        parts.append(
            f'<joint name="{side}_mount" type="fixed"><parent link="torso"/><child link="{side}_base_link"/>'
            f'<origin xyz="{x} 0 0"/></joint>'
        )
    for name, kind, parent, child, axis in (
        ("turn", "continuous", "root", "column", "0 0 1"),
        ("lift", "prismatic", "column", "torso", "0 1 0"),
    ):
        parts.append(
            f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/><axis xyz="{axis}"/>'
            '<limit lower="0" upper="0.5" effort="1000" velocity="1"/></joint>'
        )
    return "\n".join([*parts, "</robot>"])


def machine_cell(folder, change=None):
    """Both arms from the root, the torso neither held nor passed; `change` is done to the robots of the cell file."""
    (folder / "machine.urdf").write_text(machine(), encoding="utf-8")
    description = yaml.safe_load((DATA / "cell.yaml").read_text())
    for robot in description["robots"]:
        # so that the torso, turned by 0.3 rad and 0.4 m up, carries the arms where the shipped ones stand
        up = 0.4 * np.array([-np.sin(TURN), np.cos(TURN)])
        back = np.array([[np.cos(TURN), np.sin(TURN)], [-np.sin(TURN), np.cos(TURN)]])
        robot |= {"urdf": "machine.urdf", "base_link": "root", "tip_link": f"{robot['name']}_contact"}
        robot["base"] = {"xyz": [*(-back @ up).tolist(), 0], "rpy": [0, 0, -TURN]}
    if change is not None:
        change(description["robots"])
    for robot in description["robots"]:
        extra = ("turn", "lift")[: 0 if robot["base_link"] == "torso" else 2]
        moving = [name for name in extra if name not in robot.get("fixed", {})]
        robot["posture"] = [0.0] * len(moving) + robot["posture"]
        robot["torque"] = [1000.0] * len(moving) + robot["torque"]
    (folder / "cell.yaml").write_text(yaml.safe_dump(description), encoding="utf-8")
    return folder / "cell.yaml"
