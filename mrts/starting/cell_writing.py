# SPDX-License-Identifier: MIT
"""The files of a proposal: a cell file and a motion file whose comments say what was read, proposed and assumed."""

from collections.abc import Mapping

import numpy as np

from mrts.base.printable import printable
from mrts.base.yaml_text import yaml_text
from mrts.starting.proposal import Proposal

COMMENT_AT = 50


def cell_file(proposal: Proposal) -> str:
    """Text of the cell file."""
    request, mass = proposal.request, "assumed" if proposal.request.mass is None else "as asked for"
    if request.mass not in {None, proposal.mass}:
        mass = f"{request.mass:g} were asked for, which the motors cannot hold"
    standing = "as asked for" if request.arms[0].base is not None else "proposed"
    comments = {
        "gravity": "world, m/s²",
        "plane": "all joints move in it: two forces and one moment a hand",
        "mass": mass,
        "shape": "assumed: a uniform box, which gives the inertia as well",
        "base_link": "where the chain begins",
        "tip_link": "holds the object",
        "base": f"base link in the world, {'where the URDF has it' if request.one_machine else standing}",
        "grasp": "tip in the object, whose frame is in its centre of mass",
        "posture": "at the start, proposed",
        "torque": "assumed: the URDF has no effort. Put the data sheet's here",
    }
    return (
        f"# {len(request.arms)} arms carry a box: begun by mrts new.\n"
        "# What the URDFs do not say was proposed or assumed; change what you know better.\n"
        "# Lengths in m, angles in rad, masses in kg, torques in N m (N of prismatic joints).\n"
        f"{_commented(yaml_text(proposal.cell), comments)}"
        "# Nothing bounds yet what the hands exert on the object: see wrench and contact.\n"
    )


def motion_file(proposal: Proposal) -> str:
    """Text of the motion file."""
    lift = float(np.linalg.norm(proposal.layout.lift))
    comments = {
        "duration": "s; proposed: the cell may play it faster",
        "profile": "or sinusoid, trapezoid, cubic",
        "end": "with rpy: [0, 0, 0.3] it turns as well",
    }
    return (
        f"# The object goes up by {lift:g} m, from rest to rest: begun by mrts new.\n"
        "# Poses are those of its centre of mass in the world; lengths in m, angles in rad.\n"
        f"{_commented(yaml_text(proposal.motion), comments)}"
    )


def _commented(text: str, comments: Mapping[str, str]) -> str:
    """The same YAML with a comment behind lines that begin with a key."""
    lines = []
    for line in text.splitlines():
        comment = comments.get(line.strip(" -").partition(":")[0])
        lines.append(line if comment is None else f"{line:<{COMMENT_AT}} # {printable(comment)}")
    return "\n".join(lines) + "\n"
