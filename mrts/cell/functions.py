# SPDX-License-Identifier: MIT
"""The generated functions of a cell, bound once, called for all samples of a motion at once."""

from collections.abc import Iterable
from ctypes import CDLL, addressof, c_char, string_at
from functools import cache, cached_property, partial
from pathlib import Path
from typing import Any, Self

from mrts.base.arrays import Array
from mrts.base.errors import InputError
from mrts.base.manifest import GEOMETRY, MANIFEST_NAME
from mrts.cell.record import CellManifest, verified_manifest
from mrts.kernel.c_text import (
    CELL_FILES,
    IN_LANES,
    SELDOM,
    TRACKING_FILES,
    cell_source,
    function_source,
    motion_source,
)
from mrts.kernel.cell_library import CellLibrary
from mrts.kernel.compiler import compiled_library
from mrts.kernel.programs import offer_programs

MAKE_AGAIN = "Make C file and manifest again: `mrts generate`."


class CellFunctions:
    """Callable by short name; see the manifest for inputs, outputs and shapes.

    They pickle as what they are bound from, never as an address: another process binds a library of its own.

    Args:
        manifest: What they are.
        origin: The generated C; of a saved result its path.

    Attributes:
        bind: Gives the library, which may be compiled then, or raises why there is none; cells of other numbers share
            it.
    """

    def __init__(self, manifest: CellManifest, origin: str | Path) -> None:
        self.manifest, self.origin = manifest, origin
        self.bind = cache(partial(_bound, manifest, origin))
        self._geometry: Array | None = None

    def __call__(self, name: str, samples: int, inputs: dict[str, Array]) -> dict[str, Array]:
        """Evaluate one function for all samples in one call.

        Args:
            name: Short name, such as "terms".
            samples: Number of samples N.
            inputs: By input name, Shape (N, rows), (N, rows, columns), or (rows,) for one value for all samples; the
                geometry is that of the cell unless it is given.

        Returns:
            By output name, Shape (N, rows, columns); (N, rows) for a column.
        """
        if self._geometry is not None:
            inputs = {GEOMETRY: self._geometry} | inputs
        return self.library.map(name, samples, inputs)

    @property
    def compiled(self) -> CellLibrary | None:
        """The cell's library; None where a motion is only followed, before anything is compiled."""
        return self.library if isinstance(self.origin, str) and "terms" in self.manifest.functions else None

    @cached_property
    def library(self) -> CellLibrary:
        """The cell's library; of functions of the motion alone one that follows, and does nothing else."""
        return self.bind()

    def placed(self, geometry: Array) -> Self:
        """The same functions for a cell of this geometry, Shape (3 + 24 n + h,)."""
        ours = object.__new__(type(self))  # a copy would bind them again
        vars(ours).update(vars(self) | {"_geometry": geometry})
        return ours

    def __reduce__(self) -> tuple[Any, ...]:
        return _bound_again, (self.manifest.to_json(), self.origin)

    def __deepcopy__(self, _memo: dict[int, Any]) -> Self:
        return self  # nothing of them changes


def compiled_functions(manifest: CellManifest, source: Path) -> CellFunctions:
    """The functions of a library that is compiled unless the cache holds it."""
    functions = CellFunctions(manifest, source.read_text(encoding="utf-8"))
    try:
        functions.bind()
    except InputError as error:
        raise error.inside(source.with_name(MANIFEST_NAME)) from None
    return functions


def _bound(manifest: CellManifest, origin: str | Path) -> CellLibrary:
    if isinstance(origin, Path):
        raise InputError(
            origin,
            f"this takes the compiled functions of cell '{manifest.cell.name}', which a saved result does not hold: "
            "read it with mrts.load_result(path, cell=mrts.load_cell(CELL)).",
            key="functions",
        )
    if "terms" not in manifest.functions:  # a library of following alone is compiled in a tenth of the time
        return CellLibrary(manifest, compiled_library("motion", motion_source(manifest, origin), TRACKING_FILES))

    @cache
    def seldom(name: str) -> CDLL:
        symbol = manifest.functions[name].symbol
        return _checked(manifest, compiled_library(symbol, function_source(origin, symbol)), [name])

    library = compiled_library(manifest.source.removesuffix(".c"), cell_source(manifest, origin), CELL_FILES)
    offer_programs(library)
    return CellLibrary(manifest, _checked(manifest, library, manifest.functions.keys() - {*SELDOM}), seldom)


def _checked(manifest: CellManifest, library: CDLL, functions: Iterable[str]) -> CDLL:
    """A library whose functions take and give what the manifest says: C reads and writes where it is told to."""
    for name in functions:
        record = manifest.functions[name]
        try:
            compiled = c_char.in_dll(library, f"{record.symbol}{'_lanes' * (name in IN_LANES)}_signature")
        except ValueError:
            raise InputError("", f"the C file holds no such function. {MAKE_AGAIN}", key=f"functions.{name}") from None
        if string_at(addressof(compiled)) != record.signature.encode():
            raise InputError("", f"the compiled function has other shapes. {MAKE_AGAIN}", key=f"functions.{name}")
    return library


def _bound_again(manifest_text: str, origin: str | Path) -> CellFunctions:
    """The functions of a pickle, compiled when they are used: what raises while a worker unpickles its task ends it."""
    return CellFunctions(verified_manifest("pickled cell", manifest_text), origin)
