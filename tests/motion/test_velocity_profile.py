"""Velocity profiles against their defining integrals, and a trapezoid's corners however their u is rounded."""

import numpy as np
import pytest
from scipy.integrate import quad

from mrts.motion.velocity_profile import CORNERS, PROFILES, trapezoid

pytestmark = pytest.mark.quick

INTEGRATION = 1e-9  # of scipy's adaptive quadrature
TOP_ACCELERATION = 4.5  # 1 / (ramp (1 - ramp)) with a ramp of a third


@pytest.mark.parametrize("name", PROFILES)
def test_a_profile_is_the_integral_of_its_derivatives_from_rest_to_rest(name):
    profile = PROFILES[name]
    u = np.linspace(0.0, 1.0, 31)
    s, ds, _ = profile(u)
    assert s[0] == 0
    np.testing.assert_allclose([s[-1], ds[0], ds[-1]], [1, 0, 0], atol=INTEGRATION)
    for order, values in ((1, s), (2, ds)):
        for end, value in zip(u, values, strict=True):
            corners = [corner for corner in (1 / 3, 2 / 3) if corner < end]
            area, _ = quad(
                lambda at, order=order: float(profile(np.array([at]))[order][0]), 0, end, points=corners or None
            )
            assert abs(area - value) < INTEGRATION


@pytest.mark.parametrize("name", PROFILES)
def test_corners_are_where_the_acceleration_jumps(name):
    u = np.linspace(0.0, 1.0, 1001)  # its steps are far below a jump, and no corner is among these
    steps = np.flatnonzero(np.abs(np.diff(PROFILES[name](u)[2])) > 1)
    corners = np.array(CORNERS.get(PROFILES[name], ()))
    np.testing.assert_array_equal(steps, np.searchsorted(u, corners) - 1)


def test_samples_at_a_trapezoids_corners_take_the_ramps_acceleration():
    for samples in range(4, 602, 3):
        for u in (np.linspace(0, 1, samples), np.arange(samples) / (samples - 1)):
            third = (samples - 1) // 3
            acceleration = trapezoid(u)[2]
            assert acceleration[third] == TOP_ACCELERATION, samples
            assert acceleration[2 * third] == -TOP_ACCELERATION, samples
            assert np.count_nonzero(acceleration == 0) == third - 1, samples
