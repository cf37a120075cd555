# SPDX-License-Identifier: MIT
"""Cells generated on first use, kept per user under a hash of their content.

This is the only place where the run time calls the build time (`mrts_codegen`).
"""

import hashlib
from collections.abc import Callable, Mapping
from functools import cache, lru_cache, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

from mrts.base.atomic_file import write_text_atomically
from mrts.base.errors import InputError
from mrts.base.formats.package_uri import is_xacro
from mrts.base.manifest import (
    CHAINS_NAME,
    MANIFEST_NAME,
    ChainsRecord,
    Manifest,
    read_generated,
    verified_manifest,
)
from mrts.cell.sound_files import if_sound, is_source
from mrts.kernel.c_text import one_file
from mrts.kernel.cache_folder import cache_folder, only_ours

if TYPE_CHECKING:
    from mrts.base.embedded_inputs import EmbeddedLimits, EmbeddedVector
    from mrts.base.formats.urdf_tree import Survey, UrdfTree
    from mrts.motors.joint_source import JointSource

CACHED_STEM = "cell"
"""Names of generated functions in the cache begin so: cells of other names share them."""


def generated_in_cache(path: Path) -> tuple[Manifest, Path]:
    """Manifest and C file of a cell, made unless the cache holds them.

    All cells with the same chains share one C file, whatever the numbers in their cell files.

    Args:
        path: The cell file.

    Raises:
        InputError: If the cell file or a URDF breaks a rule.
    """
    from mrts_codegen.content_key import is_as_made, text_key  # noqa: PLC0415 (build time, on demand)

    text = text_key(path)
    described = cache_folder("cells", text) / MANIFEST_NAME
    manifest = if_sound(described, partial(verified_manifest, described))
    if manifest is not None and is_as_made(path, manifest):
        source = _source_in_cache(manifest)
        if is_source(source, manifest):
            return manifest, source
    key = _content_key(path)
    manifest = _manifest(_model(path, key), partial(_chains, path, key))
    if (text_key(path), _content_key(path)) == (text, key):
        write_text_atomically(described, manifest.to_json(), private=True)
    else:  # a file was written meanwhile: what was read may be another cell than the keys say
        _forget()
    return manifest, _source_in_cache(manifest)


def _content_key(path: Path) -> str:
    """Hash of all that a generated cell depends on.

    Raises:
        InputError: If the cell file breaks a rule or a URDF is missing.
    """
    from mrts_codegen.cell_file import read_cell_description  # noqa: PLC0415 (build time, on demand)
    from mrts_codegen.content_key import content_key  # noqa: PLC0415

    return content_key(path, read_cell_description(path).references)


def described_in_cache(description: object, folder: Path) -> tuple[Manifest, Path, Callable[[], dict[str, Any]]]:
    """Manifest of a cell that a dictionary describes, its C file, and what gives CasADi's functions; chains are cached.

    Args:
        description: Keys of a cell file.
        folder: That URDFs are relative to, absolute.

    Raises:
        InputError: If the description or a URDF breaks a rule.
    """
    from mrts_codegen.cell_file import DESCRIBED, cell_description  # noqa: PLC0415 (build time, on demand)
    from mrts_codegen.cell_model import build_cell_model  # noqa: PLC0415

    cell = build_cell_model(DESCRIBED, cell_description(description), folder)

    @cache
    def chains() -> Any:
        return _generate_chains(cell)

    manifest = _manifest(cell, chains)
    return manifest, _source_in_cache(manifest), lambda: dict(chains().functions)


def _manifest(cell: Any, generate: Callable[[], Any]) -> Manifest:
    """The manifest of a cell, its C file in the cache.

    Args:
        cell: With its URDFs.
        generate: Its functions, if the cache lacks them.
    """
    from mrts_codegen.cell_manifest import cell_manifest  # noqa: PLC0415 (build time, on demand)
    from mrts_codegen.content_key import chains_key  # noqa: PLC0415

    folder = _chains_folder(chains_key(cell, CACHED_STEM, bake=False))
    chains = if_sound(folder / CHAINS_NAME, ChainsRecord.model_validate_json)
    if chains is None or not is_source(folder / chains.source, chains):
        made = generate()
        made.write(folder, private=True)
        chains = made.record
    return cell_manifest(cell, chains)


def _source_in_cache(manifest: Manifest) -> Path:
    return _chains_folder(manifest.chains) / manifest.source


def _chains_folder(key: str) -> Path:
    """What was generated for chains, by this version of the emitter."""
    from mrts_codegen.content_key import emitter_key  # noqa: PLC0415 (build time, on demand)

    return cache_folder("chains", key, emitter_key())


def generate_to(path: Path, folder: Path | None, *, bake: bool = False) -> tuple[Manifest, Path]:
    """Generate a cell and keep it.

    Args:
        path: The cell file.
        folder: Where to write the C file and manifest.json; None is the cache.
        bake: Whether gravity, bases, grasps and held joints are folded into the C; needs a folder.

    Returns:
        The manifest and the path of the C file.

    Raises:
        InputError: If the cell file or a URDF breaks a rule, or the folder cannot be written.
    """
    if folder is None:
        return generated_in_cache(path)
    from mrts_codegen.generate import generate_cell  # noqa: PLC0415 (build time, on demand)

    generate_cell(path, bake=bake).write(folder)
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
) -> list[str]:
    """Export a cell as a self-contained C library.

    Args:
        path: The cell file.
        folder: For the library.
        limits: What the cell must keep.
        vectors: Its test vectors.
        path_samples: The first so many of them are one motion with the nominal load.
        precision: "double" or "float".
        parts: Of `mrts_codegen.embedded.parts.PARTS`; none at all is all.
        name: Prefix of every name in the library; None is the cell's.

    Returns:
        The files, relative to the folder.

    Raises:
        InputError: If the cell file breaks a rule, a part does not exist, or the folder cannot be written.
    """
    from mrts_codegen.embedded.export_library import export_library, write_library  # noqa: PLC0415 (build time, on demand)
    from mrts_codegen.embedded.parts import PARTS  # noqa: PLC0415
    from mrts_codegen.generate import generate_cell  # noqa: PLC0415

    cell = generate_cell(path, bake=True)
    texts = export_library(
        cell.record if name is None else cell.record.model_copy(update={"name": name}),
        cell.functions,
        limits=limits,
        vectors=vectors,
        path_samples=path_samples,
        kernel=one_file,
        precision=precision,
        parts=parts or PARTS,
    )
    write_library(folder, texts)
    return sorted(texts)


def comes_with_tests(parts: tuple[str, ...]) -> bool:
    """Whether an exported library of these parts has tests and an example, and so wants vectors: one of all parts.

    Args:
        parts: As in `export_to`.
    """
    from mrts_codegen.embedded.parts import is_whole  # noqa: PLC0415 (build time, on demand)

    return not parts or is_whole(parts)


class NamedFiles(NamedTuple):
    """Where the files are that a cell file names: URDFs or xacros of its robots in their order, mesh of its object."""

    urdfs: tuple[Path, ...]
    mesh: Path | None


def named_files(path: Path) -> NamedFiles:
    """Where the files are that a cell file names.

    Args:
        path: The cell file.

    Raises:
        InputError: If the cell file breaks a rule or a package is missing.
    """
    from mrts_codegen.cell_file import read_cell_description  # noqa: PLC0415 (build time, on demand)

    description = read_cell_description(path)
    found = [reference.path(path, path.resolve().parent) for reference in description.references]
    robots = len(description.robots)
    return NamedFiles(tuple(found[:robots]), next(iter(found[robots:]), None))


def urdf_files(path: Path) -> dict[str, tuple[Path, str | None]]:
    """URDF and base link (None is its root) of every robot of a cell file, by name; of a xacro a URDF in the cache.

    Args:
        path: The cell file.

    Raises:
        InputError: If the cell file breaks a rule, a package is missing, or a xacro cannot be expanded.
    """
    from mrts_codegen.cell_file import read_cell_description  # noqa: PLC0415 (build time, on demand)

    folder, found, description = path.resolve().parent, {}, read_cell_description(path)
    for robot, reference in zip(description.robots, description.urdf_references, strict=True):
        file = reference.path(path, folder)
        if is_xacro(file):
            from mrts_codegen.urdf.xacro_file import with_found_meshes  # noqa: PLC0415 (only for xacros)

            text = with_found_meshes(file, reference.content(path, folder)).decode()
            file = cache_folder("urdfs", hashlib.sha256(text.encode()).hexdigest()) / f"{robot.name}.urdf"
            write_text_atomically(file, text, private=True)
        found[robot.name] = file, robot.base_link
    return found


def surveyed_urdf(where: Path, folder: Path, urdf: str, args: Mapping[str, str]) -> "tuple[Path, UrdfTree, Survey]":
    """Path of a URDF, what is in it, and what gives its chain from a base link (None is its root) to a tip link.

    Args:
        where: What names it, for messages.
        folder: That it is relative to, absolute.
        urdf: As in a cell file.
        args: Of a xacro, by name.

    Raises:
        InputError: If it is missing, or no URDF; the survey, if there is no such chain, or it breaks a rule of cells.
    """
    from mrts_codegen.urdf.urdf_file import parse_urdf  # noqa: PLC0415 (build time, on demand)
    from mrts_codegen.urdf.urdf_survey import arm_chain, urdf_tree  # noqa: PLC0415
    from mrts_codegen.urdf_reference import FileReference  # noqa: PLC0415

    reference = FileReference(urdf, args, key="")
    path = reference.path(where, folder)
    read = parse_urdf(path, reference.content(where, folder))
    return path, urdf_tree(path, read), partial(arm_chain, path, read)


def cell_file_in(manifest: Manifest, folder: Path, beside: Path | None) -> str:
    """Text of a cell file that reads back to the cell of a manifest.

    Args:
        manifest: Of the cell as it is now.
        folder: That its URDFs are relative to, absolute.
        beside: Folder for the file; None for one that stands anywhere.

    Raises:
        InputError: If a cell file cannot hold the cell, or a URDF is not there as it was.
    """
    from mrts_codegen.written_cell import cell_file_text  # noqa: PLC0415 (build time, on demand)

    text: str = cell_file_text(manifest, folder, beside)
    return text


def all_cell_keys(path: Path) -> dict[str, Any]:
    """Keys and values of a cell file, with the default of each key that it leaves out, None where there is none.

    Args:
        path: The cell file.

    Raises:
        InputError: If the cell file breaks a rule.
    """
    from mrts_codegen.cell_file import read_cell_description  # noqa: PLC0415 (build time, on demand)

    return read_cell_description(path).model_dump()


def virtual_machine_functions(path: Path) -> dict[str, Any]:
    """The functions of a cell file for CasADi's virtual machine, by short name.

    Raises:
        InputError: If the cell file or a URDF breaks a rule.
    """
    functions: dict[str, Any] = _chains(path, _content_key(path)).functions
    _forget()
    return functions


def _forget() -> None:
    """Let go of what was read and generated last."""
    _chains.cache_clear()
    _model.cache_clear()


@lru_cache(maxsize=1)
def _model(path: Path, _key: str) -> Any:
    """A cell with its URDFs, read from files of this content."""
    from mrts_codegen.cell_manifest import read_cell_model  # noqa: PLC0415 (build time, on demand)

    return read_cell_model(path)


@lru_cache(maxsize=1)
def _chains(path: Path, key: str) -> Any:
    """Functions generated from files of this content, kept until the virtual machine takes them: that takes seconds."""
    return _generate_chains(_model(path, key))


def _generate_chains(cell: Any) -> Any:
    from mrts_codegen.generate import generate_chains  # noqa: PLC0415 (the symbolic layer, only if it is needed)

    return generate_chains(cell, CACHED_STEM)


def read_without_generating(path: Path) -> "tuple[Any, tuple[InputError, ...], tuple[JointSource, ...]]":
    """A cell with its URDFs (None if something is wrong), all that is wrong, and where what is known of joints is from.

    Args:
        path: The cell file.
    """
    from mrts_codegen.cell_reading import read_cell  # noqa: PLC0415 (build time, on demand)

    found = read_cell(path)
    return found.model, found.mistakes, found.joints


def arms_alone_of(cell: Any) -> tuple[Any, ...]:
    """A cell of each arm by itself.

    Args:
        cell: With its URDFs, as from `read_without_generating`.
    """
    from mrts_codegen.cell_reading import arms_alone  # noqa: PLC0415 (build time, on demand)

    return tuple(arms_alone(cell))


def motion_functions_of(cell: Any) -> tuple[Manifest, dict[str, Any]]:
    """Functions of the motion of a cell's joints for CasADi's virtual machine, and the manifest: nothing is compiled.

    Args:
        cell: With its URDFs, as from `read_without_generating`.
    """
    from mrts_codegen.generate import motion_functions  # noqa: PLC0415 (build time, on demand)

    manifest, functions = motion_functions(cell, CACHED_STEM)
    return manifest, functions


def read_to_generate(path: Path) -> Any | None:
    """A cell with its URDFs that is still to be generated and compiled; None where the cache holds it.

    Args:
        path: The cell file.

    Raises:
        InputError: If the cell file or a URDF breaks a rule.
    """
    from mrts_codegen.content_key import chains_key, text_key  # noqa: PLC0415 (build time, on demand)

    if only_ours(cache_folder("cells", text_key(path)) / MANIFEST_NAME):
        return None
    cell = _model(path, _content_key(path))
    folder = _chains_folder(chains_key(cell, CACHED_STEM, bake=False))
    return None if only_ours(folder / CHAINS_NAME) else cell
