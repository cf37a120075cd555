# SPDX-License-Identifier: MIT
"""All files of a cell's library."""

from collections.abc import Callable, Sequence
from pathlib import Path

import casadi as ca
from mrts_codegen.embedded.c_literals import WIDTH, Precision
from mrts_codegen.embedded.export_name import check_library_name
from mrts_codegen.embedded.motor_words import motor_words
from mrts_codegen.embedded.parts import (
    DECLARATIONS,
    KERNEL_FILES,
    LIBRARY_PARTS,
    MODEL_FUNCTIONS,
    OF_MOTORS,
    PARTS,
    check_parts,
    chosen,
    is_whole,
)
from mrts_codegen.embedded.template import filled
from mrts_codegen.embedded.template_words import NOTICE, cell_words, memory_words
from mrts_codegen.embedded.vector_rows import vector_words
from mrts_codegen.model_c import model_c

from mrts.base.atomic_file import text_writer, write_together
from mrts.base.embedded_inputs import EmbeddedLimits, EmbeddedVector
from mrts.base.errors import InputError
from mrts.cell.record import CellManifest

GENERATED = ("include/*.h", "src/*.[ch]", "src/parts/*.c", "tests/*.[ch]", "examples/*.c")
"""Where an export writes files that start with its notice."""

LONGEST_START = 100
"""Bytes of a file among which the notice stands."""


def export_library(
    manifest: CellManifest,
    functions: dict[str, ca.Function],
    *,
    limits: EmbeddedLimits,
    vectors: Sequence[EmbeddedVector],
    path_samples: int,
    kernel: Callable[[str], str],
    precision: Precision = "double",
    parts: Sequence[str] = PARTS,
) -> dict[str, str]:
    """Texts of all files of the library, by path inside its folder.

    Args:
        manifest: CellManifest of the cell; its name is that of the library.
        functions: Its generated functions, as CasADi has them.
        limits: What the cell must keep.
        vectors: Test vectors.
        path_samples: The first so many of them are one motion with the nominal load.
        kernel: The text of a file of mrts/kernel/c by its name.
        precision: "double" or "float".
        parts: Of `PARTS`.

    Raises:
        InputError: If a part or the precision does not exist, the name cannot be taken, or a function holds an
            operation that no C is known of.
    """
    check_parts(parts)
    if precision not in WIDTH:
        raise InputError("--precision", "must be double or float.", value=precision)
    check_library_name(manifest.name)
    name, with_tests = manifest.name, is_whole(parts)
    model = {f"{name}_model_{short}": functions[short] for short in chosen(MODEL_FUNCTIONS, parts)}
    motors = limits.motors is not None
    carried, own = (chosen(table, parts, motors=motors) for table in (KERNEL_FILES, LIBRARY_PARTS))
    included = [*(f"kernel/{file}" for file in carried if file.endswith(".c")), *(f"parts/{file}" for file in own)]
    words = (
        cell_words(manifest, limits, precision)
        | memory_words(manifest, limits, precision)
        | vector_words(vectors, path_samples, precision, macro=name.upper(), motors=limits.motors)
        | {
            "MODEL": model_c(model),
            "MODEL_PROTOTYPES": "".join(
                f"void {symbol}(const {name}_real *const *arg, {name}_real *const *res);\n" for symbol in model
            ),
            "MODEL_SUFFIX": "##f" if precision == "float" else "",
            "LINKAGE": "static" if with_tests else "static inline",  # of which some may be unused
            "INCLUDES": "\n".join(f'#include "{file}"' for file in included),
        }
    )
    words |= motor_words(limits, words, precision)
    words["DECLARATIONS"] = "\n".join(filled(f"include/{file}", words) for file in chosen(DECLARATIONS, parts))
    for word, template in (("MAKE_TESTS", "tests.mk"), ("CMAKE_TESTS", "tests.cmake"), ("README_TESTS", "tests.md")):
        words[word] = filled(f"project/{template}", words) if with_tests else ""
    texts = {f"include/{name}.h": filled("include/library.h", words)}
    for file in ("model.c", "model.h", "config.h"):
        texts[f"src/{name}_{file}"] = filled(f"src/{file}", words)
    texts[f"src/{name}.c"] = filled("src/library.c", words)
    texts |= {
        f"src/parts/{file}": filled(f"{'motors' if file in OF_MOTORS else 'parts'}/{file}", words) for file in own
    }
    texts |= {f"src/kernel/{file}": kernel(file) for file in carried}
    if with_tests:
        texts["examples/main.c"] = filled("tests/example.c", words)
        texts["tests/test_main.c"] = filled("tests/test_main.c", words)
        texts[f"tests/{name}_vectors.h"] = filled("tests/vectors.h", words)
    words |= _file_words(list(texts))
    return texts | {file: filled(f"project/{file}", words) for file in ("Makefile", "CMakeLists.txt", "README.md")}


def write_library(folder: Path, texts: dict[str, str]) -> None:
    """Write all files of a library, or none; what an earlier export has left beside them goes.

    Raises:
        InputError: If the folder cannot be written.
    """
    write_together({folder / target: text_writer(text) for target, text in texts.items()})
    ours = {path for pattern in GENERATED for path in folder.glob(pattern) if _is_generated(path)}
    ours |= {folder / f"src/kernel/{file}" for file in KERNEL_FILES}
    for left in ours - {folder / target for target in texts}:
        left.unlink(missing_ok=True)


def _is_generated(path: Path) -> bool:
    """Whether a file starts with our notice; what cannot be read is not ours."""
    try:
        with path.open("rb") as file:
            return NOTICE.encode() in file.read(LONGEST_START)
    except OSError:
        return False


def _file_words(files: list[str]) -> dict[str, str]:
    """Lists of files for the build."""
    compiled = [file for file in files if Path(file).parent == Path("src") and file.endswith(".c")]
    needed = [file for file in files if Path(file).parts[0] in {"include", "src"} and file not in compiled]
    return {
        "SOURCES": " ".join(compiled),
        "OBJECTS": " ".join(f"build/{Path(file).stem}.o" for file in compiled),
        "HEADERS": " \\\n  ".join(needed),
    }
