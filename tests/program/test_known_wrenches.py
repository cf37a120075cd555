"""Samples whose wrenches balance fixes: each row bounds c² by itself, as linear programs find, and Pinocchio."""

from dataclasses import replace

import numpy as np
import pytest
from conftest import DATA
from one_arm import one_arm
from random_motors import equipped

import mrts
from mrts.following.coordinated_motion import carried_by_first
from mrts.kernel.programs import OPTIMAL
from mrts.program.load_sharing import LoadSharing
from mrts.program.motion_rows import motion_rows
from mrts.program.range_ends import ends_by_linear_programs, ends_of_rows
from mrts.program.sample_problem import build_sample_problem
from mrts.program.sample_ranges import without_speed_at_rest

SAME = 1e-9
"""The linear programs' share of c²."""


def arm_and_path(folder):
    cell, _, path = one_arm(3, folder)
    return cell, path


def along_spline(cell, path, samples):
    s = np.linspace(0, 1, samples)
    return carried_by_first(cell, s, path(s), path(s, 1), path(s, 2), smooth=False)


@pytest.mark.parametrize("kind", ["arm", "velocities", "reserve", "motors", "shared", "squeezed", "infeasible"])
def test_ends_and_the_rows_that_set_them(kind, tmp_path, planar_cell, lift, dual_ur5):
    arm, path = arm_and_path(tmp_path)
    motion, sharing, cell = (
        along_spline(arm, path, 61),
        LoadSharing(np.array([0.3, 0.7])),
        arm.without_velocity_limits(),
    )
    if kind in {"shared", "squeezed"}:
        cell, motion = (
            dual_ur5,
            mrts.follow_object(dual_ur5, mrts.load_motion(DATA.parent / "dual_ur5/lift_and_turn.yaml")),
        )
        sharing = sharing if kind == "shared" else LoadSharing(internal_wrench=squeeze(cell, motion))
    elif kind == "infeasible":
        cell, motion = planar_cell, mrts.follow_object(planar_cell, lift)
    else:
        sharing = None
        cell = {
            "arm": lambda: cell,
            "velocities": lambda: arm,
            "reserve": lambda: replace(arm, reserve=0.1),
            "motors": lambda: equipped(arm, armature=0.3, coulomb=4.0),
        }[kind]()
    problem = without_speed_at_rest(build_sample_problem(motion_rows(cell, motion, sharing)))
    found, known = ends_of_rows(problem), ends_by_linear_programs(problem, "qpsol:qpoases")
    held = found.status == OPTIMAL
    assert np.all(held) == (kind != "infeasible")
    np.testing.assert_array_equal(held, known.status == OPTIMAL)
    np.testing.assert_allclose(found.lower[held], known.lower[held], rtol=SAME, atol=SAME)
    capped = np.minimum(known.upper, problem.cap())
    np.testing.assert_allclose(found.upper[held], capped[held], rtol=SAME)
    for sample, side in np.argwhere(held[:, None] & (known.codes[:, :, 0].T != 0)).tolist():
        theirs = set(known.codes[side, sample].tolist()) - {0}
        assert theirs <= set(found.codes[side, sample].tolist()) or found.upper[sample] >= problem.cap()[sample]


def squeeze(cell, motion):
    """A wrench at every sample with which both arms press on the object and that does not move it."""
    B = cell.functions("terms", motion.samples, motion.inputs(cell.load))["B"]
    _, _, directions = np.linalg.svd(B)
    return 5.0 * directions[:, -1]
