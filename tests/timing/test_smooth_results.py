"""What a smooth result carries beside its timing, and how it says it."""

import numpy as np
import pytest
from random_motors import equipped

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


def test_a_jerk_that_passes_between_nodes_is_told_by_name(planar_cell, lift):
    free = equipped(planar_cell, jerk=200.0).without_wrench_limits()
    found = mrts.retime(free, lift, rates=True, between=None)
    assert found.excess.row.name.kind == "jerk"
    assert "jerk" in found.sentence()


def test_given_torques_of_a_load_that_varies_are_refused_before_any_work(planar_cell, lift):
    boxed = planar_cell.with_variation(mass=(0.9, 1.1))
    for name in ("start_torque", "end_torque"):
        with pytest.raises(mrts.InputError, match=f"{name}: holds one load, but the cell's varies"):
            mrts.retime(boxed, lift, rates=11.0, **{name: np.zeros(6)})
    assert mrts.retime(boxed, lift, rates=11.0, load="nominal", start_torque=np.zeros(6)).status.value == (
        "infeasible holding torque"
    )
