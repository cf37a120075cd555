"""Every C file of the kernel alone, with both compilers, in double and float; structures as Python binds them."""

import ctypes
import shutil
import subprocess

import numpy as np
import pytest
from conftest import ROOT
from shipped_cells import sizes_of

from mrts.kernel.binding import bind, structure
from mrts.kernel.c_text import BATCH, SMOOTH, one_text
from mrts.kernel.programs import program_library
from mrts.program.path_solver import PROGRAM

C = ROOT / "mrts" / "kernel" / "c"
WARNINGS = ["-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Werror", "-fsyntax-only"]
EXPORTED = ("linear_programs.h", "quadratic_programs.h", "speed_intervals.h")
FILES = sorted(str(path.relative_to(C)) for path in C.rglob("*.c") if path.parent.name != "exported")
"""All but those of an exported library, which want a cell's numbers: tests/codegen/test_embedded.py compiles them."""


def check(compiler, file, *flags):
    found = shutil.which(compiler)
    if found is None:
        pytest.skip(f"needs {compiler}: apt-get install {compiler}")
    done = subprocess.run([found, *WARNINGS, *flags, C / file], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("compiler", ["gcc", pytest.param("clang", marks=pytest.mark.slow)])
@pytest.mark.parametrize("file", FILES)
def test_a_file_compiles_without_a_warning(file, compiler):
    for cell in ("redundant", "planar_dual_arm"):
        check(compiler, file, *sizes_of(cell))


@pytest.mark.parametrize("compiler", ["gcc", pytest.param("clang", marks=pytest.mark.slow)])
@pytest.mark.parametrize("file", EXPORTED)
def test_what_an_export_carries_is_also_float(file, compiler):
    check(compiler, file, "-DMRTS_REAL=float", "-DMRTS_SINGLE", "-Wdouble-promotion", "-Wno-unused-function")


def test_headers_are_guarded():
    for path in C.rglob("*.h"):
        guard = f"MRTS_{path.stem.upper()}_H"
        assert f"#ifndef {guard}\n#define {guard}\n" in path.read_text(), path


STRUCTURES = {
    "mrts_limits": "rows.h",
    "mrts_terms": "rows.h",
    "mrts_joint_path": "arm_tips.c",
    "mrts_outcome": "tracking.c",
    "mrts_tracking": "tracking.c",
    "mrts_smooth_program": "smooth_timing.c",
}


@pytest.mark.parametrize("name", STRUCTURES)
def test_structures_are_laid_out_as_the_compiler_does(name, tmp_path):
    made = structure(STRUCTURES[name], name)
    places = {field: getattr(made, field).offset for field, *_ in made._fields_}
    checks = [f"offsetof({name}, {field}) == {place}" for field, place in places.items()]
    checks.append(f"sizeof({name}) == {ctypes.sizeof(made)}")
    asserted = "".join(f'_Static_assert({check}, "{check}");\n' for check in checks)
    text = f"#include <stddef.h>\n{one_text((STRUCTURES[name],))}\n{asserted}"
    (tmp_path / "check.c").write_text(text)
    compiler = shutil.which("gcc") or shutil.which("cc")
    command = [compiler, "-std=c11", "-w", "-fsyntax-only", *sizes_of("redundant"), tmp_path / "check.c"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def test_arguments_have_the_types_that_c_declares():
    large = PROGRAM(nodes=1 << 30, rows=3, free=2)
    assert program_library(SMOOTH).mrts_smooth_kept(large) > 3 * large.nodes  # of an int, what is left below 2³¹
    with pytest.raises(ctypes.ArgumentError):
        program_library(BATCH).mrts_batch_work(1.5, 1, np.zeros(1), np.zeros(1))


def test_a_library_that_lacks_a_function_is_refused():
    with pytest.raises(AttributeError):
        bind(ctypes.CDLL(None), ("batch.c",))
