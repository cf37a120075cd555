# SPDX-License-Identifier: MIT
"""Mass properties of the links of a URDF: what a body can have, what is let pass with a remark, what is refused."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from mrts.base.arrays import Array
from mrts.base.errors import NEAREST_INERTIA, InputError, Remark
from mrts.base.formats.urdf import Link
from mrts.base.rigid_transform import RigidTransform, multiply
from mrts.cell.cell_file import INERTIA_TOLERANCE, inertia_problem, triangle_excess

TRIANGLE_MARGIN = 0.2
"""Share by which a link's largest principal moment may exceed the sum of the others. Rounding of a file stays below
2 %, but robots in wide use are farther off (the xArm 6 that pybullet ships by 15.6 %), and their users cannot mend
them; the equations stay sound as long as the inertia is positive definite. Beyond this a digit is probably wrong."""

POINT_RADIUS = 1e-7
"""Radius of gyration below which a body is a point mass [m]: exporters leave rounding of zero behind."""


@dataclass(frozen=True)
class Inertia:
    """Mass properties of a rigid body in some frame.

    Attributes:
        mass: [kg].
        com: Centre of mass, Shape (3,) [m].
        at_com: Rotational inertia about the com, axes of the frame, Shape (3, 3) [kg m²].
    """

    mass: float
    com: Array
    at_com: Array

    @staticmethod
    def zero() -> "Inertia":
        """No body at all."""
        return Inertia(0.0, np.zeros(3), np.zeros((3, 3)))

    def seen_from(self, T: RigidTransform) -> "Inertia":
        """The same body in frame a, where `T` is the pose of its frame in a."""
        return Inertia(self.mass, T.p + multiply(T.R, self.com), multiply(multiply(T.R, self.at_com), T.R.T))

    def __add__(self, other: "Inertia") -> "Inertia":
        mass = self.mass + other.mass
        if mass == 0:
            return self
        com = (self.mass * self.com + other.mass * other.com) / mass
        at_com = self.at_com + other.at_com
        for body in (self, other):
            d = body.com - com
            at_com = at_com + body.mass * (sum(d * d) * np.eye(3) - d[:, None] * d[None, :])
        return Inertia(mass, com, at_com)


def is_point(link: Link) -> bool:
    """Whether a link of a URDF has a mass but no extent: no moment of inertia of its own."""
    return link.mass > 0 and bool(np.max(np.abs(link.inertia)) <= link.mass * POINT_RADIUS**2)


def nearest_inertia(inertia: Array) -> Array:
    """The inertia of a body that is nearest to a symmetric matrix in the Frobenius norm, Shape (3, 3) [kg m²].

    A body's principal moments are sums of two each of its second moments along the principal axes, which are >= 0.
    """
    from scipy.optimize import nnls  # noqa: PLC0415 (slow to import, for URDFs that are wrong)

    moments, axes = np.linalg.eigh(inertia)
    sums = np.ones((3, 3)) - np.eye(3)
    second, _ = nnls(sums, moments)
    return multiply(axes * (sums @ second), axes.T)


def link_inertia(path: Path, link: Link, remarks: list[Remark], *, lenient: bool = False) -> Inertia:
    """Mass properties of a link in its own frame; without mass there is no body.

    What is let pass is added to `remarks`; `lenient` moves an inertia that no body has to the nearest that one has.
    """
    if link.mass < 0:
        raise InputError(path, "must be >= 0 kg.", key=f"link '{link.name}' mass", value=link.mass)
    if link.mass == 0:
        if np.any(link.inertia):
            text = f"{path.name}: link '{link.name}' has an inertia but no mass; it counts as a frame without a body."
            remarks.append(Remark("massless-inertia", text))
        return Inertia.zero()
    inertia = np.zeros((3, 3)) if is_point(link) else link.inertia
    if lenient and inertia_problem(inertia, rods=True) and np.any(inertia):
        inertia = nearest_inertia(inertia)
        given, taken = (
            ", ".join(f"{moment:.6g}" for moment in np.linalg.eigvalsh(of)) for of in (link.inertia, inertia)
        )
        text = (
            f"{path.name}: no body has the principal moments of link '{link.name}', {given} kg m²; the nearest "
            f"that one has are taken, {taken} kg m²."
        )
        remarks.append(Remark(NEAREST_INERTIA, text))
    elif np.any(inertia):
        _check_inertia(path, link, remarks)
    return Inertia(link.mass, np.zeros(3), inertia).seen_from(link.origin)


def _check_inertia(path: Path, link: Link, remarks: list[Remark]) -> None:
    problem = inertia_problem(link.inertia, triangle=TRIANGLE_MARGIN, rods=True)
    if problem:
        advice = (
            f"Correct it in the URDF; a moment {100 * TRIANGLE_MARGIN:g} % beyond the sum of the others passes. Or "
            "give 'inertia: lenient' in the cell file: then it is moved to the nearest that a body has."
        )
        raise InputError(path, f"{problem} {advice}", key=f"link '{link.name}' inertia")
    excess = triangle_excess(link.inertia)
    if excess > INERTIA_TOLERANCE:
        text = (
            f"{path.name}: the largest principal moment of link '{link.name}' exceeds the sum of the others by "
            f"{100 * excess:.2g} %, which no body's does; it is taken as it is."
        )
        remarks.append(Remark("inertia-triangle", text))
