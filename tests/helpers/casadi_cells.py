"""Cells whose functions CasADi evaluates itself: generated, and not compiled, which takes seconds."""

import casadi as ca
import numpy as np
from mrts_codegen.generate import generate_cell

from mrts.cell.cell import cell_of
from mrts.cell.generation import GeneratedFunctions


class CasadiLibrary:
    """What CasADi gives at all samples; following takes a compiled library."""

    def __init__(self, records, functions):
        self.records, self.functions = records, functions

    def map(self, name, samples, given):
        record, arguments = self.records[name], []
        for short, (rows, columns) in record.inputs.items():
            value = np.asarray(given[short], dtype=float)
            value = np.broadcast_to(value, (samples, rows)) if value.shape == (rows,) else value
            stacked = value.reshape(samples, rows, columns).transpose(1, 0, 2)
            arguments.append(ca.DM(stacked.reshape(rows, samples * columns)))
        outputs = {}
        found = self.functions[name].map(samples).call(arguments)
        for (short, (rows, columns)), result in zip(record.outputs.items(), found, strict=True):
            value = result.full().reshape(rows, samples, columns).transpose(1, 0, 2)
            outputs[short] = value[:, :, 0] if columns == 1 else value
        return outputs


def casadi_cell(path):
    """The cell of a file."""
    manifest, _, functions = generate_cell(path)
    generated = GeneratedFunctions(manifest, path)
    vars(generated)["library"] = CasadiLibrary(manifest.functions, functions)
    return cell_of(generated, path.resolve().parent)
