# SPDX-License-Identifier: MIT
"""What the loads of a study do to c²⁺(t), for drawing."""

from dataclasses import dataclass

import numpy as np

from mrts.base.arrays import Array
from mrts.scaling.loads import LoadStudy
from mrts.scaling.range import ScalingRange


def load_end(found: ScalingRange) -> float:
    """c²⁺ of a load over the motion; minus infinity if no c² is admissible."""
    return found.upper.c2 if found.upper is not None and found.status.admits_motion else -np.inf


@dataclass(frozen=True)
class LoadEnvelope:
    """c²⁺(t) of the loads that were looked at one by one.

    Attributes:
        least: The least of all at every sample, minus infinity where one load has no c² at all, Shape (N,).
        largest: The largest, infinity where nothing limits it, Shape (N,).
        order: Indices of the loads, the one with the least c²⁺ over the motion first.
    """

    least: Array
    largest: Array
    order: tuple[int, ...]


def load_envelope(study: LoadStudy) -> LoadEnvelope | None:
    """The envelope of a study's loads; None if it looked at none one by one.

    Args:
        study: The study.
    """
    if not study.ranges:
        return None
    upper = np.array([found.samples.upper for found in study.ranges])
    order = sorted(range(len(study.ranges)), key=lambda index: load_end(study.ranges[index]))
    return LoadEnvelope(np.min(upper, axis=0), np.max(upper, axis=0), tuple(order))
