"""Our interior point against Clarabel, on programs of every kind that smooth timing has."""

from dataclasses import replace

import numpy as np
import pytest
from conic_timing import ConicSolver
from smooth_paths import smooth_path

from mrts.program.path_solver import KernelSolver, cost
from mrts.program.smooth_program import Goal

KINDS = {
    "one arm": {"rows": 6, "joints": 6, "changes": False},
    "two arms": {"rows": 24, "free": 6},
    "corners": {"rows": 12, "free": 6, "blocks": 2},
    "roots": {"rows": 12, "free": 6, "roots": True},
    "cones": {"rows": 8, "free": 3, "cones": 2},
    "everything": {"rows": 8, "free": 3, "blocks": 2, "roots": True, "joints": 3, "cones": 1},
}

AGREES = 1e-6
"""Share of the cost: Clarabel's own answers to two units of a program differ by a tenth of it."""

KEPT = 1e-8
"""Excess over a limit, as a share of it: a tenth of what an answer is checked to."""

FORESEEN = 1e-6
"""Share by which a step may better what was foreseen: tangents are laid the last time a little before the end."""

RELAXED = 0.05
"""Share of what rates pass their limits by, where the duration counts a little besides."""

THIN = 1e-5
"""Share of the effort where limits leave hardly any room: Clarabel stops this far from the least."""


def programs(kind, count, seed):
    """Programs with a profile that keeps their limits and a goal, with ends given and not."""
    rng = np.random.default_rng(seed)
    for index in range(count):
        program, base = smooth_path(rng, int(rng.integers(2, 24)), **KINDS[kind])
        if index % 4 in (1, 3):
            program = replace(program, ends=(base.x[0], base.x[-1] if index % 8 == 1 else None))
        if index % 4 > 1 and program.free.shape[2]:
            program = replace(program, end_free=(base.free[0], base.free[-1] if index % 8 > 3 else None))
        duration = program.duration(base.x)
        effort = rng.choice([0.0, 0.1, 3.0])
        yield program, base, Goal(effort=effort)
        yield program, base, Goal(time=rng.choice([0.0, 0.1]), effort=1.0, longest=duration * rng.uniform(0.97, 1.05))


def replaced_cost(program, profile, around, goal):
    """The objective of a step: root² √x of the effort by its tangent."""
    root = np.sqrt(around)
    above = root + (profile.x - around) / (2 * root) - np.sqrt(profile.x)
    more = np.sum(program.spacing[:, None] * program.weight * program.root**2 * above[:, None])
    return cost(program, profile, goal) + goal.effort * float(more)


@pytest.mark.parametrize("kind", KINDS)
def test_a_step_is_clarabels(kind):
    solver = KernelSolver()
    worst = 0.0
    for program, base, goal in programs(kind, 11, 1):
        ours, theirs = solver.step(program, base.x, goal), ConicSolver.step(program, base.x, goal)
        assert (ours is None) == (theirs is None)
        if ours is None:
            continue
        assert program.excess(ours) <= KEPT
        reached = (*ours.x[[0, -1]], *ours.free[[0, -1]])
        for given, found in zip((*program.ends, *program.end_free), reached, strict=True):
            assert given is None or np.array_equal(given, found)
        assert ours.x[1:] == pytest.approx(ours.x[:-1] + program.step * (ours.u[1:] + ours.u[:-1]), rel=1e-12)
        if goal.longest is not None:
            assert program.duration(ours.x) <= goal.longest * (1 + KEPT)
        best = replaced_cost(program, theirs, base.x, goal)
        worst = max(worst, abs(replaced_cost(program, ours, base.x, goal) / best - 1))
    assert worst <= AGREES


@pytest.mark.parametrize("kind", KINDS)
def test_what_cannot_be_kept_gets_no_answer(kind):
    """Bars that the profile had room below are lowered to where no x keeps them."""
    solver = KernelSolver()
    for program, base, goal in programs(kind, 4, 2):
        hopeless = (
            replace(program, upper=program.lower.clip(-1e3) - 1e-3),
            replace(program, upper=np.full_like(program.upper, -3.0), lower=np.full_like(program.lower, -np.inf)),
        )
        for refused in hopeless:
            assert solver.step(refused, base.x, goal) is None
            assert solver.step(refused, base.x, goal, moving=True) is None
        soon = replace(goal, longest=program.duration(base.x) / 100)
        assert (solver.step(program, base.x, soon) is None) == (ConicSolver.step(program, base.x, soon) is None)


@pytest.mark.parametrize("kind", [kind for kind in KINDS if "free" in KINDS[kind]])
def test_torques_are_clarabels(kind):
    """On timings with room, and on the fastest, whose limits leave F hardly any."""
    solver = KernelSolver()
    for program, base, goal in programs(kind, 6, 3):
        fastest = solver.step(program, base.x, goal)
        for profile, close in ((base, AGREES), (fastest, THIN)):
            if profile is None:
                continue
            ours = solver.torques(program, profile.x, profile.u)
            theirs = ConicSolver.torques(program, profile.x, profile.u)
            assert ours is not None
            with_ours = replace(profile, free=ours)
            assert program.excess(with_ours) <= KEPT
            effort = program.effort(with_ours)
            assert effort <= program.effort(profile) * (1 + AGREES)
            if theirs is not None:
                assert effort <= program.effort(replace(profile, free=theirs)) * (1 + close)


@pytest.mark.parametrize("kind", KINDS)
def test_what_is_foreseen_is_where_steps_end(kind):
    """Steps from it gain next to nothing, and steps from the first profile do not lead below it by more."""
    solver = KernelSolver()
    for program, base, goal in programs(kind, 4, 4):
        foreseen = solver.step(program, base.x, goal, moving=True)
        if foreseen is None:
            continue
        assert program.excess(foreseen) <= KEPT
        best = cost(program, foreseen, goal)
        after = solver.step(program, foreseen.x, goal)
        assert best * (1 - FORESEEN) <= cost(program, after, goal) <= best * (1 + AGREES)


def with_middles(program):
    """The same program with a node in the middle of every segment, on lines between its neighbours."""

    def of_nodes(values):
        finer = np.repeat(values, 2, axis=0)[: 2 * len(values) - 1]
        finer[1::2] = (values[:-1] + values[1:]) / 2
        return finer

    names = ("square", "rate", "root", "offset", "free", "lower", "upper", "q1", "q2", "gram", "bound")
    nodes = {name: of_nodes(getattr(program, name)) for name in names}
    return replace(program, step=np.repeat(program.step / 2, 2), q3=np.repeat(program.q3, 2, axis=0), **nodes)


@pytest.mark.parametrize("kind", KINDS)
def test_an_answer_does_not_depend_on_what_was_asked_before(kind):
    """What starts from the last one's iterates, on its nodes or on more, finds what a new solver finds."""
    iterations = np.zeros(2)
    for program, base, goal in programs(kind, 4, 5):
        solver = KernelSolver()
        first = solver.step(program, base.x, goal, moving=True)
        if first is None:
            continue
        sigma = np.append(0.0, np.cumsum(program.step))
        finer = with_middles(program)
        for asked, x in ((program, first.x), (finer, np.interp(np.append(0.0, np.cumsum(finer.step)), sigma, first.x))):
            again, cold = solver.step(asked, x, goal), KernelSolver()
            alone = cold.step(asked, x, goal)
            assert (again is None) == (alone is None)
            if again is None:
                continue
            iterations += solver.iterations, cold.iterations
            assert replaced_cost(asked, again, x, goal) == pytest.approx(
                replaced_cost(asked, alone, x, goal), rel=AGREES
            )
            given = [one.torques(asked, alone.x, alone.u) for one in (solver, cold)]
            efforts = [None if free is None else asked.effort(replace(alone, free=free)) for free in given]
            assert efforts[0] == pytest.approx(efforts[1], rel=AGREES)
    assert iterations[0] < iterations[1]


@pytest.mark.parametrize("name", ["square", "rate", "offset", "lower", "upper", "step", "weight", "gram", "bound"])
@pytest.mark.parametrize("number", [np.nan, np.inf, -np.inf, 1e308, -1e308, 1e-320])
def test_numbers_of_any_size_get_an_answer_that_is_one_or_none(name, number):
    program, base = smooth_path(np.random.default_rng(1), 9, **KINDS["two arms"] | {"cones": 2})
    array = getattr(program, name).copy()
    array.flat[array.size // 2] = number
    hostile = replace(program, **{name: array})
    for around in (base.x, base.x * 1e-200):
        found = KernelSolver().step(hostile, around, Goal(effort=1.0))
        if found is not None:
            assert np.all(found.x > 0)
            assert all(np.all(np.isfinite(each)) for each in (found.x, found.u, found.free))


@pytest.mark.parametrize("kind", KINDS)
def test_rates_are_passed_by_the_least_share(kind):
    """By next to none where a profile keeps them, though tangents are laid where none does."""
    solver = KernelSolver()
    for program, base, _ in programs(kind, 2, 8):
        found, share = solver.nearest(program, base.x)
        assert share <= KEPT
        assert program.excess(found) <= KEPT
        small = replace(program, change=program.change / 1e3, jerk=program.jerk / 1e3)
        ours, theirs = solver.nearest(small, base.x), ConicSolver.nearest(small, base.x)
        assert (ours is None) == (theirs is None)
        if ours is not None:
            assert theirs[1] - AGREES <= ours[1] <= theirs[1] * (1 + RELAXED) + AGREES
