"""Samples whose wrenches balance fixes, in one pass of C: the same ends and rows as in numpy."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from conftest import DATA
from one_arm import one_arm
from random_cells import configuration
from random_motors import equipped

import mrts
from mrts.following.coordinated_motion import carried_by_first
from mrts.program.load_sharing import LoadSharing
from mrts.program.motion_rows import motion_rows
from mrts.program.sample_problem import build_sample_problem
from mrts.program.trajectory_programs import motion_ranges
from mrts.timing.speed_regions import speed_regions

SAME = 1e-12
"""Both ways divide the same numbers, summed in another order."""

BY_PINOCCHIO = 1e-8
"""Another way to the same torques, as a share of a limit."""

BY_PROGRAMS = "qpsol:qpoases"
"""Linear programs of one unknown."""


def arm_and_path(folder):
    cell, _, path = one_arm(3, folder)
    return cell, path


def along_spline(cell, path, samples):
    s = np.linspace(0, 1, samples)
    return carried_by_first(cell, s, path(s), path(s, 1), path(s, 2), smooth=False)


def asked(name, folder, planar_cell, lift, dual_ur5):
    """A cell, its motion and how its load is shared."""
    arm, path = arm_and_path(folder)
    motion = along_spline(arm, path, 61)
    coordinated = mrts.follow_object(planar_cell, lift)
    carried = mrts.follow_object(dual_ur5, mrts.load_motion(DATA.parent / "dual_ur5" / "lift_and_turn.yaml"))
    uneven = LoadSharing(shares=np.array([0.3, 0.7]))
    return {
        "arm": lambda: (arm.without_velocity_limits(), motion, None),
        "arm with velocities": lambda: (arm, motion, None),
        "arm with velocities that bind": lambda: (with_velocities(arm, motion), motion, None),
        "arm with a reserve": lambda: (replace(arm, reserve=0.1), motion, None),
        "arm with motors": lambda: (equipped(arm, armature=0.3, coulomb=4.0), motion, None),
        "arm at rest at both ends": lambda: (planar_cell, coordinated, LoadSharing()),
        "shared, some samples infeasible": lambda: (planar_cell, coordinated, uneven),
        "shared": lambda: (dual_ur5, carried, uneven),
        "squeezed": lambda: (dual_ur5, carried, LoadSharing(internal_wrench=squeeze(dual_ur5, carried))),
    }[name]()


def with_velocities(cell, motion):
    """The cell with velocity limits of which one binds before the torques do."""
    robot = cell.robots[0]
    fastest = np.sqrt(np.min(motion_ranges(motion_rows(cell.without_velocity_limits(), motion), "kernel").upper))
    robot = replace(robot, velocity_limit=0.9 * fastest * np.max(np.abs(motion.dq), axis=0))
    return replace(cell, robots=(robot,), enforces_velocity_limits=True)


def squeeze(cell, motion):
    """A wrench at every sample with which both arms press on the object and that does not move it."""
    B = cell.functions("terms", motion.samples, motion.inputs(cell.load))["B"]
    _, _, directions = np.linalg.svd(B)
    return 5.0 * directions[:, -1]


CASES = (
    "arm",
    "arm with velocities",
    "arm with velocities that bind",
    "arm with a reserve",
    "arm with motors",
    "arm at rest at both ends",
    "shared, some samples infeasible",
    "shared",
    "squeezed",
)


@pytest.fixture(params=CASES)
def case(request, tmp_path, planar_cell, lift, dual_ur5):
    return asked(request.param, tmp_path, planar_cell, lift, dual_ur5)


def test_ends_and_the_rows_that_set_them(case):
    cell, motion, sharing = case
    found, known = (motion_ranges(motion_rows(cell, motion, sharing), solver) for solver in ("kernel", BY_PROGRAMS))
    assert found.status == known.status
    for ends in ("lower", "upper"):
        np.testing.assert_allclose(getattr(found, ends), getattr(known, ends), rtol=SAME, atol=0)
        for k in range(0, motion.samples, 5):
            assert set(found.binding(k, ends)) == set(known.all_binding(k, ends))
    assert [str(one) for one in found.conflicts] == [str(one) for one in known.conflicts]
    assert found.fallbacks == known.fallbacks == 0


def sides_at(regions, u, x):
    """How far points of each sample are inside its half-planes, the least of all, in limits, Shape (N,)."""
    planes = regions.planes.reshape(len(regions.lower), -1, 3)
    return np.min(planes[:, :, 2] - planes[:, :, 0] * u[:, None] - planes[:, :, 1] * x[:, None], axis=1)


@pytest.mark.parametrize("seed", range(2))
def test_half_planes_of_an_arm_are_its_torques_by_pinocchio(seed, tmp_path):
    cell, model, path = one_arm(seed, tmp_path)
    cell, data = cell.without_velocity_limits(), model.createData()
    motion, rng = along_spline(cell, path, 23), np.random.default_rng(seed)
    regions = speed_regions(build_sample_problem(motion_rows(cell, motion), varying=True), 1.0)
    limit = cell.robots[0].torque_upper
    u, x = rng.normal(size=motion.samples) * 10, rng.uniform(0, 20, motion.samples)
    inside = sides_at(regions, u, x)
    for k in range(motion.samples):
        velocity, acceleration = motion.dq[k] * np.sqrt(x[k]), motion.ddq[k] * x[k] + motion.dq[k] * u[k]
        torque = pin.rnea(model, data, configuration(model, motion.q[k]), velocity, acceleration)
        assert inside[k] == pytest.approx(float(np.min(1 - np.abs(torque) / limit)), abs=BY_PINOCCHIO)
