# SPDX-License-Identifier: MIT
"""The generated functions of a cell, bound once, called for all samples of a motion at once."""

import logging
from collections.abc import Callable
from functools import cached_property, partial
from pathlib import Path
from typing import Any, Literal, Self

import numpy as np

from mrts.base.arrays import Array
from mrts.base.errors import CompilerError, InputError
from mrts.base.manifest import GEOMETRY, MANIFEST_NAME, FunctionRecord, Manifest, check_source, verified_manifest
from mrts.cell.robot import Robot, robot_from_record
from mrts.kernel.c_text import cell_source
from mrts.kernel.cell_library import CellLibrary
from mrts.kernel.compiled_cache import library_or_rebuilt
from mrts.kernel.compiler import find_compiler
from mrts.kernel.function_shapes import check_shapes

Backend = Literal["auto", "compiled", "vm"]
logger = logging.getLogger("mrts")


class CellFunctions:
    """Callable by short name; see the manifest for inputs, outputs and shapes.

    They pickle as what they are bound from, never as an address: another process binds a library of its own.

    Args:
        manifest: What was generated.
        evaluate: Evaluates one of its functions: short name, number of samples, inputs by name to outputs by name.
        backend: What evaluates them; "none" refuses to.
        origin: What they are bound from: the generated C text, CasADi's functions by short name, or a saved result.
        compiled: The cell's library, if there is one.
    """

    def __init__(
        self,
        manifest: Manifest,
        evaluate: Callable[[str, int, dict[str, Array]], dict[str, Array]],
        backend: Literal["compiled", "vm", "none"],
        origin: str | dict[str, Any] | Path,
        compiled: CellLibrary | None = None,
    ) -> None:
        self.manifest = manifest
        self.backend = backend
        self.compiled = compiled
        self._geometry: Array | None = None
        self._evaluate = evaluate
        self._origin = origin

    @cached_property
    def robots(self) -> tuple[Robot, ...]:
        """The robots that the functions were generated for."""
        return tuple(robot_from_record(record) for record in self.manifest.robots)

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
        if self._geometry is not None:
            inputs = {GEOMETRY: self._geometry} | inputs
        return self._evaluate(name, samples, inputs)

    @property
    def symbolic(self) -> dict[str, Any]:
        """CasADi's functions by short name, to build programs of; only those of the backend "vm" have them."""
        if not isinstance(self._origin, dict):
            raise InputError("backend", "must be 'vm': compiled functions have no expressions.", value=self.backend)
        return self._origin

    def placed(self, geometry: Array) -> Self:
        """The same functions for a cell of this geometry, Shape (3 + 24 n + h,)."""
        ours = object.__new__(type(self))  # a copy would bind them again
        vars(ours).update(vars(self) | {"_geometry": geometry})
        return ours

    def __reduce__(self) -> tuple[Any, ...]:
        return _bound_again, (self.manifest.to_json(), self.backend, self._origin)

    def __deepcopy__(self, _memo: dict[int, Any]) -> Self:
        return self  # nothing of them changes


def bind_functions(
    manifest: Manifest,
    source: Path,
    backend: Backend,
    virtual_machine: Callable[[], dict[str, Any]] | None,
) -> CellFunctions:
    """Compile and bind the generated C; without a compiler, fall back to CasADi's virtual machine.

    Args:
        manifest: Manifest of the cell.
        source: Its C file.
        backend: "compiled" insists on a compiler, "vm" on the virtual machine, "auto" prefers the compiler.
        virtual_machine: Builds the functions from the cell file; None if only generated files are there.

    Raises:
        CompilerError: If the compiler fails, or none is there and nothing else can evaluate the C.
        InputError: If the C file is not the one that the manifest describes.
    """
    command = None if backend == "vm" else find_compiler()
    if command is not None:
        where = source.with_name(MANIFEST_NAME)
        return _compiled_functions(where, manifest, command, source.read_text(encoding="utf-8"))
    if backend == "compiled" or virtual_machine is None:
        raise CompilerError(
            f"no C compiler was found to compile {source.name}. Install one (Debian: apt-get install gcc libc6-dev), "
            "set CC, or take the cell file instead of its generated folder: it can run without a compiler."
        )
    if backend == "auto":
        logger.warning("no C compiler found: running in CasADi's virtual machine, about 20 times slower")
    return machine_functions(manifest, virtual_machine())


class _VirtualMachine:
    """CasADi Functions, mapped over all samples."""

    def __init__(self, records: dict[str, FunctionRecord], functions: dict[str, Any]) -> None:
        self._records, self._functions = records, functions
        self._maps: dict[tuple[str, int], Any] = {}

    def __call__(self, name: str, samples: int, inputs: dict[str, Array]) -> dict[str, Array]:
        import casadi as ca  # noqa: PLC0415 (the compiled path does without)

        record = self._records[name]
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


def saved_functions(manifest: Manifest, path: Path) -> CellFunctions:
    """What stands for the functions of a cell that was read from a saved result: it says what is missing.

    Args:
        manifest: Manifest of the cell.
        path: The saved result.
    """

    def refuse(name: str, _samples: int, _inputs: dict[str, Array]) -> dict[str, Array]:
        raise InputError(
            path,
            f"this takes the compiled functions of cell '{manifest.name}', which a saved result does not hold: read it "
            "with mrts.load_result(path, cell=mrts.load_cell(CELL)).",
            key=f"function '{name}'",
        )

    return CellFunctions(manifest, refuse, "none", path)


def _compiled_functions(
    where: Path | str, manifest: Manifest, command: tuple[str, ...], generated: str
) -> CellFunctions:
    text = cell_source(manifest, generated)
    compiled = library_or_rebuilt(command, manifest.source.removesuffix(".c"), text, partial(CellLibrary, manifest))
    check_shapes(where, manifest, compiled.opened)
    return CellFunctions(manifest, compiled.map, "compiled", generated, compiled)


def machine_functions(manifest: Manifest, functions: dict[str, Any]) -> CellFunctions:
    """CasADi's functions in its virtual machine.

    Args:
        manifest: Of their cell.
        functions: By short name.
    """
    return CellFunctions(manifest, _VirtualMachine(manifest.functions, functions), "vm", functions)


def _bound_again(manifest_text: str, backend: str, origin: Any) -> CellFunctions:
    """The functions of a pickle: what it holds is checked as `read_generated` does, and compiled unless it is cached.

    Where the C cannot be compiled, using the functions says so: what raises while a worker unpickles its task ends it.

    Raises:
        InputError: If this mrts reads another format, or manifest and C do not belong together.
    """
    where = "pickled cell"
    manifest = verified_manifest(where, manifest_text)
    if backend == "none":
        return saved_functions(manifest, origin)
    if backend == "vm":
        return machine_functions(manifest, origin)
    check_source(where, manifest, origin)
    command = find_compiler()
    problem = (
        f"the pickled cell '{manifest.name}' has to be compiled, but no C compiler was found. Install one (Debian: "
        'apt-get install gcc libc6-dev), set CC, or pickle what mrts.load_cell(path, backend="vm") gives.'
    )
    try:
        if command is not None:
            return _compiled_functions(where, manifest, command, origin)
    except CompilerError as error:
        problem = str(error)

    def refuse(_name: str, _samples: int, _inputs: dict[str, Array]) -> dict[str, Array]:
        raise CompilerError(problem)

    return CellFunctions(manifest, refuse, "compiled", origin)
