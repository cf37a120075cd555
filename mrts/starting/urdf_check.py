# SPDX-License-Identifier: MIT
"""What is wrong with one URDF, and what it says of its arms, before there is a cell."""

from collections.abc import Iterator
from pathlib import Path

from mrts.base.errors import InputError, Mistakes
from mrts.base.remark import Remark
from mrts.cell.remarks import joint_assumptions, missing_masses, urdf_remarks
from mrts.cell.source_files import UrdfReading, arm_of_urdf, read_urdf
from mrts.starting.arm import Arm, plane_of
from mrts.starting.cell_check import CellCheck
from mrts.starting.reading import check_movable
from mrts.starting.tips import FEWEST_JOINTS, first_link, hands


def check_urdf(path: Path) -> CellCheck:
    """Check one URDF: its XML, joints and masses, and the chains to its hands."""
    read = read_urdf(path, Path(), str(path))
    mistakes = Mistakes(read.mistakes)
    arms = _arms(read, mistakes)
    robots = tuple(arm.robot for arm in arms)
    remarks = [hint for arm in arms for hint in _hints(arm, path)]
    remarks += [*read.remarks, *missing_masses(robots), *joint_assumptions(robots)]
    return CellCheck(cell=path, mistakes=tuple(mistakes.found), robots=robots, remarks=tuple(remarks))


def _arms(read: UrdfReading, mistakes: Mistakes) -> list[Arm]:
    arms: list[Arm] = []
    if read.urdf is None:
        return arms
    tips = [hand.link for hand in hands(read.urdf)]
    if not tips:
        mistakes.add(InputError(read.path, f"has no link that {FEWEST_JOINTS} joints or more move: it is no arm."))
        return arms
    base = first_link(read.urdf, tips)
    for tip in tips:
        with mistakes.noted():
            arms.append(Arm(*arm_of_urdf(read.path, read.urdf, base, tip)))
    return arms


def _hints(arm: Arm, path: Path) -> Iterator[Remark]:
    likely = [*urdf_remarks(arm.robot)]
    yield from likely
    try:
        check_movable(arm, path, plane_of([arm]))
    except InputError as error:
        if error.rule not in {hint.text for hint in likely}:
            yield Remark.hint("cannot-hold", f"{arm.robot.source.tip_link}: {error.rule}")
