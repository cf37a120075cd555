# SPDX-License-Identifier: MIT
"""The visual meshes of an arm from its URDF, each with the body that carries it."""

from collections import deque
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mrts.base.errors import InputError, MrtsError
from mrts.base.formats.package_uri import file_of_uri, is_uri
from mrts.base.regular_file import is_file

if TYPE_CHECKING:
    from trimesh import Trimesh


def arm_meshes(
    path: Path, base_link: str | None, joints: tuple[str, ...], held: Mapping[str, float] | None = None
) -> "list[tuple[int, Trimesh]]":
    """Body and mesh (base axes with every joint of the chain at zero [m]) of every visual of an arm.

    Body 0 stands with the base, body k is moved by the first k joints (`mrts.scene.cell_shapes.body_poses`).
    Other joints stand where they are held, else at zero; what they could still move and no joint of the chain carries,
    such as the other arm of a torso, is left out.

    Args:
        path: The URDF.
        base_link: First link of the chain; None takes the URDF's root.
        joints: Moving joints of the chain, base to tip.
        held: Positions of joints that are held still [rad or m].

    Raises:
        InputError: If the file or one of its meshes cannot be read.
    """
    from trimesh import Trimesh  # noqa: PLC0415 (half a second, for cells that have meshes to show)
    from yourdfpy import URDF  # noqa: PLC0415

    try:
        model = URDF.load(str(path), filename_handler=partial(mesh_file, path))
        still = {name: value for name, value in (held or {}).items() if name in model.actuated_joint_names}
        model.update_cfg(still)  # what mimics them follows
        body = _bodies(model.robot.joints, base_link or model.base_link, joints, held or {})
        graph, found = model.scene.graph, []
        for node in graph.nodes_geometry:
            link = graph.transforms.parents[node]
            pose, name = graph.get(node, base_link or model.base_link)
            shape = model.scene.geometry[name]
            if link in body and isinstance(shape, Trimesh) and len(shape.faces):
                found.append((body[link], shape.copy().apply_transform(pose)))
    except MrtsError:
        raise
    except Exception as error:  # noqa: BLE001 (the readers of a dozen formats raise what they like)
        raise InputError(path, f"its meshes cannot be read ({type(error).__name__}: {error}).") from None
    return found


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

    Args:
        urdf: The file that names it.
        fname: How.

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
