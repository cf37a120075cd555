"""Exported libraries: warnings, languages, sanitizers, symbols, the host, a Cortex-M7, and the ways to use them."""

import ctypes
import os
import re
import shutil
import subprocess
from functools import cache

import numpy as np
import pytest
from conftest import DATA, ROOT
from embedded_target import cross_compile, missing_tools, run_on_target
from exported_library import SANITIZED, WARNINGS, compiles_cleanly, link, run, sources, tool
from loaded_library import LoadedLibrary
from shipped_cells import changed_cell

import mrts
from mrts.cli import main

CELLS = ("dual_ur5", "with_motors")
DOUBLE_HELPER = re.compile(r"__aeabi_d|__\w+df\d|\b(sin|cos|sqrt|sincos)\b")
ALLOWED = {"memcpy", "memset", "memmove", "sin", "cos", "sincos", "sqrt", "sinf", "cosf", "sincosf", "sqrtf"}
OK, UNBOUNDED, INFEASIBLE, BAD_ARGUMENT = 0, 1, 2, 5
CONSTANT = ("ROW_TEXT", "texts")  # tables of pointers, which only the linker fills
CALLS = "range_of_sample", "equal_share_range"
DRIFT_FREE = ROOT / "generated" / "embedded" / "planar_dual_arm"

LIBRARIES = [(cell, precision) for cell in CELLS for precision in ("double", "float")]
SOME_LIBRARIES = [("with_motors", "double"), ("dual_ur5", "float")]
SOME = pytest.mark.parametrize("library", SOME_LIBRARIES, ids="-".join, indirect=True)
"""For what does not depend on the numbers in it: both precisions, motors and none, the plane and space."""


@pytest.fixture(scope="module")
def exports(tmp_path_factory):
    """The folder of a library by cell and precision, exported when it is first asked for."""

    @cache
    def exported(cell, precision):
        folder = tmp_path_factory.mktemp(f"{cell}_{precision}")
        path = changed_cell(folder, real_motors) if cell == "with_motors" else DATA.parent / cell / "cell.yaml"
        assert main(["export", str(path), "-o", str(folder / "library"), "--precision", precision]) == 0
        return folder / "library"

    return exported


@pytest.fixture(params=LIBRARIES, ids="-".join)
def library(request, exports):
    return *request.param, exports(*request.param)


def real_motors(cell):
    """Motors with everything that they may have, where friction decides."""
    cell["name"] = "with_motors"
    curves = [[[0, 100], [0.2, 100], [0.8, 30]], [[0, 80], [0.3, 80], [1.0, 10]], [[0, 50], [1.5, 20]]]
    friction = {"coulomb": [6, 5, 2], "viscous": [20, 20, 8]}
    for robot in cell["robots"]:
        robot["motors"] = {"armature": [0.5, 0.4, 0.1], "friction": friction, "torque_speed": curves}


@SOME
def test_it_compiles_without_a_warning_as_c_and_cpp(library, tmp_path):
    _, _, folder = library
    compiles_cleanly(folder, [*sources(folder), folder / "examples/main.c", folder / "tests/test_main.c"], tmp_path)


@pytest.mark.parametrize("flags", [["-O2"], pytest.param(SANITIZED, marks=pytest.mark.slow)], ids=["host", "sanitized"])
def test_the_vectors_pass_on_the_host_and_under_sanitizers(library, flags, tmp_path):
    _, precision, folder = library
    said = run(link(folder, folder / "tests/test_main.c", tmp_path / "test", *flags))
    found = re.findall(r"(\d+) (ok|unbounded|infeasible|undecided|vectors|mismatches)", said)
    counts = {what: number for number, what in found}
    assert int(counts["vectors"]) >= 500
    assert all(int(counts[status]) > 0 for status in ("ok", "unbounded", "infeasible"))
    assert int(counts["mismatches"]) == 0
    if precision == "double":
        assert int(counts["undecided"]) == 0


@SOME
def test_a_wrong_expectation_is_noticed(library, tmp_path):
    cell, _, folder = library
    spoiled = tmp_path / "tests"
    shutil.copytree(folder / "tests", spoiled)
    vectors = spoiled / f"{cell}_vectors.h"
    lines = vectors.read_text().splitlines()
    row = next(index for index, line in enumerate(lines) if line.startswith("    {{{") and ", 0, 0.0" in line)
    lines[row] = lines[row].replace(", 0, 0.0", ", 0, 10.0", 1)
    vectors.write_text("\n".join(lines))
    link(folder, spoiled / "test_main.c", tmp_path / "test")
    assert subprocess.run([tmp_path / "test"], capture_output=True, check=False).returncode != 0


@SOME
def test_its_symbols_are_its_own(library, tmp_path):
    cell, precision, folder = library
    for source in sources(folder):
        run(tool("gcc", "gcc"), "-std=c99", "-O2", f"-I{folder}/include", "-c", source, "-o", tmp_path / "o")
        symbols = [line.split() for line in run("nm", tmp_path / "o").splitlines()]
        wanted = {parts[-1] for parts in symbols if parts[-2] == "U"}
        defined = {parts[-1] for parts in symbols if parts[-2] in "TDBRC"}
        assert all(symbol.startswith(cell) for symbol in defined)
        assert {symbol for symbol in wanted if not symbol.startswith(cell)} <= ALLOWED
        writable = {parts[-1] for parts in symbols if parts[-2] in "dDbBC"}
        assert all(symbol.startswith(CONSTANT) for symbol in writable)
        if precision == "float":
            assert not any(DOUBLE_HELPER.search(symbol) for symbol in wanted)


@pytest.mark.slow
def test_the_vectors_pass_on_a_cortex_m7(library, tmp_path):
    cell, _, folder = library
    for package in missing_tools():
        assert "MRTS_ALL_TOOLS" not in os.environ, f"apt-get install {package}"
        pytest.skip(f"the Cortex-M7 tests need: apt-get install {package}")
    image = cross_compile(folder, folder / "tests" / "test_main.c", tmp_path / "image.elf")
    done = run_on_target(image)
    assert done.returncode == 0, done.stdout + done.stderr
    assert " 0 mismatches" in done.stdout
    assert cell


@pytest.mark.parametrize(
    "library", [SOME_LIBRARIES[0], pytest.param(SOME_LIBRARIES[1], marks=pytest.mark.slow)], ids="-".join, indirect=True
)
def test_out_of_tree_use_as_its_readme_says(library, tmp_path):
    cell, _, folder = library
    copy = tmp_path / "library"
    shutil.copytree(folder, copy)
    assert "0 mismatches" in run(tool("make", "make"), "test", cwd=copy)
    assert "ok: c^2 in" in run("make", "example", cwd=copy)
    cmake = tool("cmake", "cmake")
    run(cmake, "-B", "cmake-build", cwd=copy)
    run(cmake, "--build", "cmake-build", cwd=copy)
    run("ctest", "--test-dir", "cmake-build", "--output-on-failure", cwd=copy)
    run(cmake, "--install", "cmake-build", "--prefix", tmp_path / "installed", cwd=copy)
    settings = f"{cell}_settings s; {cell}_default_settings(&s); return (int){cell}_check_settings(&s);"
    program = f'#include "{cell}.h"\nint main(void) {{ {settings} }}\n'
    uses = {"subdirectory": f"add_subdirectory({copy} library)", "package": f"find_package({cell} REQUIRED)"}
    for name, line in uses.items():
        user = tmp_path / name
        user.mkdir()
        (user / "main.c").write_text(program)
        (user / "CMakeLists.txt").write_text(
            f"cmake_minimum_required(VERSION 3.13)\nproject(user C)\n{line}\nadd_executable(user main.c)\n"
            f"target_link_libraries(user PRIVATE {cell}::{cell})\n"
        )
        run(cmake, "-B", "build", f"-DCMAKE_PREFIX_PATH={tmp_path / 'installed'}", cwd=user)
        run(cmake, "--build", "build", cwd=user)
        run(user / "build" / "user")


def test_a_program_holds_what_it_calls_alone(exports, tmp_path):
    folder, name = exports("dual_ur5", "double"), "dual_ur5"
    asked = f"{name}_settings s; {name}_default_settings(&s); return (int){name}_check_settings(&s);"
    (tmp_path / "main.c").write_text(f'#include "{name}.h"\nint main(void) {{ {asked} }}\n')
    run(tool("make", "make"), "-C", folder)
    linked = tmp_path / "main.c", folder / f"build/lib{name}.a", "-lm", "-Wl,--gc-sections", "-o", tmp_path / "program"
    run(tool("gcc", "gcc"), f"-I{folder}/include", *linked)
    held = run("nm", tmp_path / "program")
    assert f"{name}_check_settings" in held
    assert f"{name}_torques" not in held
    assert f"{name}_model_" not in held


@pytest.mark.quick
def test_the_committed_export_is_current(tmp_path):
    assert main(["export", str(DATA / "cell.yaml"), "-o", str(tmp_path)]) == 0
    committed, fresh = (
        # the vectors hold rounding of the machine that makes them
        sorted(path.relative_to(top) for path in top.rglob("*") if path.is_file() and "_vectors.h" not in path.name)
        for top in (DRIFT_FREE, tmp_path)
    )
    assert committed == fresh
    for path in committed:
        assert (DRIFT_FREE / path).read_text() == (tmp_path / path).read_text(), f"{path}: run `make generate`"


@pytest.mark.parametrize("arms", [1, 2])
def test_misuse_is_a_status(arms, tmp_path):
    def fewer(cell):
        cell["robots"] = cell["robots"][:arms]
        if arms == 1:
            del cell["robots"][0]["wrench"]

    path, folder = changed_cell(tmp_path, fewer), tmp_path / "library"
    assert main(["export", str(path), "-o", str(folder), "--name", "my_cell"]) == 0
    assert "0 mismatches" in run("make", "test", cwd=folder)
    library = LoadedLibrary(folder, tmp_path)
    settings, rows = library.settings, library.sizes["ROWS"]
    sample = library.sample(mrts.follow_object(mrts.load_cell(path), mrts.load_motion(DATA / "lift.yaml")), 20)
    status, interval, _ = library.range(sample)
    assert status == OK
    asked = 100 * interval[0, 1], interval[0, 1] / 2, -1
    assert [library.torques(sample, c2)[0] for c2 in asked] == [INFEASIBLE, OK, BAD_ARGUMENT]
    ctypes.memset(library.workspace, 0x80, len(library.workspace))
    assert library.range(sample)[0] == OK
    for row, upper in ((row, upper) for row in range(rows) for upper in (-5, np.nan)):
        settings.lower[row], settings.upper[row] = 5, upper
        assert [library.range(sample, call)[0] for call in CALLS] == [BAD_ARGUMENT] * 2
        assert library.call("check_settings", settings) == BAD_ARGUMENT
        library.call("default_settings", settings)
    loads, found = (type(settings.load) * 1)(), library.Range()
    loads[0][0] = -1
    given = loads, 1, found, None, None, library.workspace
    assert library.call("guaranteed_range", sample, settings, *given) == BAD_ARGUMENT
    settings.lower[:], settings.upper[:] = [-1e300] * rows, [1e300] * rows
    assert library.range(sample)[0] == UNBOUNDED
    sample.ddq[0] = np.nan
    assert library.torques(sample, 1)[0] == library.range(sample)[0] == BAD_ARGUMENT


def test_text_from_a_urdf_cannot_leave_its_string(tmp_path):
    urdf = (DATA / "planar_arm.urdf").read_text()
    spoiled = urdf.replace('name="elbow"', 'name="el&quot;bow\\ */ %s ü ??/"')
    assert spoiled != urdf
    (tmp_path / "arm.urdf").write_text(spoiled)
    path = changed_cell(tmp_path, lambda cell: [robot.update(urdf="arm.urdf") for robot in cell["robots"]])
    folder = tmp_path / "library"
    assert main(["export", str(path), "-o", str(folder)]) == 0
    source = folder / "src/planar_dual_arm.c"
    run(tool("gcc", "gcc"), *WARNINGS, f"-I{folder}/include", "-c", source, "-o", tmp_path / "o")
    assert "el\\042bow\\134 \\052/" in (folder / "src/planar_dual_arm_tables.h").read_text()


def test_bad_exports_are_refused(tmp_path, capsys):
    cell, target = str(DATA / "cell.yaml"), ["-o", str(tmp_path / "x")]
    names = [("test", "is taken"), ("stdio", "is taken"), ("1x", "must be letters"), ("../x", "must be letters")]
    for arguments, words in (
        *((["export", cell, *target, "--name", name], words) for name, words in [*names, ("x" * 41, "at most 40")]),
        (["export", str(tmp_path), *target], "starts from the cell file"),
        (["export", str(tmp_path / "none.yaml"), *target], "there is no such cell file"),
    ):
        assert main(arguments) == 2
        assert words in capsys.readouterr().err
    assert not (tmp_path / "x").exists()
