"""What a smooth result carries beside its timing, and how it says it."""

import numpy as np
import pytest

import mrts
from mrts.program.motion_rows import motion_rows
from mrts.program.sample_problem import build_sample_problem
from mrts.timing.result import RetimingStatus


@pytest.fixture(scope="module")
def smooth(planar_cell, lift):
    return mrts.retime(planar_cell, lift, rates=11.0)


def test_what_passes_between_nodes_is_told_at_the_time_that_it_is_played(planar_cell, lift):
    bare = mrts.retime(planar_cell, lift, rates=11.0, between=None)
    assert bare.status is RetimingStatus.LOCALLY_AT_SAMPLES
    given, own = bare.motion.object.time, bare.retimed.motion.object.time
    assert bare.retimed.excess.time == np.interp(bare.excess.time, given, own)
    assert bare.retimed.excess.time < bare.duration < given[-1]


def test_the_plan_keeps_limits_between_its_rows_where_it_is_linear(smooth, planar_cell):
    (part,) = smooth.pieces
    segment, share, x, u = part.between()
    problem = build_sample_problem(motion_rows(planar_cell, part.piece.fine.at(part.piece.inside)), varying=True)
    plan = part.plan[segment] * (1 - share[:, None]) + part.plan[segment + 1] * share[:, None]
    values = np.einsum("nrk,nk->nr", problem.A, np.column_stack([plan, u, x]))
    excess = np.max(np.maximum(values - problem.upper, problem.lower - values))
    assert smooth.excess.share == pytest.approx(max(excess, 0.0), abs=1e-12)
    assert excess < 1e-4  # 4 % at a quarter of the nodes, where other wrenches than the plan's keep this
