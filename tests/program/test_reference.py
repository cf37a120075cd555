"""Ranges of c² against the independent implementation, on planar and spatial random cells of 1 to 4 arms."""

import numpy as np
import pytest
from cell_bank import random_planar_cell, random_spatial_cell
from draws import seeds
from reference import ReferenceCell

import mrts

SEEDS = 8
RANGE_TOLERANCE = 1e-7  # HiGHS and Newton tolerances of 1e-10 and 1e-12, times the condition of the programs
MOTION_TOLERANCE = 1e-8


@pytest.mark.parametrize("make", [random_planar_cell, random_spatial_cell])
@pytest.mark.parametrize("arms", [pytest.param(4, marks=pytest.mark.slow), 3, 2, 1])
@pytest.mark.parametrize("seed", [pytest.param(0, marks=pytest.mark.quick), *seeds(1, SEEDS - 1)[1:]])
def test_ranges_equal_the_reference(seed, arms, make, tmp_path):
    case = make(np.random.default_rng([arms, seed]), tmp_path, arms)
    motion = mrts.follow_object(case.cell, case.motion)
    reference = ReferenceCell(case.cell_file)
    _, samples = reference.object_motion(case.motion_file)
    joints = reference.joint_motion(samples)
    for index, field in enumerate((motion.q, motion.dq, motion.ddq)):
        theirs = np.concatenate([[step[index] for step in arm] for arm in joints], axis=1)
        if index == 0:
            theirs = field + (theirs - field + np.pi) % (2 * np.pi) - np.pi
        np.testing.assert_allclose(field, theirs, atol=MOTION_TOLERANCE * (1 + np.max(np.abs(theirs))))
    at = [[arm[k] for arm in joints] for k in range(len(samples))]
    terms = [reference.terms(*pair) for pair in zip(samples, at, strict=True)]
    for even in (False, True):
        sharing = mrts.LoadSharing() if even else None
        ours = mrts.scale(case.cell, motion, sharing=sharing, between=None).range.samples
        for k, term in enumerate(terms):
            status, low, high = reference.range_at(term, at[k], even=even)
            where = f"sample {k}, even {even}"
            assert ours.status[k].value == status, where
            if status == "infeasible":
                continue
            assert ours.lower[k] == pytest.approx(low, rel=RANGE_TOLERANCE, abs=RANGE_TOLERANCE), where
            if status == "feasible":
                assert ours.upper[k] == pytest.approx(high, rel=RANGE_TOLERANCE, abs=RANGE_TOLERANCE), where
