"""Two gantries that slow an object down in a straight line, where rotor inertia helps against their friction."""

from dataclasses import dataclass

import numpy as np
from gantries import gantries, straight
from random_motors import equipped

GANTRY_MASS, OBJECT_MASS, FORCE = 4.0, 3.0, 20.0


@dataclass(frozen=True)
class Slowing:
    """A motion from one speed to another along x; `inertia` and `friction` of the motors that push."""

    inertia: float = 100.0
    friction: float = 120.0
    first: float = 1.0
    last: float = 0.9
    slowing: float = 1.0

    def cell(self, folder, **changes):
        """The cell."""
        folder.mkdir(exist_ok=True)
        return equipped(gantries(folder, **changes), armature=[self.inertia, 0, 0], viscous=[self.friction, 0, 0])

    def motion(self, samples=11):
        """Of the object."""
        t = np.linspace(0, (self.first - self.last) / self.slowing, samples)
        return straight(t, self.first * t - self.slowing * t**2 / 2, self.first - self.slowing * t, -self.slowing)

    def intervals(self, mass=OBJECT_MASS):
        """Of c²: -FORCE <= b v c - M a c² <= FORCE at the first and the last speed; each arm moves half the object."""
        M = (GANTRY_MASS + mass / 2 + self.inertia) * self.slowing

        def roots(speed, force):
            half = self.friction * speed / 2
            return (half - np.sqrt(half**2 - force * M)) / M, (half + np.sqrt(half**2 - force * M)) / M

        (slow, fast), (_, fastest) = roots(self.first, FORCE), roots(self.last, -FORCE)
        return [(0.0, slow**2), (fast**2, fastest**2)]
