"""How points of an arm move, against differences of where they are."""

import numpy as np
import pytest

from mrts.base.rigid_transform import rotations_from_vectors
from mrts.kernel.arm_points import arm_point

STEP = 1e-4
SLIDES = (False, True, False, False)


def place(axes, points, at_zero, q):
    """Of the point, with each joint's motion after another from the last one on."""
    found = at_zero
    for axis, point, slides, value in reversed(list(zip(axes, points, SLIDES, q, strict=True))):
        found = (
            found + axis * value if slides else point + rotations_from_vectors(axis[None] * value)[0] @ (found - point)
        )
    return found


@pytest.mark.quick
def test_points_move_as_differences_of_their_places_say(planar_cell):
    rng = np.random.default_rng(3)
    axes, points = rng.normal(size=(2, 4, 3))
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    at_zero, rates = rng.normal(size=3), rng.normal(size=(3, 5, 4))
    found = arm_point(planar_cell.library, axes=axes, points=points, slides=SLIDES, at_zero=at_zero, rates=rates)
    for sample, (q, dq, ddq) in enumerate(rates.transpose(1, 0, 2)):
        before, here, after = (place(axes, points, at_zero, q + t * dq + t**2 / 2 * ddq) for t in (-STEP, 0, STEP))
        assert found[0][sample] == pytest.approx((after - before) / (2 * STEP), abs=1e-6)
        assert found[1][sample] == pytest.approx((after - 2 * here + before) / STEP**2, abs=1e-5)
