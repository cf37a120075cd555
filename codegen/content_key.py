# SPDX-License-Identifier: MIT
"""What a generated cell depends on, without the symbolic layer: looking into the cache must cost next to nothing."""

import hashlib
import json
from functools import cache
from importlib.metadata import version
from pathlib import Path

from mrts_codegen.cell_file import read_cell_description, resolve_urdf
from mrts_codegen.cell_model import CellModel

from mrts.base import input_file, load_box, manifest, rigid_transform, yaml_parser
from mrts.base.input_file import MAX_URDF_BYTES
from mrts.base.regular_file import read_regular
from mrts.base.version import __version__
from mrts.hands import contact
from mrts.motors import joint_motors


def content_key(path: Path) -> str:
    """Hash of all that a generated cell depends on: cell file, URDFs, this package and CasADi's version.

    Raises:
        InputError: If the cell file breaks a rule or a URDF is missing.
    """
    description = read_cell_description(path)
    parts = [json.dumps(description.model_dump(), sort_keys=True), emitter_key()]
    digest = hashlib.sha256("\n".join(parts).encode())
    for robot in description.robots:
        digest.update(read_regular(resolve_urdf(path, path.resolve().parent, robot.urdf), "URDF", MAX_URDF_BYTES))
    return digest.hexdigest()


def chains_key(cell: CellModel, stem: str, *, bake: bool) -> str:
    """Hash of what functions are generated of: the chains, not the numbers of a cell file.

    Args:
        cell: The cell.
        stem: First part of their names.
        bake: Whether its geometry is folded in.
    """
    parts: list[object] = [stem, bake, cell.description.plane]
    for robot in cell.robots:
        model = robot.model
        for joint in model.joints:
            by_held = (joint.placed_by_held, joint.laden_by_held)
            parts += [joint.kind, joint.axis.tolist(), *by_held, joint.body.mass]
            if bake or not joint.placed_by_held:
                parts.append(joint.placement.numbers.tolist())
            if bake or not joint.laden_by_held:
                parts += [joint.body.com.tolist(), joint.body.at_com.tolist()]
        parts += [model.tip_by_held, *([] if model.tip_by_held and not bake else [model.tip.numbers.tolist()])]
        if bake:
            parts += [robot.T_world_base.numbers.tolist(), robot.T_object_tip.numbers.tolist()]
    if bake:
        parts.append(cell.description.gravity)
    return hashlib.sha256(json.dumps(parts).encode()).hexdigest()


@cache
def emitter_key() -> str:
    """Hash of what reads cells and emits functions: this package and CasADi's version."""
    shaping = (manifest, rigid_transform, input_file, yaml_parser, load_box)
    rooms = [source for of in (contact, joint_motors) for source in Path(of.__file__ or "").parent.glob("*.py")]
    ours = [source for source in Path(__file__).parent.rglob("*.py") if source.parent.name != "embedded"]
    digest = hashlib.sha256("\n".join([version("casadi"), __version__]).encode())
    for source in sorted([*ours, *rooms, *(Path(module.__file__ or "") for module in shaping)]):
        digest.update(source.read_bytes())
    return digest.hexdigest()
