# SPDX-License-Identifier: MIT
"""Functions of cells: generated on first use, kept per user under a hash of their content, compiled and bound.

Here and nowhere else the run time calls the build time (`mrts_codegen`).
"""

import hashlib
from collections.abc import Callable, Iterable
from ctypes import CDLL, addressof, c_char, string_at
from dataclasses import dataclass, replace
from functools import cache, cached_property, partial
from importlib.util import find_spec
from pathlib import Path
from typing import Any, TypeVar

from mrts.base import version
from mrts.base.arrays import Array
from mrts.base.atomic_file import write_text_atomically
from mrts.base.errors import NEAREST_INERTIA, InputError
from mrts.base.formats.record import MadeAgain, read_json
from mrts.base.formats.urdf import Urdf
from mrts.base.input_file import FileReference, plain
from mrts.base.manifest import CHAINS_NAME, MANIFEST_NAME, OF_MOTION, ChainsRecord, check_source
from mrts.base.regular_file import is_folder, read_regular
from mrts.base.yaml_text import MAX_YAML_BYTES
from mrts.cell.record import CellManifest, CellRecord, read_generated, verified_manifest
from mrts.cell.robot import Robot
from mrts.kernel.c_text import (
    BATCH,
    CELL_FILES,
    IN_LANES,
    SELDOM,
    TRACKING,
    cell_source,
    function_source,
    motion_source,
    one_file,
)
from mrts.kernel.cache_folder import cache_folder, only_ours
from mrts.kernel.cell_library import CellLibrary
from mrts.kernel.compiler import compiled_library
from mrts.kernel.programs import opened_programs

MAKE_AGAIN = "Make C file and manifest again: `mrts generate`."

Read = TypeVar("Read")

CACHED_STEM = "cell"
"""Names of generated functions in the cache begin so: cells of other names share them."""

CELL_FILE = "cell.yaml"
"""What `mrts new` and `mrts demo` call a cell file."""


@dataclass(frozen=True, eq=False)
class GeneratedFunctions(MadeAgain):
    """What was generated of a cell; cells of other numbers share it.

    It pickles without an address: another process binds a library of its own, where it is used first.

    Attributes:
        manifest: What the functions are.
        origin: The generated C; of a saved result its path.
    """

    manifest: CellManifest
    origin: str | Path

    @property
    def compiled(self) -> CellLibrary | None:
        """The cell's library; None where a motion is only followed, before anything else is compiled."""
        return self.library if isinstance(self.origin, str) and "wrench_form" in self.manifest.functions else None

    @cached_property
    def library(self) -> CellLibrary:
        """The cell's library, compiled unless the cache holds it; of functions of the motion one that only follows.

        What follows is compiled by itself, in a fifth of the time, and is the same before and after the rest.
        """
        manifest, origin = self.manifest, self.origin
        if isinstance(origin, Path):
            raise InputError(
                origin,
                f"this takes the compiled functions of cell '{manifest.cell.name}', which a saved result does not "
                "hold: read it with mrts.load_result(path, cell=mrts.load_cell(CELL)).",
                key="functions",
            )

        def part(name: str) -> CDLL:
            if name == "cell":
                opened = compiled_library(manifest.source.removesuffix(".c"), cell_source(manifest, origin), CELL_FILES)
                opened_programs.setdefault(BATCH, opened)
                return _checked(manifest, opened, {*manifest.functions} - {*SELDOM, *OF_MOTION} | {*IN_LANES}, "_lanes")
            if name == "motion":
                opened = compiled_library("motion", motion_source(manifest, origin), (TRACKING,))
                return _checked(manifest, opened, manifest.functions.keys() & {*OF_MOTION})
            opened = compiled_library(manifest.functions[name].symbol, function_source(manifest, origin, name))
            return _checked(manifest, opened, [name])

        return CellLibrary(manifest, part)


def compiled_functions(manifest: CellManifest, source: Path) -> GeneratedFunctions:
    """Functions whose library is compiled unless the cache holds it."""
    functions = GeneratedFunctions(manifest, source.read_text(encoding="utf-8"))
    try:
        functions.library  # noqa: B018 (it is bound)
    except InputError as error:
        raise error.inside(source.with_name(MANIFEST_NAME)) from None
    return functions


def _checked(manifest: CellManifest, library: CDLL, functions: Iterable[str], of_lanes: str = "") -> CDLL:
    """A library whose functions take and give what the manifest says: C reads and writes where it is told to."""
    for name in functions:
        record = manifest.functions[name]
        try:
            compiled = c_char.in_dll(library, f"{record.symbol}{of_lanes}_signature")
        except ValueError:
            raise InputError("", f"the C file holds no such function. {MAKE_AGAIN}", key=f"functions.{name}") from None
        if string_at(addressof(compiled)) != record.signature.encode():
            raise InputError("", f"the compiled function has other shapes. {MAKE_AGAIN}", key=f"functions.{name}")
    return library


def generated_in_cache(path: Path) -> tuple[CellManifest, Path]:
    """Manifest and C file of a cell, made unless the cache holds them.

    All cells with the same chains share one C file, whatever the numbers in their cell files.
    """
    described = _described(path)
    if made := _as_made(path, described):
        return made
    manifest, source = generated_chains(cell_model(path))
    if _described(path) == described and is_as_made(path, manifest.cell):  # else a file was written meanwhile
        write_text_atomically(described, manifest.to_json(), private=True)
    return manifest, source


def _as_made(path: Path, described: Path) -> tuple[CellManifest, Path] | None:
    """What the cache holds of a cell file; None unless the files it names are as then, and the C file is whole."""
    manifest = _if_sound(described, partial(verified_manifest, described))
    if manifest is None or not is_as_made(path, manifest.cell):
        return None
    source = _chains_folder(manifest.chains) / manifest.source
    return (manifest, source) if _is_source(source, manifest) else None


def described_model(description: object, folder: Path, where: str = "cell description") -> Any:
    """A cell that a dictionary describes, with its URDFs."""
    from mrts_codegen.cell_model import build_cell_model  # noqa: PLC0415

    from mrts.cell.cell_file import CellDescription  # noqa: PLC0415 (build time, on demand)

    given = CellDescription.read(where, plain(where, description), "cell file")
    return build_cell_model(Path(where), given, folder)


def generated_chains(cell: Any) -> tuple[CellManifest, Path]:
    """Manifest and C file of a cell with its URDFs: what is generated of its chains is cached."""
    from mrts_codegen.cell_model import cell_manifest  # noqa: PLC0415 (build time, on demand)

    folder, chains = _chains_in_cache(cell)
    if chains is None:
        from mrts_codegen.generate import generate_chains, write_generated  # noqa: PLC0415 (the symbolic layer, only if it is needed)

        chains, c_source, _ = generate_chains(cell, CACHED_STEM)
        write_generated(folder, chains, c_source, private=True)
    return cell_manifest(cell, chains), folder / chains.source


def _chains_in_cache(cell: Any) -> tuple[Path, ChainsRecord | None]:
    """Where the cache keeps what is generated of a cell's chains, and its record; None unless it is there and whole."""
    folder = _chains_folder(cell.chains_key(CACHED_STEM))
    chains = _if_sound(folder / CHAINS_NAME, lambda text: ChainsRecord.model_validate(read_json(text)))
    return folder, chains if chains is not None and _is_source(folder / chains.source, chains) else None


def _chains_folder(key: str) -> Path:
    return cache_folder("chains", key, emitter_key())


def _described(path: Path) -> Path:
    """Where the cache keeps the manifest of a cell file, which is the same while its text and what reads it are."""
    text = read_regular(path, "cell file", MAX_YAML_BYTES)
    return cache_folder("cells", hashlib.sha256(emitter_key().encode() + text).hexdigest()) / MANIFEST_NAME


def is_as_made(path: Path, record: CellRecord) -> bool:
    """Whether the files that a cell file names hold what the record of a cell was made from."""
    folder = path.resolve().parent
    sources = [robot.source for robot in record.robots]
    known = [(FileReference(source.urdf), source.sha256) for source in sources]
    known += [(FileReference(one.joint_limits[0]), one.joint_limits[1]) for one in sources if one.joint_limits]
    known += [(FileReference(file, what="mesh"), surface.sha256) for file, surface in record.surfaces.items()]
    try:
        return all(reference.sha256(path, folder) == made for reference, made in known)
    except InputError:
        return False


@cache
def emitter_key() -> str:
    """Hash of what reads cells and emits functions: our own files and CasADi's version."""
    base = Path(version.__file__).parent
    shaping = [*base.rglob("*.py"), *base.with_name("cell").glob("*.py")]
    folder = _package_folder("mrts_codegen")
    ours = [source for source in folder.rglob("*.py") if source.parent.name != "embedded"]
    casadi = sorted(path.name for path in _package_folder("casadi").parent.glob("casadi-*"))  # with its version
    digest = hashlib.sha256("\n".join([*casadi, version.__version__]).encode())
    for source in sorted([*ours, *shaping]):
        digest.update(source.read_bytes())
    return digest.hexdigest()


def _package_folder(name: str) -> Path:
    found = find_spec(name)
    if found is None or found.origin is None:
        raise InputError(name, "is not installed: pip install mrts.")
    return Path(found.origin).parent


def generate_to(path: Path, folder: Path | None) -> tuple[CellManifest, Path]:
    """Generate a cell and keep it.

    Returns:
        The manifest and the path of the C file.
    """
    if folder is None:
        return generated_in_cache(path)
    from mrts_codegen.generate import generate_cell, write_generated  # noqa: PLC0415 (build time, on demand)

    manifest, c_source, _ = generate_cell(path)
    write_generated(folder, manifest, c_source)
    return read_generated(folder)


def export_to(path: Path, folder: Path, *, name: str | None = None, **asked: Any) -> list[str]:
    """Export a cell as a self-contained C library.

    Args:
        path: The cell file.
        folder: For the library.
        name: Prefix of every name in the library; None is the cell's.
        **asked: What else `export_library` there takes.

    Returns:
        The files, relative to the folder.
    """
    from mrts_codegen.embedded.export_library import export_library, write_library  # noqa: PLC0415 (build time, on demand)
    from mrts_codegen.generated_functions import build_functions  # noqa: PLC0415

    cell = cell_model(path)
    record = cell.record if name is None else replace(cell.record, name=name)
    functions = build_functions(cell, CACHED_STEM, bake=True)
    texts = export_library(record, functions, kernel=one_file, **asked)
    write_library(folder, texts)
    return sorted(texts)


def cell_model(path: Path) -> Any:
    """A cell with its URDFs."""
    from mrts_codegen.cell_model import read_cell_model  # noqa: PLC0415 (build time, on demand)

    return read_cell_model(path)


def motion_functions_of(cell: Any) -> GeneratedFunctions:
    """The functions of a cell that the motion of its joints takes, compiled when something follows."""
    from mrts_codegen.cell_model import cell_manifest  # noqa: PLC0415 (build time, on demand)
    from mrts_codegen.generate import generate_chains  # noqa: PLC0415

    chains, c_source, _ = generate_chains(cell, CACHED_STEM, OF_MOTION)
    return GeneratedFunctions(cell_manifest(cell, chains), c_source)


def read_to_generate(path: Path) -> Any | None:
    """A cell with its URDFs that is still to be generated and compiled; None where the cache holds it."""
    if _as_made(path, _described(path)):
        return None
    cell = cell_model(path)
    return cell if _chains_in_cache(cell)[1] is None else None


def _if_sound(path: Path, read: Callable[[str], Read]) -> Read | None:
    """What a file of the cache says; None unless it is ours, and whole."""
    try:
        return read(path.read_text(encoding="utf-8")) if only_ours(path) else None
    except (InputError, ValueError):
        return None


def _is_source(path: Path, chains: ChainsRecord) -> bool:
    return _if_sound(path, partial(check_source, path, chains)) is not None


def is_generated(path: Path) -> bool:
    """Whether a path is that of a generated cell, and not of a cell file."""
    if is_folder(path) and not (path / MANIFEST_NAME).exists():
        inside = path / CELL_FILE
        named = f"the cell file in it: {inside}" if inside.exists() else "a cell file"
        raise InputError(
            path, f"is a folder without {MANIFEST_NAME}, so `mrts generate` did not write it; name {named}."
        )
    return is_folder(path) or path.name == MANIFEST_NAME


def urdf_of(robot: Robot, folder: Path) -> Path:
    """The URDF of an arm of a cell whose files are relative to a folder."""
    return FileReference(robot.source.urdf).path(folder / CELL_FILE, folder)


def read_urdf(where: Path, folder: Path, urdf: str) -> tuple[Path, Urdf]:
    """Path, links and joints of a URDF, which is named relative to a folder, or in a package."""
    from mrts_codegen.urdf.urdf_file import parse_urdf  # noqa: PLC0415 (build time, on demand)

    reference = FileReference(urdf, key="")
    path = reference.path(where, folder)
    return path, parse_urdf(path, reference.content(where, folder))


def arm_of_urdf(path: Path, urdf: Urdf, base_link: str | None, tip_link: str) -> tuple[Robot, Array]:
    """The arm from a base link, None for the root, to a tip link, and centres of mass of its joints' bodies."""
    from mrts_codegen.urdf.robot_model import arm_chain  # noqa: PLC0415 (build time, on demand)

    return arm_chain(path, urdf, base_link, tip_link)


def chain_of(cell: CellRecord, robot: Robot, folder: Path) -> Any:
    """The chain of an arm of a cell, with the masses that its functions were generated with; files are in a folder.

    Raises:
        InputError: If its URDF is not there as it was.
    """
    from mrts_codegen.urdf.robot_model import build_robot_model  # noqa: PLC0415 (build time, on demand)

    where, source = folder / CELL_FILE, robot.source
    path, urdf = read_urdf(where, folder, source.urdf)
    if FileReference(source.urdf).sha256(where, folder) != source.sha256:
        raise InputError(path, "is another file than the cell was made from. Read the cell again.")
    lenient = any(remark.code == NEAREST_INERTIA for remark in cell.remarks)
    return build_robot_model(path, urdf, source.base_link, source.tip_link, robot.held, lenient=lenient)


def read_without_generating(path: Path) -> tuple[Any, tuple[InputError, ...]]:
    """A cell with its URDFs (None if something is wrong), and all that is wrong."""
    from mrts_codegen.cell_model import read_cell  # noqa: PLC0415 (build time, on demand)

    return read_cell(path)
