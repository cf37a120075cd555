"""Exported libraries: warnings, languages, sanitizers, symbols, the host, a Cortex-M7, and the ways to use them."""

import os
import re
import shutil
import subprocess
from functools import cache

import pytest
import yaml
from conftest import DATA, ROOT
from embedded_target import cross_compile, missing_tools, run_on_target
from exported_library import SANITIZED, answers, changed_cell, link, run, sources, tool

import mrts
from mrts.cell.generation import export_to
from mrts.cli import main
from mrts.output.embedded_limits import embedded_limits

CELLS = ("dual_ur5", "with_motors")
WARNINGS = ["-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Wdouble-promotion", "-Werror"]
DOUBLE_HELPER = re.compile(r"__aeabi_d|__\w+df\d|\b(sin|cos|sqrt|sincos)\b")
FORBIDDEN = re.compile(r"\b(malloc|calloc|realloc|free|printf|puts|fprintf)\b")
ALLOWED = {"memcpy", "memset", "memmove", "sin", "cos", "sincos", "sqrt", "sinf", "cosf", "sincosf", "sqrtf"}
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


@pytest.mark.parametrize("compiler", [("gcc", "gcc"), ("clang", "clang")])
@SOME
def test_it_compiles_without_a_warning(library, compiler, tmp_path):
    _, _, folder = library
    command = [
        tool(*compiler),
        *WARNINGS,
        "-O2",
        f"-I{folder}/include",
        f"-I{folder}/tests",
        "-c",
        "-o",
        tmp_path / "o",
    ]
    for source in (*sources(folder), folder / "examples/main.c", folder / "tests/test_main.c"):
        run(*command, source)


@SOME
def test_it_compiles_as_cpp(library, tmp_path):
    _, _, folder = library
    for source in (*sources(folder), folder / "tests/test_main.c"):
        run(tool("g++", "g++"), "-std=c++17", "-x", "c++", "-Wall", "-Wextra", "-Werror", f"-I{folder}/include",
            f"-I{folder}/tests", "-c", source, "-o", tmp_path / "o")  # fmt: skip


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
    row = next(index for index, line in enumerate(lines) if line.startswith("    {{{") and ", 0, 0.0, " in line)
    lines[row] = lines[row].replace(", 0, 0.0, ", ", 0, 0.0, 1", 1)
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
        assert not any(FORBIDDEN.search(symbol) for symbol in wanted)
        assert not any(parts[-2] in "dDbBC" and parts[-1] != "ROW_TEXT" for parts in symbols), "writable data"
        if precision == "float":
            assert not any(DOUBLE_HELPER.search(symbol) for symbol in wanted)
    text = "".join(path.read_text() for path in (folder / "src").rglob("*.[ch]"))
    assert not FORBIDDEN.search(re.sub(r"/\*.*?\*/", "", text, flags=re.DOTALL))


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


@SOME
def test_exporting_twice_gives_the_same_bytes(library, tmp_path):
    cell, precision, folder = library
    path = folder.parent / "cell.yaml" if cell == "with_motors" else DATA.parent / cell / "cell.yaml"
    assert main(["export", str(path), "-o", str(tmp_path), "--precision", precision]) == 0
    files = sorted(path.relative_to(folder) for path in folder.rglob("*") if path.is_file())
    assert files == sorted(path.relative_to(tmp_path) for path in tmp_path.rglob("*") if path.is_file())
    for path in files:
        assert (folder / path).read_bytes() == (tmp_path / path).read_bytes(), path


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


@pytest.mark.parametrize("parts", ["terms", "range", "share", "torques"])
def test_parts_of_it_compile_alone(parts, tmp_path):
    assert main(["export", str(DATA / "cell.yaml"), "-o", str(tmp_path), "--functions", parts]) == 0
    for source in sources(tmp_path):
        run(tool("gcc", "gcc"), *WARNINGS, f"-I{tmp_path}/include", "-c", source, "-o", tmp_path / "o")
    run("make", cwd=tmp_path)
    assert not (tmp_path / "tests").exists()


def test_corners_of_a_load_variation_are_exported(tmp_path):
    cell = yaml.safe_load((DATA / "cell.yaml").read_text())
    cell["object"]["variation"] = {"mass": [0.2, 6.0]}
    for robot in cell["robots"]:
        robot["urdf"] = str(DATA / "planar_arm.urdf")
    path, folder = tmp_path / "cell.yaml", tmp_path / "library"
    path.write_text(yaml.safe_dump(cell))
    assert main(["export", str(path), "-o", str(folder), "--motion", str(DATA / "lift.yaml")]) == 0
    said = answers(
        folder,
        """
#include <stdio.h>
#include "planar_dual_arm.h"
#include "planar_dual_arm_vectors.h"
int main(void) {
    static planar_dual_arm_workspace w;
    planar_dual_arm_settings s;
    planar_dual_arm_range r;
    planar_dual_arm_horizon h;
    int low, high = -1, at = -1;
    planar_dual_arm_default_settings(&s);
    planar_dual_arm_horizon_start(&h);
    for (int k = 0; k < PLANAR_DUAL_ARM_PATH_SAMPLES; ++k) {
        planar_dual_arm_guaranteed_range(&planar_dual_arm_vectors[k].sample, &s, planar_dual_arm_load_corners,
                                         PLANAR_DUAL_ARM_CORNERS, &r, &low, &high, &w);
        planar_dual_arm_horizon_add(&h, &r);
        if (h.upper_sample == k) at = high;
    }
    printf("%d %.12g %d %ld %s\\n", (int)h.status, h.upper, at, h.upper_sample, planar_dual_arm_row_text(-5));
    return 0;
}
""",
        tmp_path,
    )
    status, upper, corner, sample, row = said.split(maxsplit=4)
    found = mrts.scale(mrts.load_cell(path), mrts.load_motion(DATA / "lift.yaml")).range
    assert (int(status), int(corner), int(sample)) == (0, 1, found.upper.sample)
    assert float(upper) == pytest.approx(found.upper.c2, rel=1e-9)
    assert row.strip() == "right/elbow torque"


MISUSE = """
#include <math.h>
#include <stdio.h>
#include <string.h>
#include "NAME.h"
#include "NAME_vectors.h"
#define SAY(what, status) printf("%s=%d\\n", what, (int)(status))
int main(void) {
    static NAME_workspace w;
    NAME_settings s, spoiled;
    NAME_range r;
    NAME_sample sample = NAME_vectors[20].sample;
    NAME_real torque[MACRO_JOINTS], wrench[MACRO_WRENCHES], none[1][MACRO_LOAD];
    NAME_default_settings(&s);
    memset(&w, 0x80, sizeof w);
    NAME_reset(&w);
    SAY("ok", NAME_range_of_sample(&sample, &s, &r, &w));
    SAY("beyond", NAME_torques(&sample, &s, 100 * r.upper, torque, wrench, &w));
    SAY("inside", NAME_torques(&sample, &s, r.upper / 2, torque, wrench, &w));
    SAY("negative", NAME_torques(&sample, &s, -1, torque, wrench, &w));
    memset(&w, 0x80, sizeof w);
    SAY("garbage", NAME_range_of_sample(&sample, &s, &r, &w));
    for (int i = 0; i < MACRO_ROWS; ++i) {
        spoiled = s;
        spoiled.lower[i] = 5;
        spoiled.upper[i] = -5;
        if (NAME_range_of_sample(&sample, &spoiled, &r, &w) != MACRO_BAD_ARGUMENT) SAY("reversed", i);
        spoiled.upper[i] = (NAME_real)NAN;
        if (NAME_equal_share_range(&sample, &spoiled, &r, &w) != MACRO_BAD_ARGUMENT) SAY("not a number", i);
        if (NAME_check_settings(&spoiled) != MACRO_BAD_ARGUMENT) SAY("unchecked", i);
    }
    spoiled = s;
    for (int i = 0; i < MACRO_ROWS; ++i) {
        spoiled.lower[i] = -MACRO_UNLIMITED;
        spoiled.upper[i] = MACRO_UNLIMITED;
    }
    SAY("unlimited", NAME_range_of_sample(&sample, &spoiled, &r, &w));
    memset(none, 0, sizeof none);
    none[0][0] = -1;
    SAY("load", NAME_guaranteed_range(&sample, &s, (const NAME_real(*)[MACRO_LOAD])none, 1, &r, 0, 0, &w));
    sample.ddq[0] = (NAME_real)NAN;
    SAY("nan", NAME_torques(&sample, &spoiled, 1, torque, wrench, &w));
    SAY("nan range", NAME_range_of_sample(&sample, &spoiled, &r, &w));
    return 0;
}
"""


@pytest.mark.parametrize(("arms", "precision"), [(1, "double"), (2, "float")])
def test_misuse_is_a_status(arms, precision, tmp_path):
    cell = yaml.safe_load((DATA / "cell.yaml").read_text())
    for robot in cell["robots"]:
        robot["urdf"] = str(DATA / "planar_arm.urdf")
    cell["robots"] = cell["robots"][:arms]
    if arms == 1:
        del cell["robots"][0]["wrench"]
    path, folder = tmp_path / "cell.yaml", tmp_path / "library"
    path.write_text(yaml.safe_dump(cell))
    command = ["export", str(path), "-o", str(folder), "--precision", precision, "--name", "my_cell"]
    assert main(command) == 0
    assert "0 mismatches" in run("make", "test", cwd=folder)
    text = answers(folder, MISUSE.replace("NAME", "my_cell").replace("MACRO", "MY_CELL"), tmp_path)
    said = dict(line.split("=") for line in text.splitlines())
    ok, unbounded, infeasible, bad = "0", "1", "2", "5"
    wanted = {"ok": ok, "beyond": infeasible, "inside": ok, "negative": bad, "garbage": ok, "unlimited": unbounded}
    assert said == wanted | {"load": bad, "nan": bad, "nan range": bad}


@pytest.mark.parametrize("precision", ["double", "float"])
def test_a_slow_motion_is_not_taken_for_rest(precision, tmp_path):
    slow = yaml.safe_load((DATA / "lift.yaml").read_text()) | {"duration": 600.0}
    (tmp_path / "slow.yaml").write_text(yaml.safe_dump(slow))
    command = ["export", str(DATA / "cell.yaml"), "-o", str(tmp_path / "x"), "--precision", precision]
    assert main([*command, "--motion", str(tmp_path / "slow.yaml")]) == 0
    assert "0 mismatches" in run("make", "test", cwd=tmp_path / "x")


def test_names_that_build_systems_use_are_refused(tmp_path, capsys):
    for name, words in (
        ("mrts", "is taken"),
        ("test", "is taken"),
        ("1x", "must be letters"),
        ("a/b", "must be letters"),
    ):
        assert main(["export", str(DATA / "cell.yaml"), "-o", str(tmp_path / "x"), "--name", name]) == 2
        assert words in capsys.readouterr().err
    assert not (tmp_path / "x").exists()


def test_an_export_leaves_the_files_of_others_wherever_it_stands(tmp_path):
    mine = tmp_path / "kernel" / "arm" / "src" / "driver.c"
    mine.parent.mkdir(parents=True)
    mine.write_text("/* SPDX-License-Identifier: MIT */\n", encoding="utf-8")
    assert main(["export", str(DATA / "cell.yaml"), "-o", str(mine.parents[1])]) == 0
    assert mine.is_file()


def test_a_smaller_export_leaves_nothing_of_a_larger_one(tmp_path):
    assert main(["export", str(DATA / "cell.yaml"), "-o", str(tmp_path)]) == 0
    assert main(["export", str(DATA / "cell.yaml"), "-o", str(tmp_path), "--functions", "range"]) == 0
    assert not [path for path in tmp_path.rglob("*.c") if path.parent.name in {"tests", "examples"}]
    assert "make test" not in (tmp_path / "README.md").read_text()
    assert not [path for path in (tmp_path / "src").rglob("*") if "share" in path.name or "quadratic" in path.name]


@SOME
def test_the_readme_tells_the_size_of_the_workspace(library, tmp_path):
    cell, _, folder = library
    told = re.search(rf"sizeof\({cell}_workspace\)` = (\d+)", (folder / "README.md").read_text()).group(1)
    says = f'printf("%u", (unsigned)sizeof({cell}_workspace));'
    (tmp_path / "main.c").write_text(f'#include <stdio.h>\n#include "{cell}.h"\nint main(void) {{ {says} }}\n')
    run(tool("gcc", "gcc"), f"-I{folder}/include", tmp_path / "main.c", "-o", tmp_path / "main")
    assert run(tmp_path / "main") == told


def test_text_from_a_urdf_cannot_leave_its_string(tmp_path):
    nasty = 'el"bow\\ */ #include "x" \n%s ü'
    urdf = (DATA / "planar_arm.urdf").read_text()
    spoiled = urdf.replace('name="elbow"', 'name="el&quot;bow\\ */ %s ü ??/"')
    assert spoiled != urdf
    (tmp_path / "arm.urdf").write_text(spoiled)
    cell = yaml.safe_load((DATA / "cell.yaml").read_text())
    for robot in cell["robots"]:
        robot["urdf"] = "arm.urdf"
    (tmp_path / "cell.yaml").write_text(yaml.safe_dump(cell))
    folder = tmp_path / "library"
    assert main(["export", str(tmp_path / "cell.yaml"), "-o", str(folder)]) == 0
    source = folder / "src/planar_dual_arm.c"
    run(tool("gcc", "gcc"), *WARNINGS, f"-I{folder}/include", "-c", source, "-o", tmp_path / "o")
    text = (folder / "src/planar_dual_arm_tables.h").read_text()
    assert "el\\042bow\\134 \\052/" in text
    assert nasty not in text


def test_all_parts_by_name_are_the_whole_library(tmp_path):
    named, all_parts = tmp_path / "named", tmp_path / "all"
    for folder, more in ((named, ["--functions", "terms,range,share,torques"]), (all_parts, [])):
        assert main(["export", str(DATA / "cell.yaml"), "-o", str(folder), *more]) == 0
    vectors = "tests/planar_dual_arm_vectors.h"
    assert (named / vectors).read_text() == (all_parts / vectors).read_text()


def test_bad_exports_are_refused(tmp_path, capsys, planar_cell):
    cell = DATA / "cell.yaml"
    for arguments, words in (
        (["export", str(cell), "-o", str(tmp_path / "x"), "--functions", "ranges"], "there are terms, range,"),
        (["export", str(tmp_path), "-o", str(tmp_path / "x")], "starts from the cell file"),
        (["export", str(tmp_path / "none.yaml"), "-o", str(tmp_path / "x")], "there is no such cell file"),
    ):
        assert main(arguments) == 2
        assert words in capsys.readouterr().err
    assert not (tmp_path / "x").exists()
    with pytest.raises(mrts.InputError, match="double or float"):
        export_to(cell, tmp_path / "x", limits=embedded_limits(planar_cell), vectors=[], path_samples=0,
                  precision="half", parts=())  # fmt: skip
