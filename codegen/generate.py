# SPDX-License-Identifier: MIT
"""From a cell file to C source and manifest: the one entry of build time."""

import hashlib
from collections.abc import Iterable
from pathlib import Path

import casadi as ca
from mrts_codegen.cell_model import CellModel, cell_manifest, read_cell_model
from mrts_codegen.generated_functions import BUILDERS, build_functions
from mrts_codegen.model_c import DOUBLE, function_record, model_c

from mrts.base.atomic_file import check_own, is_marked, text_writer, write_together
from mrts.base.manifest import CHAINS_NAME, MANIFEST_NAME, ChainsRecord
from mrts.cell.record import NOTICE, CellManifest


def generate_cell(path: Path) -> tuple[CellManifest, str, dict[str, ca.Function]]:
    """The manifest of a cell, the content of its C file, and its functions as CasADi has them, by short name."""
    cell = read_cell_model(path)
    chains, c_source, functions = generate_chains(cell, cell.record.name)
    return cell_manifest(cell, chains), c_source, functions


def generate_chains(
    cell: CellModel, stem: str, names: Iterable[str] = BUILDERS
) -> tuple[ChainsRecord, str, dict[str, ca.Function]]:
    """Functions of a cell: what they are, the content of their C file, and they as CasADi has them."""
    functions = build_functions(cell, stem, names=names)
    c_source = f"/* {NOTICE} */\n{DOUBLE}\n{model_c({one.name(): one for one in functions.values()})}"
    record = ChainsRecord(
        chains=cell.chains_key(stem),
        casadi_version=ca.CasadiMeta.version(),
        source=f"{stem}.c",
        source_sha256=hashlib.sha256(c_source.encode()).hexdigest(),
        functions={name: function_record(function.name(), function) for name, function in functions.items()},
    )
    return record, c_source, functions


def write_generated(folder: Path, record: ChainsRecord, c_source: str, *, private: bool = False) -> None:
    """Write the C file and, last, the record into `folder`, both or none.

    Raises:
        InputError: If a file would be lost that was not generated, or one cannot be written.
    """
    name = MANIFEST_NAME if isinstance(record, CellManifest) else CHAINS_NAME
    texts = {record.source: c_source, name: record.to_json()}
    for target, mark in zip(texts, (NOTICE, '"chains"'), strict=True):
        check_own(folder / target, own=private or is_marked(folder / target, mark))
    write_together({folder / name: text_writer(text) for name, text in texts.items()}, private=private)
