# SPDX-License-Identifier: MIT
"""`mrts new`."""

import re
import shlex
from pathlib import Path
from typing import TYPE_CHECKING, Any

from click import argument, option

from mrts.base.errors import InputError, MotionError
from mrts.commands import options
from mrts.commands.console import FEASIBLE, INFEASIBLE, say, warn, working
from mrts.commands.options import Written

if TYPE_CHECKING:
    from collections.abc import Callable

    from mrts.base.arrays import Array
    from mrts.base.rigid_transform import RigidTransform
    from mrts.starting.arm import Arm
    from mrts.starting.proposal import Proposal
    from mrts.starting.request import Request


def _vector(where: str, *counts: int) -> "Callable[[str], Array]":
    rule = f"must be {' or '.join(map(str, counts))} numbers with commas between them, such as 0.5,0,-1."
    return options.listed(where, rule, options.array, counts=counts)


@options.command
@argument("folder", type=Written(folder=True), metavar="DIR", help="folder for cell.yaml and motion.yaml")
@option("--robot", "robots", multiple=True, required=True, metavar="URDF",
        help="once for each robot; a single arm stands twice, a machine with two arms once")  # fmt: skip
@option("--tip", "tips", multiple=True, metavar="LINK",
        help="link that holds the object, once for each robot, or several of a single one (default: found by "
        "name)")  # fmt: skip
@option("--base", "bases", multiple=True, type=_vector("bases", 3, 6), metavar="X,Y,Z[,R,P,Y]",
        help="root of the URDF in the world, once for each robot; m, rad (default: proposed)")  # fmt: skip
@option("--mass", type=float, metavar="KG", help="of the object (default: what the arms hold easily)")
@option("--gravity", type=_vector("gravity", 3), metavar="X,Y,Z", help="in the world (default: 0,0,-9.81)")
@option("--force", is_flag=True, help="overwrite files")
def run(folder: Path, bases: "tuple[Array, ...]" = (), *, force: bool = False, **given: Any) -> int:
    """Begin a cell from URDFs alone: hands, bases, a motion that can be played.

    Examples:
        mrts new pair --robot arm.urdf                  two of a kind
        mrts new lift --robot left.urdf --robot right.urdf --tip tool0 --tip tool0 --mass 5
    """
    from mrts.base.atomic_file import text_writer, write_together
    from mrts.cell.remarks import urdf_remarks
    from mrts.starting.proposal import cell_file, motion_file, propose
    from mrts.starting.request import request_of

    cell, motion = folder / "cell.yaml", folder / "motion.yaml"
    for path in (cell, motion):
        if path.exists() and not force:
            raise InputError(path, "is there already; --force overwrites it, another DIR leaves it.")
    request = request_of(folder, name=_name(folder), bases=[_base(base) for base in bases], **given)
    _tell_arms(request)
    with working("trying layouts (the first time, compiling)") as progress:
        try:
            proposal = propose(request, progress)
        except MotionError as error:
            say(f"{folder}: nothing written: {error}", "bad")
            for remark in (one for arm in request.arms for one in urdf_remarks(arm.robot)):
                say(str(remark), "note")
            return INFEASIBLE
    write_together({cell: text_writer(cell_file(proposal)), motion: text_writer(motion_file(proposal))})
    _tell_proposal(cell, motion, proposal)
    return FEASIBLE


def _base(numbers: "Array") -> "RigidTransform":
    from mrts.base.rigid_transform import RigidTransform

    x, y, z, *rpy = numbers.tolist()
    return RigidTransform.from_xyz_rpy([x, y, z], rpy or [0.0, 0.0, 0.0])


def _name(folder: Path) -> str:
    """The name of the cell: letters, digits and single underscores, as generated C has it."""
    from mrts.base.input_file import IDENTIFIER, LONGEST_NAME

    words = re.findall(r"[A-Za-z0-9]+", folder.absolute().name)
    name = "_".join(words)[:LONGEST_NAME].rstrip("_")
    return name if re.fullmatch(IDENTIFIER, name) else "cell"


def _tell_arms(request: "Request") -> None:
    from mrts.cell.remarks import joint_assumptions
    from mrts.starting.check import joint_table

    alike: dict[tuple[str, str], list[Arm]] = {}
    for arm in request.arms:  # two of a kind are told under the name of the first
        alike.setdefault((arm.urdf, arm.robot.source.tip_link), []).append(arm)
    for (urdf, tip), arms in alike.items():
        chain = arms[0].robot
        names = " and ".join(arm.robot.name for arm in arms)
        say(f"{names}: {urdf}, {chain.source.base_link} to {tip}", "strong")
        for line in joint_table([chain]):
            say(line)
        if beyond := arms[0].beyond:
            text = f"{', '.join(beyond)} beyond {tip} may reach into the object, and no collision with it is seen"
            say(f"  {text}: if they hold it, name the link between them, --tip LINK", "note")
        for remark in joint_assumptions([chain]):
            say(f"  {remark.text}", "note")
    say("")


def _tell_proposal(cell: Path, motion: Path, proposal: "Proposal") -> None:
    lift = max(abs(proposal.layout.lift))
    asked = proposal.request.mass
    if asked is not None and proposal.mass < asked:
        warn(f"{asked:g} kg are more than the motors can lift: {cell} has {proposal.mass:g} kg")
    say(f"{cell}: {len(proposal.request.arms)} arms hold {proposal.mass:g} kg", "strong")
    say(f"{motion}: up by {lift:g} m in {proposal.motion['duration']:g} s", "strong")
    say(proposal.result.sentence())
    for remark in proposal.result.warnings:
        say(str(remark), "note")
    for remark in proposal.collisions:
        if remark.severity == "hint":  # no layout that was tried keeps everything apart
            warn(remark.text)
        else:
            say(remark.text, "note")
    say("\nLook at it, ask how fast it may be played, then put your own numbers in:")
    files = f"{shlex.quote(str(cell))} {shlex.quote(str(motion))}"
    say(f"  mrts view {files}")
    say(f"  mrts scale {files}")
