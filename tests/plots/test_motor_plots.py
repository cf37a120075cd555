"""The plot of an identification shows its numbers."""

from pathlib import Path

import numpy as np
import pytest
from motor_recordings import exact_recording, random_motors, recording

import mrts
from mrts.plots import motor_plot


@pytest.fixture(scope="module")
def found(planar_cell):
    """A joint that stands still, and efforts with an offset."""
    joints, time, q, effort = exact_recording(planar_cell, random_motors(6), rate=200, still=(1,))
    return mrts.identify(planar_cell, recording(Path("recorded.csv"), joints, time, q, effort + 2.0))


@pytest.mark.quick
def test_friction_and_residual_are_those_of_the_result(found):
    arm = found.arm("left")
    rows = motor_plot(arm).rows
    assert [len(row) for row in rows] == [3, 3, 3]
    dots, line = rows[0][1].items
    coulomb, viscous = arm.coulomb.value[0], arm.viscous.value[0]
    np.testing.assert_allclose(line.y, np.array([-1, -1, 1, 1]) * coulomb + viscous * line.x)
    assert len(dots.x) == np.count_nonzero(arm.used[:, 0])
    np.testing.assert_allclose(dots.y, coulomb * np.sign(dots.x) + viscous * dots.x, atol=0.01)
    (residual,) = rows[0][2].items
    np.testing.assert_allclose(np.sqrt(np.mean(residual.y**2)), arm.residual_rms[0])
