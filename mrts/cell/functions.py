# SPDX-License-Identifier: MIT
"""The generated functions of a cell, bound once, called for all samples of a motion at once."""

from functools import cached_property, partial
from pathlib import Path
from typing import Any, Self

import numpy as np

from mrts.base.arrays import Array
from mrts.base.errors import CompilerError, InputError, MrtsError
from mrts.base.manifest import GEOMETRY, MANIFEST_NAME, check_source
from mrts.cell.generation import emitted
from mrts.cell.record import CellManifest, verified_manifest
from mrts.kernel.c_text import cell_source, motion_source
from mrts.kernel.cell_library import CellLibrary, MotionLibrary
from mrts.kernel.compiler import find_compiler, library_or_rebuilt
from mrts.kernel.function_shapes import check_shapes


class CellFunctions:
    """Callable by short name; see the manifest for inputs, outputs and shapes.

    They pickle as what they are bound from, never as an address: another process binds a library of its own.
    """

    def __init__(
        self,
        manifest: CellManifest,
        bound: "CellLibrary | CasadiFunctions | MrtsError",
        origin: str | dict[str, Any] | Path,
    ) -> None:
        self.manifest = manifest
        self.bound = bound
        self.origin = origin
        self._geometry: Array | None = None

    def __contains__(self, name: str) -> bool:
        return name in self.manifest.functions

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
        if isinstance(self.bound, MrtsError):
            raise self.bound.with_traceback(None)
        if self._geometry is not None:
            inputs = {GEOMETRY: self._geometry} | inputs
        return self.bound.map(name, samples, inputs)

    @property
    def compiled(self) -> CellLibrary | None:
        """The cell's library; None where a motion is only followed, before anything is compiled."""
        return self.bound if isinstance(self.bound, CellLibrary) else None

    @property
    def library(self) -> CellLibrary:
        """The cell's library."""
        if isinstance(self.bound, CellLibrary):
            return self.bound
        if isinstance(self.bound, MrtsError):
            raise self.bound.with_traceback(None)
        raise CompilerError(f"cell '{self.manifest.name}' is not compiled: load it with mrts.load_cell.")

    @property
    def motion_library(self) -> MotionLibrary:
        """What follows: the cell's library, or, where nothing else was compiled, one that does only that."""
        return self.bound.library if isinstance(self.bound, CasadiFunctions) else self.library

    def placed(self, geometry: Array) -> Self:
        """The same functions for a cell of this geometry, Shape (3 + 24 n + h,)."""
        ours = object.__new__(type(self))  # a copy would bind them again
        vars(ours).update(vars(self) | {"_geometry": geometry})
        return ours

    def __reduce__(self) -> tuple[Any, ...]:
        return _bound_again, (self.manifest.to_json(), self.origin)

    def __deepcopy__(self, _memo: dict[int, Any]) -> Self:
        return self  # nothing of them changes


class CasadiFunctions:
    """CasADi's functions, mapped over all samples: what evaluates a cell before it is compiled."""

    def __init__(self, manifest: CellManifest, functions: dict[str, Any]) -> None:
        self._manifest, self._functions = manifest, functions
        self._maps: dict[tuple[str, int], Any] = {}

    @cached_property
    def library(self) -> MotionLibrary:
        """A library of those that following takes, compiled with the first motion, in a tenth of the time."""
        text = motion_source(self._manifest, emitted(self._functions))
        return library_or_rebuilt(find_compiler(), "motion", text, partial(MotionLibrary, self._manifest))

    def map(self, name: str, samples: int, inputs: dict[str, Array]) -> dict[str, Array]:
        """Evaluate a function at all samples; see `CellFunctions`."""
        import casadi as ca  # noqa: PLC0415 (a compiled cell does without)

        record = self._manifest.functions[name]
        function = self._maps.get((name, samples))
        if function is None:
            function = self._maps[name, samples] = self._functions[name].map(samples)
        arguments = []
        for argument in record.inputs:
            rows, columns = argument.shape
            value = np.asarray(inputs[argument.name], dtype=float)
            if value.shape == (rows,):
                value = np.broadcast_to(value, (samples, rows))
            stacked = value.reshape(samples, rows, columns).transpose(1, 0, 2)
            arguments.append(stacked.reshape(rows, samples * columns))
        results = function.call([ca.DM(argument) for argument in arguments])
        outputs = {}
        for argument, result in zip(record.outputs, results, strict=True):
            rows, columns = argument.shape
            value = result.full().reshape(rows, samples, columns).transpose(1, 0, 2)
            outputs[argument.name] = np.ascontiguousarray(value[:, :, 0] if columns == 1 else value)
        return outputs


def compiled_functions(manifest: CellManifest, source: Path) -> CellFunctions:
    """The functions of a library that is compiled unless the cache holds it."""
    return _compiled(source.with_name(MANIFEST_NAME), manifest, source.read_text(encoding="utf-8"))


def _compiled(where: Path | str, manifest: CellManifest, generated: str) -> CellFunctions:
    text, name = cell_source(manifest, generated), manifest.source.removesuffix(".c")
    library = library_or_rebuilt(find_compiler(), name, text, partial(CellLibrary, manifest))
    check_shapes(where, manifest, library.opened)
    return CellFunctions(manifest, library, generated)


def uncompiled_functions(manifest: CellManifest, functions: dict[str, Any]) -> CellFunctions:
    """CasADi's functions."""
    return CellFunctions(manifest, CasadiFunctions(manifest, functions), functions)


def saved_functions(manifest: CellManifest, path: Path) -> CellFunctions:
    """What stands for the functions of a cell that was read from a saved result: it says what is missing."""
    missing = InputError(
        path,
        f"this takes the compiled functions of cell '{manifest.name}', which a saved result does not hold: read it "
        "with mrts.load_result(path, cell=mrts.load_cell(CELL)).",
        key="functions",
    )
    return CellFunctions(manifest, missing, path)


def _bound_again(manifest_text: str, origin: str | dict[str, Any] | Path) -> CellFunctions:
    """The functions of a pickle: what it holds is checked as `read_generated` does, and compiled unless it is cached.

    Where the C cannot be compiled, using the functions says so: what raises while a worker unpickles its task ends it.
    """
    where = "pickled cell"
    manifest = verified_manifest(where, manifest_text)
    if isinstance(origin, Path):
        return saved_functions(manifest, origin)
    if isinstance(origin, dict):
        return uncompiled_functions(manifest, origin)
    check_source(where, manifest, origin)
    try:
        return _compiled(where, manifest, origin)
    except CompilerError as error:
        return CellFunctions(manifest, error, origin)
