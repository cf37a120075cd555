"""Reads the files named on the command line under limits of memory and time, and prints what each cost.

A process of its own: what a bomb would take is then refused by the kernel, not taken from the machine.
"""

import json
import resource
import sys
import time
from contextlib import suppress
from pathlib import Path

import mrts
from mrts.motion.motion_file import load_motion
from mrts.output.saved_result import load_result

MEMORY = 400_000_000
"""Beyond what the imported libraries take [bytes]."""

CPU = 100
"""Of all files together [s]."""


def read(kind: str, path: Path) -> None:
    """Read a file as its kind."""
    if kind == "cell":
        from mrts.cell.cell_file import CellDescription  # noqa: PLC0415 (not before it is needed)
        from mrts.cell.cell_keys import named_files  # noqa: PLC0415

        for reference in named_files(CellDescription.read_file(path, "cell file").model_dump()).values():
            reference.sha256(path, path.parent)
    elif kind == "urdf":
        from mrts_codegen.urdf.robot_model import build_robot_model  # noqa: PLC0415
        from mrts_codegen.urdf.urdf_file import parse_urdf  # noqa: PLC0415

        from mrts.base.input_file import FileReference  # noqa: PLC0415

        content = FileReference(path.name).content(path, path.parent)
        build_robot_model(path, parse_urdf(path, content), "base", "tip")
    else:
        {"motion": load_motion, "result": load_result, "generated": mrts.load_cell}[kind](path)


def main() -> None:
    """Read all."""
    for kind in ("cell", "urdf", "motion"):  # imports
        with suppress(mrts.MrtsError):
            read(kind, Path("nothing.yaml"))
    import rosbags.rosbag2  # noqa: F401, PLC0415 (likewise)
    from yourdfpy import URDF  # noqa: F401, PLC0415

    taken = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (taken + MEMORY, taken + MEMORY))
    resource.setrlimit(resource.RLIMIT_CPU, (CPU, CPU))
    for argument in sys.argv[1:]:
        kind, _, name = argument.partition(":")
        start = time.process_time()
        try:
            read(kind, Path(name))
            outcome = "read"
        except mrts.MrtsError as error:
            outcome = str(error)
        print(json.dumps([argument, outcome, time.process_time() - start]), flush=True)


main()
