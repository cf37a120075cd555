# SPDX-License-Identifier: MIT
"""Instructions, stack and code size of exported libraries on a Cortex-M7 under QEMU: the table of docs/embedded.md."""

import io
import sys
import tempfile
from contextlib import redirect_stdout
from importlib.resources import files
from pathlib import Path
from typing import Any

import yaml

import mrts
from mrts.cli import main as mrts_main

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "tests" / "helpers" / "embedded"))
from embedded_target import FOLDER, code_size, cross_compile, missing_tools, run_on_target

DATA = Path(str(files("mrts") / "data"))

DRY: dict[str, dict[str, Any]] = {
    "planar_dual_arm": {"armature": [0.5, 0.4, 0.1], "friction": {"coulomb": [6, 5, 2], "viscous": 0}},
    "dual_ur5": {
        "armature": [0.66, 0.66, 0.6, 0.1, 0.1, 0.1],
        "friction": {"coulomb": [12, 12, 8, 2, 2, 2], "viscous": 0},
    },
}
"""Motors without terms in the speed."""

LARGE, SMALL = [[0, 330], [1, 330], [4, 115]], [[0, 60], [2, 60], [6, 10]]

WITH_SPEED: dict[str, dict[str, Any]] = {
    "planar_dual_arm": {
        "viscous": [8, 8, 3],
        "torque_speed": [[[0, 100], [1.5, 100], [4, 30]], [[0, 80], [2, 80], [5, 10]], [[0, 50], [6, 20]]],
    },
    "dual_ur5": {"viscous": [16, 16, 10, 3, 3, 3], "torque_speed": [LARGE] * 3 + [SMALL] * 3},
}
"""What such motors have besides in the third count."""


def main() -> None:
    """Print the counts of both shipped cells: ideal motors, dry friction, everything that motors may have."""
    if missing_tools():
        sys.exit(f"this needs: apt-get install {' '.join(missing_tools())}")
    for cell in ("planar_dual_arm", "dual_ur5"):
        more = WITH_SPEED[cell]
        friction = DRY[cell]["friction"] | {"viscous": more["viscous"]}
        curved = DRY[cell] | {"friction": friction, "torque_speed": more["torque_speed"]}
        for what, motors in (("ideal motors", None), ("dry friction", DRY[cell]), ("with speed", curved)):
            for precision in ("double", "float"):
                with tempfile.TemporaryDirectory() as name:
                    _count(cell, what, motors, precision, Path(name))
        for precision in ("double", "float"):
            with tempfile.TemporaryDirectory() as name:
                _count_override(cell, precision, Path(name))


def _count(cell: str, what: str, motors: dict[str, Any] | None, precision: str, place: Path) -> None:
    description = yaml.safe_load((DATA / cell / "cell.yaml").read_text())
    for robot in description["robots"]:
        if not robot["urdf"].startswith("package:"):
            robot["urdf"] = str(DATA / cell / robot["urdf"])
        robot.update({} if motors is None else {"motors": motors})
    (place / "cell.yaml").write_text(yaml.safe_dump(description))
    library = _exported(place / "cell.yaml", precision, place)
    headers = (f'-DLIBRARY_HEADER="{cell}.h"', f'-DVECTORS_HEADER="{cell}_vectors.h"')
    defines = (f"-DPREFIX={cell}", f"-DMACRO={cell.upper()}", *headers)
    image = cross_compile(library, FOLDER / "count_main.c", place / "image.elf", *defines)
    print(f"\n{cell}, {what}, {precision}: code and tables {code_size(library)} bytes (-O2)")
    print(f"{'call':<22} {'mean':>9} {'most':>9} {'stack':>7}   instructions, instructions, bytes")
    print(run_on_target(image).stdout)


def _count_override(cell: str, precision: str, place: Path) -> None:
    folder = DATA / cell
    motion = next(path for path in (folder / "lift.yaml", folder / "lift_and_turn.yaml") if path.exists())
    plan = place / "plan.npz"
    mrts.save_result(mrts.scale(mrts.load_cell(folder / "cell.yaml"), mrts.load_motion(motion)), plan)
    library = _exported(folder / "cell.yaml", precision, place, "--plan", str(plan))
    defines = (f"-DPREFIX={cell}", f'-DLIBRARY_HEADER="{cell}_override.h"')
    image = cross_compile(library, FOLDER / "count_override.c", place / "image.elf", *defines)
    print(f"\n{cell}, speed override, {precision}: instructions of a")
    print(run_on_target(image).stdout)


def _exported(cell: Path, precision: str, place: Path, *plan: str) -> Path:
    with redirect_stdout(io.StringIO()):
        mrts_main(["export", str(cell), "-o", str(place / "library"), "--precision", precision, *plan])
    return place / "library"


if __name__ == "__main__":
    main()
