# SPDX-License-Identifier: MIT
"""Velocity profiles: how the path fraction s runs from 0 to 1 over the normalised time u in [0, 1]."""

from collections.abc import Callable

import numpy as np

from mrts.base.arrays import Array

Profile = Callable[[Array], tuple[Array, Array, Array]]

RAMP = 1 / 3
"""Share of the duration that a trapezoid accelerates, and that it brakes."""

CORNER_TOLERANCE = 1e-9
"""Share of the duration by which rounding may miss a corner: far above that of any u, far below a step of any table."""


def sinusoid(u: Array) -> tuple[Array, Array, Array]:
    """Velocity ∝ sin(π u) (the paper's section VI); s, ds/du, d²s/du², each Shape (N,)."""
    return (1 - np.cos(np.pi * u)) / 2, np.pi / 2 * np.sin(np.pi * u), np.pi**2 / 2 * np.cos(np.pi * u)


def trapezoid(u: Array) -> tuple[Array, Array, Array]:
    """Constant acceleration, speed, deceleration, a third of the time each; s, ds/du, d²s/du², each Shape (N,).

    At the two corners, where the acceleration jumps, the value of the ramp is taken.
    """
    top = 1 / (1 - RAMP)
    rising, falling = u <= RAMP + CORNER_TOLERANCE, u >= 1 - RAMP - CORNER_TOLERANCE
    s = np.where(
        rising,
        top * u**2 / (2 * RAMP),
        np.where(falling, 1 - top * (1 - u) ** 2 / (2 * RAMP), top * (u - RAMP / 2)),
    )
    ds = np.where(rising, top * u / RAMP, np.where(falling, top * (1 - u) / RAMP, top))
    dds = np.where(rising, top / RAMP, np.where(falling, -top / RAMP, 0.0))
    return s, ds, dds


def cubic(u: Array) -> tuple[Array, Array, Array]:
    """3u² - 2u³: at rest at both ends; s, ds/du, d²s/du², each Shape (N,)."""
    return u**2 * (3 - 2 * u), 6 * u * (1 - u), 6 - 12 * u


def quintic(u: Array) -> tuple[Array, Array, Array]:
    """10u³ - 15u⁴ + 6u⁵: at rest without acceleration at both ends; s, ds/du, d²s/du², each Shape (N,)."""
    return (
        u**3 * (10 + u * (6 * u - 15)),
        30 * u**2 * (1 - u) ** 2,
        60 * u * (1 - u) * (1 - 2 * u),
    )


PROFILES: dict[str, Profile] = {
    "sinusoid": sinusoid,
    "trapezoid": trapezoid,
    "cubic": cubic,
    "quintic": quintic,
}
"""The names that a motion file may use."""

CORNERS: dict[Profile, tuple[float, ...]] = {trapezoid: (RAMP, 1 - RAMP)}
"""Where the acceleration of a profile jumps, if it does."""
