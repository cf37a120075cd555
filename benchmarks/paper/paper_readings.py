# SPDX-License-Identifier: MIT
"""How the examples of the paper's section VI depend on what the paper leaves unstated.

Prints c²⁺ of six examples for other half-widths and contact heights of the object, and with the moments r × f of the
contact forces left out of (4). Used in docs/paper.md.
"""

import shutil
import tempfile
from importlib.resources import files
from pathlib import Path
from typing import Any

import yaml

import mrts

DATA = Path(str(files("mrts") / "data"))
DOWN_UP = {"left": [0.5, 2.1, -2.6]}
CASES = ("6.1 (a)", "6.1 (b)", "6.1 (c)", "6.3", "6.3 even", "6.4")
PAPER = (3.988, 2.949, 2.779, 2.516, 2.406, 1.358)


def with_contact(half_width: float, height: float, *, moments: bool = True) -> mrts.Cell:
    """The shipped cell with other contact points; without moments the contacts act at the centre of mass.

    Leaving r × f out of (4) is the same as moving grasps to the centre of mass and the bases with them: the arms keep
    their configuration, and a base has no other effect.
    """
    description: dict[str, Any] = yaml.safe_load((DATA / "planar_dual_arm" / "cell.yaml").read_text())
    for robot, side in zip(description["robots"], (-1, 1), strict=True):
        robot["grasp"]["xyz"] = [side * half_width, height, 0]
        if not moments:
            robot["base"]["xyz"][0] -= side * half_width
            robot["base"]["xyz"][1] -= height
            robot["grasp"]["xyz"] = [0, 0, 0]
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "cell.yaml"
        path.write_text(yaml.safe_dump(description), encoding="utf-8")
        shutil.copy(DATA / "planar_dual_arm" / "planar_arm.urdf", folder)
        return mrts.load_cell(path)


def examples(cell: mrts.Cell) -> list[float]:
    """c²⁺ of `CASES`."""
    lift = mrts.load_motion(DATA / "planar_dual_arm" / "lift.yaml")
    flipped, even = cell.with_postures(DOWN_UP), mrts.LoadSharing()
    results = [
        mrts.scale(cell.without_wrench_limits(), lift, weights=1),
        mrts.scale(cell, lift, weights=1),
        mrts.scale(cell, lift, sharing=even, weights=1),
        mrts.scale(flipped, lift, weights=1),
        mrts.scale(flipped, lift, sharing=even, weights=1),
        mrts.scale(cell.with_mass(3.0), lift, weights=1),
    ]
    return [result.range.upper.c2 if result.range.upper else float("nan") for result in results]


def row(name: str, values: list[float] | tuple[float, ...]) -> str:
    """One line of the table."""
    return f"{name:<26}" + "".join(f"{value:>10.3f}" for value in values)


def main() -> None:
    """Print the table."""
    print(" " * 26 + "".join(f"{case:>10}" for case in CASES))
    print(row("paper", PAPER))
    print(row("w 1.10 m, h 0 (shipped)", examples(with_contact(1.1, 0))))
    print(row("the same without r × f", examples(with_contact(1.1, 0, moments=False))))
    for half_width in (0.1, 0.3, 0.6, 0.9, 1.0, 1.05, 1.15, 1.2):
        print(row(f"w {half_width:.2f} m", examples(with_contact(half_width, 0))))
    for height in (-0.15, -0.1, -0.05, 0.05, 0.1):
        print(row(f"h {height:+.2f} m", examples(with_contact(1.1, height))))


if __name__ == "__main__":
    main()
