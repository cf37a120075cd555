# SPDX-License-Identifier: MIT
"""Links and joints of a URDF as values, read from elements that `mrts_codegen.urdf.urdf_file` has checked."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from mrts.base.arrays import Array
from mrts.base.rigid_transform import RigidTransform, rotation_from_rpy, snap_rotation

INERTIA_KEYS = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
"""Attributes of <inertia>."""


@dataclass(frozen=True)
class Inertial:
    """Mass [kg], inertia about the com in the axes of the origin, Shape (3, 3) [kg m²], and its place in the link."""

    mass: float
    inertia: Array
    origin: RigidTransform


@dataclass(frozen=True)
class Link:
    """A link; inertial is None where it says nothing of mass."""

    name: str
    inertial: Inertial | None


@dataclass(frozen=True)
class Limit:
    """What <limit> gives, None where it says nothing."""

    effort: float | None
    velocity: float | None
    lower: float | None
    upper: float | None


@dataclass(frozen=True)
class Mimic:
    """That a joint stands at multiplier times the position of another, plus offset."""

    joint: str
    multiplier: float
    offset: float


@dataclass(frozen=True)
class Dynamics:
    """Dry friction [N m or N] and damping [N m s/rad or N s/m], 0 where the URDF says nothing."""

    friction: float
    damping: float


@dataclass(frozen=True, kw_only=True)
class UrdfJoint:
    """A joint; limit, mimic and dynamics are None where they are not there.

    Attributes:
        name: Its own.
        type: Of `JOINT_TYPES`.
        parent: Link that it hangs from.
        child: Link that hangs from it.
        origin: Frame of the child in the parent, at position zero.
        axis: As given, of any length, Shape (3,).
        limit: Of its motion.
        mimic: What it follows.
        dynamics: Of its motor.
    """

    name: str
    type: str
    parent: str
    child: str
    origin: RigidTransform
    axis: Array
    limit: Limit | None
    mimic: Mimic | None
    dynamics: Dynamics | None


@dataclass(frozen=True)
class Urdf:
    """All links and joints, in the order of the file."""

    links: tuple[Link, ...]
    joints: tuple[UrdfJoint, ...]


def link_of(name: str, inertial: Any | None) -> Link:
    """A link of its <inertial> element, which is None or complete."""
    if inertial is None:
        return Link(name, None)
    xx, xy, xz, yy, yz, zz = (float(inertial.find("inertia").get(key)) for key in INERTIA_KEYS)
    inertia = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    return Link(name, Inertial(float(inertial.find("mass").get("value")), inertia, _origin(inertial)))


def joint_of(joint: Any) -> UrdfJoint:
    """A joint of its element."""
    axis, limit, mimic, dynamics = (joint.find(tag) for tag in ("axis", "limit", "mimic", "dynamics"))
    return UrdfJoint(
        name=joint.get("name"),
        type=joint.get("type"),
        parent=joint.find("parent").get("link"),
        child=joint.find("child").get("link"),
        origin=_origin(joint),
        axis=_vector(None if axis is None else axis.get("xyz"), (1.0, 0.0, 0.0)),
        limit=None if limit is None else Limit(*(_number(limit, key) for key in Limit.__annotations__)),
        mimic=None
        if mimic is None
        else Mimic(mimic.get("joint"), float(mimic.get("multiplier", 1)), float(mimic.get("offset", 0))),
        dynamics=None
        if dynamics is None
        else Dynamics(*(float(dynamics.get(key, 0)) for key in Dynamics.__annotations__)),
    )


def _origin(element: Any) -> RigidTransform:
    origin = element.find("origin")
    if origin is None:
        return RigidTransform.identity()
    p, rpy = (_vector(origin.get(key), (0.0, 0.0, 0.0)) for key in ("xyz", "rpy"))
    return RigidTransform(snap_rotation(rotation_from_rpy(*rpy.tolist())), p)


def _vector(text: str | None, default: tuple[float, ...]) -> Array:
    return np.array(default if text is None else [float(word) for word in text.split()])


def _number(element: Any, key: str) -> float | None:
    text = element.get(key)
    return None if text is None else float(text)
