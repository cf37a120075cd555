# SPDX-License-Identifier: MIT
"""The files of a proposal: a cell file and a motion file whose comments say what was read, proposed and assumed."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from mrts.base.printable import printable
from mrts.base.yaml_text import flow
from mrts.cell.remarks import missing_masses
from mrts.starting.arm import Arm
from mrts.starting.proposal import Proposal

COMMENT_AT = 50


def cell_file(proposal: Proposal) -> str:
    """Text of the cell file."""
    request, cell = proposal.request, proposal.cell
    lines = [
        f"# {len(request.arms)} arms carry a box: begun by mrts new.",
        "# What the URDFs do not say was proposed or assumed; change what you know better.",
        "# Lengths in m, angles in rad, masses in kg, torques in N m (N of prismatic joints).",
        f"name: {flow(cell['name'])}",
        _line(f"gravity: {flow(cell['gravity'])}", "world, m/s²"),
    ]
    if cell.get("plane"):
        lines.append(_line(f"plane: {cell['plane']}", "all joints move in it: two forces and one moment a hand"))
    lines += [
        "object:",
        _line(f"  mass: {cell['object']['mass']:g}", "assumed" if request.mass is None else "as asked for", proposal),
        _line(f"  shape: {flow(cell['object']['shape'])}", "assumed: a uniform box, which gives the inertia as well"),
        "robots:",
    ]
    for arm, robot in zip(request.arms, cell["robots"], strict=True):
        lines += _robot(proposal, arm, robot)
    lines.append("    # nothing bounds yet what the hands exert on the object: see wrench and contact")
    return "\n".join(lines) + "\n"


def motion_file(proposal: Proposal) -> str:
    """Text of the motion file."""
    motion, lift = proposal.motion, float(np.linalg.norm(proposal.layout.lift))
    lines = [
        f"# The object goes up by {lift:g} m, from rest to rest: begun by mrts new.",
        "# Poses are those of its centre of mass in the world; lengths in m, angles in rad.",
        _line(f"duration: {motion['duration']:g}", "s; proposed: the cell may play it faster"),
        _line(f"profile: {motion['profile']}", "or sinusoid, trapezoid, cubic"),
        f"start: {flow(motion['start'])}",
        _line(f"end: {flow(motion['end'])}", "with rpy: [0, 0, 0.3] it turns as well"),
    ]
    return "\n".join(lines) + "\n"


def _line(text: str, comment: str, proposal: Proposal | None = None) -> str:
    if proposal is not None and proposal.request.mass not in {None, proposal.mass}:
        comment = f"{proposal.request.mass:g} were asked for, which the motors cannot hold"
    if not comment:
        return text
    return f"{text:<{COMMENT_AT}} # {printable(comment)}"


def _robot(proposal: Proposal, arm: Arm, robot: dict[str, Any]) -> Iterator[str]:
    chain, standing = arm.robot, arm.base is not None
    machine = proposal.request.one_machine
    yield f"  - name: {flow(robot['name'])}"
    yield f"    urdf: {flow(robot['urdf'])}"
    yield _line(f"    base_link: {flow(robot['base_link'])}", "where the chain begins")
    yield _line(f"    tip_link: {flow(robot['tip_link'])}", arm.why and f"proposed: {arm.why}")
    whose = "where the URDF has it" if machine else "as asked for" if standing else "proposed"
    yield _line(f"    base: {flow(robot['base'])}", f"base link in the world, {whose}")
    yield _line(f"    grasp: {flow(robot['grasp'])}", "tip in the object, whose frame is in its centre of mass")
    yield f"    # at the start, proposed: {printable(', '.join(chain.joints))}"
    yield f"    posture: {flow(robot['posture'])}"
    yield from _limits(arm, robot)


def _limits(arm: Arm, robot: dict[str, Any]) -> Iterator[str]:
    chain, assumed = arm.robot, arm.without_effort
    if assumed:
        whose = "assumed" if len(assumed) == len(chain.joints) else f"assumed for {', '.join(assumed)}"
        yield _line(
            f"    torque: {flow(robot['torque'])}", f"{whose}: the URDF has no effort. Put the data sheet's here"
        )
    else:
        efforts = chain.torque_upper[np.isfinite(chain.torque_upper)].tolist()
        yield _line(f"    # torque: {flow(efforts)}", "the URDF's efforts, which count; remove the # to set your own")
    speeds = ", ".join("none" if each == np.inf else f"{each:.4g}" for each in chain.velocity_limit)
    yield f"    # the URDF's velocity limits: {speeds}"
    for remark in missing_masses([arm.robot]):
        yield f"    # {printable(remark.text)}"
