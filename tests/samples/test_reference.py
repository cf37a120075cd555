"""Ranges of c² against the independent implementation, on 100 planar and 100 spatial random cells of 1 to 4 arms."""

from collections import Counter

import numpy as np
import pytest
from random_cells import random_planar_cell, random_spatial_cell
from reference import ReferenceCell

import mrts

CELLS_PER_COUNT = 25
RANGE_TOLERANCE = 1e-7  # HiGHS and Newton tolerances of 1e-10 and 1e-12, times the condition of the programs
MOTION_TOLERANCE = 1e-8


@pytest.mark.parametrize("make", [random_planar_cell, random_spatial_cell])
@pytest.mark.parametrize("arms", [4, 3, 2, 1])
def test_ranges_equal_the_reference(arms, make, tmp_path):
    seen = Counter()
    for seed in range(CELLS_PER_COUNT):
        folder = tmp_path / str(seed)
        folder.mkdir()
        paths = make(np.random.default_rng([arms, seed]), folder, arms)
        seen += compare(*paths, f"{arms} arms, seed {seed}")
    # the random cells would prove little if they were all of one kind
    assert seen["feasible"] > 50
    assert seen["infeasible"] > 10
    assert seen["unbounded"] > 0
    assert seen["minimum speed"] > 3
    assert 10 < seen["velocity"] < seen["feasible"] - 10


def compare(cell_path, motion_path, label):
    cell = mrts.load_cell(cell_path, backend="vm")
    motion = mrts.follow_object(cell, mrts.load_motion(motion_path))
    reference = ReferenceCell(cell_path)
    _, samples = reference.object_motion(motion_path)
    joints = reference.joint_motion(samples)
    for index, field in enumerate((motion.q, motion.dq, motion.ddq)):
        theirs = np.concatenate([[step[index] for step in arm] for arm in joints], axis=1)
        if index == 0:
            theirs = field + (theirs - field + np.pi) % (2 * np.pi) - np.pi
        np.testing.assert_allclose(field, theirs, atol=MOTION_TOLERANCE * (1 + np.max(np.abs(theirs))), err_msg=label)

    seen = Counter()
    for even in (False, True):
        result = mrts.scale(cell, motion, sharing=mrts.LoadSharing() if even else None)
        ours = result.range.samples
        for k, sample in enumerate(samples):
            terms = reference.terms(sample, [arm[k] for arm in joints])
            status, low, high = reference.range_at(terms, [arm[k] for arm in joints], even=even)
            where = f"{label}, sample {k}, even {even}"
            assert ours.status[k].value == status, where
            seen[status] += 1
            if status == "infeasible":
                continue
            assert ours.lower[k] == pytest.approx(low, rel=RANGE_TOLERANCE, abs=RANGE_TOLERANCE), where
            seen["minimum speed"] += low > RANGE_TOLERANCE
            if status == "feasible":
                seen["velocity"] += any(row.name.kind == "velocity" for row in ours.upper_rows[k])
                assert ours.upper[k] == pytest.approx(high, rel=RANGE_TOLERANCE, abs=RANGE_TOLERANCE), where
    return seen
