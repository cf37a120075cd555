"""Whether two cells are one, rotations to rounding."""

import numpy as np

from mrts.cell.cell_keys import manifest_of

ROUNDING = 2e-15
"""Of an entry of a rotation."""


def same_cell(one, other):
    """Whether two cells agree in all that a manifest says but where their URDFs are."""
    ours, theirs = (_numbers(cell) for cell in (one, other))
    return _alike(ours, theirs) and np.allclose(one.geometry, other.geometry, rtol=0, atol=ROUNDING)


def _alike(one, other):
    """Whether two values of JSON are equal; rotations come back from their angles to rounding."""
    if isinstance(one, dict):
        return one.keys() == other.keys() and all(_alike(value, other[key]) for key, value in one.items())
    if isinstance(one, list):
        return len(one) == len(other) and all(map(_alike, one, other))
    return abs(one - other) <= ROUNDING if isinstance(one, float) and isinstance(other, float) else one == other


def _numbers(cell):
    said = manifest_of(cell).model_dump()
    for robot in said["cell"]["robots"]:
        del robot["source"]["urdf"], robot["source"]["joint_limits"]
    return said
