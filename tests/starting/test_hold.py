"""'Hold it here, now': grasps from postures, in Python and in the text of a cell file."""

from pathlib import Path

import numpy as np
import pytest
import yaml

import mrts
from mrts.starting.hold import hold_here, with_grasps

START = [0.03, 0.15, 0.4]
TURN = [0.1, -0.2, 0.3]

SAME = 1e-9
"""Rounding of poses; nothing is searched."""

ROBOTS = """
robots:
  - name: left   # the first
    grasp:       # as measured
      xyz: [0, 0,
            0]   # in the middle
      rpy: [0, 0, 0]
    posture: [1]
  - {name: right, posture: [2]}
  - name: third
    posture: [3]
  - posture: [4]
    grasp: {xyz: [9, 9, 9]} # kept
    name: fourth
"""


@pytest.mark.quick
def test_the_arms_start_at_their_postures(dual_ur5):
    """Where the compiled kinematics, not the ones that found the grasps, have the hands."""
    held = hold_here(dual_ur5, START, TURN)
    q = np.concatenate([robot.posture for robot in held.robots])
    keys = {"xyz": START, "rpy": TURN}
    motion = mrts.sample_motion(
        mrts.MotionDescription(start=keys, end={"xyz": [0.03, 0.15, 0.41], "rpy": TURN}, duration=1.0, profile="cubic")
    )
    assert mrts.follow_object(held, motion).q[0] == pytest.approx(q, abs=SAME)
    assert [robot.T_world_base for robot in held.robots] == [robot.T_world_base for robot in dual_ur5.robots]


def test_grasps_are_put_into_the_text_and_nothing_else_changes():
    grasps = {name: {"xyz": [index, 0, 0]} for index, name in enumerate(("left", "right", "third", "fourth"))}
    text = with_grasps(Path("cell.yaml"), ROBOTS, grasps)
    read = {robot["name"]: robot for robot in yaml.safe_load(text)["robots"]}
    for index, name in enumerate(grasps):
        assert read[name] == {"name": name, "grasp": {"xyz": [index, 0, 0]}, "posture": [index + 1]}
    assert "# the first" in text
    assert "# kept" in text
