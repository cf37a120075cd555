"""Structures and functions of the kernel as Python binds them: laid out as the compiler lays them out."""

import ctypes
import shutil
import subprocess

import numpy as np
import pytest

from mrts.kernel.binding import bind, structure
from mrts.kernel.c_text import one_text
from mrts.kernel.cell_library import SparseLimits

STRUCTURES = {
    "mrts_limits": "rows.h",
    "mrts_terms": "rows.h",
    "mrts_joint_path": "dense/path_places.c",
    "mrts_following": "tracking/follow.h",
    "mrts_outcome": "tracking/follow.h",
    "mrts_smooth_program": "smooth/smooth_program.h",
}


@pytest.mark.parametrize("name", STRUCTURES)
def test_structures_are_laid_out_as_the_compiler_does(name, tmp_path):
    made = structure(STRUCTURES[name], name)
    places = {field: getattr(made, field).offset for field, *_ in made._fields_}
    checks = [f"offsetof({name}, {field}) == {place}" for field, place in places.items()]
    checks.append(f"sizeof({name}) == {ctypes.sizeof(made)}")
    asserted = "".join(f'_Static_assert({check}, "{check}");\n' for check in checks)
    text = f"#include <stddef.h>\n#define MRTS_LOCAL static\n{one_text((STRUCTURES[name],))}\n{asserted}"
    (tmp_path / "check.c").write_text(text)
    compiler = shutil.which("gcc") or shutil.which("cc")
    command = [compiler, "-std=c11", "-w", "-fsyntax-only", tmp_path / "check.c"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def test_arguments_have_the_types_that_c_declares(planar_cell):
    library = planar_cell.library.opened
    assert library.mrts_backward.restype is ctypes.c_longlong
    with pytest.raises(ctypes.ArgumentError):
        library.mrts_effects(1.5, 1, 1, 1, np.zeros(1, dtype=np.int32), np.zeros(1), np.zeros(1))


def test_a_library_that_lacks_a_function_is_refused():
    with pytest.raises(AttributeError):
        bind(ctypes.CDLL(None), ("batch.c",))


def test_reversed_limits_are_refused():
    with pytest.raises(ValueError, match=r"rows \[1\]"):
        SparseLimits(matrix=np.eye(2), lower=np.array([0.0, 1.0]), upper=np.array([1.0, 0.0]), group=("N", "N"))
