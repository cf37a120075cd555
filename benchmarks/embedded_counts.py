# SPDX-License-Identifier: MIT
"""Instructions, stack and code size of exported libraries on a Cortex-M7 under QEMU: the table of docs/embedded.md."""

import sys
import tempfile
from importlib.resources import files
from pathlib import Path

from mrts.cli import main as mrts_main

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "tests" / "helpers"))
from embedded_target import FOLDER, code_size, cross_compile, missing_tools, run_on_target

DATA = Path(str(files("mrts") / "data"))


def main() -> None:
    """Print the counts of both shipped cells in both precisions."""
    if missing_tools():
        sys.exit(f"this needs: apt-get install {' '.join(missing_tools())}")
    for cell in ("planar_dual_arm", "dual_ur5"):
        for precision in ("double", "float"):
            with tempfile.TemporaryDirectory() as name:
                library = Path(name)
                mrts_main(["export", str(DATA / cell / "cell.yaml"), "-o", name, "--precision", precision])
                headers = (f'-DLIBRARY_HEADER="{cell}.h"', f'-DVECTORS_HEADER="{cell}_vectors.h"')
                defines = (f"-DPREFIX={cell}", f"-DMACRO={cell.upper()}", *headers)
                image = cross_compile(library, FOLDER / "count_main.c", library / "image.elf", *defines)
                print(f"\n{cell}, {precision}: code and tables {code_size(library)} bytes (-O2)")
                print(f"{'call':<22} {'mean':>9} {'most':>9} {'stack':>7}   instructions, instructions, bytes")
                print(run_on_target(image).stdout)


if __name__ == "__main__":
    main()
