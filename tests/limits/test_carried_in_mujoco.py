"""A loose block on the object that a plan carries: MuJoCo's contacts know nothing of its rows."""

from dataclasses import replace

import numpy as np
import pytest
from conftest import DATA
from loose_block import GeodesicPlan, slid

import mrts
from mrts.cell.points import CarriedThing

STRONG = 1e6
"""Torques that bind nothing [N m]."""

STAYS, SLIDES = 1e-3, 5e-3
"""How far a block creeps that stays, and how far at least one goes that slides [m]."""

BLOCKS = {
    "on the box": {"at": [0.1, 0.05, 0.05]},
    # pushed along the normal it would bear any acceleration, and a contact of MuJoCo throws it up
    "on a tilted surface": {"at": [-0.1, 0.0, 0.05], "normal": [0.05, -0.1, 1.0]},
}


@pytest.mark.parametrize("place", ["on a tilted surface", pytest.param("on the box", marks=pytest.mark.slow)])
def test_a_block_stays_with_the_plan_and_slides_with_one_10_percent_faster(place, dual_ur5):
    """Lifted, moved aside and turned about a tilted axis, by limits of the block alone."""
    block = CarriedThing(name="block", friction=0.4, half_width=[0.04, 0.04], height=0.02, **BLOCKS[place])
    free = dual_ur5.without_wrench_limits().without_velocity_limits()
    strong = {"torque_lower": np.full(6, -STRONG), "torque_upper": np.full(6, STRONG)}
    cell = replace(free, robots=tuple(replace(robot, **strong) for robot in free.robots), carried=(block,))
    found = mrts.retime(cell, mrts.load_motion(DATA.parent / "dual_ur5" / "lift_and_turn.yaml"))
    motion = found.retimed.motion.object
    gone = [slid(GeodesicPlan(motion, faster), block, cell.gravity, [0.08, 0.08, 0.04]) for faster in (1.0, 1.1)]
    assert gone[0] < STAYS
    assert gone[1] > SLIDES
