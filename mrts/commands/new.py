# SPDX-License-Identifier: MIT
"""`mrts new`."""

import re
import shlex
import shutil
from pathlib import Path
from typing import TYPE_CHECKING, Any

from click import argument, get_current_context, option

from mrts.base.errors import InputError, MotionError
from mrts.commands import options
from mrts.commands.console.exit_codes import FEASIBLE, INFEASIBLE
from mrts.commands.console.progress import working
from mrts.commands.console.terminal import say, warn
from mrts.commands.options import Named, Written

if TYPE_CHECKING:
    from collections.abc import Callable

    from mrts.base.arrays import Array
    from mrts.base.rigid_transform import RigidTransform
    from mrts.starting.proposal import Proposal
    from mrts.starting.request import ArmRequest, Request

EXAMPLES = """\
examples:
  mrts new pair --robot arm.urdf                  two of a kind
  mrts new lift --robot left.urdf --robot right.urdf --tip tool0 --tip tool0 --mass 5
  mrts new held --robot arm.urdf --degrees --posture 6,-75,109,-40,11,17 --posture -23,-69,103,-29,-11,57
  mrts new --hold cell.yaml motion.yaml           grasps from the postures of a cell that is there"""


def _vector(where: str, *counts: int) -> "Callable[[str], Array]":
    rule = f"must be {' or '.join(map(str, counts)) or 'some'} numbers with commas between them, such as 0.5,0,-1."
    return options.listed(where, rule, options.array, counts=counts or options.ANY_COUNT)


@options.command(EXAMPLES)
@argument("folder", type=Written(folder=True), required=False, metavar="[DIR]",
          help="folder for cell.yaml and motion.yaml")  # fmt: skip
@option("--robot", "robots", multiple=True, metavar="URDF",
        help="once for each robot; a single arm stands twice, a machine with two arms once")  # fmt: skip
@options.xacro_arg
@option("--tip", "tips", multiple=True, metavar="LINK",
        help="link that holds the object, once for each robot, or several of a single one (default: found by "
        "name)")  # fmt: skip
@option("--base", "bases", multiple=True, type=_vector("bases", 3, 6), metavar="X,Y,Z[,R,P,Y]",
        help="root of the URDF in the world, once for each robot; m, rad (default: proposed)")  # fmt: skip
@option("--posture", "postures", multiple=True, type=_vector("postures"), metavar="Q,Q,…",
        help="where the arm holds the object, once for each arm; rad, m (default: searched)")  # fmt: skip
@option("--degrees", is_flag=True, help="angles of --base and --posture are degrees")
@option("--mass", type=float, metavar="KG", help="of the object (default: what the arms hold easily)")
@option(
    "--gravity",
    type=_vector("gravity", 3),
    metavar="X,Y,Z",
    help="in the world (default: 0,0,-9.81)",
)
@option("--name", help="of the cell (default: that of the folder)")
@option("--copy", is_flag=True, help="copy the URDFs into the folder (not their meshes)")
@option("--force", is_flag=True, help="overwrite files; with --hold, write the grasps into CELL")
@option("--hold", nargs=2, type=Named(), metavar="CELL MOTION",
        help="the grasps with which the hands hold the object where the motion starts, as the postures of the cell put "
        "them: 'hold it here, now'")  # fmt: skip
def run(
    folder: Path | None = None,
    hold: tuple[Path, Path] | None = None,
    name: str | None = None,
    bases: "tuple[Array, ...]" = (),
    xacro_arg: tuple[str, ...] = (),
    *,
    copy: bool = False,
    force: bool = False,
    **given: Any,
) -> int:
    """Begin a cell from URDFs alone: hands, bases, a motion that can be played; or compute the grasps of a cell."""
    from mrts.starting.reading import request_of

    if hold is not None:
        for other in get_current_context().params.keys() - {"hold", "force"}:
            raise InputError(other, "does not go with --hold, which takes a cell that is there, and its motion.")
        return _hold(*hold, force=force)
    if folder is None:
        raise InputError("folder", "is missing: the folder for cell.yaml and motion.yaml.")
    if "robots" not in given:
        raise InputError("robots", "is missing: the URDF of a robot, once for each.")
    for path in (folder / "cell.yaml", folder / "motion.yaml"):
        if path.exists() and not force:
            raise InputError(path, "is there already; --force overwrites it, another DIR leaves it.")
    request = request_of(
        folder,
        name=_name(name, folder),
        bases=[_base(base, degrees=given.get("degrees", False)) for base in bases],
        xacro_args=options.xacro_arguments(xacro_arg),
        **given,
    )
    return _begin(folder, request, copy=copy, force=force)


def _base(numbers: "Array", *, degrees: bool) -> "RigidTransform":
    import numpy as np

    from mrts.base.rigid_transform import RigidTransform

    rpy = numbers[3:] if numbers.size > 3 else np.zeros(3)  # noqa: PLR2004 (x, y, z)
    return RigidTransform.from_xyz_rpy(numbers[:3].tolist(), (np.radians(rpy) if degrees else rpy).tolist())


def _begin(folder: Path, request: "Request", *, copy: bool, force: bool) -> int:
    from mrts.cell.remarks import urdf_remarks
    from mrts.starting.proposal import propose, renamed

    copies = _copies(request, folder, force=force) if copy else {}
    _tell_arms(request)
    with working("trying layouts (the first time, compiling)") as progress:
        try:
            proposal = propose(request, progress)
        except MotionError as error:
            say(f"{folder}: nothing written: {error}", "bad")
            for remark in (one for each in request.arms for one in urdf_remarks(each.arm.robot)):
                say(str(remark), "note")
            return INFEASIBLE
    if copies:
        proposal = renamed(proposal, [copies[each.path] for each in request.arms])
    _write(folder, proposal, copies)
    _tell_proposal(folder, proposal)
    return FEASIBLE


def _name(given: str | None, folder: Path) -> str:
    """The name of the cell: letters, digits and single underscores, as generated C has it."""
    from mrts.base.input_file import IDENTIFIER, LONGEST_NAME

    if given is not None:
        if not re.fullmatch(IDENTIFIER, given) or len(given) > LONGEST_NAME:
            rule = f"must be letters, digits and single underscores, at most {LONGEST_NAME}, beginning with a letter."
            raise InputError("name", rule, value=given)
        return given
    words = re.findall(r"[A-Za-z0-9]+", folder.absolute().name)
    name = "_".join(words)[:LONGEST_NAME].rstrip("_")
    return name if re.fullmatch(IDENTIFIER, name) else "cell"


def _tell_arms(request: "Request") -> None:
    from mrts.cell.remarks import joint_assumptions
    from mrts.starting.cell_check import joint_table

    chains: dict[int, ArmRequest] = {}
    for each in request.arms:  # two of a kind have one chain, told under the name of the first
        chains.setdefault(id(each.arm.robot.source), each)
    for each in chains.values():
        chain = each.arm.robot
        proposed = f" (proposed: {each.why})" if each.why else ""
        names = " and ".join(other.arm.robot.name for other in request.arms if other.arm.robot.source is chain.source)
        say(f"{names}: {each.urdf}, {chain.source.base_link} to {chain.source.tip_link}{proposed}", "strong")
        for line in joint_table([chain]):
            say(line)
        for remark in joint_assumptions([chain]):
            say(f"  {remark.text}", "note")
    say("")


def _copies(request: "Request", folder: Path, *, force: bool) -> dict[Path, str]:
    from mrts.base.formats.package_uri import is_xacro

    names: dict[Path, str] = {}
    for each in request.arms:
        if is_xacro(each.path):
            raise InputError("copy", "does not go with a xacro, which includes other files.", value=each.urdf)
        if each.path not in names:
            taken = {"cell.yaml", "motion.yaml", *names.values()}
            stem, suffix = each.path.stem, each.path.suffix
            choices = (f"{stem}{number}{suffix}" for number in ("", *range(2, len(request.arms) + 2)))
            names[each.path] = next(name for name in choices if name not in taken)
    for name in names.values():
        if (folder / name).exists() and not force:
            raise InputError(folder / name, "is there already; --force overwrites it.")
    return names


def _write(folder: Path, proposal: "Proposal", copies: dict[Path, str]) -> None:
    from mrts.base.atomic_file import Write, text_writer, write_together
    from mrts.starting.cell_writing import cell_file, motion_file

    files: dict[Path, Write] = {}
    for path, name in copies.items():
        files[folder / name] = lambda copy, path=path: shutil.copyfile(path, copy)  # type: ignore[misc]  # its own path
    files[folder / "cell.yaml"] = text_writer(cell_file(proposal))
    files[folder / "motion.yaml"] = text_writer(motion_file(proposal))
    write_together(files)


def _tell_proposal(folder: Path, proposal: "Proposal") -> None:
    lift = max(abs(proposal.layout.lift))
    asked = proposal.request.mass
    cell, motion = folder / "cell.yaml", folder / "motion.yaml"
    if asked is not None and proposal.mass < asked:
        warn(f"{asked:g} kg are more than the motors can lift: {cell} has {proposal.mass:g} kg")
    if proposal.request.plane == "xy" and not any(proposal.request.gravity[:2]):
        warn("gravity is normal to the plane and loads no joint; for an upright plane: --gravity=0,-9.81,0")
    say(f"{cell}: {len(proposal.request.arms)} arms hold {proposal.mass:g} kg", "strong")
    say(f"{motion}: up by {lift:g} m in {proposal.motion['duration']:g} s", "strong")
    say(proposal.result.sentence())
    for remark in proposal.result.warnings:
        say(str(remark), "note")
    for remark in proposal.collisions:
        say(remark.text, "note")
    say("\nLook at it, ask how fast it may be played, then put your own numbers in:")
    files = f"{shlex.quote(str(cell))} {shlex.quote(str(motion))}"
    say(f"  mrts view {files}")
    say(f"  mrts scale {files}")


def _hold(cell_path: Path, motion_path: Path, *, force: bool) -> int:
    from mrts.base.atomic_file import write_text_atomically
    from mrts.base.edited_yaml import flow
    from mrts.base.input_file import text_of
    from mrts.base.regular_file import is_folder, read_regular
    from mrts.base.rigid_transform import rpy_from_rotation
    from mrts.base.yaml_parser import MAX_YAML_BYTES
    from mrts.motion.motion_file import load_motion
    from mrts.motion.object_motion import ObjectMotion
    from mrts.starting.hold import hold_here, with_grasps
    from mrts.starting.proposal import short_pose

    motion = load_motion(motion_path)
    if not isinstance(motion, ObjectMotion):
        raise InputError(motion_path, "moves joints: only a motion of the object says where it starts.")
    if is_folder(cell_path):
        raise InputError(cell_path, "is a folder; --hold takes a cell file.")
    content = read_regular(cell_path, "cell file", MAX_YAML_BYTES)
    text = text_of(cell_path, "cell file", content)
    cell = hold_here(options.compiled_cell(cell_path), motion.position[0], rpy_from_rotation(motion.rotation[0]))
    grasps = {robot.name: short_pose(robot.T_object_tip) for robot in cell.robots}
    if force:
        held = with_grasps(cell_path, text, grasps)
        write_text_atomically(cell_path, held.replace("\n", "\r\n") if b"\r\n" in content else held)
    for name, grasp in grasps.items():
        say(f"{name}:", "strong")
        say(f"    grasp: {flow(grasp)}")
    say(f"written into {cell_path}" if force else f"--force writes them into {cell_path}")
    return FEASIBLE
