# SPDX-License-Identifier: MIT
"""Bodies of an arm, which its joints move against each other: where they are, and the links of the URDF in each."""

import logging
from collections import deque
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from mrts.base.arrays import Array
from mrts.base.errors import InputError, MrtsError
from mrts.base.input_file import file_of_uri, is_uri
from mrts.base.regular_file import is_file
from mrts.base.rigid_transform import RigidTransform, rotations_from_vectors
from mrts.cell.robot import Robot


def body_poses(robot: Robot, q: Array) -> tuple[Array, Array]:
    """What takes each body of the arm from where it is in base axes with every joint at zero to the world.

    Body 0 is the base, body k is moved by the first k joints. Of joint positions, Shape (N, n_i), these are R, Shape
    (N, n_i + 1, 3, 3), and p, Shape (N, n_i + 1, 3) [m].
    """
    R = np.broadcast_to(robot.T_world_base.R, (len(q), 3, 3))
    p = np.broadcast_to(robot.T_world_base.p, (len(q), 3))
    rotations, positions = [R], [p]
    for index, (kind, axis, point) in enumerate(zip(robot.joint_types, robot.axes, robot.points, strict=True)):
        if kind == "prismatic":
            p = p + R @ axis * q[:, index, None]
        else:
            center = p + R @ point
            R = R @ rotations_from_vectors(q[:, index, None] * axis)
            p = center - R @ point
        rotations.append(R)
        positions.append(p)
    return np.stack(rotations, axis=1), np.stack(positions, axis=1)


def tip_at_posture(robot: Robot) -> RigidTransform:
    """The tip in the world, with the arm at its posture."""
    R, p = body_poses(robot, robot.posture[None])
    return RigidTransform(R[0, -1], p[0, -1]) @ robot.T_base_tip


@contextmanager
def reading_meshes(path: Path) -> Iterator[None]:
    """Tell what goes wrong with the meshes of a URDF.

    Raises:
        InputError: Whatever their readers raise.
    """
    try:
        yield
    except MrtsError:
        raise
    except Exception as error:  # noqa: BLE001 (the readers of a dozen formats raise what they like)
        raise InputError(path, f"its meshes cannot be read ({type(error).__name__}: {error}).") from None


def posed_urdf(
    path: Path, base_link: str | None, joints: tuple[str, ...], held: Mapping[str, float], *, visuals: bool = True
) -> tuple[Any, dict[str, int], str]:
    """A URDF as yourdfpy has it, every joint of the chain at zero and others where they are held; see `reading_meshes`.

    With it come the body of each link that stands with the base (None is the URDF's root) or hangs from the chain, and
    the base link. Meshes of visuals are read where they are wanted.
    """
    from yourdfpy import URDF  # noqa: PLC0415 (half a second, for cells that have meshes)

    logging.getLogger("yourdfpy").setLevel(logging.CRITICAL)  # it tells of namespaces that it gets over
    model = URDF.load(str(path), filename_handler=partial(mesh_file, path), load_meshes=visuals)
    still = {name: value for name, value in held.items() if name in model.actuated_joint_names}
    model.update_cfg(still)  # what mimics them follows
    base = base_link or model.base_link
    return model, _bodies(model.robot.joints, base, joints, held), base


def _bodies(joints: list[Any], base_link: str, chain: tuple[str, ...], held: Mapping[str, float]) -> dict[str, int]:
    """The body that each link belongs to, for the links that stand with the base or hang from the chain."""
    body, pending = {base_link: 0}, deque([base_link])
    while pending:
        link = pending.popleft()
        for joint in joints:
            stands = joint.type == "fixed" or joint.name in held
            if joint.parent == link:
                other, moved = joint.child, not stands
            elif joint.child == link and stands:
                other, moved = joint.parent, False
            else:
                continue
            if other in body or (moved and joint.name not in chain and body[link] == 0):
                continue
            body[other] = chain.index(joint.name) + 1 if joint.name in chain else body[link]
            pending.append(other)
    return body


def mesh_file(urdf: Path, fname: str) -> str:
    """Path of a mesh: of a package, relative to the URDF, or in a package that stands there under another name.

    Raises:
        InputError: If it is not there.
    """
    inside = fname.removeprefix("file://")
    if is_uri(fname):
        inside = fname.partition("://")[2].partition("/")[2]
        try:
            return str(file_of_uri(urdf, fname, urdf))
        except InputError as error:
            for above in urdf.resolve().parents:
                if is_file(above / inside):
                    return str(above / inside)
            raise InputError(urdf, f"its mesh '{fname}' is not found: {error.rule}") from None
    file = urdf.resolve().parent / inside
    if is_file(file):
        return str(file)
    raise InputError(urdf, f"its mesh '{fname}' is not found.")
