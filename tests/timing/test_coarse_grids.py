"""Few samples: sharp turns, and accelerations that rise along a segment, beside toppra."""

import numpy as np
import pytest
from cases import model_with_box
from cases import one_arm as shipped_arm
from coarse_grids import POINTS, compared, spline_path, table
from draws import seeds
from scipy.integrate import solve_ivp

import mrts
from mrts.following.coordinated_motion import carried_by_first
from mrts.motion.object_courses import PROFILES
from mrts.program.between_samples import BETWEEN
from mrts.program.motion_rows import motion_rows
from mrts.program.sample_ranges import motion_ranges
from mrts.program.smooth_program import segment_times
from mrts.timing.result import at_segment_ends

PATHS = 4
KEPT = 1e-6  # of c²: limits at both ends of a segment are kept to rounding, which a small effect of ṙ² widens
LONGER = 1.02  # a single path may take so much longer than toppra's, which oversteps limits
EVEN_GRID = np.linspace(0, 1, POINTS)


@pytest.fixture(scope="module")
def arm(tmp_path_factory):
    cell = shipped_arm(tmp_path_factory.mktemp("arm"))
    return cell, model_with_box(cell)


@pytest.mark.parametrize("law", ["own", "quintic"])
def test_coarse_tables_are_timed_no_worse_than_by_toppra(arm, law):
    """From the same samples: what is overstepped between them, and how long it takes."""
    grid = EVEN_GRID if law == "own" else PROFILES["quintic"](EVEN_GRID)[0]
    found = []
    for seed in range(PATHS):
        path = spline_path(*arm, seed)
        found.append(compared(path, table(path, grid), grid))
    assert max(one.refined for one in found) <= 1e-4
    ratios = [(1 + one.longer[2]) / (1 + one.longer[0]) for one in found]
    assert np.median(ratios) < 1 < LONGER
    assert max(ratios) < LONGER


def test_limits_hold_between_the_samples_across_a_knot(arm):
    """Its third derivative jumps inside a segment: divided, that stays the same curve, and the excess vanishes."""
    grid = np.linspace(0, 1, 334)  # its knots, at fifths, lie inside segments
    for seed in range(PATHS):
        path = spline_path(*arm, seed)
        motion = carried_by_first(path.cell, grid, *(path.spline(grid, order) for order in range(3)))
        found = mrts.retime(path.cell, motion)
        assert found.status is mrts.RetimingStatus.OPTIMAL, seed
        assert found.excess.share <= BETWEEN


@pytest.mark.parametrize("seed", seeds(1, 1))
def test_limits_hold_at_both_ends_of_every_segment(arm, seed):
    """With a rising acceleration: c² = 1 is within the range at each end."""
    path = spline_path(*arm, seed)
    found = mrts.retime(path.cell, table(path, EVEN_GRID), between=None)
    (part,) = found.pieces
    assert np.any(part.profile.rise)
    for motion in at_segment_ends(part):
        assert np.min(motion_ranges(motion_rows(path.cell, motion)).upper) >= 1 - KEPT


@pytest.mark.parametrize("seed", range(3))
def test_times_of_segments_are_those_of_the_differential_equation(seed):
    rng = np.random.default_rng([180, seed])
    step, start, rate, rise = rng.uniform(0.1, 1), rng.uniform(0.2, 2), rng.uniform(0, 3), rng.uniform(-1, 1)
    rise *= 0.3 if seed else 0.0
    end = start + 2 * step * rate
    found = segment_times(np.array([step]), np.array([start, end]), np.array([rise]))
    first = rate - rise / 2

    def arrives(_time, state):
        return state[0] - step

    arrives.terminal = True
    played = solve_ivp(
        lambda _time, state: [state[1], first + rise * state[0] / step],
        (0, 100),
        [0.0, np.sqrt(start)],
        events=arrives,
        rtol=1e-11,
        atol=1e-13,
    )
    assert found[0] == pytest.approx(played.t_events[0][0], rel=1e-8)
    assert played.y_events[0][0][1] ** 2 == pytest.approx(end, rel=1e-8)
