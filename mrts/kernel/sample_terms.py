# SPDX-License-Identifier: MIT
"""What is added at every sample to a generated function and its limits, as C reads it."""

from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from mrts.base.arrays import Array
from mrts.kernel.binding import structure

FIELDS = ("torque_square", "torque_offset", "square", "offset", "margin", "torque_speed", "speed")


TERMS = structure("rows.h", "mrts_terms")


@dataclass(frozen=True, kw_only=True)
class SampleTerms:
    """Terms of N samples, m joints and r rows of limits; None is nothing.

    Attributes:
        torque_square: What c² adds to each torque, Shape (N, m) [N m].
        torque_offset: What is added to each torque, likewise.
        square: What c² adds to each row, in the unit of the row, Shape (N, r).
        offset: What is added to each row, likewise.
        margin: By how much both limits of each row move inward, likewise.
        torque_speed: What c adds to each torque, Shape (N, m) [N m]; at a known c it is in `torque_offset` instead.
        speed: What c adds to each row, Shape (N, r); likewise in `offset`.
    """

    torque_square: Array | None = None
    torque_offset: Array | None = None
    square: Array | None = None
    offset: Array | None = None
    margin: Array | None = None
    torque_speed: Array | None = None
    speed: Array | None = None

    def __post_init__(self) -> None:
        for name in FIELDS:
            if getattr(self, name) is not None:
                object.__setattr__(self, name, np.ascontiguousarray(getattr(self, name), dtype=np.float64))

    def at(self, samples: NDArray[np.intp]) -> Self:
        """The same at some samples only."""
        some = {name: getattr(self, name) for name in FIELDS}
        return type(self)(**{name: None if terms is None else terms[samples] for name, terms in some.items()})

    def structure(self) -> Any:
        """What C takes; valid while these terms live."""
        given = [getattr(self, name) for name in FIELDS]
        return TERMS(*[None if terms is None else terms.ctypes.data for terms in given])
