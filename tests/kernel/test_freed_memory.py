"""Memory that arrays give back serves the next ones, once a cell's library has been opened."""

import platform
import subprocess
import sys

import pytest

CYCLES, PAGES = 50, 4096
TOUCHED = """
import resource
import numpy as np
from mrts.kernel.foreign_arrays import keep_freed_memory

def faults():
    before = resource.getrusage(resource.RUSAGE_SELF).ru_minflt
    for _ in range({cycles}):
        arrays = [np.ones(60_000) for _ in range(4)]  # half a megabyte each
        del arrays
    return resource.getrusage(resource.RUSAGE_SELF).ru_minflt - before

first = faults()
keep_freed_memory()
faults()
print(first, faults())
"""


@pytest.mark.quick
@pytest.mark.skipif(platform.libc_ver()[0] != "glibc", reason="other C libraries decide for themselves")
def test_memory_that_was_freed_is_not_asked_of_the_system_again():
    """Of 2 MB a cycle no page comes anew; before, nearly all of them did."""
    code = TOUCHED.format(cycles=CYCLES)
    before, after = map(int, subprocess.check_output([sys.executable, "-c", code], text=True).split())
    pages_a_cycle = 4 * 480_000 // PAGES
    assert before > CYCLES * pages_a_cycle / 2
    assert after < CYCLES * pages_a_cycle / 20
