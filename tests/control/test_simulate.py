"""A plan in closed loop: the controller against closed forms, the cell by energy; the least reserve that keeps all."""

import json
from dataclasses import replace

import numpy as np
import pytest
from command_line import mrts_command
from random_motors import equipped
from shipped_cells import DATA

import mrts
from mrts.control import simulate as simulation
from mrts.control.controller import with_settings
from mrts.following.coordinated_motion import CoordinatedMotion
from mrts.plots import reserve_plot

EXACT = mrts.PlantErrors(mass=0.0, friction_error=0.0)

PROMPT = mrts.Controller(rate=5000.0, delay=0.0, lag=0.0)
"""A controller that hardly delays what is planned."""

SAME_WRENCH = 0.01
"""Share of a limit by which wrenches of a slow motion may differ from the plan's without errors: torques are held."""

SAME_FILTER = 1e-9
"""Share of a torque: rounding of an exponential."""

SAME_ENERGY = 2e-3
"""Share of the work of the motors: trapezoids over steps of torques, and what grasps dissipate."""


def test_the_exact_cell_does_what_was_planned(dual_ur5, lift_and_turn):
    """At a third of the given speed, where the ends are smooth."""
    found = mrts.simulate(mrts.scale(dual_ur5, lift_and_turn, select=0.1), PROMPT, EXACT)
    plan, played = found.plan, found.played
    inside = played.time <= plan.duration
    planned = np.column_stack([np.interp(played.time[inside], plan.time, column) for column in plan.wrench.T])
    limit = np.concatenate([robot.wrench_upper for robot in plan.cell.robots])
    off = np.max(np.abs(played.wrench[inside] - planned) / limit, axis=0)
    print("wrenches", np.max(off), *found.words())
    assert np.max(off) < SAME_WRENCH < np.max(np.ptp(planned, axis=0) / limit) / 5
    assert np.max(found.object_error) < 1e-4
    assert found.passed == ()
    assert found.saturated == 0


@pytest.mark.quick
def test_motors_follow_held_and_late_commands(lifted):
    """Without feedback: a chain of exact steps of a first-order lag, one a period and delay."""
    rate, delay, lag = 400.0, 1.3e-3, 4e-3
    found = mrts.simulate(lifted, mrts.Controller(rate=rate, delay=delay, lag=lag, bandwidth=0.0), EXACT)
    plan, played = found.plan, found.played
    rest = plan.holding.torque
    period, now, expected = 1 / rate, rest[0], []
    ends = np.arange(0, len(played.time) + 1) * period
    given = np.column_stack([np.interp(ends, plan.time, column) for column in plan.torque.T])
    given[ends > plan.duration] = rest[1]
    for k, start in enumerate(ends[: int(played.time[-1] / period) + 1]):  # from arrival to arrival
        own = (played.time >= start + delay - 1e-9) & (played.time < start + period + delay - 1e-9)
        expected.extend(given[k] + (now - given[k]) * np.exp(-(t - start - delay) / lag) for t in played.time[own])
        now = given[k] + (now - given[k]) * np.exp(-period / lag)
    measured = played.torque[played.time >= delay - 1e-9]
    np.testing.assert_allclose(measured, expected, atol=SAME_FILTER * np.max(np.abs(plan.torque)))
    assert np.max(np.abs(measured - given[0])) > 1.0


def test_gains_are_of_the_inertia_with_the_others_held(lifted):
    plan = lifted.trajectory
    mass = lifted.cell.functions("dynamics", 101, {"q": plan.q, "dq": plan.dq})["mass_matrix"][0]
    given = 400.0 * np.diag(mass), 40.0 * np.diag(mass)
    ours, theirs = (
        mrts.simulate(lifted, controller).played.torque
        for controller in (mrts.Controller(), mrts.Controller(position_gain=given[0], velocity_gain=given[1]))
    )
    np.testing.assert_allclose(ours, theirs, rtol=1e-6, atol=1e-6)


def test_work_of_the_motors_lifts_and_rubs(lifted):
    """Between standstill and standstill, with the product's gravity torques and the true load and friction."""
    cell = equipped(lifted.cell, coulomb=1.0, viscous=2.0)
    plan = mrts.scale(cell, mrts.load_motion(DATA / "planar_dual_arm" / "lift.yaml"))
    found = mrts.simulate(plan, PROMPT, mrts.PlantErrors(mass=0.1, friction_error=0.5))
    done = found.played
    still = np.zeros_like(done.dq)
    gravity = cell.functions("dynamics", len(done.time), {"q": done.q, "dq": still})["gravity_torque"]
    lifted_arms, work = np.trapezoid(gravity * done.dq, done.time, axis=0).sum(), done.energy
    height = (done.motion.object.position[-1] - done.motion.object.position[0]) @ -cell.gravity
    rubbed = np.trapezoid(1.5 * (np.abs(done.dq) + 2.0 * done.dq**2), done.time, axis=0).sum()
    print("work", work, "arms", lifted_arms, "object", 1.1 * cell.mass * height, "friction", rubbed)
    assert work == pytest.approx(lifted_arms + 1.1 * cell.mass * height + rubbed, abs=SAME_ENERGY * work)
    assert rubbed > 0.05 * work


def test_at_the_end_the_grasps_carry_the_true_load(dual_ur5, lift_and_turn):
    cell, plan = dual_ur5, mrts.retime(dual_ur5, lift_and_turn, rates=10.0)
    found = mrts.simulate(plan, errors=mrts.PlantErrors(mass=0.2, com=np.array([0.02, 0.0, 0.0])))
    late = found.played.wrench[found.played.time > found.played.time[-1] - 0.05].mean(axis=0)
    forces, moments = np.zeros(3), np.zeros(3)
    R = found.played.motion.object.rotation[-1]
    for robot, six in zip(cell.robots, np.split(late, len(cell.robots)), strict=True):
        force, moment = (robot.T_world_base.R @ part for part in np.split(six, 2))
        forces, moments = forces + force, moments + moment + np.cross(R @ robot.T_object_tip.p, force)
    weight = 1.2 * cell.mass * -cell.gravity
    np.testing.assert_allclose(forces, weight, atol=0.01 * np.max(weight))
    about = np.cross(R @ [0.02, 0.0, 0.0], weight)
    np.testing.assert_allclose(moments, about, atol=0.05 * np.max(np.abs(about)))


def test_friction_fed_forward_keeps_the_joints_on_their_path(dual_ur5):
    cell = equipped(dual_ur5, armature=[0.66, 0.66, 0.66, 0.1, 0.1, 0.1], coulomb=2.0, viscous=1.0)
    plan = mrts.scale(cell, mrts.load_motion(DATA / "dual_ur5" / "lift_and_turn.yaml"))
    fed, not_fed = (
        np.max(np.abs(mrts.simulate(plan, mrts.Controller(friction=friction), EXACT).joint_error))
        for friction in (True, False)
    )
    print("largest error of a joint [rad]", fed, not_fed)
    assert fed < 5e-3
    assert not_fed > 3 * fed


def test_dampers_of_grasps_make_nothing_heavier(lifted):
    """Steps that are implicit in what two arms and an object share added it to the inertia of each of them."""
    off = [
        np.max(np.abs(mrts.simulate(lifted, errors=mrts.PlantErrors(damping_time=time)).joint_error))
        for time in (1e-4, 1e-3)
    ]
    assert off[1] == pytest.approx(off[0], rel=0.01)


def test_trials_draw_errors_by_their_seed_whatever_the_controller(lifted):
    errors = mrts.PlantErrors(mass=0.1, friction_error=0.0)
    found, other = (mrts.simulate(lifted, errors=errors, trials=count, seed=count) for count in (2, 1))
    drawn = [*found.trials.errors, *other.trials.errors]
    assert all(0 < abs(each.mass) <= 0.1 for each in drawn)
    assert len({each.mass for each in drawn}) == 3
    assert np.all(found.trials.spread[0] <= found.trials.spread[1])
    noisy = mrts.Controller(rate=250.0, velocity_noise=1e-3)
    assert mrts.simulate(lifted, noisy, errors, trials=2, seed=2).trials.errors == found.trials.errors
    again = mrts.simulate(lifted, errors=drawn[0])
    shares = [use.share for use in simulation.kept_uses(again.played)]
    np.testing.assert_array_equal(found.trials.shares[0], shares)
    as_planned = replace(found, played=found.plan)  # whose trials pass limits all the same
    assert (as_planned.passed, as_planned.kept, as_planned.to_json()["kept"]) == ((), False, False)
    assert replace(as_planned, trials=None).kept
    json.loads(found.json_text())


def test_noise_and_resolution_are_felt(lifted):
    plain, *others = (
        mrts.simulate(lifted, controller, EXACT).played.q
        for controller in (mrts.Controller(), mrts.Controller(position_noise=1e-4), mrts.Controller(resolution=0.01))
    )
    for other in others:
        assert 1e-6 < np.max(np.abs(other - plain)) < 0.1


@pytest.mark.parametrize(
    ("given", "key"),
    [
        ({"rate": 0.0}, "rate"),
        ({"delay": np.nan}, "delay"),
        ({"position_gain": [-1.0, 1.0]}, "position_gain"),
        ({"velocity_gain": np.ones((6, 2))}, "velocity_gain"),
        ({"mass": "heavy"}, "mass"),
        ({"com": [0.0, 0.0]}, "com"),
        ({"com": np.zeros((2, 3))}, "com"),
        ({"stiffness": [np.inf, 1.0]}, "stiffness"),
        ({"wrong": 1.0}, ""),
    ],
)
def test_wrong_numbers_are_named(given, key):
    with pytest.raises(mrts.InputError, check=lambda error: error.key == key):
        with_settings(mrts.Controller(), mrts.PlantErrors(), given)


def test_what_runs_away_is_an_error_and_leaves_no_file(lifted, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(mrts.SolverError):
        mrts.simulate(lifted, errors=mrts.PlantErrors(stiffness=[1e9, 1e9], damping_time=1e-5))
    assert list(tmp_path.iterdir()) == []


def test_a_plan_that_does_not_rest_or_has_no_trajectory_is_refused(lifted, planar_cell, lift):
    whole = lifted.trajectory.motion
    given, cut = whole.object, slice(20, None)
    names = ("position", "rotation", "twist", "acceleration")
    carried = mrts.ObjectMotion(given.time[cut] - given.time[20], *(getattr(given, name)[cut] for name in names))
    moving = replace(lifted.trajectory, motion=CoordinatedMotion(carried, whole.q[cut], whole.dq[cut], whole.ddq[cut]))
    for plan in (moving, mrts.scale(planar_cell.with_mass(1e4), lift)):
        with pytest.raises(mrts.InputError, check=lambda error: error.where == "plan"):
            mrts.simulate(plan)


class Played:
    """A simulation that keeps limits from the reserve on that is needed."""

    def __init__(self, reserve, needed):
        self.share = (1 - reserve) / (1 - needed)
        self.uses = ((None, self),)
        self.name = "left/fx contact wrench"
        self.passed = (self,) if self.share > 1 else ()


@pytest.mark.parametrize(("needed", "most", "found"), [(0.2, 1.0, 0.2), (0.2, 0.1, None), (0.0, 1.0, 0.0)])
def test_the_search_ends_at_the_least_that_keeps_all(lifted, monkeypatch, needed, most, found):
    asked = []

    def solve(reserve):
        asked.append(reserve)
        return lifted if reserve < most else mrts.scale(lifted.cell.with_mass(1e4), lifted.motion)

    monkeypatch.setattr(simulation, "simulate", lambda *_: Played(asked[-1], needed))
    search = mrts.least_reserve(solve)
    assert asked[0] == 0
    assert len(asked) < 9
    if found is None:
        assert (search.found, search.reserve) == (None, None)
    else:
        assert found <= search.reserve <= found + simulation.RESERVE_WITHIN
        assert search.found is lifted


def test_the_figure_of_a_search_has_every_plan_by_whether_it_keeps_all_limits():
    tried = (
        simulation.TriedReserve(0.0, 0.4, 1.2, "a"),
        simulation.TriedReserve(0.1, 0.5, 0.9, "a", kept=True),
        simulation.TriedReserve(0.5),
    )
    ((panel,),) = reserve_plot(simulation.ReserveSearch(None, tried)).rows
    line, kept, passed = panel.items
    for drawn, places in ((line, [(0, 0.4), (10, 0.5)]), (kept, [(10, 0.5)]), (passed, [(0, 0.4)])):
        assert [*zip(drawn.x, drawn.y, strict=True)] == places
    assert (kept.texts, passed.texts) == (["90.0 %"], ["120.0 %"])


def test_a_lighter_load_counts_too(lifted):
    """Of the tried plans the first is the worse of both: the load heavier, and lighter by as much."""
    errors = mrts.PlantErrors(mass=0.05, friction_error=0.0)
    assert (errors.opposite().mass, errors.opposite().com.tolist()) == (-0.05, [0.0, 0.0, 0.0])
    first = mrts.least_reserve(lambda _: lifted, errors=errors).tried[0]
    both = [mrts.simulate(lifted, errors=each).uses[0][1].share for each in (errors, errors.opposite())]
    assert first.largest == max(both) != min(both)


@pytest.mark.slow
def test_the_command_finds_a_plan_that_is_kept(tmp_path):
    cell, motion, plan = (
        DATA / "dual_ur5" / "cell.yaml",
        DATA / "dual_ur5" / "lift_and_turn.yaml",
        tmp_path / "plan.csv",
    )
    done = mrts_command("scale", cell, motion, "--reserve", "auto", "--csv", plan, "--plot", tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    assert (tmp_path / "reserve.png").exists()
    assert mrts_command("simulate", cell, plan).returncode == 0
    assert mrts_command("configurations", cell, motion, "--reserve", "auto").returncode == 2
