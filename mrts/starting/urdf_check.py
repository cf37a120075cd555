# SPDX-License-Identifier: MIT
"""What is wrong with one URDF, and what it says of its arms, before there is a cell."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np

from mrts.base.errors import InputError, Mistakes
from mrts.base.formats.package_uri import is_xacro
from mrts.base.json_output import JsonOutput
from mrts.base.remark import Remark, Severity
from mrts.cell.remarks import first_few, urdf_remarks
from mrts.cell.robot import Robot
from mrts.cell.source_files import UrdfReading, urdf_with_mistakes
from mrts.diagnosis.cell_check import finite_json, mistakes_json, position_range
from mrts.scene.arm_meshes import mesh_file
from mrts.starting.arm import Arm, make_arm, plane_of
from mrts.starting.cell_writing import missing
from mrts.starting.reading import check_movable
from mrts.starting.tips import FEWEST_JOINTS, first_link, hands

ENDINGS = (".urdf", ".xacro", ".xml")
"""Of names of files that are checked as URDFs."""


def is_urdf(path: Path) -> bool:
    """Whether a file is a URDF or a xacro, by its name."""
    return path.suffix.lower() in ENDINGS


@dataclass(frozen=True, kw_only=True)
class UrdfCheck(JsonOutput):
    """What `check_urdf` found.

    Attributes:
        urdf: The file.
        mistakes: All that breaks a rule.
        links: How many there are.
        joints: Likewise.
        arms: Chains to the hands that it seems to have.
        remarks: What to know of it; hints are likely mistakes, and why an arm can hold nothing.
    """

    urdf: Path
    mistakes: tuple[InputError, ...]
    links: int = 0
    joints: int = 0
    arms: tuple[Arm, ...] = ()
    remarks: tuple[Remark, ...] = ()

    @property
    def status(self) -> Literal["fine", "wrong-input"]:
        """What came of it."""
        return "wrong-input" if self.mistakes else "fine"

    def outcome(self) -> str:
        """The answer in a sentence."""
        count = len(self.mistakes)
        sound = f"the URDF is sound: {self.links} links, {self.joints} joints"
        return f"{self.urdf.name}: " + (f"{count} mistake{'s' * (count > 1)}" if count else sound)

    def lines(self) -> Iterator[str]:
        """The answer for people, the outcome first."""
        yield f"{self.outcome()}{':' * bool(self.mistakes)}"
        for number, mistake in enumerate(self.mistakes, start=1):
            yield f"  {number}. {mistake}"
        yield from (f"hint: {remark.text}" for remark in self._told("hint"))
        for arm in self.arms:
            yield ""
            source = arm.chain.source
            yield f"{source.base_link} to {source.tip_link}, {sum(source.carried_mass):.4g} kg"
            yield from joint_lines(arm.chain)
            yield from (f"  missing: {sentence}" for sentence in missing(arm))
        yield from map(str, self._told("warning"))

    def to_json(self) -> dict[str, Any]:
        """All of it as JSON values."""
        return {
            "status": self.status,
            "urdf": str(self.urdf),
            "mistakes": mistakes_json(self.mistakes),
            "links": self.links,
            "joints": self.joints,
            "arms": [_arm_json(arm) for arm in self.arms],
            "hints": [remark.to_json() for remark in self._told("hint")],
            "warnings": [remark.to_json() for remark in self._told("warning")],
        }

    def _told(self, severity: Severity) -> list[Remark]:
        return [remark for remark in self.remarks if remark.severity == severity]


def check_urdf(path: Path, args: Mapping[str, str]) -> UrdfCheck:
    """Check one URDF: its XML, joints and masses, the chains to its hands, and whether its meshes are there.

    Args:
        path: The file.
        args: Of a xacro, by name.

    Raises:
        InputError: If arguments are given to what is no xacro.
    """
    if args and not is_xacro(path):
        raise InputError("--xacro-arg", f"{path.name} is no xacro, whose name ends in .xacro.")
    read = urdf_with_mistakes(path, args)
    mistakes = Mistakes()
    for mistake in read.mistakes:
        mistakes.add(mistake)
    arms = _arms(read, mistakes)
    return UrdfCheck(
        urdf=path,
        mistakes=tuple(mistakes.found),
        links=0 if read.tree is None else len(read.tree.links),
        joints=0 if read.tree is None else len(read.tree.joints),
        arms=tuple(arms),
        remarks=(*(hint for arm in arms for hint in _hints(arm, path)), *read.remarks, *_missing_meshes(read)),
    )


def joint_lines(chain: Robot) -> Iterator[str]:
    """Joints of a chain and their limits, as aligned lines.

    Args:
        chain: From a URDF.
    """
    rows = _joints(chain)
    width = max(len(name) for name in ("joint", *chain.joints))
    yield f"  {'joint':<{width}} {'position':>20} {'torque':>10} {'velocity':>12}"
    for name, kind, lower, upper, effort, velocity, _ in rows:
        unit, torque = ("rad", "N m") if kind == "revolute" else ("m", "N")
        shown = "?" if effort == np.inf else f"{effort:.4g} {torque}"
        speed = "?" if velocity == np.inf else f"{velocity:.4g} {unit}/s"
        yield f"  {name:<{width}} {position_range(lower, upper, unit):>20} {shown:>10} {speed:>12}"


def _joints(chain: Robot) -> Iterator[tuple[Any, ...]]:
    """Name, kind, limits of position, effort and velocity, infinite where there is none, and mass of each joint."""
    arrays = (chain.position_lower, chain.position_upper, chain.torque_upper, chain.velocity_limit)
    columns = (values.tolist() for values in arrays)
    return zip(chain.joints, chain.joint_types, *columns, chain.source.carried_mass, strict=True)


def _arms(read: UrdfReading, mistakes: Mistakes) -> list[Arm]:
    arms: list[Arm] = []
    if read.tree is None or read.survey is None:
        return arms
    tips = [hand.link for hand in hands(read.tree)]
    if not tips:
        mistakes.add(InputError(read.path, f"has no link that {FEWEST_JOINTS} joints or more move: it is no arm."))
        return arms
    base = first_link(read.tree, tips)
    for tip in tips:
        with mistakes.noted():
            arms.append(make_arm(tip, *read.survey(base, tip)))
    return arms


def _hints(arm: Arm, path: Path) -> Iterator[Remark]:
    likely = [*urdf_remarks(arm.robot)]
    yield from likely
    try:
        check_movable(arm, path, plane_of([arm]))
    except InputError as error:
        if error.rule not in {hint.text for hint in likely}:
            yield Remark.hint("cannot-hold", f"{arm.chain.source.tip_link}: {error.rule}")


def _missing_meshes(read: UrdfReading) -> Iterator[Remark]:
    """Meshes that are not there: nothing is computed from them."""
    gone, why = [], ""
    for name in read.meshes:
        try:
            mesh_file(read.path, name)
        except InputError as error:
            gone.append(name)
            why = why or error.rule
    if gone:
        also = "" if len(gone) == 1 else f" So are {len(gone) - 1} more: {first_few(gone[1:])}."
        text = f"{read.path.name}: {why}{also} Only pictures need meshes."
        yield Remark("missing-mesh", text)


def _arm_json(arm: Arm) -> dict[str, Any]:
    chain = arm.chain
    joints = [
        finite_json({
            "joint": name, "type": kind, "position": (lower, upper), "torque": effort, "velocity": velocity,
            "mass": mass,
        })
        for name, kind, lower, upper, effort, velocity, mass in _joints(chain)
    ]  # fmt: skip
    return {
        "base_link": chain.source.base_link,
        "tip_link": chain.source.tip_link,
        "joints": joints,
        "missing": missing(arm),
    }
