"""The paper's appendices as properties, and both formulations against each other, on random cells."""

import numpy as np
import pytest
from cell_bank import drawn_until, random_planar_cell
from draws import seeds

import mrts
from mrts.limits import limit_rows
from mrts.program.motion_rows import motion_rows
from mrts.program.sample_problem import build_sample_problem
from mrts.program.sample_ranges import SampleStatus, sample_ranges
from mrts.program.torque_distribution import distribute_torques

LIMIT_TOLERANCE = 3e-9  # the quadratic program widens limits by 1e-9 of their size plus 1e-9

MOTIONS = 12  # with two feasible samples or more each, so that there are 300 speeds between the ends


def draws(folder, family, seed):
    """Draws random cells of two to four arms."""
    rng = np.random.default_rng([family, seed])
    return lambda: random_planar_cell(rng, folder, arms=2 + seed % 3)


def feasible_samples(ranges):
    return np.flatnonzero([status is SampleStatus.FEASIBLE for status in ranges.status])


def limit_violation(rows, torque, wrench, c2):
    value = rows.value(torque[None], wrench[None], 0.0, np.sqrt(c2))
    lower, upper = rows.limits.lower, rows.limits.upper
    size = 1 + np.where(np.isfinite(upper), np.abs(upper), np.abs(lower))
    return float(np.max(np.maximum(lower - value, value - upper) / size))


def feasible_problem(case):
    """Its motion, sample problem and ranges, if at least two samples are feasible."""
    motion = mrts.follow_object(case.cell, case.motion)
    problem = build_sample_problem(motion_rows(case.cell, motion))
    ranges = sample_ranges(problem, case.motion.time)
    return (motion, problem, ranges) if len(feasible_samples(ranges)) > 1 else None


@pytest.mark.parametrize("seed", seeds(4, MOTIONS - 4))
def test_appendix_a_every_speed_between_the_ends_is_feasible_and_c_torques_satisfy_all_equations(seed, tmp_path):
    """At 14 c² of every feasible sample the quadratic program has a solution; it satisfies (8), (13), (20), (24)."""
    rng = np.random.default_rng(seed)
    case, (joint_motion, problem, ranges) = drawn_until(feasible_problem, draws(tmp_path, 101, seed))
    cell = case.cell
    terms = cell.functions("terms", joint_motion.samples, joint_motion.inputs(cell.load))
    limits = limit_rows(cell, joint_motion)
    for k in feasible_samples(ranges):
        for share in [0.0, 1.0, *rng.uniform(0, 1, 12)]:
            c2 = float(ranges.lower[k] + share * (ranges.upper[k] - ranges.lower[k]))
            one = problem.at(np.array([k]))
            x = distribute_torques(one, c2, np.eye(len(cell.joint_names)))
            torque, wrench = one.torque(x)[0], one.wrench(x)[0]
            assert limit_violation(limits.at(np.array([k])), torque, wrench, c2) <= LIMIT_TOLERANCE
            scale = 1 + np.max(np.abs(torque)) + np.max(np.abs(wrench))
            balance = terms["B"][k] @ wrench - c2 * terms["P"][k] - terms["Q"][k]
            assert np.max(np.abs(balance)) <= 1e-10 * scale
            for name, joints in cell.joint_slices.items():
                J, F = terms["J"][k][:, joints], wrench[cell.wrench_slices[name]]
                arm = torque[joints] - c2 * terms["E"][k, joints] - terms["G"][k, joints] - J.T @ F
                assert np.max(np.abs(arm)) <= 1e-10 * scale


@pytest.mark.quick
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


@pytest.mark.quick
def test_internal_wrench_does_not_move_the_object(planar_cell, lift):
    result = mrts.scale(planar_cell.without_wrench_limits(), lift)
    B = planar_cell.functions("terms", result.motion.samples, result.motion.inputs(planar_cell.load))["B"]
    internal = result.trajectory.internal_wrench
    assert np.max(np.abs(np.einsum("nij,nj->ni", B, internal))) < 1e-10
    rest = result.trajectory.wrench - internal
    assert np.max(np.abs(np.sum(rest * internal, axis=1))) < 1e-8  # orthogonal parts
    assert np.max(np.abs(internal)) > 1  # and there is one
