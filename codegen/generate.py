# SPDX-License-Identifier: MIT
"""From a cell file to C source and manifest: the one entry of build time."""

import hashlib
from dataclasses import dataclass
from pathlib import Path
from typing import Generic, TypeVar

import casadi as ca
from mrts_codegen.cell_model import CellModel, cell_manifest, read_cell_model
from mrts_codegen.function_registry import build_functions
from mrts_codegen.model_c import DOUBLE, function_record, model_c

from mrts.base.atomic_file import check_own, is_marked, text_writer, write_together
from mrts.base.manifest import CHAINS_NAME, MANIFEST_NAME, OF_MOTION, ChainsRecord
from mrts.cell.record import NOTICE, CellManifest

Record = TypeVar("Record", bound=ChainsRecord)


@dataclass(frozen=True)
class Generated(Generic[Record]):
    """What generation yields.

    Attributes:
        record: What the functions are: those of chains alone, or of a whole cell.
        c_source: The content of the C file.
        functions: The same functions as CasADi has them, by short name.
    """

    record: Record
    c_source: str
    functions: dict[str, ca.Function]

    def write(self, folder: Path, *, private: bool = False) -> None:
        """Write the C file and, last, the record into `folder`, both or none.

        Raises:
            InputError: If a file would be lost that was not generated, or one cannot be written.
        """
        name = MANIFEST_NAME if isinstance(self.record, CellManifest) else CHAINS_NAME
        texts = {self.record.source: self.c_source, name: self.record.to_json()}
        for target, mark in zip(texts, (NOTICE, '"chains"'), strict=True):
            check_own(folder / target, own=private or is_marked(folder / target, mark))
        write_together({folder / name: text_writer(text) for name, text in texts.items()}, private=private)


def generate_cell(path: Path) -> Generated[CellManifest]:
    """Generate a cell."""
    cell = read_cell_model(path)
    chains = generate_chains(cell, cell.record.name)
    return Generated(cell_manifest(cell, chains.record), chains.c_source, chains.functions)


def generate_chains(cell: CellModel, stem: str) -> Generated[ChainsRecord]:
    """Generate the functions of a cell."""
    functions = build_functions(cell, stem)
    c_source = emit_c(functions)
    return Generated(_chains(cell, stem, functions, c_source), c_source, functions)


def motion_functions(cell: CellModel, stem: str) -> tuple[CellManifest, dict[str, ca.Function]]:
    """The functions of a cell that the motion of its joints takes, and its manifest: nothing is emitted."""
    functions = build_functions(cell, stem, names=OF_MOTION)
    return cell_manifest(cell, _chains(cell, stem, functions, "")), functions


def _chains(cell: CellModel, stem: str, functions: dict[str, ca.Function], c_source: str) -> ChainsRecord:
    return ChainsRecord(
        chains=cell.chains_key(stem),
        casadi_version=ca.CasadiMeta.version(),
        source=f"{stem}.c",
        source_sha256=hashlib.sha256(c_source.encode()).hexdigest(),
        functions={name: function_record(function.name(), function) for name, function in functions.items()},
    )


def emit_c(functions: dict[str, ca.Function]) -> str:
    """The C text of functions by short name, for doubles."""
    return f"/* {NOTICE} */\n{DOUBLE}\n{model_c({one.name(): one for one in functions.values()})}"
