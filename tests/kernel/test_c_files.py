"""Every C file of the kernel alone: what it includes is all that it needs, with both compilers, in double and float."""

import shutil
import subprocess

import pytest
from conftest import ROOT

C = ROOT / "mrts" / "kernel" / "c"
WARNINGS = ["-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Werror", "-fsyntax-only"]
PLANAR = {
    "MRTS_ROBOTS": "2",
    "MRTS_SIZE": "3",
    "MRTS_JOINTS": "6",
    "MRTS_WRENCHES": "6",
    "MRTS_INPUTS": "8",
    "MRTS_INPUT_SIZES": "{6, 6, 6, 9, 6, 6, 10, 51}",
    "MRTS_INPUT_NUMBERS": "100",
    "MRTS_GEOMETRY_NUMBERS": "51",
    "MRTS_UNKNOWNS": "4",
    "MRTS_MOST_JOINTS": "3",
    "MRTS_FIRST_JOINTS": "{0, 3, 6}",
    "MRTS_WRENCH_FORM": "wrench_form",
    "MRTS_KINEMATICS": "kinematics",
    "MRTS_BIAS_ACCELERATION": "bias_acceleration",
    "MRTS_WRENCH_FORM_LANES": "wrench_form_lanes",
    "MRTS_KINEMATICS_LANES": "kinematics_lanes",
    "MRTS_BIAS_ACCELERATION_LANES": "bias_acceleration_lanes",
}
EXPORTED = ("basis/kept_basis.c", "least_torques.c", "linear_programs.c", "quadratic_programs.c", "rows.c")
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
def test_a_file_can_be_checked_alone(file, compiler):
    check(compiler, file)
    check(compiler, file, *(f"-D{name}={value}" for name, value in PLANAR.items()))


@pytest.mark.parametrize("compiler", ["gcc", pytest.param("clang", marks=pytest.mark.slow)])
@pytest.mark.parametrize("file", EXPORTED)
def test_what_an_export_carries_is_also_float(file, compiler):
    check(compiler, file, "-DMRTS_REAL=float", "-DMRTS_SINGLE", "-Wdouble-promotion")


def test_headers_are_guarded():
    for path in C.rglob("*.h"):
        guard = f"MRTS_{path.stem.upper()}_H"
        assert f"#ifndef {guard}\n#define {guard}\n" in path.read_text(), path
