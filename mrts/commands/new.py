# SPDX-License-Identifier: MIT
"""`mrts new`."""

import argparse
import shlex
import shutil
from pathlib import Path
from typing import TYPE_CHECKING

from mrts.base.errors import InputError, MotionError
from mrts.commands.options.common import add_xacro_arg, xacro_arguments
from mrts.console.exit_codes import FEASIBLE, INFEASIBLE
from mrts.console.output_files import check_outputs
from mrts.console.progress import working
from mrts.console.questions import ask, can_ask
from mrts.console.terminal import say, warn

if TYPE_CHECKING:
    from mrts.base.arrays import Array
    from mrts.base.formats.urdf_tree import UrdfTree
    from mrts.starting.proposal import Proposal
    from mrts.starting.reading import Given
    from mrts.starting.request import ArmRequest, Request
    from mrts.starting.tips import Hand

EXAMPLES = """\
examples:
  mrts new pair --robot arm.urdf                  two of a kind
  mrts new lift --robot left.urdf --robot right.urdf --tip tool0 --tip tool0 --mass 5
  mrts new held --robot arm.urdf --degrees --posture=6,-75,109,-40,11,17 --posture=-23,-69,103,-29,-11,57
  mrts new --hold cell.yaml motion.yaml           grasps from the postures of a cell that is there"""

HOLD_FILES = 2
"""CELL and MOTION of --hold."""

OF_A_NEW_CELL = ("folder", "robot", "xacro_arg", "tip", "base", "posture", "degrees", "mass", "gravity", "name", "copy")
"""Arguments that --hold does without."""


def add(verb: argparse.ArgumentParser) -> None:
    """Add the arguments of the verb."""
    verb.add_argument("folder", type=Path, nargs="?", metavar="DIR", help="folder for cell.yaml and motion.yaml")
    verb.add_argument("--robot", action="append", default=[], metavar="URDF",
                      help="once for each robot; a single arm stands twice, a machine with two arms once (asked for at "
                      "a terminal)")  # fmt: skip
    add_xacro_arg(verb, "the robots that are xacros")
    verb.add_argument("--tip", action="append", default=[], metavar="LINK",
                      help="link that holds the object, once for each robot, or several of a single one (default: "
                      "found by name)")  # fmt: skip
    verb.add_argument(
        "--base",
        action="append",
        default=[],
        metavar="X,Y,Z[,R,P,Y]",
        help="root of the URDF in the world, once for each robot; m, rad (default: proposed)",
    )
    verb.add_argument("--posture", action="append", default=[], metavar="Q,Q,…",
                      help="where the arm holds the object, once for each arm; rad, m (default: searched)")  # fmt: skip
    verb.add_argument("--degrees", action="store_true", help="angles of --base and --posture are degrees")
    verb.add_argument("--mass", type=float, metavar="KG", help="of the object (default: what the arms hold easily)")
    verb.add_argument("--gravity", metavar="X,Y,Z", help="in the world (default: 0,0,-9.81)")
    verb.add_argument("--name", help="of the cell (default: that of the folder)")
    verb.add_argument("--copy", action="store_true", help="copy the URDFs into the folder (not their meshes)")
    verb.add_argument("--force", action="store_true", help="overwrite files; with --hold, write the grasps into CELL")
    verb.add_argument("--hold", nargs=HOLD_FILES, type=Path, metavar=("CELL", "MOTION"),
                      help="the grasps with which the hands hold the object where the motion starts, as the postures "
                      "of the cell put them: 'hold it here, now'")  # fmt: skip
    verb.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Begin a cell, or compute the grasps of one."""
    if options.hold is not None:
        return _hold(options)
    from mrts.starting.reading import refuse, request_of

    folder = options.folder or _asked_folder()
    if folder.is_file():
        rule = "is a file, and the folder for the new files belongs here; robots follow --robot."
        raise InputError("DIR", rule, value=str(folder))
    files = {"cell": folder / "cell.yaml", "motion": folder / "motion.yaml"}
    for path in files.values():
        if path.exists() and not options.force:
            raise InputError(path, "is there already; --force overwrites it, another DIR leaves it.")
    check_outputs({f"DIR ({name})": path for name, path in files.items()})
    request = request_of(_given(options, folder), folder, _asked_tips if can_ask() else refuse)
    return _begin(options, folder, request)


def _begin(options: argparse.Namespace, folder: Path, request: "Request") -> int:
    from mrts.cell.remarks import urdf_remarks
    from mrts.starting.proposal import propose, renamed

    copies = _copies(request, folder, force=options.force) if options.copy else {}
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


def _asked_folder() -> Path:
    """The folder that a user at a terminal names.

    Raises:
        InputError: If nobody can be asked.
    """
    if not can_ask():
        raise InputError("DIR", "is missing: the folder for cell.yaml and motion.yaml.")
    return Path(ask("Folder for the new cell", "cell"))


def _asked_robots() -> list[str]:
    """The URDFs that a user at a terminal names.

    Raises:
        InputError: If nobody can be asked.
    """
    if not can_ask():
        raise InputError("--robot", "is missing: the URDF of a robot, once for each.")
    robots: list[str] = []
    while not robots:
        robots = [robot for robot in [ask("URDF of the first robot")] if robot]
    while another := ask("URDF of another robot (nothing: no other; one arm alone stands twice)"):
        robots.append(another)
    return robots


def _given(options: argparse.Namespace, folder: Path) -> "Given":
    """What the options say.

    Raises:
        InputError: If one breaks a rule.
    """
    import numpy as np

    from mrts.base.argument_types import is_number
    from mrts.base.input_file import LARGEST_NUMBER
    from mrts.base.rigid_transform import RigidTransform
    from mrts.starting.reading import Given

    if options.mass is not None and not (is_number(options.mass, 0, LARGEST_NUMBER) and options.mass > 0):
        raise InputError("--mass", "must be a number > 0, in kg.", value=options.mass)
    turn = np.pi / 180 if options.degrees else 1.0
    bases = []
    for text in options.base:
        pose = _numbers("--base", text, (3, 6))
        bases.append(
            RigidTransform.from_xyz_rpy(pose[:3].tolist(), (turn * np.append(pose[3:], [0.0] * 3)[:3]).tolist())
        )
    gravity = np.array([0, 0, -9.81]) if options.gravity is None else _numbers("--gravity", options.gravity, (3,))
    return Given(
        name=_name(options.name, folder),
        robots=options.robot or _asked_robots(),
        tips=options.tip,
        bases=bases,
        postures=[_numbers("--posture", text) for text in options.posture],
        mass=options.mass,
        gravity=gravity,
        degrees=options.degrees,
        xacro_args=xacro_arguments(options.xacro_arg),
    )


def _numbers(option: str, text: str, counts: tuple[int, ...] = ()) -> "Array":
    """The numbers of an option, Shape (n,).

    Raises:
        InputError: If they are none, not finite, or of another count.
    """
    import numpy as np

    from mrts.base.argument_types import is_number
    from mrts.base.input_file import LARGEST_NUMBER

    try:
        numbers = [float(word) for word in text.split(",")]
    except ValueError:
        numbers = []
    if not numbers or "_" in text or not all(is_number(number, -LARGEST_NUMBER, LARGEST_NUMBER) for number in numbers):
        raise InputError(option, "must be numbers with commas between them, such as 0.5,0,-1.", value=text)
    if counts and len(numbers) not in counts:
        raise InputError(option, f"must be {' or '.join(map(str, counts))} numbers.", value=text)
    return np.array(numbers)


def _name(given: str | None, folder: Path) -> str:
    """The name of the cell: letters, digits and single underscores, as generated C has it.

    Raises:
        InputError: If the one that is given is no such name.
    """
    import re

    from mrts.base.input_file import IDENTIFIER, LONGEST_NAME

    if given is not None:
        if not re.fullmatch(IDENTIFIER, given) or len(given) > LONGEST_NAME:
            rule = f"must be letters, digits and single underscores, at most {LONGEST_NAME}, beginning with a letter."
            raise InputError("--name", rule, value=given)
        return given
    words = re.findall(r"[A-Za-z0-9]+", folder.absolute().name)
    name = "_".join(words)[:LONGEST_NAME].rstrip("_")
    return name if re.fullmatch(IDENTIFIER, name) else "cell"


def _asked_tips(name: str, tree: "UrdfTree", found: list["Hand"]) -> list[str]:
    """The tips that a user at a terminal chooses.

    Raises:
        InputError: If there is none to choose, or no answer.
    """
    from mrts.starting.reading import refuse
    from mrts.starting.tips import FEWEST_JOINTS, moved_by, possible_tips

    links = possible_tips(tree, found)
    if not links:
        return refuse(name, tree, found)
    say(f"{name} does not say which link holds the object. Links that {FEWEST_JOINTS} joints or more move:")
    for link in links:
        say(f"  {link} ({len(moved_by(tree, link))} joints)")
    while True:
        typed = ask("Tip link (two with a comma between them for two arms)", links[-1])
        tips = [tip.strip() for tip in typed.split(",")]
        unknown = [tip for tip in tips if tip not in tree.links]
        if not unknown:
            return tips
        warn(f"there is no link '{unknown[0]}'")


def _tell_arms(request: "Request") -> None:
    """What was read: the chain of each arm, its joints and limits, and what is missing."""
    from mrts.starting.cell_writing import missing
    from mrts.starting.urdf_check import joint_lines

    chains: dict[int, ArmRequest] = {}
    for each in request.arms:  # two of a kind have one chain, told under the name of the first
        chains.setdefault(id(each.arm.chain), each)
    for each in chains.values():
        chain = each.arm.chain
        proposed = f" (proposed: {each.why})" if each.why else ""
        names = " and ".join(other.arm.name for other in request.arms if other.arm.chain is chain)
        say(f"{names}: {each.urdf}, {chain.source.base_link} to {chain.source.tip_link}{proposed}", "strong")
        for line in joint_lines(chain):
            say(line)
        for sentence in missing(each.arm):
            say(f"  missing: {sentence}", "note")
    say("")


def _copies(request: "Request", folder: Path, *, force: bool) -> dict[Path, str]:
    """Names in the new folder for copies of the URDFs, by where they are.

    Raises:
        InputError: If one is a xacro, or is there already.
    """
    from mrts.base.formats.package_uri import is_xacro

    names: dict[Path, str] = {}
    for each in request.arms:
        if is_xacro(each.path):
            raise InputError("--copy", "does not go with a xacro, which includes other files.", value=each.urdf)
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
    """Write the files, all or none.

    Raises:
        InputError: If one cannot be written.
    """
    from mrts.base.atomic_file import Write, text_writer, write_together
    from mrts.starting.cell_writing import cell_file, motion_file

    files: dict[Path, Write] = {}
    for path, name in copies.items():
        files[folder / name] = lambda copy, path=path: shutil.copyfile(path, copy)  # type: ignore[misc]  # its own path
    files[folder / "cell.yaml"] = text_writer(cell_file(proposal))
    files[folder / "motion.yaml"] = text_writer(motion_file(proposal))
    write_together(files)


def _tell_proposal(folder: Path, proposal: "Proposal") -> None:
    """What was written, what it can do, and what to do next."""
    from mrts.cell.remarks import NO_COLLISIONS

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
    say(f"{NO_COLLISIONS}\n", "note")
    say("Look at it, ask how fast it may be played, then put your own numbers in:")
    files = f"{shlex.quote(str(cell))} {shlex.quote(str(motion))}"
    say(f"  mrts view {files}")
    say(f"  mrts scale {files}")


def _hold(options: argparse.Namespace) -> int:
    """Print the grasps of a cell whose hands hold the object where they are, or write them into its file."""
    from mrts.base.atomic_file import write_text_atomically
    from mrts.base.input_file import text_of
    from mrts.base.regular_file import is_folder, read_regular
    from mrts.base.rigid_transform import rpy_from_rotation
    from mrts.base.yaml_parser import MAX_YAML_BYTES
    from mrts.commands.options.common import cell_option
    from mrts.motion.motion_file import load_motion
    from mrts.motion.object_motion import ObjectMotion
    from mrts.starting.hold import grasp_lines, hold_here, with_grasps

    cell_path, motion_path = options.hold
    given = {name: getattr(options, name) for name in OF_A_NEW_CELL}
    beside = [name for name, value in given.items() if value is not None and value is not False and value != []]
    if beside:
        word = "DIR" if "folder" in beside else f"--{beside[0].replace('_', '-')}"
        raise InputError("--hold", f"takes a cell that is there, and its motion; {word} does not go with it.")
    motion = load_motion(motion_path)
    if not isinstance(motion, ObjectMotion):
        raise InputError(motion_path, "moves joints: only a motion of the object says where it starts.")
    if is_folder(cell_path):
        raise InputError(cell_path, "is a folder; --hold takes a cell file.")
    content = read_regular(cell_path, "cell file", MAX_YAML_BYTES)
    text = text_of(cell_path, "cell file", content)
    cell = hold_here(cell_option(cell_path), motion.position[0], rpy_from_rotation(motion.rotation[0]))
    grasps = grasp_lines(cell)
    if options.force:
        held = with_grasps(cell_path, text, grasps)
        write_text_atomically(cell_path, held.replace("\n", "\r\n") if b"\r\n" in content else held)
    for name, line in grasps.items():
        say(f"{name}:", "strong")
        say(f"    grasp: {line}")
    say(f"written into {cell_path}" if options.force else f"--force writes them into {cell_path}")
    return FEASIBLE
