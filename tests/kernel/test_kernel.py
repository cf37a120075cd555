"""Our dense kernel against HiGHS and DAQP, and its certificates by substitution."""

from collections import Counter

import daqp
import highspy
import numpy as np
import pytest
from random_programs import cell_programs, hard_programs
from reference import highs_minimum

import mrts
from mrts.kernel.cell_library import pointers
from mrts.kernel.programs import INFEASIBLE, MARGINAL, OPTIMAL, solve_batch
from mrts.program.solvers import ConvexPrograms, optimality_error, solve_programs

LINEAR_PROGRAMS, QUADRATIC_PROGRAMS, HARD = 34_000, 3_360, 20
SAMPLES = 84  # of one sequence of slowly changing programs
UNBOUNDED = 1e9
OBJECTIVE_TOLERANCE = RESIDUAL_TOLERANCE = COMBINATION_TOLERANCE = 1e-9
SHAPES = [(arms, size) for size in (3, 6) for arms in (2, 3, 4)]


def bounds(A):
    """Free unknowns, and 0 <= c² <= what counts as unbounded."""
    count, _, k = A.shape
    low, high = np.full((count, k), -np.inf), np.full((count, k), np.inf)
    low[:, -1], high[:, -1] = 0, UNBOUNDED
    return low, high


def certificate_holds(A, lower, upper, y):
    """Σ y_i (row i) shows that no x exists: yᵀA = 0 over rows and unknowns, and Σ y_i limit_i < 0."""
    rows = np.vstack([A, np.eye(A.shape[1])])
    terms = np.abs(y) @ np.abs(rows)
    limit = np.where(y > 0, upper, np.where(y < 0, lower, 0.0))
    return np.max(np.abs(y @ rows)) <= COMBINATION_TOLERANCE * np.max(terms) and np.sum(y * limit) < 0


@pytest.mark.parametrize(("arms", "size"), SHAPES)
def test_linear_programs_of_cells_equal_highs(arms, size):
    seen = Counter()
    rng = np.random.default_rng([arms, size])
    for _ in range(LINEAR_PROGRAMS // len(SHAPES) // SAMPLES // 2 + 1):
        A, lower, upper = cell_programs(rng, SAMPLES, arms, size)
        low, high = bounds(A)
        low, high = np.hstack([lower, low]), np.hstack([upper, high])
        rows = A.shape[1]
        for direction in (1.0, -1.0):
            g = np.zeros((SAMPLES, A.shape[2]))
            g[:, -1] = direction
            x, dual, status = solve_batch(None, g, A, low, high)
            good = status == OPTIMAL
            error = optimality_error(ConvexPrograms(None, g, A, low, high), x, dual)
            assert np.max(error[good], initial=0) <= RESIDUAL_TOLERANCE
            for n in range(SAMPLES):
                theirs, value = highs_minimum(A[n], lower[n], upper[n], low[n, rows:], high[n, rows:], direction)
                if theirs == highspy.HighsModelStatus.kInfeasible:
                    assert status[n] == INFEASIBLE, (arms, size, n)
                    assert certificate_holds(A[n], low[n], high[n], dual[n])
                    seen["infeasible"] += 1
                else:
                    assert theirs == highspy.HighsModelStatus.kOptimal
                    assert status[n] == OPTIMAL, (arms, size, n)
                    assert abs(direction * x[n, -1] - value) <= OBJECTIVE_TOLERANCE * max(1, abs(value))
                    seen["unbounded" if x[n, -1] > 0.99 * UNBOUNDED else "feasible"] += 1
    assert seen["feasible"] > LINEAR_PROGRAMS // 20
    assert seen["infeasible"] > LINEAR_PROGRAMS // 200


@pytest.mark.parametrize(("k", "rows"), [(3, 12), (7, 24), (13, 48), (31, 120)])
def test_hard_linear_programs_equal_highs(k, rows):
    seen = Counter()
    for seed in range(HARD):
        for kind, (A, lower, upper, feasible) in hard_programs(np.random.default_rng([k, seed]), k, rows).items():
            low, high = (side[0] for side in bounds(A[None]))
            for direction in (1.0, -1.0):
                g = np.zeros(k)
                g[-1] = direction
                ends = np.hstack([lower, low])[None], np.hstack([upper, high])[None]
                scaled, *_ = ConvexPrograms(None, g[None], A[None], *ends).scaled()
                ends = scaled.lower, scaled.upper
                x, dual, status = solve_batch(None, scaled.g, scaled.A, *ends)
                of_rows, of_unknowns = ([end[0, part] for end in ends] for part in (slice(rows), slice(rows, None)))
                theirs, value = highs_minimum(scaled.A[0], *of_rows, *of_unknowns, direction)
                ours = int(status[0])
                seen[kind, ours] += 1
                if feasible is not None:
                    assert (ours == OPTIMAL) == feasible, (kind, seed)
                if theirs == highspy.HighsModelStatus.kInfeasible:
                    assert ours in {INFEASIBLE, MARGINAL}, (kind, seed)
                if ours == INFEASIBLE:
                    assert certificate_holds(scaled.A[0], ends[0][0], ends[1][0], dual[0]), (kind, seed)
                if ours == OPTIMAL:
                    error = optimality_error(scaled, x, dual)
                    assert error[0] <= RESIDUAL_TOLERANCE, (kind, seed)
                    if theirs == highspy.HighsModelStatus.kOptimal:
                        # HiGHS stops at its own tolerance, which degenerate data magnify
                        assert abs(scaled.g[0] @ x[0] - value) <= 1e-7 * max(1, abs(value)), (kind, seed)
    assert seen["degenerate vertex", OPTIMAL] == seen["scales of 1e-6 to 1e6", OPTIMAL] == 2 * HARD
    # a certificate of large multipliers may be too weak to separate by 1e-6
    assert seen["infeasible by 1e-6", INFEASIBLE] >= 2 * HARD * 0.95


@pytest.mark.quick
def test_limits_that_miss_each_other_by_less_than_rounding_are_marginal():
    """x >= 1 + gap and x <= 1: a certificate from 1e-8 on, feasible below 1e-10, marginal between."""
    wanted = {1e-6: {INFEASIBLE}, 1e-8: {INFEASIBLE}, 1e-9: {INFEASIBLE, MARGINAL}, 1e-12: {OPTIMAL}, 0.0: {OPTIMAL}}
    for gap, statuses in wanted.items():
        A = np.array([[[1.0, 0.0], [1.0, 0.0]]])
        lower, upper = np.array([[1 + gap, -np.inf, -np.inf, 0.0]]), np.array([[np.inf, 1.0, np.inf, 5.0]])
        _, _, status = solve_batch(None, np.array([[0.0, 1.0]]), A, lower, upper)
        assert int(status[0]) in statuses, gap


def test_quadratic_programs_of_cells_equal_daqp():
    rng, compared = np.random.default_rng(11), 0
    infeasible = 0
    for sequence in range(QUADRATIC_PROGRAMS // SAMPLES):
        arms, size = SHAPES[sequence % len(SHAPES)]
        A, lower, upper = cell_programs(rng, SAMPLES, arms, size)
        speed = rng.uniform(0, 0.4, SAMPLES)[:, None]
        given = A[:, :, -1] * speed
        T, offset = A[:, : arms * size, :-1], given[:, : arms * size]
        H, g = np.swapaxes(T, 1, 2) @ T, np.einsum("nri,nr->ni", T, offset)
        free = np.full((SAMPLES, A.shape[2] - 1), np.inf)
        A, lower, upper = np.ascontiguousarray(A[:, :, :-1]), lower - given, upper - given
        programs = ConvexPrograms(H, g, A, np.hstack([lower, -free]), np.hstack([upper, free]))
        x, dual, status = solve_batch(H, g, A, programs.lower, programs.upper)
        good = status == OPTIMAL
        error = optimality_error(programs, x, dual)
        assert np.max(error[good], initial=0) <= RESIDUAL_TOLERANCE
        for n in range(SAMPLES):
            sense = np.zeros(A.shape[1], dtype=np.int32)
            ends = np.clip(upper[n], -1e30, 1e30), np.clip(lower[n], -1e30, 1e30)
            theirs, value, flag, _ = daqp.solve(H[n], g[n], A[n], *ends, sense)
            if flag == -1:
                assert status[n] in {INFEASIBLE, MARGINAL}
                infeasible += 1
                continue
            assert flag == 1
            assert status[n] == OPTIMAL
            ours = x[n] @ H[n] @ x[n] / 2 + g[n] @ x[n]
            assert abs(ours - value) <= OBJECTIVE_TOLERANCE * max(1, abs(value), abs(g[n] @ x[n]))
            np.testing.assert_allclose(x[n], theirs, atol=1e-6 * (1 + np.max(np.abs(theirs))))
            compared += 1
    assert compared > QUADRATIC_PROGRAMS // 3
    assert infeasible > QUADRATIC_PROGRAMS // 100


def test_hard_quadratic_programs_pass_their_conditions():
    solved = Counter()
    for k, rows in ((3, 12), (7, 24), (20, 80)):
        for seed in range(HARD):
            rng = np.random.default_rng([k, rows, seed])
            root = rng.normal(size=(k, k)) * 10.0 ** rng.uniform(-2, 2, k)
            for kind, (A, lower, upper, feasible) in hard_programs(rng, k, rows).items():
                free = np.full((1, k), np.inf)
                H, g = (root.T @ root + np.eye(k) * 1e-3)[None], rng.normal(size=(1, k))
                ends = np.hstack([lower[None], -free]), np.hstack([upper[None], free])
                programs = ConvexPrograms(H, g, A[None], *ends)
                scaled, _, _ = programs.scaled()
                x, dual, status = solve_batch(scaled.H, scaled.g, scaled.A, scaled.lower, scaled.upper)
                solved[kind, int(status[0])] += 1
                if status[0] == OPTIMAL:
                    error = optimality_error(scaled, x, dual)
                    assert error[0] <= RESIDUAL_TOLERANCE * 1e3, (kind, k, seed)  # gradients are held to 1e-12 there
                elif feasible:
                    answers = solve_programs(programs, "kernel")
                    assert answers.verified[0], (kind, k, seed)
    assert solved["degenerate vertex", OPTIMAL] == 3 * HARD


@pytest.mark.quick
def test_numbers_lie_where_numpy_says():
    whole = np.arange(6.0)
    whole.setflags(write=False)
    for array in (whole, whole[2:], np.zeros(0), np.zeros((3, 2), dtype=np.int32)):
        assert pointers([array])[0] == array.ctypes.data


def test_inputs_of_a_wrong_shape_never_reach_the_compiled_code(planar_cell):
    for q in (np.zeros((1, 6)), np.zeros((50, 5)), np.zeros(7), np.zeros((51, 6))):
        with pytest.raises(ValueError, match="q has Shape"):
            planar_cell.functions("kinematics", 50, {"q": q})


@pytest.mark.quick
def test_what_is_no_number_gets_no_answer(planar_cell):
    A = np.ones((1, 3, 2))
    A[0, 1, 0] = np.nan
    low, high = np.array([[-1.0, -1, -1, -1, 0]]), np.array([[1.0, 1, 1, 1, 1]])
    _, _, status = solve_batch(None, np.array([[0.0, 1]]), A, low, high)
    assert status[0] != OPTIMAL
    _, _, status = solve_batch(np.eye(2)[None], np.array([[-5.0, 1]]), A, low, high)
    assert status[0] != OPTIMAL
    with pytest.raises(mrts.InputError, match="must be <= 1e"):
        planar_cell.with_mass(1.7e308)
