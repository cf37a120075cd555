"""Exported libraries as a user compiles them."""

import os
import shutil
import subprocess

import pytest

WARNINGS = ("-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Wdouble-promotion", "-Werror")
SANITIZED = ("-g1", "-fsanitize=address,undefined", "-fno-sanitize-recover=all")


def tool(name, package):
    """Path of a tool; without it the test fails where all are promised, and is skipped with advice elsewhere."""
    found = shutil.which(name)
    if found is None:
        assert "MRTS_ALL_TOOLS" not in os.environ, f"apt-get install {package}"
        pytest.skip(f"needs {name}: apt-get install {package}")
    return found


def run(*command, **options):
    """What a command prints; it must succeed."""
    done = subprocess.run([*map(str, command)], capture_output=True, text=True, check=False, **options)
    assert done.returncode == 0, f"{' '.join(map(str, command))}\n{done.stdout[-2000:]}\n{done.stderr[-2000:]}"
    return done.stdout


def sources(folder):
    """C files of a library."""
    return sorted((folder / "src").glob("*.c"))


def compiles_cleanly(folder, programs, place, headers=(), flags=()):
    """C files compile without a warning, as C with both compilers, and they or headers of a library as C++."""
    places = [f"-I{folder}/include", f"-I{folder}/tests", *flags, "-o", place / "o", "-c"]
    for source in programs:
        for compiler in ("gcc", "clang"):
            run(tool(compiler, compiler), *WARNINGS, "-O2", *places, source)
    for source in headers or programs:
        run(tool("g++", "g++"), "-std=c++17", "-x", "c++", "-Wall", "-Wextra", "-Werror", *places, source)


def link(folder, main, program, *flags):
    """Compile a main program with a library."""
    given = [*sources(folder), main, "-lm"]
    run(tool("gcc", "gcc"), "-std=c99", *flags, f"-I{folder}/include", f"-I{folder}/tests", *given, "-o", program)
    return program
