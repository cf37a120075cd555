"""Products and medians of arrays: the numbers of numpy."""

import numpy as np
import pytest

from mrts.base.arrays import apply, cross, median, rotated, row_products

ROUNDING = 1e-14
"""Of sums of a few numbers near 1, taken in another order."""


@pytest.mark.quick
def test_they_are_numpys():
    rng = np.random.default_rng(0)
    for count in (1, 2, 3, 50):
        first, second = rng.normal(size=(2, count, 3))
        R = rng.normal(size=(count, 3, 3))
        np.testing.assert_array_equal(cross(first, second[0]), np.cross(first, second[0]))
        np.testing.assert_allclose(row_products(first, second), np.sum(first * second, axis=1), atol=ROUNDING)
        np.testing.assert_allclose(apply(R, first), (R @ first[:, :, None])[:, :, 0], atol=ROUNDING)
        np.testing.assert_allclose(rotated(R, second[0]), R @ second[0], atol=ROUNDING)
        assert median(first[:, 0]) == np.median(first[:, 0])
