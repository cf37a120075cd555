"""Planar closed forms of inverse kinematics, and paths that leave the plane."""

from functools import partial

import numpy as np
import pytest
from followed_motions import motion

import mrts
from mrts.following.tracking import branches_at_start

pytestmark = pytest.mark.quick


def test_both_branches_reach_and_the_posture_chooses(planar_cell, lift):
    for index in range(2):
        first, second = branches_at_start(planar_cell, index, lift)
        assert np.sign(np.sin(first[1])) == -np.sign(np.sin(second[1]))
    up_up = mrts.follow_object(planar_cell, lift)
    assert (np.sign(up_up.q[:, 1]) == -1).all()
    assert (np.sign(up_up.q[:, 4]) == 1).all()
    down_up = mrts.follow_object(planar_cell.with_postures({"left": [0.5, 2.1, -2.6]}), lift)
    assert (np.sign(down_up.q[:, 1]) == 1).all()
    assert (np.sign(down_up.q[:, 4]) == 1).all()


motion_to = partial(motion, start=(1.25, 1.0, 0.0), duration=0.5, samples=11, profile="cubic")


@pytest.mark.parametrize(("xyz", "rpy"), [((1.25, 1.2, 0.1), (0, 0, 0)), ((1.25, 1.2, 0), (0.1, 0, 0))])
def test_a_path_out_of_the_plane_is_refused(planar_cell, xyz, rpy):
    with pytest.raises(mrts.MotionError, match="leaves the plane xy"):
        mrts.follow_object(planar_cell, motion_to(xyz, rpy))
