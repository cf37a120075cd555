"""Cells whose functions CasADi evaluates itself: generated, and not compiled, which takes seconds."""

from mrts_codegen.generate import generate_cell

from mrts.cell.functions import uncompiled_functions
from mrts.cell.loading import cell_from_manifest


def casadi_cell(path):
    """The cell of a file."""
    made = generate_cell(path)
    return cell_from_manifest(made.record, uncompiled_functions(made.record, made.functions), path.resolve().parent)
