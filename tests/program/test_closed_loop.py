"""The profiles in closed loop: played by a controller on a plant with delay, lag, friction and another load."""

import numpy as np
import played_plans
import pytest
from closed_loop_trials import DATA, GRASPS, measures, trial
from mujoco_cells import urdf_of
from random_motors import equipped

import mrts

WITHIN = {"rigid": 0.15, "clamps": 0.25}
"""Share of its limit by which a contact wrench of a smooth plan may pass it. A box that swings in its clamps adds some:
0.15 to 0.28 in all, at torque rates of 8 to 15 limits a second and 0.018 to 0.04 s to fill a contact's limit."""

SATURATED = 0.01
"""Share of a smooth plan's commands that motors may cut."""

SAME_LOAD = 5e-3
"""Share of the object's weight by which its carriers may miss it 0.1 s after the end: springs swing, joints creep."""

SAME_WRENCH = 0.02
"""Share of a limit by which wrenches of a slow motion may differ from the plan's without delay, friction and errors:
the torques are held for 1 ms."""

NEARER = {"dual_ur5": "error", "planar_dual_arm": "off_path"}
"""In what the smooth plan is nearer than the constant factor of its duration. In the plane the factor's start jumps off
the path, while its joints, slower at most, are the less late."""


@pytest.fixture(scope="module", params=["planar_dual_arm", pytest.param("dual_ur5", marks=pytest.mark.slow)])
def tried(request):
    return trial(request.param)


def told(of, played):
    print(of, *(f"{name} {value:.4g}" for name, value in measures(played).items()))
    return played


@pytest.mark.parametrize("grasp", GRASPS)
def test_smooth_wrenches_stay_near_their_limits_and_motors_have_torque_left(tried, grasp):
    smooth = told(f"{tried.name} smooth, {grasp}", tried.played("smooth", grasp))
    assert smooth.overstep < WITHIN[grasp]
    assert smooth.overstep_after < WITHIN[grasp]
    assert smooth.cut < SATURATED


def test_smooth_is_nearer_to_its_plan_than_the_constant_factor_of_its_duration(tried):
    smooth = told("smooth", tried.played("smooth"))
    constant = told("constant, as long", tried.played("as_long"))
    assert constant.duration == pytest.approx(smooth.duration)
    of = NEARER[tried.name]
    assert smooth.rms(getattr(smooth, of)) < constant.rms(getattr(constant, of))


def test_the_fastest_timing_does_not_pass_the_trial(tried):
    """The trial can be failed: steps of the torque pass the limits of contacts, and motors have nothing left."""
    optimal = told(f"{tried.name} optimal, clamps", tried.played("optimal", "clamps"))
    assert optimal.overstep > 2 * WITHIN["clamps"]
    assert optimal.cut > 5 * SATURATED


def test_at_the_end_the_grasps_carry_the_true_load(tried):
    cell = tried.cell
    for grasp in GRASPS:
        played = tried.played("smooth", grasp)
        late = played.wrench[played.time > played.time[-1] - played_plans.AFTER / 2]
        lifted = np.zeros(3)
        for robot, six in zip(cell.robots, np.split(late.mean(axis=0), len(cell.robots)), strict=True):
            force = np.zeros(6)
            force[cell.wrench_rows] = six
            lifted += robot.T_world_base.R @ force[:3]
        weight = -(1 + played_plans.MASS_ERROR) * cell.mass * cell.gravity
        print(grasp, "carried", lifted, "weight", weight)
        np.testing.assert_allclose(lifted, weight, rtol=0, atol=SAME_LOAD * np.linalg.norm(weight))


@pytest.mark.slow
@pytest.mark.parametrize("grasp", GRASPS)
def test_wrenches_of_a_slow_motion_without_errors_are_those_of_the_plan(grasp, monkeypatch):
    """What is measured is what the plan's limits are about: the same point, axes and sign."""
    for name, value in {"MASS_ERROR": 0.0, "FRICTION_ERROR": 0.0, "DELAY": 0.0, "LAG": played_plans.STEP}.items():
        monkeypatch.setattr(played_plans, name, value)
    of = trial("dual_ur5")
    cell = equipped(of.cell, coulomb=0, viscous=0)
    plan = mrts.scale(cell, of.motion, select="nominal").trajectory
    played = played_plans.play(cell, urdf_of(DATA / of.name), plan, GRASPS[grasp])
    limit = np.concatenate([robot.wrench_upper for robot in cell.robots])
    inside = played.time <= played.duration
    planned = np.array([np.interp(played.time[inside], plan.time, column) for column in plan.wrench.T]).T
    size = np.where(np.isfinite(limit), limit, np.max(np.abs(planned), axis=0))
    off = np.max(np.abs(played.wrench[inside] - planned) / size, axis=0)
    print(grasp, "largest difference, share of a limit", off.round(4))
    assert np.max(np.ptp(planned, axis=0) / size) > 5 * SAME_WRENCH
    assert np.max(off) < SAME_WRENCH
