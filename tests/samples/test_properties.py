"""The paper's appendices as properties, and both formulations against each other, on random cells."""

import numpy as np
import pytest
from random_cells import random_planar_cell

import mrts
from mrts.base.errors import SolverError
from mrts.limits import limit_rows
from mrts.samples.range_status import SampleStatus
from mrts.samples.sample_problem import build_sample_problem
from mrts.samples.sample_ranges import sample_ranges
from mrts.samples.torque_distribution import distribute_torques
from mrts.solvers import DEFAULT_SOLVER

FORMULATION_TOLERANCE = 1e-9  # relative; the torque form inverts Jacobians of condition up to about 100
LIMIT_TOLERANCE = 3e-9  # the quadratic program widens limits by 1e-9 of their size plus 1e-9
BEYOND = 1 + 1e-6


def random_cells(folder, count, seed):
    for index in range(count):
        place = folder / str(index)
        place.mkdir()
        paths = random_planar_cell(np.random.default_rng([seed, index]), place, arms=2 + index % 3)
        yield mrts.load_cell(paths[0], backend="vm"), mrts.load_motion(paths[1])


def feasible_samples(ranges):
    return np.flatnonzero([status is SampleStatus.FEASIBLE for status in ranges.status])


def limit_violation(cell, motion, torque, wrench, c2):
    rows = limit_rows(cell, motion)
    value = rows.value(torque, wrench, 0.0, np.sqrt(c2))
    size = 1 + np.where(np.isfinite(rows.upper), np.abs(rows.upper), np.abs(rows.lower))
    return float(np.max(np.maximum(rows.lower - value, value - rows.upper) / size))


def test_appendix_a_every_speed_between_the_ends_is_feasible_and_c_torques_satisfy_all_equations(tmp_path):
    """1000 random (sample, c²): the quadratic program has a solution, and it satisfies (8), (13), (20), (24)."""
    rng = np.random.default_rng(1)
    checked = 0
    for cell, motion in random_cells(tmp_path, 40, seed=101):
        joint_motion = mrts.follow_object(cell, motion)
        problem = build_sample_problem(cell, joint_motion)
        ranges = sample_ranges(problem, motion.time, DEFAULT_SOLVER)
        terms = cell.functions("terms", joint_motion.samples, joint_motion.inputs(cell.load))
        for k in feasible_samples(ranges):
            for share in [0.0, 1.0, *rng.uniform(0, 1, 12)]:
                c2 = float(ranges.lower[k] + share * (ranges.upper[k] - ranges.lower[k]))
                one = problem.at(np.array([k]))
                x, _ = distribute_torques(one, c2, np.eye(sum(len(r.joints) for r in cell.robots)), DEFAULT_SOLVER)
                torque, wrench = one.torque(x)[0], one.wrench(x)[0]
                here = joint_motion.at(np.array([k]))
                assert limit_violation(cell, here, one.torque(x), one.wrench(x), c2) <= LIMIT_TOLERANCE
                scale = 1 + np.max(np.abs(torque)) + np.max(np.abs(wrench))
                balance = terms["B"][k] @ wrench - c2 * terms["P"][k] - terms["Q"][k]
                assert np.max(np.abs(balance)) <= 1e-10 * scale
                for name, joints in cell.joint_slices.items():
                    J, F = terms["J"][k][:, joints], wrench[cell.wrench_slices[name]]
                    arm = torque[joints] - c2 * terms["E"][k, joints] - terms["G"][k, joints] - J.T @ F
                    assert np.max(np.abs(arm)) <= 1e-10 * scale
                checked += 1
    assert checked >= 1000


def test_appendix_b_nothing_faster_or_slower_than_the_range_is_feasible(tmp_path):
    checked = 0
    for cell, motion in random_cells(tmp_path, 25, seed=202):
        joint_motion = mrts.follow_object(cell, motion)
        problem = build_sample_problem(cell, joint_motion)
        ranges = sample_ranges(problem, motion.time, DEFAULT_SOLVER)
        W = np.eye(sum(len(robot.joints) for robot in cell.robots))
        for k in feasible_samples(ranges):
            outside = [ranges.upper[k] * BEYOND + 1e-6]
            if ranges.lower[k] > 1e-3:
                outside.append(ranges.lower[k] / BEYOND - 1e-6)
            for c2 in outside:
                with pytest.raises(SolverError):
                    distribute_torques(problem.at(np.array([k])), float(c2), W, DEFAULT_SOLVER)
                checked += 1
    assert checked >= 60


def test_both_formulations_agree(tmp_path):
    compared = 0
    for cell, motion in random_cells(tmp_path, 25, seed=303):
        results = {}
        for formulation in ("wrench", "torque"):
            results[formulation] = mrts.scale(cell, motion, formulation=formulation)
        wrench, torque = (results[name].range for name in ("wrench", "torque"))
        assert wrench.samples.status == torque.samples.status
        for ours, theirs in (
            (wrench.samples.lower, torque.samples.lower),
            (wrench.samples.upper, torque.samples.upper),
        ):
            np.testing.assert_allclose(ours, theirs, rtol=FORMULATION_TOLERANCE, atol=FORMULATION_TOLERANCE)
        if wrench.status.admits_motion:
            a, b = (results[name].trajectory.torque for name in ("wrench", "torque"))
            # the slack of 1e-9 on the limits moves a degenerate optimum by more than itself
            np.testing.assert_allclose(a, b, atol=1e-6 * (1 + np.max(np.abs(a))))
            compared += 1
    assert compared >= 5


def test_energy_of_the_motors_is_the_change_of_mechanical_energy(planar_cell, lift):
    """∫ q̇ᵀτ dt = Δ(kinetic + potential): contact forces do no net work on the whole."""
    result = mrts.scale(planar_cell, lift)
    done, motion = result.trajectory, result.motion
    D = planar_cell.functions("dynamics", motion.samples, {"q": motion.q, "dq": motion.dq})["mass_matrix"]
    kinetic = np.einsum("ni,nij,nj->n", done.dq, D, done.dq) / 2
    v = motion.object.twist[:, :3] * np.sqrt(done.c2)
    kinetic += planar_cell.mass * np.sum(v * v, axis=1) / 2
    # potential energy of the shipped arm in closed form: mid-link centres of mass
    potential = planar_cell.mass * 9.8 * motion.object.position[:, 1]
    for joints in planar_cell.joint_slices.values():
        angle = np.cumsum(motion.q[:, joints], axis=1)
        height = np.zeros(motion.samples)
        for index, (length, mass) in enumerate(((1.0, 5.0), (1.0, 4.0), (0.1, 0.5))):
            potential += mass * 9.8 * (height + length / 2 * np.sin(angle[:, index]))
            height += length * np.sin(angle[:, index])
    total = kinetic + potential
    rate = np.gradient(total, done.time, edge_order=2)
    power = np.sum(done.power, axis=1)
    np.testing.assert_allclose(power, rate, atol=2e-3 * np.max(np.abs(power)))  # second-order differences, h = T/100
    assert done.energy == pytest.approx(total[-1] - total[0], rel=1e-4)  # trapezoidal rule, same h
    slower = mrts.scale(planar_cell, lift, 1.0).trajectory
    assert slower.energy == pytest.approx(done.energy, rel=1e-4)  # at rest at both ends: gravity's work only


def test_chosen_speed_scales_time_rates_and_power(planar_cell, lift):
    given = mrts.scale(planar_cell, lift, "nominal").trajectory
    fast = mrts.scale(planar_cell, lift, 2.25).trajectory
    assert given.duration == pytest.approx(lift.time[-1])
    assert fast.duration == pytest.approx(lift.time[-1] / 1.5)
    np.testing.assert_allclose(fast.dq, 1.5 * given.dq)
    np.testing.assert_allclose(fast.ddq, 2.25 * given.ddq)
    np.testing.assert_allclose(fast.power, fast.dq * fast.torque)
    np.testing.assert_array_equal(fast.q, given.q)


def test_internal_wrench_does_not_move_the_object(planar_cell, lift):
    result = mrts.scale(planar_cell.without_wrench_limits(), lift)
    B = planar_cell.functions("terms", result.motion.samples, result.motion.inputs(planar_cell.load))["B"]
    internal = result.trajectory.internal_wrench
    assert np.max(np.abs(np.einsum("nij,nj->ni", B, internal))) < 1e-10
    rest = result.trajectory.wrench - internal
    assert np.max(np.abs(np.sum(rest * internal, axis=1))) < 1e-8  # orthogonal parts
    assert np.max(np.abs(internal)) > 1  # and there is one
