"""The fastest timing with motors, against toppra, a nonlinear program, closed forms and its own rows."""

import numpy as np
import pytest
from cell_bank import random_planar_cell, random_spatial_cell
from draws import seeds
from gantries import along_x, gantries
from one_arm import duration
from random_motors import drawn_motors, equipped
from scipy.optimize import linprog
from transcription import transcribed

import mrts
from mrts.following.coordinated_motion import carried_by_first
from mrts.program.motion_rows import motion_rows
from mrts.program.sample_problem import build_sample_problem
from mrts.timing.fastest_profile import Obstacle
from mrts.timing.path_pieces import path_pieces
from mrts.timing.successive_profiles import successive_profiles

TRANSCRIPTION_TOLERANCE = 1e-5
DISCRETE = 2e-3  # limits hold at samples, closed forms everywhere
FEASIBLE = 1e-8  # of a limit: projections are exact to 1e-9
FALLING = 1e-12  # rounding of a sum of times

CELLS = 12


def drawn_case(seed, folder, samples=21):
    """Rows over [F, u, x] and √x of a random cell with motors, its path, and the cell."""
    rng = np.random.default_rng([15, seed])
    draw, arms = (random_spatial_cell, 2) if seed % 3 == 0 else (random_planar_cell, 1 + seed % 3)
    case = draw(rng, folder, arms, samples=samples)
    cell = drawn_motors(rng, case.cell.without_velocity_limits())
    motion = mrts.follow_object(cell, case.motion)
    (piece,) = path_pieces(cell, motion)
    return build_sample_problem(motion_rows(cell, piece.path), varying=True), piece, cell, motion


@pytest.mark.parametrize("seed", seeds(3, CELLS - 3))
def test_random_cells_equal_a_nonlinear_program_and_every_step_is_faster(seed, tmp_path):
    problem, piece, cell, motion = drawn_case(seed, tmp_path)
    steps = successive_profiles([problem], piece.step, (0.0, 0.0))
    if isinstance(steps, Obstacle):
        slow = np.minimum(np.arange(21), np.arange(21)[::-1]) * 1e-3
        assert not transcribed(cell, motion, slow)()[0]
        return
    durations = np.array([duration(piece.step, one.x) for one in steps])
    assert np.all(np.diff(durations) <= FALLING * durations[0])
    found, theirs = transcribed(cell, motion, 0.3 * steps[0].x)()
    assert found
    assert durations[-1] == pytest.approx(duration(piece.step, theirs), rel=TRANSCRIPTION_TOLERANCE)


def widening(problem, sample, u, x):
    """By how many limits rows must move outward at a speed, with √x as it is, by HiGHS."""
    A, free = problem.A[sample], problem.unknowns - 2
    given = A[:, -2] * u + A[:, -1] * x + problem.speed[sample] * np.sqrt(x)
    rows = np.concatenate([A[:, :free], -A[:, :free]])
    limit = np.concatenate([problem.upper[sample] - given, given - problem.lower[sample]])
    kept = np.isfinite(limit)
    outward = np.column_stack([rows[kept], -np.ones(np.sum(kept))])
    found = linprog(np.append(np.zeros(free), 1.0), outward, limit[kept], bounds=[(None, None)] * free + [(0, None)])
    assert found.status == 0
    return found.fun


@pytest.mark.parametrize("seed", [1, pytest.param(0, marks=pytest.mark.slow)])
def test_every_step_keeps_all_limits_with_its_root_as_it_is(seed, tmp_path):
    problem, piece, *_ = drawn_case(seed, tmp_path)
    steps = successive_profiles([problem], piece.step, (0.0, 0.0))
    assert len(steps) > 2
    for one in steps:
        x = one.x
        u = np.diff(x) / (2 * piece.step)
        excess = [widening(problem, place + end, u[place], x[place + end]) for place in range(len(u)) for end in (0, 1)]
        assert max(excess) <= FEASIBLE


@pytest.mark.quick
@pytest.mark.parametrize(
    ("motors", "drive", "brake", "mass"),
    [({"coulomb": 3.0, "armature": 0.5}, 34, 46, 12), ({"torque_speed": [[0, 20], [10, 0]]}, 40, 40, 11)],
)
def test_gantries_equal_closed_forms(motors, drive, brake, mass, tmp_path):
    """Two motors of 20 N move 11 kg by 2 m."""
    cell = equipped(gantries(tmp_path), **motors)
    found = mrts.retime(cell, along_x(samples=201))
    assert found.status.admits_motion, found.summary()
    top = np.sqrt(2 * 2.0 / mass * drive * brake / (drive + brake))
    expected = driven_by_curve() if "torque_speed" in motors else mass * top * (1 / drive + 1 / brake)
    assert found.duration == pytest.approx(expected, rel=DISCRETE)


def driven_by_curve():
    """40 N less 4 N s/m while it drives 11 kg, 40 N while it brakes; m v dv = (40 - 4 v) dx by quadrature."""
    v = np.linspace(0, 9.9, 200_001)
    force = 40 - 4 * v
    x = np.concatenate([[0], np.cumsum((11 * v / force)[1:] + (11 * v / force)[:-1]) * np.diff(v)[0] / 2])
    t = np.concatenate([[0], np.cumsum((11 / force)[1:] + (11 / force)[:-1]) * np.diff(v)[0] / 2])
    place = int(np.argmin(np.abs(x + 11 * v**2 / 80 - 2)))
    return t[place] + 11 * v[place] / 40


@pytest.mark.quick
@pytest.mark.parametrize(("back", "profile"), [(-1.0, "cubic"), (1.0, "quintic")])
def test_friction_at_a_stop_points_along_the_travel(back, profile, tmp_path):
    """There and back, or on: each way takes the time that it takes by itself, and torques at the stop keep limits."""
    cell = equipped(gantries(tmp_path), coulomb=8.0, viscous=0.5)
    one = mrts.follow_object(cell, along_x(samples=101, profile=profile))
    way = one.object
    time = np.concatenate([way.time, 1 + way.time[1:]])
    q, dq, ddq = (
        np.concatenate([first, second[1:]])
        for first, second in (
            (one.q, one.q[::-1] if back < 0 else one.q + one.q[-1] - one.q[0]),
            (one.dq, back * one.dq),
            (one.ddq, back * one.ddq),
        )
    )
    motion = carried_by_first(cell, time, q, dq, ddq)
    there, both = mrts.retime(cell, one), mrts.retime(cell, motion)
    assert both.status.admits_motion, both.summary()
    assert len(both.stops) == 1
    assert both.duration == pytest.approx(2 * there.duration, rel=1e-6)
    done = both.retimed.trajectory
    assert done.friction[0, 0] == pytest.approx(8)
    assert done.friction[100, 0] == pytest.approx(0 if back < 0 else 8)
    assert done.friction[-1, 0] == pytest.approx(8 * back)
    assert both.retimed.residuals().limits <= FEASIBLE
    mrts.save_result(both.retimed, tmp_path / "stop.npz")
    assert np.array_equal(mrts.load_result(tmp_path / "stop.npz").trajectory.friction, done.friction)
