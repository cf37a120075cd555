# SPDX-License-Identifier: MIT
"""Cells generated on first use, kept per user under a hash of their content.

Here and in `source_files.py` beside it, and nowhere else, the run time calls the build time (`mrts_codegen`).
"""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, TypeVar

from mrts.base.atomic_file import write_text_atomically
from mrts.base.errors import InputError
from mrts.base.formats.record import read_json
from mrts.base.manifest import CHAINS_NAME, MANIFEST_NAME, ChainsRecord, check_source
from mrts.cell.record import CellManifest, read_generated, verified_manifest
from mrts.kernel.c_text import one_file
from mrts.kernel.cache_folder import cache_folder, only_ours

if TYPE_CHECKING:
    from mrts.base.embedded_inputs import EmbeddedLimits, EmbeddedPlan, EmbeddedVector

Record = TypeVar("Record", bound=ChainsRecord)

CACHED_STEM = "cell"
"""Names of generated functions in the cache begin so: cells of other names share them."""


def generated_in_cache(path: Path) -> tuple[CellManifest, Path]:
    """Manifest and C file of a cell, made unless the cache holds them.

    All cells with the same chains share one C file, whatever the numbers in their cell files.
    """
    from mrts_codegen.content_key import is_as_made, text_key  # noqa: PLC0415 (build time, on demand)

    text = text_key(path)
    described = cache_folder("cells", text) / MANIFEST_NAME
    manifest = _manifest_as_made(path, described)
    if manifest is None:
        manifest = _manifest(cell_model(path))
        if text_key(path) == text and is_as_made(path, manifest.cell):  # else a file was written meanwhile
            write_text_atomically(described, manifest.to_json(), private=True)
    return manifest, _source_in_cache(manifest)


def _manifest_as_made(path: Path, described: Path) -> CellManifest | None:
    """The manifest of a cell file in the cache; None unless the files it names are as then, and its C file is whole."""
    from mrts_codegen.content_key import is_as_made  # noqa: PLC0415 (build time, on demand)

    manifest = _if_sound(described, partial(verified_manifest, described))
    if manifest is None or not is_as_made(path, manifest.cell):
        return None
    return manifest if _is_source(_source_in_cache(manifest), manifest) else None


def described_in_cache(model: Any) -> tuple[CellManifest, Path]:
    """Manifest and C file of a cell from `described_model`; chains are cached."""
    manifest = _manifest(model)
    return manifest, _source_in_cache(manifest)


def described_model(description: object, folder: Path, where: str = "cell description") -> Any:
    """A cell that a dictionary describes, with its URDFs."""
    from mrts_codegen.cell_model import build_cell_model  # noqa: PLC0415

    from mrts.cell.cell_file import cell_description  # noqa: PLC0415 (build time, on demand)

    return build_cell_model(Path(where), cell_description(description, where), folder)


def _manifest(cell: Any) -> CellManifest:
    from mrts_codegen.cell_model import cell_manifest  # noqa: PLC0415 (build time, on demand)

    folder, chains = _chains_in_cache(cell)
    if chains is None:
        from mrts_codegen.generate import generate_chains  # noqa: PLC0415 (the symbolic layer, only if it is needed)

        made = generate_chains(cell, CACHED_STEM)
        made.write(folder, private=True)
        chains = made.record
    return cell_manifest(cell, chains)


def _chains_in_cache(cell: Any) -> tuple[Path, ChainsRecord | None]:
    """Where the cache keeps what is generated of a cell's chains, and its record; None unless it is there and whole."""
    from mrts_codegen.content_key import chains_key  # noqa: PLC0415 (build time, on demand)

    folder = _chains_folder(chains_key(cell, CACHED_STEM))
    chains = _if_sound(folder / CHAINS_NAME, lambda text: ChainsRecord.model_validate(read_json(text)))
    return folder, chains if chains is not None and _is_source(folder / chains.source, chains) else None


def _source_in_cache(manifest: CellManifest) -> Path:
    return _chains_folder(manifest.chains) / manifest.source


def _chains_folder(key: str) -> Path:
    from mrts_codegen.content_key import emitter_key  # noqa: PLC0415 (build time, on demand)

    return cache_folder("chains", key, emitter_key())


def generate_to(path: Path, folder: Path | None) -> tuple[CellManifest, Path]:
    """Generate a cell and keep it.

    Returns:
        The manifest and the path of the C file.
    """
    if folder is None:
        return generated_in_cache(path)
    from mrts_codegen.generate import generate_cell  # noqa: PLC0415 (build time, on demand)

    generate_cell(path).write(folder)
    return read_generated(folder)


def export_to(
    path: Path,
    folder: Path,
    *,
    limits: "EmbeddedLimits",
    vectors: list["EmbeddedVector"],
    path_samples: int,
    precision: Literal["double", "float"],
    parts: tuple[str, ...],
    name: str | None = None,
    plan: "EmbeddedPlan | None" = None,
) -> list[str]:
    """Export a cell as a self-contained C library.

    Args:
        path: The cell file.
        folder: For the library.
        limits: What the cell must keep.
        vectors: Its test vectors.
        path_samples: The first so many of them are one motion with the nominal load.
        precision: "double" or "float".
        parts: Of `mrts_codegen.embedded.export_library.PARTS`; none at all is all.
        name: Prefix of every name in the library; None is the cell's.
        plan: What the library plays at any speed.

    Returns:
        The files, relative to the folder.
    """
    from mrts_codegen.embedded.export_library import (  # noqa: PLC0415 (build time, on demand)
        OVERRIDE,
        PARTS,
        export_library,
        write_library,
    )
    from mrts_codegen.function_registry import build_functions  # noqa: PLC0415

    cell = cell_model(path)
    texts = export_library(
        cell.record if name is None else replace(cell.record, name=name),
        build_functions(cell, CACHED_STEM, bake=True),
        limits=limits,
        vectors=vectors,
        path_samples=path_samples,
        kernel=one_file,
        precision=precision,
        parts=parts or (PARTS if plan is None else (*PARTS, OVERRIDE)),
        plan=plan,
    )
    write_library(folder, texts)
    return sorted(texts)


def comes_with_tests(parts: tuple[str, ...]) -> bool:
    """Whether an exported library of these parts has tests and an example, and so wants vectors: one of all parts."""
    from mrts_codegen.embedded.export_library import is_whole  # noqa: PLC0415 (build time, on demand)

    return not parts or is_whole(parts)


def emitted(functions: dict[str, Any]) -> str:
    """The C text of CasADi's functions by short name."""
    from mrts_codegen.generate import emit_c  # noqa: PLC0415 (build time, on demand)

    text: str = emit_c(functions)
    return text


def cell_model(path: Path) -> Any:
    """A cell with its URDFs."""
    from mrts_codegen.cell_model import read_cell_model  # noqa: PLC0415 (build time, on demand)

    return read_cell_model(path)


def motion_functions_of(cell: Any) -> tuple[CellManifest, dict[str, Any]]:
    """CasADi's functions of the motion of a cell's joints, and the manifest: nothing is compiled."""
    from mrts_codegen.generate import motion_functions  # noqa: PLC0415 (build time, on demand)

    manifest, functions = motion_functions(cell, CACHED_STEM)
    return manifest, functions


def read_to_generate(path: Path) -> Any | None:
    """A cell with its URDFs that is still to be generated and compiled; None where the cache holds it."""
    from mrts_codegen.content_key import text_key  # noqa: PLC0415 (build time, on demand)

    if _manifest_as_made(path, cache_folder("cells", text_key(path)) / MANIFEST_NAME) is not None:
        return None
    cell = cell_model(path)
    return cell if _chains_in_cache(cell)[1] is None else None


def _if_sound(path: Path, read: Callable[[str], Record]) -> Record | None:
    """What a file of the cache holds; None where it is missing or damaged."""
    try:
        return read(path.read_text(encoding="utf-8")) if only_ours(path) else None
    except (InputError, ValueError):
        return None


def _is_source(path: Path, chains: ChainsRecord) -> bool:
    if not only_ours(path):
        return False
    try:
        check_source(path, chains, path.read_text(encoding="utf-8"))
    except (InputError, ValueError):
        return False
    return True
