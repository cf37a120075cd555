# SPDX-License-Identifier: MIT
"""Instructions a sample of whole calls, Python's own included, by callgrind: what no load of the machine changes.

Each call is made once before, then counted in a process under callgrind: one thread, the calls of table.py.
"""

import ctypes
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from interleaved import on_one_processor
from table import PROCESS, ROWS, questions

SOURCE = Path(__file__).resolve().parents[1] / "c" / "callgrind_requests.c"
NAMES = [name for name in ROWS if name != PROCESS]
SAMPLES = 1000
COUNT = "--count"


def counted(name: str, samples: int, requests: str) -> None:
    """Make one call, then count it once more."""
    on_one_processor()
    call, library = questions(samples)[name], ctypes.CDLL(requests)
    call()
    library.begin_counting()
    call()
    library.end_counting()


def main(samples: int = SAMPLES) -> None:
    """Print the table."""
    compiler, valgrind = shutil.which("gcc"), shutil.which("valgrind")
    if compiler is None or valgrind is None:
        sys.exit("this benchmark needs gcc and valgrind: apt-get install gcc valgrind")
    print(f"instructions of whole calls, {samples} samples")
    with tempfile.TemporaryDirectory() as folder:
        requests = Path(folder) / "requests.so"
        subprocess.run([compiler, "-O2", "-shared", "-fPIC", str(SOURCE), "-o", str(requests)], check=True)  # noqa: S603 (fixed words)
        for number, name in enumerate(NAMES):
            record = Path(folder) / f"callgrind{number}"
            command = [valgrind, "--tool=callgrind", "--instr-atstart=no", f"--callgrind-out-file={record}"]
            command += [sys.executable, __file__, COUNT, name, str(samples), str(requests)]
            subprocess.run(command, check=True, capture_output=True)  # noqa: S603 (this script)
            text = Path(f"{record}.1").read_text(encoding="utf-8")
            found = re.search(r"^(?:summary|totals): (\d+)", text, re.MULTILINE)
            if found is None:
                sys.exit(f"callgrind counted nothing of '{name}'")
            print(f"  {name:<40}{int(found.group(1)) / samples:>12.0f} a sample", flush=True)


if __name__ == "__main__":
    if sys.argv[1:2] == [COUNT]:
        counted(sys.argv[2], int(sys.argv[3]), sys.argv[4])
    else:
        main()
