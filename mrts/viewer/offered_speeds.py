# SPDX-License-Identifier: MIT
"""Which speeds a player offers: around the admissible ones, slightly beyond their ends."""

from dataclasses import dataclass
from math import ceil, floor, isfinite, log10, sqrt

from mrts.scaling.range import ScalingRange

BEYOND = 1.2
"""Speeds are offered up to this factor beyond an end of the range, so that one sees what forbids them."""

FASTEST_INFEASIBLE, FASTEST_UNBOUNDED = 2.0, 3.0
"""Largest offered c where no end gives one."""

SLOWEST = 0.02
"""Least offered c, as a share of the largest, where the cell may stand still."""

STEPS = 400
"""Least number of speeds on offer."""


@dataclass(frozen=True)
class Speeds:
    """The speeds that are offered.

    Attributes:
        ends: c² of "c⁻" and "c⁺", as far as they are finite and > 0.
        lower: Least c on offer.
        upper: Largest.
        step: Between neighbours, a power of ten; `lower` and `upper` are multiples of it.
        start: First choice.
    """

    ends: dict[str, float]
    lower: float
    upper: float
    step: float
    start: float

    @property
    def digits(self) -> int:
        """Decimal places that tell neighbours apart."""
        return max(0, -round(log10(self.step)))

    def c2(self, c: float) -> float:
        """The c² that a c on offer stands for: the exact end where the end lies within half a step."""
        near = [c2 for c2 in self.ends.values() if abs(sqrt(c2) - c) <= self.step / 2]
        return near[-1] if near else c * c


def offered_speeds(found: ScalingRange) -> Speeds:
    """Speeds to slightly beyond both ends of a range of c²; without an admissible one c = 1 is the first choice."""
    both = [end.c2 for end in (found.lower, found.upper) if end is not None]
    ends = {name: c2 for name, c2 in zip(("c⁻", "c⁺"), both, strict=False) if isfinite(c2) and c2 > 0}
    of_ends = [sqrt(c2) for c2 in ends.values()]
    least = both[0] if both and not found.samples.several else 0.0
    moves = found.status.admits_motion and both[1] > 0
    if moves and isfinite(both[1]):
        start = upper = sqrt(both[1])
        upper *= BEYOND
    else:
        start = max(1.0, sqrt(both[0])) if moves else 1.0
        upper = FASTEST_UNBOUNDED if moves else FASTEST_INFEASIBLE
        upper = max([upper, *(BEYOND * c for c in of_ends)])
    lower = min([start, *of_ends]) / BEYOND if least > 0 else SLOWEST * upper
    power = floor(log10((upper - lower) / STEPS))
    step = 10.0**power
    lower, upper = (round(count * step, -power) for count in (max(floor(lower / step), 1), ceil(upper / step)))
    return Speeds(ends, lower, upper, step, start)


OF_TIMINGS = Speeds(ends={"r(t)": 1.0}, lower=0.1, upper=BEYOND, step=1e-3, start=1.0)
"""Speeds of a timing that was found: shares of its own."""
